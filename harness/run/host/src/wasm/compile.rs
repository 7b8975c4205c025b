//! Compiling a plugin, in a process of its own.
//!
//! A compiler's time and memory are no fixed multiple of the code's size: forty kilobytes of nested loops can take
//! gigabytes. So it runs where the system can stop it, in the harness's own program started again, with limits of
//! memory and processor time and with nothing but two pipes. What it sends back is as trusted as what a compiler in this
//! process would give: it is this harness's compiler that made it.

use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use vb_worker::protocol::{self, HEADER};
use vb_worker::sandbox;
use wasmtime::Engine;

use super::{componentize, engine, is_of_the_system};
use crate::fault::FaultCause;
use crate::inspect::{Format, PluginFile};
use crate::log::Log;
use crate::process::{Process, Trouble};
use crate::system::{self, Role};
use crate::{Limits, LoadError, LogSink};
use vb_files::one_line;

/// The argument that makes the compiler of a program that is one among other things.
pub(crate) const ARGUMENT: &str = "__compile";

/// The compiler works without pause, so that by the wall clock it takes longer than its processor time only where the
/// machine is overloaded: a compiler that takes so many times its processor time is given up.
const PATIENCE: u64 = 20;
/// Threads of the compiler: each has memory of its own, and the limit of memory is for all together.
const MOST_THREADS: usize = 8;

/// What the compiler is to do.
#[derive(Serialize, Deserialize)]
struct Order {
    limits: Limits,
    core_module: bool,
    #[serde(with = "serde_bytes")]
    bytes: Vec<u8>,
}

/// What came of it.
#[derive(Serialize, Deserialize)]
enum Outcome {
    /// The code, as the engine serializes it.
    Compiled(#[serde(with = "serde_bytes")] Vec<u8>),
    Refused(Refusal),
}

/// Why there is no code.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Refusal {
    NotAPlugin(String),
    ForbiddenImports(Vec<String>),
    Unloadable(String),
    /// The system gave no more memory.
    OutOfMemory,
}

/// Compiles a plugin for the engine; by `program`, if there is one, within the limits.
pub(super) fn compile(
    path: &Path,
    file: &PluginFile,
    engine: &Engine,
    limits: &Limits,
    program: Option<&Path>,
) -> Result<Vec<u8>, LoadError> {
    let core_module = matches!(file.format, Format::CoreModule);
    let outcome = match program {
        Some(program) => {
            let order = Order { limits: limits.clone(), core_module, bytes: file.bytes.clone() };
            elsewhere(path, &order, program)?
        }
        None => here(engine, core_module, &file.bytes),
    };
    let path = path.to_owned();
    match outcome {
        Outcome::Compiled(code) => Ok(code),
        Outcome::Refused(Refusal::NotAPlugin(reason)) => Err(LoadError::NotAPlugin { path, reason }),
        Outcome::Refused(Refusal::ForbiddenImports(imports)) => {
            Err(LoadError::ForbiddenImports { path, imports })
        }
        Outcome::Refused(Refusal::Unloadable(reason)) => Err(LoadError::Unloadable { path, reason }),
        Outcome::Refused(Refusal::OutOfMemory) => Err(out_of_memory(&path, limits)),
    }
}

fn here(engine: &Engine, core_module: bool, bytes: &[u8]) -> Outcome {
    let code = if core_module {
        componentize(bytes).and_then(|component| compiled(engine, &component))
    } else {
        compiled(engine, bytes)
    };
    code.map_or_else(Outcome::Refused, Outcome::Compiled)
}

fn compiled(engine: &Engine, component: &[u8]) -> Result<Vec<u8>, Refusal> {
    match vb_nan::rewrite(component) {
        Ok(rewritten) => precompiled(engine, &rewritten),
        // What is wrong with a component the engine tells as it does for others. It never runs as it is.
        Err(unfit) => Err(precompiled(engine, component)
            .err()
            .unwrap_or_else(|| Refusal::Unloadable(one_line(&unfit.to_string())))),
    }
}

fn precompiled(engine: &Engine, component: &[u8]) -> Result<Vec<u8>, Refusal> {
    engine.precompile_component(component).map_err(|e| {
        if is_of_the_system(&e) || e.is::<wasmtime::OutOfMemory>() {
            Refusal::OutOfMemory
        } else {
            Refusal::Unloadable(one_line(&format!("{e:#}")))
        }
    })
}

