//! The PID planner of the released code of Verti-Bench, including its peculiarities, for comparison with results of the
//! original. The `pid` planner follows the paper.
//!
//! Every 0.1 s it re-plans from its position: A* on a map of pixels (see [`grid`]), one Bézier curve through all cells.
//! It steers by the angle between the heading and the bearing of the curve's first point that is at least 10 m away and
//! ahead, gain 1 per radian, changing by at most 0.05 every 5 ms; the original does not limit it to the lock, this
//! interface does. Until the first plan, at `first_plan`, it aims east. Throttle and brake come from a proportional
//! controller of the forward speed, gain 1. Terrain is ignored. All lengths are in pixels of the elevation map, 1 m at
//! full scale.

pub mod grid;

use grid::{Cell, Grid};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, math};

vb_sdk::export_planner! {
    planner: PidRelease,
    name: "pid-release",
    about: "PID planner of the released code: re-plans with A* and one Bezier curve",
    control_period: 0.005,
    params: {
        speed: 4.0 => "target speed, m/s",
        first_plan: 0.1 => "time of the first plan, s",
        obstacles: "" => "blocked squares of pixels as ROW:COLUMN:HALF;..., north row 0; default: from the occupancy map",
    }
}

/// Time between two plans, s.
const PLAN_PERIOD: f64 = 0.1;
/// Minimum distance of the local goal, pixels.
const LOOK_AHEAD: f64 = 10.0;
/// Maximum change of the steering command per step.
const STEERING_STEP: f64 = 0.05;
/// Dilation of obstacles, pixels.
const INFLATION: usize = 4;

#[derive(Clone, Debug)]
pub struct PidRelease {
    grid: Grid,
    goal: Cell,
    target_speed: f64,
    speed: SpeedController,
    period: f64,
    /// The smoothed path, m; empty before the first plan.
    path: Vec<[f64; 2]>,
    /// Index of the local goal.
    local_goal: usize,
    /// Time of the next plan, s.
    next_plan: f64,
    steering: f64,
}

impl Planner for PidRelease {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let frame = task.elevation()?.frame;
        if frame.rows != frame.cols {
            let (rows, cols) = (frame.rows, frame.cols);
            return Err(format!(
                "the world has {rows} x {cols} samples; this planner supports square worlds"
            )
            .into());
        }
        let mut grid = Grid::new(frame.rows as usize, frame.resolution);
        let squares = task.param("obstacles").unwrap_or_default();
        if squares.is_empty() {
            grid.block_occupied(task.occupancy()?);
        } else {
            grid.block_squares(squares)?;
        }
        let target_speed = task.param_positive("speed")?;
        let first_plan = task.param_f64("first_plan")?;
        Ok(Self {
            goal: grid.cell(task.goal.x, task.goal.y),
            grid: grid.inflated(INFLATION),
            target_speed,
            speed: SpeedController::new(1.0, 0.0),
            period: task.control_period,
            path: Vec::new(),
            local_goal: 0,
            next_plan: first_plan,
            steering: 0.0,
        })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        let pose = observation.pose()?;
        let (x, y, yaw) = (pose.position.x, pose.position.y, pose.yaw);
        // Half a step of tolerance: times are sums of steps.
        if observation.time + 0.5 * self.period > self.next_plan {
            self.next_plan += PLAN_PERIOD;
            // Without a new path, the old path remains.
            if let Some(cells) = self.grid.plan(self.grid.cell(x, y), self.goal) {
                self.path = self.grid.smooth(&cells);
                self.local_goal = 0;
            }
        }
        let bearing = match self.find_local_goal(x, y, yaw) {
            Some([gx, gy]) => math::atan2(gy - y, gx - x),
            None => 0.0,
        };
        let error = math::turn(yaw, bearing);
        self.steering += (error - self.steering).clamp(-STEERING_STEP, STEERING_STEP);
        let (throttle, brake) = self.speed.update(self.target_speed, pose.linear_velocity.x, self.period);
        let steering = self.steering.clamp(-1.0, 1.0);
        Ok(Command { steering, throttle, brake, ..Command::default() })
    }
}

