//! Planners in processes of their own: native libraries, which the harness's worker opens in a sandbox, and commands in
//! any language.
//!
//! Both speak the protocol of [`vb_worker::protocol`]. A process serves one session after another as long as it is
//! healthy; after any fault it is ended, and the next session gets a fresh one.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command as OsCommand, ExitCode};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde::Serialize;
use vb_sdk::metadata::{Metadata, Need, ParamSpec, is_control_period, is_name};
use vb_sdk::{Command, LogLevel, Observation, Task};
use vb_worker::protocol::{
    Asked, Empty, Failure, FailureKind, FrameError, Greeting, Introduction, Library, PROTOCOL, Reply, Request,
};
use vb_worker::sandbox::{self, OUT_OF_MEMORY, STACK_OVERFLOW, SandboxReport, system_call_name};

use crate::abi::AbiVersion;
use crate::fault::{FaultCause, ProcessEnd};
use crate::log::Log;
use crate::process::{End, Process, Trouble};
use crate::system::{self, Role};
use crate::wasm::compile;
use crate::{Limits, LoadError, LogSink};
use vb_files::{lock, one_line};

/// The argument that makes the worker of a program that is a worker among other things.
const WORKER_ARGUMENT: &str = "__worker";

/// How long a command may take until it has introduced itself. Interpreters load large libraries.
const HELLO: Duration = Duration::from_secs(120);
/// How long a command may take to leave when it is told to.
const BYE: Duration = Duration::from_secs(1);
/// A worker that has used so much processor time is not used for another task: its own limit is a day.
const WORN_OUT: Duration = Duration::from_secs(60 * 60);
/// Bytes of a message beside the data that the limits name.
const MESSAGE: usize = 64 << 10;

/// Whether the running program is a worker when it is started as one.
static SERVES: AtomicBool = AtomicBool::new(false);

/// Serves as a worker or a compiler if the program was started as one, and returns the code with which it is to end;
/// otherwise it returns `None`. A program calls it before anything else: a worker must be alone in its process. By this
/// call the host knows that it may start the program again.
pub fn serve_as_worker() -> Option<ExitCode> {
    let argument = std::env::args_os().nth(1).unwrap_or_default();
    if argument == WORKER_ARGUMENT {
        return Some(vb_worker::serve());
    }
    if argument == compile::ARGUMENT {
        return Some(compile::serve());
    }
    SERVES.store(true, Ordering::Relaxed);
    None
}

/// The way in which native plugins are run and WASM is compiled.
#[derive(Clone, Debug, Default)]
pub struct ProcessOptions {
    /// A program that begins with [`serve_as_worker`]; by default the one that is running.
    pub worker: Option<PathBuf>,
    /// Whether to refuse native plugins where the system can't confine them in every way.
    pub require_sandbox: bool,
    /// Whether to run native plugins where the system can't confine them at all.
    pub unconfined: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct ProcessPlugin(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    kind: Kind,
    /// What its processes are greeted with.
    abi: AbiVersion,
    memory_bytes: u64,
    max_message: usize,
    /// How long a process may take until it has introduced itself.
    hello: Duration,
    /// Healthy processes without a task.
    idle: Mutex<Vec<Process>>,
}

#[derive(Debug)]
enum Kind {
    /// The harness's worker with a library.
    Worker { program: PathBuf, library: Library },
    /// Somebody's program.
    Command { words: Vec<OsString> },
}

/// Why a process didn't introduce itself.
enum Refusal {
    Fault(FaultCause),
    Failure(Failure),
    /// It ended; with its last words.
    Ended(End),
}

impl ProcessPlugin {
    /// Opens a library in a worker and checks its layout. Every worker opens it only as long as its content has the
    /// given hash.
    pub(crate) fn load(
        path: &Path,
        sha256: &str,
        abi: AbiVersion,
        limits: &Limits,
        options: &ProcessOptions,
    ) -> Result<(Self, SandboxReport), LoadError> {
        if let Some(refusal) = refusal(system::HAS_NATIVE_PLANNERS, sandbox::EXISTS, options.unconfined) {
            return Err(LoadError::NotHere { path: path.into(), reason: refusal });
        }
        let io = |source| LoadError::Io { path: path.into(), source };
        // With a bare file name the system would search its library folders.
        let full = path.canonicalize().map_err(io)?;
        let text = full.to_str().ok_or_else(|| LoadError::Unloadable {
            path: path.into(),
            reason: "the names of its folders are not UTF-8; move it".into(),
        })?;
        let program = match &options.worker {
            Some(program) => program.clone(),
            None => this_program().map_err(io)?,
        };
        let library = Library {
            path: text.to_owned(),
            sha256: sha256.to_owned(),
            memory_bytes: limits.memory_bytes as u64,
            require_sandbox: options.require_sandbox,
        };
        let plugin = Self::new(Kind::Worker { program, library }, abi, limits);
        match plugin.spawn() {
            Ok((process, introduction)) => {
                plugin.put_back(process);
                Ok((plugin, introduction.sandbox.unwrap_or_default()))
            }
            Err(Refusal::Failure(failure)) => Err(explain(path, failure)),
            Err(Refusal::Fault(cause)) => Err(LoadError::Faulty { path: path.into(), cause }),
            Err(Refusal::Ended(end)) => {
                let cause = plugin.death(&end);
                Err(LoadError::Faulty { path: path.into(), cause })
            }
        }
    }

