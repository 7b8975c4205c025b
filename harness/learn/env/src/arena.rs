//! What environments of one kind share.

use std::path::PathBuf;
use std::sync::Arc;

use vb_catalog::Catalog;
use vb_record::{LogMode, TraceMode};
use vb_render::Painter;
use vb_score::Rules;
use vb_sdk::policy::{ActionKind, Layout, PARTS, Sight};
use vb_sim::{SAMPLE_PERIOD, Simulation};
use vb_trial::{Cache, Keep, Place, Setting, Trial, Wants, defaults};
use vb_world::{Suite, Task, TaskId};

use crate::{EnvError, Reward};

/// The side of the cells in which soil remembers ruts, at scale 1, m: that of the benchmark.
const SOIL_RESOLUTION: f64 = 0.1;
/// Worlds that are kept in memory: about 1 MB each.
const WORLDS: usize = 256;
/// Tasks whose vehicle is kept as it stands at the start: 20 to 200 kB each.
const STARTS: usize = 2048;

/// Worlds of which pictures can be taken without preparing them anew: about 5 MB each.
const PAINTERS: usize = 16;

/// How environments are made. Names are those of what comes with the harness, or paths of files.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The suite whose tasks are driven; `None` for training worlds.
    pub suite: Option<PathBuf>,
    /// The tasks, as a selector; `None` for all.
    pub tasks: Option<String>,
    /// The number of training worlds, from 1 to 1000; not used with a `suite`.
    pub worlds: u32,
    /// The seed of the training worlds, from 7000 to 7999.
    pub world_seed: u64,
    /// Suites of which no training world may be one, beside those that come with the harness.
    pub apart_from: Vec<PathBuf>,
    /// The vehicle: a name in `tasks/vehicles`, or the path of a file.
    pub vehicle: String,
    /// The soils of deformable ground: a name in `tasks/soils`, or the path of a file.
    pub soils: String,
    /// The perception profile: a name in `tasks/perception`, or the path of a file.
    pub perception: String,
    /// The rules by which episodes end: the name of a built-in profile, or the path of a file.
    pub rules: String,
    /// The factor on every length of the worlds; `None` for the scale that the vehicle is made for.
    pub scale: Option<f64>,
    /// The number of actions per simulated second, Hz: 100 divided by a whole number from 1 to 100.
    pub control_hz: f64,
    /// The time step of the simulation, s, as in `vb-harness run --time-step`. That of the benchmark is 0.001.
    pub time_step: f64,
    /// The parts of an observation, by their names in [`PARTS`].
    pub observation: Vec<String>,
    /// The sizes of the crops of maps and of the path in an observation.
    pub sight: Sight,
    /// The meaning and the range of each number of an action.
    pub action: ActionKind,
    /// The weights from which the reward of a step is computed.
    pub reward: Reward,
}

impl Options {
    /// The parts of an observation where none are named.
    pub const OBSERVATION: [&str; 5] = ["state", "goal", "path", "command", "height"];
}

impl Default for Options {
    fn default() -> Self {
        Self {
            suite: None,
            tasks: None,
            worlds: 18,
            world_seed: 7000,
            apart_from: Vec::new(),
            vehicle: defaults::VEHICLE.into(),
            soils: defaults::SOILS.into(),
            perception: defaults::PERCEPTION.into(),
            rules: defaults::RULES.into(),
            scale: None,
            control_hz: 10.0,
            time_step: defaults::TIME_STEP,
            observation: Self::OBSERVATION.map(str::to_owned).to_vec(),
            sight: Sight::default(),
            action: ActionKind::default(),
            reward: Reward::default(),
        }
    }
}

/// A task, ready to be driven: its world, and the vehicle as it stands at the start.
pub(crate) struct Start {
    pub(crate) name: TaskId,
    pub(crate) place: Place,
    pub(crate) task: Task,
    pub(crate) simulation: Simulation,
    /// What is told about the task, in a run with the setting's own seed.
    pub(crate) brief: Arc<vb_sdk::Task>,
}

