//! Pure pursuit: drive the circle that goes through a point ahead on the path.

use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, Vehicle, math};

vb_sdk::export_planner! {
    planner: Pursuit,
    name: "pursuit",
    about: "Drives the circle through a point ahead on the global path",
    control_period: 0.1,
    params: { speed: 4.0 => "target speed, m/s", ahead: 6.0 => "distance of the point ahead, m at full scale" }
}

struct Pursuit {
    vehicle: Vehicle,
    follower: Follower,
    speed: f64,
    ahead: f64,
}

impl Planner for Pursuit {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let ahead = task.param_f64("ahead")? * task.vehicle.scale;
        let follower = Follower::new(Path::new(&task.path)?, 2.0 * ahead);
        Ok(Self { vehicle: task.vehicle.clone(), follower, speed: task.param_f64("speed")?, ahead })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        // Rejects implausible numbers. Comparisons with NaN are false, so NaN is rejected, too.
        let seen = [pose.position.x, pose.position.y, pose.yaw, pose.linear_velocity.x];
        if !seen.iter().all(|value| value.abs() < 1e9) {
            return Err(PlannerError::new(format!("invalid position, heading or speed: {seen:?}")));
        }
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(self.ahead);
        let (dx, dy) = (goal.x - pose.position.x, goal.y - pose.position.y);
        let angle = math::turn(pose.yaw, math::atan2(dy, dx));
        let curvature = 2.0 * math::sin(angle) / math::hypot(dx, dy).max(0.1);
        let steering = math::atan(self.vehicle.wheelbase * curvature) / self.vehicle.max_steer_angle;
        let (throttle, brake) =
            SpeedController::new(1.0, 0.0).update(self.speed, pose.linear_velocity.x, 0.1);
        Ok(Command { steering: steering.clamp(-1.0, 1.0), throttle, brake, ..Command::default() })
    }
}
