//! The brush.

use super::TyreData;
use crate::field::Check;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;

/// A brush with a parabolic pressure and relaxation lengths (Pacejka, Tire and Vehicle Dynamics, 2012, ch. 3 and 7).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BrushTyre {
    /// The unloaded radius, m.
    pub radius: f64,
    /// The width, m.
    pub width: f64,
    /// The friction coefficient. The lesser of it and the ground's counts.
    pub friction: f64,
    /// The vertical stiffness, N/m.
    pub vertical_stiffness: f64,
    /// The vertical damping, N s/m.
    pub vertical_damping: f64,
    /// The longitudinal and the lateral slope of the force over the slip at zero slip, per unit load.
    pub slip_stiffness: [f64; 2],
    /// The longitudinal and the lateral relaxation length, m.
    pub relaxation_length: [f64; 2],
    /// The damping ratio of the carcass against a quarter of the vehicle's mass.
    pub damping_ratio: f64,
    /// The rolling resistance as a fraction of the load.
    pub rolling_resistance: f64,
}

impl TyreData for BrushTyre {
    fn check(&self, check: &Check, at: &str) -> Result<(), Flaw> {
        check.all_positive(
            at,
            &[("friction", self.friction), ("vertical_stiffness", self.vertical_stiffness)],
        )?;
        check.pairs_positive(
            at,
            &[("slip_stiffness", self.slip_stiffness), ("relaxation_length", self.relaxation_length)],
        )?;
        check.not_negative(&format!("{at}.damping_ratio"), self.damping_ratio)?;
        check.not_negative(&format!("{at}.rolling_resistance"), self.rolling_resistance)
    }

    fn double(&mut self) {
        self.vertical_stiffness *= 2.0;
        self.vertical_damping *= 2.0;
    }

    fn rolling_resistance(&self) -> f64 {
        self.rolling_resistance
    }

    fn coulomb_friction(&self) -> Option<f64> {
        Some(self.friction)
    }

    fn set_coulomb_friction(&mut self, friction: f64) {
        self.friction = friction;
    }
}
