//! One task, from the start to its verdict.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use vb_host::{Blame, FaultCode, LogSink, clamp};
use vb_record::{
    DebugSeries, LogMode, Sample, TRACE_SCHEMA, Trace, TraceMeta, TraceMode, TraceRecorder, WheelSample,
};
use vb_score::{Fault, FuelUse, Outcome, Rules, Scorer, TaskGeometry, TaskRecord, TaskScore};
use vb_sdk::{Command, Observation};
use vb_sense::{Perception, Readings, Truth};
use vb_sim::{Controls, SimOptions, Simulation, SoilSet, VehicleState};
use vb_vehicle::VehicleModel;
use vb_world::{Task, World};

use crate::StateHash;
use crate::driver::{Driver, Metered, Witness};

/// The time between the samples that rules and metrics see, s.
pub const SAMPLE_PERIOD: f64 = 0.01;

/// Lines of a planner's log, the last ones, that are kept for the record of a task.
const LOG_LINES: usize = 20;

/// Everything that decides the result of one task.
pub struct Trial<'a> {
    /// The world, already scaled.
    pub world: &'a Arc<World>,
    /// The task.
    pub task: &'a Task,
    /// The data that the planner is told.
    pub brief: &'a vb_sdk::Task,
    /// The vehicle.
    pub vehicle: &'a VehicleModel,
    /// The soils of deformable ground.
    pub soils: &'a SoilSet,
    /// The settings by which the simulation is stepped.
    pub options: SimOptions,
    /// The rules.
    pub rules: &'a Rules,
    /// The samples that are kept in the trace.
    pub trace: TraceMode,
    /// Whether the record keeps the planner's log.
    pub logs: LogMode,
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

/// Who ended a trial before a verdict, and why.
struct Failure {
    fault: Fault,
    code: FaultCode,
    reason: String,
    backtrace: Vec<String>,
}

