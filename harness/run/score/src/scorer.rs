//! Applying rules to a trial, sample by sample.

use std::collections::VecDeque;

use vb_math::angle::degrees;
use vb_math::{acos, cos};
use vb_record::{Sample, TraceMeta};
use vb_world::{Task, World};

use crate::metrics::{Accumulator, displacement};
use crate::{Fault, Metrics, Outcome, RollTime, RolloverRule, Rules, StuckRule, SuccessRule, ThreeWay};

/// The place of a trial, in metres of the world as simulated, that is after scaling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskGeometry {
    /// The goal (x, y), m.
    pub goal: [f64; 2],
    /// The height of the ground at the goal, m.
    pub goal_z: f64,
    /// Half the extents of the world along x and y, m.
    pub half_extent: [f64; 2],
    /// The factor by which the world's lengths were multiplied. The lengths in rules are multiplied by it too.
    pub scale: f64,
    /// The vehicle's maximum speed, m/s, on which the time limit depends.
    pub max_speed: f64,
}

impl TaskGeometry {
    /// The place of a task in a world, which is scaled already, for a vehicle of a maximum speed (m/s).
    #[must_use]
    pub fn of(world: &World, task: &Task, max_speed: f64) -> Self {
        let (h, goal) = (&world.heightfield, task.goal);
        Self {
            goal,
            goal_z: h.height(goal[0], goal[1]),
            half_extent: [h.half_x(), h.half_y()],
            scale: world.scale,
            max_speed,
        }
    }
}

impl From<&TraceMeta> for TaskGeometry {
    fn from(meta: &TraceMeta) -> Self {
        let TraceMeta { goal, goal_z, half_extent, scale, max_speed, .. } = *meta;
        Self { goal, goal_z, half_extent, scale, max_speed }
    }
}

/// The way in which a trial was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The outcome of the trial.
    pub outcome: Outcome,
    /// The reason for the outcome, in words.
    pub reason: String,
}

/// The score of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskScore {
    /// The outcome of the trial.
    pub outcome: Outcome,
    /// The paper's class of the outcome.
    pub three_way: ThreeWay,
    /// The reason for the outcome, in words.
    pub reason: String,
    /// The simulated time at the end of the trial, s.
    pub time_s: f64,
    /// The measures of the trial; `None` if it ended before the first sample.
    pub metrics: Option<Metrics>,
}

/// Times are sums of steps: what is due at 10 s must not wait for the next sample over the last bits of a sum.
const TIME_TOLERANCE: f64 = 1e-6;

/// How the reason of a trial begins that the rule `overturned` ended.
pub(crate) const TIPPED: &str = "tipped over by";
/// What stands in a reason between the angles of a rollover and how the vehicle was stuck.
const BETWEEN: &str = "; ";

/// The verdict on a trial that ended because the vehicle was stuck, with how.
fn stuck_or_rolled(angles: Option<String>, how: &str) -> Verdict {
    match angles {
        Some(angles) => Verdict { outcome: Outcome::Rollover, reason: format!("{angles}{BETWEEN}{how}") },
        None => Verdict { outcome: Outcome::Stuck, reason: how.to_owned() },
    }
}

/// The verdict on a trial that ended because the vehicle was stuck or rolled over, with this reason, if other angles (in words) make it a
/// rollover.
pub(crate) fn judged_again(outcome: Outcome, reason: &str, angles: Option<String>) -> Verdict {
    let how = match outcome {
        Outcome::Rollover => reason.split_once(BETWEEN).map_or(reason, |(_, how)| how),
        _ => reason,
    };
    stuck_or_rolled(angles, how)
}

/// Judges and measures one trial.
///
/// At each sample the rules are tested in this order: state not finite (a simulation error), time limit, success,
/// out of bounds, overturned, stuck. The first that applies decides. A failed trial in which the vehicle is rolled over is a
/// rollover if it ended by the stuck rule; see [`Outcome::three_way`] for the others.
#[derive(Clone, Debug)]
pub struct Scorer {
    rules: Rules,
    geometry: TaskGeometry,
    sums: Accumulator,
    /// Samples of the stuck rule's window and the last one before it (displacement rule).
    window: VecDeque<Sample>,
    /// For how long the vehicle has been slow, s (speed rule).
    slow_for: f64,
    verdict: Option<Verdict>,
}

impl Scorer {
    /// A scorer for one trial.
    #[must_use]
    pub fn new(rules: &Rules, geometry: &TaskGeometry) -> Self {
        Self {
            rules: rules.clone(),
            geometry: *geometry,
            sums: Accumulator::new(geometry.goal),
            window: VecDeque::new(),
            slow_for: 0.0,
            verdict: None,
        }
    }

    /// Takes the next sample; times must increase. It returns the verdict as soon as there is one; samples after it
    /// change nothing.
    pub fn push(&mut self, sample: &Sample) -> Option<&Verdict> {
        if self.verdict.is_none() {
            self.verdict = self.judge(sample);
        }
        self.verdict.as_ref()
    }

    /// The verdict; `None` while no rule has decided.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// The measures of the samples so far; `None` without samples.
    #[must_use]
    pub fn metrics(&self) -> Option<Metrics> {
        self.sums.metrics()
    }

    /// The score of the trial; `None` if the samples didn't suffice for a verdict.
    #[must_use]
    pub fn finish(self) -> Option<TaskScore> {
        let Verdict { outcome, reason } = self.verdict.clone()?;
        Some(self.score(outcome, reason))
    }

    /// The score of a trial that could not go on.
    #[must_use]
    pub fn fail(self, fault: Fault, reason: impl Into<String>) -> TaskScore {
        self.score(fault.outcome(), reason.into())
    }

