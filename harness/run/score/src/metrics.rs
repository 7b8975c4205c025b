//! Measures of one trial, and the figures that summaries have of them: each is declared here and measured by [`Accumulator`].

use serde::{Deserialize, Serialize};
use vb_math::angle::degrees;
use vb_math::hypot;
use vb_record::Sample;

use crate::measures::Extent::{Failures, Pages, Papers};
use crate::measures::{MOST, measures};
use crate::stats::Running;

measures! {
    /// Measures of one trial, over its samples from the first to the one that decided it. Angles are in degrees, as the
    /// paper reports them, and absolute: left and right, up and down count alike. Variances are of the population.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    "metrics": pub struct Metrics {
        /// Number of samples.
        pub samples: u64 => most(MOST),
        /// Mean of |roll|, degrees.
        pub roll_mean_deg: f64 => column("|roll| °") drawn(Papers, "Mean |roll| of a task", "degrees"),
        /// Variance of |roll|, degrees².
        pub roll_variance_deg2: f64,
        /// Maximum |roll|, degrees.
        pub roll_max_deg: f64 => column("max") drawn(Pages, "Maximum |roll| of a task", "degrees"),
        /// Signed roll at the last sample, degrees.
        pub roll_end_deg: f64 => signed(),
        /// Mean of |pitch|, degrees.
        pub pitch_mean_deg: f64 => column("|pitch| °") drawn(Papers, "Mean |pitch| of a task", "degrees"),
        /// Variance of |pitch|, degrees².
        pub pitch_variance_deg2: f64,
        /// Maximum |pitch|, degrees.
        pub pitch_max_deg: f64 => column("max") drawn(Pages, "Maximum |pitch| of a task", "degrees"),
        /// Length of the reference point's 3D trajectory, m: the sum of the distances between samples.
        pub distance_m: f64 => column("distance m") drawn(Pages, "Distance travelled", "m"),
        /// Mean speed: `distance_m` over the duration, m/s.
        pub speed_mean_m_per_s: f64 => drawn(Papers, "Mean speed", "m/s"),
        /// Maximum speed at a sample, m/s.
        pub speed_max_m_per_s: f64,
        /// Time integral of the throttle command, s.
        pub throttle_effort_s: f64,
        /// Time integral of the brake command, s.
        pub brake_effort_s: f64,
        /// Time integral of |steering command|, s.
        pub steering_effort_s: f64,
        /// Mean of |d(steering command)/dt|, 1/s: the sum of the command's changes over time.
        pub steering_rate_per_s: f64,
        /// Time with the reverse gear commanded, s.
        pub reverse_s: f64,
        /// Minimum horizontal distance from the goal, m.
        pub goal_distance_min_m: f64,
        /// Horizontal distance from the goal at the last sample, m.
        pub goal_distance_end_m: f64
            => column("to goal m") drawn(Failures, "Distance from the goal at the end of failures", "m"),
        /// World x coordinate (east) of the reference point at the last sample, m.
        pub end_x_m: f64 => signed(),
        /// World y coordinate (north) of the reference point at the last sample, m.
        pub end_y_m: f64 => signed(),
    }
}

impl Metrics {
    /// |roll| over the samples, degrees.
    fn roll(&self) -> Running {
        Running::from_parts(self.samples, self.roll_mean_deg, self.roll_variance_deg2, self.roll_max_deg)
    }

    /// |pitch| over the samples, degrees.
    fn pitch(&self) -> Running {
        Running::from_parts(self.samples, self.pitch_mean_deg, self.pitch_variance_deg2, self.pitch_max_deg)
    }

    /// Where the trial ended: x and y of the reference point at the last sample, m, world frame.
    #[must_use]
    pub fn end(&self) -> [f64; 2] {
        [self.end_x_m, self.end_y_m]
    }
}