/// What environments of one kind share: tasks, vehicle, observation, action, reward, and what was made of them before.
pub struct Arena {
    pub(crate) setting: Setting,
    pub(crate) wants: Wants,
    pub(crate) layout: Layout,
    pub(crate) action: ActionKind,
    pub(crate) reward: Reward,
    options: Options,
    suite: Suite,
    tasks: Vec<TaskId>,
    places: Cache<Place>,
    starts: Cache<Arc<Start>>,
    painters: Cache<Arc<Painter>>,
}

/// Nothing but the record is kept of an episode.
const KEEP: Keep = Keep { trace: TraceMode::None, logs: LogMode::None };

impl Arena {
    /// Makes what environments share. Training worlds that aren't there yet are drawn now, which takes about a second for each;
    /// `making` hears of it.
    ///
    /// # Errors
    /// Returns an error that names the option that is wrong.
    pub fn new(catalog: &Catalog, options: Options, making: &mut dyn FnMut()) -> Result<Self, EnvError> {
        let option = |option, value: String, problem: &str| EnvError::Option {
            option,
            value,
            problem: problem.to_owned(),
        };
        let period = 1.0 / options.control_hz;
        let samples = (period / SAMPLE_PERIOD).round();
        if !((1.0..=100.0).contains(&samples) && (samples * SAMPLE_PERIOD - period).abs() < 1e-9) {
            let problem = "must be 100 over a whole number from 1 to 100, e.g. 10, 20 or 50";
            return Err(option("control_hz", options.control_hz.to_string(), problem));
        }
        let step = options.time_step;
        if !vb_trial::is_time_step(step) {
            let problem =
                "must lie in 0.0001 to 0.005 s and divide 0.01 s, e.g. 0.001 (the benchmark's) or 0.002";
            return Err(option("time_step", step.to_string(), problem));
        }
        if let ActionKind::Speed { slowest, fastest } | ActionKind::Rate { slowest, fastest } = options.action
            && !(slowest < fastest && slowest >= -10.0 && fastest <= 30.0)
        {
            let problem = "must be two speeds, the lower first, from -10 to 30 m/s";
            return Err(option("speed_range", format!("({slowest}, {fastest})"), problem));
        }
        if options.suite.is_none() && !(1..=1000).contains(&options.worlds) {
            return Err(option("worlds", options.worlds.to_string(), "must lie in 1 to 1000"));
        }
        if let Some(name) = options.observation.iter().find(|n| PARTS.iter().all(|k| k.name != **n)) {
            let known = PARTS.map(|k| k.name).join(", ");
            return Err(option("observation", name.clone(), &format!("unknown part; parts: {known}")));
        }
        let rules = Rules::resolve(&options.rules)?;
        let vehicle = catalog.vehicle(&options.vehicle)?;
        let soils = catalog.soils(&options.soils, SOIL_RESOLUTION)?;
        let perception = catalog.perception(&options.perception)?;
        let scale = options.scale.unwrap_or(vehicle.spec.scale);
        let setting = Setting::new(&vehicle, &soils, &rules, &perception, options.time_step, scale, 0)?;
        let suite = match &options.suite {
            Some(dir) => catalog.open_suite(Some(dir))?,
            None => Self::training(catalog, &options, making)?,
        };
        let tasks = vb_catalog::select(&suite, options.tasks.as_deref())?;
        let Some(first) = tasks.first() else {
            return Err(option("tasks", options.tasks.unwrap_or_default(), "selects no task"));
        };
        let wants = Wants {
            name: "the environment".into(),
            control_period: period,
            needs: Layout::needs(&options.observation),
            params: Vec::new(),
        };
        // What a task of the first world comes with, all others come with too.
        let place = Place::load(&suite, first.world(), scale)?;
        let Some(task) = place.world.task(first.task()) else {
            return Err(option("tasks", first.to_string(), "is not in its world"));
        };
        let (_, brief) = setting.brief(&place, task, &wants)?;
        let layout =
            Layout::new(&options.observation, options.sight, &brief).map_err(EnvError::Observation)?;
        let places = Cache::new(WORLDS);
        let _ = places.get(first.world(), || Ok::<_, EnvError>(place));
        Ok(Self {
            setting,
            wants,
            layout,
            action: options.action,
            reward: options.reward.clone(),
            options,
            suite,
            tasks,
            places,
            starts: Cache::new(STARTS),
            painters: Cache::new(PAINTERS),
        })
    }

