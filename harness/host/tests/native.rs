//! Native planners in their process: what they may do, and what becomes of those that do more. The plugins are C,
//! compiled here; the tests are skipped where there is no compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use common::{keeper, observation, task};
use vb_host::{
    Carrier, FaultCause, FaultCode, Limits, LoadError, LogSink, NativeOptions, PlannerFault, Plugin,
    ProcessEnd,
};
use vb_sdk::{LogLevel, Series, Task};

/// A library made of `hostile.c`, which does `at_load` when it is opened; none where there is no compiler.
fn compile(at_load: Option<&str>) -> Option<(tempfile::TempDir, PathBuf)> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let dir = tempfile::tempdir().unwrap();
    let library = dir.path().join("hostile.so");
    let mut command = Command::new("cc");
    command.args(["-O1", "-fPIC", "-shared", "-w", "-pthread", "-I"]).arg(tests.join("../../../sdk/c"));
    command.args(at_load.map(|harm| format!("-DHARM_AT_LOAD=\"{harm}\"")));
    let Ok(built) = command.arg("-o").arg(&library).arg(tests.join("hostile.c")).output() else {
        eprintln!("skipped: there is no C compiler");
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some((dir, library))
}

fn limits() -> Limits {
    Limits { memory_bytes: 64 << 20, watchdog_ms: 1500, output_bytes: 1 << 20, ..Limits::default() }
}

fn options() -> NativeOptions {
    NativeOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), require_sandbox: false }
}

fn load(path: &Path) -> Result<Plugin, LoadError> {
    Plugin::load_with(path, &limits(), None, &options())
}

/// The hostile plugin, shared by the tests.
fn hostile() -> Option<Plugin> {
    static PLUGIN: OnceLock<Option<(tempfile::TempDir, Plugin)>> = OnceLock::new();
    let plugin = PLUGIN.get_or_init(|| {
        let (dir, path) = compile(None)?;
        Some((dir, load(&path).unwrap()))
    });
    plugin.as_ref().map(|(_, plugin)| plugin.clone())
}

fn harmful(plugin: &Plugin, what: &str, place: &str) -> Task {
    let given = [("what", what), ("where", place)].map(|(k, v)| (k.to_owned(), v.to_owned()));
    Task { params: plugin.params(&given).unwrap(), ..task() }
}

/// The fault of a planner that does harm.
fn fault(plugin: &Plugin, what: &str, place: &str) -> PlannerFault {
    match plugin.start(&harmful(plugin, what, place), LogSink::discard()) {
        Err(fault) => {
            assert_eq!((fault.step, place), (None, "init"), "{what}");
            fault
        }
        Ok(mut session) => {
            let fault = session.step(&observation()).unwrap_err();
            assert_eq!(session.step(&observation()).unwrap_err(), fault, "a session is over after a fault");
            fault
        }
    }
}

/// A planner of the same plugin that does nothing, which must work whatever another has done.
fn is_well(plugin: &Plugin) {
    let mut session = plugin.start(&harmful(plugin, "nothing", "step"), LogSink::discard()).unwrap();
    assert_eq!(session.step(&observation()).unwrap().steering, 0.5);
}

#[test]
fn a_c_planner_gets_the_observation_and_gives_its_command_and_series() {
    let Some(plugin) = hostile() else { return };
    assert_eq!((plugin.carrier(), plugin.metadata().name.as_str()), (Carrier::Native, "hostile"));
    let mut session = plugin.start(&harmful(&plugin, "nothing", "step"), LogSink::discard()).unwrap();
    let command = session.step(&observation()).unwrap();
    assert_eq!((command.steering, command.brake), (0.5, 0.0));
    assert_eq!(command.debug, [Series { name: "pair".into(), values: vec![1.5, -2.0] }]);
    assert!(session.fuel().is_none());
}

