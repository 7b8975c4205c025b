//! Who drives in a trial, and who looks on.

use vb_host::{FuelMeter, Limits, LogSink, PlannerFault, Plugin, Session, one_line};
use vb_record::Sample;
use vb_sdk::{Command, Observation, Task};
use vb_sim::{Controls, Simulation, VehicleState};

/// Who drives in a trial: a planner's plugin ([`PluginDriver`]), or something within the harness. A driver drives one
/// trial.
pub trait Driver {
    /// The name and the version, for messages.
    fn name(&self) -> String;

    /// Takes in what is told about the task.
    ///
    /// # Errors
    /// Returns an error if the driver can't begin.
    fn start(&mut self, brief: &Task, log: LogSink) -> Result<(), PlannerFault>;

    /// Decides on a command, every `brief.control_period` seconds. It may be out of range.
    ///
    /// # Errors
    /// Returns an error if the driver fails; this ends the trial.
    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerFault>;

    /// What has been used until now; `None` for a driver that isn't metered.
    fn metered(&self) -> Option<Metered> {
        None
    }
}

/// What a metered driver has used, and what it was allowed.
#[derive(Clone, Copy, Debug)]
pub struct Metered {
    /// The fuel.
    pub fuel: FuelMeter,
    /// The most memory, bytes.
    pub memory_bytes: u64,
    /// The fuel that start-up and `init` may use.
    pub fuel_init: u64,
    /// The fuel that a step may use.
    pub fuel_per_step: u64,
}

/// A planner's plugin as the driver of a trial.
pub struct PluginDriver<'a> {
    plugin: &'a Plugin,
    session: Option<Session>,
}

impl<'a> PluginDriver<'a> {
    /// A driver that starts a fresh planner.
    #[must_use]
    pub fn new(plugin: &'a Plugin) -> Self {
        Self { plugin, session: None }
    }
}

impl Driver for PluginDriver<'_> {
    fn name(&self) -> String {
        let planner = self.plugin.metadata();
        format!("planner {} {}", one_line(&planner.name), one_line(&planner.version))
    }

    fn start(&mut self, brief: &Task, log: LogSink) -> Result<(), PlannerFault> {
        self.session = Some(self.plugin.start(brief, log)?);
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerFault> {
        match &mut self.session {
            Some(session) => session.step(observation),
            // A trial starts its driver first; a vehicle without a driver stands.
            None => Ok(Command { brake: 1.0, ..Command::default() }),
        }
    }

    fn metered(&self) -> Option<Metered> {
        let session = self.session.as_ref()?;
        let Limits { fuel_init, fuel_per_step, .. } = *self.plugin.limits();
        let (fuel, memory_bytes) = (session.fuel()?, session.memory_bytes().unwrap_or(0));
        Some(Metered { fuel, memory_bytes, fuel_init, fuel_per_step })
    }
}

/// Someone who looks on at a trial, and changes nothing.
pub trait Witness {
    /// The driver has seen `observation`, while the vehicle was in `state`, and commanded `given`, of which `taken` is what
    /// is within range, and holds until the next step.
    fn step(&mut self, state: &VehicleState, observation: &Observation, given: &Command, taken: Controls) {
        let _ = (state, observation, given, taken);
    }

    /// The simulation at a sample, with the vehicle's state: at the start, and every 10 ms.
    fn sample(&mut self, sim: &Simulation, state: &VehicleState, sample: &Sample) {
        let _ = (sim, state, sample);
    }
}

/// Nobody looks on.
impl Witness for () {}
