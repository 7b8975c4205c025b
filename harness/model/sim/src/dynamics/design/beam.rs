//! What a solid axle is.
//!
//! Masses at the hubs and in the middle that have the beam's mass and its moment of inertia stand for the beam; a rod's
//! inertia about its own line is left out.

use crate::V3;
use std::sync::Arc;
use vb_vehicle::kinematics::BeamAxle;
use vb_vehicle::suspension::{self, Linkage};

#[derive(Clone)]
pub(crate) struct Beam {
    pub(crate) kinematics: Arc<BeamAxle>,
    /// Number of the left wheel.
    pub(crate) left: usize,
    /// The axle's reference point relative to the chassis' centre of mass, body axes.
    pub(crate) mount: V3,
    /// All of the beam, kg.
    pub(crate) mass: f64,
    /// What of the mass is at each hub, kg.
    pub(crate) at_hub: f64,
    /// What of the mass is in the middle, kg.
    pub(crate) at_middle: f64,
    /// Whether it can only roll.
    pub(crate) pivots: bool,
    /// N/m over the difference of travels.
    pub(crate) anti_roll: f64,
}

impl Beam {
    pub(crate) fn new(
        kinematics: Arc<BeamAxle>,
        beam: suspension::Beam,
        left: usize,
        mount: V3,
        linkage: &Linkage,
        anti_roll: f64,
    ) -> Self {
        let half_track = linkage.spindle()[1];
        let at_hub = 0.5 * beam.inertia / (half_track * half_track);
        Self {
            kinematics,
            left,
            mount,
            mass: beam.mass,
            at_hub,
            at_middle: beam.mass - 2.0 * at_hub,
            pivots: matches!(linkage, Linkage::PivotAxle(_)),
            anti_roll,
        }
    }

    /// The beam's middle in the design position relative to the axle's reference point, m.
    pub(crate) fn middle(&self) -> V3 {
        self.kinematics.at([0.0; 2], [0.0; 2], 0.0).middle
    }
}
