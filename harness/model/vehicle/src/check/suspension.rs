//! Axles, suspensions and steering.

use super::Check;
use crate::{
    Point, VehicleSpec,
    suspension::{
        AntiRoll, Beam, Damper, KnuckleDrive, Knuckles, Linkage, Part, Rod, SolidAxle, Spring, SteeredBy,
        SteeringGear, Suspension,
    },
};
use vb_files::Flaw;

/// Struts, a torsion bar included, that the tables have room for.
const MOST_STRUTS: usize = 2;

impl Check {
    /// An axle, with its solved linkage.
    pub(super) fn axle(&self, v: &VehicleSpec, i: usize) -> Result<crate::kinematics::AxleKinematics, Flaw> {
        let a = &v.axles[i];
        let at = |f: &str| format!("axles[{i}].{f}");
        self.finite(&at("position"), &a.position)?;
        self.positive(&at("unsprung_mass"), a.unsprung_mass)?;
        self.positive(&at("spin_inertia"), a.spin_inertia)?;
        self.not_negative(&at("brake_torque"), a.brake_torque)?;
        if let Some(gear) = &a.steering {
            self.gear(&at("steering"), gear)?;
            if v.steering.by == SteeredBy::Differential {
                let reason = "given, but steering.by says that the driveline steers".to_owned();
                return self.fail(&at("steering"), reason);
            }
        }
        let field = at("suspension");
        let s = &a.suspension;
        self.linkage(&format!("{field}.linkage"), s)?;
        self.steerable(&at("steering"), a.steering.is_some(), &s.linkage)?;
        self.struts(&field, s)?;
        self.stops(&field, s)?;
        self.anti_roll(&format!("{field}.anti_roll"), s)?;
        crate::kinematics::AxleKinematics::solve(a).or_else(|e| {
            let part = if matches!(e, crate::kinematics::LinkageError::SteeringLocked { .. }) {
                "steering"
            } else {
                "suspension.linkage"
            };
            self.fail(&at(part), e.to_string())
        })
    }

    /// Two points that must lie apart.
    fn apart(&self, field: &str, a: Point, b: Point) -> Result<(), Flaw> {
        self.finite(field, &a)?;
        self.finite(field, &b)?;
        if a == b {
            return self.fail(field, format!("both ends are at {a:?}; they must lie apart"));
        }
        Ok(())
    }

    fn direction(&self, field: &str, d: Point) -> Result<(), Flaw> {
        self.apart(field, d, [0.0; 3])
    }

    fn gear(&self, field: &str, gear: &SteeringGear) -> Result<(), Flaw> {
        let amount = match gear {
            SteeringGear::RackAndPinion { travel } => ("travel", *travel),
            SteeringGear::PitmanArm { pivot, arm_end, idler_pivot, idler_end, axis, angle } => {
                self.apart(&format!("{field}.arm_end"), *pivot, *arm_end)?;
                self.apart(&format!("{field}.idler_end"), *idler_pivot, *idler_end)?;
                self.apart(&format!("{field}.idler_end"), *arm_end, *idler_end)?;
                self.direction(&format!("{field}.axis"), *axis)?;
                ("angle", *angle)
            }
            SteeringGear::RotaryArm { pivot, axis, angle, response } => {
                self.finite(&format!("{field}.pivot"), pivot)?;
                self.characteristic(&format!("{field}.response"), response, [-1.0, 1.0])?;
                if let Some(w) = response.windows(2).find(|w| w[0][1] >= w[1][1]) {
                    let reason = format!("second numbers must rise, but {} follows {}", w[1][1], w[0][1]);
                    return self.fail(&format!("{field}.response"), reason);
                }
                self.direction(&format!("{field}.axis"), *axis)?;
                ("angle", *angle)
            }
        };
        if !amount.1.is_finite() || amount.1 == 0.0 {
            let reason = format!("{} must be a number other than zero", amount.1);
            return self.fail(&format!("{field}.{}", amount.0), reason);
        }
        Ok(())
    }

