//! The hostile corpus: planners that are broken or mean harm, made from source. Each ends under its own code, at the
//! place where it does its harm, within its budget; and planners at work beside it notice nothing.
//!
//! The tables are in `wasm`, `files`, `native` and `commands`. Native ones are C, skipped where there is no compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

#[path = "../common/mod.rs"]
mod common;

mod commands;
mod files;
mod good;
mod native;
mod wasm;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use common::{keeper, observation, task};
use good::Good;
use vb_host::{FaultCode, Limits, LoadError, LogSink, PlannerFault, Plugin, ProcessOptions};
use vb_sdk::Task;

/// The fewest planners that the corpus may have.
const AT_LEAST: usize = 170;

/// Where a planner does its harm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ends {
    /// It is refused, or its process fails, before there is a task.
    Load,
    Init,
    /// In its first step.
    Step,
    /// It drives, which no planner of the corpus does.
    Never,
}

#[derive(Clone, Debug)]
enum Source {
    /// A plugin file of these bytes.
    File(Vec<u8>),
    /// Something else at the path of the plugin: made by this function.
    Place(fn(&Path)),
    /// `hostile.c` with this value of its parameter `what`.
    Harm(&'static str),
    /// A C library of its own: this text after the header and the metadata.
    C(&'static str),
    /// A shell script that speaks the worker protocol, given the folder of its messages.
    Script(String),
}

/// A planner of the corpus and what has to become of it.
#[derive(Clone, Debug)]
struct Case {
    name: &'static str,
    source: Source,
    ends: Ends,
    code: FaultCode,
    /// A part of the message.
    says: &'static str,
}

fn case(name: &'static str, source: Source, ends: Ends, code: FaultCode, says: &'static str) -> Case {
    Case { name, source, ends, code, says }
}

/// Small limits, so that the tests are quick.
fn limits() -> Limits {
    Limits {
        fuel_init: 3_000_000,
        fuel_per_step: 1_000_000,
        memory_bytes: 64 << 20,
        table_elements: 5000,
        output_bytes: 1 << 20,
        log_bytes: 4096,
        module_bytes: 4 << 20,
        compile_bytes: 192 << 20,
        compile_seconds: 3,
        watchdog_ms: 1500,
        ..Limits::default()
    }
}

fn options() -> ProcessOptions {
    ProcessOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), ..ProcessOptions::default() }
}

/// How a planner ended: where, its code and the message.
#[derive(Clone, Debug, PartialEq, Eq)]
struct End {
    ends: Ends,
    code: FaultCode,
    message: String,
}

impl From<LoadError> for End {
    fn from(error: LoadError) -> Self {
        Self { ends: Ends::Load, code: error.code(), message: error.to_string() }
    }
}

impl From<PlannerFault> for End {
    fn from(fault: PlannerFault) -> Self {
        let ends = if fault.step.is_none() { Ends::Init } else { Ends::Step };
        Self { ends, code: fault.code(), message: fault.to_string() }
    }
}

/// Loads the planner of a case; none where there is no C compiler.
fn load(case: &Case, dir: &Path) -> Option<Result<Plugin, LoadError>> {
    let path = dir.join("probe.plugin");
    match &case.source {
        Source::File(bytes) => std::fs::write(&path, bytes).unwrap(),
        Source::Place(make) => make(&path),
        Source::Harm(what) if case.ends == Ends::Load => {
            let harm = format!("HARM_AT_LOAD=\"{what}\"");
            common::compile_c(Path::new("hostile.c"), &path, &[&harm])?;
        }
        Source::Harm(_) => {
            std::fs::copy(hostile()?, &path).unwrap();
        }
        Source::C(text) => {
            let metadata = "VB_PLANNER_METADATA(\"p\", \"1\", \"a\", \"b\", \"0.1\", \"\");";
            let source = dir.join("p.c");
            std::fs::write(&source, format!("#include \"vb_planner.h\"\n{metadata}\n{text}\n")).unwrap();
            common::compile_c(&source, &path, &[])?;
        }
        Source::Script(text) => {
            commands::write_messages(dir);
            let words = ["sh", "-c", &format!("cd '{}'; {text}", dir.display())];
            let words: Vec<OsString> = words.iter().map(Into::into).collect();
            return Some(Plugin::command(&words, &limits()));
        }
    }
    Some(Plugin::load_with(&path, &limits(), None, &options()))
}

/// The library of `hostile.c`, compiled once; none where there is no compiler.
fn hostile() -> Option<&'static Path> {
    static LIBRARY: OnceLock<Option<(tempfile::TempDir, PathBuf)>> = OnceLock::new();
    let compile = || {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("hostile.so");
        common::compile_c(Path::new("hostile.c"), &path, &[])?;
        Some((dir, path))
    };
    LIBRARY.get_or_init(compile).as_ref().map(|(_, path)| path.as_path())
}

fn task_for(case: &Case, plugin: &Plugin) -> Task {
    let Source::Harm(what) = case.source else { return task() };
    let place = if case.ends == Ends::Init { "init" } else { "step" };
    harmful(plugin, what, place)
}

/// A task on which `hostile.c` does `what` at this place.
fn harmful(plugin: &Plugin, what: &str, place: &str) -> Task {
    let given = [("what", what), ("where", place)].map(|(k, v)| (k.to_owned(), v.to_owned()));
    Task { params: plugin.params(&given).unwrap(), ..task() }
}

