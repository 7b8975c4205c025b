//! Whether a vehicle can do what commands ask for: steer, brake and drive.

use super::Check;
use crate::GRAVITY;
use crate::kinematics::{AxleKinematics, Side};
use crate::suspension::SteeredBy;
use crate::{Axle, VehicleSpec, powertrain::Engine};
use vb_files::Flaw;
use vb_math::angle::degrees;
use vb_math::atan2;

/// The minimum force of all brakes, and of the engine in its lowest gear, as a fraction of the vehicle's weight: it holds and climbs a
/// slope of 3°.
const LEAST_FORCE: f64 = 0.05;
/// The minimum angle at full lock between wheels of two axles, degrees. With 1° between its axles the HMMWV turns on a radius of 190 m.
const LEAST_LOCK_DEG: f64 = 1.0;

/// The angle by which the left wheel of an axle turns to the left between no command and full lock, degrees.
fn lock(axle: &AxleKinematics) -> f64 {
    let heading = |command: f64| {
        let axis = axle.wheel(Side::Left, [0.0; 2], command).axis;
        degrees(atan2(-axis[0], axis[1]))
    };
    heading(-1.0) - heading(0.0)
}

impl Check {
    /// Refuses vehicles that no command steers.
    pub(super) fn can_steer(&self, v: &VehicleSpec, axles: &[AxleKinematics]) -> Result<(), Flaw> {
        // The driveline of tracks steers by `tracks.steering_torque`, that of skid steering by `skid`: both are positive.
        if v.steering.by != SteeredBy::Wheels || v.tracks.is_some() || v.skid.is_some() {
            return Ok(());
        }
        if v.axles.iter().all(|a| a.steering.is_none()) {
            let reason = "no axle has `steering`, so the vehicle can't steer (give one a steering gear, or the vehicle `skid`)";
            return self.fail("axles", reason.to_owned());
        }
        let locks = || axles.iter().map(lock);
        let apart = locks().fold(f64::NEG_INFINITY, f64::max) - locks().fold(f64::INFINITY, f64::min);
        if apart < LEAST_LOCK_DEG {
            let reason = format!(
                "at full lock the wheels of no two axles are {LEAST_LOCK_DEG}° apart (at most {apart:.2}°), so the vehicle can't turn; \
                 check the travel or angle of the steering gear and its tie rods"
            );
            return self.fail("axles", reason);
        }
        Ok(())
    }

    /// Refuses vehicles that no command stops.
    pub(super) fn can_brake(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let force: f64 = v.axles.iter().map(|a| 2.0 * a.brake_torque / v.tyre_of(a).radius()).sum();
        let least = LEAST_FORCE * v.total_mass() * GRAVITY;
        if force < least {
            let reason = format!(
                "the brakes of all wheels (brake_torque) give {force:.1} N, which can't stop a vehicle of {:.0} kg (at least {least:.1} N, \
                 {} % of its weight, are needed)",
                v.total_mass(),
                100.0 * LEAST_FORCE
            );
            return self.fail("axles", reason);
        }
        Ok(())
    }

    /// Refuses vehicles that no command moves.
    pub(super) fn can_drive(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let p = &v.powertrain;
        let (field, torque) = match &p.engine {
            Engine::Map { full_throttle, .. } => {
                ("powertrain.engine.full_throttle", full_throttle.iter().map(|t| t[1]).fold(0.0, f64::max))
            }
            Engine::Simple { torque, .. } => ("powertrain.engine.torque", *torque),
            Engine::Electric { torque, .. } => {
                ("powertrain.engine.torque", torque.iter().map(|t| t[1]).fold(0.0, f64::max))
            }
        };
        let driven: Vec<&Axle> = v.axles.iter().filter(|a| a.driven).collect();
        let at_wheels = |torque: f64| -> f64 {
            let axles = p.driveline.axles.iter().zip(&driven);
            axles.map(|(line, a)| line.fraction * torque / line.final_drive / v.tyre_of(a).radius()).sum()
        };
        let lowest = p.gearbox.ratios.first().copied().unwrap_or(1.0);
        let force = at_wheels(torque / lowest);
        let least = LEAST_FORCE * v.total_mass() * GRAVITY;
        if force < least {
            let reason = format!(
                "the most torque of the engine, {torque:.4} N m, pushes a vehicle of {:.0} kg with {force:.1} N in its lowest gear, which \
                 can't drive it (at least {least:.1} N, {} % of its weight, are needed; ratios and final_drive are output over input speed)",
                v.total_mass(),
                100.0 * LEAST_FORCE
            );
            return self.fail(field, reason);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::VehicleSpec;

    const HMMWV: &str = include_str!("../../../../../tasks/vehicles/hmmwv.yaml");

    /// The vehicle with each of these texts replaced, wherever it occurs.
    fn refused(changes: &[(&str, &str)]) -> String {
        let mut text = HMMWV.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        VehicleSpec::parse(&text, "car.yaml").unwrap_err().to_string()
    }

    #[test]
    fn a_vehicle_that_nothing_steers_is_refused() {
        let gear = HMMWV.lines().find(|l| l.trim_start().starts_with("steering: {")).unwrap();
        let e = refused(&[(gear, "")]);
        assert!(e.starts_with("car.yaml: axles: no axle has `steering`"), "{e}");
    }

    #[test]
    fn a_gear_that_hardly_turns_the_wheels_is_refused() {
        let gear = HMMWV.lines().find(|l| l.trim_start().starts_with("steering: {")).unwrap();
        let indent = &gear[..gear.len() - gear.trim_start().len()];
        let weak = format!("{indent}steering: {{type: rack_and_pinion, travel: 0.0001}}");
        let e = refused(&[(gear, &weak)]);
        assert!(
            e.starts_with("car.yaml: axles: at full lock the wheels of no two axles are 1° apart"),
            "{e}"
        );
    }

    #[test]
    fn brakes_that_stop_nothing_are_refused_with_their_force() {
        // 2.4 t weigh some 24 kN; four wheels of 0.47 m with 10 N m each make 4 · 10 / 0.467 = 85.7 N.
        let e = refused(&[("brake_torque: 4000.0", "brake_torque: 10.0")]);
        assert!(e.starts_with("car.yaml: axles: the brakes of all wheels (brake_torque) give 85."), "{e}");
        assert!(refused(&[("brake_torque: 4000.0", "brake_torque: 0.0")]).contains("give 0.0 N"));
    }

    #[test]
    fn an_engine_without_torque_is_refused() {
        let spec: VehicleSpec = VehicleSpec::parse(HMMWV, "car.yaml").unwrap();
        let crate::powertrain::Engine::Map { full_throttle, .. } = &spec.powertrain.engine else {
            panic!("the engine has a map")
        };
        let head = HMMWV.split_once("full_throttle:").unwrap().1;
        let table = head.split_once("closed_throttle:").unwrap().0;
        let zero: String =
            full_throttle.iter().map(|t| format!("\n      - [{}, 0.0]", t[0])).collect::<String>() + "\n    ";
        let e = refused(&[(table, &zero)]);
        assert!(
            e.starts_with("car.yaml: powertrain.engine.full_throttle: the most torque of the engine, 0"),
            "{e}"
        );
    }
}