    /// Checks the driver's steering and that each limit belongs to a gear of the vehicle.
    pub(super) fn steering(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        self.positive("steering.rate", v.steering.rate)?;
        let rack = |gear: &SteeringGear| matches!(gear, SteeringGear::RackAndPinion { .. });
        let gears = || v.axles.iter().filter_map(|a| a.steering.as_ref());
        for (field, limit, fits, needed) in [
            ("steering.force", v.steering.force, gears().any(rack), "a rack"),
            ("steering.torque", v.steering.torque, gears().any(|g| !rack(g)), "a pitman arm or a rotary arm"),
        ] {
            let Some(limit) = limit else { continue };
            self.positive(field, limit)?;
            if !fits {
                return self.fail(field, format!("{limit} given, but no axle is steered by {needed}"));
            }
        }
        Ok(())
    }

    /// Whether a linkage has what an axle's steering moves.
    fn steerable(&self, field: &str, steered: bool, linkage: &Linkage) -> Result<(), Flaw> {
        let can = linkage.tie_rod_inner().is_some() || linkage.knuckles().is_some();
        if steered && !can {
            return self.fail(field, "the linkage has neither a tie rod nor knuckles to steer".to_owned());
        }
        Ok(())
    }

    fn linkage(&self, field: &str, s: &Suspension) -> Result<(), Flaw> {
        self.finite(&format!("{field}.spindle"), &s.linkage.spindle())?;
        let rod = |name: &str, a: Point, b: Point| self.apart(&format!("{field}.{name}"), a, b);
        match &s.linkage {
            Linkage::DoubleWishbone(l) => {
                rod("lower_arm_front", l.lower_arm_front, l.lower_arm_rear)?;
                rod("upper_arm_front", l.upper_arm_front, l.upper_ball_joint)?;
                rod("upper_arm_rear", l.upper_arm_rear, l.upper_ball_joint)?;
                rod("lower_ball_joint", l.lower_arm_front, l.lower_ball_joint)?;
                rod("tie_rod_inner", l.tie_rod_inner, l.tie_rod_outer)?;
            }
            Linkage::SingleWishbone(l) => {
                rod("arm_front", l.arm_front, l.arm_rear)?;
                rod("kingpin_lower", l.kingpin_lower, l.kingpin_upper)?;
                rod("tie_rod_inner", l.tie_rod_inner, l.tie_rod_outer)?;
            }
            Linkage::Multilink(l) => {
                for (k, link) in l.links.iter().enumerate() {
                    rod(&format!("links[{k}]"), link.chassis, link.carrier)?;
                }
                rod("tie_rod_inner", l.tie_rod_inner, l.tie_rod_outer)?;
            }
            Linkage::TorsionArm(l) => {
                rod("pivot", l.pivot, l.spindle)?;
                self.direction(&format!("{field}.axis"), l.axis)?;
                if let Some(t) = l.torsion {
                    self.positive(&format!("{field}.torsion.stiffness"), t.stiffness)?;
                    self.not_negative(&format!("{field}.torsion.damping"), t.damping)?;
                    self.finite(&format!("{field}.torsion.preload"), &[t.preload])?;
                }
            }
            Linkage::SolidAxle(l) => {
                self.rods(field, l)?;
                self.beam(field, l.spindle, l.beam, l.knuckles.as_ref())?;
            }
            Linkage::LeafAxle(l) => {
                rod("eye", l.eye, l.seat)?;
                self.beam(field, l.spindle, l.beam, l.knuckles.as_ref())?;
            }
            Linkage::PivotAxle(l) => {
                self.finite(&format!("{field}.pin_height"), &[l.pin_height])?;
                self.beam(field, l.spindle, l.beam, l.knuckles.as_ref())?;
            }
            Linkage::Rigid(_) => return Ok(()),
        }
        let field = field.replace(".linkage", ".range");
        self.finite(&field, &s.range)?;
        if !(s.range[0] < 0.0 && s.range[1] > 0.0) {
            return self.fail(&field, format!("{:?} must go from a negative to a positive travel", s.range));
        }
        Ok(())
    }

