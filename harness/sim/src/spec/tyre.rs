//! Tyres as data.

use serde::{Deserialize, Serialize};

/// A tyre; see [`crate::Envelope`] for its contact and [`crate::Brush`] for its forces in the contact plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TyreSpec {
    /// Unloaded radius, m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Friction coefficient, combined with the ground's by the minimum.
    pub friction: f64,
    /// N/m.
    pub vertical_stiffness: f64,
    /// N s/m.
    pub vertical_damping: f64,
    /// Slope of force over slip at zero slip, per unit load: longitudinal, lateral.
    pub slip_stiffness: [f64; 2],
    /// Longitudinal, lateral, m.
    pub relaxation_length: [f64; 2],
    /// Damping ratio of the carcass against a quarter of the vehicle's mass.
    pub damping_ratio: f64,
    /// Rolling resistance as a fraction of load.
    pub rolling_resistance: f64,
}
