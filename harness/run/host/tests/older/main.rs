//! A synthetic older version of the planner interface: its generated conversions keep the shared fields, leave out newer ones and give
//! the command's newer fields their defaults.

#[rustfmt::skip]
mod convert;

#[allow(unreachable_pub, dead_code, clippy::all)]
mod bindings {
    wasmtime::component::bindgen!({ world: "planner-plugin", path: "tests/older" });
}

use bindings::vertibench::planner::types;
use vb_sdk::{Command, Gear, Observation, Point2, Task, Vehicle};

#[test]
fn conversions_to_an_older_version_keep_what_it_knows() {
    let vehicle = Vehicle { name: "hmmwv".into(), mass: 3000.0, wheelbase: 3.3, ..Vehicle::default() };
    let path = vec![Point2 { x: 1.0, y: -2.0 }, Point2 { x: 3.0, y: 4.0 }];
    let task = Task { id: "w001/t00".into(), vehicle, path, goal_radius: 8.0, seed: 7, ..Task::default() };
    let older = types::Task::from(&task);
    assert_eq!((older.id.as_str(), older.goal_radius), ("w001/t00", 8.0));
    assert_eq!((older.vehicle.name.as_str(), older.vehicle.mass), ("hmmwv", 3000.0));
    let points: Vec<_> = older.path.iter().map(|p| [p.x, p.y]).collect();
    assert_eq!(points, [[1.0, -2.0], [3.0, 4.0]]);
    let observation =
        Observation { time: 0.5, last_steering: -0.25, gear: Gear::Reverse, ..Observation::default() };
    let older = types::Observation::from(&observation);
    assert_eq!((older.time, older.last_steering), (0.5, -0.25));
    let command = types::Command { steering: 0.1, throttle: 0.2, brake: 0.3 };
    let expected =
        Command { steering: 0.1, throttle: 0.2, brake: 0.3, gear: Gear::Forward, debug: Vec::new() };
    assert_eq!(Command::from(command), expected);
}