    fn rods(&self, field: &str, l: &SolidAxle) -> Result<(), Flaw> {
        let check = |name: String, r: &Rod| self.apart(&name, r.chassis, r.carrier);
        for (k, r) in l.links.iter().enumerate() {
            check(format!("{field}.links[{k}]"), r)?;
        }
        for (k, r) in l.single_links.iter().enumerate() {
            check(format!("{field}.single_links[{k}]"), r)?;
        }
        let rods = 2 * l.links.len() + l.single_links.len();
        if rods != 4 {
            let reason = format!(
                "{} at both sides and {} single_links make {rods} rods; a beam needs 4",
                l.links.len(),
                l.single_links.len()
            );
            return self.fail(&format!("{field}.links"), reason);
        }
        Ok(())
    }

    fn beam(&self, field: &str, spindle: Point, beam: Beam, knuckles: Option<&Knuckles>) -> Result<(), Flaw> {
        self.positive(&format!("{field}.spindle[1]"), spindle[1])?;
        self.positive(&format!("{field}.beam.mass"), beam.mass)?;
        self.not_negative(&format!("{field}.beam.inertia"), beam.inertia)?;
        let most = beam.mass * spindle[1] * spindle[1];
        if beam.inertia > most {
            let reason =
                format!("{} exceeds mass times the square of half the track ({most:.4})", beam.inertia);
            return self.fail(&format!("{field}.beam.inertia"), reason);
        }
        let Some(k) = knuckles else { return Ok(()) };
        let field = format!("{field}.knuckles");
        self.apart(&format!("{field}.kingpin_lower"), k.kingpin_lower, k.kingpin_upper)?;
        self.finite(&format!("{field}.tie_rod"), &k.tie_rod)?;
        match &k.by {
            KnuckleDrive::Toebar { drag_link_outer } => {
                self.apart(&format!("{field}.drag_link_inner"), k.drag_link_inner, *drag_link_outer)
            }
            KnuckleDrive::Bellcrank { pivot, axis, drag_link_outer, tie_rod_left, tie_rod_right } => {
                self.finite(&format!("{field}.by.pivot"), pivot)?;
                self.direction(&format!("{field}.by.axis"), *axis)?;
                self.apart(&format!("{field}.drag_link_inner"), k.drag_link_inner, *drag_link_outer)?;
                let right = [k.tie_rod[0], -k.tie_rod[1], k.tie_rod[2]];
                self.apart(&format!("{field}.by.tie_rod_left"), *tie_rod_left, k.tie_rod)?;
                self.apart(&format!("{field}.by.tie_rod_right"), *tie_rod_right, right)
            }
        }
    }

    fn struts(&self, field: &str, s: &Suspension) -> Result<(), Flaw> {
        let torsion = usize::from(s.linkage.torsion().is_some());
        let list = format!("{field}.struts");
        if matches!(s.linkage, Linkage::Rigid(_)) && !s.struts.is_empty() {
            return self.fail(&list, "given, but the wheels are fixed to the chassis".to_owned());
        }
        if s.struts.len() + torsion > MOST_STRUTS {
            let reason = format!("{} given; a wheel has at most {}", s.struts.len(), MOST_STRUTS - torsion);
            return self.fail(&list, reason);
        }
        let springs = torsion + s.struts.iter().filter(|x| x.spring.is_some()).count();
        if springs == 0 && !matches!(s.linkage, Linkage::Rigid(_) | Linkage::PivotAxle(_)) {
            return self.fail(&list, "none has a spring to carry the vehicle".to_owned());
        }
        for (k, strut) in s.struts.iter().enumerate() {
            let at = |f: &str| format!("{list}[{k}].{f}");
            self.apart(&at("end"), strut.chassis, strut.end)?;
            self.part(&at("part"), strut.part, &s.linkage)?;
            if let Some(spring) = &strut.spring {
                self.spring(&at("spring"), spring)?;
            }
            if let Some(damper) = &strut.damper {
                self.damper(&at("damper"), damper)?;
            }
            if let Some(stops) = &strut.stops {
                self.positive(&at("stops.shortest"), stops.shortest)?;
                if !(stops.longest.is_finite() && stops.longest > stops.shortest) {
                    let reason = format!("{} must be greater than shortest", stops.longest);
                    return self.fail(&at("stops.longest"), reason);
                }
                self.stop_law(&at("stops"), stops.stiffness, &stops.table)?;
            }
        }
        Ok(())
    }

