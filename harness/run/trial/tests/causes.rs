//! The causes of failures in scenes that are made for them, one for each.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::sync::atomic::AtomicBool;

use vb_score::cause::Cause;
use vb_score::{Rules, TaskRecord};
use vb_sdk::{Command, Observation};
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_trial::{Driver, DriverFault, Keep, Log, Place, Setting, Wants};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{Heightfield, Obstacle, ObstacleKind, Pose2, Task, TerrainClass, World};

/// A driver whose command follows from what it sees.
struct Hand(fn(&Observation) -> Command);

impl Driver for Hand {
    fn name(&self) -> String {
        "hand".into()
    }

    fn start(&mut self, _: &vb_sdk::Task, _: Log) -> Result<(), DriverFault> {
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        Ok((self.0)(observation))
    }
}

/// The side of the grid's squares, m.
const RESOLUTION: f64 = 0.25;
/// The number of nodes along a side of the world, which reaches 40 m to each side of its centre.
const NODES: usize = 321;

/// Ground whose height follows from x and y.
fn ground(height: impl Fn(f64, f64) -> f64) -> Heightfield {
    let at = |k: usize| (k as f64 - (NODES / 2) as f64) * RESOLUTION;
    let heights = (0..NODES * NODES).map(|k| height(at(k % NODES), at(k / NODES))).collect();
    Heightfield::new(NODES, NODES, RESOLUTION, heights)
}

/// A scene: the HMMWV at the origin, which looks east.
struct Scene {
    world: World,
    vehicle: &'static str,
    start: [f64; 2],
    hand: fn(&Observation) -> Command,
}

impl Scene {
    /// On firm ground with this friction.
    fn new(friction: f64, height: impl Fn(f64, f64) -> f64, hand: fn(&Observation) -> Command) -> Self {
        let world = World::uniform("scene", ground(height), TerrainClass::Gravel, friction);
        Self {
            world,
            vehicle: include_str!("../../../../tasks/vehicles/hmmwv.yaml"),
            start: [0.0, 0.0],
            hand,
        }
    }

    fn from(self, x: f64, y: f64) -> Self {
        Self { start: [x, y], ..self }
    }

    fn on(mut self, class: TerrainClass) -> Self {
        let ground = self.world.heightfield.clone();
        self.world = World { obstacles: self.world.obstacles, ..World::uniform("scene", ground, class, 0.0) };
        self
    }

    fn with(mut self, x: f64, y: f64, kind: ObstacleKind) -> Self {
        self.world.obstacles.push(Obstacle { x, y, yaw: 0.0, buried: 0.2, kind });
        self
    }

    fn drive(self) -> TaskRecord {
        let vehicle =
            Vehicle { spec: VehicleSpec::parse(self.vehicle, "vehicle").unwrap(), hash: String::new() };
        let set = SoilSet::load(std::path::Path::new("../../../tasks/soils/default.yaml")).unwrap();
        let soils = Soils { set, hash: String::new(), resolution: 0.1 };
        let rules = Rules::resolve("paper").unwrap();
        let setting = Setting::new(&vehicle, &soils, &rules, &Profile::oracle(), 0.001, 1.0, 0).unwrap();
        let [x, y] = self.start;
        let task = Task {
            id: "t00".into(),
            start: Pose2 { x, y, yaw: 0.0 },
            goal: [38.0, 38.0],
            path: vec![[x, y], [38.0, 38.0]],
        };
        let wants = Wants { name: "hand".into(), control_period: 0.1, needs: Vec::new(), params: Vec::new() };
        let (place, mut hand, never) = (Place::new(self.world, 1.0), Hand(self.hand), AtomicBool::new(false));
        let result = setting.drive(&place, &task, &wants, &mut hand, &mut (), Keep::default(), &never);
        result.unwrap().unwrap().record
    }
}

fn throttle(throttle: f64) -> Command {
    Command { throttle, ..Command::default() }
}

/// Holds a speed, m/s.
fn holds(o: &Observation, speed: f64, steering: f64) -> Command {
    let missing = speed - o.pose.map_or(0.0, |p| p.linear_velocity.x);
    Command {
        steering,
        throttle: (0.5 * missing).clamp(0.0, 1.0),
        brake: (-0.3 * missing).clamp(0.0, 1.0),
        ..Command::default()
    }
}

/// Holds a speed and the line y = 0 towards the east.
fn along(o: &Observation, speed: f64) -> Command {
    let (y, yaw) = o.pose.map_or((0.0, 0.0), |p| (p.position.y, p.yaw));
    holds(o, speed, (-0.3 * y - 1.5 * yaw).clamp(-1.0, 1.0))
}

/// What the scene ends with.
fn cause(scene: Scene) -> Cause {
    let record = scene.drive();
    let told = format!("{} after {:.1} s: {}", record.outcome, record.time_s, record.explanation());
    record.cause.unwrap_or_else(|| panic!("no failure: {told}"))
}

/// A vehicle without a torque converter, whose differentials hardly lock.
const RELEASED: &str = include_str!("../../../../tasks/vehicles/hmmwv-released.yaml");
const TRUCK: &str = include_str!("../../../../tasks/vehicles/man10t.yaml");

fn flat(_: f64, _: f64) -> f64 {
    0.0
}

