//! Tyres.

use super::Check;
use crate::{
    TyreSpec, VehicleSpec,
    tyre::{BrushTyre, FialaTyre, HardContact, RigidTyre, TmeasyTyre},
};
use vb_files::Flaw;

impl Check {
    pub(super) fn tyres(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        self.tyre("tyre", &v.tyre)?;
        for (name, tyre) in &v.tyres {
            self.tyre(&format!("tyres.{name}"), tyre)?;
        }
        for (i, axle) in v.axles.iter().enumerate() {
            if let Some(tyre) = &axle.tyre {
                self.tyre(&format!("axles[{i}].tyre"), tyre)?;
            } else if let Some(name) = axle.tyres.keys().next() {
                let reason = "given, but the axle has no tyre of its own".to_owned();
                return self.fail(&format!("axles[{i}].tyres.{name}"), reason);
            }
            for (name, tyre) in &axle.tyres {
                self.tyre(&format!("axles[{i}].tyres.{name}"), tyre)?;
            }
        }
        Ok(())
    }

    fn tyre(&self, at: &str, tyre: &TyreSpec) -> Result<(), Flaw> {
        self.all_positive(at, &[("radius", tyre.radius()), ("width", tyre.width())])?;
        self.not_negative(&format!("{at}.vertical_damping"), tyre.vertical_damping())?;
        match tyre {
            TyreSpec::Rigid(t) => self.rigid(at, t),
            TyreSpec::Brush(t) => self.brush(at, t),
            TyreSpec::Fiala(t) => self.fiala(at, t),
            TyreSpec::Tmeasy(t) => self.tmeasy(at, t),
        }
    }

    fn all_positive(&self, at: &str, fields: &[(&str, f64)]) -> Result<(), Flaw> {
        fields.iter().try_for_each(|(field, value)| self.positive(&format!("{at}.{field}"), *value))
    }

    /// Both values of fields that are pairs.
    fn pairs_positive(&self, at: &str, fields: &[(&str, [f64; 2])]) -> Result<(), Flaw> {
        for (field, pair) in fields {
            for (i, value) in pair.iter().enumerate() {
                self.positive(&format!("{at}.{field}[{i}]"), *value)?;
            }
        }
        Ok(())
    }

    fn damping_pair(&self, at: &str, field: &str, pair: [f64; 2]) -> Result<(), Flaw> {
        (0..2).try_for_each(|i| self.not_negative(&format!("{at}.{field}[{i}]"), pair[i]))
    }

    fn rigid(&self, at: &str, t: &RigidTyre) -> Result<(), Flaw> {
        self.all_positive(
            at,
            &[
                ("friction", t.friction),
                ("vertical_stiffness", t.vertical_stiffness),
                ("tangential_stiffness", t.tangential_stiffness),
                ("relaxation_length", t.relaxation_length),
            ],
        )?;
        if let Some(d) = t.dilation {
            if t.contact != HardContact::Facets {
                let reason = "given, but contact is not facets: an envelope ends at the ground".to_owned();
                return self.fail(&format!("{at}.dilation"), reason);
            }
            self.all_positive(&format!("{at}.dilation"), &[("step", d.step), ("reach", d.reach)])?;
            if d.reach > t.radius {
                let reason = format!("{} is more than the tyre's radius, {}", d.reach, t.radius);
                return self.fail(&format!("{at}.dilation.reach"), reason);
            }
        }
        self.not_negative(&format!("{at}.tangential_damping"), t.tangential_damping)
    }

    fn brush(&self, at: &str, t: &BrushTyre) -> Result<(), Flaw> {
        self.all_positive(at, &[("friction", t.friction), ("vertical_stiffness", t.vertical_stiffness)])?;
        self.pairs_positive(
            at,
            &[("slip_stiffness", t.slip_stiffness), ("relaxation_length", t.relaxation_length)],
        )?;
        self.not_negative(&format!("{at}.damping_ratio"), t.damping_ratio)?;
        self.not_negative(&format!("{at}.rolling_resistance"), t.rolling_resistance)
    }

