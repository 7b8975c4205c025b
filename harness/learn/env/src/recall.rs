//! What a policy would have seen in a drive that was recorded.

use vb_sdk::policy::{Dtype, Observer, Row};
use vb_sdk::{Observation, Pose, Vec3};
use vb_trial::{numbered_gear, planner_gear};
use vb_world::TaskId;

use crate::{Arena, EnvError};

/// A frame of a drive, as datasets have it (docs/datasets.md).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The entries of `observation.state`: x, y, z; roll, pitch, yaw; velocity and angular velocity in body axes; steering, speed of
    /// the engine, gear.
    pub state: [f64; 15],
    /// Steering, throttle and brake that held until now.
    pub command: [f64; 3],
}

/// The numbers of a part of the observation, frame after frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Of a part of [`Dtype::F32`].
    F32(Vec<f32>),
    /// Of a part of [`Dtype::U8`].
    U8(Vec<u8>),
}

impl Frame {
    fn observation(&self) -> Observation {
        let [x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, engine_speed, gear] = self.state;
        let [last_steering, last_throttle, last_brake] = self.command;
        let pose = Pose {
            position: Vec3 { x, y, z },
            roll,
            pitch,
            yaw,
            linear_velocity: Vec3 { x: vx, y: vy, z: vz },
            angular_velocity: Vec3 { x: wx, y: wy, z: wz },
        };
        let gear = planner_gear(numbered_gear(gear));
        let pose = Some(pose);
        Observation {
            pose,
            steering,
            engine_speed,
            gear,
            last_steering,
            last_throttle,
            last_brake,
            ..Observation::default()
        }
    }
}

impl Arena {
    /// The observations of a drive of a task: for each part its numbers, frame after frame. Parts that take a sensor beside the pose
    /// are as if it had measured nothing.
    ///
    /// # Errors
    /// Returns an error if there is no such task.
    pub fn recall(&self, task: &TaskId, frames: &[Frame]) -> Result<Vec<Column>, EnvError> {
        let start = self.start(self.find(task)?)?;
        let brief = self.brief(&start, 0)?;
        let mut observer = Observer::new(&brief, self.layout()).map_err(EnvError::Observation)?;
        let parts = self.layout().parts();
        let column = |p: &vb_sdk::policy::Part| match p.dtype {
            Dtype::F32 => Column::F32(vec![0.0; p.width() * frames.len()]),
            Dtype::U8 => Column::U8(vec![0; p.width() * frames.len()]),
        };
        let mut columns: Vec<Column> = parts.iter().map(column).collect();
        for (k, frame) in frames.iter().enumerate() {
            observer.look(&frame.observation());
            for (part, column) in parts.iter().zip(&mut columns) {
                let own = k * part.width()..(k + 1) * part.width();
                let row = match column {
                    Column::F32(all) => Row::F32(&mut all[own]),
                    Column::U8(all) => Row::U8(&mut all[own]),
                };
                observer.fill(&brief, part, row);
            }
        }
        Ok(columns)
    }
}
