//! A drive at random, and what a planner would have seen of it.

use std::sync::Arc;

use vb_env::{Arena, Env, EnvError, Reset};
use vb_math::rng::Stream;
use vb_score::Cause;
use vb_sdk::speed::SpeedKeeper;
use vb_sdk::{Observation, Pose, Task, Vec3, Wheel};
use vb_sim::VehicleState;
use vb_world::TaskId;

/// The greatest speed of an action, m/s at full scale.
pub(crate) const FASTEST: f64 = 8.0;
/// Speeds that are driven, m/s at full scale, for so many seconds each; and the most steering, for a second each.
const SPEEDS: [f64; 4] = [3.0, 4.0, 5.0, 6.0];
const SPEED_TIME: usize = 3;
const STEERING: f64 = 0.6;

pub(crate) struct Drive {
    pub(crate) task: Task,
    /// At each control period, the last one included.
    pub(crate) seen: Vec<Observation>,
    /// What the integral of the speed controller was then.
    pub(crate) integrals: Vec<f64>,
    /// Steering and speed (m/s) from then on.
    pub(crate) commands: Vec<[f64; 2]>,
    /// The control period, s, and how many of them make a second at full scale.
    pub(crate) period: f64,
    pub(crate) second: usize,
    pub(crate) met_obstacle: bool,
}

impl Drive {
    /// Drives from the start of a task until its rules end it.
    pub(crate) fn new(arena: &Arc<Arena>, name: &TaskId) -> Result<Self, EnvError> {
        let mut env = Env::new(Arc::clone(arena), 0);
        env.reset(&Reset { task: Some(name.clone()), run_seed: Some(0), seed: None })?;
        let task = Task::clone(env.brief().ok_or(EnvError::NoEpisode)?);
        let (period, root) = (arena.control_period(), task.vehicle.scale.sqrt());
        let second = ((root / period).round() as usize).max(1);
        let mut random = Stream::new(0, &["twin check", name.as_str()]);
        let mut keeper = SpeedKeeper::new(task.vehicle.scale);
        let start = observed(&env.vehicle().ok_or(EnvError::NoEpisode)?);
        let (mut seen, mut integrals, mut commands) = (vec![start], vec![0.0], Vec::new());
        let (mut steering, mut speed) = (0.0, 0.0);
        loop {
            let k = commands.len();
            if k.is_multiple_of(second) {
                steering = STEERING * (2.0 * random.unit() - 1.0);
            }
            if k.is_multiple_of(SPEED_TIME * second) {
                speed = SPEEDS[random.below(SPEEDS.len() as u64) as usize];
            }
            let now = seen[k].pose.map_or(0.0, |p| p.linear_velocity.x);
            keeper.aim(speed * root);
            keeper.update(now, period);
            integrals.push(keeper.integral());
            commands.push([steering, speed * root]);
            let step = env.step(&[steering, 2.0 * speed / FASTEST - 1.0])?;
            seen.push(observed(&env.vehicle().ok_or(EnvError::NoEpisode)?));
            if step.terminated || step.truncated {
                break;
            }
        }
        let cause = env.record().and_then(|record| record.cause);
        let met_obstacle = matches!(cause, Some(Cause::AgainstObstacle | Cause::RolloverAtObstacle));
        Ok(Self { task, seen, integrals, commands, period, second, met_obstacle })
    }
}

/// What a planner sees of a state under the profile `oracle`.
fn observed(s: &VehicleState) -> Observation {
    let (roll, pitch, yaw) = s.roll_pitch_yaw();
    let vector = |v: [f64; 3]| Vec3::from(v);
    let pose = Pose {
        position: vector(s.position.into()),
        roll,
        pitch,
        yaw,
        linear_velocity: vector(s.velocity_body.into()),
        angular_velocity: vector(s.angular_velocity_body.into()),
    };
    Observation {
        time: s.time,
        wheels: s.wheels.iter().map(|w| Wheel { spin: w.speed, travel: w.deflection }).collect(),
        steering: s.steering,
        engine_speed: s.engine_speed,
        ..Observation::of(pose)
    }
}
