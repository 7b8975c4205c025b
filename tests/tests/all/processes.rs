//! Planners in processes of their own, as users run them: C++ libraries and Python commands.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;
use vb_tests::{Bench, PluginKind, plugin, root};

const TASKS: &str = "w001/t00-t02";

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// A Python that has what `sdk/python` needs: the one that `VB_PYTHON` names, or that of the path.
fn python() -> Option<&'static str> {
    static PYTHON: OnceLock<Option<String>> = OnceLock::new();
    let found = PYTHON.get_or_init(|| {
        let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
        let check =
            with_libraries(&mut Command::new(&program)).args(["-c", "import numpy, msgpack"]).output();
        if check.is_ok_and(|o| o.status.success()) {
            return Some(program);
        }
        vb_testing::skip(format_args!(
            "{program} lacks numpy or msgpack (pip install numpy msgpack, or set VB_PYTHON or VB_PYTHON_LIBS)"
        ));
        None
    });
    found.as_deref()
}

/// Python finds the module of this repository, and what `VB_PYTHON_LIBS` holds.
fn with_libraries(command: &mut Command) -> &mut Command {
    let mut folders = vec![root().join("sdk/python/src")];
    folders.extend(std::env::var_os("VB_PYTHON_LIBS").map(PathBuf::from));
    let path = std::env::join_paths(folders).expect("folders without colons");
    command.env("PYTHONPATH", path)
}

/// Runs a Python planner over a few tasks.
fn drive(bench: &Bench, script: &Path, out: &str, more: &[&str]) -> vb_tests::Done {
    let command = format!("{} '{}'", python().expect("there is a Python"), text(script));
    let args = ["--plugin", &command, "--tasks", TASKS, "--jobs", "2", "--out", out];
    let mut command = bench.command(&[&args[..], more].concat());
    vb_tests::Done::of(with_libraries(&mut command))
}

fn example(name: &str) -> PathBuf {
    root().join("sdk/python/examples").join(name)
}

#[test]
fn a_new_project_with_numpy_drives_as_the_example_and_its_commands_are_recorded() {
    let Some(python) = python() else { return };
    let bench = Bench::new();
    bench.ok(&["plugin", "new", "fox", "--lang", "numpy"]);
    // Not with the SDK of this repository: the project has its own.
    let planner = format!("{python} '{}'", text(&bench.path("fox/planner.py")));
    let run = |args: &[&str]| {
        let mut command = bench.command(args);
        if let Some(libraries) = std::env::var_os("VB_PYTHON_LIBS") {
            command.env("PYTHONPATH", libraries);
        }
        vb_tests::Done::of(&mut command).ok()
    };
    assert!(run(&["inspect", &planner]).contains("fox 0.1.0"));
    assert!(run(&["check", &planner]).contains("0 failed"));
    run(&["run", &planner, "--tasks", "w001/t00", "--out", "fox-run"]);
    let _ = drive(&bench, &example("pursuit.py"), "example", &[]).ok();
    let hash = |run: &str| bench.records(run)["w001/t00"]["state_hash"].clone();
    assert_eq!(hash("fox-run"), hash("example"));
    run(&["commands", "fox-run", "--out", "fox.commands"]);
    run(&["run", "fox.commands", "--tasks", "w001/t00", "--out", "again"]);
    assert_eq!(hash("again"), hash("fox-run"));
}

