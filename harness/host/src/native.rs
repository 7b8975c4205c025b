//! Native plugins: libraries with an `abi_stable` root module, in the harness's own process.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use abi_stable::library::{LibraryError, lib_header_from_path};
use abi_stable::std_types::{RErr, ROk, RStr};
use vb_sdk::native::{Fault, LogCallback, NativeObservation, NativeTask, PlannerModuleRef};
use vb_sdk::{Command, LogLevel, Observation, Task};

use crate::fault::{FaultCause, one_line};
use crate::log::Log;
use crate::{LoadError, LogSink};

/// Opens a library and checks its layout. The library stays open as long as the process.
pub(crate) fn load(path: &Path) -> Result<PlannerModuleRef, LoadError> {
    // With a bare file name the system would search its library folders.
    let full = path.canonicalize().map_err(|source| LoadError::Io { path: path.into(), source })?;
    let header = lib_header_from_path(&full).map_err(|e| explain(path, &e))?;
    header.init_root_module::<PlannerModuleRef>().map_err(|e| explain(path, &e))
}

fn explain(path: &Path, error: &LibraryError) -> LoadError {
    let path = path.into();
    match error {
        LibraryError::AbiInstability(_)
        | LibraryError::IncompatibleVersionNumber { .. }
        | LibraryError::InvalidAbiHeader(_) => {
            LoadError::LayoutMismatch { path, reason: one_line(&error.to_string()) }
        }
        LibraryError::GetSymbolError { .. } => LoadError::NotAPlugin {
            path,
            reason:
                "the library has no planner root module; planners are exported by vb_sdk::export_planner!"
                    .into(),
        },
        LibraryError::OpenError { err, .. } => {
            // The text of the error itself is only "dlopen failed".
            let reason = std::error::Error::source(err).map_or_else(|| err.to_string(), ToString::to_string);
            LoadError::Unloadable { path, reason: one_line(&reason) }
        }
        other => LoadError::Unloadable { path, reason: one_line(&other.to_string()) },
    }
}

/// A planner of a native plugin at work on a task.
#[derive(Debug)]
pub(crate) struct NativeSession {
    module: PlannerModuleRef,
    planner: *mut (),
    log: Box<Log>,
}

impl NativeSession {
    pub(crate) fn start(
        module: PlannerModuleRef,
        task: &Task,
        sink: LogSink,
        log_bytes: usize,
    ) -> Result<Self, FaultCause> {
        let mut log = Box::new(Log::new(sink, log_bytes));
        match module.init()(&NativeTask::from(task), callback(&mut log)) {
            ROk(planner) => Ok(Self { module, planner, log }),
            RErr(fault) => Err(cause(&fault, &mut log)),
        }
    }

    pub(crate) fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause> {
        let observation = NativeObservation::from(observation);
        // SAFETY: `planner` comes from this module's `init`, and `&mut self` keeps others away.
        let result = unsafe { self.module.step()(self.planner, &observation, callback(&mut self.log)) };
        match result {
            ROk(command) => Ok(command.into()),
            RErr(fault) => Err(cause(&fault, &mut self.log)),
        }
    }
}

impl Drop for NativeSession {
    fn drop(&mut self) {
        // SAFETY: `planner` comes from this module's `init` and is used no more.
        unsafe { self.module.free()(self.planner) };
    }
}

fn cause(fault: &Fault, log: &mut Log) -> FaultCause {
    if fault.panicked {
        // As the panic hook of a WASM plugin does.
        log.write(LogLevel::Error, &fault.message);
        FaultCause::Panic { message: one_line(&fault.message) }
    } else {
        FaultCause::Error { message: one_line(&fault.message) }
    }
}

fn callback(log: &mut Log) -> LogCallback {
    LogCallback { context: std::ptr::from_mut(log).cast(), write }
}

unsafe extern "C" fn write(context: *mut (), level: u8, message: RStr<'_>) {
    // SAFETY: `context` is the log that `callback` was given, alive and unused by others during the call.
    let log = unsafe { &mut *context.cast::<Log>() };
    let level = match level {
        0 => LogLevel::Error,
        1 => LogLevel::Warn,
        2 => LogLevel::Info,
        _ => LogLevel::Debug,
    };
    // A panicking sink must not unwind into the plugin.
    let _ = catch_unwind(AssertUnwindSafe(|| log.write(level, &message)));
}
