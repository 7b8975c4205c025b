//! Objectives of a search.

use clap::ValueEnum;
use serde::Serialize;
use vb_env::{Env, EnvError};
use vb_score::Outcome;
use vb_sdk::{HeightMap, Task};
use vb_sim::VehicleState;
use vb_vehicle::GRAVITY;

use crate::way::Way;

/// Speed above which a vehicle counts as one that moves or falls, m/s at full scale.
const SLOW: f64 = 0.5;
/// The radius of the circle about the start within which a vehicle counts as one that has not left, m at full scale.
const AT_START: f64 = 5.0;

/// Objective of a search: the goal, or a gain through an error of simulator or rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Aim {
    /// The goal, in the shortest time
    Goal,
    /// Mechanical energy that neither engine nor steering supplied, J
    Energy,
    /// Load of a wheel over that of a vehicle at rest on level ground
    Load,
    /// Height of the reference point above the highest ground within a wheelbase, less that at the start, of a vehicle at rest, m
    Height,
    /// Tilt of the body at the moment of success, degrees
    Tumble,
    /// Time until the rules end a trial that stays within 5 m of its start, s
    Idle,
}

impl Aim {
    /// Gain in the objective that offsets one earlier attempt from the same state.
    fn per_try(self) -> f64 {
        match self {
            // A metre of the way.
            Self::Goal | Self::Tumble => 1.0,
            Self::Energy => 200.0,
            Self::Load => 0.1,
            Self::Height => 0.02,
            Self::Idle => 0.5,
        }
    }

    /// Cost of a second, in earlier attempts; 0 except for the goal.
    pub(crate) fn second(self) -> f64 {
        if self == Self::Goal { 2.0 } else { 0.0 }
    }

    /// Value of a state, in earlier attempts from it.
    pub(crate) fn promise(self, value: f64) -> f64 {
        value / self.per_try()
    }
}

/// A task with what its states are measured by.
pub(crate) struct Measure {
    aim: Aim,
    way: Way,
    heights: HeightMap,
    start: VehicleState,
    /// Height above the surrounding ground at the start, m.
    clear: f64,
    /// The load of a wheel at rest on level ground, N.
    load: f64,
    wheelbase: f64,
    scale: f64,
}

impl Measure {
    /// Of an environment that was just reset to a task.
    ///
    /// # Errors
    /// Returns an error without an episode, and if the maps of heights and obstacles aren't known.
    pub(crate) fn new(env: &Env, aim: Aim) -> Result<Self, EnvError> {
        let missing = || EnvError::Observation("maps of heights and obstacles are needed".into());
        let task: &Task = env.brief().ok_or(EnvError::NoEpisode)?;
        let start = env.vehicle().ok_or(EnvError::NoEpisode)?;
        let vehicle = &task.vehicle;
        let mut measure = Self {
            aim,
            way: Way::new(task).ok_or_else(missing)?,
            heights: task.elevation.clone().ok_or_else(missing)?,
            clear: 0.0,
            load: vehicle.mass * GRAVITY / f64::from(vehicle.wheels.max(1)),
            wheelbase: vehicle.wheelbase,
            scale: vehicle.scale,
            start,
        };
        measure.clear = measure.above_ground(&measure.start);
        Ok(measure)
    }

    pub(crate) fn way(&self) -> &Way {
        &self.way
    }

    /// The value of the state that an environment is in, and of the end of its episode if it has ended; greater is better.
    pub(crate) fn value(&self, env: &Env, ended: Option<Outcome>) -> f64 {
        let Some(state) = env.vehicle() else { return f64::NEG_INFINITY };
        match self.aim {
            Aim::Goal => -self.left(&state),
            Aim::Energy => env.diagnostics().map_or(0.0, |d| d.energy_surplus),
            Aim::Load => state.wheels.iter().map(|w| w.load / self.load).fold(0.0, f64::max),
            Aim::Height if self.moves(&state) => 0.0,
            Aim::Height => self.above_ground(&state) - self.clear,
            Aim::Tumble if ended == Some(Outcome::Success) => tilt(&state).to_degrees(),
            Aim::Tumble => -self.left(&state),
            Aim::Idle if self.has_left(&state) => 0.0,
            Aim::Idle => state.time - self.start.time,
        }
    }

    /// The cost of the way that is left, m.
    pub(crate) fn left(&self, state: &VehicleState) -> f64 {
        self.way.left(state.position.x, state.position.y)
    }

    fn moves(&self, state: &VehicleState) -> bool {
        state.velocity_body.norm() > SLOW * self.scale.sqrt()
    }

    fn has_left(&self, state: &VehicleState) -> bool {
        (state.position - self.start.position).xy().norm() > AT_START * self.scale
    }

    /// Height of the reference point above the highest sample of the ground within a wheelbase, m.
    fn above_ground(&self, state: &VehicleState) -> f64 {
        let (frame, reach) = (self.heights.frame, self.wheelbase);
        let p = state.position;
        let (row, col) = frame.fractional(p.x, p.y);
        let samples = (reach / frame.resolution).ceil() as i64;
        let around = |at: f64, n: u32| {
            let at = at.round() as i64;
            (at - samples).max(0)..=(at + samples).min(i64::from(n) - 1)
        };
        let rows = around(row, frame.rows);
        let heights = rows.flat_map(|r| around(col, frame.cols).map(move |c| (r as u32, c as u32)));
        let highest =
            heights.map(|(r, c)| f64::from(self.heights.at(r, c))).fold(f64::NEG_INFINITY, f64::max);
        p.z - highest
    }
}

/// The angle between the vertical axes of body and world, rad.
fn tilt(state: &VehicleState) -> f64 {
    let (roll, pitch, _) = state.roll_pitch_yaw();
    vb_math::acos((vb_math::cos(roll) * vb_math::cos(pitch)).clamp(-1.0, 1.0))
}
