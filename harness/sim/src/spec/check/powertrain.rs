//! Engine, gearbox and driveline.

use super::Check;
use crate::error::SimError;
use crate::spec::VehicleSpec;

impl Check<'_> {
    pub(super) fn powertrain(&self, v: &VehicleSpec) -> Result<(), SimError> {
        let p = &v.powertrain;
        for (field, map) in [
            ("powertrain.engine.full_throttle", &p.engine.full_throttle),
            ("powertrain.engine.closed_throttle", &p.engine.closed_throttle),
        ] {
            if map.is_empty() || map.iter().flatten().any(|x| !x.is_finite()) {
                return self
                    .fail(field, "needs at least one point [rad/s, N m] of finite numbers".to_owned());
            }
            if let Some(w) = map.windows(2).find(|w| w[0][0] >= w[1][0]) {
                return self
                    .fail(field, format!("speeds must increase, but {} follows {}", w[1][0], w[0][0]));
            }
        }
        let g = &p.gearbox;
        if g.ratios.is_empty() || g.ratios.len() != g.shift_up.len() || g.ratios.len() != g.shift_down.len() {
            let reason = format!(
                "{} ratios, {} shift_down, {} shift_up: there must be as many of each, and one at least",
                g.ratios.len(),
                g.shift_down.len(),
                g.shift_up.len()
            );
            return self.fail("powertrain.gearbox", reason);
        }
        for i in 0..g.ratios.len() {
            self.positive(&format!("powertrain.gearbox.ratios[{i}]"), g.ratios[i])?;
            if !(g.shift_down[i].is_finite() && g.shift_up[i] > g.shift_down[i]) {
                let reason =
                    format!("{} must be greater than shift_down[{i}] = {}", g.shift_up[i], g.shift_down[i]);
                return self.fail(&format!("powertrain.gearbox.shift_up[{i}]"), reason);
            }
        }
        self.positive("powertrain.final_drive", p.final_drive)?;
        self.not_negative("powertrain.shaft_inertia", p.shaft_inertia)?;
        self.not_negative("powertrain.differentials.front", p.differentials.front)?;
        self.not_negative("powertrain.differentials.rear", p.differentials.rear)?;
        self.not_negative("powertrain.differentials.centre", p.differentials.centre)
    }
}