#[test]
fn a_vehicle_without_throttle_is_not_driven() {
    // The engine without a converter doesn't creep.
    let scene = Scene { vehicle: RELEASED, ..Scene::new(0.8, flat, |_| Command::default()) };
    assert_eq!(cause(scene), Cause::NotDriven);
}

#[test]
fn a_hull_on_a_ridge_bears_the_vehicle() {
    // Between the axles, at 1.7 m before and behind.
    let ridge = |x: f64, _: f64| if x.abs() < 0.6 { 0.65 } else { 0.0 };
    assert_eq!(cause(Scene::new(0.8, ridge, |_| throttle(1.0))), Cause::HighCentred);
}

#[test]
fn a_block_as_wide_as_a_road_stands_in_the_way() {
    let block = ObstacleKind::Box { size: [2.0, 6.0, 2.0] };
    let scene = Scene::new(0.8, flat, |o| along(o, 1.0)).with(8.0, 0.0, block);
    assert_eq!(cause(scene), Cause::AgainstObstacle);
}

#[test]
fn ground_that_rises_like_a_wall_is_one() {
    let wall = |x: f64, _: f64| if x > 8.0 { 1.5 } else { 0.0 };
    assert_eq!(cause(Scene::new(0.8, wall, |o| along(o, 1.0))), Cause::AgainstWall);
}

#[test]
fn two_wheels_over_pits_are_unloaded_across_a_diagonal() {
    // Below the left front wheel and the right rear one, on a grade that the others would have to climb alone.
    let pit = |x: f64, y: f64, at: [f64; 2]| (x - at[0]).abs() < 0.6 && (y - at[1]).abs() < 0.4;
    let pits = move |x: f64, y: f64| {
        let deep = pit(x, y, [1.7, 0.9]) || pit(x, y, [-1.7, -0.9]);
        0.1 * x - if deep { 0.3 } else { 0.0 }
    };
    assert_eq!(cause(Scene::new(0.5, pits, |_| throttle(0.3))), Cause::CrossAxled);
}

#[test]
fn a_vehicle_that_is_stood_on_end_has_wheels_off_the_ground() {
    let gator = include_str!("../../../../tasks/vehicles/gator.yaml");
    let scene = Scene { vehicle: gator, ..Scene::new(3.0, |x, _| bowl(x, 5.0, 0.9), |o| along(o, 3.9)) };
    assert_eq!(cause(scene.from(-6.0, 0.0)), Cause::WheelsOffGround);
}

/// Ground that curves upwards with a radius (m) up to a part of it along x, and goes on as it rises there.
fn bowl(x: f64, radius: f64, end: f64) -> f64 {
    let u = (x / radius).clamp(0.0, end);
    let slope = end / (1.0 - end * end).sqrt();
    radius * (1.0 - (1.0 - u * u).sqrt()) + slope * (x - end * radius).max(0.0)
}

#[test]
fn on_a_slope_of_snow_the_wheels_spin_and_dig() {
    let scene = Scene::new(0.8, |x, _| 0.3 * x.max(0.0), |_| throttle(1.0)).on(TerrainClass::Snow);
    assert_eq!(cause(scene), Cause::SpinningOnSoil);
}

#[test]
fn a_slope_of_42_degrees_is_too_steep() {
    let slope = |x: f64, _: f64| 0.9 * (x - 4.0).max(0.0);
    let scene = Scene { vehicle: RELEASED, ..Scene::new(0.9, slope, |_| throttle(0.4)) };
    assert_eq!(cause(scene), Cause::TooSteep);
}

#[test]
fn a_vehicle_that_is_stood_in_a_hollow_of_ice_spins_on_firm_ground() {
    // Its slopes are too gentle to be the cause, and the friction is too little for them.
    let hollow = |x: f64, _: f64| 0.12 * (x.abs() - 1.0).max(0.0);
    assert_eq!(cause(Scene::new(0.1, hollow, |_| throttle(1.0))), Cause::SpinningOnFirm);
}

#[test]
fn a_truck_tips_over_an_edge() {
    let edge = |_: f64, y: f64| -(-y - 2.0).clamp(0.0, 5.0);
    let scene = Scene { vehicle: TRUCK, ..Scene::new(1.0, edge, |o| holds(o, 2.0, -0.05)) };
    assert_eq!(cause(scene), Cause::RolloverOverEdge);
}

#[test]
fn a_truck_tips_over_in_a_fast_turn() {
    let truck = include_str!("../../../../tasks/vehicles/man5t.yaml");
    let turn = |o: &Observation| holds(o, 14.0, if o.time > 5.5 { 1.0 } else { 0.0 });
    let scene = Scene { vehicle: truck, ..Scene::new(1.2, flat, turn) };
    assert_eq!(cause(scene.from(-38.0, -20.0)), Cause::RolloverAtSpeed);
}

#[test]
fn a_truck_that_slides_into_a_kerb_tips_over_it() {
    // Down a side slope of 29° with locked wheels.
    let kerb = ObstacleKind::Box { size: [60.0, 1.0, 1.2] };
    let locked = |_: &Observation| Command { brake: 1.0, ..throttle(0.2) };
    let scene = Scene { vehicle: TRUCK, ..Scene::new(0.3, |_, y| 0.55 * y, locked) };
    assert_eq!(cause(scene.with(0.0, -6.0, kerb)), Cause::RolloverAtObstacle);
}
