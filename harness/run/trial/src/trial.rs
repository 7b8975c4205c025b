//! One task, from the start to its verdict.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use vb_files::{lock, panic_text};
use vb_record::{DebugSeries, LogMode, TRACE_SCHEMA, Trace, TraceMeta, TraceMode};
use vb_score::{Fault, FuelUse, Outcome, Rules, TaskGeometry, TaskRecord, TaskScore};
use vb_sdk::fault::{Blame, FaultCode};
use vb_sense::Perception;
use vb_sim::{SAMPLE_PERIOD, SimError, SimOptions, Simulation, SoilSet, Surroundings};
use vb_vehicle::VehicleModel;
use vb_world::{Task, World};

use crate::driver::{Driver, DriverFault, Fuel, Log, Witness};
use crate::episode::{Episode, Ledger};

/// Lines of a planner's log, the last ones, that are kept for the record of a task.
const LOG_LINES: usize = 20;

/// Everything that decides the result of one task.
pub struct Trial<'a> {
    /// The world, already scaled, with what stands in it.
    pub surroundings: &'a Surroundings,
    pub task: &'a Task,
    /// The data that the planner is told.
    pub brief: &'a vb_sdk::Task,
    pub vehicle: &'a VehicleModel,
    /// The soils of deformable ground.
    pub soils: &'a SoilSet,
    /// The settings by which the simulation is stepped.
    pub options: SimOptions,
    pub rules: &'a Rules,
    /// The samples that are kept in the trace.
    pub trace: TraceMode,
    /// Whether the record keeps the planner's log.
    pub logs: LogMode,
    /// The settings that aren't the benchmark's, in words.
    pub departures: &'a [String],
}

/// The result of a trial.
pub struct TrialResult {
    /// The record, which is a line of `tasks.jsonl`.
    pub record: TaskRecord,
    /// The trajectory; `None` if none is wanted.
    pub trace: Option<Trace>,
    /// The planner's own series, if a trajectory is wanted.
    pub debug: DebugSeries,
}

/// How a trial ends without a failure.
enum End {
    /// The rules have decided.
    Decided,
    /// It was cancelled before.
    Cancelled,
}

/// Who ended a trial before a verdict, and why.
struct Failure {
    fault: Fault,
    code: FaultCode,
    reason: String,
    backtrace: Vec<String>,
}

impl Failure {
    /// A driver's fault: who, where, what, and what to do about it.
    fn driver(trial: &Trial<'_>, driver: &dyn Driver, fault: DriverFault) -> Self {
        let DriverFault { code, message, hint, backtrace } = fault;
        let reason = format!("{} on {}, {message}; {hint}", driver.name(), trial.brief.id);
        Self { backtrace, ..Self::new(code, reason) }
    }

    fn new(code: FaultCode, reason: String) -> Self {
        let fault = match code.blame() {
            Blame::Planner => Fault::Planner,
            Blame::Host => Fault::Host,
            Blame::Simulation => Fault::Simulation,
        };
        Self { fault, code, reason, backtrace: Vec::new() }
    }
}

/// What the driver has left behind; it survives whatever ends the trial.
#[derive(Default)]
struct Trail {
    debug: DebugSeries,
    /// What the driver has used; none for drivers that aren't metered.
    fuel: Option<Fuel>,
    /// Fuel for each step.
    fuel_steps: Vec<u64>,
    /// The last lines that it logged.
    log: Arc<Mutex<Vec<String>>>,
}

/// The name of a series as it is recorded: without what a terminal might act on or a reader can't see. One that is too long is not
/// recorded, so it stays as it is.
fn shown(name: &str) -> Cow<'_, str> {
    if name.len() > DebugSeries::MAX_NAME { Cow::Borrowed(name) } else { vb_files::printable(name).into() }
}

impl Trail {
    /// Where the driver's log goes.
    fn sink(&self) -> Log {
        let lines = Arc::clone(&self.log);
        Box::new(move |level, text| {
            let mut lines = lock(&lines);
            if lines.len() == LOG_LINES {
                lines.remove(0);
            }
            lines.push(format!("{}: {text}", format!("{level:?}").to_lowercase()));
        })
    }
}

