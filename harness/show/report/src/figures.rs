//! Figures of a run over some of its tasks.

use vb_score::{BOOTSTRAP_SEED, Cause, Flag, Outcome, Ride};

use crate::runs::{Row, Run, Runs, WorldLabels};
use crate::statistics::{Interval, Ratio, bootstrap_ratio, success_interval};

/// A measure of which a report gives means and intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Successes over tasks.
    Success,
    /// Traversal time of successful tasks, s.
    Time,
    /// |roll| over all samples of all tasks, degrees.
    Roll,
    /// |pitch| over the same, degrees.
    Pitch,
}

impl Measure {
    /// All, in the order of the paper's figure.
    pub const ALL: [Self; 4] = [Self::Success, Self::Time, Self::Roll, Self::Pitch];

    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Success => "success rate",
            Self::Time => "traversal time",
            Self::Roll => "|roll|",
            Self::Pitch => "|pitch|",
        }
    }

    /// The unit in which [`Measure::shown`] gives it.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Success => "%",
            Self::Time => "s",
            Self::Roll | Self::Pitch => "°",
        }
    }

    /// The unit of a difference, in which [`Measure::shown`] gives it.
    #[must_use]
    pub fn difference_unit(self) -> &'static str {
        if self == Self::Success { "points" } else { self.unit() }
    }

    /// Whether a planner wants much of it: successes, but neither time nor tilt.
    #[must_use]
    pub fn more_is_better(self) -> bool {
        self == Self::Success
    }

    /// A value in the unit that people read.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        if self == Self::Success { 100.0 * value } else { value }
    }

    /// What a task adds to numerator and denominator of the mean.
    #[must_use]
    pub fn of(self, row: &Row) -> Ratio {
        let pooled = |mean: f64, samples: u64| Ratio { sum: mean * samples as f64, weight: samples as f64 };
        match (self, &row.metrics) {
            (Self::Success, _) => Ratio { sum: f64::from(u8::from(row.succeeded())), weight: 1.0 },
            (Self::Time, _) if row.succeeded() => Ratio { sum: row.time, weight: 1.0 },
            (Self::Roll, Some(m)) => pooled(m.roll_mean_deg, m.samples),
            (Self::Pitch, Some(m)) => pooled(m.pitch_mean_deg, m.samples),
            _ => Ratio::default(),
        }
    }
}

/// A mean, with its interval where there are two worlds or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub mean: f64,
    /// Its 95 % interval by the bootstrap over worlds.
    pub interval: Option<Interval>,
}

impl Estimate {
    #[must_use]
    pub(crate) fn negated(self) -> Self {
        // 0 has no sign.
        let minus = |v: f64| 0.0 - v;
        let interval = self.interval.map(|i| Interval {
            estimate: minus(i.estimate),
            low: minus(i.high),
            high: minus(i.low),
        });
        Self { mean: minus(self.mean), interval }
    }
}

/// The step of the colour scale of shares, 0 to 5 (the classes `h0` to `h5` of [`vb_page::TABLE_STYLE`]), for so many of all
/// tasks.
#[must_use]
pub fn heat((done, all): (u64, u64)) -> usize {
    (done as f64 / all.max(1) as f64 * 5.999) as usize
}

/// Figures over some tasks of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Number of tasks that count.
    pub tasks: u64,
    /// Number of worlds that they lie in.
    pub worlds: usize,
    /// Number by outcome, in the order of [`Outcome::ALL`].
    pub outcomes: [u64; Outcome::ALL.len()],
    /// Number of those of which each flag is true, in the order of [`Flag::ALL`]; none where no task says it.
    pub flags: [Option<u64>; Flag::ALL.len()],
    /// Means of the measures of [`Ride`] over the tasks that have them, in the order of [`Ride::MEASURES`].
    pub ride: [Option<f64>; Ride::MEASURES.len()],
    /// Number of those that rolled over or got stuck by cause, in the order of [`Cause::ALL`].
    pub causes: [u64; Cause::ALL.len()],
    /// Means, in the order of [`Measure::ALL`]; none without anything to average.
    pub means: [Option<Estimate>; Measure::ALL.len()],
}

