//! Making datasets: episodes that many threads drive, written in order.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use vb_math::rng::Stream;
use vb_record::{LogMode, RunReader, Sample, TraceMode};
use vb_score::{Outcome, TaskRecord};
use vb_sdk::metadata::Need;
use vb_sdk::{Command, Observation};
use vb_sim::{Controls, SAMPLE_PERIOD, Simulation, VehicleState};
use vb_trial::{Cache, Driver, Keep, Place, Setting, TrialResult, Wants, Witness};
use vb_world::{Suite, Task, TaskId};

use crate::episode::{Ending, Episode, EpisodeInfo, Recorder};
use crate::error::DatasetError;
use crate::explore::{Exploration, Explorer, random_start};
use crate::feature::{Feature, Ground};
use crate::ordered::ordered;
use crate::playback::Playback;
use crate::writer::DatasetWriter;

/// Worlds that are kept in memory, beside those that threads use: episodes of exploration go from one world to the next.
const IN_MEMORY: usize = 24;
/// Starts that are tried where the simulation fails.
const STARTS: u64 = 20;

/// What is told while a dataset is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The drives until now, kept or not, with those of an earlier, interrupted command.
    pub drives: usize,
    /// The episodes until now.
    pub episodes: usize,
    /// The frames until now.
    pub frames: usize,
}

/// How a dataset is made.
pub struct Making<'a> {
    /// Everything but world, task and driver.
    pub setting: &'a Setting,
    /// The suite that the worlds are of.
    pub worlds: &'a Suite,
    /// Frames a second.
    pub hz: u32,
    /// Threads.
    pub jobs: usize,
    /// The stack of each thread, bytes; WASM planners run on it.
    pub stack_bytes: usize,
    /// Set to end it.
    pub cancel: &'a AtomicBool,
}

/// A planner that drives tasks for a dataset.
pub struct Planner<'a> {
    /// What it asks for.
    pub wants: Wants,
    /// Makes a driver for one drive.
    pub driver: Box<dyn Fn() -> Box<dyn Driver + 'a> + Sync + 'a>,
}

/// Refuses worlds that belong to a suite on which planners are judged, by their content.
///
/// # Errors
/// Returns [`DatasetError::SuiteWorld`] for the first such world.
pub fn keep_apart<'s>(
    worlds: &Suite,
    suites: impl IntoIterator<Item = &'s Suite>,
) -> Result<(), DatasetError> {
    for suite in suites {
        if let Some((own, theirs)) = worlds.common_world(suite) {
            let (suite, of) = (suite.meta().name.clone(), theirs.id.clone());
            return Err(DatasetError::SuiteWorld { world: own.id.clone(), suite, of });
        }
    }
    Ok(())
}

/// How much is explored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// So many episodes.
    Episodes(usize),
    /// As many episodes as have so many frames together.
    Frames(usize),
}

impl Amount {
    fn is_reached(self, writer: &DatasetWriter) -> bool {
        match self {
            Self::Episodes(n) => writer.episodes() >= n,
            Self::Frames(n) => writer.frames() >= n,
        }
    }
}

/// Which episodes of planners are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// All.
    All,
    /// Those that reach their goal.
    Success,
    /// Those that don't.
    Failure,
}

impl Kept {
    fn keeps(self, outcome: Outcome) -> bool {
        match self {
            Self::All => true,
            Self::Success => outcome == Outcome::Success,
            Self::Failure => outcome != Outcome::Success,
        }
    }
}

/// A world that episodes are driven in.
#[derive(Clone)]
struct Site {
    place: Place,
    ground: Arc<Ground>,
    hash: String,
}

/// The worlds in use.
struct Sites<'a> {
    making: &'a Making<'a>,
    loaded: Cache<Site>,
}

impl<'a> Sites<'a> {
    fn new(making: &'a Making<'a>) -> Self {
        Self { making, loaded: Cache::new(making.jobs + IN_MEMORY) }
    }

    fn site(&self, world: &str) -> Result<Site, DatasetError> {
        self.loaded.get(world, || {
            let Making { worlds, setting, .. } = self.making;
            let place = Place::load(worlds, world, setting.scale)?;
            let hash = worlds.world_info(world)?.sha256.clone();
            Ok(Site { ground: Arc::new(Ground::new(place.world.clone())), place, hash })
        })
    }
}

/// Two who look on.
struct Both<'a>(&'a mut dyn Witness, &'a mut dyn Witness);

