//! One environment: an episode after another.

use std::ops::ControlFlow;
use std::sync::Arc;

use vb_math::hypot;
use vb_math::rng::Stream;
use vb_render::{Moment, Size, View};
use vb_score::{Outcome, TaskRecord};
use vb_sdk::path::{Follower, Path};
use vb_sdk::policy::{Actuator, Dimension, Observer, Row};
use vb_sdk::{Observation, Point2};
use vb_sim::{Diagnostics, SimError, VehicleState};
use vb_trial::Episode;
use vb_world::TaskId;

use crate::arena::Start;
use crate::drive_log::DriveLog;
use crate::reward::Measured;
use crate::{Arena, EnvError, TERMS, Terms};

/// How far ahead of its progress along the path the vehicle is looked for, m at scale 1.
const WINDOW: f64 = 8.0;

/// What an episode begins with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reset {
    /// The seed of all that is random from now on; `None` to go on with the numbers of the last one.
    pub seed: Option<u64>,
    /// The task, e.g. `w001/t03`; `None` for one that is drawn.
    pub task: Option<TaskId>,
    /// The seed of the sensors' noise, that of a run (`vb-harness run --seed`); `None` for one that is drawn.
    pub run_seed: Option<u64>,
}

/// What a step came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// The sum of `terms`.
    pub reward: f64,
    /// The value of each of [`TERMS`], multiplied by its weight.
    pub terms: Terms,
    /// Whether the episode has ended by what the vehicle did: success, rollover, stuck, out of bounds.
    pub terminated: bool,
    /// Whether the episode has ended by something else: time ran out, or the simulation failed.
    pub truncated: bool,
}

/// An environment: drives one episode after another, of tasks of its arena.
pub struct Env {
    arena: Arc<Arena>,
    draws: Stream,
    running: Option<Running>,
}

/// An environment as it was at some time. It goes on exactly as the environment did.
#[derive(Clone)]
pub struct Snapshot {
    arena: Arc<Arena>,
    draws: Stream,
    running: Option<Running>,
}

/// An episode that was begun.
#[derive(Clone)]
struct Running {
    start: Arc<Start>,
    brief: Arc<vb_sdk::Task>,
    run_seed: u64,
    episode: Episode,
    observer: Observer,
    actuator: Actuator,
    observation: Observation,
    /// Where the vehicle is in truth, for the reward.
    follower: Follower,
    goal_distance: f64,
    steering: f64,
    time: f64,
    /// Steps of the simulation in which the contacts of the hull were solved, in the last step.
    contact_steps: u64,
    /// All actions until now, one after another.
    actions: Vec<f64>,
    /// The way until now, m: the place at the start and after each step.
    way: Vec<[f32; 3]>,
    /// How far each wheel has turned until now, rad, for pictures.
    turned: Vec<f64>,
    /// Actions until now that were out of range and were limited to it.
    clipped: u64,
    record: Option<Box<TaskRecord>>,
}

impl Env {
    /// An environment of an arena, whose numbers are drawn by this seed until another is given.
    #[must_use]
    pub fn new(arena: Arc<Arena>, seed: u64) -> Self {
        Self { arena, draws: draws(seed), running: None }
    }

    /// The arena, which other environments may share.
    #[must_use]
    pub fn arena(&self) -> &Arc<Arena> {
        &self.arena
    }

    /// Begins an episode.
    ///
    /// # Errors
    /// Returns an error if there is no such task, or it can't be begun; the last episode goes on then. A drawn task that can't be
    /// begun isn't drawn again: the next reset goes on with the numbers that follow.
    pub fn reset(&mut self, reset: &Reset) -> Result<(), EnvError> {
        let fixed = reset.task.as_ref().map(|task| self.arena.find(task)).transpose()?;
        let mut stream = reset.seed.map_or_else(|| self.draws.clone(), draws);
        // Both are drawn whether they are used or not, so that later episodes stay the same.
        let drawn = stream.below(self.arena.tasks().len() as u64) as usize;
        // Below 2^63: gymnasium puts whole numbers into arrays of signed ones.
        let noise = stream.next_u64() >> 1;
        let (index, run_seed) = (fixed.unwrap_or(drawn), reset.run_seed.unwrap_or(noise));
        let running = Running::new(&self.arena, index, run_seed);
        if running.is_ok() || fixed.is_none() {
            self.draws = stream;
        }
        self.running = Some(running?);
        Ok(())
    }

