//! Axles, suspensions and steering.

use super::Check;
use crate::error::SimError;
use crate::spec::{Suspension, VehicleSpec};

impl Check<'_> {
    pub(super) fn axle(&self, v: &VehicleSpec, i: usize) -> Result<(), SimError> {
        let a = &v.axles[i];
        let at = |f: &str| format!("axles[{i}].{f}");
        self.finite(&at("position"), &a.position)?;
        self.positive(&at("unsprung_mass"), a.unsprung_mass)?;
        self.positive(&at("spin_inertia"), a.spin_inertia)?;
        self.not_negative(&at("brake_torque"), a.brake_torque)?;
        let Suspension::DoubleWishbone { spring, damper, stops, .. } = &a.suspension;
        self.positive(&at("suspension.spring.stiffness"), spring.stiffness)?;
        self.positive(&at("suspension.spring.free_length"), spring.free_length)?;
        self.not_negative(&at("suspension.damper.coefficient"), damper.coefficient)?;
        self.positive(&at("suspension.stops.jounce"), stops.jounce)?;
        self.positive(&at("suspension.stops.stiffness"), stops.stiffness)?;
        if !(stops.rebound.is_finite() && stops.rebound < 0.0) {
            return self.fail(&at("suspension.stops.rebound"), format!("{} must be negative", stops.rebound));
        }
        let rack = if a.steered { v.steering.rack_travel } else { 0.0 };
        crate::SuspensionTable::solve(&a.suspension, rack)
            .map(|_| ())
            .or_else(|reason| self.fail(&at("suspension.hardpoints"), reason))
    }
}
