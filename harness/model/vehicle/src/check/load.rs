//! Whether the springs can carry what rests on them.

use super::Check;
use crate::GRAVITY;
use crate::kinematics::{AxleKinematics, Motion};
use crate::{VehicleSpec, suspension::Linkage};
use vb_files::Flaw;

/// Travels at which the force of an axle's springs and stops is looked at.
const TRAVELS: usize = 33;

/// The maximum force with which springs and stops push a wheel down within its range, N, and the travel of that, m.
fn strongest(axle: &crate::Axle, kinematics: &AxleKinematics) -> (f64, f64) {
    kinematics
        .sample(&axle.suspension, Motion::Parallel, TRAVELS, 1)
        .iter()
        .map(|s| (s.force, s.travel))
        .fold((f64::NEG_INFINITY, 0.0), |a, b| if b.0 > a.0 { b } else { a })
}

impl Check {
    /// Statics of the chassis on level ground: on two axles each has its share by the law of the lever; on more the
    /// shares follow from the springs, and what can be said without solving for them is that all together must do.
    pub(super) fn carries(&self, v: &VehicleSpec, axles: &[AxleKinematics]) -> Result<(), Flaw> {
        let weight = v.chassis.mass * GRAVITY;
        let places: Vec<f64> =
            v.axles.iter().map(|a| a.position[0] + a.suspension.linkage.spindle()[0]).collect();
        let sprung =
            |i: usize| !matches!(v.axles[i].suspension.linkage, Linkage::Rigid(_) | Linkage::PivotAxle(_));
        if let [front, rear] = places[..] {
            let fraction = (v.chassis.com[0] - rear) / (front - rear);
            if !(0.0..=1.0).contains(&fraction) {
                let reason = format!(
                    "its x of {} lies outside the axles, which are at {front} and {rear}: the vehicle falls over",
                    v.chassis.com[0]
                );
                return self.fail("chassis.com", reason);
            }
            for (i, part) in [(0, fraction), (1, 1.0 - fraction)] {
                if !sprung(i) {
                    continue;
                }
                let (most, travel) = strongest(&v.axles[i], &axles[i]);
                let load = 0.5 * part * weight;
                if most < load {
                    let reason = format!(
                        "carries at most {most:.1} N a wheel (at {travel:.3} m of travel), but {load:.1} N of the chassis \
                         rest on it; stiffen or lengthen its springs"
                    );
                    return self.fail(&format!("axles[{i}].suspension"), reason);
                }
            }
            return Ok(());
        }
        if (0..v.axles.len()).all(sprung) {
            let most: f64 = v.axles.iter().zip(axles).map(|(a, k)| 2.0 * strongest(a, k).0).sum();
            if most < weight {
                let reason = format!(
                    "all suspensions together carry at most {most:.1} N, but the chassis weighs {weight:.1} N; stiffen or \
                     lengthen their springs"
                );
                return self.fail("axles", reason);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::VehicleSpec;

    const HMMWV: &str = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");
    const MAN: &str = include_str!("../../../../../tasks/vehicles/man10t.yaml");

    fn refused(text: &str, changes: &[(&str, &str)]) -> String {
        let mut text = text.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        VehicleSpec::parse(&text, "car.yaml").unwrap_err().to_string()
    }

    /// 2095.592 kg, 0.056 + 1.651 of 3.302 m before the rear wheels: half of 0.517 of the weight.
    #[test]
    fn a_spring_that_cannot_carry_its_load_is_refused_with_load_and_strength() {
        let e = refused(HMMWV, &[("stiffness: 167070.939", "stiffness: 1670.70939")]);
        assert!(e.starts_with("car.yaml: axles[0].suspension: carries at most "), "{e}");
        assert!(e.contains("5313.") || e.contains("5314.") || e.contains("5312."), "{e}");
        assert!(e.contains("rest on it; stiffen") && !e.contains('\n'), "{e}");
    }

    #[test]
    fn on_more_axles_than_two_all_springs_together_must_carry_the_chassis() {
        let e =
            refused(MAN, &[("mass: 11015.0", "mass: 211015.0"), ("inertia: [5238.0", "inertia: [5238.0")]);
        assert!(e.starts_with("car.yaml: axles: all suspensions together carry at most "), "{e}");
        assert!(e.contains("2070057"), "m g: {e}");
    }

    #[test]
    fn a_centre_of_mass_outside_the_axles_is_refused() {
        let e = refused(HMMWV, &[("com: [0.056, 0.0, 0.213]", "com: [1.9, 0.0, 0.213]")]);
        assert!(e.starts_with("car.yaml: chassis.com: its x of 1.9 lies outside the axles"), "{e}");
    }

    #[test]
    fn masses_that_are_not_positive_are_refused_wherever_they_are() {
        for (from, to, says) in [
            ("mass: 2095.592", "mass: 0", "chassis.mass: 0 must be a positive number"),
            (
                "unsprung_mass: 99.49124",
                "unsprung_mass: -1",
                "axles[0].unsprung_mass: -1 must be a positive number",
            ),
            ("spin_inertia: 8.7143", "spin_inertia: 0", "axles[0].spin_inertia: 0 must be a positive number"),
        ] {
            assert_eq!(refused(HMMWV, &[(from, to)]), format!("car.yaml: {says}"));
        }
    }
}