    fn fiala(&self, at: &str, t: &FialaTyre) -> Result<(), Flaw> {
        self.all_positive(
            at,
            &[
                ("c_slip", t.c_slip),
                ("c_alpha", t.c_alpha),
                ("mu_min", t.mu_min),
                ("mu_max", t.mu_max),
                ("mu_0", t.mu_0),
            ],
        )?;
        if t.mu_min > t.mu_max {
            let reason = format!("{} exceeds mu_max ({}); friction falls with slip", t.mu_min, t.mu_max);
            return self.fail(&format!("{at}.mu_min"), reason);
        }
        let field = format!("{at}.vertical_map");
        if t.vertical_map.len() < 2 || t.vertical_map[0] != [0.0, 0.0] {
            let reason = format!("{:?} must have at least two points, the first [0, 0]", t.vertical_map);
            return self.fail(&field, reason);
        }
        for (i, pair) in t.vertical_map.windows(2).enumerate() {
            self.finite(&field, &pair[1])?;
            if pair[1][0] <= pair[0][0] || pair[1][1] <= pair[0][1] {
                let reason = format!("{:?} must exceed the point before it in both values", pair[1]);
                return self.fail(&format!("{field}[{}]", i + 1), reason);
            }
        }
        self.not_negative(&format!("{at}.rolling_resistance"), t.rolling_resistance)?;
        self.pairs_positive(at, &[("carcass_stiffness", t.carcass_stiffness)])?;
        self.damping_pair(at, "carcass_damping", t.carcass_damping)
    }

    fn tmeasy(&self, at: &str, t: &TmeasyTyre) -> Result<(), Flaw> {
        self.all_positive(
            at,
            &[
                ("rim_radius", t.rim_radius),
                ("mu_0", t.mu_0),
                ("pn", t.pn),
                ("pn_max", t.pn_max),
                ("vertical_stiffness", t.vertical_stiffness),
            ],
        )?;
        if t.rim_radius >= t.radius {
            let reason = format!("{} must be less than the radius ({})", t.rim_radius, t.radius);
            return self.fail(&format!("{at}.rim_radius"), reason);
        }
        let growth = t.vertical_stiffness_growth;
        self.finite(&format!("{at}.vertical_stiffness_growth"), &[growth])?;
        let at_rim = t.vertical_stiffness + 2.0 * growth * (t.radius - t.rim_radius);
        if at_rim <= 0.0 {
            let reason = format!("{growth} makes the tyre give way ({at_rim} N/m) before it meets the rim");
            return self.fail(&format!("{at}.vertical_stiffness_growth"), reason);
        }
        self.not_negative(&format!("{at}.rolling_resistance"), t.rolling_resistance)?;
        let forces = [
            ("dfx0", t.dfx0),
            ("fxm", t.fxm),
            ("fxs", t.fxs),
            ("dfy0", t.dfy0),
            ("fym", t.fym),
            ("fys", t.fys),
        ];
        self.pairs_positive(at, &forces)?;
        for (field, [w1, w2]) in forces {
            // Beyond it the parabola through zero and both values starts downwards.
            if w2 >= 4.0 * w1 {
                let reason = format!("{w2} at twice the load must be less than four times {w1}");
                return self.fail(&format!("{at}.{field}[1]"), reason);
            }
        }
        let slips =
            [("sxm", t.sxm), ("sxs", t.sxs), ("sym", t.sym), ("sys", t.sys), ("sq0", t.sq0), ("sqe", t.sqe)];
        self.pairs_positive(at, &slips)?;
        self.pairs_positive(at, &[("nl0", t.nl0)])?;
        for i in 0..2 {
            for (peak, slide, s_peak, s_slide, f_peak, f_slide) in [
                ("fxm", "fxs", t.sxm[i], t.sxs[i], t.fxm[i], t.fxs[i]),
                ("fym", "fys", t.sym[i], t.sys[i], t.fym[i], t.fys[i]),
            ] {
                if f_slide > f_peak {
                    let reason = format!("{f_slide} exceeds {peak}[{i}], the greatest force ({f_peak})");
                    return self.fail(&format!("{at}.{slide}[{i}]"), reason);
                }
                if s_slide <= s_peak {
                    let field = slide.replace('f', "s");
                    let reason = format!("{s_slide} must exceed the slip of the greatest force ({s_peak})");
                    return self.fail(&format!("{at}.{field}[{i}]"), reason);
                }
            }
        }
        self.pairs_positive(at, &[("carcass_stiffness", t.carcass_stiffness)])?;
        self.damping_pair(at, "carcass_damping", t.carcass_damping)
    }
}
