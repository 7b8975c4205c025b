//! Random extreme commands, for soak tests of the simulator (`cargo xtask soak`), and as a baseline for planners.
//!
//! A drive is a chain of phases of a fifth of a second to four seconds. Each phase misuses the vehicle in one way:
//! full throttle ahead, full throttle at full lock, full brakes at speed, slalom from lock to lock, all pedals at once, or
//! new commands at every step. In every other phase it steers along the global path, so that it reaches more of the world
//! than the surroundings of its start.

use vb_sdk::path::{Follower, Path};
use vb_sdk::rng::Rng;
use vb_sdk::{Command, Observation, Planner, PlannerError, Pose, Task, math};

vb_sdk::export_planner! {
    planner: Wild,
    name: "wild",
    about: "Random extreme commands, to test the simulator",
    control_period: 0.02,
    params: {
        brakes: true => "whether it brakes; without brakes it is faster",
    }
}

/// The kind of misuse in a phase.
#[derive(Clone, Debug, PartialEq)]
enum Phase {
    /// Along the path, with this throttle.
    Follow { throttle: f64 },
    /// Constant commands.
    Hold(Command),
    /// Full throttle from lock to lock.
    Slalom { period: f64 },
    /// New random commands at every step.
    Noise,
}

/// The planner.
#[derive(Clone, Debug)]
pub struct Wild {
    rng: Rng,
    follower: Follower,
    lookahead: f64,
    brakes: bool,
    phase: Phase,
    /// When the phase ends, s since the start.
    until: f64,
    /// Number of phases so far.
    count: u32,
}

impl Wild {
    fn next_phase(&mut self) -> Phase {
        self.count += 1;
        let r = &mut self.rng;
        if self.count % 2 == 1 {
            return Phase::Follow { throttle: if r.unit() < 0.7 { 1.0 } else { r.unit() } };
        }
        let side = if r.unit() < 0.5 { -1.0 } else { 1.0 };
        let hold = |steering, throttle, brake| {
            Phase::Hold(Command { steering, throttle, brake, ..Command::default() })
        };
        match r.below(7) {
            0 => hold(0.0, 1.0, 0.0),
            1 => hold(side, 1.0, 0.0),
            2 => hold(side * r.unit(), 0.0, 1.0),
            3 => hold(side, 1.0, 1.0),
            4 => hold(r.uniform(-1.0, 1.0), r.unit(), 0.0),
            5 => Phase::Slalom { period: r.uniform(0.05, 2.0) },
            _ => Phase::Noise,
        }
    }

    fn along_the_path(&mut self, pose: &Pose) -> f64 {
        let (x, y) = (pose.position.x, pose.position.y);
        self.follower.update(x, y);
        let goal = self.follower.look_ahead(self.lookahead);
        2.0 * math::turn(pose.yaw, math::atan2(goal.y - y, goal.x - x))
    }
}

impl Planner for Wild {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let lookahead = 8.0 * task.vehicle.scale;
        Ok(Self {
            rng: Rng::new(task.seed),
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            brakes: task.param_as("brakes")?,
            phase: Phase::Noise,
            until: 0.0,
            count: 0,
        })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        if observation.time >= self.until {
            self.phase = self.next_phase();
            self.until = observation.time + self.rng.uniform(0.2, 4.0);
        }
        let mut command = match self.phase.clone() {
            Phase::Follow { throttle } => {
                let steering = self.along_the_path(observation.pose()?).clamp(-1.0, 1.0);
                Command { steering, throttle, ..Command::default() }
            }
            Phase::Hold(command) => command,
            Phase::Slalom { period } => {
                let turned = ((observation.time / period) as u64).is_multiple_of(2);
                let steering = if turned { 1.0 } else { -1.0 };
                Command { steering, throttle: 1.0, ..Command::default() }
            }
            Phase::Noise => {
                let r = &mut self.rng;
                let steering = r.uniform(-1.0, 1.0);
                Command { steering, throttle: r.unit(), brake: r.unit(), ..Command::default() }
            }
        };
        if !self.brakes {
            command.brake = 0.0;
        }
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{Param, Point2, Vehicle};

    #[test]
    fn commands_stay_within_bounds_and_differ_from_task_to_task() {
        let drive = |seed| {
            let task = Task {
                path: (0..=100).map(|i| Point2 { x: f64::from(i), y: 0.0 }).collect(),
                vehicle: Vehicle { scale: 1.0, ..Vehicle::default() },
                seed,
                params: vec![Param { key: "brakes".into(), value: "true".into() }],
                ..Task::default()
            };
            let mut wild = Wild::init(&task).unwrap();
            (0..3000)
                .map(|k| Observation { time: f64::from(k) * 0.02, ..Observation::of(Pose::default()) })
                .map(|o| wild.step(&o).unwrap())
                .collect::<Vec<_>>()
        };
        let commands = drive(1);
        for c in &commands {
            assert!(c.steering.abs() <= 1.0 && (0.0..=1.0).contains(&c.throttle), "{c:?}");
            assert!((0.0..=1.0).contains(&c.brake), "{c:?}");
        }
        assert_eq!(commands, drive(1));
        assert_ne!(commands, drive(2));
    }
}
