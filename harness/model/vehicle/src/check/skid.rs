//! Skid steering on wheels.

use super::Check;
use crate::VehicleSpec;
use crate::powertrain::{Differential, Engine};
use crate::skid::Skid;
use crate::suspension::SteeredBy;
use vb_files::Flaw;

impl Check {
    /// That what steers is there, once: steering gears, belts or motors for each side.
    pub(super) fn steered_by(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let differential = v.steering.by == SteeredBy::Differential;
        let reason = match (&v.tracks, &v.skid, differential) {
            (Some(_), Some(_), _) => {
                return self.fail("skid", "given, but the vehicle has `tracks`".to_owned());
            }
            (Some(_), None, false) => {
                "wheels, but a tracked vehicle is steered by its driveline; write `by: differential`"
            }
            (None, Some(_), false) => "wheels, but there is `skid`; write `by: differential`",
            (None, None, true) => {
                "differential, but there is neither `tracks` nor `skid`, which say how the sides turn at different speeds"
            }
            _ => return Ok(()),
        };
        self.fail("steering.by", reason.to_owned())
    }

    pub(super) fn skid(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let Some(skid) = &v.skid else { return Ok(()) };
        match *skid {
            Skid::Speed { relative, at_rest, gain } => {
                self.positive("skid.relative", relative)?;
                self.not_negative("skid.at_rest", at_rest)?;
                self.positive("skid.gain", gain)?;
            }
            Skid::Torque { torque } => self.positive("skid.torque", torque)?,
        }
        for (i, a) in v.axles.iter().enumerate() {
            let at = |f: &str| format!("axles[{i}].{f}");
            if a.steering.is_some() {
                return self
                    .fail(&at("steering"), "given, but `skid` steers by the speeds of the sides".to_owned());
            }
            if !a.driven {
                return self.fail(&at("driven"), "false, but skid steering drives all wheels".to_owned());
            }
            if v.tyre_of(a).radius() != v.tyre.radius() {
                let reason = format!("{}; all wheels of a side have one radius", v.tyre_of(a).radius());
                return self.fail(&at("tyre.radius"), reason);
            }
        }
        let p = &v.powertrain;
        if !matches!(p.engine, Engine::Electric { .. }) {
            return self.fail("powertrain.engine.type", "skid steering has `electric` motors".to_owned());
        }
        if p.converter.is_some() {
            return self.fail("powertrain.converter", "given, but motors have none".to_owned());
        }
        let [ratio] = p.gearbox.ratios[..] else {
            let reason = format!("{} given; motors of a side have one", p.gearbox.ratios.len());
            return self.fail("powertrain.gearbox.ratios", reason);
        };
        if p.gearbox.reverse != Some(-ratio) {
            let reason = format!("must be {}: motors turn backwards with the gears that they have", -ratio);
            return self.fail("powertrain.gearbox.reverse", reason);
        }
        let line = &p.driveline;
        if !matches!(line.centre, Differential::Locked {} | Differential::Open {}) {
            let reason =
                "must be `locked` (the wheels of a side turn together) or `open` (each has its motor)";
            return self.fail("powertrain.driveline.centre", reason.to_owned());
        }
        for (i, a) in line.axles.iter().enumerate() {
            let at = |f: &str| format!("powertrain.driveline.axles[{i}].{f}");
            if a.differential != (Differential::Open {}) {
                return self.fail(&at("differential"), "must be `open`: each side has its motors".to_owned());
            }
            if a.final_drive != line.axles[0].final_drive {
                let reason =
                    format!("{} must be that of axles[0], {}", a.final_drive, line.axles[0].final_drive);
                return self.fail(&at("final_drive"), reason);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::VehicleSpec;

    const HUSKY: &str = include_str!("../../../../../tasks/vehicles/husky.yaml");

    fn refused(from: &str, to: &str, says: &str) {
        assert!(HUSKY.contains(from), "{from}");
        let e = VehicleSpec::parse(&HUSKY.replacen(from, to, 1), "robot.yaml").unwrap_err().to_string();
        assert!(e.starts_with(&format!("robot.yaml: {says}")), "{e}");
    }

    #[test]
    fn what_no_skid_steered_vehicle_can_be_is_refused_with_field_and_reason() {
        let gain = HUSKY.lines().find(|l| l.trim_start().starts_with("gain:")).unwrap();
        refused(gain, "  gain: 0.0", "skid.gain: 0 must be a positive number");
        refused("  by: differential", "  by: wheels", "steering.by: wheels, but there is `skid`");
        refused(
            "driven: true",
            "driven: false",
            "axles[0].driven: false, but skid steering drives all wheels",
        );
        refused(
            "centre: {type: locked}",
            "centre: {type: limited_slip, bias: 2.0}",
            "powertrain.driveline.centre: must be",
        );
        refused(
            "differential: {type: open}",
            "differential: {type: locked}",
            "powertrain.driveline.axles[0].differential:",
        );
        let reverse = HUSKY.lines().find(|l| l.trim_start().starts_with("reverse:")).unwrap();
        refused(reverse, "    reverse: -0.5", "powertrain.gearbox.reverse: must be -");
        let whole = HUSKY.split_once("\nskid:\n").unwrap();
        let rest = whole.1.split_once("\n\n").unwrap().1;
        let e = VehicleSpec::parse(&format!("{}\n{rest}", whole.0), "robot.yaml").unwrap_err().to_string();
        assert!(e.contains("steering.by: differential, but there is neither `tracks` nor `skid`"), "{e}");
    }
}