impl Trial<'_> {
    /// The world, already scaled.
    #[must_use]
    pub fn world(&self) -> &World {
        self.surroundings.world()
    }

    /// Where the task is, and for which vehicle.
    pub(crate) fn geometry(&self) -> TaskGeometry {
        TaskGeometry::of(self.world(), self.task, self.vehicle.spec().max_speed)
    }

    /// Lets a driver drive the task to its end, with these sensors. It returns `None` if `cancel` was set before the end
    /// came.
    #[must_use]
    pub fn run(
        &self,
        driver: &mut dyn Driver,
        perception: Perception,
        witness: &mut dyn Witness,
        cancel: &AtomicBool,
    ) -> Option<TrialResult> {
        let (mut episode, mut trail) = (None, Trail::default());
        // A panic of the harness is a bug, but it must not take the other tasks' results with it.
        let end = catch_unwind(AssertUnwindSafe(|| {
            let simulation =
                self.simulation().map_err(|e| Failure::new(FaultCode::Simulation, e.to_string()))?;
            let episode = episode.insert(Episode::new(self, simulation, perception));
            self.drive(episode, driver, witness, &mut trail, cancel)
        }));
        let failure = match end {
            Ok(Ok(End::Decided)) => None,
            Ok(Ok(End::Cancelled)) => return None,
            Ok(Err(failure)) => Some(failure),
            Err(panic) => {
                let text = panic_text(&*panic);
                Some(Failure::new(
                    FaultCode::HostPanic,
                    format!("the harness panicked: {text}; please report it"),
                ))
            }
        };
        let ledger = episode.map_or_else(|| Ledger::new(self), Episode::into_ledger);
        Some(self.result(ledger, failure, trail))
    }

    /// The simulation with the vehicle at the start of the task.
    ///
    /// # Errors
    /// Returns an error if the vehicle can't be put there.
    pub fn simulation(&self) -> Result<Simulation, SimError> {
        Simulation::new(self.surroundings.clone(), self.vehicle, self.soils, self.task.start, self.options)
    }

    /// The result of an episode of this trial that was driven from outside, without a planner: by its verdict, or by the
    /// error that ended its simulation.
    #[must_use]
    pub fn result_of(&self, episode: &Episode, error: Option<&SimError>) -> TrialResult {
        let failure = error.map(|e| Failure::new(FaultCode::Diverged, e.to_string()));
        self.result(episode.ledger().clone(), failure, Trail::default())
    }

    fn result(&self, ledger: Ledger, failure: Option<Failure>, trail: Trail) -> TrialResult {
        let fault = failure.as_ref().map(|f| f.code);
        let backtrace = failure.as_ref().map(|f| f.backtrace.clone()).unwrap_or_default();
        let score: TaskScore = match failure {
            Some(f) => ledger.scorer.fail(f.fault, f.reason),
            None => match ledger.scorer.clone().finish() {
                Some(score) => score,
                None => ledger.scorer.fail(Fault::Simulation, "the trial ended without a verdict"),
            },
        };
        let diagnosis = ledger.recent.diagnose(&score, self.vehicle, self.world());
        let kept = self.logs.keeps(score.outcome == Outcome::Success);
        let log = if kept { lock(&trail.log).clone() } else { Vec::new() };
        let fuel = trail
            .fuel
            .map(|f| FuelUse::new(f.init, trail.fuel_steps, f.init_limit, f.step_limit, f.memory_bytes));
        let world = self.world();
        let mut record = TaskRecord {
            task: world.task_id(self.task),
            world: world.id.clone(),
            elevation: world.elevation,
            terrain: world.terrain,
            density: world.density,
            outcome: score.outcome,
            three_way: score.three_way,
            flags: BTreeMap::new(),
            departures: self.departures.to_vec(),
            reason: score.reason,
            cause: diagnosis.as_ref().map(|d| d.cause),
            evidence: diagnosis.map(|d| d.evidence).unwrap_or_default(),
            fault,
            time_s: score.time_s,
            state_hash: ledger.hash.hex(),
            sim_steps: ledger.sim_steps,
            planner_steps: ledger.planner_steps,
            clamped: ledger.clamped,
            fuel,
            metrics: score.metrics,
            ride: ledger.ride.ride(),
            log,
            backtrace,
        };
        record.judge();
        let (start, geometry) = (self.task.start, self.geometry());
        let trace = ledger.recorder.finish(TraceMeta {
            schema: TRACE_SCHEMA,
            task: world.task_id(self.task),
            start: [start.x, start.y, start.yaw],
            goal: geometry.goal,
            goal_z: geometry.goal_z,
            half_extent: geometry.half_extent,
            scale: geometry.scale,
            max_speed: geometry.max_speed,
            time_step: self.options.step,
            sample_period: SAMPLE_PERIOD,
            mode: self.trace,
        });
        TrialResult { record, trace, debug: trail.debug }
    }

    /// Drives until the rules decide or `cancel` is set.
    fn drive(
        &self,
        episode: &mut Episode,
        driver: &mut dyn Driver,
        witness: &mut dyn Witness,
        trail: &mut Trail,
        cancel: &AtomicBool,
    ) -> Result<End, Failure> {
        let started = driver.start(self.brief, trail.sink());
        started.map_err(|f| Failure::driver(self, driver, f))?;
        trail.fuel = driver.fuel();
        if episode.begin(witness).is_break() {
            return Ok(End::Decided);
        }
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Ok(End::Cancelled);
            }
            let observation = episode.observe();
            let given = driver.step(&observation);
            trail.fuel = driver.fuel();
            trail.fuel_steps.extend(trail.fuel.map(|f| f.last_step));
            let given = given.map_err(|f| Failure::driver(self, driver, f))?;
            let taken = episode.command(&given);
            witness.step(&episode.simulation().state(), &observation, &given, taken);
            if self.trace != TraceMode::None {
                for series in &given.debug {
                    trail.debug.push(observation.time, &shown(&series.name), &series.values);
                }
            }
            let advanced = episode.advance(witness);
            if advanced.map_err(|e| Failure::new(FaultCode::Diverged, e.to_string()))?.is_break() {
                return Ok(End::Decided);
            }
        }
    }
}
