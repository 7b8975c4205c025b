//! An episode: what was recorded of one drive.

use serde::de::IntoDeserializer as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vb_record::Sample;
use vb_score::{Cause, Outcome};
use vb_sdk::{Command, Observation};
use vb_sim::{Controls, Gear, Simulation, VehicleState};
use vb_trial::Witness;
use vb_world::{Density, Elevation, TaskId, Terrain, TerrainClass};

use crate::feature::{Feature, Frame, Ground, Values};
use crate::values::shown;

/// The greatest length, coordinate or time that an episode may have, m or s.
const FARTHEST: f64 = 1e9;

/// The end of an episode, as text the name of the outcome or `ended`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The rules decided.
    Decided(Outcome),
    /// The driver ended it before the rules decided.
    ByDriver,
}

impl Ending {
    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Decided(outcome) => outcome.name(),
            Self::ByDriver => "ended",
        }
    }
}

impl Serialize for Ending {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Ending {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        if text == Self::ByDriver.name() {
            return Ok(Self::ByDriver);
        }
        Outcome::deserialize(text.into_deserializer()).map(Self::Decided)
    }
}

/// An absent value as empty text, because a column of texts has no other.
mod or_empty {
    use serde::de::IntoDeserializer as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<T: Serialize, S: Serializer>(
        value: &Option<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        match value {
            Some(value) => value.serialize(to),
            None => to.serialize_str(""),
        }
    }

    pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<T>, D::Error> {
        let text = String::deserialize(from)?;
        (!text.is_empty()).then(|| T::deserialize(text.into_deserializer())).transpose()
    }
}

/// What is said of an episode as a whole. Each field is a column of `meta/episodes`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// The task in the suite; absent for exploration.
    #[serde(with = "or_empty")]
    pub task: Option<TaskId>,
    /// The level of the world's relief.
    pub elevation: Elevation,
    /// The kind of the world's ground.
    pub terrain: Terrain,
    /// The density of the world's obstacles.
    pub density: Density,
    /// The kind of ground under the vehicle at the end; absent without a sample.
    #[serde(with = "or_empty")]
    pub ground: Option<TerrainClass>,
    /// The outcome by the rules, as runs have it, or that there is none.
    pub outcome: Ending,
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
    /// The cause of a rollover, or of getting stuck.
    #[serde(with = "or_empty")]
    pub cause: Option<Cause>,
}

impl Default for EpisodeInfo {
    /// An episode of no drive, in a world of the first levels.
    fn default() -> Self {
        Self {
            instruction: String::new(),
            drive: 0,
            driver: String::new(),
            world: String::new(),
            world_hash: String::new(),
            task: None,
            elevation: Elevation::Low,
            terrain: Terrain::Rigid,
            density: Density::Sparse,
            ground: None,
            outcome: Ending::ByDriver,
            reason: String::new(),
            time_s: 0.0,
            distance_m: 0.0,
            start: [0.0; 3],
            goal: [0.0; 2],
            state_hash: String::new(),
            origin: String::new(),
            cause: None,
        }
    }
}

impl EpisodeInfo {
    /// The first field with a value that no episode can have: the field, the value, and what is allowed. `None` if there is none.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let within = |field: &str, values: &[f64], low: f64, high: f64| {
            let odd = values.iter().find(|v| !(low..=high).contains(*v))?;
            Some(format!("{field}: {} must lie in {} to {}", shown(*odd), shown(low), shown(high)))
        };
        within("time_s", &[self.time_s], 0.0, FARTHEST)
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
        self.complete(Some(info.outcome == Ending::Decided(Outcome::Success)));
        let ground = self.last.map(|[x, y, _]| self.ground.world.class_at(x, y));
        let info = EpisodeInfo { distance_m: self.distance, ground, ..info };
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
