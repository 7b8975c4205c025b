//! A WASM planner at work on a task.

use vb_sdk::{Command, LogLevel, Observation, Task};
use wasmtime::component::{Linker, WasmStr};
use wasmtime::{Engine, Error, Store, StoreContextMut, Trap, WasmBacktrace};

use super::interface::{Planner, Pre};
use super::state::{PANIC_PREFIX, State, pay};
use super::v1_0::bindings::vertibench::planner::types;
use super::{engine, is_of_the_system};
use crate::abi::AbiVersion;
use crate::fault::{FaultCause, Resource};
use crate::{FuelMeter, Limits, LogSink};
use vb_files::one_line;

/// Resource handles alive at a time: planners have one, and WASI's a handful more.
const HANDLES: usize = 10_000;

/// Gives the linker the planner interface's own functions.
pub(super) fn add_host_functions(linker: &mut Linker<State>, abi: AbiVersion) -> wasmtime::Result<()> {
    let log = |mut store: StoreContextMut<'_, State>, (level, message): (types::LogLevel, WasmStr)| {
        let text = {
            let text = message.to_str(&store)?;
            text.into_owned()
        };
        pay(&mut store, text.len() as u64)?;
        let level = match level {
            types::LogLevel::Error => LogLevel::Error,
            types::LogLevel::Warn => LogLevel::Warn,
            types::LogLevel::Info => LogLevel::Info,
            types::LogLevel::Debug => LogLevel::Debug,
        };
        let state = store.data_mut();
        if level == LogLevel::Error && text.starts_with(PANIC_PREFIX) {
            state.note_panic(&text);
        }
        state.log.write(level, &text);
        Ok(())
    };
    linker.instance(abi.host_interface())?.func_wrap("log", log)
}

/// A planner of a WASM plugin, in a store of its own.
pub(crate) struct WasmSession {
    store: Store<State>,
    planner: Planner,
    fuel_per_step: u64,
    fuel_per_task: u64,
    /// Ticks that a call has; `None` without a watchdog.
    deadline: Option<u64>,
    fuel: FuelMeter,
}

impl std::fmt::Debug for WasmSession {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WasmSession").field("fuel", &self.fuel).finish_non_exhaustive()
    }
}

impl WasmSession {
    pub(super) fn start(
        engine: &Engine,
        pre: &Pre,
        task: &Task,
        sink: LogSink,
        limits: &Limits,
    ) -> Result<Self, FaultCause> {
        let mut store = Store::new(engine, State::new(task, sink, limits));
        store.limiter(|state| &mut state.memory);
        store.set_hostcall_fuel(limits.output_bytes);
        store.set_max_component_handles(HANDLES);
        let deadline = limits.wasm_watchdog.then(|| engine::deadline(limits));
        if let Some(ticks) = deadline {
            store.set_epoch_deadline(ticks);
            store.epoch_deadline_trap();
        }
        let task = types::Task::from(task);
        let budget = Budget::new(limits.fuel_init, limits.fuel_per_task);
        let mut init = || {
            store.set_fuel(budget.fuel)?;
            let planner = Planner::init(pre, &mut store, &task)?;
            Ok((planner, budget.fuel - store.get_fuel()?))
        };
        let result = init();
        store.data_mut().flush_output();
        let (planner, used) = result.map_err(|e| cause(&e, store.data(), budget))?;
        let planner = planner.map_err(|message| FaultCause::Error { message: one_line(&message) })?;
        let fuel = FuelMeter { init: used, ..FuelMeter::default() };
        let (fuel_per_step, fuel_per_task) = (limits.fuel_per_step, limits.fuel_per_task);
        Ok(Self { store, planner, fuel_per_step, fuel_per_task, deadline, fuel })
    }

    pub(crate) fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause> {
        let left = self.fuel_per_task.saturating_sub(self.fuel.init + self.fuel.steps);
        let budget = Budget { task: self.fuel_per_task, ..Budget::new(self.fuel_per_step, left) };
        let store = &mut self.store;
        let state = store.data_mut();
        state.memory.refused = None;
        state.panic = None;
        state.wasi.set_time(observation.time);
        if let Some(ticks) = self.deadline {
            store.set_epoch_deadline(ticks);
        }
        let observation = types::Observation::from(observation);
        let result = store.set_fuel(budget.fuel).and_then(|()| self.planner.step(&mut *store, &observation));
        store.data_mut().flush_output();
        let used = budget.fuel - store.get_fuel().unwrap_or(0);
        self.fuel.last_step = used;
        self.fuel.steps += used;
        self.fuel.max_step = self.fuel.max_step.max(used);
        match result {
            Ok(Ok(command)) => Ok(command),
            Ok(Err(message)) => Err(FaultCause::Error { message: one_line(&message) }),
            Err(e) => Err(cause(&e, store.data(), budget)),
        }
    }

    pub(crate) fn fuel(&self) -> FuelMeter {
        self.fuel
    }

