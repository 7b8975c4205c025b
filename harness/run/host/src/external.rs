//! Planners of other crates: nodes of ROS 2, which run outside of the harness, and recorded commands.

use std::fmt;

use vb_sdk::{Command, LogLevel, Observation, Task};

use crate::FaultCause;

/// The receiver of an external planner's log lines. The harness bounds and cleans them.
pub type ExternalLog = Box<dyn FnMut(LogLevel, &str) + Send>;

/// The connection to an external planner. A failure is a [`FaultCause`], as with planners that the harness runs itself.
pub trait External: fmt::Debug + Send + Sync {
    /// Passes the task to the planner and waits until it is ready.
    ///
    /// # Errors
    /// Returns the fault of the planner or of the connection; it ends the task.
    fn start(&self, task: &Task, log: ExternalLog) -> Result<Box<dyn ExternalSession>, FaultCause>;

    /// Descriptions of departures from repeatable results, with which results are marked ([`Plugin::departures`](crate::Plugin::departures)).
    fn departures(&self) -> Vec<String> {
        Vec::new()
    }

    /// The settings that a run must have with this planner: fields of run.json, such as `suite.hash`, and their values as JSON.
    fn requires(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }
}

/// An external planner at work on one task.
pub trait ExternalSession: fmt::Debug + Send {
    /// Passes an observation and waits for the command. Numbers of the command that are not finite are a fault.
    ///
    /// # Errors
    /// Returns the fault of the planner or of the connection; it ends the task.
    fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause>;
}
