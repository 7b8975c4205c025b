//! An episode: what was recorded of one drive.

use serde::{Deserialize, Serialize};
use vb_record::Sample;
use vb_sdk::{Command, Observation};
use vb_sim::{Controls, Gear, Simulation, VehicleState};
use vb_trial::Witness;
use vb_world::{Density, Elevation, Terrain, TerrainClass};

use crate::feature::{Feature, Frame, Ground, Values};
use crate::values::shown;

/// The greatest length, coordinate or time that an episode may have, m or s.
const FARTHEST: f64 = 1e9;

/// The outcome of an episode that its driver ended before the rules did.
pub const ENDED: &str = "ended";

/// What is said of an episode as a whole. Each field is a column of `meta/episodes`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EpisodeInfo {
    /// The task in words, as a policy that takes language reads it.
    pub instruction: String,
    /// The place of the drive among all that the command makes, from 0. Drives that weren't kept are missing.
    pub drive: u64,
    /// Who drove: a policy of exploration, a planner with its version, or a person.
    pub driver: String,
    /// The world, by its name in the dataset's `worlds`.
    pub world: String,
    pub world_hash: String,
    /// The name of the task in the suite, e.g. `w003/t07`; empty for exploration.
    pub task: String,
    /// The level of the world's relief: `low`, `medium` or `high`.
    pub elevation: String,
    /// The kind of the world's ground: `rigid`, `deformable` or `mixed`.
    pub terrain: String,
    /// The density of the world's obstacles: `sparse`, `medium` or `dense`.
    pub density: String,
    /// The kind of ground under the vehicle at the end.
    pub ground: String,
    /// The outcome by the rules, as runs have it.
    pub outcome: String,
    /// Why it ended, in words.
    pub reason: String,
    /// The time at the end, s.
    pub time_s: f64,
    /// The length of the way, m.
    pub distance_m: f64,
    /// The pose at the start: x and y, m, and the heading, rad.
    pub start: [f64; 3],
    /// The goal: x and y, m; where the vehicle started if there is none.
    pub goal: [f64; 2],
    /// The hash over the simulation's states, by which a drive is known again; empty for a part of an episode.
    pub state_hash: String,
    /// Where a part of an episode comes from: the episode, and from which second; empty for whole ones.
    pub origin: String,
    /// The cause of a rollover, or of getting stuck; else empty.
    pub cause: String,
}

impl EpisodeInfo {
    /// The first field with a value that no episode can have: the field, the value, and what is allowed. `None` if there is none.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let named = |field: &str, value: &str, known: &[&str]| {
            let is_known = value.is_empty() || known.contains(&value);
            (!is_known).then(|| format!("{field}: {value:?} is none of {}", known.join(", ")))
        };
        let within = |field: &str, values: &[f64], low: f64, high: f64| {
            let odd = values.iter().find(|v| !(low..=high).contains(*v))?;
            Some(format!("{field}: {} must lie in {} to {}", shown(*odd), shown(low), shown(high)))
        };
        let outcomes: Vec<&str> = vb_score::Outcome::ALL.iter().map(|o| o.name()).chain([ENDED]).collect();
        let causes: Vec<&str> = vb_score::Cause::ALL.iter().map(|c| c.name()).collect();
        named("outcome", &self.outcome, &outcomes)
            .or_else(|| named("cause", &self.cause, &causes))
            .or_else(|| named("elevation", &self.elevation, &Elevation::ALL.map(Elevation::name)))
            .or_else(|| named("terrain", &self.terrain, &Terrain::ALL.map(Terrain::name)))
            .or_else(|| named("density", &self.density, &Density::ALL.map(Density::name)))
            .or_else(|| named("ground", &self.ground, &TerrainClass::ALL.map(TerrainClass::name)))
            .or_else(|| within("time_s", &[self.time_s], 0.0, FARTHEST))
            .or_else(|| within("distance_m", &[self.distance_m], 0.0, FARTHEST))
            .or_else(|| within("start", &self.start, -FARTHEST, FARTHEST))
            .or_else(|| within("goal", &self.goal, -FARTHEST, FARTHEST))
    }
}

/// An episode in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    pub info: EpisodeInfo,
    pub frames: usize,
    /// The values of each column, in the order of the dataset's features.
    pub columns: Vec<Values>,
}

/// An episode with the names of its columns.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    features: &'a [Feature],
    values: &'a [Values],
}

impl Episode {
    /// The episode with the features of its dataset.
    #[must_use]
    pub fn view<'a>(&'a self, features: &'a [Feature]) -> View<'a> {
        View { features, values: &self.columns }
    }
}

