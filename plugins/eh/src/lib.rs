//! Elevation heuristics (EH) of the Verti-Bench paper: compares five regions of the elevation map ahead of the vehicle,
//! and steers towards the one with the mean height closest to that of the terrain under the vehicle and the smallest
//! standard deviation, while following the global path.
//!
//! The five regions are squares side by side ahead of the vehicle, each of the size of the patch under the vehicle. The
//! score of a region is |mean − mean of the patch| + `roughness` · standard deviation, m. The region with the minimum
//! score wins; ties go to the region nearest to straight ahead. The steering error is (1 − `terrain`) · bearing of the
//! local goal + `terrain` · bearing of the region, the input of a proportional controller. The speed controller is that
//! of PID.
//!
//! The regions of the released code lie left of the vehicle, because it crops the map before rotating it; here they lie
//! ahead. `docs/planners.md` lists the differences.

use vb_sdk::crop::Window;
use vb_sdk::path::{Follower, Path};
use vb_sdk::speed::SpeedController;
use vb_sdk::{Command, HeightMap, Observation, Planner, PlannerError, Pose2, Series, Task, math};

vb_sdk::export_planner! {
    planner: Eh,
    name: "eh",
    about: "Steers between the global path and the flattest of five regions ahead on the elevation map",
    control_period: 0.1,
    params: {
        speed: 5.0 => "target speed, m/s at full scale",
        lookahead: 10.0 => "look-ahead distance of the local goal along the global path, m at full scale",
        region: 6.4 => "side length of a region, m at full scale",
        terrain: 0.2 => "weight of the region's bearing in the steering error, 0 to 1",
        roughness: 1.0 => "weight of a region's standard deviation against its difference in mean height",
        kp: 1.0 => "proportional gain of the steering, 1/rad",
        speed_kp: 1.0 => "proportional gain of the speed controller, s/m at full scale",
        explain: 0 => "1: record the regions with their scores and the local goal in the debug file",
    },
    without_maps: { local_map }
}

/// Number of regions side by side.
const REGIONS: usize = 5;
/// Samples per side of a region.
const SAMPLES: usize = 8;
/// A region needs 1 / `KNOWN` of its samples.
const KNOWN: usize = 4;

#[derive(Clone, Debug)]
pub struct Eh {
    /// The elevation map of the world, or the last local map.
    elevation: HeightMap,
    /// Whether the local map replaces the map of the world.
    looks_around: bool,
    follower: Follower,
    lookahead: f64,
    region: f64,
    terrain: f64,
    roughness: f64,
    kp: f64,
    target_speed: f64,
    speed: SpeedController,
    period: f64,
    explain: bool,
}

/// Mean and standard deviation of the heights in a square, m.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heights {
    mean: f64,
    std: f64,
}

impl Eh {
    /// Heights of the square with the centre `forward` and `left` of the vehicle, m; none with too few known samples.
    fn square(&self, pose: Pose2, forward: f64, left: f64) -> Option<Heights> {
        let (sin, cos) = math::sin_cos(pose.yaw);
        let middle = Pose2 {
            x: pose.x + cos * forward - sin * left,
            y: pose.y + sin * forward + cos * left,
            yaw: pose.yaw,
        };
        let window =
            Window { rows: SAMPLES, cols: SAMPLES, resolution: self.region / SAMPLES as f64, ahead: 0.0 };
        let mut known = self.elevation.crop(middle, &window).height;
        known.retain(|z| !z.is_nan());
        if known.len() * KNOWN < SAMPLES * SAMPLES {
            return None;
        }
        let n = known.len() as f64;
        let mean = known.iter().map(|&z| f64::from(z)).sum::<f64>() / n;
        let square = |z: f64| z * z;
        let variance = known.iter().map(|&z| square(f64::from(z) - mean)).sum::<f64>() / n;
        Some(Heights { mean, std: variance.sqrt() })
    }

    /// Lateral offset of the centre of each region, m, positive to the left; leftmost region first.
    fn lateral(&self, region: usize) -> f64 {
        (2.0 - region as f64) * self.region
    }

    /// Scores of the regions, leftmost first; infinite for a centre outside the map or too few known samples.
    fn scores(&self, pose: Pose2) -> [f64; REGIONS] {
        if self.elevation.frame.rows < 2 || self.elevation.frame.cols < 2 {
            return [f64::INFINITY; REGIONS];
        }
        let here = self.square(pose, 0.0, 0.0);
        let (sin, cos) = math::sin_cos(pose.yaw);
        std::array::from_fn(|i| {
            let (forward, left) = (self.region, self.lateral(i));
            let (x, y) = (pose.x + cos * forward - sin * left, pose.y + sin * forward + cos * left);
            if !self.elevation.frame.contains(x, y) {
                return f64::INFINITY;
            }
            let Some(there) = self.square(pose, forward, left) else { return f64::INFINITY };
            // The terrain under the vehicle is outside the lidar's field of view.
            let step = here.map_or(0.0, |here| (there.mean - here.mean).abs());
            step + self.roughness * there.std
        })
    }
}

