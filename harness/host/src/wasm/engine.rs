//! The engine's configuration: whatever it allows must give the same bits on every machine.

use std::time::Duration;

use wasmtime::{Config, Engine, EngineWeak, OperatorCost, OptLevel};

use crate::Limits;

/// Innermost functions told with a trap.
pub(super) const BACKTRACE_FRAMES: usize = 32;
/// Time between two looks of the watchdog.
const TICK: Duration = Duration::from_millis(10);

pub(super) fn new(limits: &Limits) -> wasmtime::Result<Engine> {
    let mut cost = OperatorCost::new();
    // Growing calls the host, whatever the size: without a price of its own, a loop of it would take minutes for the
    // fuel of seconds.
    cost.MemoryGrow = u8::MAX;
    cost.TableGrow = u8::MAX;
    let mut config = Config::new();
    config
        // Fuel, not time, ends an endless loop: after the same instruction everywhere.
        .consume_fuel(true)
        .operator_cost(cost)
        .epoch_interruption(limits.wasm_watchdog)
        // The bits of a NaN are the processor's choice otherwise.
        .cranelift_nan_canonicalization(true)
        // Relaxed instructions are those that may differ between processors.
        .wasm_relaxed_simd(false)
        .cranelift_opt_level(OptLevel::Speed)
        .max_wasm_stack(limits.stack_bytes)
        .wasm_backtrace_max_frames(std::num::NonZeroUsize::new(BACKTRACE_FRAMES));
    Engine::new(&config)
}

/// Starts the clock of the watchdog.
pub(super) fn watch(engine: &Engine) -> std::io::Result<()> {
    let weak = engine.weak();
    std::thread::Builder::new().name("watchdog".to_owned()).spawn(move || tick(&weak))?;
    Ok(())
}

/// Ticks until which a call that begins now may run.
pub(super) fn deadline(limits: &Limits) -> u64 {
    // The first tick may come at once.
    limits.watchdog_ms.div_ceil(TICK.as_millis() as u64) + 1
}

/// Counts time for as long as the engine lives.
fn tick(engine: &EngineWeak) {
    while let Some(engine) = engine.upgrade() {
        engine.increment_epoch();
        drop(engine);
        std::thread::sleep(TICK);
    }
}