    /// Whether the linkage has such a part.
    fn part(&self, field: &str, on: Part, linkage: &Linkage) -> Result<(), Flaw> {
        let (parts, names): (&[Part], &str) = match linkage {
            Linkage::DoubleWishbone(_) | Linkage::SingleWishbone(_) => {
                (&[Part::Upright, Part::Arm], "upright or arm")
            }
            Linkage::Multilink(_) => (&[Part::Upright], "upright"),
            Linkage::TorsionArm(_) => (&[Part::Arm], "arm"),
            Linkage::SolidAxle(_) | Linkage::LeafAxle(_) | Linkage::PivotAxle(_) => (&[Part::Beam], "beam"),
            Linkage::Rigid(_) => (&[], "nothing"),
        };
        if parts.contains(&on) {
            return Ok(());
        }
        let name = match on {
            Part::Upright => "upright",
            Part::Arm => "arm",
            Part::Beam => "beam",
        };
        self.fail(field, format!("{name} is no part of this linkage; it has {names}"))
    }

    fn spring(&self, field: &str, spring: &Spring) -> Result<(), Flaw> {
        let at = |f: &str| format!("{field}.{f}");
        match spring {
            Spring::Linear { stiffness, free_length, preload } => {
                self.positive(&at("stiffness"), *stiffness)?;
                self.positive(&at("free_length"), *free_length)?;
                self.finite(&at("preload"), &[*preload])
            }
            Spring::Progressive { stiffness, progression, free_length } => {
                self.positive(&at("stiffness"), *stiffness)?;
                self.not_negative(&at("progression"), *progression)?;
                self.positive(&at("free_length"), *free_length)
            }
            Spring::Table { free_length, points } => {
                self.positive(&at("free_length"), *free_length)?;
                self.rising(&at("points"), points, 2)
            }
        }
    }

    fn damper(&self, field: &str, damper: &Damper) -> Result<(), Flaw> {
        let values: &[(&str, f64)] = match damper {
            Damper::Linear { coefficient } => &[("coefficient", *coefficient)],
            Damper::Bilinear { compression, rebound } => {
                &[("compression", *compression), ("rebound", *rebound)]
            }
            Damper::Degressive { compression, compression_degression, rebound, rebound_degression } => &[
                ("compression", *compression),
                ("compression_degression", *compression_degression),
                ("rebound", *rebound),
                ("rebound_degression", *rebound_degression),
            ],
            Damper::Table { points } => {
                let field = format!("{field}.points");
                self.rising(&field, points, 2)?;
                if !points.contains(&[0.0, 0.0]) {
                    return self.fail(&field, "[0, 0] must be one of them".to_owned());
                }
                return match points.iter().find(|p| p[0] * p[1] < 0.0) {
                    Some(p) => self.fail(&field, format!("{p:?} would drive the motion")),
                    None => Ok(()),
                };
            }
        };
        values.iter().try_for_each(|(name, value)| self.not_negative(&format!("{field}.{name}"), *value))
    }