    /// Starts a command and asks it what it is.
    pub(crate) fn command(
        words: &[OsString],
        limits: &Limits,
    ) -> Result<(Self, AbiVersion, Metadata), LoadError> {
        let text: Vec<_> = words.iter().map(|w| w.to_string_lossy()).collect();
        let path = PathBuf::from(text.join(" "));
        // The greeting names the newest version; the reply may name any version of the window.
        let plugin = Self::new(Kind::Command { words: words.to_vec() }, AbiVersion::NEWEST, limits);
        match plugin.spawn() {
            Ok((process, introduction)) => {
                let (abi, metadata) = metadata(&path, introduction)?;
                plugin.put_back(process);
                Ok((plugin, abi, metadata))
            }
            Err(Refusal::Failure(failure)) => {
                let reason = one_line(&failure.message);
                Err(LoadError::Unloadable { path, reason })
            }
            Err(Refusal::Fault(cause)) => Err(LoadError::Faulty { path, cause }),
            Err(Refusal::Ended(end)) => {
                let last = end.words.last().map(|w| format!(": {}", one_line(w))).unwrap_or_default();
                let reason = format!("it exited before it sent its metadata ({}){last}", ended(end.how));
                Err(LoadError::Unloadable { path, reason })
            }
        }
    }

    fn new(kind: Kind, abi: AbiVersion, limits: &Limits) -> Self {
        let hello = match kind {
            // What a library does when it is opened is the first of its calls.
            Kind::Worker { .. } => Duration::from_millis(limits.watchdog_ms),
            Kind::Command { .. } => HELLO,
        };
        Self(Arc::new(Shared {
            kind,
            abi,
            hello,
            memory_bytes: limits.memory_bytes as u64,
            max_message: limits.output_bytes.saturating_add(MESSAGE),
            idle: Mutex::default(),
        }))
    }

    /// A process that has introduced itself.
    fn spawn(&self) -> Result<(Process, Introduction), Refusal> {
        let mut greeting = Greeting { protocol: PROTOCOL, abi: self.0.abi.name().to_owned(), library: None };
        let (mut command, role) = match &self.0.kind {
            Kind::Worker { program, library } => {
                greeting.library = Some(library.clone());
                let mut command = OsCommand::new(program);
                command.arg(WORKER_ARGUMENT).env_clear().current_dir("/");
                (command, Role::Worker)
            }
            Kind::Command { words } => {
                let (program, args) =
                    words.split_first().map_or((OsString::new(), &[][..]), |(p, a)| (p.clone(), a));
                let mut command = OsCommand::new(program);
                command.args(args);
                (command, Role::Command)
            }
        };
        system::prepare(&mut command, role);
        let started = Process::start(command, role, self.0.max_message);
        let mut process = started.map_err(|e| {
            let cause = FaultCause::Worker { message: one_line(&e.to_string()) };
            Refusal::Fault(cause)
        })?;
        // Words on standard error that precede the introduction are in the fault, if it comes to one.
        let mut log = Log::new(LogSink::discard(), 0);
        match process.ask(&Request::Hello(greeting), self.0.hello, &mut log) {
            Ok(Reply::Hello(introduction)) => {
                process
                    .seal(introduction.sandbox.is_some_and(|report| report.seccomp))
                    .map_err(|e| Refusal::Fault(FaultCause::Worker { message: one_line(&e.to_string()) }))?;
                Ok((process, introduction))
            }
            Ok(Reply::Error(failure)) => Err(match refused(&failure) {
                Some(cause) => Refusal::Fault(cause),
                None => Refusal::Failure(failure),
            }),
            Ok(other) => Err(Refusal::Fault(unexpected(other.name(), "hello"))),
            Err(Trouble::Gone) => Err(Refusal::Ended(process.end(&mut log))),
            Err(trouble) => Err(Refusal::Fault(self.trouble(&trouble, self.0.hello))),
        }
    }

