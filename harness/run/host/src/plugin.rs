//! A loaded plugin and its sessions.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use vb_files::Hash;
use vb_sdk::metadata::Metadata;
use vb_sdk::{Command, Observation, Param, Task};
use vb_worker::sandbox::SandboxReport;

use crate::abi::AbiVersion;
use crate::external::{External, ExternalSession};
use crate::fault::{FaultCause, PlannerFault};
use crate::inspect::{self, Format};
use crate::log::Log;
use crate::native::{self, ProcessOptions, ProcessPlugin, ProcessSession};
use crate::wasm::{WasmPlugin, WasmSession};
use crate::{Limits, LoadError, LogSink, ParamError};

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PluginKind {
    /// The plugin is WebAssembly, sandboxed and metered.
    Wasm,
    /// The plugin is a native library, in a sandboxed process of its own.
    Native,
    /// The plugin is a command that the user gave, with all that the user may do. It is not eligible for ranking.
    Command,
    /// The planner is a ROS 2 node that the user started. It is not eligible for ranking.
    Ros,
    /// The planner gives the recorded commands of a run. It is not eligible for ranking.
    Recording,
}

impl PluginKind {
    /// The name by which results call the kind.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wasm => "wasm",
            Self::Native => "native",
            Self::Command => "command",
            Self::Ros => "ros",
            Self::Recording => "recording",
        }
    }

    /// Whether results of such planners are eligible for ranking: the planner is a file that decides by what it observes, and
    /// that others can run as well.
    #[must_use]
    pub fn is_eligible(self) -> bool {
        match self {
            Self::Wasm | Self::Native => true,
            Self::Command | Self::Ros | Self::Recording => false,
        }
    }
}

/// A loaded planner plugin. Clones share the compiled code; any number of threads may start sessions at once.
#[derive(Clone, Debug)]
pub struct Plugin(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    abi: AbiVersion,
    metadata: Metadata,
    sha256: String,
    limits: Limits,
    code: Code,
}

#[derive(Debug)]
enum Code {
    Wasm(WasmPlugin),
    Native(ProcessPlugin, SandboxReport),
    Command(ProcessPlugin),
    External(PluginKind, Arc<dyn External>),
}

impl Plugin {
    /// Loads a plugin: a WASM component, a core WASM module as the Rust compiler leaves it, or a native library; the
    /// content decides, not the name.
    ///
    /// Compiled WASM is kept in `cache_dir` (made if it doesn't exist) and taken from there the next time. It is
    /// machine code: the directory must be one that only the user can write to.
    ///
    /// WASM is compiled and a native library is opened by a process of its own, for which the running program starts
    /// itself again: it must begin with [`serve_as_worker`](crate::serve_as_worker). See [`Plugin::load_with`] for
    /// another program. Without either, no native library can be opened, and WASM is compiled in the running program,
    /// without the limits `compile_bytes` and `compile_seconds`: that is for plugins that one trusts.
    ///
    /// # Errors
    /// Returns an error if the file is not a plugin that this harness can run; see [`LoadError`]. An unusable cache is
    /// not an error.
    pub fn load(path: &Path, limits: &Limits, cache_dir: Option<&Path>) -> Result<Self, LoadError> {
        Self::load_with(path, limits, cache_dir, &ProcessOptions::default())
    }

    /// Loads a plugin as [`Plugin::load`] does, with a choice of the program for the processes.
    pub fn load_with(
        path: &Path,
        limits: &Limits,
        cache_dir: Option<&Path>,
        processes: &ProcessOptions,
    ) -> Result<Self, LoadError> {
        let file = inspect::read(path, limits.module_bytes)?;
        let sha256 = vb_files::sha256(&file.bytes);
        let code = match file.format {
            Format::Native => {
                let (plugin, sandbox) = ProcessPlugin::load(path, &sha256, file.abi, limits, processes)?;
                Code::Native(plugin, sandbox)
            }
            Format::Component | Format::CoreModule => {
                let compiler = native::compiler(processes);
                Code::Wasm(WasmPlugin::load(path, &file, &sha256, limits, cache_dir, compiler.as_deref())?)
            }
        };
        let (abi, metadata, limits) = (file.abi, file.metadata, limits.clone());
        Ok(Self(Arc::new(Inner { abi, metadata, sha256, limits, code })))
    }

