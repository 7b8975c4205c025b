//! A planner that searches the whole map before the start for a path on which the vehicle can stand, climb and
//! straddle, and follows it. A stuck vehicle reverses and retries faster.
//!
//! It is not a system of the paper. It provides solvability certificates (`vb-harness suite prove`): run with several
//! variants and speeds, which choose different paths.

mod ground;
mod route;

use ground::Ground;
use vb_sdk::path::{Follower, Path};
use vb_sdk::recovery::{Recovery, Settings};
use vb_sdk::rng::Rng;
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, Vehicle, math};

vb_sdk::export_planner! {
    planner: Expert,
    name: "expert",
    about: "Plans a path over the terrain before the start, and follows it",
    control_period: 0.1,
    params: {
        speed: 3.0 => "target speed, m/s at full scale",
        lookahead: 5.0 => "look-ahead distance of the steering controller, m at full scale",
        caution: 1.0 => "weight of tilt, slope, twist and belly clearance against the path length",
        variant: 0 => "0: path of minimum cost; other values: seeds of randomly perturbed costs, for other paths",
        ki: 0.3 => "integral gain of the speed controller, 1/m",
    }
}

/// Standard deviation of the logarithm of the random cost factors of a variant.
const SPREAD: f64 = 0.5;
/// Increase of the target speed per recovery attempt, as a fraction: momentum carries the vehicle over steps on which a
/// slow vehicle hangs up.
const BOOST: f64 = 0.4;
/// Maximum factor of the target speed after recovery attempts.
const BOOST_MOST: f64 = 2.0;

struct Expert {
    follower: Follower,
    vehicle: Vehicle,
    lookahead: f64,
    target: f64,
    boost: f64,
    speed: SpeedController,
    period: f64,
    recovery: Recovery,
}

impl Planner for Expert {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let scale = task.vehicle.scale;
        let caution = task.param_positive("caution")?;
        let variant: u64 = task.param_as("variant")?;
        let mut ground = Ground::new(task, caution)?;
        if variant > 0 {
            ground.perturb(&mut Rng::new(task.seed ^ variant), SPREAD);
        }
        // Without a path, the global path is followed.
        let way = route::route(task, &ground).unwrap_or_else(|| task.path.clone());
        let lookahead = task.param_positive("lookahead")? * scale;
        Ok(Self {
            follower: Follower::new(Path::new(&way)?, 2.0 * lookahead),
            lookahead,
            target: task.param_positive("speed")? * scale.sqrt(),
            boost: 1.0,
            speed: SpeedController::new(1.0 / scale.sqrt(), task.param_f64("ki")?),
            period: task.control_period,
            recovery: Recovery::new(task, Settings::default().scaled(scale)),
            vehicle: task.vehicle.clone(),
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        let (x, y) = (pose.position.x, pose.position.y);
        self.follower.update(x, y);
        let goal = self.follower.look_ahead(self.lookahead);
        let (dx, dy) = (goal.x - x, goal.y - y);
        let bearing = math::turn(pose.yaw, math::atan2(dy, dx));
        // Pure pursuit (Coulter 1992): the arc through the point, on a bicycle.
        let distance = math::hypot(dx, dy).max(0.1 * self.lookahead);
        let angle = math::atan(2.0 * self.vehicle.wheelbase * math::sin(bearing) / distance);
        let mut steering = (angle / self.vehicle.max_steer_angle).clamp(-1.0, 1.0);
        if bearing.abs() > 1.57 {
            steering = bearing.signum();
        }
        // Slower in bends.
        let target = self.boost * self.target * (1.0 - 0.4 * steering.abs());
        let (throttle, brake) = self.speed.update(target, pose.linear_velocity.x, self.period);
        let command = Command { steering, throttle, brake, ..Command::default() };
        let attempts = self.recovery.attempts();
        let command = self.recovery.update(o, command);
        if self.recovery.attempts() > attempts {
            self.boost = (self.boost + BOOST).min(BOOST_MOST);
        }
        Ok(command)
    }
}
