//! Opening a native plugin and calling it, whichever of the two interfaces it has.

use std::ffi::{CStr, CString};
use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use abi_stable::library::LibHeader;
use abi_stable::library::{LibraryError, RawLibrary, lib_header_from_path};
use abi_stable::std_types::{RErr, ROk, RResult, RStr};
use vb_abi_v0_1::native as old;
use vb_files::Hash;
use vb_sdk::c::ENTRY;
use vb_sdk::native::PlannerModuleRef;
use vb_sdk::{Command, LogLevel, Observation, Task};

use crate::calls::Functions;
use crate::protocol::{Failure, FailureKind};
use crate::v0_1;

/// A version of the interface that libraries may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Abi {
    V0_1,
    V0_2,
}

impl Abi {
    pub(crate) fn find(name: &str) -> Option<Self> {
        match name {
            "0.1" => Some(Self::V0_1),
            vb_sdk::ABI_VERSION => Some(Self::V0_2),
            _ => None,
        }
    }
}

/// An open library.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Library {
    /// Of the newest version, in any language.
    Newest(Functions),
    /// Of version 0.1 with an `abi_stable` root module.
    OldRust(old::PlannerModuleRef),
    /// Of version 0.1 with `vb_planner_entry`.
    OldC(v0_1::c_abi::CPlanner),
}

/// What a file holds, and which file it is.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    /// Hexadecimal.
    pub(crate) sha256: String,
    /// Device, file, size, and time of the last change, of content or place, s and ns.
    file: [i64; 5],
}

impl Identity {
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let mut hash = Hash::new();
        let mut chunk = vec![0; 256 << 10];
        loop {
            let read = match file.read(&mut chunk) {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                other => other?,
            };
            if read == 0 {
                break;
            }
            hash.update(&chunk[..read]);
        }
        let sha256 = hash.hex();
        Ok(Self { sha256, file: which(&file.metadata()?) })
    }

    /// Whether a path still leads to the same file and nobody has written to it.
    pub(crate) fn is_still(&self, path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|m| which(&m) == self.file)
    }
}

fn which(m: &Metadata) -> [i64; 5] {
    [m.dev().cast_signed(), m.ino().cast_signed(), m.size().cast_signed(), m.ctime(), m.ctime_nsec()]
}

/// Opens a library and checks its layout. It stays open as long as the process.
pub(crate) fn open(path: &Path, abi: Abi) -> Result<Library, Failure> {
    resolve(path)?;
    // Stays open from here: looking for one interface and then the other must not load it twice.
    let raw = Box::leak(Box::new(RawLibrary::load_at(path).map_err(|e| explain(&e))?));
    match lib_header_from_path(path) {
        Ok(header) => of_rust(header, abi).map_err(|e| explain(&e)),
        Err(error @ LibraryError::GetSymbolError { .. }) => {
            // SAFETY: the symbol is a struct, so its address is what the pointer takes.
            let entry = unsafe { raw.get::<*const ()>(ENTRY) }.map_err(|_| explain(&error))?;
            // SAFETY: it is the address of the symbol, and the library is never closed.
            let library = unsafe {
                match abi {
                    Abi::V0_1 => v0_1::c_abi::CPlanner::new(entry.cast()).map(Library::OldC),
                    Abi::V0_2 => Functions::of_entry(entry.cast()).map(Library::Newest),
                }
            };
            library.map_err(|message| Failure { kind: FailureKind::LayoutMismatch, message })
        }
        Err(error) => Err(explain(&error)),
    }
}

fn of_rust(header: &'static LibHeader, abi: Abi) -> Result<Library, LibraryError> {
    Ok(match abi {
        Abi::V0_1 => Library::OldRust(header.init_root_module::<old::PlannerModuleRef>()?),
        Abi::V0_2 => Library::Newest(Functions::of_module(header.init_root_module::<PlannerModuleRef>()?)),
    })
}

/// Opens a library with all that it wants from others, once and for all: a function that is missing would otherwise end
/// the process at its first call, in the midst of a task.
fn resolve(path: &Path) -> Result<(), Failure> {
    let unloadable = |message: String| Failure { kind: FailureKind::Unloadable, message };
    let name = CString::new(path.as_os_str().as_bytes()).map_err(|e| unloadable(e.to_string()))?;
    // SAFETY: the name ends with 0. What the library's constructors do is the reason for this process.
    if !unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) }.is_null() {
        return Ok(());
    }
    // SAFETY: the text is valid until the next call of the loader on this thread.
    let error = unsafe { libc::dlerror() };
    let message = if error.is_null() {
        "the system's loader refuses it".to_owned()
    } else {
        // SAFETY: as above, and it ends with 0.
        unsafe { CStr::from_ptr(error) }.to_string_lossy().into_owned()
    };
    Err(unloadable(on_one_line(&message)))
}