fn elsewhere(path: &Path, order: &Order, program: &Path) -> Result<Outcome, LoadError> {
    let limits = &order.limits;
    let faulty = |cause| LoadError::Faulty { path: path.into(), cause };
    let system = |e: io::Error| faulty(FaultCause::Worker { message: one_line(&e.to_string()) });
    let mut command = Command::new(program);
    command.arg(ARGUMENT).env_clear().current_dir("/");
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get().min(MOST_THREADS));
    command.env("RAYON_NUM_THREADS", threads.to_string());
    system::prepare(&mut command, Role::Compiler);
    let mut process = Process::start(command, Role::Compiler, limits.compile_bytes).map_err(system)?;
    let patience = Duration::from_secs(limits.compile_seconds.saturating_mul(PATIENCE));
    let mut log = Log::new(LogSink::discard(), 0);
    match process.order(order, patience, &mut log) {
        Ok(outcome) => Ok(outcome),
        Err(Trouble::Gone) => {
            let end = process.end(&mut log);
            let said = end.words.last().map(|w| format!(": {}", one_line(w))).unwrap_or_default();
            Err(match end.how {
                how if system::used_up_time(how) => LoadError::TooCostly {
                    path: path.into(),
                    what: "seconds of processor time",
                    limit: limits.compile_seconds,
                    field: "compile_seconds",
                },
                how if system::was_killed(how) => faulty(FaultCause::killed("the compiler")),
                // What Rust says before it gives up.
                _ if end.words.iter().any(|w| w.contains("memory allocation of ")) => {
                    out_of_memory(path, limits)
                }
                how => LoadError::Unloadable {
                    path: path.into(),
                    reason: format!("the compiler failed: {how}{said}"),
                },
            })
        }
        Err(Trouble::Late) => Err(faulty(FaultCause::Machine {
            message: format!(
                "compiling took more than {} s of wall-clock time within its limit of {} s of processor time",
                patience.as_secs(),
                limits.compile_seconds
            ),
        })),
        Err(Trouble::System(e)) => Err(system(e)),
        Err(Trouble::Nonsense(e)) => Err(system(io::Error::other(format!(
            "{} is not the compiler of this harness ({e})",
            program.display()
        )))),
        Err(Trouble::Unasked(name)) => Err(system(io::Error::other(format!("it sent `{name}`")))),
    }
}

/// Whose fault it is that there was no more memory: the plugin's if it had all that it may have.
fn out_of_memory(path: &Path, limits: &Limits) -> LoadError {
    let path = path.to_owned();
    let wanted = limits.compile_bytes as u64;
    match system::memory_granted().filter(|granted| *granted < wanted) {
        Some(granted) => LoadError::Faulty {
            path,
            cause: FaultCause::Machine {
                message: format!(
                    "not enough memory to compile it: the system provides {granted} bytes (ulimit) of {wanted}"
                ),
            },
        },
        None => LoadError::TooCostly { path, what: "bytes of memory", limit: wanted, field: "compile_bytes" },
    }
}

/// Compiles one plugin that comes on standard input, and sends the code to standard output. Nothing else may run in the
/// process.
pub(crate) fn serve() -> ExitCode {
    match answer() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // There is nobody else to tell.
            let _ = writeln!(io::stderr(), "compiler: {error}");
            ExitCode::FAILURE
        }
    }
}

fn answer() -> io::Result<()> {
    let mut frame = Vec::new();
    let mut header = [0; HEADER];
    io::stdin().read_exact(&mut header)?;
    let length = u64::from(u32::from_le_bytes(header));
    io::stdin().take(length).read_to_end(&mut frame)?;
    let order: Order = protocol::decode(&frame).map_err(io::Error::other)?;
    drop(frame);
    // Whatever sets up signals and asks what the machine can do comes before the confinement.
    let engine = engine::new(&order.limits).map_err(|e| io::Error::other(format!("{e:#}")))?;
    sandbox::confine_compiler(order.limits.compile_bytes as u64, order.limits.compile_seconds)?;
    let outcome = here(&engine, order.core_module, &order.bytes);
    let mut out = Vec::new();
    protocol::encode(&outcome, &mut out).map_err(io::Error::other)?;
    io::stdout().write_all(&out)
}
