//! The engine's configuration: whatever it allows must give the same bits on every machine.

use std::time::Duration;

use vb_nan::FEATURES;
use wasmtime::{Config, Engine, EngineWeak, OperatorCost, OptLevel};

use crate::Limits;

/// Innermost functions told with a trap.
pub(super) const BACKTRACE_FRAMES: usize = 32;
/// Time between two looks of the watchdog.
const TICK: Duration = Duration::from_millis(10);

/// What x86-64-v3 has beyond the first x86-64 processors, as far as the compiler knows it.
#[cfg(target_arch = "x86_64")]
const X86_64_V3: [&str; 12] = [
    "has_cmpxchg16b",
    "has_sse3",
    "has_ssse3",
    "has_sse41",
    "has_sse42",
    "has_popcnt",
    "has_avx",
    "has_avx2",
    "has_fma",
    "has_bmi1",
    "has_bmi2",
    "has_lzcnt",
];

/// Has code compiled for the same processor everywhere, whatever this machine's can do: the frames of functions, and with
/// them the depth at which a recursion ends, depend on the instructions that there are. On x86-64 that is x86-64-v3, with
/// which a step of MPPI takes no longer than with all that a newer processor has; elsewhere it is the architecture's baseline.
fn fix_processor(config: &mut Config) -> wasmtime::Result<()> {
    config.target(&target_lexicon::HOST.to_string())?;
    #[cfg(target_arch = "x86_64")]
    {
        let known = std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("fma")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt");
        if !known {
            return Err(wasmtime::Error::msg(
                "its processor lacks instructions of x86-64-v3 (AVX2, FMA, BMI2, LZCNT), for which planners are compiled, so \
                 that results are identical everywhere; use another machine",
            ));
        }
        for feature in X86_64_V3 {
            // SAFETY: the flag only permits instructions, and the engine refuses to run code on a processor without
            // them.
            unsafe { config.cranelift_flag_enable(feature) };
        }
    }
    Ok(())
}

pub(super) fn new(limits: &Limits) -> wasmtime::Result<Engine> {
    Engine::new(&config(limits)?)
}

pub(super) fn config(limits: &Limits) -> wasmtime::Result<Config> {
    let mut cost = OperatorCost::new();
    // Growing calls the host, whatever the size: without a price of its own, a loop of it would take minutes for the
    // fuel of seconds.
    cost.MemoryGrow = u8::MAX;
    cost.TableGrow = u8::MAX;
    // So do these, some for a size of nothing, and a planner has no use for many of them.
    cost.RefFunc = u8::MAX;
    cost.MemoryInit = u8::MAX;
    cost.DataDrop = u8::MAX;
    cost.TableInit = u8::MAX;
    cost.ElemDrop = u8::MAX;
    cost.TableCopy = u8::MAX;
    cost.TableFill = u8::MAX;
    let mut config = Config::new();
    config
        // Fuel, not time, ends an endless loop: after the same instruction everywhere.
        .consume_fuel(true)
        .operator_cost(cost)
        .epoch_interruption(limits.wasm_watchdog)
        // The bits of a NaN are the processor's choice; `vb_nan` makes those canonical that are observable.
        .cranelift_nan_canonicalization(false)
        .wasm_features(FEATURES.complement(), false)
        .wasm_features(FEATURES, true)
        .cranelift_opt_level(OptLevel::Speed)
        .max_wasm_stack(limits.stack_bytes)
        .wasm_backtrace_max_frames(std::num::NonZeroUsize::new(BACKTRACE_FRAMES));
    fix_processor(&mut config)?;
    Ok(config)
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