    /// Points of a table: enough of them, numbers, increasing abscissas.
    fn rising(&self, field: &str, points: &[[f64; 2]], least: usize) -> Result<(), Flaw> {
        if points.len() < least {
            return self.fail(field, format!("{} given, at least {least} needed", points.len()));
        }
        for p in points {
            self.finite(field, p)?;
        }
        match points.windows(2).find(|w| w[0][0] >= w[1][0]) {
            Some(w) => self
                .fail(field, format!("the first numbers must increase, but {} follows {}", w[1][0], w[0][0])),
            None => Ok(()),
        }
    }

    fn stop_law(&self, field: &str, stiffness: f64, table: &[[f64; 2]]) -> Result<(), Flaw> {
        self.not_negative(&format!("{field}.stiffness"), stiffness)?;
        if table.is_empty() {
            return self.positive(&format!("{field}.stiffness"), stiffness);
        }
        let field = format!("{field}.table");
        self.rising(&field, table, 2)?;
        match table.iter().flatten().find(|x| **x < 0.0) {
            Some(x) => self.fail(&field, format!("{x} must not be negative")),
            None => Ok(()),
        }
    }

    fn stops(&self, field: &str, s: &Suspension) -> Result<(), Flaw> {
        let Some(stops) = &s.stops else { return Ok(()) };
        let at = |f: &str| format!("{field}.stops.{f}");
        self.positive(&at("jounce"), stops.jounce)?;
        if !(stops.rebound.is_finite() && stops.rebound < 0.0) {
            return self.fail(&at("rebound"), format!("{} must be negative", stops.rebound));
        }
        for (name, stop) in [("jounce", stops.jounce), ("rebound", stops.rebound)] {
            if !(s.range[0]..=s.range[1]).contains(&stop) {
                let reason = format!("{stop} lies outside the range of travel, {:?}", s.range);
                return self.fail(&at(name), reason);
            }
        }
        self.stop_law(&format!("{field}.stops"), stops.stiffness, &stops.table)
    }

