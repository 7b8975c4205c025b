//! Planners from toolchains that need WASI: here a module for `wasm32-wasip1`, which the harness makes a component with
//! imports of WASI 0.2.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use crate::common::{METADATA, core_module, core_module_of, file, keeper, observation, planner_wat, task};
use vb_host::{FaultCause, Limits, LogSink, Plugin};
use vb_sdk::{Command, LogLevel, Observation, Task};

/// A planner whose step has WASI's functions: `$random`, `$clock`, `$write`, `$open`, `$exit`, `$environ`. A list of
/// one vector for `$write` lies at 3100, with the text "hello log", at 3120 with a panic's text, and at 3140 with that of a
/// language's runtime.
fn wasip1(step: &str) -> Plugin {
    let imports = r#"(module
  (import "wasi_snapshot_preview1" "random_get" (func $random (param i32 i32) (result i32)))
  (import "wasi_snapshot_preview1" "clock_time_get" (func $clock (param i32 i64 i32) (result i32)))
  (import "wasi_snapshot_preview1" "fd_write" (func $write (param i32 i32 i32 i32) (result i32)))
  (import "wasi_snapshot_preview1" "path_open"
    (func $open (param i32 i32 i32 i32 i32 i64 i64 i32 i32) (result i32)))
  (import "wasi_snapshot_preview1" "environ_sizes_get" (func $environ (param i32 i32) (result i32)))
  (import "wasi_snapshot_preview1" "proc_exit" (func $exit (param i32)))
  (data (i32.const 3100) "\10\00\00\00\09\00\00\00")
  (data (i32.const 3120) "\20\00\00\00\2f\00\00\00")
  (data (i32.const 3140) "\60\0c\00\00\2b\00\00\00")
  (data (i32.const 3168) "panicked at runtime.rs:1:1:\nPython function")"#;
    let wat = planner_wat("(call $ok_planner)", step).replacen("(module", imports, 1);
    let (_dir, path) = file(&core_module(&wat, METADATA));
    Plugin::load(&path, &Limits::default(), None).unwrap()
}

fn steps(plugin: &Plugin, seed: u64) -> Vec<Command> {
    let mut session = plugin.start(&Task { seed, ..task() }, LogSink::discard()).unwrap();
    (1..4).map(|t| session.step(&Observation { time: f64::from(t), ..observation() }).unwrap()).collect()
}

/// Steering: a random number. Throttle: the monotonic clock, s. Brake: the wall clock, s.
const CLOCKS_AND_RANDOM: &str = "
    (drop (call $random (i32.const 3000) (i32.const 8)))
    (drop (call $clock (i32.const 1) (i64.const 1) (i32.const 3008)))
    (drop (call $clock (i32.const 0) (i64.const 1) (i32.const 3016)))
    (call $ok_command
      (f64.mul (f64.convert_i64_u (i64.load (i32.const 3000))) (f64.const 0x1p-64))
      (f64.mul (f64.convert_i64_u (i64.load (i32.const 3008))) (f64.const 1e-9))
      (f64.mul (f64.convert_i64_u (i64.load (i32.const 3016))) (f64.const 1e-9)))";

#[test]
fn clocks_show_simulated_time_and_random_numbers_come_from_the_seed() {
    let plugin = wasip1(CLOCKS_AND_RANDOM);
    let commands = steps(&plugin, 7);
    for (t, command) in (1..).zip(&commands) {
        assert_eq!((command.throttle, command.brake), (f64::from(t), f64::from(t)));
    }
    assert!(commands[0].steering != commands[1].steering && commands[1].steering != commands[2].steering);
    // The same with the same seed, others with another.
    assert_eq!(steps(&plugin, 7), commands);
    assert_ne!(steps(&plugin, 8)[0].steering, commands[0].steering);
}

#[test]
fn what_is_written_goes_to_the_log() {
    let plugin = wasip1(
        "(drop (call $write (i32.const 1) (i32.const 3100) (i32.const 1) (i32.const 3108)))
         (drop (call $write (i32.const 2) (i32.const 3100) (i32.const 1) (i32.const 3108)))
         (call $ok_command (f64.const 0) (f64.const 0) (f64.const 0))",
    );
    let (sink, lines) = keeper();
    plugin.start(&task(), sink).unwrap().step(&observation()).unwrap();
    let expected = [(LogLevel::Info, "hello log".to_owned()), (LogLevel::Warn, "hello log".to_owned())];
    assert_eq!(*lines.lock().unwrap(), expected);
}