    /// A healthy process, an idle one if there is one.
    fn take(&self) -> Result<Process, FaultCause> {
        loop {
            let idle = lock(&self.0.idle).pop();
            let Some(mut process) = idle else { break };
            // One that was ended from outside while it had no task is nobody's fault.
            if process.is_alive() {
                return Ok(process);
            }
        }
        self.spawn().map(|(process, _)| process).map_err(|refusal| match refusal {
            Refusal::Fault(cause) => cause,
            // It had been opened before: something on the machine has changed.
            Refusal::Failure(failure) => FaultCause::Worker { message: one_line(&failure.message) },
            Refusal::Ended(end) => self.death(&end),
        })
    }

    fn put_back(&self, process: Process) {
        let worn_out = matches!(self.0.kind, Kind::Worker { .. })
            && process.cpu_time().is_some_and(|used| used > WORN_OUT);
        if !worn_out {
            lock(&self.0.idle).push(process);
        }
    }

    /// What a process died of.
    fn death(&self, end: &End) -> FaultCause {
        /// What the worker and the allocators of Rust, C++ and Python say before they give up.
        const MEMORY: [&str; 4] = [OUT_OF_MEMORY, "memory allocation of ", "std::bad_alloc", "MemoryError"];
        if end.is_filtered && system::was_killed_by_others(end.how) {
            return FaultCause::killed("the planner's process");
        }
        let said = |text: &str| end.words.iter().any(|w| w.contains(text));
        if said(STACK_OVERFLOW) {
            FaultCause::ProcessStackOverflow { limit: system::stack_limit() }
        } else if MEMORY.iter().any(|text| said(text)) {
            let is_limited = matches!(self.0.kind, Kind::Worker { .. });
            FaultCause::ProcessOutOfMemory { limit: is_limited.then_some(self.0.memory_bytes) }
        } else {
            FaultCause::Crashed { how: end.how }
        }
    }

    fn trouble(&self, trouble: &Trouble, limit: Duration) -> FaultCause {
        match trouble {
            // Callers that can tell how it ended do.
            Trouble::Gone => FaultCause::Protocol { message: "it closed its output".into() },
            Trouble::Late => {
                FaultCause::Hung { limit_ms: u64::try_from(limit.as_millis()).unwrap_or(u64::MAX) }
            }
            Trouble::Nonsense(FrameError::TooLong { bytes, .. }) if is_text(*bytes) => FaultCause::Protocol {
                message: "text received instead of a message; print to standard error".into(),
            },
            Trouble::Nonsense(FrameError::TooLong { .. }) => {
                FaultCause::OutputTooLarge { limit: self.0.max_message as u64 }
            }
            Trouble::Nonsense(e) => FaultCause::Protocol { message: one_line(&e.to_string()) },
            Trouble::Unasked(name) => {
                FaultCause::Protocol { message: format!("it sent an unexpected `{name}`") }
            }
            Trouble::System(e) => FaultCause::Machine { message: one_line(&e.to_string()) },
        }
    }

