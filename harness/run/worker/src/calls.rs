//! Calls of a native planner's functions, which are the same in every language.

use std::ffi::{CStr, c_char, c_void};
use std::ptr;

use vb_sdk::c::{self, Arena, CCommand, CError, CFunctions, CHost, CObservation, CTask};
use vb_sdk::native::PlannerModuleRef;
use vb_sdk::{Command, Observation, Task};

use crate::log::{Log, level_of};
use crate::protocol::{Failure, FailureKind};

/// The functions of an open library.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functions {
    init: unsafe extern "C" fn(*const CTask, *const CHost, *mut *mut c_void, *mut CError) -> i32,
    step: unsafe extern "C" fn(
        *mut c_void,
        *const CObservation,
        *const CHost,
        *mut CCommand,
        *mut CError,
    ) -> i32,
    free: unsafe extern "C" fn(*mut c_void),
}

impl Functions {
    /// Those of a root module whose layout has been checked.
    pub(crate) fn of_module(module: PlannerModuleRef) -> Self {
        Self { init: module.init(), step: module.step(), free: module.free() }
    }

    /// Those of a symbol, or a text that says in what they differ from what this harness calls.
    ///
    /// # Safety
    /// `entry` is the address of the library's `vb_planner_entry`, and the library stays open.
    pub(crate) unsafe fn of_entry(entry: *const CFunctions) -> Result<Self, String> {
        if entry.is_null() || !entry.is_aligned() {
            return Err("vb_planner_entry is not aligned as a struct".into());
        }
        // SAFETY: the three first fields are there in every version; later ones are read when the size covers them.
        let (size, major, minor) = unsafe { ((*entry).size, (*entry).abi_major, (*entry).abi_minor) };
        if (major, minor) != c::ABI {
            let (a, b) = c::ABI;
            return Err(format!("vb_planner_entry has version {major}.{minor}, the metadata {a}.{b}"));
        }
        if size < size_of::<CFunctions>() {
            let wanted = size_of::<CFunctions>();
            return Err(format!("vb_planner_entry has {size} bytes, not {wanted}"));
        }
        // SAFETY: as above, and the size covers all of it.
        let entry = unsafe { &*entry };
        let missing = |name| format!("vb_planner_entry has no function {name}");
        Ok(Self {
            init: entry.init.ok_or_else(|| missing("init"))?,
            step: entry.step.ok_or_else(|| missing("step"))?,
            free: entry.free.ok_or_else(|| missing("free"))?,
        })
    }

    pub(crate) fn init(&self, task: &Task, mut log: Log<'_>) -> Result<*mut c_void, Failure> {
        let (mut arena, mut planner, mut error) = (Arena::default(), ptr::null_mut(), CError::default());
        let task = c::lower_task(task, &mut arena);
        // SAFETY: all pointers lead to values that live until the call ends, as the header promises.
        let status =
            unsafe { (self.init)(&raw const task, &host(&mut log), &raw mut planner, &raw mut error) };
        judged("init", status, &error).map(|()| planner)
    }

    /// Calls `step`.
    ///
    /// # Safety
    /// `planner` comes from `init` and isn't freed.
    pub(crate) unsafe fn step(
        &self,
        planner: *mut c_void,
        observation: &Observation,
        mut log: Log<'_>,
    ) -> Result<Command, Failure> {
        let (mut arena, mut command, mut error) = (Arena::default(), CCommand::default(), CError::default());
        let observation = c::lower_observation(observation, &mut arena);
        // SAFETY: by this function's own condition; all pointers lead to values that live until the call ends.
        let status = unsafe {
            (self.step)(planner, &raw const observation, &host(&mut log), &raw mut command, &raw mut error)
        };
        judged("step", status, &error)?;
        // SAFETY: the header makes the planner promise it. One that lies harms its own process only.
        let command = unsafe { c::lift_command(&command) };
        command.map_err(|message| Failure { kind: FailureKind::InvalidOutput, message })
    }

    /// Calls `free`.
    ///
    /// # Safety
    /// `planner` comes from `init` and isn't used again.
    pub(crate) unsafe fn free(&self, planner: *mut c_void) {
        // SAFETY: by this function's own condition.
        unsafe { (self.free)(planner) };
    }
}

/// What a status means.
fn judged(function: &str, status: i32, error: &CError) -> Result<(), Failure> {
    let kind = match status {
        c::OK => return Ok(()),
        c::PANICKED => FailureKind::Panic,
        _ => FailureKind::Error,
    };
    let message = error.get().unwrap_or_else(|| format!("{function} returned {status} without a message"));
    Err(Failure { kind, message })
}

fn host(log: &mut Log<'_>) -> CHost {
    CHost { context: ptr::from_mut(log).cast(), log: write }
}

/// The `log` of [`CHost`].
unsafe extern "C" fn write(context: *mut c_void, level: u32, message: *const c_char) {
    if context.is_null() || message.is_null() {
        return;
    }
    // SAFETY: `context` is the one that `host` made, alive during the call.
    let log = unsafe { &mut *context.cast::<Log<'_>>() };
    // SAFETY: the header demands text that ends with 0.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    log(level_of(level), &text);
}
