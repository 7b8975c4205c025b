//! A planner's plugin as the driver of a trial.

use vb_files::one_line;
use vb_host::{Limits, LogSink, Metadata, PlannerFault, Plugin, Session};
use vb_sdk::{Command, Observation, Param, Task};
use vb_sense::Profile;
use vb_trial::{Driver, DriverFault, Fuel, Log, Wants};

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

    fn start(&mut self, brief: &Task, log: Log) -> Result<(), DriverFault> {
        self.session = Some(self.plugin.start(brief, LogSink::new(log)).map_err(|f| driver_fault(&f))?);
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        match &mut self.session {
            Some(session) => session.step(observation).map_err(|f| driver_fault(&f)),
            // A trial starts its driver first; a vehicle without a driver stands.
            None => Ok(Command { brake: 1.0, ..Command::default() }),
        }
    }

    fn fuel(&self) -> Option<Fuel> {
        let session = self.session.as_ref()?;
        let Limits { fuel_init, fuel_per_step, .. } = *self.plugin.limits();
        let (used, memory_bytes) = (session.fuel()?, session.memory_bytes().unwrap_or(0));
        Some(Fuel {
            init: used.init,
            last_step: used.last_step,
            init_limit: fuel_init,
            step_limit: fuel_per_step,
            memory_bytes,
        })
    }
}

fn driver_fault(fault: &PlannerFault) -> DriverFault {
    DriverFault {
        code: fault.code(),
        message: fault.to_string(),
        hint: fault.cause.hint(),
        backtrace: fault.cause.backtrace().to_vec(),
    }
}

/// What a plugin asks for under a perception profile.
#[must_use]
pub fn wants(plugin: &Plugin, perception: &Profile, params: Vec<Param>) -> Wants {
    let Metadata { name, control_period, .. } = plugin.metadata();
    let needs = perception.sensors_of(plugin.metadata());
    Wants { name: name.clone(), control_period: *control_period, needs, params }
}