    /// Starts a command that speaks the worker protocol on its standard input and output (`docs/worker-protocol.md`)
    /// and asks it what it is. It may do all that the user may do.
    ///
    /// # Errors
    /// Returns an error if the command can't be started or doesn't introduce itself as a planner of this version of the
    /// interface.
    pub fn command(words: &[OsString], limits: &Limits) -> Result<Self, LoadError> {
        let (plugin, abi, metadata) = ProcessPlugin::command(words, limits)?;
        let (sha256, limits) = (command_hash(words), limits.clone());
        Ok(Self(Arc::new(Inner { abi, metadata, sha256, limits, code: Code::Command(plugin) })))
    }

    /// A planner that runs outside of the harness and is reached by `external`; `identity` is the hash by which records know it.
    #[must_use]
    pub fn external(
        kind: PluginKind,
        metadata: Metadata,
        identity: &str,
        limits: &Limits,
        external: Arc<dyn External>,
    ) -> Self {
        Self(Arc::new(Inner {
            abi: AbiVersion::NEWEST,
            metadata,
            sha256: identity.to_owned(),
            limits: limits.clone(),
            code: Code::External(kind, external),
        }))
    }

    /// Descriptions of departures from repeatable results, such as a dependence on the speed of the machine. Results are marked with them.
    #[must_use]
    pub fn departures(&self) -> Vec<String> {
        match &self.0.code {
            Code::External(_, external) => external.departures(),
            Code::Wasm(_) | Code::Native(..) | Code::Command(_) => Vec::new(),
        }
    }

    /// The settings that a run must have with this planner: fields of run.json and their values as JSON.
    #[must_use]
    pub fn requires(&self) -> Vec<(&'static str, String)> {
        match &self.0.code {
            Code::External(_, external) => external.requires(),
            Code::Wasm(_) | Code::Native(..) | Code::Command(_) => Vec::new(),
        }
    }

    /// The confinement of the process of a native library; `None` for other plugins.
    #[must_use]
    pub fn sandbox(&self) -> Option<&SandboxReport> {
        match &self.0.code {
            Code::Native(_, sandbox) => Some(sandbox),
            Code::Wasm(_) | Code::Command(_) | Code::External(..) => None,
        }
    }

    #[must_use]
    pub fn abi(&self) -> AbiVersion {
        self.0.abi
    }

    #[must_use]
    pub fn metadata(&self) -> &Metadata {
        &self.0.metadata
    }

    /// The SHA-256 of the plugin file, hexadecimal; for a command, that of its words and of the content of those that
    /// are files; for an external planner, what was given as its identity.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.0.sha256
    }

    #[must_use]
    pub fn kind(&self) -> PluginKind {
        match self.0.code {
            Code::Wasm(_) => PluginKind::Wasm,
            Code::Native(..) => PluginKind::Native,
            Code::Command(_) => PluginKind::Command,
            Code::External(kind, _) => kind,
        }
    }

    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// All declared parameters with the user's values or the defaults, for [`Task::params`].
    ///
    /// # Errors
    /// Returns an error if the user gives a parameter that the planner doesn't declare, or one twice, or a value of another kind than the
    /// default.
    pub fn params(&self, given: &[(String, String)]) -> Result<Vec<Param>, ParamError> {
        resolve_params(self.metadata(), given)
    }

    /// Starts a planner on a task, in a store of its own.
    ///
    /// # Errors
    /// Returns an error if the planner fails in `init`.
    pub fn start(&self, task: &Task, log: LogSink) -> Result<Session, PlannerFault> {
        let inner = match &self.0.code {
            Code::Wasm(plugin) => {
                plugin.start(task, log, &self.0.limits).map(|s| SessionKind::Wasm(Box::new(s)))
            }
            Code::Native(plugin, _) | Code::Command(plugin) => {
                plugin.start(task, log, &self.0.limits).map(|s| SessionKind::Process(Box::new(s)))
            }
            Code::External(_, external) => {
                let mut log = Log::new(log, self.0.limits.log_bytes);
                external
                    .start(task, Box::new(move |level, line| log.write(level, line)))
                    .map(SessionKind::External)
            }
        };
        let inner = inner.map_err(|cause| PlannerFault { step: None, time: None, cause: cause.in_init() })?;
        Ok(Session { inner, steps: 0, failed: None })
    }
}

