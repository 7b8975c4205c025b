//! The values that the settings of a run may have. They are checked whenever a run is read: run.json is a text that people can edit,
//! and a simulation with a step of 0, or a world of scale 0, would never end.

use std::ops::RangeInclusive;

use vb_vehicle::SCALES;

use crate::{RunHeader, TraceMeta};

/// The time steps that the simulation of a run may have, s.
pub const TIME_STEPS: RangeInclusive<f64> = 1e-4..=5e-3;

/// The sides of the cells in which the soil of a run may remember ruts, at scale 1, m.
pub const SOIL_RESOLUTIONS: RangeInclusive<f64> = 0.01..=0.5;

/// The times between two samples that a run may have, s.
const SAMPLE_PERIODS: RangeInclusive<f64> = 1e-3..=1.0;

/// Whether the simulation of a run may have this time step, s: it lies in [`TIME_STEPS`], and the time between two samples is a whole
/// number of steps.
#[must_use]
pub fn is_time_step(step: f64, sample_period: f64) -> bool {
    const TOLERANCE: f64 = 1e-9;
    (TIME_STEPS.start() - TOLERANCE..=TIME_STEPS.end() + TOLERANCE).contains(&step)
        && ((sample_period / step).round() * step - sample_period).abs() < TOLERANCE
}

/// The maximum speeds that a vehicle may have, m/s: all that a vehicle file may have.
const SPEEDS: RangeInclusive<f64> = f64::MIN_POSITIVE..=f64::MAX;

/// The coordinates that a place in a world may have, m, and the other numbers of a sample.
pub(crate) const PLACES: RangeInclusive<f64> = -1e9..=1e9;

/// What is wrong with a value that lies outside of what is allowed.
fn outside(field: &str, value: f64, allowed: &RangeInclusive<f64>) -> Option<String> {
    // A sum of digits or a power, whichever is shorter: 1e300 has 301 digits.
    let text = |v: f64| {
        let (plain, power) = (v.to_string(), format!("{v:e}"));
        if plain.len() > 12 { power } else { plain }
    };
    let (low, high) = (text(*allowed.start()), text(*allowed.end()));
    (!allowed.contains(&value)).then(|| format!("{field}: {} must lie in {low} to {high}", text(value)))
}

impl TraceMeta {
    /// The first value that no task can have: its field, its value, and what is allowed.
    pub(crate) fn flaw(&self) -> Option<String> {
        let places = |field: &str, values: &[f64]| values.iter().find_map(|v| outside(field, *v, &PLACES));
        outside("scale", self.scale, &SCALES)
            .or_else(|| outside("sample_period", self.sample_period, &SAMPLE_PERIODS))
            .or_else(|| outside("time_step", self.time_step, &TIME_STEPS))
            .or_else(|| places("start", &self.start))
            .or_else(|| places("goal", &self.goal))
            .or_else(|| places("goal_z", &[self.goal_z]))
            .or_else(|| places("half_extent", &self.half_extent))
            .or_else(|| outside("max_speed", self.max_speed, &SPEEDS))
    }
}

impl RunHeader {
    /// The first setting that no run can have: its field, its value, and what is allowed. `None` if there is no such setting.
    pub(crate) fn flaw(&self) -> Option<String> {
        outside("scale", self.scale, &SCALES)
            .or_else(|| outside("sample_period", self.sample_period, &SAMPLE_PERIODS))
            .or_else(|| {
                (!is_time_step(self.time_step, self.sample_period)).then(|| {
                    format!(
                        "time_step: {} must lie in {} to {}, and divide sample_period, {}",
                        self.time_step,
                        TIME_STEPS.start(),
                        TIME_STEPS.end(),
                        self.sample_period
                    )
                })
            })
            .or_else(|| outside("soil_resolution", self.soil_resolution, &SOIL_RESOLUTIONS))
            .or_else(|| {
                let period = self.plugin.control_period;
                (!(period.is_finite() && period > 0.0))
                    .then(|| format!("plugin.control_period: {period} must be above 0"))
            })
            .or_else(|| self.flaw_of_counts())
    }

    /// The first number of tasks, or of shards, that contradicts another.
    fn flaw_of_counts(&self) -> Option<String> {
        let above = |field: &str, value: u64, of: &str, most: u64| {
            (value > most).then(|| format!("{field}: {value} must not exceed {of}, {most}"))
        };
        let of_shard = self.shard.and_then(|shard| {
            let index = (shard.index == 0).then(|| "shard.index: 0 must be at least 1".to_owned());
            index
                .or_else(|| above("shard.index", shard.index.into(), "shard.of", shard.of.into()))
                .or_else(|| above("tasks", self.tasks, "shard.tasks", shard.tasks))
        });
        let all = self.whole().tasks;
        of_shard.or_else(|| above("tasks", all, "suite.tasks", self.suite.tasks))
    }
}