    /// Drives on with an action until the next is due, or the episode ends.
    ///
    /// # Errors
    /// Returns an error if there is no episode or it has ended, and if the action isn't made of as many finite numbers as an
    /// action has; the episode stays as it was then.
    pub fn step(&mut self, action: &[f64]) -> Result<Step, EnvError> {
        let arena = Arc::clone(&self.arena);
        let running = self.running.as_mut().ok_or(EnvError::NoEpisode)?;
        if let Some(record) = &running.record {
            return Err(EnvError::Ended(record.reason.clone()));
        }
        let dimensions = arena.action().dimensions();
        if action.len() != dimensions.len() {
            let names = dimensions.iter().map(|d| d.name).collect::<Vec<_>>().join(", ");
            return Err(EnvError::ActionLength { wanted: dimensions.len(), names, given: action.len() });
        }
        if let Some(index) = action.iter().position(|a| !a.is_finite()) {
            return Err(EnvError::Action { index, name: dimensions[index].name, value: action[index] });
        }
        Ok(running.step(&arena, action))
    }

    /// Writes a part of the observation, in the order of [`vb_sdk::policy::Layout::parts`]. Without an episode nothing is
    /// written.
    pub fn observe(&self, part: usize, row: Row<'_>) {
        if let (Some(running), Some(part)) = (&self.running, self.arena.layout().parts().get(part)) {
            running.observer.fill(&running.brief, part, row);
        }
    }

    /// Writes the flat observation ([`Observer::flat`]). Without an episode nothing is written.
    pub fn observe_flat(&self, to: &mut [f32]) {
        if let Some(running) = &self.running {
            running.observer.flat(&running.brief, self.arena.layout(), to);
        }
    }

    /// The name of the task; `None` before the first episode.
    #[must_use]
    pub fn task(&self) -> Option<&TaskId> {
        self.running.as_ref().map(|r| &r.start.name)
    }

    /// The seed of the sensors' noise; `None` before the first episode.
    #[must_use]
    pub fn run_seed(&self) -> Option<u64> {
        self.running.as_ref().map(|r| r.run_seed)
    }

    /// What is told about the task: maps, path, vehicle.
    #[must_use]
    pub fn brief(&self) -> Option<&Arc<vb_sdk::Task>> {
        self.running.as_ref().map(|r| &r.brief)
    }

    /// The true state of the vehicle; `None` before the first episode.
    #[must_use]
    pub fn vehicle(&self) -> Option<VehicleState> {
        self.running.as_ref().map(|r| r.episode.simulation().state())
    }

    /// Counts and maxima of the simulation since the start of the episode; `None` before the first episode.
    #[must_use]
    pub fn diagnostics(&self) -> Option<Diagnostics> {
        self.running.as_ref().map(|r| r.episode.simulation().diagnostics())
    }

    /// The steps of the simulation in which the contacts of the hull were solved, in the last step of the environment. Each takes
    /// several times as long as one without.
    pub(crate) fn contact_steps(&self) -> u64 {
        self.running.as_ref().map_or(0, |r| r.contact_steps)
    }

    /// A picture of the episode as it is now: rows of pixels from the top, each of red, green and blue.
    ///
    /// # Errors
    /// Returns an error without an episode, and for a size or a window that a picture can't have.
    pub fn picture(&self, view: View, size: Size) -> Result<Vec<u8>, EnvError> {
        let running = self.running.as_ref().ok_or(EnvError::NoEpisode)?;
        let sim = running.episode.simulation();
        let path: Vec<[f64; 2]> = running.brief.path.iter().map(|p| [p.x, p.y]).collect();
        let trail: Vec<[f64; 3]> = running.way.iter().map(|p| p.map(f64::from)).collect();
        let grains: Vec<([f64; 3], f64)> = sim.grains().collect();
        let moment = Moment {
            state: &sim.state(),
            turned: &running.turned,
            goal: running.brief.goal.into(),
            goal_radius: running.brief.goal_radius,
            path: &path,
            trail: &trail,
            change: Some(&|x, y| sim.soil_change(x, y)),
            grains: &grains,
            colour: None,
        };
        Ok(self.arena.painter(&running.start).picture(view, size, &moment)?)
    }

