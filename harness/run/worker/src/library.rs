//! Opening a native plugin: a Rust library with an `abi_stable` root module, or any other with `vb_planner_entry`.

use std::ffi::c_void;
use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use abi_stable::library::{LibraryError, lib_header_from_path};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use vb_files::Hash;
use vb_sdk::c::{CFunctions, ENTRY};
use vb_sdk::native::PlannerModuleRef;
use vb_sdk::{Command, Observation, Task};

use crate::calls::Functions;
use crate::log::Log;
use crate::protocol::{Failure, FailureKind};

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
pub(crate) fn open(path: &Path) -> Result<Functions, Failure> {
    // With all symbols resolved: a function that is missing would otherwise end the process at its first call, in the midst of a task.
    // SAFETY: what the library's constructors do is the reason for this process.
    let library = unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map_err(|e| unloadable(&e))?;
    let library = Box::leak(Box::new(library));
    match lib_header_from_path(path) {
        Ok(header) => {
            let module = header.init_root_module::<PlannerModuleRef>().map_err(|e| explain(&e))?;
            Ok(Functions::of_module(module))
        }
        Err(error @ LibraryError::GetSymbolError { .. }) => {
            // SAFETY: the symbol is a struct, so its address is what the pointer takes.
            let entry = unsafe { library.get::<*const CFunctions>(ENTRY) }.map_err(|_| explain(&error))?;
            // SAFETY: it is the address of the symbol, and the library is never closed.
            let functions = unsafe { Functions::of_entry(*entry) };
            functions.map_err(|message| Failure { kind: FailureKind::LayoutMismatch, message })
        }
        Err(error) => Err(explain(&error)),
    }
}

fn unloadable(error: &libloading::Error) -> Failure {
    // The text of the error itself is only "dlopen failed".
    let reason = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
    Failure { kind: FailureKind::Unloadable, message: vb_files::one_line(&reason) }
}

fn explain(error: &LibraryError) -> Failure {
    let (kind, message) = match error {
        LibraryError::AbiInstability(_) => {
            (FailureKind::LayoutMismatch, "its root module has other types".to_owned())
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
            "the library has no planner root module and no vb_planner_entry; export planners with \
             vb_sdk::export_planner!, or VB_PLANNER_EXPORT of vb_planner.h"
                .to_owned(),
        ),
        other => (FailureKind::Unloadable, other.to_string()),
    };
    Failure { kind, message: vb_files::one_line(&message) }
}

/// A planner at work on a task.
#[derive(Debug)]
pub(crate) struct Planner {
    functions: Functions,
    state: *mut c_void,
}

impl Planner {
    pub(crate) fn init(functions: Functions, task: &Task, log: Log<'_>) -> Result<Self, Failure> {
        functions.init(task, log).map(|state| Self { functions, state })
    }

    pub(crate) fn step(&mut self, observation: &Observation, log: Log<'_>) -> Result<Command, Failure> {
        // SAFETY: the state comes from these functions' `init`, and `&mut self` keeps others away.
        unsafe { self.functions.step(self.state, observation, log) }
    }
}

impl Drop for Planner {
    fn drop(&mut self) {
        // SAFETY: the state comes from these functions' `init` and is used no more.
        unsafe { self.functions.free(self.state) }
    }
}