impl Failure {
    /// What the planner did: who, where, what, and what to do about it.
    fn session(trial: &Trial<'_>, driver: &dyn Driver, fault: &vb_host::PlannerFault) -> Self {
        let reason = format!("{} on {}, {fault}; {}", driver.name(), trial.brief.id, fault.cause.hint());
        Self { backtrace: fault.cause.backtrace().to_vec(), ..Self::new(fault.code(), reason) }
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

/// What is gathered while a trial runs; it survives whatever ends the trial.
struct Ledger {
    scorer: Scorer,
    recorder: TraceRecorder,
    debug: DebugSeries,
    hash: StateHash,
    sim_steps: u64,
    planner_steps: u64,
    clamped: u64,
    /// What the driver has used; none for drivers that aren't metered.
    metered: Option<Metered>,
    /// Fuel for each step.
    fuel_steps: Vec<u64>,
    wheels: Vec<WheelSample>,
}

/// Who takes part in a trial beside the simulation.
struct Part<'a> {
    driver: &'a mut dyn Driver,
    perception: &'a mut Perception,
    witness: &'a mut dyn Witness,
    ledger: &'a mut Ledger,
}

impl Trial<'_> {
    /// Lets a driver drive the task to its end, with these sensors. It returns `None` if `cancel` was set before the end
    /// came.
    #[must_use]
    pub fn run(
        &self,
        driver: &mut dyn Driver,
        mut perception: Perception,
        witness: &mut dyn Witness,
        cancel: &AtomicBool,
    ) -> Option<TrialResult> {
        let h = &self.world.heightfield;
        let goal = self.task.goal;
        let geometry = TaskGeometry {
            goal,
            goal_z: h.height(goal[0], goal[1]),
            half_extent: [h.half_x(), h.half_y()],
            scale: self.world.scale,
        };
        let wheels = 2 * self.vehicle.axles().len();
        let mut ledger = Ledger {
            scorer: Scorer::new(self.rules, &geometry),
            recorder: TraceRecorder::new(self.trace, wheels),
            debug: DebugSeries::default(),
            hash: StateHash::default(),
            sim_steps: 0,
            planner_steps: 0,
            clamped: 0,
            metered: None,
            fuel_steps: Vec::new(),
            wheels: Vec::with_capacity(wheels),
        };
        let log = Arc::new(Mutex::new(Vec::<String>::new()));
        // A panic of the harness is a bug, but it must not take the other tasks' results with it.
        let end = catch_unwind(AssertUnwindSafe(|| {
            let mut part = Part { driver, perception: &mut perception, witness, ledger: &mut ledger };
            self.drive(&mut part, &log, cancel)
        }));
        let failure = match end {
            Ok(Ok(true)) => None,
            Ok(Ok(false)) => return None,
            Ok(Err(failure)) => Some(failure),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                let text = text.unwrap_or_else(|| "no message".to_owned());
                Some(Failure::new(
                    FaultCode::HostPanic,
                    format!("the harness panicked: {text}; please report it"),
                ))
            }
        };
        Some(self.result(ledger, geometry, failure, &log))
    }

    fn result(
        &self,
        ledger: Ledger,
        geometry: TaskGeometry,
        failure: Option<Failure>,
        log: &Mutex<Vec<String>>,
    ) -> TrialResult {
        let fault = failure.as_ref().map(|f| f.code.name().to_owned());
        let backtrace = failure.as_ref().map(|f| f.backtrace.clone()).unwrap_or_default();
        let score: TaskScore = match failure {
            Some(f) => ledger.scorer.fail(f.fault, f.reason),
            None => match ledger.scorer.clone().finish() {
                Some(score) => score,
                None => ledger.scorer.fail(Fault::Simulation, "the trial ended without a verdict"),
            },
        };
        let kept = self.logs.keeps(score.outcome == Outcome::Success);
        let log = if kept { log.lock().map(|l| l.clone()).unwrap_or_default() } else { Vec::new() };
        let fuel = ledger.metered.map(|m| {
            FuelUse::new(m.fuel.init, ledger.fuel_steps, m.fuel_init, m.fuel_per_step, m.memory_bytes)
        });
        let record = TaskRecord {
            task: self.brief.id.clone(),
            world: self.world.id.clone(),
            elevation: self.world.elevation,
            terrain: self.world.terrain,
            density: self.world.density,
            outcome: score.outcome,
            three_way: score.three_way,
            reason: score.reason,
            fault,
            time_s: score.time_s,
            state_hash: ledger.hash.hex(),
            sim_steps: ledger.sim_steps,
            planner_steps: ledger.planner_steps,
            clamped: ledger.clamped,
            fuel,
            metrics: score.metrics,
            log,
            backtrace,
        };
        let start = self.task.start;
        let trace = ledger.recorder.finish(TraceMeta {
            schema: TRACE_SCHEMA,
            task: self.brief.id.clone(),
            start: [start.x, start.y, start.yaw],
            goal: geometry.goal,
            goal_z: geometry.goal_z,
            half_extent: geometry.half_extent,
            scale: geometry.scale,
            time_step: self.options.step,
            sample_period: SAMPLE_PERIOD,
            mode: self.trace,
        });
        TrialResult { record, trace, debug: ledger.debug }
    }

    /// Drives until the rules decide: true; or until `cancel` is set: false.
    fn drive(
        &self,
        part: &mut Part<'_>,
        log: &Arc<Mutex<Vec<String>>>,
        cancel: &AtomicBool,
    ) -> Result<bool, Failure> {
        let lines = Arc::clone(log);
        let sink = LogSink::new(move |level, text| {
            if let Ok(mut lines) = lines.lock() {
                if lines.len() == LOG_LINES {
                    lines.remove(0);
                }
                lines.push(format!("{}: {text}", format!("{level:?}").to_lowercase()));
            }
        });
        let mut sim =
            Simulation::new(self.world.clone(), self.vehicle, self.soils, self.task.start, self.options)
                .map_err(|e| Failure::new(FaultCode::Simulation, e.to_string()))?;
        let started = part.driver.start(self.brief, sink);
        started.map_err(|f| Failure::session(self, part.driver, &f))?;
        part.ledger.metered = part.driver.metered();
        let steps = |seconds: f64| (seconds / self.options.step).round() as u64;
        let (sample_every, control_every) = (steps(SAMPLE_PERIOD), steps(self.brief.control_period));
        let mut controls = Controls::default();
        if self.sample(&sim, controls, part) {
            return Ok(true);
        }
        loop {
            if sim.steps().is_multiple_of(control_every) {
                if cancel.load(Ordering::Relaxed) {
                    return Ok(false);
                }
                let result = self.ask(&sim, controls, part);
                part.ledger.metered = part.driver.metered();
                part.ledger.fuel_steps.extend(part.ledger.metered.map(|m| m.fuel.last_step));
                controls = result?;
            }
            let now = sim.steps();
            let next = |every: u64| (now / every + 1) * every;
            let until = next(sample_every).min(next(control_every));
            let advanced = sim.advance(controls, until - now);
            part.ledger.sim_steps = sim.steps();
            advanced.map_err(|e| Failure::new(FaultCode::Diverged, e.to_string()))?;
            if sim.steps().is_multiple_of(sample_every) && self.sample(&sim, controls, part) {
                return Ok(true);
            }
        }
    }

    /// Shows the driver what its sensors have measured and takes its command.
    fn ask(&self, sim: &Simulation, last: Controls, part: &mut Part<'_>) -> Result<Controls, Failure> {
        let state = sim.state();
        let observation = observation(&state, last, part.perception.read(&state));
        let given = part.driver.step(&observation);
        part.ledger.planner_steps += 1;
        let given = given.map_err(|f| Failure::session(self, part.driver, &f))?;
        let (Command { steering, throttle, brake, gear, .. }, clamped) =
            clamp(Command { debug: Vec::new(), ..given });
        let taken = Controls { steering, throttle, brake, gear: asked_gear(gear) };
        part.witness.step(&state, &observation, &given, taken);
        part.ledger.clamped += u64::from(clamped);
        if self.trace != TraceMode::None {
            for series in &given.debug {
                part.ledger.debug.push(state.time, &series.name, &series.values);
            }
        }
        Ok(taken)
    }

    /// Shows the sensors, the rules and the recorder the state; true when there is a verdict.
    fn sample(&self, sim: &Simulation, controls: Controls, part: &mut Part<'_>) -> bool {
        let Part { perception, witness, ledger, .. } = part;
        let state = sim.state();
        perception.sample(Truth { state: &state, ruts: Some(sim) });
        let sample = sample(&state, controls);
        witness.sample(sim, &state, &sample);
        sim.visit_state(|x| ledger.hash.push(x));
        if self.trace != TraceMode::None {
            ledger.wheels.clear();
            let wheels = state.wheels.iter();
            ledger.wheels.extend(wheels.map(|w| WheelSample { speed: w.speed, deflection: w.deflection }));
            ledger.recorder.push(&sample, &ledger.wheels);
        }
        ledger.scorer.push(&sample).is_some()
    }
}