    fn anti_roll(&self, field: &str, s: &Suspension) -> Result<(), Flaw> {
        match &s.anti_roll {
            None => Ok(()),
            Some(_) if matches!(s.linkage, Linkage::Rigid(_)) => {
                self.fail(field, "given, but the wheels are fixed to the chassis".to_owned())
            }
            Some(AntiRoll::Travel { stiffness }) => self.positive(&format!("{field}.stiffness"), *stiffness),
            Some(AntiRoll::Bar { stiffness, damping, pivot, arm_end, link_end, part }) => {
                if s.linkage.beam().is_some() {
                    let reason = "a bar with drop links needs wheels that are guided independently; \
                                  give a beam type: travel";
                    return self.fail(field, reason.to_owned());
                }
                self.positive(&format!("{field}.stiffness"), *stiffness)?;
                self.not_negative(&format!("{field}.damping"), *damping)?;
                self.apart(&format!("{field}.arm_end"), *pivot, *arm_end)?;
                self.apart(&format!("{field}.link_end"), *arm_end, *link_end)?;
                self.part(&format!("{field}.part"), *part, &s.linkage)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::VehicleSpec;

    const HMMWV: &str = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");

    fn refused(changes: &[(&str, &str)], says: &str) {
        let mut text = HMMWV.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        let e = VehicleSpec::parse(&text, "car.yaml").unwrap_err().to_string();
        assert!(e.starts_with(&format!("car.yaml: {says}")), "{e}");
        assert!(!e.contains('\n'), "{e}");
    }

    #[test]
    fn a_strut_on_a_part_that_the_linkage_has_not_is_refused_with_the_parts_it_has() {
        refused(
            &[("part: upright", "part: beam")],
            "axles[0].suspension.struts[0].part: beam is no part of this linkage; it has upright or arm",
        );
    }

    #[test]
    fn a_range_that_leaves_the_design_position_out_is_refused() {
        refused(
            &[("range: [-0.16, 0.24]", "range: [0.02, 0.24]")],
            "axles[0].suspension.range: [0.02, 0.24] must go from a negative to a positive travel",
        );
    }

    #[test]
    fn stops_beyond_the_range_are_refused() {
        refused(
            &[(
                "range: [-0.16, 0.24]",
                "range: [-0.16, 0.16]\n      stops: {jounce: 0.2, rebound: -0.12, stiffness: 800000.0}",
            )],
            "axles[0].suspension.stops.jounce: 0.2 lies outside the range of travel, [-0.16, 0.16]",
        );
    }

    #[test]
    fn a_damper_that_drives_is_refused() {
        refused(
            &[(
                "damper: {type: linear, coefficient: 22460.0083}",
                "damper: {type: table, points: [[-1, 5], [0, 0], [1, 5]]}",
            )],
            "axles[0].suspension.struts[0].damper.points: [-1.0, 5.0] would drive the motion",
        );
    }

    #[test]
    fn a_limit_of_the_steering_is_positive_and_belongs_to_a_gear_of_the_vehicle() {
        refused(
            &[("  rate: 10.0 ", "  force: -15000.0\n  rate: 10.0 ")],
            "steering.force: -15000 must be a positive number",
        );
        refused(
            &[("  rate: 10.0 ", "  torque: 4000.0\n  rate: 10.0 ")],
            "steering.torque: 4000 given, but no axle is steered by a pitman arm or a rotary arm",
        );
    }

    #[test]
    fn the_response_of_a_servo_goes_through_zero_from_one_end_of_the_command_to_the_other() {
        for (response, expected) in [
            ("[[-0.5, -1.0], [1.0, 1.0]]", "goes from -0.5 to 1; must go from -1 to 1"),
            ("[[-1.0, 1.0], [1.0, -1.0]]", "second numbers must not fall, but -1 follows 1"),
            (
                "[[-1.0, -1.0], [-0.1, 0.0], [0.1, 0.0], [1.0, 1.0]]",
                "second numbers must rise, but 0 follows 0",
            ),
            ("[[-1.0, -1.0], [1.0, 0.5]]", "gives -0.25 at 0; must give 0"),
            (
                "[[-1.0, -0.5], [0.0, 0.0], [1.0, 0.5]]",
                "reaches 0.5; must reach 1 at one end and no more at the other",
            ),
        ] {
            let gear =
                format!("steering: {{type: rotary_arm, pivot: [0, 0, 0], angle: 0.5, response: {response}}}");
            refused(
                &[("steering: {type: rack_and_pinion, travel: 0.0523598776}", &gear)],
                &format!("axles[0].steering.response: {expected}"),
            );
        }
    }

    #[test]
    fn a_gear_at_an_axle_is_refused_where_the_driveline_steers() {
        refused(
            &[("  rate: 10.0 ", "  by: differential\n  rate: 10.0 ")],
            "axles[0].steering: given, but steering.by says that the driveline steers",
        );
        refused(
            &[
                ("  rate: 10.0 ", "  by: differential\n  rate: 10.0 "),
                ("    steering: {type: rack_and_pinion, travel: 0.0523598776}\n", ""),
            ],
            "steering.by: differential, but there is neither `tracks` nor `skid`, which say how the sides turn at different speeds",
        );
    }

    #[test]
    fn a_rod_without_length_is_refused() {
        refused(
            &[(
                "tie_rod_outer: [-0.1758188, 0.8211058, -0.0163322]",
                "tie_rod_outer: [-0.250317, 0.448437, 0.054229]",
            )],
            "axles[0].suspension.linkage.tie_rod_inner: both ends are at [-0.250317, 0.448437, 0.054229]",
        );
    }

    #[test]
    fn a_spring_that_pushes_the_wheel_up_is_refused() {
        refused(
            &[("- chassis: [0.10414, 0.707644, 0.323088]", "- chassis: [0.10414, 0.707644, -0.5]")],
            "axles[0].suspension.linkage: struts[0] does not shorten in compression",
        );
    }
}