    /// Bytes of linear memory. Memories never shrink, so this is the most there was.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.store.data().memory.used as u64
    }
}

/// Fuel that a call has.
#[derive(Clone, Copy, Debug)]
struct Budget {
    fuel: u64,
    /// Whether that is what is left for the task.
    is_last: bool,
    /// What the task had.
    task: u64,
}

impl Budget {
    /// The budget of a call that may use this much, where so much is left for the task.
    fn new(call: u64, left: u64) -> Self {
        Self { fuel: call.min(left), is_last: left < call, task: left }
    }

    fn used_up(self) -> FaultCause {
        if self.is_last {
            FaultCause::OutOfTaskFuel { budget: self.task }
        } else {
            FaultCause::OutOfFuel { budget: self.fuel }
        }
    }
}

/// What an error of the engine means for the planner.
fn cause(error: &Error, state: &State, budget: Budget) -> FaultCause {
    let trap = error.downcast_ref::<Trap>();
    match trap {
        Some(Trap::OutOfFuel) => return budget.used_up(),
        Some(Trap::Interrupt) => return FaultCause::Watchdog { limit_ms: state.watchdog_ms },
        _ => {}
    }
    if let Some(cause) = error.downcast_ref::<FaultCause>() {
        return cause.clone();
    }
    if is_of_the_system(error) {
        return FaultCause::Machine { message: one_line(&error.root_cause().to_string()) };
    }
    if let Some(message) = &state.panic {
        return FaultCause::Panic { message: message.clone() };
    }
    let frames = error.downcast_ref::<WasmBacktrace>().map_or(&[][..], WasmBacktrace::frames);
    let backtrace: Vec<String> = frames.iter().map(function).collect();
    if trap == Some(&Trap::StackOverflow) {
        return FaultCause::StackOverflow { limit: Some(state.stack_bytes), backtrace };
    }
    if trap == Some(&Trap::MemoryOutOfBounds) && is_deep_recursion(&backtrace) {
        return FaultCause::StackOverflow { limit: None, backtrace };
    }
    if let Some((what, wanted)) = state.memory.refused {
        let limit = match what {
            Resource::Memory => state.memory.limit,
            Resource::Table => state.memory.table_limit,
        };
        return FaultCause::OutOfMemory { what, wanted, limit: limit as u64 };
    }
    // The engine's type for this is private; a test holds its text.
    if trap.is_none() && error.root_cause().to_string().starts_with("too much data is being copied") {
        return FaultCause::OutputTooLarge { limit: state.output_bytes };
    }
    // What a call hands over has one enumeration, the gear. The engine's error has no type; a test holds its text.
    let root = error.root_cause().to_string();
    if trap.is_none()
        && backtrace.is_empty()
        && let Some(found) = root.strip_prefix("unexpected discriminant: ")
    {
        let found = one_line(found);
        let message = format!("gear is {found}; want forward (0), neutral (1) or reverse (2)");
        return FaultCause::BadCommand { message };
    }
    // Of an error that is no trap the outermost texts are the engine's own frames of reference.
    let message = trap.map_or(root, ToString::to_string);
    let message = one_line(message.strip_prefix("wasm trap: ").unwrap_or(&message));
    FaultCause::Trap { message, backtrace }
}

/// Whether the innermost calls are those of a recursion. Compilers keep what has an address on a stack of their own at the
/// bottom of memory, so a recursion may fall out of memory before it meets the end of the engine's stack.
fn is_deep_recursion(backtrace: &[String]) -> bool {
    let calls = |name: &String| backtrace.iter().filter(|other| *other == name).count();
    backtrace.len() == engine::BACKTRACE_FRAMES
        && backtrace.iter().any(|name| calls(name) >= engine::BACKTRACE_FRAMES / 4)
}

/// A function's name as its author wrote it.
fn function(frame: &wasmtime::FrameInfo) -> String {
    let name = frame.func_name().unwrap_or("an unnamed function");
    one_line(&format!("{:#}", rustc_demangle::demangle(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_of_the_system_is_not_blamed_on_the_planner() {
        let state = State::new(&Task::default(), LogSink::discard(), &Limits::default());
        let refusal = std::io::Error::from(std::io::ErrorKind::OutOfMemory);
        let found = cause(&Error::from(refusal).context("while making room"), &state, Budget::new(1, 1));
        assert!(matches!(&found, FaultCause::Machine { message } if message.contains("memory")), "{found}");
        #[cfg(unix)]
        {
            let found =
                cause(&Error::from(rustix::io::Errno::NOMEM).context("mmap"), &state, Budget::new(1, 1));
            assert!(matches!(found, FaultCause::Machine { .. }), "{found}");
        }
        let found = cause(&Error::msg("no such table"), &state, Budget::new(1, 1));
        assert!(matches!(found, FaultCause::Trap { .. }), "{found}");
    }
}