    fn score(self, outcome: Outcome, reason: String) -> TaskScore {
        TaskScore {
            outcome,
            three_way: outcome.three_way(self.rolled_over().is_some()),
            reason,
            time_s: self.sums.last().map_or(0.0, |s| s.time),
            metrics: self.sums.metrics(),
        }
    }

    fn judge(&mut self, sample: &Sample) -> Option<Verdict> {
        let verdict = |outcome, reason| Some(Verdict { outcome, reason });
        let t = sample.time;
        if !sample.is_finite() {
            // Not measured: one NaN would swallow every figure of the trial.
            let reason = format!("the state of the vehicle is not finite after {t:.3} s");
            return verdict(Outcome::SimError, reason);
        }
        // The window needs the sample even if another rule decides now, but then nobody looks any more.
        let stuck = self.stuck(sample);
        self.sums.push(sample);
        if t + TIME_TOLERANCE >= self.rules.time_limit(self.geometry.scale, self.geometry.max_speed) {
            let away = self.sums.goal_distance();
            return verdict(
                Outcome::Timeout,
                format!("{away:.1} m from the goal when time ran out at {t:.2} s"),
            );
        }
        if let Some(distance) = self.reached(sample) {
            return verdict(Outcome::Success, format!("{distance:.2} m from the goal at {t:.2} s"));
        }
        if self.outside(sample) {
            return verdict(
                Outcome::OutOfBounds,
                format!("left the world at ({:.1}, {:.1})", sample.x, sample.y),
            );
        }
        if let Some(tilt) = self.overturned(sample) {
            return verdict(Outcome::Rollover, format!("{TIPPED} {tilt:.1}° at {t:.2} s"));
        }
        Some(stuck_or_rolled(self.rolled_over(), &stuck?))
    }

    /// The distance from the goal if that is near enough, m.
    fn reached(&self, s: &Sample) -> Option<f64> {
        let planar = self.sums.goal_distance();
        let distance = match self.rules.success {
            SuccessRule::Planar { .. } => planar,
            SuccessRule::Marker { marker_height_m, .. } => {
                let dz = s.z - (self.geometry.goal_z + marker_height_m * self.geometry.scale);
                (planar * planar + dz * dz).sqrt()
            }
            SuccessRule::Never => return None,
        };
        (distance < self.rules.goal_radius(self.geometry.scale)).then_some(distance)
    }

    /// The angle between the vehicle's upward axis and the vertical if it is too great, degrees.
    fn overturned(&self, s: &Sample) -> Option<f64> {
        let rule = self.rules.overturned?;
        // The vertical component of the upward axis: heading first, then pitch, then roll.
        let tilt = degrees(acos((cos(s.pitch) * cos(s.roll)).clamp(-1.0, 1.0)));
        (tilt > rule.tilt_limit_deg).then_some(tilt)
    }

    fn outside(&self, s: &Sample) -> bool {
        self.rules.out_of_bounds.is_some_and(|rule| {
            let margin = rule.margin_m * self.geometry.scale;
            let [half_x, half_y] = self.geometry.half_extent;
            s.x.abs() > half_x + margin || s.y.abs() > half_y + margin
        })
    }

    /// Takes the sample into the stuck rule's memory; if the vehicle is stuck, how.
    fn stuck(&mut self, s: &Sample) -> Option<String> {
        match self.rules.stuck? {
            StuckRule::Displacement { window_s, distance_m } => {
                let window_s = window_s * self.geometry.scale.sqrt();
                self.window.push_back(*s);
                let begin = s.time - window_s + TIME_TOLERANCE;
                while self.window.get(1).is_some_and(|next| next.time <= begin) {
                    self.window.pop_front();
                }
                let first = self.window.front().filter(|first| first.time <= begin)?;
                let moved = displacement(first, s);
                (moved < distance_m * self.geometry.scale)
                    .then(|| format!("moved {moved:.2} m in the last {} s", shown(window_s)))
            }
            StuckRule::Slow { speed_m_per_s, duration_s } => {
                let last = self.sums.last()?;
                let dt = s.time - last.time;
                let pace = self.geometry.scale.sqrt();
                let (limit, duration_s) = (speed_m_per_s * pace, duration_s * pace);
                self.slow_for = if displacement(last, s) < limit * dt { self.slow_for + dt } else { 0.0 };
                (self.slow_for + TIME_TOLERANCE >= duration_s)
                    .then(|| format!("slower than {} m/s for {} s", shown(limit), shown(duration_s)))
            }
        }
    }

    /// The angles that make this a rollover if the trial failed now, in words.
    fn rolled_over(&self) -> Option<String> {
        let rule = self.rules.rollover?;
        let last = self.sums.last()?;
        let (roll, pitch) = match rule.when {
            RollTime::End => (degrees(last.roll), degrees(last.pitch)),
            RollTime::AnyTime => self.sums.angle_maxima(),
        };
        rule.exceeded(roll, pitch)
    }
}

impl RolloverRule {
    /// The angle at the time that counts, degrees, which makes a failed trial a rollover, in words.
    pub(crate) fn exceeded(&self, roll: f64, pitch: f64) -> Option<String> {
        let when = match self.when {
            RollTime::End => "at the end",
            RollTime::AnyTime => "at most",
        };
        if roll.abs() > self.roll_limit_deg {
            return Some(format!("roll {roll:.1}° {when}"));
        }
        self.pitch_limit_deg.filter(|limit| pitch.abs() > *limit).map(|_| format!("pitch {pitch:.1}° {when}"))
    }
}

/// A number for a message: as it is, or in hundredths where scaling made it long.
fn shown(value: f64) -> String {
    if (value * 100.0).round() / 100.0 == value { value.to_string() } else { format!("{value:.2}") }
}