/// The sample of a state under these controls, as rules and recorder see it.
#[must_use]
pub fn sample(state: &VehicleState, controls: Controls) -> Sample {
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    let (p, v, w) = (state.position, state.velocity, state.angular_velocity);
    Sample {
        time: state.time,
        x: p.x,
        y: p.y,
        z: p.z,
        roll,
        pitch,
        yaw,
        vx: v.x,
        vy: v.y,
        vz: v.z,
        wx: w.x,
        wy: w.y,
        wz: w.z,
        steering: controls.steering,
        throttle: controls.throttle,
        brake: controls.brake,
        gear: f64::from(gear(controls.gear) as u32),
    }
}

/// The gear that a sample says was commanded.
#[must_use]
pub fn commanded_gear(sample: &Sample) -> vb_sim::Gear {
    if sample.gear == Sample::REVERSE {
        vb_sim::Gear::Reverse
    } else if sample.gear == Sample::NEUTRAL {
        vb_sim::Gear::Neutral
    } else {
        vb_sim::Gear::Forward
    }
}

/// A gear that a planner asks for, as the simulation knows it.
fn asked_gear(gear: vb_sdk::Gear) -> vb_sim::Gear {
    match gear {
        vb_sdk::Gear::Forward => vb_sim::Gear::Forward,
        vb_sdk::Gear::Neutral => vb_sim::Gear::Neutral,
        vb_sdk::Gear::Reverse => vb_sim::Gear::Reverse,
    }
}

/// A gear as planners and records know it.
fn gear(gear: vb_sim::Gear) -> vb_sdk::Gear {
    match gear {
        vb_sim::Gear::Forward => vb_sdk::Gear::Forward,
        vb_sim::Gear::Neutral => vb_sdk::Gear::Neutral,
        vb_sim::Gear::Reverse => vb_sdk::Gear::Reverse,
    }
}

fn observation(state: &VehicleState, last: Controls, seen: Readings) -> Observation {
    let Readings { pose, wheels, imu, gnss, lidar, depth, local_map } = seen;
    Observation {
        time: state.time,
        pose,
        wheels,
        imu,
        gnss,
        lidar,
        depth,
        local_map,
        gear: gear(state.gear),
        engine_speed: state.engine_speed,
        steering: state.steering,
        last_steering: last.steering,
        last_throttle: last.throttle,
        last_brake: last.brake,
    }
}