#[test]
fn what_ends_the_process_is_the_planners_crash_with_the_signal_or_code() {
    let Some(plugin) = hostile() else { return };
    let ends = [
        ("segfault", ProcessEnd::Signal(libc::SIGSEGV)),
        ("abort", ProcessEnd::Signal(libc::SIGABRT)),
        ("exit", ProcessEnd::Exit(3)),
        ("exit-0", ProcessEnd::Exit(0)),
    ];
    for (what, how) in ends {
        for place in ["init", "step"] {
            let fault = fault(&plugin, what, place);
            assert_eq!(fault.cause, FaultCause::Crashed { how }, "{what} in {place}");
            assert_eq!(fault.code(), FaultCode::Crashed);
            is_well(&plugin);
        }
    }
}

#[test]
fn a_planner_that_doesnt_answer_is_hung_after_the_watchdogs_time() {
    let Some(plugin) = hostile() else { return };
    for (what, place) in [("spin", "step"), ("sleep", "init"), ("talk", "step")] {
        let fault = fault(&plugin, what, place);
        assert_eq!(fault.cause, FaultCause::Hung { limit_ms: 1500 }, "{what}");
        is_well(&plugin);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn forbidden_system_calls_end_the_planner_by_name() {
    let Some(plugin) = hostile() else { return };
    if !plugin.sandbox().unwrap().seccomp {
        eprintln!("skipped: the kernel has no seccomp");
        return;
    }
    for (what, call) in [("fork", "clone (fork)"), ("exec", "execve"), ("socket", "socket"), ("kill", "kill")]
    {
        let fault = fault(&plugin, what, "step");
        assert_eq!(fault.code(), FaultCode::ImportDenied, "{what}: {fault}");
        assert!(fault.to_string().contains(&format!("the system call {call}")), "{fault}");
        is_well(&plugin);
    }
    assert!(!Path::new("/tmp/vb-hostile").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn files_threads_signal_handlers_and_the_environment_are_out_of_reach() {
    let Some(plugin) = hostile() else { return };
    let words = [
        ("passwd", "it can't be opened"),
        ("write", "it can't be opened"),
        ("thread", "no thread"),
        ("handler", "no handler"),
        ("environment", "first variable: none"),
    ];
    for (what, message) in words {
        assert_eq!(
            fault(&plugin, what, "step").cause,
            FaultCause::Error { message: message.into() },
            "{what}"
        );
        let cause = FaultCause::InitFailed { message: message.into() };
        assert_eq!(fault(&plugin, what, "init").cause, cause, "{what}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn memory_beyond_the_limit_is_told_as_such() {
    let Some(plugin) = hostile() else { return };
    for place in ["init", "step"] {
        let fault = fault(&plugin, "memory", place);
        assert_eq!(fault.code(), FaultCode::OutOfMemory, "{fault}");
        assert!(fault.to_string().contains("67108864"), "{fault}");
        is_well(&plugin);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn calls_nested_too_deeply_are_told_as_such() {
    let Some(plugin) = hostile() else { return };
    let fault = fault(&plugin, "stack", "step");
    assert_eq!(fault.code(), FaultCode::StackOverflow, "{fault}");
    is_well(&plugin);
}

#[test]
fn a_planner_that_closes_the_harnesss_pipes_harms_itself_only() {
    let Some(plugin) = hostile() else { return };
    assert_eq!(fault(&plugin, "close", "step").cause, FaultCause::Crashed { how: ProcessEnd::Exit(1) });
    is_well(&plugin);
}

#[test]
fn forged_messages_are_a_breach_of_the_protocol() {
    let Some(plugin) = hostile() else { return };
    assert_eq!(fault(&plugin, "garbage", "step").code(), FaultCode::Protocol);
    is_well(&plugin);
    let text = fault(&plugin, "text", "step");
    assert!(
        text.code() == FaultCode::Protocol && text.to_string().contains("print to standard error"),
        "{text}"
    );
    // A `ready` precedes the command that is due.
    let forged = fault(&plugin, "twice", "step");
    assert_eq!(forged.code(), FaultCode::Protocol, "{forged}");
    is_well(&plugin);
    let huge = fault(&plugin, "huge", "step");
    assert_eq!(huge.cause, FaultCause::OutputTooLarge { limit: (1 << 20) + (64 << 10) }, "{huge}");
    is_well(&plugin);
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
fn a_flood_of_log_lines_is_cut() {
    let Some((_dir, path)) = compile(None) else { return };
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
    let Some((_dir, path)) = compile(None) else { return };
    let plugin = load(&path).unwrap();
    // The throttle counts the calls in one process.
    let calls = |what: &str| {
        let mut session = plugin.start(&harmful(&plugin, what, "free"), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap().throttle
    };
    assert_eq!([calls("nothing"), calls("nothing"), calls("abort"), calls("nothing")], [1.0, 2.0, 3.0, 1.0]);
}

#[test]
fn a_task_on_another_thread_doesnt_end_with_the_thread_that_started_the_process() {
    let Some((_dir, path)) = compile(None) else { return };
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

#[test]
fn harm_while_the_library_is_opened_is_a_load_error() {
    let codes = [
        ("segfault", FaultCode::Crashed),
        ("exit", FaultCode::Crashed),
        #[cfg(target_os = "linux")]
        ("socket", FaultCode::ImportDenied),
        #[cfg(target_os = "linux")]
        ("fork", FaultCode::ImportDenied),
    ];
    for (what, code) in codes {
        let Some((_dir, path)) = compile(Some(what)) else { return };
        let error = load(&path).unwrap_err();
        assert_eq!(error.code(), code, "{what}: {error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    // Reading secrets fails then as well: the constructor ends the process with code 9 if it doesn't.
    if cfg!(target_os = "linux") {
        let Some((_dir, path)) = compile(Some("passwd")) else { return };
        is_well(&load(&path).unwrap());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_sandbox_tells_what_it_is_made_of() {
    let Some((_dir, path)) = compile(None) else { return };
    let report = *load(&path).unwrap().sandbox().unwrap();
    assert!(report.no_new_privs && report.rlimits, "{report:?}");
    let strict = NativeOptions { require_sandbox: true, ..options() };
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
    let Some((dir, path)) = compile(None) else { return };
    for worker in [dir.path().join("nowhere"), dir.path().to_owned()] {
        let options = NativeOptions { worker: Some(worker), require_sandbox: false };
        let error = Plugin::load_with(&path, &limits(), None, &options).unwrap_err();
        assert_eq!(error.code(), FaultCode::Worker, "{error}");
    }
}

#[test]
fn a_library_without_an_entry_and_one_of_another_version_are_refused() {
    let tests = [
        ("const int vb_planner_nothing = 1;", FaultCode::NotAPlugin),
        (
            "const vb_planner_functions vb_planner_entry = {sizeof(vb_planner_functions), 0, 2, 0, 0, 0};",
            FaultCode::AbiMismatch,
        ),
        ("const vb_planner_functions vb_planner_entry = {16, 0, 1, 0, 0, 0};", FaultCode::AbiMismatch),
        (
            "const vb_planner_functions vb_planner_entry = {sizeof(vb_planner_functions), 0, 1, 0, 0, 0};",
            FaultCode::AbiMismatch,
        ),
    ];
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sdk/c");
    let dir = tempfile::tempdir().unwrap();
    for (i, (entry, code)) in tests.into_iter().enumerate() {
        let (source, library) = (dir.path().join("p.c"), dir.path().join(format!("{i}.so")));
        let metadata = "VB_PLANNER_METADATA(\"p\", \"1\", \"a\", \"b\", \"0.1\", \"\");";
        std::fs::write(&source, format!("#include \"vb_planner.h\"\n{metadata}\n{entry}\n")).unwrap();
        let mut command = Command::new("cc");
        command.args(["-fPIC", "-shared", "-w", "-I"]).arg(&include).arg("-o").arg(&library).arg(&source);
        let Ok(status) = command.status() else {
            eprintln!("skipped: there is no C compiler");
            return;
        };
        assert!(status.success());
        let error = load(&library).unwrap_err();
        assert_eq!(error.code(), code, "{entry}: {error}");
    }
}
