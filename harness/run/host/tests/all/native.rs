//! Native planners in their process: what they may do, and how the process is kept. What becomes of those that do harm
//! is in `hostile`. The plugins are C, compiled here; the tests are skipped where there is no compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::common::{keeper, observation, task};
use vb_host::{FaultCause, FaultCode, Limits, LoadError, LogSink, Plugin, PluginKind, ProcessOptions};
use vb_sdk::{LogLevel, Series, Task};

/// A library made of `hostile.c`, with macros; none where there is no compiler.
fn compile(macros: &[&str]) -> Option<(tempfile::TempDir, PathBuf)> {
    let dir = tempfile::tempdir().unwrap();
    let library = dir.path().join("hostile.so");
    crate::common::compile_c(Path::new("hostile.c"), &library, macros)?;
    Some((dir, library))
}

fn limits() -> Limits {
    Limits { memory_bytes: 64 << 20, watchdog_ms: 1500, output_bytes: 1 << 20, ..Limits::default() }
}

fn options() -> ProcessOptions {
    ProcessOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), ..ProcessOptions::default() }
}

fn load(path: &Path) -> Result<Plugin, LoadError> {
    Plugin::load_with(path, &limits(), None, &options())
}

/// The hostile plugin, shared by the tests.
fn hostile() -> Option<Plugin> {
    static PLUGIN: OnceLock<Option<(tempfile::TempDir, Plugin)>> = OnceLock::new();
    let plugin = PLUGIN.get_or_init(|| {
        let (dir, path) = compile(&[])?;
        Some((dir, load(&path).unwrap()))
    });
    plugin.as_ref().map(|(_, plugin)| plugin.clone())
}

fn harmful(plugin: &Plugin, what: &str, place: &str) -> Task {
    let given = [("what", what), ("where", place)].map(|(k, v)| (k.to_owned(), v.to_owned()));
    Task { params: plugin.params(&given).unwrap(), ..task() }
}

/// A planner of the same plugin that does nothing, which must work whatever another has done.
fn is_well(plugin: &Plugin) {
    let mut session = plugin.start(&harmful(plugin, "nothing", "step"), LogSink::discard()).unwrap();
    assert_eq!(session.step(&observation()).unwrap().steering, 0.5);
}

#[test]
fn a_c_planner_gets_the_observation_and_gives_its_command_and_series() {
    let Some(plugin) = hostile() else { return };
    assert_eq!((plugin.kind(), plugin.metadata().name.as_str()), (PluginKind::Native, "hostile"));
    let mut session = plugin.start(&harmful(&plugin, "nothing", "step"), LogSink::discard()).unwrap();
    let command = session.step(&observation()).unwrap();
    assert_eq!((command.steering, command.brake), (0.5, 0.0));
    assert_eq!(command.debug, [Series { name: "pair".into(), values: vec![1.5, -2.0] }]);
    assert!(session.fuel().is_none());
}

#[test]
fn what_a_planner_prints_is_in_the_log_and_its_input_is_empty() {
    let Some(plugin) = hostile() else { return };
    let (sink, lines) = keeper();
    let mut session = plugin.start(&harmful(&plugin, "print", "step"), sink).unwrap();
    let fault = session.step(&observation()).unwrap_err();
    assert_eq!(fault.cause, FaultCause::Error { message: "standard input gives -1".into() });
    drop(session);
    let expected = ["stderr: to standard output", "stderr: to standard error \u{fffd}[2J"];
    let expected = expected.map(|line| (LogLevel::Info, line.to_owned()));
    assert_eq!(*lines.lock().unwrap(), expected);
}

