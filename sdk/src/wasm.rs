//! Planners as WASM: exports a planner as the component `vertibench:planner/guest`.

use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Once;

use crate::{
    Command, GridFrame, LogLevel, Map, Observation, Param, Planner, Point2, Pose2, Task, Vec3, Vehicle, Wheel,
};
use bindings::exports::vertibench::planner::guest;
use bindings::vertibench::planner::{host, types};

#[allow(missing_docs, unreachable_pub, clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod bindings {
    //! Generated from `wit/v0_1/planner.wit`.
    wit_bindgen::generate!({
        world: "planner-plugin",
        path: "wit/v0_1",
        pub_export_macro: true,
        export_macro_name: "export",
    });
}
pub use bindings::export;

pub(crate) fn log(level: LogLevel, message: &str) {
    let level = match level {
        LogLevel::Error => types::LogLevel::Error,
        LogLevel::Warn => types::LogLevel::Warn,
        LogLevel::Info => types::LogLevel::Info,
        LogLevel::Debug => types::LogLevel::Debug,
    };
    host::log(level, message);
}

/// A panic leaves a WASM guest as a bare trap; its text reaches the harness as a log line beforehand.
fn install_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|info| log(LogLevel::Error, &info.to_string()))));
}

/// The exported interface of a planner `P`.
#[derive(Debug)]
pub struct Guest<P>(PhantomData<P>);

/// The exported resource of a planner `P`.
#[derive(Debug)]
pub struct Resource<P>(RefCell<P>);

impl<P: Planner> guest::Guest for Guest<P> {
    type Planner = Resource<P>;
}

impl<P: Planner> guest::GuestPlanner for Resource<P> {
    fn init(task: types::Task) -> Result<guest::Planner, String> {
        install_panic_hook();
        let planner = P::init(&task.into()).map_err(|e| e.to_string())?;
        Ok(guest::Planner::new(Self(RefCell::new(planner))))
    }

    fn step(&self, observation: types::Observation) -> Result<types::Command, String> {
        self.0.borrow_mut().step(&observation.into()).map(Into::into).map_err(|e| e.to_string())
    }
}

impl From<types::GridFrame> for GridFrame {
    fn from(f: types::GridFrame) -> Self {
        Self {
            rows: f.rows,
            cols: f.cols,
            resolution: f.resolution,
            origin_x: f.origin_x,
            origin_y: f.origin_y,
        }
    }
}

impl From<types::Vehicle> for Vehicle {
    fn from(v: types::Vehicle) -> Self {
        Self {
            name: v.name,
            scale: v.scale,
            mass: v.mass,
            length: v.length,
            width: v.width,
            height: v.height,
            wheelbase: v.wheelbase,
            track: v.track,
            wheel_radius: v.wheel_radius,
            wheels: v.wheels,
            ground_clearance: v.ground_clearance,
            max_steer_angle: v.max_steer_angle,
            max_steer_rate: v.max_steer_rate,
            min_turn_radius: v.min_turn_radius,
            max_speed: v.max_speed,
        }
    }
}

impl From<types::Task> for Task {
    fn from(t: types::Task) -> Self {
        Self {
            id: t.id,
            vehicle: t.vehicle.into(),
            elevation: Map { frame: t.elevation.frame.into(), data: t.elevation.heights },
            semantics: Map { frame: t.semantics.frame.into(), data: t.semantics.labels },
            occupancy: Map { frame: t.occupancy.frame.into(), data: t.occupancy.occupied },
            path: t.path.into_iter().map(|p| Point2 { x: p.x, y: p.y }).collect(),
            start: Pose2 { x: t.start.x, y: t.start.y, yaw: t.start.yaw },
            goal: Point2 { x: t.goal.x, y: t.goal.y },
            goal_radius: t.goal_radius,
            time_limit: t.time_limit,
            control_period: t.control_period,
            seed: t.seed,
            params: t.params.into_iter().map(|p| Param { key: p.key, value: p.value }).collect(),
        }
    }
}

impl From<types::Vec3> for Vec3 {
    fn from(v: types::Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<types::Observation> for Observation {
    fn from(o: types::Observation) -> Self {
        Self {
            time: o.time,
            position: o.position.into(),
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: o.linear_velocity.into(),
            angular_velocity: o.angular_velocity.into(),
            wheels: o
                .wheels
                .into_iter()
                .map(|w| Wheel { speed: w.speed, deflection: w.deflection })
                .collect(),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        }
    }
}

impl From<Command> for types::Command {
    fn from(c: Command) -> Self {
        Self {
            steering: c.steering,
            throttle: c.throttle,
            brake: c.brake,
            debug: c.debug.into_iter().map(|s| types::Series { name: s.name, values: s.values }).collect(),
        }
    }
}
