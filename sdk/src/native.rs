//! Planners as native libraries, with a root module whose layout `abi_stable` checks when the library is loaded.
//!
//! Planner authors do not need this module: [`export_planner!`](crate::export_planner) and the harness use it. Data
//! cross the boundary as the structs of [`crate::c`]; a panic becomes the status [`c::PANICKED`].

use std::cell::{Cell, RefCell};
use std::ffi::{CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use abi_stable::StableAbi;
use abi_stable::library::{RootModule, RootModuleResult};
use abi_stable::prefix_type::{PrefixRefTrait, PrefixTypeTrait};
use abi_stable::sabi_types::VersionStrings;
use abi_stable::std_types::{ROk, RSlice};

use crate::c::{self, Arena, CCommand, CError, CHost, CObservation, CTask};
use crate::{Command, LogLevel, Planner, PlannerError};

/// The functions of a planner library, as in `vb_planner_functions` of the C header.
#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = PlannerModuleRef)))]
pub struct PlannerModule {
    /// The [metadata](crate::metadata) text; the reference prevents the linker from dropping its section.
    pub metadata: RSlice<'static, u8>,
    /// Creates a planner for a task. The returned pointer is passed to `step` and `free`, which are called from one
    /// thread at a time.
    pub init: unsafe extern "C" fn(
        task: *const CTask,
        host: *const CHost,
        planner: *mut *mut c_void,
        error: *mut CError,
    ) -> i32,
    /// Runs one step of a planner from `init`. After a failure, only `free` may be called with that planner.
    pub step: unsafe extern "C" fn(
        planner: *mut c_void,
        observation: *const CObservation,
        host: *const CHost,
        command: *mut CCommand,
        error: *mut CError,
    ) -> i32,
    /// Frees a planner from `init`.
    #[sabi(last_prefix_field)]
    pub free: unsafe extern "C" fn(planner: *mut c_void),
}

impl RootModule for PlannerModuleRef {
    abi_stable::declare_root_module_statics! {PlannerModuleRef}
    const BASE_NAME: &'static str = "vb_planner";
    const NAME: &'static str = "vb_planner";
    const VERSION_STRINGS: VersionStrings = abi_stable::package_version_strings!();
}

impl std::fmt::Debug for PlannerModuleRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("PlannerModuleRef")
    }
}

thread_local! {
    /// The destination of log lines during a call on this thread.
    static LOG: Cell<Option<CHost>> = const { Cell::new(None) };
    /// The text of the last panic during such a call.
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

pub(crate) fn log(level: LogLevel, message: &str) {
    if let Some(host) = LOG.get() {
        let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the harness keeps the context alive during its call, which is when LOG is set.
        unsafe { (host.log)(host.context, level as u32, text.as_ptr()) };
    }
}

/// Stores the text and location of a panic during a call instead of printing it.
fn install_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if LOG.get().is_some() {
                PANIC.set(Some(info.to_string()));
            } else {
                previous(info);
            }
        }));
    });
}

/// Runs planner code for the harness: log lines go to `host`; an error or a panic becomes a status with a text.
fn guarded(host: CHost, error: &mut CError, f: impl FnOnce() -> Result<(), PlannerError>) -> i32 {
    install_panic_hook();
    LOG.set(Some(host));
    // A planner is never called again after a panic, so broken invariants are not observed.
    let result = catch_unwind(AssertUnwindSafe(f));
    LOG.set(None);
    match result {
        Ok(Ok(())) => c::OK,
        Ok(Err(e)) => {
            error.set(&e.to_string());
            c::FAILED
        }
        Err(_) => {
            error.set(&PANIC.take().unwrap_or_else(|| "panicked".to_owned()));
            c::PANICKED
        }
    }
}

/// A planner, and the memory that the pointers of its last command refer to.
struct Seat<P> {
    planner: P,
    last: Command,
    arena: Arena,
}

/// # Safety
/// All pointers are valid as documented in the header.
unsafe extern "C" fn init<P: Planner>(
    task: *const CTask,
    host: *const CHost,
    planner: *mut *mut c_void,
    error: *mut CError,
) -> i32 {
    // SAFETY: by this function's own condition.
    let (host, error) = unsafe { (*host, &mut *error) };
    guarded(host, error, || {
        // SAFETY: as above.
        let task = unsafe { c::lift_task(&*task) }?;
        let seat = Seat { planner: P::init(&task)?, last: Command::default(), arena: Arena::default() };
        // SAFETY: as above.
        unsafe { *planner = Box::into_raw(Box::new(seat)).cast() };
        Ok(())
    })
}

/// # Safety
/// `planner` comes from `init::<P>`, is not freed, and is not used by another thread during the call; all other
/// pointers are valid as documented in the header.
unsafe extern "C" fn step<P: Planner>(
    planner: *mut c_void,
    observation: *const CObservation,
    host: *const CHost,
    command: *mut CCommand,
    error: *mut CError,
) -> i32 {
    // SAFETY: by this function's own conditions.
    let (seat, host, error) = unsafe { (&mut *planner.cast::<Seat<P>>(), *host, &mut *error) };
    guarded(host, error, || {
        // SAFETY: as above.
        let observation = unsafe { c::lift_observation(&*observation) }?;
        seat.arena.clear();
        seat.last = seat.planner.step(&observation)?;
        // SAFETY: as above. The command's pointers lead into the seat, which stays as it is until the next call.
        unsafe { *command = c::lower_command(&seat.last, &mut seat.arena) };
        Ok(())
    })
}

/// # Safety
/// `planner` comes from `init::<P>` and is not used again.
unsafe extern "C" fn free<P: Planner>(planner: *mut c_void) {
    // SAFETY: by this function's own conditions.
    let seat = unsafe { Box::from_raw(planner.cast::<Seat<P>>()) };
    // A panic in `drop` cannot be reported.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(seat)));
}

/// The root module of a planner `P`.
#[must_use]
pub fn module<P: Planner>(metadata: &'static [u8]) -> PlannerModuleRef {
    PlannerModule {
        metadata: RSlice::from_slice(metadata),
        init: init::<P>,
        step: step::<P>,
        free: free::<P>,
    }
    .leak_into_prefix()
}

/// The root module, as exported by [`export_planner!`](crate::export_planner).
#[doc(hidden)]
pub fn erased_module<P: Planner>(metadata: &'static [u8]) -> RootModuleResult {
    // SAFETY: `LibHeader` casts it back after the layout check.
    ROk(unsafe { module::<P>(metadata).to_prefix_ref().cast() })
}

#[cfg(test)]
mod tests;
