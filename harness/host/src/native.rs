//! Native plugins: libraries with an `abi_stable` root module, in the harness's own process.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use abi_stable::library::{LibraryError, lib_header_from_path};
use abi_stable::std_types::{RErr, ROk, RStr};
use vb_sdk::native::{Fault, LogCallback, NativeObservation, NativeTask, PlannerModuleRef};
use vb_sdk::{Command, LogLevel, Observation, Task};

use crate::fault::FaultCause;
use crate::log::Log;
use crate::text::one_line;
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
        LibraryError::AbiInstability(report) => {
            LoadError::LayoutMismatch { path, reason: first_difference(&report.to_string()) }
        }
        LibraryError::IncompatibleVersionNumber { expected_version, actual_version, .. } => {
            let reason =
                format!("it was built with vb-sdk {actual_version}, the harness with {expected_version}");
            LoadError::LayoutMismatch { path, reason }
        }
        LibraryError::InvalidAbiHeader(_) => LoadError::LayoutMismatch {
            path,
            reason: "it was built with another version of abi_stable".into(),
        },
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

/// The gist of `abi_stable`'s report on two layouts, which goes over hundreds of lines: the innermost field before the
/// first `Error:`, the type that it belongs to, and what is wrong with it.
fn first_difference(report: &str) -> String {
    let Some((before, error)) = report.split_once("\nError:") else {
        return "its types differ".into();
    };
    let place = before.rsplit_once("\nLayout of expected type:").map_or(before, |(place, _)| place);
    let value = |prefix: &'static str| place.lines().rev().filter_map(move |l| l.trim().strip_prefix(prefix));
    let field = value("field_name:").next().unwrap_or("a field");
    // The last type is the field's own, the one before it that of its owner.
    let owner = value("type:").nth(1).unwrap_or("the root module");
    // Further errors follow after an empty line.
    let error = error.split("\n\n").next().unwrap_or_default();
    format!("{field} of {}: {}", owner.trim(), one_line(error))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_report_is_cut_down_to_the_field() {
        // As abi_stable 0.11.3 reports a field that changed from f64 to f32, without most of its lines.
        let report = "Compared <this>:\n    --- Type Layout ---\n    type:PrefixRef<'a, PlannerModule>\nTo <other>:\n\
            0 error(s).\n\n1 error(s)inside:\n    <other>\n\n    field_name:task,log,\n    type:&'a  NativeTask<'a> \n\n    \
            field_name:0\n    type:NativeTask<'a>\n    size:408 align:8\n\n    field_name:goal_radius\n    type:f32\n    \
            size:4 align:4\n\nLayout of expected type:\n    --- Type Layout ---\n    type:f64\n\nLayout of found type:\n    \
            type:f32\n\n\n\nError:mismatched type\nExpected:\n    f64\nFound:\n    f32\n\n";
        let expected = "goal_radius of NativeTask<'a>: mismatched type Expected: f64 Found: f32";
        assert_eq!(first_difference(report), expected);
        assert_eq!(first_difference("something else"), "its types differ");
    }
}
