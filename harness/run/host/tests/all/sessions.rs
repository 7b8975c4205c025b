//! WASM planners at work, and what is told of those that fail. The codes of all ways to fail are in `hostile`.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use crate::common::{keeper, observation, plugin, task};
use vb_host::{FaultCause, Limits, LogSink, PlannerFault, Plugin, PluginKind, Resource, Session};
use vb_sdk::{Command, LogLevel};

const OK: &str = "(call $ok_planner)";
const GO: &str = "(call $ok_command (f64.const 0.25) (f64.const 0.5) (f64.const 0))";

/// Small limits, so that the tests are quick.
fn limits() -> Limits {
    Limits { fuel_init: 1_000_000, fuel_per_step: 100_000, memory_bytes: 4 << 20, ..Limits::default() }
}

fn started(step: &str) -> Session {
    plugin(OK, step, &limits()).start(&task(), LogSink::discard()).unwrap()
}

fn step_fault(step: &str) -> PlannerFault {
    started(step).step(&observation()).unwrap_err()
}

#[test]
fn a_planner_gets_the_observation_and_gives_its_command() {
    // Behind the planner's handle comes the observation, whose first field is its time: 0.5.
    let mut session =
        started("(call $ok_command (f64.load offset=8 (local.get $args)) (f64.const 1) (f64.const 0.125))");
    let command = session.step(&observation()).unwrap();
    assert_eq!(command, Command { steering: 0.5, throttle: 1.0, brake: 0.125, ..Command::default() });
}

#[test]
fn every_session_starts_afresh() {
    let plugin = plugin(
        OK,
        "(call $ok_command (f64.convert_i32_u (global.get $calls)) (f64.const 0) (f64.const 0))",
        &limits(),
    );
    assert_eq!(plugin.kind(), PluginKind::Wasm);
    for _ in 0..3 {
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        assert_eq!(session.step(&observation()).unwrap().steering, 1.0);
        assert_eq!(session.step(&observation()).unwrap().steering, 2.0);
    }
}

#[test]
fn a_plugin_serves_several_threads() {
    fn shared<T: Send + Sync>(_: &T) {}
    let plugin = plugin(OK, GO, &limits());
    shared(&plugin);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap());
        }
    });
}

#[test]
fn fuel_is_counted_the_same_every_time() {
    let plugin = plugin(OK, GO, &limits());
    let run = |plugin: &Plugin| {
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        for _ in 0..3 {
            session.step(&observation()).unwrap();
        }
        (session.fuel().unwrap(), session.fuel_used().unwrap())
    };
    let (fuel, total) = run(&plugin);
    assert_eq!(run(&plugin), (fuel, total));
    assert!(fuel.init > 0 && fuel.last_step > 0);
    assert_eq!(
        (fuel.steps, fuel.max_step, total),
        (3 * fuel.last_step, fuel.last_step, fuel.init + fuel.steps)
    );
}

#[test]
fn endless_logging_runs_out_of_fuel_too() {
    // 1000 units and one a byte for each line, so a hundred lines at most with 100 000 units.
    let (sink, lines) = keeper();
    let loud = "(loop $l (call $log (i32.const 2) (i32.const 16) (i32.const 9)) (br $l)) unreachable";
    let fault = plugin(OK, loud, &limits()).start(&task(), sink).unwrap().step(&observation()).unwrap_err();
    assert_eq!(fault.code().name(), "planner/out-of-fuel");
    assert_eq!(lines.lock().unwrap().len(), 98);
}

#[test]
fn a_memory_hog_is_told_as_such() {
    let fault = step_fault("(call $hog) unreachable");
    // The module has 4 pages, and asks for 16 more until it is refused.
    let cause = |wanted, limit| FaultCause::OutOfMemory { what: Resource::Memory, wanted, limit };
    assert_eq!(fault.cause, cause((4 + 4 * 16) << 16, 4 << 20));
    // More at the start than it may have.
    let small = Limits { memory_bytes: 100_000, ..limits() };
    let fault = plugin(OK, GO, &small).start(&task(), LogSink::discard()).unwrap_err();
    assert_eq!(fault.cause, cause(4 << 16, 100_000));
}

#[test]
fn a_panic_keeps_its_text() {
    let (sink, lines) = keeper();
    let panics = "(call $log (i32.const 0) (i32.const 32) (i32.const 47)) unreachable";
    let fault = plugin(OK, panics, &limits()).start(&task(), sink).unwrap().step(&observation()).unwrap_err();
    assert_eq!(fault.to_string(), "step 0 (t = 0.50 s): panicked at src/lib.rs:3:5: index out of bounds");
    assert_eq!(fault.code().name(), "planner/panic");
    assert_eq!(lines.lock().unwrap()[0].0, LogLevel::Error);
}

#[test]
fn a_command_that_is_not_finite_is_a_fault_with_its_step() {
    let step = "(call $ok_command (f64.const 0) (f64.const 0)
                (select (f64.const nan) (f64.const 0) (i32.eq (global.get $calls) (i32.const 2))))";
    let mut session = started(step);
    session.step(&observation()).unwrap();
    let fault = session.step(&observation()).unwrap_err();
    let cause = FaultCause::InvalidOutput { field: "brake", value: "NaN".into() };
    assert_eq!(fault, PlannerFault { step: Some(1), time: Some(0.5), cause });
    // The session is over.
    assert_eq!(session.step(&observation()).unwrap_err(), fault);
}

#[test]
fn log_lines_reach_the_sink_up_to_the_limit() {
    let (sink, lines) = keeper();
    let talks = format!("(call $log (i32.const 2) (i32.const 16) (i32.const 9)) {GO}");
    let plugin = plugin(OK, &talks, &Limits { log_bytes: 20, ..limits() });
    let mut session = plugin.start(&task(), sink).unwrap();
    for _ in 0..5 {
        session.step(&observation()).unwrap();
    }
    let lines = lines.lock().unwrap();
    assert_eq!(lines[..2], [(LogLevel::Info, "hello log".into()), (LogLevel::Info, "hello log".into())]);
    assert_eq!((lines.len(), lines[2].0), (3, LogLevel::Warn));
}

#[test]
fn faults_are_serialised_with_their_kind() {
    let json = serde_json::to_value(step_fault("(call $spin) unreachable")).unwrap();
    assert_eq!(
        json,
        serde_json::json!({"step": 0, "time": 0.5, "cause": {"kind": "out-of-fuel", "budget": 100_000}})
    );
}
