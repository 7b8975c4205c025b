//! A WASM planner at work on a task.

use vb_sdk::{Command, LogLevel, Observation, Task};
use wasmtime::component::{Linker, ResourceAny, WasmStr};
use wasmtime::{Engine, Error, ResourceLimiter, Store, StoreContextMut, Trap, WasmBacktrace};

use super::bindings::vertibench::planner::types;
use super::bindings::{PlannerPlugin, PlannerPluginPre};
use super::{HOST_INTERFACE, convert, engine};
use crate::fault::{FaultCause, Resource};
use crate::log::Log;
use crate::text::one_line;
use crate::{FuelUse, Limits, LogSink};

/// Fuel for a log line beside one unit a byte: about what it costs the harness.
const LOG_FUEL: u64 = 1000;
/// Elements of all tables of a plugin together.
const TABLE_ELEMENTS: usize = 1 << 20;
/// Core instances, tables and memories of one plugin each: planners in interpreted languages take dozens.
const INSTANCES: usize = 256;
/// A panic's text begins so, as Rust prints it.
const PANIC_PREFIX: &str = "panicked at ";

/// What the host functions of a session work on.
pub(super) struct State {
    log: Log,
    memory: MemoryLimiter,
    /// Bytes that one call may hand over.
    output_bytes: u64,
    /// Text of the panic that the planner has just reported.
    panic: Option<String>,
}

/// Counts the memory of a plugin and remembers that it refused some: the guest itself only sees an allocation fail,
/// and traps with no word about it.
struct MemoryLimiter {
    limit: usize,
    used: usize,
    table_elements: usize,
    /// What was refused last: what, and how much there would have been.
    refused: Option<(Resource, u64)>,
}

impl ResourceLimiter for MemoryLimiter {
    fn memory_growing(&mut self, current: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        let used = self.used.saturating_add(desired.saturating_sub(current));
        if used > self.limit {
            self.refused = Some((Resource::Memory, used as u64));
            return Ok(false);
        }
        self.used = used;
        Ok(true)
    }

    fn table_growing(&mut self, current: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        let elements = self.table_elements.saturating_add(desired.saturating_sub(current));
        if elements > TABLE_ELEMENTS {
            self.refused = Some((Resource::Table, elements as u64));
            return Ok(false);
        }
        self.table_elements = elements;
        Ok(true)
    }

    fn instances(&self) -> usize {
        INSTANCES
    }

    fn tables(&self) -> usize {
        INSTANCES
    }

    fn memories(&self) -> usize {
        INSTANCES
    }
}

/// Gives the linker all that planners may import.
pub(super) fn add_host_functions(linker: &mut Linker<State>) -> wasmtime::Result<()> {
    let log = |mut store: StoreContextMut<'_, State>, (level, message): (types::LogLevel, WasmStr)| {
        // Paid for beforehand: a line costs the harness work that the guest's own instructions don't reflect.
        let text = {
            let text = message.to_str(&store)?;
            text.into_owned()
        };
        let price = LOG_FUEL.saturating_add(text.len() as u64);
        let left = store.get_fuel()?.checked_sub(price).ok_or(Trap::OutOfFuel)?;
        store.set_fuel(left)?;
        let level = match level {
            types::LogLevel::Error => LogLevel::Error,
            types::LogLevel::Warn => LogLevel::Warn,
            types::LogLevel::Info => LogLevel::Info,
            types::LogLevel::Debug => LogLevel::Debug,
        };
        let state = store.data_mut();
        if level == LogLevel::Error && text.starts_with(PANIC_PREFIX) {
            state.panic = Some(one_line(&text));
        }
        state.log.write(level, &text);
        Ok(())
    };
    linker.instance(HOST_INTERFACE)?.func_wrap("log", log)
}

/// A planner of a WASM plugin, in a store of its own.
pub(crate) struct WasmSession {
    store: Store<State>,
    plugin: PlannerPlugin,
    planner: ResourceAny,
    fuel_per_step: u64,
    fuel: FuelUse,
}

impl std::fmt::Debug for WasmSession {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WasmSession").field("fuel", &self.fuel).finish_non_exhaustive()
    }
}

