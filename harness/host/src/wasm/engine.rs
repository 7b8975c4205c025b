//! The engine's configuration: whatever it allows must give the same bits on every machine.

use wasmtime::{Config, Engine, OptLevel};

/// Stack of the WASM code, bytes. A worker thread of Rust has 2 MiB by default, of which this leaves half.
pub(super) const STACK_BYTES: usize = 1 << 20;
/// Innermost functions told with a trap.
pub(super) const BACKTRACE_FRAMES: usize = 5;

pub(super) fn new() -> wasmtime::Result<Engine> {
    let mut config = Config::new();
    config
        // Fuel, not time, ends an endless loop: after the same instruction everywhere.
        .consume_fuel(true)
        // The bits of a NaN are the processor's choice otherwise.
        .cranelift_nan_canonicalization(true)
        // Relaxed instructions are those that may differ between processors.
        .wasm_relaxed_simd(false)
        .cranelift_opt_level(OptLevel::Speed)
        .max_wasm_stack(STACK_BYTES)
        .wasm_backtrace_max_frames(std::num::NonZeroUsize::new(BACKTRACE_FRAMES));
    Engine::new(&config)
}
