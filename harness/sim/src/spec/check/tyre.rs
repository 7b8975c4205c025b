//! Tyres.

use super::Check;
use crate::error::SimError;
use crate::spec::VehicleSpec;

impl Check<'_> {
    pub(super) fn tyre(&self, v: &VehicleSpec) -> Result<(), SimError> {
        let t = &v.tyre;
        for (field, value) in [
            ("tyre.radius", t.radius),
            ("tyre.width", t.width),
            ("tyre.friction", t.friction),
            ("tyre.vertical_stiffness", t.vertical_stiffness),
            ("tyre.slip_stiffness[0]", t.slip_stiffness[0]),
            ("tyre.slip_stiffness[1]", t.slip_stiffness[1]),
            ("tyre.relaxation_length[0]", t.relaxation_length[0]),
            ("tyre.relaxation_length[1]", t.relaxation_length[1]),
        ] {
            self.positive(field, value)?;
        }
        self.not_negative("tyre.vertical_damping", t.vertical_damping)?;
        self.not_negative("tyre.damping_ratio", t.damping_ratio)?;
        self.not_negative("tyre.rolling_resistance", t.rolling_resistance)
    }
}
