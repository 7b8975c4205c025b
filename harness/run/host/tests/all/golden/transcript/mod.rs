//! What a planner was told and what it answered, as a file: the memory of a golden plugin.
//!
//! Numbers that go in have few decimal digits, which every reader of JSON takes as the same bits. Those that come out
//! are written as their bits.

use serde::{Deserialize, Serialize};
use vb_host::{LogSink, Plugin};
use vb_sdk::{Command, GridFrame, Map, Observation, Point2, Pose, Pose2, Task, Vec3, Vehicle, Wheel};

/// A task in short, and every step of it.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transcript {
    /// The planner interface that the plugin was built for.
    pub abi: String,
    /// File of the plugin.
    pub plugin: String,
    /// How far answers may be off: by nothing, but where a planner takes its mathematical functions from the machine.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tolerance: f64,
    /// Distance between the axles, m.
    pub wheelbase: f64,
    /// Road-wheel angle at full lock, rad.
    pub max_steer_angle: f64,
    /// Parameters that the user set.
    pub params: Vec<(String, String)>,
    /// The global path, m.
    pub path: Vec<[f64; 2]>,
    pub steps: Vec<Step>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Time; position x, y, z; roll, pitch, yaw; velocity x, y, z; angular velocity x, y, z; last steering, throttle,
    /// brake; then spin and travel of each wheel.
    pub sees: Vec<f64>,
    /// The bits of steering, throttle and brake, hexadecimal.
    pub answers: [String; 3],
}

impl Transcript {
    /// The task as the planner is told of it. What the transcript doesn't hold is made up, and the same every time.
    pub fn task(&self, plugin: &Plugin) -> Task {
        let frame = GridFrame { rows: 5, cols: 7, resolution: 0.5, origin_x: -1.5, origin_y: -1.0 };
        let point = |p: &[f64; 2]| Point2 { x: p[0], y: p[1] };
        Task {
            id: "golden/t00".into(),
            vehicle: Vehicle {
                name: "golden".into(),
                scale: 1.0,
                mass: 2500.0,
                wheelbase: self.wheelbase,
                track: 1.75,
                wheels: 4,
                max_steer_angle: self.max_steer_angle,
                max_steer_rate: 0.5,
                max_speed: 30.0,
                ..Vehicle::default()
            },
            elevation: Some(Map { frame, data: (0..35u8).map(|i| f32::from(i) * 0.125).collect() }),
            semantics: Some(Map { frame, data: (0..35).map(|i| i % 10).collect() }),
            occupancy: Some(Map { frame, data: (0..35).map(|i| i % 2).collect() }),
            path: self.path.iter().map(point).collect(),
            start: Pose2 { x: 0.0, y: 0.0, yaw: 0.25 },
            goal: self.path.last().map(point).unwrap(),
            goal_radius: 8.0,
            time_limit: 60.0,
            control_period: plugin.metadata().control_period,
            seed: 7,
            params: plugin.params(&self.params).unwrap(),
            ..Task::default()
        }
    }

    /// What the plugin answers today: the bits of every command.
    pub fn replay(&self, plugin: &Plugin) -> Vec<[String; 3]> {
        let mut session = plugin.start(&self.task(plugin), LogSink::discard()).unwrap();
        self.steps.iter().map(|step| bits(&session.step(&observation(&step.sees)).unwrap())).collect()
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// The number of which these are the bits.
#[allow(dead_code, reason = "not used by all that share this file")]
pub fn number(bits: &str) -> f64 {
    f64::from_bits(u64::from_str_radix(bits, 16).unwrap())
}

pub fn bits(command: &Command) -> [String; 3] {
    [command.steering, command.throttle, command.brake].map(|x| format!("{:016x}", x.to_bits()))
}

/// The observation that a list of numbers stands for.
pub fn observation(sees: &[f64]) -> Observation {
    let vec3 = |i: usize| Vec3 { x: sees[i], y: sees[i + 1], z: sees[i + 2] };
    Observation {
        time: sees[0],
        pose: Some(Pose {
            position: vec3(1),
            roll: sees[4],
            pitch: sees[5],
            yaw: sees[6],
            linear_velocity: vec3(7),
            angular_velocity: vec3(10),
        }),
        last_steering: sees[13],
        last_throttle: sees[14],
        last_brake: sees[15],
        wheels: sees[16..].chunks_exact(2).map(|w| Wheel { spin: w[0], travel: w[1] }).collect(),
        ..Observation::default()
    }
}