/// What a parameter's values are, as its default says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Number,
    Truth,
}

impl Kind {
    /// The kind of a default; none for texts, which may be anything.
    fn of(default: &str) -> Option<Self> {
        [Self::Number, Self::Truth].into_iter().find(|kind| kind.has(default))
    }

    fn has(self, value: &str) -> bool {
        match self {
            Self::Number => value.trim().parse::<f64>().is_ok_and(f64::is_finite),
            Self::Truth => matches!(value.trim(), "true" | "false"),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Number => "a number",
            Self::Truth => "true or false",
        }
    }
}

/// All declared parameters with the user's values or the defaults.
///
/// # Errors
/// Returns an error if the user gives a parameter that the planner doesn't declare, or one twice, or if the default is a number, or a truth
/// value, and the user's value is none.
pub fn resolve_params(metadata: &Metadata, given: &[(String, String)]) -> Result<Vec<Param>, ParamError> {
    for (i, (key, value)) in given.iter().enumerate() {
        let declared = metadata.params.iter().find(|p| p.key == *key);
        if let Some(p) = declared
            && let Some(kind) = Kind::of(&p.default)
            && !kind.has(value)
        {
            let help = if p.help.is_empty() { String::new() } else { format!(" ({})", p.help) };
            let (key, value, default) = (key.clone(), value.clone(), p.default.clone());
            return Err(ParamError::Kind { key, value, kind: kind.name(), help, default });
        }
        if declared.is_none() {
            let known: Vec<&str> = metadata.params.iter().map(|p| p.key.as_str()).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(ParamError::Unknown { key: key.clone(), planner: metadata.name.clone(), known });
        }
        if given[..i].iter().any(|(k, _)| k == key) {
            return Err(ParamError::Twice { key: key.clone() });
        }
    }
    let value = |key: &str| given.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone());
    let param = |p: &vb_sdk::metadata::ParamSpec| Param {
        key: p.key.clone(),
        value: value(&p.key).unwrap_or_else(|| p.default.clone()),
    };
    Ok(metadata.params.iter().map(param).collect())
}

/// A planner at work on one task. It stays on the thread that started it.
#[derive(Debug)]
pub struct Session {
    inner: SessionKind,
    steps: u64,
    failed: Option<PlannerFault>,
}

#[derive(Debug)]
enum SessionKind {
    Wasm(Box<WasmSession>),
    Process(Box<ProcessSession>),
    External(Box<dyn ExternalSession>),
}

/// The fuel that a session has used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct FuelMeter {
    /// The fuel for start-up and `init`.
    pub init: u64,
    /// The fuel for all steps together.
    pub steps: u64,
    pub last_step: u64,
    pub max_step: u64,
}

impl Session {
    /// Takes one step of the planner. The command that it returns is finite but may be out of range: see [`Command::clamped`].
    ///
    /// # Errors
    /// Returns an error if the planner fails or its command is not finite. The session is over then; any further call
    /// gives the same fault.
    pub fn step(&mut self, observation: &Observation) -> Result<Command, PlannerFault> {
        if let Some(fault) = &self.failed {
            return Err(fault.clone());
        }
        let result = match &mut self.inner {
            SessionKind::Wasm(session) => session.step(observation),
            SessionKind::Process(session) => session.step(observation),
            SessionKind::External(session) => session.step(observation),
        };
        let step = self.steps;
        self.steps += 1;
        result.and_then(finite).map_err(|cause| {
            let fault = PlannerFault { step: Some(step), time: Some(observation.time), cause };
            self.failed = Some(fault.clone());
            fault
        })
    }