    pub(crate) fn start(
        &self,
        task: &Task,
        sink: LogSink,
        limits: &Limits,
    ) -> Result<ProcessSession, FaultCause> {
        let process = self.take()?;
        let mut session = ProcessSession {
            plugin: self.clone(),
            process: Some(process),
            log: Log::new(sink, limits.log_bytes),
            limit: Duration::from_millis(limits.watchdog_ms),
        };
        match session.init(task)? {
            Reply::Ready(_) => Ok(session),
            other => Err(session.fail(unexpected(other.name(), "ready"))),
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        let idle = std::mem::take(self.idle.get_mut().unwrap_or_else(PoisonError::into_inner));
        if matches!(self.kind, Kind::Command { .. }) {
            for mut process in idle {
                process.farewell(BYE);
            }
        }
    }
}

/// A planner in a process, at work on a task.
#[derive(Debug)]
pub(crate) struct ProcessSession {
    plugin: ProcessPlugin,
    /// None after a fault.
    process: Option<Process>,
    log: Log,
    limit: Duration,
}

impl ProcessSession {
    fn init(&mut self, task: &Task) -> Result<Reply, FaultCause> {
        self.ask(&Asked::Init(task))
    }

    pub(crate) fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause> {
        let reply = self.ask(&Asked::Step(observation));
        match reply? {
            Reply::Command(command) => Ok(command),
            other => Err(self.fail(unexpected(other.name(), "command"))),
        }
    }

    /// Asks the process; after a fault there is none any more.
    fn ask(&mut self, request: &impl Serialize) -> Result<Reply, FaultCause> {
        let Some(process) = &mut self.process else {
            return Err(FaultCause::Protocol { message: "its process is gone".into() });
        };
        let cause = match process.ask(request, self.limit, &mut self.log) {
            Ok(Reply::Error(failure)) => match refused(&failure) {
                Some(cause) => {
                    if failure.kind == FailureKind::Panic {
                        // As the panic hook of a WASM plugin does.
                        self.log.write(LogLevel::Error, &failure.message);
                    }
                    cause
                }
                None => unexpected("error", "another kind of error"),
            },
            Ok(reply) => return Ok(reply),
            Err(Trouble::Gone) => {
                let end = process.end(&mut self.log);
                self.plugin.death(&end)
            }
            Err(trouble) => self.plugin.trouble(&trouble, self.limit),
        };
        Err(self.fail(cause))
    }