/// Declares the figures that a summary has of the metrics of its tasks: behind each the function that makes it of them.
macro_rules! pooled {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident {
            $($(#[doc = $about:literal])+ pub $field:ident = $pool:ident($($arg:expr),+),)+
        }
    ) => {
        $(#[$attribute])*
        pub struct $name {
            $($(#[doc = $about])+ pub $field: Option<f64>,)+
        }

        impl $name {
            /// The figures of tasks with these metrics, in the order in which they are summed.
            pub(crate) fn new(tasks: &[&Metrics]) -> Self {
                Self { $($field: $pool(tasks, $($arg),+)),+ }
            }
        }
    };
}

pooled! {
    /// Figures over the metrics of some tasks; `None` if no task has samples.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Pooled {
        /// The mean |roll| over all samples of all tasks, as in the evaluation scripts of the original, degrees.
        pub roll_mean_deg = over_samples(Metrics::roll, |s| s.mean),
        /// The variance of |roll| over the same samples, degrees².
        pub roll_variance_deg2 = over_samples(Metrics::roll, Running::variance),
        /// The maximum |roll|, degrees.
        pub roll_max_deg = over_samples(Metrics::roll, |s| s.max),
        /// The mean over tasks of each task's mean |roll|, degrees: all tasks have the same weight.
        pub roll_task_mean_deg = over_tasks(|m| m.roll_mean_deg),
        /// The mean |pitch| over all samples of all tasks, degrees.
        pub pitch_mean_deg = over_samples(Metrics::pitch, |s| s.mean),
        /// The variance of |pitch| over the same samples, degrees².
        pub pitch_variance_deg2 = over_samples(Metrics::pitch, Running::variance),
        /// The maximum |pitch|, degrees.
        pub pitch_max_deg = over_samples(Metrics::pitch, |s| s.max),
        /// The mean over tasks of each task's mean |pitch|, degrees.
        pub pitch_task_mean_deg = over_tasks(|m| m.pitch_mean_deg),
        /// The mean distance travelled, m.
        pub distance_mean_m = over_tasks(|m| m.distance_m),
        /// The mean throttle effort, s.
        pub throttle_effort_mean_s = over_tasks(|m| m.throttle_effort_s),
        /// The mean steering effort, s.
        pub steering_effort_mean_s = over_tasks(|m| m.steering_effort_s),
        /// The mean steering rate, 1/s.
        pub steering_rate_mean_per_s = over_tasks(|m| m.steering_rate_per_s),
    }
}

/// A figure over the samples of all tasks together, of which each task has mean, variance and maximum.
fn over_samples(tasks: &[&Metrics], of: fn(&Metrics) -> Running, figure: fn(&Running) -> f64) -> Option<f64> {
    let mut all = Running::default();
    tasks.iter().for_each(|m| all.merge(&of(m)));
    (all.count > 0).then(|| figure(&all))
}

/// The mean over tasks, which count alike.
fn over_tasks(tasks: &[&Metrics], of: fn(&Metrics) -> f64) -> Option<f64> {
    let mut all = Running::default();
    tasks.iter().for_each(|m| all.push(of(m)));
    (all.count > 0).then_some(all.mean)
}

/// Sums over the samples of one trial, in their order.
#[derive(Clone, Debug)]
pub(crate) struct Accumulator {
    goal: [f64; 2],
    roll: Running,
    pitch: Running,
    first_time: f64,
    last: Option<Sample>,
    distance: f64,
    speed_max: f64,
    throttle: f64,
    brake: f64,
    steering: f64,
    steering_travel: f64,
    reverse: f64,
    goal_distance_min: f64,
    goal_distance: f64,
}

impl Accumulator {
    pub(crate) fn new(goal: [f64; 2]) -> Self {
        Self {
            goal,
            roll: Running::default(),
            pitch: Running::default(),
            first_time: 0.0,
            last: None,
            distance: 0.0,
            speed_max: 0.0,
            throttle: 0.0,
            brake: 0.0,
            steering: 0.0,
            steering_travel: 0.0,
            reverse: 0.0,
            goal_distance_min: f64::INFINITY,
            goal_distance: f64::INFINITY,
        }
    }

    pub(crate) fn push(&mut self, s: &Sample) {
        self.roll.push(degrees(s.roll).abs());
        self.pitch.push(degrees(s.pitch).abs());
        self.speed_max = self.speed_max.max((s.vx * s.vx + s.vy * s.vy + s.vz * s.vz).sqrt());
        self.goal_distance = hypot(s.x - self.goal[0], s.y - self.goal[1]);
        self.goal_distance_min = self.goal_distance_min.min(self.goal_distance);
        if let Some(last) = &self.last {
            // A sample carries the command that was applied up to it, so it stands for the interval before it.
            let dt = s.time - last.time;
            self.distance += displacement(last, s);
            self.throttle += s.throttle * dt;
            self.brake += s.brake * dt;
            self.steering += s.steering.abs() * dt;
            self.reverse += if s.gear == Sample::REVERSE { dt } else { 0.0 };
            self.steering_travel += (s.steering - last.steering).abs();
        } else {
            self.first_time = s.time;
        }
        self.last = Some(*s);
    }

    /// Maximum |roll| and |pitch| so far, degrees.
    pub(crate) fn angle_maxima(&self) -> (f64, f64) {
        (self.roll.max, self.pitch.max)
    }

    pub(crate) fn last(&self) -> Option<&Sample> {
        self.last.as_ref()
    }

    /// Distance from the goal in the plane at the latest sample, m.
    pub(crate) fn goal_distance(&self) -> f64 {
        self.goal_distance
    }

    /// The measures; none without samples.
    pub(crate) fn metrics(&self) -> Option<Metrics> {
        let last = self.last?;
        let duration = last.time - self.first_time;
        let per_time = |sum: f64| if duration > 0.0 { sum / duration } else { 0.0 };
        Some(Metrics {
            samples: self.roll.count,
            roll_mean_deg: self.roll.mean,
            roll_variance_deg2: self.roll.variance(),
            roll_max_deg: self.roll.max,
            roll_end_deg: degrees(last.roll),
            pitch_mean_deg: self.pitch.mean,
            pitch_variance_deg2: self.pitch.variance(),
            pitch_max_deg: self.pitch.max,
            distance_m: self.distance,
            speed_mean_m_per_s: per_time(self.distance),
            speed_max_m_per_s: self.speed_max,
            throttle_effort_s: self.throttle,
            brake_effort_s: self.brake,
            steering_effort_s: self.steering,
            steering_rate_per_s: per_time(self.steering_travel),
            reverse_s: self.reverse,
            goal_distance_min_m: self.goal_distance_min,
            goal_distance_end_m: self.goal_distance,
            end_x_m: last.x,
            end_y_m: last.y,
        })
    }
}

/// Distance in space between the positions of two samples, m.
pub(crate) fn displacement(a: &Sample, b: &Sample) -> f64 {
    let (dx, dy, dz) = (b.x - a.x, b.y - a.y, b.z - a.z);
    (dx * dx + dy * dy + dz * dz).sqrt()
}