impl PidRelease {
    /// The first point of the path after the last local goal that is far enough away and ahead; without such a point
    /// the path's last point; none without a path.
    fn find_local_goal(&mut self, x: f64, y: f64, yaw: f64) -> Option<[f64; 2]> {
        let far = LOOK_AHEAD * self.grid.pixel();
        let fits = |p: &[f64; 2]| {
            let (dx, dy) = (p[0] - x, p[1] - y);
            math::hypot(dx, dy) >= far
                && math::turn(yaw, math::atan2(dy, dx)).abs() <= std::f64::consts::FRAC_PI_2
        };
        if let Some(k) = self.path[self.local_goal..].iter().position(fits) {
            self.local_goal += k;
            return Some(self.path[self.local_goal]);
        }
        self.path.last().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{GridFrame, Map, Param, Point2, Pose, Vec3};

    /// A world of 129 × 129 pixels of 1 m without obstacles; from east to west.
    fn task(params: &[(&str, &str)]) -> Task {
        let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
        let frame = GridFrame { rows: 129, cols: 129, resolution: 1.0, origin_x: -64.0, origin_y: -64.0 };
        let half = GridFrame { rows: 256, cols: 256, resolution: 0.5, origin_x: -63.75, origin_y: -63.75 };
        Task {
            elevation: Some(Map { frame, data: vec![0.0; 129 * 129] }),
            occupancy: Some(Map { frame: half, data: vec![0; 256 * 256] }),
            goal: Point2 { x: -60.0, y: 0.0 },
            control_period: 0.005,
            params: [("speed", "4.0"), ("first_plan", "0.1"), ("obstacles", "")]
                .iter()
                .map(|(k, d)| Param { key: (*k).into(), value: value(k, d) })
                .collect(),
            ..Task::default()
        }
    }

    fn at(time: f64, x: f64, y: f64, yaw: f64, speed: f64) -> Observation {
        let (position, linear_velocity) = (Vec3 { x, y, z: 0.0 }, Vec3 { x: speed, ..Vec3::default() });
        let pose = Pose { position, yaw, linear_velocity, ..Pose::default() };
        Observation { time, ..Observation::of(pose) }
    }

    #[test]
    fn it_aims_east_until_the_first_plan_and_steers_by_small_steps() {
        let mut p = PidRelease::init(&task(&[])).unwrap();
        // Facing north the error to the east is −90°: full right, 0.05 a step.
        let north = std::f64::consts::FRAC_PI_2;
        for k in 0..20u32 {
            let c = p.step(&at(0.005 * f64::from(k), 0.5, 0.5, north, 0.0)).unwrap();
            assert!((c.steering + 0.05 * f64::from(k + 1)).abs() < 1e-12, "{k}: {}", c.steering);
            assert_eq!((c.throttle, c.brake), (1.0, 0.0));
        }
        // At 0.1 s the way west is planned: now the error is +90°.
        assert!((p.step(&at(0.1, 0.5, 0.5, north, 4.5)).unwrap().steering + 0.95).abs() < 1e-12);
        assert_eq!(p.step(&at(0.105, 0.5, 0.5, north, 4.5)).unwrap().brake, 0.5);
    }

    #[test]
    fn it_plans_at_its_start_if_told_to() {
        let mut p = PidRelease::init(&task(&[("first_plan", "0")])).unwrap();
        let north = std::f64::consts::FRAC_PI_2;
        assert_eq!(p.step(&at(0.0, 0.5, 0.5, north, 0.0)).unwrap().steering, 0.05, "west, where the goal is");
    }

    #[test]
    fn the_local_goal_is_ten_metres_ahead_and_the_goal_near_the_end() {
        let mut p = PidRelease::init(&task(&[])).unwrap();
        p.step(&at(0.1, 20.0, 0.5, 0.0, 0.0)).unwrap();
        // Straight west along y = 0.5 in 81 cells from x = 19.5 to -60.5, sampled at 100 points.
        let west = std::f64::consts::PI;
        let [gx, gy] = p.find_local_goal(20.0, 0.5, west).unwrap();
        assert!((gy - 0.5).abs() < 1e-9 && gx <= 10.0 && gx > 10.0 - 80.0 / 99.0, "{gx}, {gy}");
        // Nothing of the path is in front: its last point.
        let [gx, gy] = p.find_local_goal(20.0, 0.5, 0.0).unwrap();
        assert!((gx + 60.5).abs() < 1e-9 && (gy - 0.5).abs() < 1e-9, "{gx}, {gy}");
    }

    #[test]
    fn obstacles_are_taken_from_the_parameter_or_from_the_map() {
        let way = |p: &PidRelease| p.grid.plan((64, 124), p.goal).unwrap();
        let free = PidRelease::init(&task(&[])).unwrap();
        assert!(way(&free).iter().all(|c| c.0 == 64));
        let given = PidRelease::init(&task(&[("obstacles", "64:64:2;10:10:1")])).unwrap();
        // Two pixels of the square and four of inflation.
        assert!(way(&given).iter().all(|c| c.0.abs_diff(64) > 6 || c.1.abs_diff(64) > 6));
        let mut map = task(&[]);
        // The square of 0.5 m around the centre of pixel (64, 64), which is (-0.5, 0.5).
        for (row, col) in [(128, 126), (128, 127), (129, 126), (129, 127)] {
            map.occupancy.as_mut().unwrap().data[row * 256 + col] = 1;
        }
        let seen = PidRelease::init(&map).unwrap();
        assert!(way(&seen).iter().all(|c| c.0.abs_diff(64) > 4 || c.1.abs_diff(64) > 4));
        assert!(way(&seen).iter().any(|c| c.0.abs_diff(64) == 5));
    }

    #[test]
    fn a_bad_parameter_is_refused_by_name() {
        for (key, value) in
            [("speed", "0"), ("obstacles", "64:64"), ("obstacles", "a:b:c"), ("obstacles", "129:0:1")]
        {
            let message = PidRelease::init(&task(&[(key, value)])).unwrap_err().to_string();
            assert!(message.contains(key) && message.contains(value), "{message}");
        }
    }
}