    fn fail(&mut self, cause: FaultCause) -> FaultCause {
        if let Some(mut process) = self.process.take() {
            process.kill(&mut self.log);
        }
        cause
    }
}

impl Drop for ProcessSession {
    fn drop(&mut self) {
        let Some(mut process) = self.process.take() else { return };
        // The task is over and judged: a planner that fails now only loses its process.
        let reply = process.ask(&Request::Drop(Empty {}), self.limit, &mut self.log);
        if matches!(reply, Ok(Reply::Dropped(_))) {
            self.plugin.put_back(process);
        }
    }
}

/// Why native plugins don't run on a system, by whether it can open them, whether it can confine them, and whether the user
/// lets them run without that.
fn refusal(is_possible: bool, has_sandbox: bool, unconfined: bool) -> Option<&'static str> {
    match (is_possible, has_sandbox) {
        (false, _) => {
            Some("the harness opens native plugins on Unix systems only; use the planner's WASM file")
        }
        (true, false) if !unconfined => Some(
            "this system has no sandbox for native plugins, so it would have all your permissions; use the planner's WASM file, or \
             set VB_UNCONFINED=1 if you trust it",
        ),
        _ => None,
    }
}

/// Whether the length of a message is four characters of text.
fn is_text(length: usize) -> bool {
    u32::try_from(length)
        .is_ok_and(|n| n.to_le_bytes().iter().all(|b| matches!(b, b'\t' | b'\n' | b'\r' | b' '..=b'~')))
}

fn unexpected(found: &str, wanted: &str) -> FaultCause {
    FaultCause::Protocol { message: format!("it answered `{found}` instead of `{wanted}`") }
}

/// The cause of a failure that planners may have; none for those of opening a library.
fn refused(failure: &Failure) -> Option<FaultCause> {
    let message = one_line(&failure.message);
    match failure.kind {
        FailureKind::Error => Some(FaultCause::Error { message }),
        FailureKind::Panic => Some(FaultCause::Panic { message }),
        FailureKind::InvalidOutput => Some(FaultCause::BadCommand { message }),
        FailureKind::Denied => {
            let import = message.parse().map_or_else(|_| message.clone(), system_call_name);
            Some(FaultCause::ImportDenied { import })
        }
        FailureKind::NotAPlugin
        | FailureKind::LayoutMismatch
        | FailureKind::Unloadable
        | FailureKind::Sandbox => None,
    }
}

fn explain(path: &Path, failure: Failure) -> LoadError {
    let (path, reason) = (path.into(), one_line(&failure.message));
    match failure.kind {
        FailureKind::NotAPlugin => LoadError::NotAPlugin { path, reason },
        FailureKind::LayoutMismatch => LoadError::LayoutMismatch { path, reason },
        FailureKind::Sandbox => LoadError::Faulty { path, cause: FaultCause::Worker { message: reason } },
        _ => LoadError::Unloadable { path, reason },
    }
}

fn ended(how: ProcessEnd) -> String {
    match how {
        ProcessEnd::Exit(code) => format!("exit code {code}"),
        ProcessEnd::Signal(signal) => format!("signal {signal}"),
        ProcessEnd::Mute => "it closed its output without exiting".into(),
    }
}

/// What a command says of itself, checked as the metadata of a file are.
fn metadata(path: &Path, said: Introduction) -> Result<(AbiVersion, Metadata), LoadError> {
    let path = PathBuf::from(path);
    let not_a_plugin = |reason: String| LoadError::NotAPlugin { path: path.clone(), reason };
    if said.protocol != PROTOCOL {
        return Err(not_a_plugin(format!(
            "it uses version {} of the worker protocol, the harness version {PROTOCOL}",
            said.protocol
        )));
    }
    let Some(abi) = AbiVersion::find(&said.abi) else {
        return Err(LoadError::AbiVersion { path, found: one_line(&said.abi) });
    };
    if !is_name(&said.name) {
        return Err(not_a_plugin(format!(
            "its name is `{}`; want a-z, 0-9, - and _ only",
            one_line(&said.name)
        )));
    }
    if !is_control_period(said.control_period) {
        return Err(not_a_plugin(format!(
            "its control period is {} s; want a positive multiple of 0.001",
            said.control_period
        )));
    }
    let needs = |texts: &[String]| {
        let mut needs = Vec::new();
        for text in texts {
            Need::add(&mut needs, text).map_err(|reason| not_a_plugin(one_line(&reason)))?;
        }
        Ok::<_, LoadError>(needs)
    };
    let (needs, needs_without_maps) = (needs(&said.needs)?, needs(&said.needs_without_maps)?);
    let param =
        |p: vb_worker::protocol::WireParamSpec| ParamSpec { key: p.key, default: p.default, help: p.help };
    let metadata = Metadata {
        abi: said.abi,
        name: said.name,
        version: said.version,
        authors: said.authors,
        about: said.about,
        control_period: said.control_period,
        params: said.params.into_iter().map(param).collect(),
        needs,
        needs_without_maps,
        models: said.models,
    };
    Ok((abi, metadata))
}

/// The program that compiles; none if the running one would not know what it is asked.
pub(crate) fn compiler(options: &ProcessOptions) -> Option<PathBuf> {
    let own = || SERVES.load(Ordering::Relaxed).then(this_program)?.ok();
    options.worker.clone().or_else(own)
}

/// The program that is running; on Linux even if its file has been replaced since.
fn this_program() -> std::io::Result<PathBuf> {
    let link = Path::new("/proc/self/exe");
    if cfg!(target_os = "linux") && link.exists() { Ok(link.into()) } else { std::env::current_exe() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn native_plugins_are_refused_where_nothing_confines_them() {
        assert_eq!(refusal(true, true, false), None);
        let told = refusal(true, false, false).unwrap();
        assert!(told.contains("no sandbox") && told.contains("VB_UNCONFINED=1"), "{told}");
        assert_eq!(refusal(true, false, true), None);
        // Where there is no worker, nobody's word helps.
        assert!(refusal(false, false, true).unwrap().contains("WASM"));
    }

    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    #[test]
    fn linux_confines_them() {
        assert_eq!(refusal(system::HAS_NATIVE_PLANNERS, sandbox::EXISTS, false), None);
    }
}