    /// Training worlds that no suite has.
    fn training(catalog: &Catalog, options: &Options, making: &mut dyn FnMut()) -> Result<Suite, EnvError> {
        let worlds = catalog.training(options.world_seed, options.worlds, making)?;
        for dir in catalog.suites()?.iter().chain(&options.apart_from) {
            let suite = Suite::open(dir)?;
            if let Some((own, theirs)) = worlds.common_world(&suite) {
                let (world, of) = (own.id.clone(), theirs.id.clone());
                return Err(EnvError::SuiteWorld { world, suite: suite.meta().name.clone(), of });
            }
        }
        Ok(worlds)
    }

    /// Whether it was made with the same options, so that an environment of one can go on in the other.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || self.options == other.options
    }

    /// A hash of the options, by which arenas of several processes are compared.
    pub(crate) fn options_hash(&self) -> String {
        vb_files::sha256(format!("{:?}", self.options).as_bytes())
    }

    /// The suite that the tasks are of.
    #[must_use]
    pub fn suite(&self) -> &Suite {
        &self.suite
    }

    /// The tasks, in the suite's order.
    #[must_use]
    pub fn tasks(&self) -> &[TaskId] {
        &self.tasks
    }

    /// The parts of an observation.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What an action means.
    #[must_use]
    pub fn action(&self) -> ActionKind {
        self.action
    }

    /// What a step is worth.
    #[must_use]
    pub fn reward(&self) -> &Reward {
        &self.reward
    }

    /// The setting of the trials.
    #[must_use]
    pub fn setting(&self) -> &Setting {
        &self.setting
    }

    /// The time between two actions, s.
    #[must_use]
    pub fn control_period(&self) -> f64 {
        self.wants.control_period
    }

    pub(crate) fn find(&self, task: &TaskId) -> Result<usize, EnvError> {
        self.tasks.iter().position(|t| t == task).ok_or_else(|| EnvError::NoTask {
            task: task.clone(),
            count: self.tasks.len(),
            first: self.tasks.iter().take(3).map(ToString::to_string).collect::<Vec<_>>().join(", "),
        })
    }

    /// A task with its vehicle at the start.
    pub(crate) fn start(&self, index: usize) -> Result<Arc<Start>, EnvError> {
        let name = &self.tasks[index];
        self.starts.get(name.as_str(), || {
            let load = || Place::load(&self.suite, name.world(), self.setting.scale);
            let place = self.places.get(name.world(), load)?;
            let task = place.world.task(name.task()).cloned().ok_or_else(|| EnvError::NoTask {
                task: name.clone(),
                count: self.tasks.len(),
                first: String::new(),
            })?;
            let (_, brief) = self.setting.brief(&place, &task, &self.wants)?;
            let trial = self.setting.trial(&place, &task, &brief, KEEP);
            let simulation =
                trial.simulation().map_err(|source| EnvError::Start { task: name.clone(), source })?;
            Ok(Arc::new(Start { name: name.clone(), place, task, simulation, brief: Arc::new(brief) }))
        })
    }

    /// What is told about a task in a run with this seed.
    pub(crate) fn brief(&self, start: &Start, seed: u64) -> Result<Arc<vb_sdk::Task>, EnvError> {
        if self.setting.perception.has_exact_maps() {
            return Ok(Arc::clone(&start.brief));
        }
        Ok(Arc::new(self.setting.brief_in(&start.place, &start.task, &self.wants, seed)?.1))
    }

    /// Who takes pictures in a world.
    pub(crate) fn painter(&self, start: &Start) -> Arc<Painter> {
        let world = &start.place.world;
        let make = || Ok::<_, std::convert::Infallible>(Arc::new(Painter::new(world, &self.setting.model)));
        match self.painters.get(&world.id, make) {
            Ok(painter) => painter,
            Err(never) => match never {},
        }
    }

    pub(crate) fn trial<'a>(&'a self, start: &'a Start, brief: &'a vb_sdk::Task) -> Trial<'a> {
        self.setting.trial(&start.place, &start.task, brief, KEEP)
    }
}