#[test]
fn a_panic_reported_on_standard_error_keeps_its_text() {
    let plugin = wasip1(
        "(drop (call $write (i32.const 2) (i32.const 3120) (i32.const 1) (i32.const 3108))) unreachable",
    );
    let found = plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap_err();
    assert_eq!(
        found.cause,
        FaultCause::Panic { message: "panicked at src/lib.rs:3:5: index out of bounds".into() }
    );
}

/// The runtime of a language panics after the planner has told its own place, which is the one that helps.
#[test]
fn a_panic_that_the_planner_logged_outlives_the_report_of_its_runtime() {
    let plugin = wasip1(
        "(call $log (i32.const 0) (i32.const 32) (i32.const 47))
         (drop (call $write (i32.const 2) (i32.const 3140) (i32.const 1) (i32.const 3108))) unreachable",
    );
    let found = plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap_err();
    assert_eq!(
        found.cause,
        FaultCause::Panic { message: "panicked at src/lib.rs:3:5: index out of bounds".into() }
    );
}

#[test]
fn there_are_no_files_and_no_environment() {
    // The number of variables, and the error for opening a file in the first directory that was opened beforehand.
    let plugin = wasip1(
        "(drop (call $environ (i32.const 3000) (i32.const 3004)))
         (call $ok_command
           (f64.convert_i32_u (i32.load (i32.const 3000)))
           (f64.convert_i32_u (call $open (i32.const 3) (i32.const 0) (i32.const 16) (i32.const 5) (i32.const 0)
             (i64.const 0) (i64.const 0) (i32.const 0) (i32.const 3008)))
           (f64.const 0))",
    );
    let command = plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap();
    // 8 is `badf` in preview 1: there is no such directory.
    assert_eq!((command.steering, command.throttle), (0.0, 8.0));
}

/// A planner that imports a part of WASI's sockets.
fn with_sockets(step: &str) -> Plugin {
    let sockets = "package wasi:sockets@0.2.3;
        interface network {
          enum error-code { unknown, access-denied }
          enum ip-address-family { ipv4, ipv6 }
          resource network;
        }
        interface instance-network { use network.{network}; instance-network: func() -> network; }
        interface tcp { resource tcp-socket; }
        interface tcp-create-socket {
          use network.{error-code, ip-address-family};
          use tcp.{tcp-socket};
          create-tcp-socket: func(address-family: ip-address-family) -> result<tcp-socket, error-code>;
        }";
    let world = "package test:probe;
        world probe {
          include vertibench:planner/planner-plugin@1.0.0;
          import wasi:sockets/instance-network@0.2.3;
          import wasi:sockets/tcp-create-socket@0.2.3;
        }";
    let imports = r#"(module
  (import "wasi:sockets/instance-network@0.2.3" "instance-network" (func $network (result i32)))
  (import "wasi:sockets/tcp-create-socket@0.2.3" "create-tcp-socket" (func $socket (param i32 i32)))"#;
    let wat = planner_wat("(call $ok_planner)", step).replacen("(module", imports, 1);
    let (_dir, path) = file(&core_module_of(&wat, METADATA, &[sockets, world]));
    Plugin::load(&path, &Limits::default(), None).unwrap()
}

#[test]
fn access_to_the_network_is_denied() {
    // The result's discriminant, 1 for an error, and the error's number, 1 for access denied.
    let plugin = with_sockets(
        "(call $socket (i32.const 0) (i32.const 3000))
         (call $ok_command (f64.convert_i32_u (i32.load8_u (i32.const 3000)))
           (f64.convert_i32_u (i32.load8_u (i32.const 3004))) (f64.const 0))",
    );
    let command = plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap();
    assert_eq!((command.steering, command.throttle), (1.0, 1.0));
}

#[test]
fn what_cannot_be_denied_by_its_result_ends_the_task() {
    let plugin = with_sockets("(drop (call $network)) unreachable");
    let found = plugin.start(&task(), LogSink::discard()).unwrap().step(&observation()).unwrap_err();
    assert_eq!(found.code().name(), "planner/import-denied");
    assert!(found.to_string().contains("wasi:sockets/instance-network instance-network"), "{found}");
}