#[test]
fn what_a_planner_prints_without_a_flush_is_in_the_log_of_its_task() {
    let Some(plugin) = hostile() else { return };
    for place in ["init", "step", "free"] {
        let (sink, lines) = keeper();
        let mut session = plugin.start(&harmful(&plugin, "mutter", place), sink).unwrap();
        session.step(&observation()).unwrap();
        drop(session);
        let expected = [(LogLevel::Info, "stderr: said without a flush".to_owned())];
        assert_eq!(*lines.lock().unwrap(), expected, "{place}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_linker_that_drops_what_nobody_uses_keeps_the_metadata() {
    let dir = tempfile::tempdir().unwrap();
    let library = dir.path().join("hostile.so");
    let options = ["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections"];
    if crate::common::compile_c_with(Path::new("hostile.c"), &library, &options).is_none() {
        return;
    }
    assert_eq!(vb_host::inspect(&library).unwrap().name, "hostile");
}

#[test]
fn a_native_planner_is_told_only_of_limits_that_it_has() {
    let Some(plugin) = hostile() else { return };
    let fault = |what: &str| {
        let mut session = plugin.start(&harmful(&plugin, what, "step"), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap_err()
    };
    let memory = fault("memory");
    assert_eq!(memory.code(), FaultCode::OutOfMemory);
    assert!(memory.to_string().ends_with("exceeded its memory limit of 67108864 bytes"), "{memory}");
    let hint = memory.cause.hint();
    assert!(hint.contains("memory_bytes") && !hint.contains("table_elements"), "{hint}");
    let stack = fault("stack");
    assert_eq!(stack.code(), FaultCode::StackOverflow);
    let hint = stack.cause.hint();
    assert!(hint.contains("ulimit -s") && !hint.contains("raise stack_bytes"), "{hint}");
}

#[test]
fn a_flood_of_log_lines_is_cut() {
    let Some((_dir, path)) = compile(&[]) else { return };
    let limits = Limits { log_bytes: 100, ..limits() };
    let plugin = Plugin::load_with(&path, &limits, None, &options()).unwrap();
    let (sink, lines) = keeper();
    let mut session = plugin.start(&harmful(&plugin, "talk", "step"), sink).unwrap();
    session.step(&observation()).unwrap_err();
    let lines = lines.lock().unwrap();
    // Twelve lines of 8 bytes, and a word on the rest.
    assert_eq!((lines.len(), lines[12].0), (13, LogLevel::Warn));
}

#[test]
fn a_planner_that_fails_when_its_task_is_over_changes_nothing() {
    let Some(plugin) = hostile() else { return };
    for what in ["segfault", "exit", "spin"] {
        let mut session = plugin.start(&harmful(&plugin, what, "free"), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap();
        drop(session);
        is_well(&plugin);
    }
}

#[test]
fn a_healthy_process_is_used_again_and_a_faulty_one_is_not() {
    let Some((_dir, path)) = compile(&[]) else { return };
    let plugin = load(&path).unwrap();
    // The throttle counts the calls in one process.
    let calls = |what: &str| {
        let mut session = plugin.start(&harmful(&plugin, what, "free"), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap().throttle
    };
    assert_eq!([calls("nothing"), calls("nothing"), calls("abort"), calls("nothing")], [1.0, 2.0, 3.0, 1.0]);
}

#[test]
fn a_library_that_was_built_anew_during_a_run_is_not_opened_in_the_place_of_the_first() {
    let Some((_dir, path)) = compile(&[]) else { return };
    let Some((_other_dir, other)) = compile(&["HARM_AT_LOAD=\"nothing\""]) else { return };
    let plugin = load(&path).unwrap();
    let start = || plugin.start(&harmful(&plugin, "nothing", "step"), LogSink::discard());
    // Keeps the process of the loading, so that the next task needs another.
    let mut first = start().unwrap();
    std::fs::rename(other, &path).unwrap();
    let fault = start().unwrap_err();
    assert_eq!(fault.cause.code(), FaultCode::Worker, "{fault}");
    assert!(fault.to_string().contains("its file has changed"), "{fault}");
    assert_eq!(first.step(&observation()).unwrap().steering, 0.5);
}

#[test]
fn a_task_on_another_thread_doesnt_end_with_the_thread_that_started_the_process() {
    let Some((_dir, path)) = compile(&[]) else { return };
    let plugin = load(&path).unwrap();
    let start = || plugin.start(&harmful(&plugin, "nothing", "step"), LogSink::discard()).unwrap();
    let mut session = std::thread::scope(|scope| {
        let first = start();
        // The first has the process of the loading; this one is started on the thread.
        let second = scope.spawn(start).join().unwrap();
        drop(first);
        second
    });
    std::thread::sleep(std::time::Duration::from_millis(50));
    assert_eq!(session.step(&observation()).unwrap().steering, 0.5);
}

#[cfg(target_os = "linux")]
#[test]
fn the_sandbox_tells_what_it_is_made_of() {
    let Some((_dir, path)) = compile(&[]) else { return };
    let report = *load(&path).unwrap().sandbox().unwrap();
    assert!(report.no_new_privs && report.rlimits, "{report:?}");
    // Else the tests of what it forbids would be left out.
    assert_eq!(report.seccomp, Path::new("/proc/sys/kernel/seccomp").exists(), "{report:?}");
    let strict = ProcessOptions { require_sandbox: true, ..options() };
    match Plugin::load_with(&path, &limits(), None, &strict) {
        Ok(_) => assert!(report.missing().is_empty(), "{report:?}"),
        Err(error) => {
            assert!(!report.missing().is_empty(), "{error}");
            assert_eq!(error.code(), FaultCode::Worker);
        }
    }
}

#[test]
fn a_worker_that_cant_be_started_is_the_hosts_fault() {
    let Some((dir, path)) = compile(&[]) else { return };
    for worker in [dir.path().join("nowhere"), dir.path().to_owned()] {
        let options = ProcessOptions { worker: Some(worker), ..ProcessOptions::default() };
        let error = Plugin::load_with(&path, &limits(), None, &options).unwrap_err();
        assert_eq!(error.code(), FaultCode::Worker, "{error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_that_is_being_opened_may_do_no_more_than_later() {
    let Some(plugin) = hostile() else { return };
    if plugin.sandbox().is_none_or(|report| !report.missing().is_empty()) {
        vb_testing::skip("the kernel can't confine planners");
        return;
    }
    // Its constructor ends the process with code 9 if it is let.
    for harm in [
        "passwd",
        "write",
        "limits",
        "parents-limits",
        "own",
        "signal",
        "async",
        "survive",
        "dumpable",
        "filter-prctl",
        "shared",
        "downwards",
        "thread",
        "handler",
    ] {
        let Some((_dir, path)) = compile(&[&format!("HARM_AT_LOAD=\"{harm}\"")]) else { return };
        let plugin = load(&path).unwrap_or_else(|e| panic!("{harm}: {e}"));
        is_well(&plugin);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_process_that_was_killed_from_outside_is_not_blamed_on_its_planner() {
    use rustix::process::{Pid, Signal, kill_process};
    let Some(plugin) = hostile() else { return };
    if !plugin.sandbox().is_some_and(|report| report.seccomp) {
        vb_testing::skip("the kernel has no seccomp");
        return;
    }
    for signal in [Signal::KILL, Signal::TERM] {
        // It tells its number and then waits for its end.
        let sink = LogSink::new(move |_, line| {
            let pid = line.trim().parse().ok().and_then(Pid::from_raw).unwrap();
            kill_process(pid, signal).unwrap();
        });
        let mut session = plugin.start(&harmful(&plugin, "wait", "step"), sink).unwrap();
        let fault = session.step(&observation()).unwrap_err();
        assert_eq!(fault.code(), FaultCode::Machine, "{fault}");
        assert!(fault.to_string().contains("killed from outside"), "{fault}");
        assert!(!fault.is_planners());
        drop(session);
        is_well(&plugin);
    }
}