impl Figures {
    /// Figures over these rows of runs in `worlds`.
    #[must_use]
    pub fn new<'a>(rows: impl Iterator<Item = &'a Row>, worlds: usize) -> Self {
        let mut sums = vec![[Ratio::default(); Measure::ALL.len()]; worlds];
        let mut outcomes = [0; Outcome::ALL.len()];
        let mut causes = [0; Cause::ALL.len()];
        let mut flags = [None; Flag::ALL.len()];
        let mut ride = [Ratio::default(); Ride::MEASURES.len()];
        let mut tasks = 0;
        for row in rows.filter(|r| r.counts()) {
            tasks += 1;
            outcomes[row.outcome.index()] += 1;
            for (count, is) in flags.iter_mut().zip(row.flags) {
                if let Some(is) = is {
                    *count = Some(count.unwrap_or(0) + u64::from(is));
                }
            }
            for (mean, measure) in ride.iter_mut().zip(Ride::MEASURES) {
                if let Some(value) = row.ride.as_ref().and_then(|ride| measure.number(ride)) {
                    mean.sum += value;
                    mean.weight += 1.0;
                }
            }
            if let Some(k) = Cause::ALL.iter().position(|c| Some(*c) == row.cause) {
                causes[k] += 1;
            }
            for (sum, measure) in sums[row.world as usize].iter_mut().zip(Measure::ALL) {
                let own = measure.of(row);
                sum.sum += own.sum;
                sum.weight += own.weight;
            }
        }
        let means = std::array::from_fn(|k| {
            let (clusters, measure): (Vec<Ratio>, _) = (sums.iter().map(|s| s[k]).collect(), Measure::ALL[k]);
            match measure {
                Measure::Success => mean(&clusters, success_interval(&clusters)),
                _ => estimate(&clusters, measure.name()),
            }
        });
        let found = sums.iter().filter(|s| s[0].weight > 0.0).count();
        let ride = ride.map(|r| (r.weight > 0.0).then(|| r.sum / r.weight));
        Self { tasks, worlds: found, outcomes, flags, ride, causes, means }
    }

    #[must_use]
    pub fn mean(&self, measure: Measure) -> Option<Estimate> {
        self.means[measure as usize]
    }

    /// Of how many tasks this is true; none where no task says it.
    #[must_use]
    pub fn flagged(&self, flag: Flag) -> Option<u64> {
        self.flags[flag as usize]
    }

    /// The share of the tasks of which this is true, percent.
    #[must_use]
    pub fn flagged_percent(&self, flag: Flag) -> Option<f64> {
        self.flagged(flag).map(|n| 100.0 * n as f64 / self.tasks.max(1) as f64)
    }

    #[must_use]
    pub fn caused(&self, cause: Cause) -> u64 {
        Cause::ALL.iter().position(|c| *c == cause).map_or(0, |k| self.causes[k])
    }

    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u64 {
        self.outcomes[outcome.index()]
    }
}

/// A mean over clusters with its interval.
pub(crate) fn estimate(clusters: &[Ratio], label: &str) -> Option<Estimate> {
    mean(clusters, bootstrap_ratio(clusters, BOOTSTRAP_SEED, &["report", label]))
}

/// A mean over clusters with this interval; none without anything to average.
fn mean(clusters: &[Ratio], interval: Option<Interval>) -> Option<Estimate> {
    let (sum, weight) = clusters.iter().fold((0.0, 0.0), |(s, w), c| (s + c.sum, w + c.weight));
    (weight > 0.0).then(|| Estimate { mean: sum / weight, interval })
}

/// A label of worlds by which figures are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    Elevation,
    Terrain,
    Density,
}

impl Split {
    /// All, in the order of the paper's figure.
    pub const ALL: [Self; 3] = [Self::Elevation, Self::Terrain, Self::Density];

    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Elevation => "elevation",
            Self::Terrain => "terrain",
            Self::Density => "obstacle density",
        }
    }

    #[must_use]
    pub fn levels(self) -> Vec<&'static str> {
        match self {
            Self::Elevation => vb_world::Elevation::ALL.map(vb_world::Elevation::name).to_vec(),
            Self::Terrain => vb_world::Terrain::ALL.map(vb_world::Terrain::name).to_vec(),
            Self::Density => vb_world::Density::ALL.map(vb_world::Density::name).to_vec(),
        }
    }

    #[must_use]
    pub fn level(self, world: &WorldLabels) -> &'static str {
        match self {
            Self::Elevation => world.elevation.name(),
            Self::Terrain => world.terrain.name(),
            Self::Density => world.density.name(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct RunFigures {
    pub all: Figures,
    /// By each split, its levels in order; levels without tasks have figures without means.
    pub splits: [Vec<(&'static str, Figures)>; Split::ALL.len()],
    /// (successes, tasks) by world.
    pub worlds: Vec<(u64, u64)>,
}

impl RunFigures {
    #[must_use]
    pub fn new(runs: &Runs, run: &Run) -> Self {
        let count = runs.worlds.len();
        let splits = Split::ALL.map(|split| {
            let of = |level: &'static str| {
                let rows = run.rows.iter().filter(|r| split.level(&runs.worlds[r.world as usize]) == level);
                (level, Figures::new(rows, count))
            };
            split.levels().into_iter().map(of).collect()
        });
        let mut worlds = vec![(0, 0); count];
        for row in run.counted() {
            let w = &mut worlds[row.world as usize];
            w.0 += u64::from(row.succeeded());
            w.1 += 1;
        }
        Self { all: Figures::new(run.rows.iter(), count), splits, worlds }
    }
}
