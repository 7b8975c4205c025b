//! A task while it is driven: what happens from one command to the next.

use std::ops::ControlFlow::{self, Break, Continue};

use vb_record::{Sample, TraceMode, TraceRecorder, WheelSample};
use vb_score::{Scorer, Verdict};
use vb_sdk::{Command, Observation};
use vb_sense::{Perception, Readings, Truth};
use vb_sim::{Controls, SAMPLE_PERIOD, SimError, Simulation, StateHash, VehicleState};

use crate::Trial;
use crate::driver::Witness;
use crate::gear::{planner_gear, simulated_gear};
use crate::recent::Recent;
use crate::ride::RideWatch;

/// What is gathered while a task is driven; it survives whatever ends the drive.
#[derive(Clone)]
pub(crate) struct Ledger {
    pub(crate) scorer: Scorer,
    pub(crate) recorder: TraceRecorder,
    pub(crate) hash: StateHash,
    pub(crate) recent: Recent,
    pub(crate) ride: RideWatch,
    pub(crate) sim_steps: u64,
    pub(crate) planner_steps: u64,
    pub(crate) clamped: u64,
    trace: TraceMode,
    wheels: Vec<WheelSample>,
}

impl Ledger {
    pub(crate) fn new(trial: &Trial<'_>) -> Self {
        let wheels = 2 * trial.vehicle.axles().len();
        Self {
            scorer: Scorer::new(trial.rules, &trial.geometry()),
            recorder: TraceRecorder::new(trial.trace, wheels),
            hash: StateHash::default(),
            recent: Recent::new(trial.world().scale),
            ride: RideWatch::new(trial),
            sim_steps: 0,
            planner_steps: 0,
            clamped: 0,
            trace: trial.trace,
            wheels: Vec::with_capacity(wheels),
        }
    }

    /// Takes a sample; breaks once there is a verdict.
    fn push(&mut self, sim: &Simulation, state: &VehicleState, sample: &Sample) -> ControlFlow<()> {
        sim.visit_state(|x| self.hash.push(x));
        if self.trace != TraceMode::None {
            self.wheels.clear();
            let wheels = state.wheels.iter();
            self.wheels.extend(wheels.map(|w| WheelSample { speed: w.speed, deflection: w.deflection }));
            self.recorder.push(sample, &self.wheels);
        }
        self.recent.push(state, sample);
        self.ride.sample(sim);
        if self.scorer.push(sample).is_some() { Break(()) } else { Continue(()) }
    }
}

/// A task while it is driven, by whoever gives the commands: a [`Trial`] with its driver, or an environment from outside.
///
/// [`Self::begin`] comes first; then, until there is a verdict, [`Self::observe`], [`Self::command`] and [`Self::advance`]
/// follow each other. A clone is a snapshot: it goes on exactly as the original does.
#[derive(Clone)]
pub struct Episode {
    sim: Simulation,
    perception: Perception,
    ledger: Ledger,
    /// The command that holds.
    controls: Controls,
    /// The steps of the simulation between two samples, and between two commands.
    sample_every: u64,
    control_every: u64,
}

impl Episode {
    /// An episode of a trial that begins with the vehicle as it stands in the simulation ([`Trial::simulation`]), which
    /// perceives by these sensors.
    #[must_use]
    pub fn new(trial: &Trial<'_>, sim: Simulation, perception: Perception) -> Self {
        let steps = |seconds: f64| (seconds / trial.options.step).round() as u64;
        Self {
            sim,
            perception,
            ledger: Ledger::new(trial),
            controls: Controls::default(),
            sample_every: steps(SAMPLE_PERIOD),
            control_every: steps(trial.brief.control_period),
        }
    }

    /// Takes the sample at the start; breaks if it decides already.
    pub fn begin(&mut self, witness: &mut dyn Witness) -> ControlFlow<()> {
        self.ledger.ride.begin(&self.sim);
        self.sample(witness)
    }

    /// What the sensors have measured since the last observation. An observation is taken before each command.
    pub fn observe(&mut self) -> Observation {
        let state = self.sim.state();
        self.ledger.planner_steps += 1;
        observation(&state, self.controls, self.perception.read(&state))
    }

    /// Takes a command, which holds until the next one; returns what is within range of it.
    pub fn command(&mut self, given: &Command) -> Controls {
        let own = Command { debug: Vec::new(), ..*given };
        let (Command { steering, throttle, brake, gear, .. }, clamped) = own.clamped();
        self.ledger.clamped += u64::from(clamped);
        self.controls = Controls { steering, throttle, brake, gear: simulated_gear(gear) };
        self.controls
    }

    /// Drives until the next command is due; breaks once there is a verdict.
    ///
    /// # Errors
    /// Returns an error if the simulation fails.
    pub fn advance(&mut self, witness: &mut dyn Witness) -> Result<ControlFlow<()>, SimError> {
        loop {
            let now = self.sim.steps();
            let next = |every: u64| (now / every + 1) * every;
            let until = next(self.sample_every).min(next(self.control_every));
            let ride = &mut self.ledger.ride;
            let advanced = self.sim.advance_watched(self.controls, until - now, |sim| ride.push(sim));
            self.ledger.sim_steps = self.sim.steps();
            advanced?;
            if until.is_multiple_of(self.sample_every) && self.sample(witness).is_break() {
                return Ok(Break(()));
            }
            if until.is_multiple_of(self.control_every) {
                return Ok(Continue(()));
            }
        }
    }

    /// Shows the sensors, the rules and the recorder the state; breaks once there is a verdict.
    fn sample(&mut self, witness: &mut dyn Witness) -> ControlFlow<()> {
        let state = self.sim.state();
        self.perception.sample(Truth { state: &state, ruts: Some(&self.sim) });
        let sample = sample(&state, self.controls);
        witness.sample(&self.sim, &state, &sample);
        self.ledger.push(&self.sim, &state, &sample)
    }

    /// The simulation as it is now.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.sim
    }

    /// The verdict, as soon as there is one.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        self.ledger.scorer.verdict()
    }

    /// The hash of all states until now, one for each sample.
    #[must_use]
    pub fn state_hash(&self) -> StateHash {
        self.ledger.hash.clone()
    }

    /// What has been gathered until now.
    pub(crate) fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// What has been gathered.
    pub(crate) fn into_ledger(self) -> Ledger {
        self.ledger
    }
}

/// The sample of a state under these controls, as rules and recorder see it.
#[must_use]
pub fn sample(state: &VehicleState, controls: Controls) -> Sample {
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    let (p, v, w) = (state.position, state.velocity_body, state.angular_velocity_body);
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
        gear: f64::from(planner_gear(controls.gear) as u32),
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
        gear: planner_gear(state.gear),
        engine_speed: state.engine_speed,
        steering: state.steering,
        last_steering: last.steering,
        last_throttle: last.throttle,
        last_brake: last.brake,
    }
}
