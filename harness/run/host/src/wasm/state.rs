//! State of a session that its host functions access: log, WASI state, memory limits.

use vb_sdk::Task;
use wasmtime::{Error, ResourceLimiter, StoreContextMut, Trap};

use super::guest_world::Wasi;
use super::is_of_the_system;
use crate::fault::Resource;
use crate::log::Log;
use crate::{Limits, LogSink};
use vb_files::one_line;

/// Fuel for a call of the host beside one unit a byte: about what a log line costs the harness.
const CALL_FUEL: u64 = 1000;
/// Core instances, tables and memories of one plugin each: planners in interpreted languages take dozens.
const INSTANCES: usize = 256;
/// A panic's text begins so, as Rust prints it.
pub(super) const PANIC_PREFIX: &str = "panicked at ";

/// State of a session that its host functions access.
pub(super) struct State {
    pub(super) log: Log,
    pub(super) wasi: Wasi,
    pub(super) memory: MemoryLimiter,
    /// Bytes that one call may hand over.
    pub(super) output_bytes: u64,
    /// Bytes of stack.
    pub(super) stack_bytes: u64,
    /// Wall-clock time of a call, ms.
    pub(super) watchdog_ms: u64,
    /// Text of the panic that the planner has just reported.
    pub(super) panic: Option<String>,
}

impl State {
    pub(super) fn new(task: &Task, sink: LogSink, limits: &Limits) -> Self {
        Self {
            log: Log::new(sink, limits.log_bytes),
            wasi: Wasi::new(task.seed),
            memory: MemoryLimiter {
                limit: limits.memory_bytes,
                used: 0,
                table_limit: limits.table_elements,
                table_used: 0,
                refused: None,
            },
            output_bytes: limits.output_bytes as u64,
            stack_bytes: limits.stack_bytes as u64,
            watchdog_ms: limits.watchdog_ms,
            panic: None,
        }
    }

    /// Keeps the text of a panic, if this is one, as the reason of the trap that follows it.
    pub(super) fn note_panic(&mut self, text: &str) {
        if let Some(at) = text.find(PANIC_PREFIX) {
            // What follows the text in the standard library's own report.
            let text = text[at..].split("\nnote: run with").next().unwrap_or_default();
            self.panic = Some(one_line(text));
        }
    }

    /// The same for what a call wrote to standard error. If the planner itself has logged a panic, that says more than
    /// the report of its language's runtime, which comes later.
    pub(super) fn note_report(&mut self, text: &str) {
        if self.panic.is_none() {
            self.note_panic(text);
        }
    }
}

/// Counts the memory of a plugin and remembers what it refused: the guest itself only sees an allocation fail, and
/// traps with no word about it.
pub(super) struct MemoryLimiter {
    pub(super) limit: usize,
    pub(super) used: usize,
    pub(super) table_limit: usize,
    table_used: usize,
    /// The last refused growth: the resource and its total size after the growth, bytes or elements.
    pub(super) refused: Option<(Resource, u64)>,
}

impl ResourceLimiter for MemoryLimiter {
    fn memory_growing(
        &mut self,
        current: usize,
        desired: usize,
        most: Option<usize>,
    ) -> wasmtime::Result<bool> {
        if most.is_some_and(|most| desired > most) {
            return Ok(false);
        }
        let used = self.used.saturating_add(desired.saturating_sub(current));
        if used > self.limit {
            self.refused = Some((Resource::Memory, used as u64));
            return Ok(false);
        }
        self.used = used;
        Ok(true)
    }

    fn table_growing(
        &mut self,
        current: usize,
        desired: usize,
        most: Option<usize>,
    ) -> wasmtime::Result<bool> {
        if most.is_some_and(|most| desired > most) {
            return Ok(false);
        }
        let elements = self.table_used.saturating_add(desired.saturating_sub(current));
        if elements > self.table_limit {
            self.refused = Some((Resource::Table, elements as u64));
            return Ok(false);
        }
        self.table_used = elements;
        Ok(true)
    }

    /// Returns an error of the host if the system refuses memory within the limits: the planner must not observe it.
    fn memory_grow_failed(&mut self, error: Error) -> wasmtime::Result<()> {
        if is_of_the_system(&error) { Err(error) } else { Ok(()) }
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

/// Charges for a call of the host that handles so many bytes, before it does: that costs the harness work which the
/// guest's own instructions don't reflect.
pub(super) fn pay(store: &mut StoreContextMut<'_, State>, bytes: u64) -> wasmtime::Result<()> {
    let price = CALL_FUEL.saturating_add(bytes);
    let left = store.get_fuel()?.checked_sub(price).ok_or(Trap::OutOfFuel)?;
    store.set_fuel(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_standard_error_is_cut_down_to_its_text() {
        let mut state = State::new(&Task::default(), LogSink::discard(), &Limits::default());
        // As the standard library of Rust 1.95 reports it.
        state.note_panic(
            "\nthread '<unnamed>' (1) panicked at src/lib.rs:3:5:\nno way\nout\nnote: run with `RUST_BACKTRACE=1` environment \
             variable to display a backtrace\n",
        );
        assert_eq!(state.panic.as_deref(), Some("panicked at src/lib.rs:3:5: no way out"));
    }
}