/// The region with the minimum score; ties go to the region nearest to straight ahead.
fn best(scores: &[f64; REGIONS]) -> usize {
    let mut order = [2, 1, 3, 0, 4];
    order.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]));
    order[0]
}

impl Planner for Eh {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let scale = task.vehicle.scale;
        let terrain = task.param_f64("terrain")?;
        if !(0.0..=1.0).contains(&terrain) {
            return Err(PlannerError::new(format!("parameter `terrain`: {terrain} is not from 0 to 1")));
        }
        let lookahead = task.param_positive("lookahead")? * scale;
        Ok(Self {
            // Without all maps of the world, the local map is more accurate than a coarse prior map.
            looks_around: task.occupancy.is_none(),
            elevation: task.elevation.clone().unwrap_or_default(),
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            region: task.param_positive("region")? * scale,
            terrain,
            roughness: task.param_f64("roughness")?,
            kp: task.param_f64("kp")?,
            // Speeds scale with the root of lengths (Froude).
            target_speed: task.param_positive("speed")? * scale.sqrt(),
            speed: SpeedController::new(task.param_f64("speed_kp")? / scale.sqrt(), 0.0),
            period: task.control_period,
            explain: task.param_as::<u32>("explain")? != 0,
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let seen = o.pose()?;
        let pose = Pose2 { x: seen.position.x, y: seen.position.y, yaw: seen.yaw };
        if let Some(map) = o.local_map.as_ref().filter(|_| self.looks_around) {
            self.elevation = map.elevation.clone();
        }
        self.follower.update(pose.x, pose.y);
        let goal = self.follower.look_ahead(self.lookahead);
        let to_goal = math::turn(seen.yaw, math::atan2(goal.y - pose.y, goal.x - pose.x));
        let scores = self.scores(pose);
        let chosen = best(&scores);
        let to_region = math::atan2(self.lateral(chosen), self.region);
        // Outside the map there is no region to choose.
        let terrain = if scores[chosen].is_finite() { self.terrain } else { 0.0 };
        let error = (1.0 - terrain) * to_goal + terrain * to_region;
        let (throttle, brake) = self.speed.update(self.target_speed, seen.linear_velocity.x, self.period);
        let debug = if self.explain {
            let series = |name: &str, values: Vec<f32>| Series { name: name.into(), values };
            vec![
                series("local_goal", vec![goal.x as f32, goal.y as f32]),
                series("region_scores", scores.iter().map(|&s| s as f32).collect()),
                series("region_chosen", vec![chosen as f32]),
            ]
        } else {
            Vec::new()
        };
        Ok(Command {
            steering: (self.kp * error).clamp(-1.0, 1.0),
            throttle,
            brake,
            debug,
            ..Command::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;
    use vb_sdk::{GridFrame, LocalMap, Map, Param, Point2, Pose, Vec3, Vehicle};

    const DEFAULTS: [(&str, &str); 8] = [
        ("speed", "5"),
        ("lookahead", "10"),
        ("region", "6.4"),
        ("terrain", "0.2"),
        ("roughness", "1"),
        ("kp", "1"),
        ("speed_kp", "1"),
        ("explain", "1"),
    ];

    /// Drives east along the x axis over the ground z(x, y) on 81 × 81 samples of 1 m about the origin.
    fn task(z: impl Fn(f64, f64) -> f64, params: &[(&str, &str)]) -> Task {
        let frame = GridFrame { rows: 81, cols: 81, resolution: 1.0, origin_x: -40.0, origin_y: -40.0 };
        let data =
            (0..81 * 81).map(|i| z(f64::from(i % 81) - 40.0, f64::from(i / 81) - 40.0) as f32).collect();
        let value = |k: &str, d: &str| params.iter().find(|p| p.0 == k).map_or(d, |p| p.1).to_owned();
        Task {
            elevation: Some(Map { frame, data }),
            path: (0..=60).map(|i| Point2 { x: f64::from(i), y: 0.0 }).collect(),
            vehicle: Vehicle { scale: 1.0, ..Vehicle::default() },
            control_period: 0.1,
            params: DEFAULTS.iter().map(|(k, d)| Param { key: (*k).into(), value: value(k, d) }).collect(),
            ..Task::default()
        }
    }

    fn command(task: &Task, x: f64, y: f64, yaw: f64) -> Command {
        let o = Observation::of(Pose { position: Vec3 { x, y, z: 0.0 }, yaw, ..Pose::default() });
        Eh::init(task).unwrap().step(&o).unwrap()
    }

    fn chosen(command: &Command) -> f32 {
        command.debug[2].values[0]
    }

    #[test]
    fn on_flat_ground_it_drives_straight_on() {
        let c = command(&task(|_, _| 2.0, &[]), 0.0, 0.0, 0.0);
        assert_eq!((c.steering, chosen(&c)), (0.0, 2.0));
        assert_eq!(c.debug[1].values, [0.0; 5]);
    }

    #[test]
    fn it_steers_to_the_only_even_region_in_front_whatever_the_heading() {
        // Bumps everywhere but to the left of the vehicle's course; behind the vehicle it is rough too.
        let bumps = |u: f64| math::sin(2.0 * u);
        let rough_but =
            |left: f64| move |x: f64, y: f64| if (y - left).abs() < 4.0 && x > 2.0 { 0.0 } else { bumps(x) };
        let c = command(&task(rough_but(6.4), &[]), 0.0, 0.0, 0.0);
        assert_eq!(chosen(&c), 1.0, "left");
        // 0.2 of the region's 45°.
        assert!((c.steering - 0.2 * 0.25 * std::f64::consts::PI).abs() < 1e-9, "{}", c.steering);
        let c = command(&task(rough_but(-12.8), &[]), 0.0, 0.0, 0.0);
        assert_eq!(chosen(&c), 4.0, "far right");
        // The same ground turned by a quarter, driven northwards.
        let turned = move |x: f64, y: f64| rough_but(6.4)(y, -x);
        let c = command(&task(turned, &[("terrain", "1")]), 0.0, 0.0, FRAC_PI_2);
        assert_eq!(chosen(&c), 1.0);
        assert!((c.steering - 0.25 * std::f64::consts::PI).abs() < 1e-9);
    }

    #[test]
    fn it_keeps_to_the_height_it_is_at() {
        // Even steps: straight ahead and to the right it goes up by 1 m, to the left it stays.
        let step = |x: f64, y: f64| if x > 3.0 && y < 3.0 { 1.0 } else { 0.0 };
        let c = command(&task(step, &[("roughness", "0")]), 0.0, 0.0, 0.0);
        assert!(chosen(&c) < 2.0, "{:?}", c.debug);
    }

    #[test]
    fn a_region_beyond_the_map_is_not_chosen() {
        let c = command(&task(|_, y| 0.1 * y, &[]), 0.0, 36.0, 0.0);
        assert_eq!(c.debug[1].values[..2], [f32::INFINITY; 2], "36 + 6.4 m is beyond");
        let mut at_the_edge = task(|_, _| 0.0, &[]);
        at_the_edge.path = (30..=60).map(|i| Point2 { x: f64::from(i), y: 0.0 }).collect();
        let c = command(&at_the_edge, 39.0, 0.0, 0.0);
        assert_eq!(c.steering, 0.0, "all lie beyond: the path alone counts");
    }

    #[test]
    fn without_a_map_of_the_world_it_chooses_by_what_it_sees() {
        let z = |x: f64, y: f64| if (y - 6.4).abs() < 4.0 && x > 2.0 { 0.0 } else { math::sin(2.0 * x) };
        let mut unknown = task(z, &[]);
        unknown.elevation = None;
        // A map of the surroundings of 20 m, in which the ground under the vehicle has not been seen.
        let frame = GridFrame { rows: 81, cols: 81, resolution: 0.25, origin_x: -10.0, origin_y: -10.0 };
        let at = |i: i32| 0.25 * f64::from(i) - 10.0;
        let seen = |x: f64, y: f64| if x * x + y * y < 16.0 { f64::NAN } else { z(x, y) };
        let data = (0..81 * 81).map(|i| seen(at(i % 81), at(i / 81)) as f32).collect();
        let local_map = LocalMap { elevation: Map { frame, data }, ..LocalMap::default() };
        let blind = Observation::of(Pose::default());
        let o = Observation { local_map: Some(local_map), ..blind.clone() };
        let mut eh = Eh::init(&unknown).unwrap();
        assert_eq!(eh.step(&blind).unwrap().steering, 0.0, "nothing is known yet: the path alone counts");
        assert_eq!(chosen(&eh.step(&o).unwrap()), 1.0, "left");
    }

    #[test]
    fn the_regions_scale_with_the_vehicle() {
        let mut t =
            task(|x, y| if (y - 0.64).abs() < 0.4 && x > 0.2 { 0.0 } else { math::sin(20.0 * x) }, &[]);
        t.vehicle.scale = 0.1;
        let elevation = t.elevation.as_mut().unwrap();
        elevation.frame = GridFrame { resolution: 0.1, origin_x: -4.0, origin_y: -4.0, ..elevation.frame };
        let at = |i: i32| 0.1 * f64::from(i) - 4.0;
        let z = |x: f64, y: f64| if (y - 0.64).abs() < 0.4 && x > 0.2 { 0.0 } else { math::sin(20.0 * x) };
        elevation.data = (0..81 * 81).map(|i| z(at(i % 81), at(i / 81)) as f32).collect();
        assert_eq!(chosen(&command(&t, 0.0, 0.0, 0.0)), 1.0);
    }

    #[test]
    fn a_bad_parameter_is_refused_by_name() {
        for (key, value) in [("speed", "0"), ("region", "-1"), ("terrain", "1.5"), ("kp", "NaN")] {
            let message = Eh::init(&task(|_, _| 0.0, &[(key, value)])).unwrap_err().to_string();
            assert!(message.contains(key) && message.contains(value), "{message}");
        }
    }
}