impl WasmSession {
    pub(super) fn start(
        engine: &Engine,
        pre: &PlannerPluginPre<State>,
        task: &Task,
        sink: LogSink,
        limits: &Limits,
    ) -> Result<Self, FaultCause> {
        let memory = MemoryLimiter { limit: limits.memory_bytes, used: 0, table_elements: 0, refused: None };
        let log = Log::new(sink, limits.log_bytes);
        let mut store =
            Store::new(engine, State { log, memory, output_bytes: limits.output_bytes as u64, panic: None });
        store.limiter(|state| &mut state.memory);
        store.set_hostcall_fuel(limits.output_bytes);
        let task = convert::task(task);
        let budget = limits.fuel_init;
        let mut init = || {
            store.set_fuel(budget)?;
            let plugin = pre.instantiate(&mut store)?;
            let planner = plugin.vertibench_planner_guest().planner().call_init(&mut store, &task)?;
            Ok((plugin, planner, budget - store.get_fuel()?))
        };
        let (plugin, planner, used) = init().map_err(|e| cause(&e, store.data(), budget))?;
        let planner = planner.map_err(|message| FaultCause::Error { message: one_line(&message) })?;
        let fuel = FuelUse { init: used, ..FuelUse::default() };
        Ok(Self { store, plugin, planner, fuel_per_step: limits.fuel_per_step, fuel })
    }

    pub(crate) fn step(&mut self, observation: &Observation) -> Result<Command, FaultCause> {
        let (store, budget) = (&mut self.store, self.fuel_per_step);
        store.data_mut().memory.refused = None;
        store.data_mut().panic = None;
        let observation = convert::observation(observation);
        let interface = self.plugin.vertibench_planner_guest();
        let result = store
            .set_fuel(budget)
            .and_then(|()| interface.planner().call_step(&mut *store, self.planner, &observation));
        let used = budget - store.get_fuel().unwrap_or(0);
        self.fuel.last_step = used;
        self.fuel.steps += used;
        self.fuel.max_step = self.fuel.max_step.max(used);
        match result {
            Ok(Ok(command)) => Ok(convert::command(command)),
            Ok(Err(message)) => Err(FaultCause::Error { message: one_line(&message) }),
            Err(e) => Err(cause(&e, store.data(), budget)),
        }
    }

    pub(crate) fn fuel(&self) -> FuelUse {
        self.fuel
    }
}

/// What an error of the engine means for the planner.
fn cause(error: &Error, state: &State, budget: u64) -> FaultCause {
    let trap = error.downcast_ref::<Trap>();
    if trap == Some(&Trap::OutOfFuel) {
        return FaultCause::OutOfFuel { budget };
    }
    if let Some(message) = &state.panic {
        return FaultCause::Panic { message: message.clone() };
    }
    if let Some((what, wanted)) = state.memory.refused {
        let limit = match what {
            Resource::Memory => state.memory.limit,
            Resource::Table => TABLE_ELEMENTS,
        };
        return FaultCause::OutOfMemory { what, wanted: Some(wanted), limit: limit as u64 };
    }
    if is_of_the_system(error) {
        return FaultCause::Machine { message: one_line(&error.root_cause().to_string()) };
    }
    // The engine's type for this is private; a test holds its text.
    if trap.is_none() && error.root_cause().to_string().starts_with("too much data is being copied") {
        return FaultCause::OutputTooLarge { limit: state.output_bytes };
    }
    // Of an error that is no trap the outermost texts are the engine's own frames of reference.
    let message = trap.map_or_else(|| one_line(&error.root_cause().to_string()), ToString::to_string);
    let frames = error.downcast_ref::<WasmBacktrace>().map_or(&[][..], WasmBacktrace::frames);
    let name = |f: &wasmtime::FrameInfo| one_line(f.func_name().unwrap_or("an unnamed function"));
    let backtrace = frames.iter().take(engine::BACKTRACE_FRAMES).map(name).collect();
    if trap == Some(&Trap::StackOverflow) {
        return FaultCause::StackOverflow { limit: engine::STACK_BYTES as u64, backtrace };
    }
    FaultCause::Trap { message, backtrace }
}

/// Whether the operating system caused an error of the engine. A planner has no way to: it makes no system calls.
fn is_of_the_system(error: &Error) -> bool {
    let root = error.root_cause();
    #[cfg(unix)]
    if root.is::<rustix::io::Errno>() {
        return true;
    }
    root.is::<std::io::Error>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, LogSink};

    #[test]
    fn a_refusal_of_the_system_is_not_blamed_on_the_planner() {
        let memory = MemoryLimiter { limit: 1, used: 0, table_elements: 0, refused: None };
        let state = State {
            log: Log::new(LogSink::discard(), Limits::default().log_bytes),
            memory,
            output_bytes: 1,
            panic: None,
        };
        let refusal = std::io::Error::from(std::io::ErrorKind::OutOfMemory);
        let found = cause(&Error::from(refusal).context("while making room"), &state, 1);
        assert!(matches!(&found, FaultCause::Machine { message } if message.contains("memory")), "{found}");
        #[cfg(unix)]
        {
            let found = cause(&Error::from(rustix::io::Errno::NOMEM).context("mmap"), &state, 1);
            assert!(matches!(found, FaultCause::Machine { .. }), "{found}");
        }
        let found = cause(&Error::msg("no such table"), &state, 1);
        assert!(matches!(found, FaultCause::Trap { .. }), "{found}");
    }
}
