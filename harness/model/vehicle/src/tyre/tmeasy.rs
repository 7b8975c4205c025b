//! Rill's TMeasy.

use super::TyreData;
use crate::field::Check;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;

/// Rill's TMeasy with the names of its standard (Chrono's ChTMeasyTire.cpp; Rill, Road Vehicle Dynamics, 2012, ch. 3).
/// Pairs are the values at the loads `pn` and 2 `pn`, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TmeasyTyre {
    /// The unloaded radius, m.
    pub radius: f64,
    /// The width, m.
    pub width: f64,
    /// The radius of the rim, m. Deflections that reach the rim meet five times the stiffness more.
    pub rim_radius: f64,
    /// The rolling resistance as a fraction of the load.
    pub rolling_resistance: f64,
    /// The friction of the ground for which the tables hold. Slips and forces scale with the ground's own friction.
    pub mu_0: f64,
    /// The nominal load, N.
    pub pn: f64,
    /// The load beyond which the forces in the contact plane grow no further, N.
    pub pn_max: f64,
    /// The coefficient d1 of the vertical force over the deflection, N/m.
    pub vertical_stiffness: f64,
    /// The coefficient d2 of the vertical force over the squared deflection, N/m².
    #[serde(default)]
    pub vertical_stiffness_growth: f64,
    /// The vertical damping, N s/m.
    pub vertical_damping: f64,
    /// The longitudinal force over the slip at zero slip, N.
    pub dfx0: [f64; 2],
    /// The maximum longitudinal force, N.
    pub fxm: [f64; 2],
    /// The slip at which the maximum longitudinal force acts.
    pub sxm: [f64; 2],
    /// The longitudinal force of full sliding, N.
    pub fxs: [f64; 2],
    /// The longitudinal slip from which on the tyre slides fully.
    pub sxs: [f64; 2],
    /// The lateral force over the slip at zero slip, N.
    pub dfy0: [f64; 2],
    /// The maximum lateral force, N.
    pub fym: [f64; 2],
    /// The slip at which the maximum lateral force acts.
    pub sym: [f64; 2],
    /// The lateral force of full sliding, N.
    pub fys: [f64; 2],
    /// The lateral slip from which on the tyre slides fully.
    pub sys: [f64; 2],
    /// `nL0`: the pneumatic trail over the length of the contact, at zero slip.
    pub nl0: [f64; 2],
    /// The lateral slip at which the trail has vanished.
    pub sq0: [f64; 2],
    /// The lateral slip from which on the trail stays so.
    pub sqe: [f64; 2],
    /// The longitudinal and the lateral stiffness of the carcass, N/m. The relaxation lengths are `dfx0` and `dfy0`
    /// over these.
    pub carcass_stiffness: [f64; 2],
    /// The longitudinal and the lateral damping of the carcass, N s/m.
    pub carcass_damping: [f64; 2],
}

impl TyreData for TmeasyTyre {
    fn check(&self, check: &Check, at: &str) -> Result<(), Flaw> {
        check.all_positive(
            at,
            &[
                ("rim_radius", self.rim_radius),
                ("mu_0", self.mu_0),
                ("pn", self.pn),
                ("pn_max", self.pn_max),
                ("vertical_stiffness", self.vertical_stiffness),
            ],
        )?;
        if self.rim_radius >= self.radius {
            let reason = format!("{} must be less than the radius ({})", self.rim_radius, self.radius);
            return check.fail(&format!("{at}.rim_radius"), reason);
        }
        let growth = self.vertical_stiffness_growth;
        check.finite(&format!("{at}.vertical_stiffness_growth"), &[growth])?;
        let at_rim = self.vertical_stiffness + 2.0 * growth * (self.radius - self.rim_radius);
        if at_rim <= 0.0 {
            let reason = format!("{growth} makes the tyre give way ({at_rim} N/m) before it meets the rim");
            return check.fail(&format!("{at}.vertical_stiffness_growth"), reason);
        }
        check.not_negative(&format!("{at}.rolling_resistance"), self.rolling_resistance)?;
        let forces = [
            ("dfx0", self.dfx0),
            ("fxm", self.fxm),
            ("fxs", self.fxs),
            ("dfy0", self.dfy0),
            ("fym", self.fym),
            ("fys", self.fys),
        ];
        check.pairs_positive(at, &forces)?;
        for (field, [w1, w2]) in forces {
            // Beyond it the parabola through zero and both values starts downwards.
            if w2 >= 4.0 * w1 {
                let reason = format!("{w2} at twice the load must be less than four times {w1}");
                return check.fail(&format!("{at}.{field}[1]"), reason);
            }
        }
        let slips = [
            ("sxm", self.sxm),
            ("sxs", self.sxs),
            ("sym", self.sym),
            ("sys", self.sys),
            ("sq0", self.sq0),
            ("sqe", self.sqe),
        ];
        check.pairs_positive(at, &slips)?;
        check.pairs_positive(at, &[("nl0", self.nl0)])?;
        for i in 0..2 {
            for (peak, slide, s_peak, s_slide, f_peak, f_slide) in [
                ("fxm", "fxs", self.sxm[i], self.sxs[i], self.fxm[i], self.fxs[i]),
                ("fym", "fys", self.sym[i], self.sys[i], self.fym[i], self.fys[i]),
            ] {
                if f_slide > f_peak {
                    let reason = format!("{f_slide} exceeds {peak}[{i}], the greatest force ({f_peak})");
                    return check.fail(&format!("{at}.{slide}[{i}]"), reason);
                }
                if s_slide <= s_peak {
                    let field = slide.replace('f', "s");
                    let reason = format!("{s_slide} must exceed the slip of the greatest force ({s_peak})");
                    return check.fail(&format!("{at}.{field}[{i}]"), reason);
                }
            }
        }
        check.pairs_positive(at, &[("carcass_stiffness", self.carcass_stiffness)])?;
        check.damping_pair(at, "carcass_damping", self.carcass_damping)
    }

    fn double(&mut self) {
        let single = [
            &mut self.pn,
            &mut self.pn_max,
            &mut self.vertical_stiffness,
            &mut self.vertical_stiffness_growth,
            &mut self.vertical_damping,
        ];
        let pairs = [
            &mut self.dfx0,
            &mut self.fxm,
            &mut self.fxs,
            &mut self.dfy0,
            &mut self.fym,
            &mut self.fys,
            &mut self.carcass_stiffness,
            &mut self.carcass_damping,
        ];
        single.into_iter().chain(pairs.into_iter().flatten()).for_each(|value| *value *= 2.0);
    }

    fn rolling_resistance(&self) -> f64 {
        self.rolling_resistance
    }
}