#[test]
fn pure_pursuit_in_cpp_ends_every_task_as_in_rust() {
    let bench = Bench::new();
    let library = bench.path("libpursuit_cpp.so");
    let mut compile = Command::new("c++");
    compile.args([
        "-std=c++17",
        "-O2",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fPIC",
        "-shared",
        "-fvisibility=hidden",
    ]);
    compile.arg("-I").arg(root().join("sdk/c")).arg("-o").arg(&library);
    let Ok(built) = compile.arg(root().join("examples/pursuit-cpp/pursuit.cpp")).output() else {
        vb_testing::skip("there is no C++ compiler");
        return;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    bench.ok(&["--plugin", text(&library), "--tasks", TASKS, "--out", "cpp"]);
    let rust = plugin("pursuit", PluginKind::Native);
    bench.ok(&["--plugin", text(&rust), "--tasks", TASKS, "--out", "rust"]);
    same_verdicts(&bench, "cpp", "rust");
    assert_eq!(bench.json("cpp/run.json")["plugin"]["kind"], "native");
}

/// The same outcome of every task, in about the same time.
fn same_verdicts(bench: &Bench, a: &str, b: &str) {
    let (a, b) = (bench.records(a), bench.records(b));
    assert_eq!(a.len(), b.len());
    for (task, one) in &a {
        let other = &b[task];
        assert_eq!(one["outcome"], other["outcome"], "{task}");
        let (t, u) = (one["time_s"].as_f64().expect("time"), other["time_s"].as_f64().expect("time"));
        // The last bits of sine and arctangent differ, and a slope may make more of them.
        assert!((t - u).abs() <= 0.02 * u, "{task}: {t} s and {u} s");
    }
}

#[test]
fn a_native_planners_process_is_told_in_the_run() {
    let bench = Bench::new();
    let pid = plugin("pid", PluginKind::Native);
    bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00", "--out", "r"]);
    let plugin = &bench.json("r/run.json")["plugin"];
    assert_eq!((&plugin["kind"], &plugin["eligible_for_ranking"]), (&"native".into(), &true.into()));
    assert!(plugin["sandbox"]["no_new_privs"].is_boolean(), "{plugin}");
}

#[test]
fn pure_pursuit_in_python_ends_every_task_as_in_rust() {
    if python().is_none() {
        return;
    }
    let bench = Bench::new();
    let told = drive(&bench, &example("pursuit.py"), "python", &[]);
    assert!(told.status.success(), "{}", told.stderr);
    assert!(told.stderr.contains("not eligible for ranking"), "{}", told.stderr);
    let rust = plugin("pursuit", PluginKind::Wasm);
    bench.ok(&["--plugin", text(&rust), "--tasks", TASKS, "--out", "rust"]);
    same_verdicts(&bench, "python", "rust");
    let plugin = &bench.json("python/run.json")["plugin"];
    assert_eq!((&plugin["kind"], &plugin["eligible_for_ranking"]), (&"command".into(), &false.into()));
    assert_eq!(plugin["name"], "pursuit-python");
    assert!(plugin["sandbox"].is_null());
}

#[test]
fn a_neural_network_in_python_arrives() {
    if python().is_none() {
        return;
    }
    let bench = Bench::new();
    let told = drive(&bench, &example("neural.py"), "neural", &["--param", "speed=3"]);
    assert!(told.status.success(), "{}", told.stderr);
    for (task, record) in bench.records("neural") {
        assert_eq!(record["outcome"], "success", "{task}: {record}");
    }
}

#[test]
fn an_exception_in_python_ends_its_task_with_its_text_and_the_next_goes_on() {
    if python().is_none() {
        return;
    }
    let bench = Bench::new();
    bench.write(
        "odd.py",
        "from vertibench_planner import Command, Planner, main\n\
         class Odd(Planner):\n\
         \x20   name, control_period = 'odd', 0.5\n\
         \x20   params = {'only': ('', 'task to fail')}\n\
         \x20   def init(self, task):\n\
         \x20       self.fails = task.id == task.params['only']\n\
         \x20   def step(self, obs):\n\
         \x20       print('printed')\n\
         \x20       self.log('logged')\n\
         \x20       return Command(brake=1.0 / (0.0 if self.fails else 1.0))\n\
         main(Odd)\n",
    );
    let script = bench.path("odd.py");
    let told = drive(&bench, &script, "r", &["--param", "only=w001/t01"]);
    assert!(told.status.success(), "{}", told.stderr);
    let records = bench.records("r");
    let failed = &records["w001/t01"];
    assert_eq!((&failed["outcome"], &failed["fault"]), (&"planner_error".into(), &"planner/error".into()));
    let reason = failed["reason"].as_str().expect("a reason");
    assert!(reason.contains("ZeroDivisionError: float division by zero (odd.py:10)"), "{reason}");
    let log = failed["log"].as_array().expect("a log");
    for line in ["info: stderr: printed", "info: logged"] {
        assert!(log.contains(&Value::from(line)), "{log:?}");
    }
    for task in ["w001/t00", "w001/t02"] {
        assert_eq!(records[task]["outcome"], "stuck", "{task}");
    }
    let planner = format!("{} {}", python().expect("a Python"), text(&script));
    let mut inspect = bench.command(&["inspect", "--plugin", &planner]);
    let inspected = vb_tests::Done::of(with_libraries(&mut inspect));
    assert!(inspected.stdout.contains("--param only="), "{} {}", inspected.stdout, inspected.stderr);
}

#[test]
fn a_command_that_is_no_planner_is_told_in_a_line() {
    let bench = Bench::new();
    let tests = [
        (
            "sh -c 'echo no numpy here >&2; exit 7'",
            "it exited before it sent its metadata (exit code 7): no numpy here",
        ),
        ("sh -c 'echo hello'", "text received instead of a message"),
    ];
    for (command, says) in tests {
        let done = bench.run(&["--plugin", command, "--tasks", "w001/t00", "--out", "r"]);
        assert_eq!(done.status.code(), Some(3), "{command}: {}", done.stderr);
        let error = done.stderr.lines().last().expect("a line");
        assert!(error.starts_with("error: ") && error.contains(says), "{}", done.stderr);
        assert!(!bench.path("r").exists());
    }
    let refused = bench.run(&["--plugin", "sh -c true", "--require-sandbox", "--out", "r"]);
    assert_eq!(refused.status.code(), Some(2), "{}", refused.stderr);
}

#[test]
fn the_python_modules_own_tests_pass() {
    let Some(python) = python() else { return };
    let tests = with_libraries(&mut Command::new(python)).args(["-c", "import pytest"]).output();
    if !tests.is_ok_and(|o| o.status.success()) {
        vb_testing::skip(format_args!("{python} lacks pytest"));
        return;
    }
    let folder = root().join("sdk/python");
    let mut command = Command::new(python);
    command.args(["-B", "-m", "pytest", "-q", "-p", "no:cacheprovider"]).current_dir(&folder);
    let done = with_libraries(&mut command).output().expect("Python starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
    assert!(fs::metadata(folder.join("examples/neural_weights.npz")).is_ok());
}
