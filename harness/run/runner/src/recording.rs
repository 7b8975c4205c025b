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

/// The kind of a planner as run.json has it.
#[must_use]
pub fn recorded_kind(kind: PluginKind) -> vb_record::PluginKind {
    match kind {
        PluginKind::Wasm => vb_record::PluginKind::Wasm,
        PluginKind::Native => vb_record::PluginKind::Native,
        PluginKind::Command => vb_record::PluginKind::Command,
        PluginKind::Ros => vb_record::PluginKind::Ros,
        PluginKind::Recording => vb_record::PluginKind::Recording,
    }
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
    serde_json::to_value(header).expect("a header has text keys and can be written as JSON")
}

/// The value of a field of run.json, one of [`SETTINGS`]; its parts are separated by points. A field that run.json lacks would be
/// equal in all runs, so it is a mistake in [`SETTINGS`].
fn setting(settings: &Value, field: &str) -> String {
    let value = settings.pointer(&format!("/{}", field.replace('.', "/")));
    value.unwrap_or_else(|| panic!("run.json has no field {field}")).to_string()
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Settings of a run without the fields that run.json may lack.
    fn header() -> RunHeader {
        let named = |name: &str| json!({"name": name, "hash": name});
        let header = json!({
            "schema": vb_record::RUN_SCHEMA,
            "harness_version": "1.0.0",
            "harness_commit": "unknown",
            "started_at": "2026-01-01T00:00:00Z",
            "suite": {"name": "s", "hash": "aa", "path": "tasks/s", "tasks": 9},
            "selector": null,
            "tasks": 9,
            "plugin": {
                "name": "pid",
                "version": "1.0.0",
                "sha256": "bb",
                "kind": "wasm",
                "path": "pid.wasm",
                "eligible_for_ranking": true,
                "control_period": 0.1,
            },
            "params": {},
            "vehicle": named("hmmwv"),
            "soils": named("default"),
            "perception": named("oracle"),
            "scale": 1.0,
            "seed": 7,
            "time_step": 0.001,
            "soil_resolution": 0.1,
            "sample_period": 0.01,
            "rules": {"name": "paper", "hash": "cc", "profile": {}},
            "limits": {},
            "trace": "full",
            "logs": "failed",
        });
        serde_json::from_value(header).unwrap()
    }

    #[test]
    fn kinds_have_the_same_name_in_run_json() {
        use PluginKind::{Command, Native, Recording, Ros, Wasm};
        let kinds = [Wasm, Native, Command, Ros, Recording];
        assert_eq!(kinds.map(recorded_kind), vb_record::PluginKind::ALL);
        assert_eq!(kinds.map(PluginKind::name), kinds.map(|kind| recorded_kind(kind).name()));
    }

    #[test]
    fn every_setting_is_a_field_of_run_json() {
        let settings = settings(&header());
        for field in SETTINGS {
            assert_ne!(setting(&settings, field), "null", "{field}");
        }
    }

    #[test]
    #[should_panic(expected = "run.json has no field vehicle.hahs")]
    fn a_misspelt_setting_agrees_with_nothing() {
        setting(&settings(&header()), "vehicle.hahs");
    }
}