/// Runs a planner to its end, and holds it to its budget.
fn end(case: &Case, loaded: Result<Plugin, LoadError>) -> End {
    let plugin = match loaded {
        Ok(plugin) => plugin,
        Err(error) => return error.into(),
    };
    let limits = limits();
    let (sink, lines) = keeper();
    let found = match plugin.start(&task_for(case, &plugin), sink) {
        Err(fault) => fault,
        Ok(mut session) => {
            let Err(fault) = session.step(&observation()) else {
                return End { ends: Ends::Never, code: FaultCode::HostPanic, message: "it drives".into() };
            };
            assert_eq!(session.step(&observation()).unwrap_err(), fault, "{}: it is over", case.name);
            if let (Some(fuel), Some(memory)) = (session.fuel(), session.memory_bytes()) {
                assert!(fuel.init <= limits.fuel_init && fuel.max_step <= limits.fuel_per_step, "{fuel:?}");
                assert!(memory <= limits.memory_bytes as u64, "{memory}");
            }
            fault
        }
    };
    assert!(found.is_planners(), "{}: {found}", case.name);
    let written: usize = lines.lock().unwrap().iter().map(|(_, line)| line.len()).sum();
    // The last line says that the rest was dropped.
    assert!(written <= limits.log_bytes + 200, "{}: {written} bytes of log", case.name);
    if matches!(case.source, Source::Harm(_)) {
        // The next task of the same plugin is not its heir.
        let mut session = plugin.start(&harmful(&plugin, "nothing", "step"), LogSink::discard()).unwrap();
        assert_eq!(session.step(&observation()).unwrap().steering, 0.5, "after {}", case.name);
    }
    found.into()
}

/// Runs the planners of a table, with good planners at work before, during and after each, and names all that end in
/// another way than they should.
fn meet(table: &[Case]) {
    let good = Good::planners();
    let mut wrong = Vec::new();
    for case in table {
        let dir = tempfile::tempdir().unwrap();
        let at_work: Vec<_> = good.iter().map(|good| good.begin().half()).collect();
        let Some(loaded) = load(case, dir.path()) else { return };
        let found = end(case, loaded);
        // A refusal begins with the file.
        let file = dir.path().join("probe.plugin").display().to_string();
        let elsewhere = found.ends != Ends::Load || matches!(case.source, Source::Script(_));
        let said = found.message.contains(case.says)
            && !found.message.contains(char::is_control)
            && (elsewhere || found.message.starts_with(&file));
        if (found.ends, found.code) != (case.ends, case.code) || !said {
            wrong.push((case.name, found));
        }
        for (good, at_work) in good.iter().zip(at_work) {
            assert_eq!(at_work.finish(), good.alone, "{} beside a good planner", case.name);
            assert_eq!(good.begin().finish(), good.alone, "a good planner after {}", case.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn wasm_planners_that_do_harm_end_under_their_codes() {
    meet(&wasm::table());
}

#[test]
fn wasm_planners_end_in_the_same_way_every_time() {
    for case in wasm::table() {
        let run = || {
            let dir = tempfile::tempdir().unwrap();
            let found = end(&case, load(&case, dir.path()).unwrap());
            // The message of a refusal begins with the file's path.
            End { message: found.message.replace(dir.path().to_str().unwrap(), ""), ..found }
        };
        assert_eq!(run(), run(), "{}", case.name);
    }
}

#[test]
fn files_that_are_no_planners_are_refused_under_their_codes() {
    meet(&files::table());
}

#[test]
fn native_planners_that_do_harm_end_under_their_codes() {
    meet(&native::table());
}

#[test]
fn what_native_planners_may_not_do_ends_under_its_code() {
    if !Good::seccomp() {
        vb_testing::skip("the kernel has no seccomp");
        return;
    }
    meet(&native::confined());
    // Written by one, and by the shell that another starts, if they were let.
    assert!(!Path::new("/tmp/vb-hostile").exists());
}

#[test]
fn commands_that_do_harm_end_under_their_codes() {
    meet(&commands::table());
}

#[test]
fn the_corpus_is_large_enough_and_knows_every_code_that_a_plugin_can_cause() {
    let tables =
        [wasm::table(), files::table(), native::table(), native::confined(), commands::table()].concat();
    eprintln!("{} planners", tables.len());
    assert!(tables.len() >= AT_LEAST, "{} planners", tables.len());
    let mut names: Vec<_> = tables.iter().map(|c| c.name).collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "two have the same name");
    for code in FaultCode::ALL.iter().filter(|code| code.name().starts_with("planner/")) {
        assert!(tables.iter().any(|case| case.code == *code), "no planner ends as {code}");
    }
}

#[test]
fn commands_that_are_wild_but_finite_are_clamped_and_no_fault() {
    let denormal = f64::from_bits(1);
    for (given, clamped) in [
        ([1e300, 7.0, -0.5], [1.0, 1.0, 0.0]),
        ([-f64::MAX, -1e-300, 2.0], [-1.0, 0.0, 1.0]),
        ([denormal, denormal, -denormal], [denormal, denormal, 0.0]),
    ] {
        let [steering, throttle, brake] = given;
        let step = format!(
            "(call $ok_command (f64.const {steering:e}) (f64.const {throttle:e}) (f64.const {brake:e}))"
        );
        let mut session =
            common::plugin(wasm::OK, &step, &limits()).start(&task(), LogSink::discard()).unwrap();
        let (command, changed) = session.step(&observation()).unwrap().clamped();
        assert_eq!([command.steering, command.throttle, command.brake], clamped);
        assert_eq!(changed, given != clamped);
    }
}

#[test]
fn planners_that_run_alternately_leave_no_trace_in_each_other() {
    // Two of each kind, each at two tasks at a time; those of a library are in two processes.
    let good = || Good::planners().iter().chain(Good::planners());
    let mut at_work: Vec<_> = good().map(Good::begin).collect();
    for _ in 0..good::STEPS {
        at_work.iter_mut().for_each(good::AtWork::step);
    }
    for (good, at_work) in good().zip(at_work) {
        assert_eq!(at_work.finish(), good.alone);
    }
}
