//! Every limit, and what is said of a planner that meets it.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use crate::common::{METADATA, core_module, file, observation, planner_wat, plugin, task};
use vb_host::{FaultCause, Limits, LogSink, PlannerFault, Plugin, Resource};

const OK: &str = "(call $ok_planner)";
const GO: &str = "(call $ok_command (f64.const 0.25) (f64.const 0.5) (f64.const 0))";

fn fault(step: &str, limits: &Limits) -> PlannerFault {
    plugin(OK, step, limits).start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap_err()
}

#[test]
fn a_table_bomb_is_told_as_such() {
    let limits = Limits { table_elements: 5000, ..Limits::default() };
    let found = fault("(call $tables) unreachable", &limits);
    // Two elements to begin with, the plugin's and the component's, then thousands.
    let cause = FaultCause::OutOfMemory { what: Resource::Table, wanted: 5002, limit: 5000 };
    assert_eq!(found.cause, cause);
    assert_eq!(found.code().name(), "planner/out-of-memory");
}

#[test]
fn the_stack_is_as_large_as_it_is_said_to_be() {
    // Fuel counts the calls that fit: twice the stack, twice the calls.
    let calls = |stack_bytes: usize| {
        let limits = Limits { stack_bytes, ..Limits::default() };
        let mut session =
            plugin(OK, "(call $recurse) unreachable", &limits).start(&task(), LogSink::discard()).unwrap();
        let found = session.step(&observation()).unwrap_err();
        assert!(
            matches!(found.cause, FaultCause::StackOverflow { limit, .. } if limit == Some(stack_bytes as u64))
        );
        assert_eq!(found.code().name(), "planner/stack-overflow");
        session.fuel().unwrap().last_step as f64
    };
    let ratio = calls(512 << 10) / calls(256 << 10);
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
}

#[test]
fn the_most_memory_that_a_planner_had_is_told() {
    // 4 pages at the start, 16 more in the first step.
    let step = format!("(drop (memory.grow (i32.const 16))) {GO}");
    let plugin = plugin(OK, &step, &Limits::default());
    let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
    assert_eq!(session.memory_bytes(), Some(4 << 16));
    session.step(&observation()).unwrap();
    assert_eq!(session.memory_bytes(), Some(20 << 16));
}

#[test]
fn growing_in_a_loop_is_dear() {
    // Each call goes to the host, whatever its size: without a price of its own, the budget of seconds would last minutes.
    let grow = |n: u32| format!("{} {GO}", "(drop (memory.grow (i32.const 0)))".repeat(n as usize));
    let fuel = |n| {
        let plugin = plugin(OK, &grow(n), &Limits::default());
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap();
        session.fuel().unwrap().last_step
    };
    // The operand and the call.
    assert_eq!(fuel(110) - fuel(10), 100 * (1 + 255));
}

#[test]
fn filling_memory_costs_its_bytes() {
    let fill = |n: u32| format!("(memory.fill (i32.const 8192) (i32.const 0) (i32.const {n})) {GO}");
    let fuel = |n| {
        let plugin = plugin(OK, &fill(n), &Limits::default());
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap();
        session.fuel().unwrap().last_step
    };
    assert_eq!(fuel(60_000) - fuel(10_000), 50_000);
}

#[test]
fn the_watchdog_ends_what_hangs_and_blames_the_host() {
    // More fuel than a day has nanoseconds.
    let limits =
        Limits { fuel_per_step: i64::MAX as u64, watchdog_ms: 100, wasm_watchdog: true, ..Limits::default() };
    let found = fault("(call $spin) unreachable", &limits);
    assert_eq!(found.cause, FaultCause::Watchdog { limit_ms: 100 });
    assert_eq!(found.code().name(), "host/watchdog");
    assert!(!found.is_planners());
}

#[test]
fn the_watchdog_changes_neither_commands_nor_fuel() {
    let (_dir, path) = file(&core_module(&planner_wat(OK, GO), METADATA));
    let run = |wasm_watchdog| {
        let plugin = Plugin::load(&path, &Limits { wasm_watchdog, ..Limits::default() }, None).unwrap();
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        (session.step(&observation()).unwrap(), session.fuel())
    };
    assert_eq!(run(false), run(true));
}

#[test]
fn every_cause_has_a_hint() {
    let limits = Limits { fuel_per_step: 100_000, ..Limits::default() };
    let found = fault("(call $spin) unreachable", &limits);
    assert_eq!(found.to_string(), "step 0 (t = 0.50 s): exceeded its limit of 100000 units of fuel");
    assert!(found.cause.hint().contains("fuel_per_step"));
}

#[test]
fn a_task_has_fuel_for_all_its_calls() {
    let fuel = |limits: &Limits| {
        let mut session = plugin(OK, GO, limits).start(&task(), LogSink::discard()).unwrap();
        let end = (0..100).find_map(|_| session.step(&observation()).err());
        (session.fuel().unwrap(), end)
    };
    let (used, end) = fuel(&Limits::default());
    assert_eq!(end, None);
    // Enough for half of the steps.
    let fuel_per_task = used.init + used.steps / 2;
    let (capped, end) = fuel(&Limits { fuel_per_task, ..Limits::default() });
    let end = end.unwrap();
    assert_eq!(end.cause, FaultCause::OutOfTaskFuel { budget: fuel_per_task });
    assert_eq!((end.code().name(), end.step), ("planner/out-of-fuel", Some(50)));
    assert!(capped.init + capped.steps <= fuel_per_task);
}

#[test]
fn what_the_engine_calls_its_own_functions_for_is_dear() {
    let fuel = |text: &str, n: usize| {
        let step = format!("{} {GO}", text.repeat(n));
        let item = "(elem declare func $spin) (elem $e func $spin) (data $d \"x\") (func $spin";
        let text = planner_wat(OK, &step).replacen("(func $spin", item, 1);
        let (_dir, path) = file(&core_module(&text, METADATA));
        let plugin = Plugin::load(&path, &Limits::default(), None).unwrap();
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap();
        session.fuel().unwrap().last_step
    };
    let zeros = "(i32.const 0) (i32.const 0) (i32.const 0)";
    for text in [
        "(drop (ref.func $spin))".to_owned(),
        format!("(memory.init $d {zeros})"),
        format!("(table.init $table $e {zeros})"),
        format!("(table.copy $table $table {zeros})"),
        "(table.fill $table (i32.const 0) (ref.null func) (i32.const 0))".to_owned(),
        "(data.drop $d)".to_owned(),
        "(elem.drop $e)".to_owned(),
    ] {
        assert!(fuel(&text, 110) - fuel(&text, 10) >= 100 * 255, "{text}");
    }
}
