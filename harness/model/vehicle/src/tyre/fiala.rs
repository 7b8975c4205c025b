//! Fiala's tyre.

use super::TyreData;
use crate::field::Check;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;

/// Fiala's model with the names of Adams/Tire (Chrono's ChFialaTire.cpp).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FialaTyre {
    /// `UNLOADED_RADIUS`: the unloaded radius, m.
    pub radius: f64,
    /// `WIDTH`: the width, m, which is also the arm of the aligning torque.
    pub width: f64,
    /// The vertical force over the deflection: rising points \[m, N\] from \[0, 0\], continued beyond the last with its
    /// last slope.
    pub vertical_map: Vec<[f64; 2]>,
    /// `VERTICAL_DAMPING`: the vertical damping, N s/m.
    pub vertical_damping: f64,
    /// `CSLIP`: the longitudinal force over the slip at zero slip, N.
    pub c_slip: f64,
    /// `CALPHA`: the lateral force over the tangent of the slip angle at zero, N.
    pub c_alpha: f64,
    /// `UMIN`: the friction coefficient at a slip of one.
    pub mu_min: f64,
    /// `UMAX`: the friction coefficient at no slip.
    pub mu_max: f64,
    /// The friction of the ground for which the two coefficients hold. They scale with the ground's own friction.
    pub mu_0: f64,
    /// `ROLLING_RESISTANCE`: the moment over the load, m.
    pub rolling_resistance: f64,
    /// The longitudinal and the lateral stiffness of the carcass, N/m. The relaxation lengths are `c_slip` and
    /// `c_alpha` over these.
    pub carcass_stiffness: [f64; 2],
    /// The longitudinal and the lateral damping of the carcass, N s/m.
    pub carcass_damping: [f64; 2],
}

impl TyreData for FialaTyre {
    fn check(&self, check: &Check, at: &str) -> Result<(), Flaw> {
        check.all_positive(
            at,
            &[
                ("c_slip", self.c_slip),
                ("c_alpha", self.c_alpha),
                ("mu_min", self.mu_min),
                ("mu_max", self.mu_max),
                ("mu_0", self.mu_0),
            ],
        )?;
        if self.mu_min > self.mu_max {
            let reason =
                format!("{} exceeds mu_max ({}); friction falls with slip", self.mu_min, self.mu_max);
            return check.fail(&format!("{at}.mu_min"), reason);
        }
        let field = format!("{at}.vertical_map");
        if self.vertical_map.len() < 2 || self.vertical_map[0] != [0.0, 0.0] {
            let reason = format!("{:?} must have at least two points, the first [0, 0]", self.vertical_map);
            return check.fail(&field, reason);
        }
        for (i, pair) in self.vertical_map.windows(2).enumerate() {
            check.finite(&field, &pair[1])?;
            if pair[1][0] <= pair[0][0] || pair[1][1] <= pair[0][1] {
                let reason = format!("{:?} must exceed the point before it in both values", pair[1]);
                return check.fail(&format!("{field}[{}]", i + 1), reason);
            }
        }
        check.not_negative(&format!("{at}.rolling_resistance"), self.rolling_resistance)?;
        check.pairs_positive(at, &[("carcass_stiffness", self.carcass_stiffness)])?;
        check.damping_pair(at, "carcass_damping", self.carcass_damping)
    }

    fn double(&mut self) {
        self.vertical_map.iter_mut().for_each(|point| point[1] *= 2.0);
        let single = [&mut self.vertical_damping, &mut self.c_slip, &mut self.c_alpha];
        let pairs = [&mut self.carcass_stiffness, &mut self.carcass_damping];
        single.into_iter().chain(pairs.into_iter().flatten()).for_each(|value| *value *= 2.0);
    }

    fn rolling_resistance(&self) -> f64 {
        self.rolling_resistance
    }
}
