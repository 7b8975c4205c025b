//! A run: many trials on worker threads, each recorded as it ends.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use vb_files::lock;
use vb_host::{Metadata, Plugin};
use vb_record::{
    DataHeader, LogMode, PluginHeader, RUN_SCHEMA, RulesHeader, RunHeader, RunStore, SandboxHeader,
    ShardHeader, SuiteHeader, TraceMode,
};
use vb_score::{Outcome, Rules, Summary, TaskRecord};
use vb_sense::Profile;
use vb_sim::{SAMPLE_PERIOD, SimOptions, Soils};
use vb_trial::{Cache, Keep, Place, Setting, TrialError, TrialResult, Wants};
use vb_vehicle::Vehicle;
use vb_world::{Suite, SuiteError, TaskId};

use crate::fail_fast::{FailFast, FailedStart};
use crate::recording::recorded_kind;
use crate::{PluginDriver, RunError, recording, wants};

/// The configuration of a run: everything that decides its results, and how it is made.
#[derive(Clone, Debug)]
pub struct RunConfig {
    /// The suite of the tasks.
    pub suite: Suite,
    /// The tasks to run, in this order.
    pub tasks: Vec<TaskId>,
    /// The selector that chose the tasks, for the record.
    pub selector: Option<String>,
    /// Which shard of a larger run the tasks are, if they are one.
    pub shard: Option<ShardHeader>,
    /// The planner.
    pub plugin: Plugin,
    /// The path of the planner's file, for the record.
    pub plugin_path: PathBuf,
    /// The planner's parameters as the user gave them.
    pub params: Vec<(String, String)>,
    pub vehicle: Vehicle,
    /// The soils of deformable ground.
    pub soils: Soils,
    /// What the planner is told of the world and of its vehicle, and how wrong that is.
    pub perception: Profile,
    pub rules: Rules,
    /// The time step of the simulation, s. [`SAMPLE_PERIOD`] is a whole number of steps.
    pub time_step: f64,
    /// The factor on every length of the worlds.
    pub scale: f64,
    /// The run's seed.
    pub seed: u64,
    /// The number of worker threads, at least 1.
    pub jobs: usize,
    /// The samples that are kept in traces.
    pub trace: TraceMode,
    /// The tasks whose records keep the planner's log.
    pub logs: LogMode,
    /// The run directory.
    pub out: PathBuf,
    /// Whether to go on with an interrupted run in `out`.
    pub resume: bool,
    /// Whether to drive all tasks even if the planner fails alike, or the simulation fails, in all of the first ones
    /// ([`FailedStart`]).
    pub keep_going: bool,
    /// The time at which the run was started, RFC 3339, for the record.
    pub started_at: String,
    /// The version of the harness, for the record.
    pub harness_version: String,
    /// The Git commit that the harness was built from, for the record ([`RunHeader::harness_commit`]).
    pub harness_commit: String,
}

/// An event of a run.
#[derive(Clone, Debug)]
pub enum Event {
    /// The run directory is ready.
    Started {
        /// The number of tasks of the run.
        total: usize,
        /// The records of the tasks that an earlier, interrupted run has done.
        resumed: Vec<TaskRecord>,
    },
    /// A worker has taken a task.
    TaskStarted {
        /// The name of the task.
        task: TaskId,
    },
    /// A task is done and its record is on disk.
    TaskEnded(Box<TaskRecord>),
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// The summary of the tasks that are done.
    pub summary: Summary,
    /// Whether the run was cancelled before all tasks were done.
    pub interrupted: bool,
    /// The reason why the run was ended early, if it was.
    pub failed_start: Option<FailedStart>,
}

/// How often it is looked whether a run is cancelled.
const LOOK: Duration = Duration::from_millis(50);
/// So many looks a worker has to end by itself when the run is cancelled: half a second.
const LOOKS: u32 = 10;

