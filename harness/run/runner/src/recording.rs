//! The recorded commands of a run as a planner.

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;
use vb_host::{
    External, ExternalLog, ExternalSession, FaultCause, Limits, LoadError, Metadata, Plugin, PluginKind,
};
use vb_record::{AppliedCommand, Recording, RunHeader, StoreError};
use vb_sdk::{Command, Observation, Task};
use vb_trial::{commanded_gear, planner_gear};
use vb_world::TaskId;

use crate::RunError;

/// A planner that gives the commands of a recording, whatever it observes: the simulation, and so its result, is the same
/// as in the recorded run.
///
/// # Errors
/// Returns an error if the file can't be read or is no recording.
pub fn recorded(path: &Path, limits: &Limits) -> Result<Plugin, LoadError> {
    let (recording, identity) = Recording::read(path).map_err(|e| refused(path, e))?;
    let planner = &recording.header.plugin;
    let metadata = Metadata {
        abi: vb_host::AbiVersion::NEWEST.name().to_owned(),
        name: planner.name.clone(),
        version: planner.version.clone(),
        authors: Vec::new(),
        about: format!("recorded commands of a planner of kind {}", planner.kind),
        control_period: planner.control_period,
        params: Vec::new(),
        needs: Vec::new(),
        needs_without_maps: Vec::new(),
        models: Vec::new(),
    };
    let external = Arc::new(Recorded(Arc::new(recording)));
    Ok(Plugin::external(PluginKind::Recording, metadata, &identity, limits, external))
}

fn refused(path: &Path, error: StoreError) -> LoadError {
    let path = path.to_owned();
    let reason = match error {
        StoreError::Io { source, .. } => return LoadError::Io { path, source },
        StoreError::Damaged { detail, hint, .. } => format!("{detail} ({hint})"),
        StoreError::Schema { found, supported, .. } => {
            format!(
                "recording schema {found} is not supported; this version reads schema {supported} (use the version that wrote it)"
            )
        }
        e => e.to_string(),
    };
    LoadError::NotAPlugin { path, reason }
}

/// The settings that decide where commands lead, and those under which the planner drove, as fields of run.json.
const SETTINGS: [&str; 9] = [
    "suite.hash",
    "vehicle.hash",
    "soils.hash",
    "soil_resolution",
    "scale",
    "time_step",
    "rules.hash",
    "perception.hash",
    "seed",
];

/// Checks that a run has the settings of the recording that drives it: under others its commands mean nothing.
///
/// # Errors
/// Returns [`RunError::Recorded`] with the first setting that differs.
pub(crate) fn check(plugin: &Plugin, header: &RunHeader) -> Result<(), RunError> {
    let settings = settings(header);
    for (field, recorded) in plugin.requires() {
        let found = setting(&settings, field);
        if found != recorded {
            return Err(RunError::Recorded { field, recorded, found });
        }
    }
    Ok(())
}

/// run.json as JSON.
fn settings(header: &RunHeader) -> Value {
    serde_json::to_value(header).unwrap_or_default()
}

/// A field of run.json; its parts are separated by points.
fn setting(settings: &Value, field: &str) -> String {
    settings.pointer(&format!("/{}", field.replace('.', "/"))).unwrap_or_default().to_string()
}

/// A recording as an external planner.
#[derive(Debug)]
struct Recorded(Arc<Recording>);

impl External for Recorded {
    fn start(&self, task: &Task, _: ExternalLog) -> Result<Box<dyn ExternalSession>, FaultCause> {
        let Some(id) = task.id.parse::<TaskId>().ok().filter(|id| self.0.tasks.contains_key(id)) else {
            let message = "the recording has no commands for this task".to_owned();
            return Err(FaultCause::Error { message });
        };
        Ok(Box::new(RecordedSession { recording: Arc::clone(&self.0), id, next: 0 }))
    }

    fn departures(&self) -> Vec<String> {
        self.0.departures.clone()
    }

    fn requires(&self) -> Vec<(&'static str, String)> {
        let settings = settings(&self.0.header);
        SETTINGS.iter().map(|field| (*field, setting(&settings, field))).collect()
    }
}

#[derive(Debug)]
struct RecordedSession {
    recording: Arc<Recording>,
    id: TaskId,
    next: usize,
}

impl ExternalSession for RecordedSession {
    fn step(&mut self, _: &Observation) -> Result<Command, FaultCause> {
        let commands = &self.recording.tasks[&self.id];
        let Some(AppliedCommand { steering, throttle, brake, gear }) = commands.get(self.next).copied()
        else {
            // As in the recorded run, where the planner failed here.
            let message = format!("the recording ends after {} commands", commands.len());
            return Err(FaultCause::Error { message });
        };
        self.next += 1;
        Ok(Command { steering, throttle, brake, gear: planner_gear(commanded_gear(gear)), debug: Vec::new() })
    }
}