    /// The record of the episode, as runs have it; `None` until the episode has ended.
    #[must_use]
    pub fn record(&self) -> Option<&TaskRecord> {
        self.running.as_ref()?.record.as_deref()
    }

    /// A copy of the environment with its episode, for [`Self::restore`].
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let (arena, draws) = (Arc::clone(&self.arena), self.draws.clone());
        Snapshot { arena, draws, running: self.running.clone() }
    }

    /// Goes back to how an environment was that was made with the same options.
    ///
    /// # Errors
    /// Returns an error, and changes nothing, if it was made with others, or had no episode yet.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), EnvError> {
        if !snapshot.arena.is_like(&self.arena) {
            return Err(EnvError::Unlike);
        }
        let Snapshot { draws, running: running @ Some(_), .. } = snapshot.clone() else {
            return Err(EnvError::NoEpisode);
        };
        (self.draws, self.running) = (draws, running);
        Ok(())
    }

    /// Restores a serialized snapshot ([`Snapshot::to_bytes`]): resets to its task and replays its actions, which takes as long as
    /// simulating them did.
    ///
    /// # Errors
    /// Returns an error, and changes nothing, if the bytes are no snapshot, or one of an environment that was made with other
    /// options, and if the drive doesn't come to the same state, as after a change of the suite.
    pub fn restore_from(&mut self, bytes: &[u8]) -> Result<(), EnvError> {
        let log = DriveLog::from_bytes(bytes)?;
        if log.options != self.arena.options_hash() {
            return Err(EnvError::Unlike);
        }
        let (key, words) = log.draws;
        let mut reached = Self::new(Arc::clone(&self.arena), 0);
        reached.reset(&Reset { seed: None, task: Some(log.task.clone()), run_seed: Some(log.run_seed) })?;
        for action in log.actions.chunks(self.arena.action().dimensions().len()) {
            reached.step(action)?;
        }
        let is_there = |r: &Running| r.episode.state_hash().value() == log.state_hash;
        if !reached.running.as_ref().is_some_and(is_there) {
            return Err(EnvError::Elsewhere { task: log.task });
        }
        self.draws = Stream::at_position(key, u128::from(words));
        self.running = reached.running;
        Ok(())
    }
}

impl Snapshot {
    /// Serializes the snapshot as task, seed and actions, which [`Env::restore_from`] replays.
    ///
    /// # Errors
    /// Returns an error if there is no episode.
    pub fn to_bytes(&self) -> Result<Vec<u8>, EnvError> {
        let running = self.running.as_ref().ok_or(EnvError::NoEpisode)?;
        let (key, words) = self.draws.position();
        let log = DriveLog {
            options: self.arena.options_hash(),
            task: running.start.name.clone(),
            run_seed: running.run_seed,
            draws: (key, words as u64),
            actions: running.actions.clone(),
            state_hash: running.episode.state_hash().value(),
        };
        Ok(log.to_bytes())
    }
}

/// The stream that tasks and noise are drawn from.
fn draws(seed: u64) -> Stream {
    Stream::new(seed, &["env"])
}