impl Witness for Both<'_> {
    fn step(&mut self, state: &VehicleState, observation: &Observation, given: &Command, taken: Controls) {
        self.0.step(state, observation, given, taken);
        self.1.step(state, observation, given, taken);
    }

    fn sample(&mut self, sim: &Simulation, state: &VehicleState, sample: &Sample) {
        self.0.sample(sim, state, sample);
        self.1.sample(sim, state, sample);
    }
}

/// One drive that becomes an episode.
struct Drive<'a> {
    task: &'a Task,
    /// The task in its suite, if it is one's.
    name: Option<TaskId>,
    instruction: &'static str,
    index: usize,
    wants: &'a Wants,
    every: u64,
}

impl Making<'_> {
    /// Explores until there is enough, and adds the episodes in order. It returns false if it was cancelled.
    ///
    /// # Errors
    /// Returns an error if a world can't be read, has nowhere to start, or a file can't be written.
    pub fn explore(
        &self,
        writer: &mut DatasetWriter,
        rules: &Exploration,
        amount: Amount,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<bool, DatasetError> {
        let features = writer.features().to_vec();
        let period = 1.0 / f64::from(self.hz);
        let wants = Wants {
            name: format!("exploration {}", rules.name),
            control_period: period,
            needs: Need::DEFAULT.to_vec(),
            params: Vec::new(),
        };
        let sites = Sites::new(self);
        let make = |index: usize| {
            let episode = self.exploration(&sites, &features, rules, &wants, index);
            (!self.cancel.load(Ordering::Relaxed)).then_some(episode)
        };
        if amount.is_reached(writer) {
            return Ok(true);
        }
        self.gather(writer, make, progress, &|writer| amount.is_reached(writer))
    }

    /// Hands the episodes that are made to the writer, until it is enough. It returns false if it was cancelled.
    fn gather(
        &self,
        writer: &mut DatasetWriter,
        make: impl Fn(usize) -> Option<Result<Option<Episode>, DatasetError>> + Sync,
        progress: &mut dyn FnMut(Progress),
        is_enough: &dyn Fn(&DatasetWriter) -> bool,
    ) -> Result<bool, DatasetError> {
        let mut result = Ok(());
        let first = usize::try_from(writer.next_drive()).unwrap_or(usize::MAX);
        let take = |drive: usize, episode: Result<Option<Episode>, DatasetError>| {
            result = episode.and_then(|e| e.map_or(Ok(()), |e| writer.add(&e)));
            progress(Progress { drives: drive + 1, episodes: writer.episodes(), frames: writer.frames() });
            if result.is_err() || is_enough(writer) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        ordered(self.jobs, self.stack_bytes, first, make, take).map_err(DatasetError::Thread)?;
        result.map(|()| !self.cancel.load(Ordering::Relaxed))
    }

    /// The episode of exploration with this index, which depends on the settings and the index alone.
    fn exploration(
        &self,
        sites: &Sites<'_>,
        features: &[Feature],
        rules: &Exploration,
        wants: &Wants,
        index: usize,
    ) -> Result<Option<Episode>, DatasetError> {
        let worlds = self.worlds.worlds();
        // One after the other, so that all have as many episodes but for one.
        let world = &worlds[index % worlds.len()].id;
        let site = sites.site(world)?;
        let id = format!("e{index:06}");
        for attempt in 0..STARTS {
            let stream =
                |what: &str| Stream::new(self.setting.seed, &["explore", &id, &attempt.to_string(), what]);
            let size = [self.setting.vehicle.length, self.setting.vehicle.width];
            let Some(start) = random_start(&rules.start, &site.ground, size, &mut stream("start")) else {
                break;
            };
            let goal = [start.x, start.y];
            let task = Task { id: id.clone(), start, goal, path: vec![goal] };
            let mut driver = Explorer::new(rules, stream("commands"));
            let drive = Drive {
                task: &task,
                name: None,
                instruction: "Explore rough ground.",
                index,
                wants,
                every: 1,
            };
            match self.episode(&site, features, &drive, &mut driver)? {
                // A vehicle that can't be put there, or that the simulation loses, is put elsewhere.
                Some((_, Outcome::SimError | Outcome::HostError)) => {}
                Some((episode, _)) => return Ok(Some(episode)),
                None => return Ok(None),
            }
        }
        let vehicle = self.setting.vehicle.name.clone();
        Err(DatasetError::NoStart { world: world.clone(), vehicle })
    }

    /// Lets planners drive tasks, one planner after the other, and adds the episodes that are kept. It returns false if it was
    /// cancelled.
    ///
    /// # Errors
    /// Returns an error if a world can't be read, the frames don't fit a planner's steps, or a file can't be written.
    pub fn drive(
        &self,
        writer: &mut DatasetWriter,
        planners: &[Planner<'_>],
        tasks: &[TaskId],
        kept: Kept,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<bool, DatasetError> {
        let features = writer.features().to_vec();
        let mut every = Vec::new();
        for Planner { wants, .. } in planners {
            every.push(steps_of_a_frame(self.hz, &wants.name, wants.control_period)?);
        }
        let sites = Sites::new(self);
        let total = planners.len() * tasks.len();
        let make = |index: usize| {
            if index >= total || self.cancel.load(Ordering::Relaxed) {
                return None;
            }
            let planner = &planners[index / tasks.len()];
            let task = &tasks[index % tasks.len()];
            let every = every[index / tasks.len()];
            let episode = self.task(&sites, &features, (index, task), planner, every, kept);
            (!self.cancel.load(Ordering::Relaxed)).then_some(episode)
        };
        self.gather(writer, make, progress, &|_| false)
    }

    fn task(
        &self,
        sites: &Sites<'_>,
        features: &[Feature],
        (index, wanted): (usize, &TaskId),
        planner: &Planner<'_>,
        every: u64,
        kept: Kept,
    ) -> Result<Option<Episode>, DatasetError> {
        let site = sites.site(wanted.world())?;
        let Some(task) = site.place.world.task(wanted.task()) else { return Ok(None) };
        let (name, wants) = (Some(wanted.clone()), &planner.wants);
        let drive = Drive { task, name, instruction: "Drive to the goal.", index, wants, every };
        let mut driver = (planner.driver)();
        let episode = self.episode(&site, features, &drive, &mut *driver)?;
        // It would fail in all others alike.
        if let Some((episode, Outcome::PlannerError)) = &episode
            && episode.frames == 0
        {
            let reason = episode.info.reason.clone();
            return Err(DatasetError::Planner { task: wanted.clone(), reason });
        }
        Ok(episode.filter(|(_, outcome)| kept.keeps(*outcome)).map(|(episode, _)| episode))
    }

    /// Repeats the failures of a run by their recorded commands, and adds the last seconds of each. It returns false if it was
    /// cancelled.
    ///
    /// # Errors
    /// Returns an error if a trace can't be read, a trial doesn't come to its recorded end, or a file can't be written.
    pub fn failures_again(
        &self,
        writer: &mut DatasetWriter,
        run: &RunReader,
        records: &[TaskRecord],
        seconds: f64,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<bool, DatasetError> {
        let features = writer.features().to_vec();
        let header = run.header();
        let name = format!("planner {} {}", header.plugin.name, header.plugin.version);
        let wants = Wants {
            name: name.clone(),
            control_period: SAMPLE_PERIOD,
            needs: Need::DEFAULT.to_vec(),
            params: Vec::new(),
        };
        let every = steps_of_a_frame(self.hz, &name, SAMPLE_PERIOD)?;
        let frames = (seconds * self.setting.scale.sqrt() * f64::from(self.hz)).round() as usize;
        let sites = Sites::new(self);
        let again = |index: usize, record: &TaskRecord| {
            let site = sites.site(&record.world)?;
            let Some(task) = site.place.world.task(record.task.task()) else { return Ok(None) };
            let trace = run.trace(&record.task)?;
            let mut driver = Playback::new(name.clone(), &trace);
            let (instruction, task_name) = ("Drive to the goal.", Some(record.task.clone()));
            let drive = Drive { task, name: task_name, instruction, index, wants: &wants, every };
            let Some((episode, _)) = self.episode(&site, &features, &drive, &mut driver)? else {
                return Ok(None);
            };
            if episode.info.state_hash != record.state_hash {
                return Err(DatasetError::NotRepeated { task: record.task.clone() });
            }
            let mut clip = episode.tail(&features, frames);
            let from = (episode.frames - clip.frames) as f64 / f64::from(self.hz);
            clip.info.origin = format!("run of {}: {} from {from:.1} s", header.plugin.name, record.task);
            clip.info.state_hash = String::new();
            Ok(Some(clip))
        };
        let make = |index: usize| {
            let record = records.get(index)?;
            let clip = again(index, record);
            (!self.cancel.load(Ordering::Relaxed)).then_some(clip)
        };
        self.gather(writer, make, progress, &|_| false)
    }

    /// Lets somebody drive a task by hand while an onlooker looks on; the episode. If `cancel` is set, it ends as it is then,
    /// with [`Ending::ByDriver`].
    ///
    /// # Errors
    /// Returns an error if the world can't be read, or the frames don't fit the driver's steps.
    pub fn by_hand(
        &self,
        features: &[Feature],
        wanted: &TaskId,
        wants: &Wants,
        driver: &mut dyn Driver,
        onlooker: &mut dyn Witness,
        index: u64,
    ) -> Result<Option<Episode>, DatasetError> {
        let every = steps_of_a_frame(self.hz, &wants.name, wants.control_period)?;
        let sites = Sites::new(self);
        let site = sites.site(wanted.world())?;
        let Some(task) = site.place.world.task(wanted.task()) else { return Ok(None) };
        let instruction = "Drive to the goal.";
        let index = usize::try_from(index).unwrap_or(usize::MAX);
        let drive = Drive { task, name: Some(wanted.clone()), instruction, index, wants, every };
        let mut recorder = Recorder::new(features, &site.ground, task.goal, every);
        let mut both = Both(&mut recorder, onlooker);
        let keep = Keep { trace: TraceMode::None, logs: LogMode::default() };
        let name = driver.name();
        let driven = self.setting.drive(&site.place, task, wants, driver, &mut both, keep, self.cancel)?;
        let record = driven.map(|d| d.record);
        Ok(Some(self.recorded(recorder, &site, &drive, name, record)))
    }

    /// Lets a driver drive, and records it; `None` if it was cancelled.
    fn episode(
        &self,
        site: &Site,
        features: &[Feature],
        drive: &Drive<'_>,
        driver: &mut dyn Driver,
    ) -> Result<Option<(Episode, Outcome)>, DatasetError> {
        let Drive { task, wants, .. } = *drive;
        let mut recorder = Recorder::new(features, &site.ground, task.goal, drive.every);
        let keep = Keep { trace: TraceMode::None, logs: LogMode::default() };
        let name = driver.name();
        let driven =
            self.setting.drive(&site.place, task, wants, driver, &mut recorder, keep, self.cancel)?;
        let Some(TrialResult { record, .. }) = driven else { return Ok(None) };
        let outcome = record.outcome;
        Ok(Some((self.recorded(recorder, site, drive, name, Some(record)), outcome)))
    }

    /// The episode of a drive; without a record it was ended before the rules did.
    fn recorded(
        &self,
        recorder: Recorder<'_>,
        site: &Site,
        drive: &Drive<'_>,
        name: String,
        record: Option<TaskRecord>,
    ) -> Episode {
        let Drive { task, .. } = *drive;
        let world = &site.place.world;
        let cause = record.as_ref().and_then(|r| r.cause);
        let (outcome, reason, time_s, state_hash) = match record {
            Some(r) => (Ending::Decided(r.outcome), r.reason, r.time_s, r.state_hash),
            None => {
                let time = recorder.time();
                (Ending::ByDriver, format!("the driver ended it at {time:.2} s"), time, String::new())
            }
        };
        let start = [task.start.x, task.start.y, task.start.yaw];
        let info = EpisodeInfo {
            instruction: drive.instruction.to_owned(),
            drive: drive.index as u64,
            driver: name,
            world: world.id.clone(),
            world_hash: site.hash.clone(),
            task: drive.name.clone(),
            elevation: world.elevation,
            terrain: world.terrain,
            density: world.density,
            outcome,
            reason,
            time_s,
            start,
            goal: task.goal,
            state_hash,
            cause,
            ..EpisodeInfo::default()
        };
        recorder.finish(info)
    }
}

/// The number of a driver's steps for each frame.
pub(crate) fn steps_of_a_frame(hz: u32, driver: &str, period: f64) -> Result<u64, DatasetError> {
    let steps = 1.0 / (f64::from(hz) * period);
    if steps.round() >= 1.0 && (steps - steps.round()).abs() < 1e-6 {
        return Ok(steps.round() as u64);
    }
    let possible = (1.0 / period).floor().max(1.0).to_string();
    Err(DatasetError::Rate { hz, driver: driver.to_owned(), period, possible })
}