fn explain(error: &LibraryError) -> Failure {
    let (kind, message) = match error {
        LibraryError::AbiInstability(report) => {
            (FailureKind::LayoutMismatch, first_difference(&report.to_string()))
        }
        LibraryError::IncompatibleVersionNumber { expected_version, actual_version, .. } => (
            FailureKind::LayoutMismatch,
            format!("it was built with vb-sdk {actual_version}, the harness with {expected_version}"),
        ),
        LibraryError::InvalidAbiHeader(_) => {
            (FailureKind::LayoutMismatch, "it was built with another version of abi_stable".to_owned())
        }
        LibraryError::GetSymbolError { .. } => (
            FailureKind::NotAPlugin,
            "the library has no planner root module and no vb_planner_entry; planners are exported by \
             vb_sdk::export_planner!, or by VB_PLANNER_EXPORT of vb_planner.h"
                .to_owned(),
        ),
        LibraryError::OpenError { err, .. } => {
            // The text of the error itself is only "dlopen failed".
            let reason = std::error::Error::source(err).map_or_else(|| err.to_string(), ToString::to_string);
            (FailureKind::Unloadable, reason)
        }
        other => (FailureKind::Unloadable, other.to_string()),
    };
    Failure { kind, message: on_one_line(&message) }
}

fn on_one_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ")
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
    format!("{field} of {}: {}", owner.trim(), on_one_line(error))
}

/// Where log lines of a planner go.
pub(crate) type Log<'a> = &'a mut dyn FnMut(LogLevel, &str);

/// A planner at work on a task.
#[derive(Debug)]
pub(crate) struct Planner {
    library: Library,
    state: *mut (),
}

impl Planner {
    pub(crate) fn init(library: Library, task: &Task, mut log: Log<'_>) -> Result<Self, Failure> {
        let state = match library {
            Library::Newest(functions) => functions.init(task, log)?.cast(),
            Library::OldRust(module) => {
                let task = v0_1::task(task);
                outcome(module.init()(&old::NativeTask::from(&task), callback(&mut log)))?
            }
            Library::OldC(planner) => planner.init(&v0_1::task(task), log).map_err(error)?.cast(),
        };
        Ok(Self { library, state })
    }

    pub(crate) fn step(&mut self, observation: &Observation, mut log: Log<'_>) -> Result<Command, Failure> {
        match self.library {
            // SAFETY: the state comes from these functions' `init`, and `&mut self` keeps others away.
            Library::Newest(functions) => unsafe { functions.step(self.state.cast(), observation, log) },
            Library::OldRust(module) => {
                let observation = v0_1::observation(observation);
                let observation = old::NativeObservation::from(&observation);
                // SAFETY: as above.
                let result = unsafe { module.step()(self.state, &observation, callback(&mut log)) };
                outcome(result).map(|command| v0_1::command(command.into()))
            }
            Library::OldC(planner) => {
                // SAFETY: as above.
                let result = unsafe { planner.step(self.state.cast(), &v0_1::observation(observation), log) };
                result.map(v0_1::command).map_err(error)
            }
        }
    }
}

impl Drop for Planner {
    fn drop(&mut self) {
        match self.library {
            // SAFETY: the state comes from these functions' `init` and is used no more.
            Library::Newest(functions) => unsafe { functions.free(self.state.cast()) },
            // SAFETY: as above.
            Library::OldRust(module) => unsafe { module.free()(self.state) },
            // SAFETY: as above.
            Library::OldC(planner) => unsafe { planner.free(self.state.cast()) },
        }
    }
}

fn error(message: String) -> Failure {
    Failure { kind: FailureKind::Error, message }
}

fn outcome<T>(result: RResult<T, old::Fault>) -> Result<T, Failure> {
    match result {
        ROk(value) => Ok(value),
        RErr(fault) => {
            let kind = if fault.panicked { FailureKind::Panic } else { FailureKind::Error };
            Err(Failure { kind, message: fault.message.into() })
        }
    }
}

fn callback(log: &mut Log<'_>) -> old::LogCallback {
    old::LogCallback { context: std::ptr::from_mut(log).cast(), write }
}

unsafe extern "C" fn write(context: *mut (), level: u8, message: RStr<'_>) {
    // SAFETY: `context` is the one that `callback` made, alive and unused by others during the call.
    let log = unsafe { &mut *context.cast::<Log<'_>>() };
    log(level_of(u32::from(level)), &message);
}

/// The level of a number: 0 error, 1 warn, 2 info, else debug.
pub(crate) fn level_of(level: u32) -> LogLevel {
    match level {
        0 => LogLevel::Error,
        1 => LogLevel::Warn,
        2 => LogLevel::Info,
        _ => LogLevel::Debug,
    }
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