    /// The most linear memory that the planner had until now, bytes; `None` for native plugins and commands, which are not metered.
    #[must_use]
    pub fn memory_bytes(&self) -> Option<u64> {
        match &self.inner {
            SessionKind::Wasm(session) => Some(session.memory_bytes()),
            SessionKind::Process(_) | SessionKind::External(_) => None,
        }
    }

    /// The fuel used until now, `init` included; `None` for native plugins and commands, which are not metered.
    #[must_use]
    pub fn fuel_used(&self) -> Option<u64> {
        self.fuel().map(|f| f.init + f.steps)
    }

    /// The fuel used until now in detail; `None` for native plugins and commands.
    #[must_use]
    pub fn fuel(&self) -> Option<FuelMeter> {
        match &self.inner {
            SessionKind::Wasm(session) => Some(session.fuel()),
            SessionKind::Process(_) | SessionKind::External(_) => None,
        }
    }
}

fn finite(command: Command) -> Result<Command, FaultCause> {
    let fields = [("steering", command.steering), ("throttle", command.throttle), ("brake", command.brake)];
    match fields.into_iter().find(|(_, v)| !v.is_finite()) {
        // The sign of a NaN is not portable, so only its kind is told.
        Some((field, v)) => {
            let value = if v.is_nan() { "NaN".to_owned() } else { v.to_string() };
            Err(FaultCause::InvalidOutput { field, value })
        }
        None => Ok(command),
    }
}

/// SHA-256 of a command: of each word its length and text, and its content if it is a file.
fn command_hash(words: &[OsString]) -> String {
    let mut hash = Hash::new();
    let mut part = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    for word in words {
        part(word.as_encoded_bytes());
        let content = Some(Path::new(word)).filter(|p| p.is_file()).and_then(|p| std::fs::read(p).ok());
        part(&content.unwrap_or_default());
    }
    hash.hex()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::metadata::ParamSpec;

    fn command(steering: f64, throttle: f64, brake: f64) -> Command {
        Command { steering, throttle, brake, ..Command::default() }
    }

    #[test]
    fn commands_that_are_not_finite_are_faults() {
        let cause = |field, value: &str| Err(FaultCause::InvalidOutput { field, value: value.into() });
        assert_eq!(finite(command(f64::NAN, 0.0, 0.0)), cause("steering", "NaN"));
        assert_eq!(finite(command(0.0, f64::INFINITY, 0.0)), cause("throttle", "inf"));
        assert_eq!(finite(command(0.0, 0.0, f64::NEG_INFINITY)), cause("brake", "-inf"));
        assert_eq!(finite(command(9.0, 0.0, 0.0)), Ok(command(9.0, 0.0, 0.0)));
    }

    #[test]
    fn parameters_are_the_declared_ones_with_the_users_values() {
        let spec = |k: &str, d: &str| ParamSpec { key: k.into(), default: d.into(), help: String::new() };
        let metadata = Metadata {
            abi: "1.0".into(),
            name: "pid".into(),
            version: String::new(),
            authors: vec![],
            about: String::new(),
            control_period: 0.1,
            params: vec![spec("speed", "3.0"), spec("kp", "1.0")],
            needs: Vec::new(),
            needs_without_maps: Vec::new(),
            models: Vec::new(),
        };
        let given =
            |l: &[(&str, &str)]| l.iter().map(|(k, v)| ((*k).into(), (*v).into())).collect::<Vec<_>>();
        let params = resolve_params(&metadata, &given(&[("kp", "2")])).unwrap();
        let found: Vec<_> = params.iter().map(|p| (p.key.as_str(), p.value.as_str())).collect();
        assert_eq!(found, [("speed", "3.0"), ("kp", "2")]);
        let message = resolve_params(&metadata, &given(&[("sped", "2")])).unwrap_err().to_string();
        assert_eq!(message, "--param sped: the planner `pid` has no such parameter; it has speed, kp");
        assert!(resolve_params(&metadata, &given(&[("kp", "2"), ("kp", "3")])).is_err());
    }
}