impl Running {
    fn new(arena: &Arena, index: usize, run_seed: u64) -> Result<Self, EnvError> {
        let start = arena.start(index)?;
        let brief = arena.brief(&start, run_seed)?;
        let perception = arena.setting.perception(&start.place, &start.task, &arena.wants, run_seed)?;
        let trial = arena.trial(&start, &brief);
        let mut episode = Episode::new(&trial, start.simulation.clone(), perception);
        let begun = episode.begin(&mut ());
        let record = begun.is_break().then(|| Box::new(trial.result_of(&episode, None).record));
        let observation = episode.observe();
        let mut observer = Observer::new(&brief, arena.layout()).map_err(EnvError::Observation)?;
        observer.look(&observation);
        let mut points = brief.path.clone();
        points.push(brief.goal);
        let path = Path::new(&points).map_err(EnvError::Observation)?;
        let mut follower = Follower::new(path, WINDOW * brief.vehicle.scale);
        let at = episode.simulation().state().position;
        follower.update(at.x, at.y);
        Ok(Self {
            goal_distance: distance(brief.goal, at.x, at.y),
            actuator: Actuator::new(arena.action(), &brief),
            contact_steps: 0,
            actions: Vec::new(),
            way: vec![[at.x as f32, at.y as f32, at.z as f32]],
            turned: Vec::new(),
            steering: 0.0,
            time: 0.0,
            start,
            brief,
            run_seed,
            episode,
            observer,
            observation,
            follower,
            clipped: 0,
            record,
        })
    }

    fn step(&mut self, arena: &Arena, action: &[f64]) -> Step {
        self.actions.extend_from_slice(action);
        let outside = |(value, range): (&f64, &Dimension)| *value < range.low || *value > range.high;
        self.clipped += u64::from(action.iter().zip(arena.action().dimensions()).any(outside));
        let command = self.actuator.command(action, &self.observation);
        let taken = self.episode.command(&command);
        let contact_steps = self.episode.simulation().contact_steps();
        let ended = match self.episode.advance(&mut ()) {
            Ok(ControlFlow::Continue(())) => None,
            Ok(ControlFlow::Break(())) => Some(None),
            Err(e) => Some(Some(e)),
        };
        self.contact_steps = self.episode.simulation().contact_steps() - contact_steps;
        let outcome = ended.map(|error| self.end(arena, error));
        let state = self.episode.simulation().state();
        let at = state.position;
        self.way.push([at.x as f32, at.y as f32, at.z as f32]);
        // The last observation of an episode is answered by nobody, so it is in no record.
        self.observation = self.episode.observe();
        self.observer.look(&self.observation);

        let (scale, before) = (self.brief.vehicle.scale, self.follower.arc());
        let progress = self.follower.update(at.x, at.y).arc - before;
        let goal_distance = distance(self.brief.goal, at.x, at.y);
        let (roll, pitch, _) = state.roll_pitch_yaw();
        let measured = Measured {
            progress: progress / scale,
            approach: (self.goal_distance - goal_distance) / scale,
            time: (state.time - self.time) / scale.sqrt(),
            roll,
            pitch,
            steering: taken.steering - self.steering,
            end: outcome,
        };
        self.turned.resize(state.wheels.len(), 0.0);
        for (turned, wheel) in self.turned.iter_mut().zip(&state.wheels) {
            *turned += wheel.speed * (state.time - self.time);
        }
        (self.goal_distance, self.steering, self.time) = (goal_distance, taken.steering, state.time);
        let mut terms = arena.reward().terms(&measured);
        // The state of a simulation that has failed may be anything.
        for (term, worth) in TERMS.iter().zip(&mut terms) {
            if !worth.is_finite()
                || (outcome == Some(Outcome::SimError) && !term.is_of_end(Outcome::SimError))
            {
                *worth = 0.0;
            }
        }
        let is_truncated = |o: Outcome| matches!(o, Outcome::Timeout | Outcome::SimError);
        Step {
            reward: terms.iter().sum(),
            terms,
            terminated: outcome.is_some_and(|o| !is_truncated(o)),
            truncated: outcome.is_some_and(is_truncated),
        }
    }

    /// Puts the record away.
    fn end(&mut self, arena: &Arena, error: Option<SimError>) -> Outcome {
        let trial = arena.trial(&self.start, &self.brief);
        let mut record = trial.result_of(&self.episode, error.as_ref()).record;
        // The actuator has limited them before the episode saw them.
        record.clamped += self.clipped;
        self.record.insert(Box::new(record)).outcome
    }
}

fn distance(goal: Point2, x: f64, y: f64) -> f64 {
    hypot(goal.x - x, goal.y - y)
}