/// Runs what `config` says, telling `on_event` what happens. Setting `cancel` ends the run within a second: tasks in flight
/// are given up, all others are on disk. A planner in the midst of a long step isn't waited for: its thread ends with the
/// step, or with the program. If the planner fails alike in all of the first tasks, before its first command, or the simulation
/// fails in all of them, no further ones are started.
///
/// # Errors
/// Returns an error if something is wrong with the inputs (nothing is written then), or the run directory can't be
/// written.
pub fn run(
    config: &RunConfig,
    on_event: &mut dyn FnMut(Event),
    cancel: &AtomicBool,
) -> Result<RunReport, RunError> {
    let prepared = prepare(config)?;
    let header = header(config, prepared.setting.options);
    recording::check(&config.plugin, &header)?;
    let (store, mut records) = if config.resume {
        RunStore::resume(&config.out, &header, |r: &TaskRecord| r.outcome != Outcome::HostError)?
    } else {
        (RunStore::create(&config.out, &header)?, Vec::new())
    };
    // It would count as done, and its figures would be in the summary.
    let chosen: BTreeSet<&TaskId> = config.tasks.iter().collect();
    if let Some(foreign) = records.iter().find(|r| !chosen.contains(&r.task)) {
        return Err(RunError::ForeignTask { dir: config.out.clone(), task: foreign.task.clone() });
    }
    on_event(Event::Started { total: config.tasks.len(), resumed: records.clone() });
    let done: BTreeSet<&TaskId> = records.iter().map(|r| &r.task).collect();
    let open: Vec<TaskId> = config.tasks.iter().filter(|t| !done.contains(t)).cloned().collect();

    let work = Arc::new(Work {
        config: config.clone(),
        prepared,
        open,
        next: AtomicUsize::new(0),
        places: Cache::new(config.jobs),
        stop: AtomicBool::new(false),
        fail_fast: Mutex::default(),
        cancel: AtomicBool::new(false),
    });
    let mut failure = None;
    let (sender, receiver) = mpsc::channel();
    let mut workers = Vec::new();
    for _ in 0..config.jobs.clamp(1, work.open.len().max(1)) {
        let (sender, work) = (sender.clone(), Arc::clone(&work));
        // The WASM code runs on the thread's own stack.
        let stack = config.plugin.limits().thread_stack_bytes();
        let thread = std::thread::Builder::new().stack_size(stack);
        let stop = Arc::clone(&work);
        match thread.spawn(move || work.work(&sender)) {
            Ok(worker) => workers.push(worker),
            Err(source) => {
                stop.stop.store(true, Ordering::Relaxed);
                failure.get_or_insert(RunError::Thread(source));
            }
        }
    }
    drop(sender);
    let mut looks = 0;
    while looks < LOOKS {
        let outcome = match receiver.recv_timeout(LOOK) {
            Ok(Message::Started(task)) => {
                on_event(Event::TaskStarted { task });
                Ok(())
            }
            Ok(Message::Ended(result)) => keep(&store, &result).map(|()| {
                records.push(result.record.clone());
                on_event(Event::TaskEnded(Box::new(result.record)));
            }),
            Ok(Message::Failed(error)) => Err(error),
            Err(mpsc::RecvTimeoutError::Timeout) => {
                looks += u32::from(cancel.load(Ordering::Relaxed));
                Ok(())
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
        };
        if cancel.load(Ordering::Relaxed) {
            work.cancel.store(true, Ordering::Relaxed);
        }
        if let Err(error) = outcome {
            work.stop.store(true, Ordering::Relaxed);
            failure.get_or_insert(error);
        }
    }
    for worker in workers.into_iter().filter(std::thread::JoinHandle::is_finished) {
        if let Err(panic) = worker.join() {
            std::panic::resume_unwind(panic);
        }
    }
    if let Some(error) = failure {
        return Err(error);
    }
    let summary = Summary::new(&header, &config.rules, &records, Vec::new());
    if records.len() == config.tasks.len() {
        store.finish_whole(&config.tasks, &summary)?;
    } else {
        store.finish(&summary)?;
    }
    let mut fail_fast = lock(&work.fail_fast);
    let failed_start = std::mem::take(&mut *fail_fast).found();
    let interrupted = failed_start.is_none() && records.len() < config.tasks.len();
    Ok(RunReport { summary, interrupted, failed_start })
}

/// Puts a result on disk, the record last: a task that is done has its trace.
fn keep(store: &RunStore, result: &TrialResult) -> Result<(), RunError> {
    if let Some(trace) = &result.trace {
        store.write_trace(trace)?;
        store.write_debug(&result.record.task, &result.debug)?;
    }
    Ok(store.append(&result.record)?)
}

/// What all trials of a run share.
struct Prepared {
    setting: Setting,
    wants: Wants,
}

/// Checks what would keep a run from being begun, but for the worlds and the run directory: task, planner, parameters, vehicle.
///
/// # Errors
/// Returns what is wrong.
pub fn check(config: &RunConfig) -> Result<(), RunError> {
    let prepared = setting(config)?;
    recording::check(&config.plugin, &header(config, prepared.setting.options))
}

fn prepare(config: &RunConfig) -> Result<Prepared, RunError> {
    let prepared = setting(config)?;
    // A damaged world must not be found after hours.
    let worlds: BTreeSet<&str> = config.tasks.iter().map(|t| t.world()).collect();
    for world in worlds {
        config.suite.verify_world(world)?;
        if config.suite.has_beds(world) {
            prepared.setting.check_beds(&config.suite.load_world(world)?)?;
        }
    }
    Ok(prepared)
}

fn setting(config: &RunConfig) -> Result<Prepared, RunError> {
    // A shard may be empty: there may be more of them than worlds.
    if config.tasks.is_empty() && config.shard.is_none() {
        return Err(RunError::NoTasks);
    }
    let RunConfig { vehicle, soils, rules, perception, .. } = config;
    check_control_period(config.plugin.metadata(), config.time_step)?;
    check_perception(&config.plugin, perception)?;
    let params = config.plugin.params(&config.params)?;
    let (step, scale, seed) = (config.time_step, config.scale, config.seed);
    let mut setting = Setting::new(vehicle, soils, rules, perception, step, scale, seed)?;
    for departure in config.plugin.departures() {
        if !setting.departures.contains(&departure) {
            setting.departures.push(departure);
        }
    }
    Ok(Prepared { setting, wants: wants(&config.plugin, perception, params) })
}

/// Checks whether a planner can drive under a profile.
///
/// # Errors
/// Returns an error if it asks for what the profile doesn't offer.
pub fn check_perception(plugin: &Plugin, profile: &Profile) -> Result<(), RunError> {
    let metadata = plugin.metadata();
    vb_sense::check_needs(profile, &profile.sensors_of(metadata))
        .map_err(|source| TrialError::Perception { planner: metadata.name.clone(), source })?;
    Ok(())
}

/// Checks whether a planner's control period is a whole number of steps of the simulation, each `step` seconds long.
///
/// # Errors
/// Returns [`RunError::ControlPeriod`] if it isn't.
pub fn check_control_period(metadata: &Metadata, step: f64) -> Result<(), RunError> {
    let period = metadata.control_period;
    let steps = (period / step).round();
    if steps >= 1.0 && (steps * step - period).abs() < 1e-9 {
        return Ok(());
    }
    Err(RunError::ControlPeriod { planner: metadata.name.clone(), period, step })
}

fn header(config: &RunConfig, options: SimOptions) -> RunHeader {
    let metadata = config.plugin.metadata();
    let limits = config.plugin.limits();
    RunHeader {
        schema: RUN_SCHEMA,
        harness_version: config.harness_version.clone(),
        harness_commit: config.harness_commit.clone(),
        started_at: config.started_at.clone(),
        suite: SuiteHeader {
            name: config.suite.meta().name.clone(),
            hash: config.suite.hash(),
            path: config.suite.dir().display().to_string(),
            tasks: config.suite.task_count() as u64,
        },
        selector: config.selector.clone(),
        tasks: config.tasks.len() as u64,
        shard: config.shard,
        plugin: PluginHeader {
            name: metadata.name.clone(),
            version: metadata.version.clone(),
            sha256: config.plugin.sha256().to_owned(),
            kind: recorded_kind(config.plugin.kind()),
            path: config.plugin_path.display().to_string(),
            control_period: metadata.control_period,
            sensors: config.perception.sensors_of(metadata).iter().map(ToString::to_string).collect(),
            eligible_for_ranking: config.plugin.kind().is_eligible(),
            sandbox: config.plugin.sandbox().map(|s| SandboxHeader {
                landlock: s.landlock,
                seccomp: s.seccomp,
                no_new_privs: s.no_new_privs,
                rlimits: s.rlimits,
            }),
        },
        params: config.params.iter().cloned().collect(),
        vehicle: DataHeader { name: config.vehicle.spec.name.clone(), hash: config.vehicle.hash.clone() },
        soils: DataHeader { name: config.soils.set.name.clone(), hash: config.soils.hash.clone() },
        perception: DataHeader {
            name: config.perception.name().to_owned(),
            hash: config.perception.sha256().to_owned(),
        },
        scale: config.scale,
        seed: config.seed,
        time_step: options.step,
        soil_resolution: options.soil_resolution,
        sample_period: SAMPLE_PERIOD,
        rules: RulesHeader {
            name: config.rules.name.clone(),
            hash: config.rules.hash(),
            profile: serde_json::to_value(&config.rules)
                .expect("rules have text keys and finite numbers only"),
        },
        limits: limits.named().into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
        trace: config.trace,
        logs: config.logs,
    }
}

enum Message {
    Started(TaskId),
    Ended(Box<TrialResult>),
    Failed(RunError),
}

/// What the workers share.
struct Work {
    config: RunConfig,
    prepared: Prepared,
    open: Vec<TaskId>,
    next: AtomicUsize,
    /// The worlds in use. Tasks come in the suite's order, so few are needed at a time.
    places: Cache<Place>,
    /// Set after an error, or if all of the first tasks fail: start nothing more.
    stop: AtomicBool,
    fail_fast: Mutex<FailFast>,
    cancel: AtomicBool,
}

impl Work {
    fn work(&self, sender: &mpsc::Sender<Message>) {
        while !self.stop.load(Ordering::Relaxed) && !self.cancel.load(Ordering::Relaxed) {
            let place = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(task) = self.open.get(place) else { return };
            // The receiver outlives the workers; if it is gone, so is the run.
            if sender.send(Message::Started(task.clone())).is_err() {
                return;
            }
            let message = match self.trial(task) {
                Ok(Some(result)) => {
                    self.watch(place, &result.record);
                    Message::Ended(Box::new(result))
                }
                Ok(None) => return,
                Err(error) => Message::Failed(error),
            };
            if sender.send(message).is_err() {
                return;
            }
        }
    }

    /// Starts nothing more if the planner fails alike, or the simulation fails, in all of the first tasks. This is found out
    /// before this worker takes another task, which may cost a whole time-out.
    fn watch(&self, place: usize, record: &TaskRecord) {
        if self.config.keep_going {
            return;
        }
        let mut fail_fast = lock(&self.fail_fast);
        if fail_fast.ended(place, record) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn trial(&self, task: &TaskId) -> Result<Option<TrialResult>, RunError> {
        let place = self.place(task.world())?;
        let Some(task) = place.world.task(task.task()) else {
            return Ok(None);
        };
        let Prepared { setting, wants } = &self.prepared;
        let mut driver = PluginDriver::new(&self.config.plugin);
        let keep = Keep { trace: self.config.trace, logs: self.config.logs };
        Ok(setting.drive(&place, task, wants, &mut driver, &mut (), keep, &self.cancel)?)
    }

    fn place(&self, id: &str) -> Result<Place, SuiteError> {
        self.places.get(id, || Place::load(&self.config.suite, id, self.config.scale))
    }
}