impl View<'_> {
    /// The values of a frame in a column; none if there is no such column.
    ///
    /// # Panics
    /// Panics if there is the column, but not the frame.
    #[must_use]
    pub fn row(&self, name: &str, frame: usize) -> Vec<f64> {
        let found = self.features.iter().zip(self.values).find(|(f, _)| f.name == name);
        let row = |(f, values): (&Feature, &Values)| {
            let width = f.width();
            (frame * width..(frame + 1) * width).map(|k| values.number(k)).collect()
        };
        found.map(row).unwrap_or_default()
    }

    /// The state of a frame as it was in truth, with the entries of `observation.state`.
    ///
    /// # Panics
    /// Panics if there is no such frame.
    #[must_use]
    pub fn state(&self, frame: usize) -> Vec<f64> {
        // Where the driver knew the truth, it has no column of its own.
        let row = self.row("truth.state", frame);
        if row.is_empty() { self.row("observation.state", frame) } else { row }
    }
}

/// A command with what was seen before it; its frame is complete when the next begins.
struct Pending {
    state: VehicleState,
    seen: Observation,
    given: Command,
    taken: Controls,
    speed: f64,
    /// Sum and number of the steering of the samples since.
    steering: (f64, u32),
    gear: Gear,
}

/// Turns a trial into an episode while it is driven.
pub(crate) struct Recorder<'a> {
    features: &'a [Feature],
    ground: &'a Ground,
    goal: [f64; 2],
    /// Steps of the driver for each frame.
    every: u64,
    steps: u64,
    /// The last readings of all sensors.
    seen: Observation,
    pending: Option<Pending>,
    frames: usize,
    columns: Vec<Values>,
    distance: f64,
    last: Option<[f64; 3]>,
    time: f64,
}

/// The name under which a driver tells the speed that it aims at, among the series that it sends.
pub(crate) const SPEED_SERIES: &str = "speed_command";

impl<'a> Recorder<'a> {
    pub(crate) fn new(features: &'a [Feature], ground: &'a Ground, goal: [f64; 2], every: u64) -> Self {
        Self {
            features,
            ground,
            goal,
            every: every.max(1),
            steps: 0,
            seen: Observation::default(),
            pending: None,
            frames: 0,
            columns: features.iter().map(|f| Values::new(f.dtype)).collect(),
            distance: 0.0,
            last: None,
            time: 0.0,
        }
    }

    /// The time of the last sample, s.
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    /// The episode; `info` lacks but the distance and the ground.
    pub(crate) fn finish(mut self, info: EpisodeInfo) -> Episode {
        self.complete(Some(info.outcome == vb_score::Outcome::Success.name()));
        let ground = self.last.map(|[x, y, _]| self.ground.world.class_at(x, y).name().to_owned());
        let info = EpisodeInfo { distance_m: self.distance, ground: ground.unwrap_or_default(), ..info };
        Episode { info, frames: self.frames, columns: self.columns }
    }

    /// Writes the frame that waits; `end` says whether the episode ends with it, and whether at its goal.
    fn complete(&mut self, end: Option<bool>) {
        let Some(p) = self.pending.take() else { return };
        let (sum, count) = p.steering;
        let frame = Frame {
            ground: self.ground,
            state: &p.state,
            observation: &p.seen,
            goal: self.goal,
            given: &p.given,
            speed: p.speed,
            taken: p.taken,
            steering: if count == 0 { p.state.steering } else { sum / f64::from(count) },
            gear_after: p.gear,
            is_last: end.is_some(),
            succeeds: end == Some(true),
        };
        for (feature, column) in self.features.iter().zip(&mut self.columns) {
            feature.push(&frame, column);
        }
        self.frames += 1;
    }
}

/// Takes over what an observation has, and keeps the rest.
fn hold(seen: &mut Observation, new: &Observation) {
    let wheels = if new.wheels.is_empty() { std::mem::take(&mut seen.wheels) } else { new.wheels.clone() };
    *seen = Observation {
        pose: new.pose.or(seen.pose),
        wheels,
        gnss: new.gnss.or(seen.gnss),
        // These are large, and no column has them.
        imu: Vec::new(),
        lidar: None,
        depth: None,
        local_map: None,
        ..*new
    };
}

impl Witness for Recorder<'_> {
    fn step(&mut self, state: &VehicleState, observation: &Observation, given: &Command, taken: Controls) {
        hold(&mut self.seen, observation);
        if self.steps.is_multiple_of(self.every) {
            self.complete(None);
            let speed = given.debug.iter().find(|s| s.name == SPEED_SERIES).and_then(|s| s.values.first());
            self.pending = Some(Pending {
                state: state.clone(),
                seen: self.seen.clone(),
                given: Command { debug: Vec::new(), ..*given },
                taken,
                speed: speed.copied().map_or(0.0, f64::from),
                steering: (0.0, 0),
                gear: state.gear,
            });
        }
        self.steps += 1;
    }

    fn sample(&mut self, _: &Simulation, state: &VehicleState, sample: &Sample) {
        if let Some([x, y, z]) = self.last {
            let (dx, dy, dz) = (sample.x - x, sample.y - y, sample.z - z);
            self.distance += (dx * dx + dy * dy + dz * dz).sqrt();
        }
        self.time = sample.time;
        self.last = Some([sample.x, sample.y, sample.z]);
        if let Some(p) = &mut self.pending {
            p.steering = (p.steering.0 + state.steering, p.steering.1 + 1);
            p.gear = state.gear;
        }
    }
}
