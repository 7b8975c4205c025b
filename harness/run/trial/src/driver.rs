//! Who drives in a trial, and who observes it.

use vb_record::Sample;
use vb_sdk::fault::FaultCode;
use vb_sdk::{Command, LogLevel, Observation, Task};
use vb_sim::{Controls, Simulation, VehicleState};

/// Where a driver's log lines go.
pub type Log = Box<dyn FnMut(LogLevel, &str) + Send>;

/// Drives one trial: a planner's plugin (`vb_runner::PluginDriver`), or something within the harness.
pub trait Driver {
    /// Name and version, for messages.
    fn name(&self) -> String;

    /// Prepares for the task. Called once, before the first [`Self::step`].
    ///
    /// # Errors
    /// Returns an error if the driver can't start; this ends the trial.
    fn start(&mut self, brief: &Task, log: Log) -> Result<(), DriverFault>;

    /// Decides on a command, every `brief.control_period` seconds. It may be out of range.
    ///
    /// # Errors
    /// Returns an error if the driver fails; this ends the trial.
    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault>;

    /// What has been used so far; `None` for a driver that isn't metered.
    fn fuel(&self) -> Option<Fuel> {
        None
    }
}

/// Why a driver failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriverFault {
    /// The stable name of the cause; says who is to blame.
    pub code: FaultCode,
    /// Where and why, for the record: `step 12 (t = 1.20 s): …`.
    pub message: String,
    /// What to do about it.
    pub hint: &'static str,
    /// The innermost functions, the failing one first, where they are known.
    pub backtrace: Vec<String>,
}

/// What a metered driver has used, and its limits. Units of fuel are those of wasmtime.
#[derive(Clone, Copy, Debug)]
pub struct Fuel {
    /// Used by start-up and `init`.
    pub init: u64,
    /// Used by the last step.
    pub last_step: u64,
    /// Limit of start-up and `init`.
    pub init_limit: u64,
    /// Limit of a step.
    pub step_limit: u64,
    /// Peak memory, bytes.
    pub memory_bytes: u64,
}

/// Observes a trial and changes nothing.
pub trait Witness {
    /// Called after each step of the driver: it has seen `observation` while the vehicle was in `state`, and commanded
    /// `given`; `taken` is `given` within its range, and holds until the next step.
    fn step(&mut self, state: &VehicleState, observation: &Observation, given: &Command, taken: Controls) {
        let _ = (state, observation, given, taken);
    }

    /// Called with each sample: at the start, and every 10 ms.
    fn sample(&mut self, sim: &Simulation, state: &VehicleState, sample: &Sample) {
        let _ = (sim, state, sample);
    }
}

/// Observes nothing.
impl Witness for () {}
