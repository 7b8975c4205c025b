//! Pure pursuit with the estimated pose that stops before obstacles: a planner that requests every sensor.
//!
//! It is an example of reading sensors, and records as debug series: the nearest return of the lidar, the known fraction of
//! the local map, the number of inertial measurements since the last step, and the distance between GNSS position and
//! estimate.

use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{
    Command, LidarInfo, LocalMap, Observation, Planner, PlannerError, Pose, Series, Task, Vehicle, math,
};

vb_sdk::export_planner! {
    planner: Watch,
    name: "watch",
    about: "Pure pursuit that stops before obstacles, and records every sensor",
    control_period: 0.1,
    params: { speed: 3.0 => "target speed, m/s at full scale", ahead: 6.0 => "distance of the point ahead, m at full scale" },
    needs: { pose, wheel_odometry, imu: 100, gnss: 5, lidar: 10, depth: 5, local_map: 5 }
}

/// The planner.
pub struct Watch {
    vehicle: Vehicle,
    follower: Follower,
    lidar: LidarInfo,
    speed: f64,
    ahead: f64,
    /// Whether the last local map contains an obstacle ahead.
    blocked: bool,
}

impl Planner for Watch {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let scale = task.vehicle.scale;
        let ahead = task.param_positive("ahead")? * scale;
        Ok(Self {
            vehicle: task.vehicle.clone(),
            follower: Follower::new(Path::new(&task.path)?, 2.0 * ahead),
            lidar: task.lidar.ok_or("there is no lidar")?,
            speed: task.param_positive("speed")? * scale.sqrt(),
            ahead,
            blocked: false,
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        let (x, y) = (pose.position.x, pose.position.y);
        self.follower.update(x, y);
        let goal = self.follower.look_ahead(self.ahead);
        let (dx, dy) = (goal.x - x, goal.y - y);
        let bearing = math::turn(pose.yaw, math::atan2(dy, dx));
        let curvature = 2.0 * math::sin(bearing) / math::hypot(dx, dy).max(0.1 * self.ahead);
        let steering = math::atan(self.vehicle.wheelbase * curvature) / self.vehicle.max_steer_angle;
        let mut debug = vec![series("imu_samples", o.imu.len() as f64)];
        if let Some(fix) = &o.gnss {
            debug.push(series("gnss_off_m", math::hypot(fix.position.x - x, fix.position.y - y)));
        }
        if let Some(scan) = &o.lidar {
            let distances = self.lidar.points(scan).map(|(_, _, p)| math::hypot(p.x, p.y));
            debug.push(series("lidar_nearest_m", distances.fold(f64::INFINITY, f64::min).min(1e3)));
        }
        if let Some(image) = &o.depth {
            debug.push(series("depth_pixels", image.depths.iter().filter(|d| **d > 0.0).count() as f64));
        }
        if let Some(map) = &o.local_map {
            self.blocked = self.is_blocked(map, pose);
            let known = map.elevation.data.iter().filter(|z| !z.is_nan()).count();
            debug.push(series("map_known", known as f64 / map.elevation.data.len().max(1) as f64));
        }
        let target = if self.blocked { 0.0 } else { self.speed };
        let (throttle, brake) = SpeedController::new(1.0, 0.0).update(target, pose.linear_velocity.x, 0.1);
        Ok(Command { steering: steering.clamp(-1.0, 1.0), throttle, brake, debug, ..Command::default() })
    }
}

impl Watch {
    /// Whether an obstacle is within the vehicle's width on the next metres straight ahead.
    fn is_blocked(&self, map: &LocalMap, pose: &Pose) -> bool {
        let (sin, cos) = math::sin_cos(pose.yaw);
        let half = [0.5 * self.vehicle.length, 0.5 * self.vehicle.width];
        let step = map.occupancy.frame.resolution.max(1e-3);
        let rows = (0.5 * self.ahead / step).min(1000.0) as u32;
        let cols = (half[1] / step).min(1000.0) as i32;
        (0..=rows).flat_map(|i| (-cols..=cols).map(move |j| (i, j))).any(|(i, j)| {
            let (forward, left) = (half[0] + f64::from(i) * step, f64::from(j) * step);
            let (x, y) =
                (pose.position.x + cos * forward - sin * left, pose.position.y + sin * forward + cos * left);
            map.occupancy.frame.covers(x, y) && map.occupancy.nearest(x, y) == 1
        })
    }
}

fn series(name: &str, value: f64) -> Series {
    Series { name: name.into(), values: vec![value as f32] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{GridFrame, LabelMap, Param, Point2, Vec3};

    fn task() -> Task {
        let param = |key: &str, value: &str| Param { key: key.into(), value: value.into() };
        Task {
            path: (0..50).map(|i| Point2 { x: f64::from(i), y: 0.0 }).collect(),
            vehicle: Vehicle {
                scale: 1.0,
                length: 4.0,
                width: 2.0,
                wheelbase: 3.0,
                max_steer_angle: 0.5,
                ..Vehicle::default()
            },
            lidar: Some(LidarInfo::default()),
            params: vec![param("speed", "3"), param("ahead", "6")],
            ..Task::default()
        }
    }

    #[test]
    fn it_waits_before_an_obstacle_in_its_way_and_not_before_one_beside_it() {
        let frame = GridFrame { rows: 81, cols: 81, resolution: 0.25, origin_x: -10.0, origin_y: -10.0 };
        let seen = |at: Vec3| {
            let mut data = vec![0; 81 * 81];
            let cell = |v: f64| ((v + 10.0) / 0.25) as usize;
            data[cell(at.y) * 81 + cell(at.x)] = 1;
            let local_map = LocalMap { occupancy: LabelMap { frame, data }, ..LocalMap::default() };
            Observation { local_map: Some(local_map), ..Observation::of(Pose::default()) }
        };
        for (y, brakes) in [(0.0, true), (0.9, true), (2.0, false)] {
            let o = seen(Vec3 { x: 4.0, y, z: 0.0 });
            let command = Watch::init(&task()).unwrap().step(&o).unwrap();
            assert_eq!(command.throttle == 0.0, brakes, "{y}");
        }
    }

    #[test]
    fn without_a_lidar_it_gives_up() {
        let Err(error) = Watch::init(&Task { lidar: None, ..task() }) else { panic!() };
        assert_eq!(error.to_string(), "there is no lidar");
    }
}
