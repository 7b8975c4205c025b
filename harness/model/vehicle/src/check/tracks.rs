//! Belts.

use super::Check;
use crate::{TyreSpec, VehicleSpec, suspension::Linkage, tracks::Tracks};
use vb_files::Flaw;

impl Check {
    pub(super) fn tracks(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let Some(t) = &v.tracks else { return Ok(()) };
        self.positive("tracks.thickness", t.thickness)?;
        self.positive("tracks.mass", t.mass)?;
        self.positive("tracks.tension", t.tension)?;
        self.positive("tracks.stiffness", t.stiffness)?;
        self.not_negative("tracks.damping", t.damping)?;
        self.not_negative("tracks.resistance[0]", t.resistance[0])?;
        self.not_negative("tracks.resistance[1]", t.resistance[1])?;
        self.positive("tracks.steering_torque", t.steering_torque)?;
        if v.axles.len() < 4 {
            let reason =
                format!("{} given; a track needs sprocket, idler and two road wheels", v.axles.len());
            return self.fail("axles", reason);
        }
        let last = v.axles.len() - 1;
        if v.axles[0].driven == v.axles[last].driven {
            let reason = "either the first or the last axle of a tracked vehicle is its sprocket, and driven";
            return self.fail("axles", reason.to_owned());
        }
        for i in 0..v.axles.len() {
            self.track_wheel(v, t, i)?;
        }
        Ok(())
    }

    fn track_wheel(&self, v: &VehicleSpec, t: &Tracks, i: usize) -> Result<(), Flaw> {
        let a = &v.axles[i];
        let at = |f: &str| format!("axles[{i}].{f}");
        let last = v.axles.len() - 1;
        let ends = i == 0 || i == last;
        let linkage = &a.suspension.linkage;
        if ends && !matches!(linkage, Linkage::Rigid(_)) {
            let reason = "a sprocket and an idler are fixed to the chassis; write `type: rigid`".to_owned();
            return self.fail(&at("suspension.linkage"), reason);
        }
        if linkage.beam().is_some() {
            let reason = "a beam guides no road wheels; use arms".to_owned();
            return self.fail(&at("suspension.linkage"), reason);
        }
        if !ends && (a.driven || a.brake_torque > 0.0) {
            let field = if a.driven { "driven" } else { "brake_torque" };
            return self.fail(&at(field), "only the sprocket of a track drives and brakes".to_owned());
        }
        if v.axles[0].suspension.linkage.spindle()[1] != linkage.spindle()[1] {
            let reason = format!(
                "wheel centre {} m from the middle; all of a track lie {} m from it, as those of axles[0]",
                linkage.spindle()[1],
                v.axles[0].suspension.linkage.spindle()[1]
            );
            return self.fail(&at("suspension.linkage.spindle"), reason);
        }
        let tyre = v.tyre_of(a);
        let field = if a.tyre.is_some() { at("tyre") } else { "tyre".to_owned() };
        if !matches!(tyre, TyreSpec::Rigid(_)) {
            let reason = format!("{}; the wheels of a track have `model: rigid`", tyre.model());
            return self.fail(&format!("{field}.model"), reason);
        }
        if tyre.radius() <= t.thickness {
            let reason = format!("{} must exceed the belt's thickness, {}", tyre.radius(), t.thickness);
            return self.fail(&format!("{field}.radius"), reason);
        }
        let next = &v.axles[(i + 1) % v.axles.len()];
        let place = |a: &crate::Axle| {
            let s = a.suspension.linkage.spindle();
            [a.position[0] + s[0], a.position[2] + s[2]]
        };
        let ([x, z], [nx, nz]) = (place(a), place(next));
        let (apart, need) =
            (vb_math::hypot(x - nx, z - nz), (tyre.radius() - v.tyre_of(next).radius()).abs());
        if apart <= need {
            let reason = format!("{apart:.3} m from the next wheel of the belt, within the other's radius");
            return self.fail(&at("position"), reason);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M113: &str = include_str!("../../../../../tasks/vehicles/m113.yaml");

    fn refused(from: &str, to: &str, says: &str) {
        assert!(M113.contains(from), "{from}");
        let e = VehicleSpec::parse(&M113.replacen(from, to, 1), "tank.yaml").unwrap_err().to_string();
        assert_eq!(e, format!("tank.yaml: {says}"));
    }

    #[test]
    fn what_no_belt_can_be_is_refused_with_field_value_and_reason() {
        refused("tension: 11100.0", "tension: 0", "tracks.tension: 0 must be a positive number");
        refused(
            "  by: differential\n",
            "",
            "steering.by: wheels, but a tracked vehicle is steered by its driveline; write `by: differential`",
        );
        refused(
            "thickness: 0.06",
            "thickness: 0.5",
            "axles[0].tyre.radius: 0.2792 must exceed the belt's thickness, 0.5",
        );
        refused(
            "brake_torque: 0.0",
            "brake_torque: 10.0",
            "axles[1].brake_torque: only the sprocket of a track drives and brakes",
        );
        refused("driven: true", "driven: false", "axles: none is driven");
        refused(
            "spindle: [0, 1.0795, 0]\n        pivot",
            "spindle: [0, 1.1, 0]\n        pivot",
            "axles[1].suspension.linkage.spindle: wheel centre 1.1 m from the middle; all of a track lie 1.0795 m from it, as \
             those of axles[0]",
        );
        refused(
            "position: [1.3335, 0.0, 0.0]",
            "position: [2.03, 0.0, 0.215]",
            "axles[0].position: 0.001 m from the next wheel of the belt, within the other's radius",
        );
    }
}
