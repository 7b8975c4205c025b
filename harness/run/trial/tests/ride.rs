//! Shock and ride of drives whose motion is known.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::sync::atomic::AtomicBool;

use vb_score::{Flag, Outcome, Rules, TaskRecord};
use vb_sdk::{Command, Observation};
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_trial::{Driver, DriverFault, Keep, Log, Place, Setting, Wants};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{Heightfield, Pose2, Task, TerrainClass, World};

/// A driver who does the same all the time.
struct Hand(Command);

impl Driver for Hand {
    fn name(&self) -> String {
        "hand".into()
    }

    fn start(&mut self, _: &vb_sdk::Task, _: Log) -> Result<(), DriverFault> {
        Ok(())
    }

    fn step(&mut self, _: &Observation) -> Result<Command, DriverFault> {
        Ok(self.0.clone())
    }
}

/// Drives the Gator on flat gravel by these rules, with this step (s), towards a goal so far ahead (m).
fn drive(rules: &str, step: f64, goal: f64, command: Command) -> TaskRecord {
    let spec = VehicleSpec::parse(include_str!("../../../../tasks/vehicles/gator.yaml"), "vehicle").unwrap();
    let vehicle = Vehicle { spec, hash: String::new() };
    let set = SoilSet::load(std::path::Path::new("../../../tasks/soils/default.yaml")).unwrap();
    let soils = Soils { set, hash: String::new(), resolution: 0.1 };
    let rules = Rules::parse(rules, "rules").unwrap();
    let setting = Setting::new(&vehicle, &soils, &rules, &Profile::oracle(), step, 1.0, 0).unwrap();
    let ground = Heightfield::new(81, 81, 1.0, vec![0.0; 81 * 81]);
    let world = World::uniform("scene", ground, TerrainClass::Gravel, 0.8);
    let start = Pose2 { x: -30.0, y: 0.0, yaw: 0.0 };
    let goal = [start.x + goal, 0.0];
    let task = Task { id: "t00".into(), start, goal, path: vec![[start.x, start.y], goal] };
    let wants = Wants { name: "hand".into(), control_period: 0.1, needs: Vec::new(), params: Vec::new() };
    let (place, mut hand, never) = (Place::new(world, 1.0), Hand(command), AtomicBool::new(false));
    let result = setting.drive(&place, &task, &wants, &mut hand, &mut (), Keep::default(), &never);
    result.unwrap().unwrap().record
}

/// Rules with this start and time limit (s).
fn rules(start: &str, limit: f64) -> String {
    format!(
        "schema: 1\nname: x\nstart: {start}\nsuccess: {{planar: {{radius_m: 10.0}}}}\ntime_limit_s: {limit:?}\n"
    )
}

#[test]
fn a_vehicle_at_rest_has_no_shock_and_stands_on_its_wheels() {
    let record = drive(&rules("settled", 2.0), 1e-3, 60.0, Command { brake: 1.0, ..Command::default() });
    let ride = record.ride.unwrap();
    assert_eq!(record.outcome, Outcome::Timeout);
    // It comes to rest from a hundredth of a metre per second.
    assert!(ride.seat_peak_g < 0.05 && ride.seat_rms_m_per_s2 < 0.1, "{ride:?}");
    assert!(ride.absorbed_power_w < 0.01, "{ride:?}");
    assert_eq!((ride.airborne_fraction, ride.landed), (0.0, true));
    assert!(Flag::ALL.iter().all(|flag| !record.flags[flag]), "{:?}", record.flags);
}

#[test]
fn a_fall_is_airborne_until_it_lands_and_its_peak_hardly_depends_on_the_step() {
    // The reference point falls from 2 m to where the wheels touch, 0.3 m (their radius) above the ground: 0.59 s.
    let fall = (2.0f64 * (2.0 - 0.3) / 9.81).sqrt();
    let drop = |step| {
        let record = drive(&rules("{dropped: {height_m: 2.0}}", 3.0), step, 60.0, Command::default());
        (record.ride.unwrap(), record.flags)
    };
    let (ride, flags) = drop(1e-3);
    // Front and rear wheels touch at different times, and it may bounce.
    assert!(
        ride.airborne_fraction * 3.0 > fall - 0.05 && ride.airborne_fraction * 3.0 < fall + 0.3,
        "{ride:?}"
    );
    assert!(ride.seat_peak_z_g > 2.5 && flags[&Flag::Shock] && !flags[&Flag::Strict], "{ride:?}");
    assert!(ride.seat_peak_g >= ride.seat_peak_z_g && ride.seat_rms_m_per_s2 >= ride.seat_rms_z_m_per_s2);
    let (fine, _) = drop(5e-4);
    assert!((fine.seat_peak_z_g / ride.seat_peak_z_g - 1.0).abs() < 0.1, "{fine:?} {ride:?}");
    assert!((fine.seat_rms_z_m_per_s2 / ride.seat_rms_z_m_per_s2 - 1.0).abs() < 0.1, "{fine:?} {ride:?}");
}

#[test]
fn a_drive_over_flat_ground_to_the_goal_is_a_strict_success() {
    let throttle = Command { throttle: 0.5, ..Command::default() };
    let record = drive(&rules("settled", 30.0), 1e-3, 30.0, throttle);
    assert_eq!(record.outcome, Outcome::Success);
    assert!(record.ride.unwrap().landed && record.flags[&Flag::Strict], "{:?}", record.ride);
    // At a goal that is reached at the first sample nothing is known.
    let record = drive(&rules("{dropped: {height_m: 2.0}}", 30.0), 1e-3, 9.0, Command::default());
    assert_eq!(
        (record.outcome, record.ride, record.flags.get(&Flag::Strict)),
        (Outcome::Success, None, None)
    );
}
