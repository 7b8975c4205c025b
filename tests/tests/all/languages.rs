//! The same planner in other languages, and the projects that `vb-harness plugin new` makes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard};

use serde_json::Value;
use vb_tests::{Bench, Done, PluginKind, plugin, root};

/// Exit code of a mistake on the command line, docs/results.md.
const USAGE: i32 = 2;
/// Three tasks on easy ground, which pure pursuit solves, and three on rough ground.
const TASKS: &str = "w001/t00-t02,w002/t03,w006/t03,w009/t00";

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// Held by a test that drives Python: the first compiles the interpreter, and the others find it in the cache.
static PYTHON: Mutex<()> = Mutex::new(());

fn turn() -> MutexGuard<'static, ()> {
    // A test that failed has left nothing half done.
    vb_files::lock(&PYTHON)
}

/// Whether other languages must be there: in CI.
fn wanted() -> bool {
    std::env::var_os("VB_LANGUAGES").is_some_and(|v| v == "1")
}

/// The built example, or a word on why the test goes without it.
fn example(name: &str) -> Option<PathBuf> {
    let path = plugin("pursuit", PluginKind::Wasm).with_file_name(format!("{name}.wasm"));
    if path.is_file() {
        return Some(path);
    }
    assert!(!wanted(), "{} is missing: run `cargo xtask examples`", path.display());
    vb_testing::skip(format_args!("{} is missing; run `cargo xtask examples`", path.display()));
    None
}

/// The records of a run over [`TASKS`].
fn drive(bench: &Bench, plugin: &Path, out: &str) -> BTreeMap<String, Value> {
    bench.ok(&["--plugin", text(plugin), "--tasks", TASKS, "--out", out]);
    bench.records(out)
}

/// QuickJS and CPython take `sin`, `atan` and `atan2` from the C library that Rust's `libm` is a translation of; the
/// examples compute `hypot` as it does.
#[test]
fn python_and_javascript_drive_as_rust_does_bit_for_bit() {
    let _turn = turn();
    let bench = Bench::new();
    let rust = drive(&bench, &plugin("pursuit", PluginKind::Wasm), "rust");
    for name in ["pursuit-js", "pursuit-python"] {
        let Some(file) = example(name) else { continue };
        let other = drive(&bench, &file, name);
        assert_eq!(other.len(), rust.len());
        for (task, record) in &rust {
            for field in ["outcome", "reason", "state_hash", "metrics", "planner_steps"] {
                assert_eq!(other[task][field], record[field], "{name}: {task}: {field}");
            }
        }
    }
}

/// The last bits of `sin` and `hypot` in zig's C library differ from those of Rust's `libm`, so the vehicle ends some
/// nanometres elsewhere where the ground is easy. Where it is rough, every trajectory is its own.
#[test]
fn c_drives_as_rust_does_but_for_the_last_bits() {
    let Some(file) = example("pursuit-c") else { return };
    let bench = Bench::new();
    let rust = drive(&bench, &plugin("pursuit", PluginKind::Wasm), "rust");
    let c = drive(&bench, &file, "c");
    assert_eq!(c.len(), rust.len());
    for task in ["w001/t00", "w001/t01", "w001/t02"] {
        assert_eq!((&c[task]["outcome"], &rust[task]["outcome"]), (&"success".into(), &"success".into()));
        let [c, rust] = [&c, &rust].map(|run| run[task]["time_s"].as_f64().expect("a time"));
        assert!((c - rust).abs() < 0.05, "{task}: {c} s for {rust} s");
    }
    // And again: the same bits as before.
    assert_eq!(drive(&bench, &file, "again"), c);
}

#[test]
fn a_parameter_of_a_planner_in_another_language_is_checked_before_the_run() {
    for name in ["pursuit-c", "pursuit-js", "pursuit-python"] {
        let Some(file) = example(name) else { continue };
        let bench = Bench::new();
        let args = ["--plugin", text(&file), "--tasks", "w001/t00", "--param", "speed=fast", "--out", "r"];
        let told = bench.run(&args).error(USAGE);
        let expected = "--param speed: \"fast\" is not a number (target speed, m/s); its default is 4.0";
        assert!(told.contains(expected), "{name}: {told}");
        assert!(!bench.path("r").exists(), "{name}");
    }
}

#[test]
fn the_metadata_of_an_example_are_those_of_its_description() {
    for name in ["pursuit-c", "pursuit-js", "pursuit-python"] {
        let Some(file) = example(name) else { continue };
        let bench = Bench::new();
        let of = |file: &Path| {
            let told = bench.ok(&["inspect", "--plugin", text(file), "--message-format", "json"]);
            serde_json::from_str::<Value>(&told).expect("JSON")
        };
        let mut told = of(&file);
        assert_eq!(told["name"], name);
        told["name"] = "pursuit".into();
        // A project begins with the version of the example that it is made of; that in Rust has the workspace's.
        let rust = of(&plugin("pursuit", PluginKind::Wasm));
        told["version"] = rust["version"].clone();
        assert_eq!(told, rust, "{name}");
    }
}

/// Makes a project called `fox` and returns its folder.
fn project(bench: &Bench, lang: &str) -> PathBuf {
    let sdk = root().join("sdk");
    let mut args = vec!["plugin", "new", "fox", "--lang", lang];
    if lang == "rust" {
        args.extend(["--sdk", text(&sdk)]);
    }
    bench.ok(&args);
    bench.path("fox")
}

/// It is found by the harness, keeps what planners promise without a warning, and drives as the example that it starts
/// from.
fn assert_drives(bench: &Bench, built: &Path, example: &Path) {
    assert!(bench.ok(&["inspect", "--plugin", text(built)]).contains("fox 0.1.0"));
    let told = bench.ok(&["check", "--plugin", text(built), "--tasks", "w001/t00"]);
    assert!(told.contains("0 failed"), "{told}");
    // How long it takes to start is a matter of the machine, which may be busy.
    let mut warned = told.lines().filter(|l| l.starts_with("warn") && !l.starts_with("warn  start-up"));
    assert_eq!(
        warned.next(),
        None,
        "an author changes nothing yet, so nothing is there to be warned of: {told}"
    );
    let run = |plugin: &Path, out: &str| {
        bench.ok(&["--plugin", text(plugin), "--tasks", "w001/t00", "--out", out]);
        bench.records(out)["w001/t00"]["state_hash"].clone()
    };
    assert_eq!(run(built, "fox-run"), run(example, "example-run"));
}

/// As WASM it is built by the same compiler as the planners of the repository, which `cargo xtask test` made sure of; here
/// the native library shows that the project is whole.
#[test]
fn a_new_rust_project_builds_and_drives() {
    let bench = Bench::new();
    let dir = project(&bench, "rust");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // The versions that the repository is tested with, so that nothing new is fetched.
    std::fs::copy(root().join("Cargo.lock"), dir.join("Cargo.lock")).expect("the lock file is copied");
    let mut command = Command::new(cargo);
    // What the SDK depends on is built once.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-rust");
    command.args(["build", "--quiet"]).current_dir(&dir).env("CARGO_TARGET_DIR", &target);
    let _ = Done::of(&mut command).ok();
    let file = format!("{}fox{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = target.join("debug").join(file);
    assert_drives(&bench, &library, &plugin("pursuit", PluginKind::Native));
}

#[test]
fn new_projects_in_other_languages_build_and_drive() {
    let _turn = turn();
    for lang in ["c", "js", "python"] {
        let Some(compiled) = example(&format!("pursuit-{lang}")) else { continue };
        let Some(environment) = environment(lang) else { continue };
        let bench = Bench::new();
        let dir = project(&bench, lang);
        match lang {
            "python" => {
                plant_a_bug(&dir.join("guest.py"));
                plant_prints(&dir.join("guest.py"));
            }
            "js" => plant(&dir.join("planner.js"), JS_BUGS),
            _ => plant(&dir.join("planner.c"), C_BUGS),
        }
        let mut command = Command::new("./build.sh");
        command.current_dir(&dir).env("VB_HARNESS", vb_tests::release_harness()).envs(environment);
        let _ = Done::of(&mut command).ok();
        let built = dir.join("build/fox.wasm");
        assert_drives(&bench, &built, &compiled);
        match lang {
            "python" => assert_tells_bugs(&bench, &built),
            "js" => {
                for (speed, told) in
                    [("13", "step returned undefined;"), ("14", "step returned brake = undefined,")]
                {
                    let record = fails(&bench, &built, speed);
                    assert_eq!(record["fault"], "planner/error");
                    let reason = record["reason"].as_str().expect("a reason");
                    assert!(reason.contains(told), "{reason}");
                }
            }
            _ => {
                let record = fails(&bench, &built, "13");
                assert_eq!(record["fault"], "planner/trap");
                let reason = record["reason"].as_str().expect("a reason");
                assert!(reason.contains("abort <") && reason.contains("planner_step"), "{reason}");
                assert!(record["log"].to_string().contains("info: printed at 0"), "{record}");
            }
        }
    }
}

/// What is put before a line of a planner's source.
type Bugs = (&'static str, &'static str);
const JS_BUGS: Bugs = (
    "    // Progress never decreases",
    "    if (this.speed === 13) return;\n    if (this.speed === 14) return { steering: 0, throttle: 0 };\n",
);
const C_BUGS: Bugs = (
    "  double angle = turn(",
    "  if (planner->speed == 13.0) {\n    printf(\"printed at %d\\n\", (int)time(NULL));\n    abort();\n  }\n",
);

/// Bugs at speeds that nobody drives at.
fn plant(file: &Path, (at, bugs): Bugs) {
    let source = std::fs::read_to_string(file).expect("the planner can be read");
    assert!(source.contains(at));
    let source = source.replacen(at, &format!("{bugs}{at}"), 1);
    let source =
        source.replacen("#include <math.h>", "#include <math.h>\n#include <stdio.h>\n#include <time.h>", 1);
    std::fs::write(file, source).expect("the planner can be written");
}

/// The record of a task at a speed at which the planner fails.
fn fails(bench: &Bench, built: &Path, speed: &str) -> Value {
    let param = format!("speed={speed}");
    bench.ok(&["--plugin", text(built), "--tasks", "w001/t00", "--param", &param, "--out", speed]);
    bench.records(speed)["w001/t00"].clone()
}

/// What was planted by [`plant_a_bug`] and [`plant_prints`] is told.
fn assert_tells_bugs(bench: &Bench, built: &Path) {
    let failed = |speed: &str| {
        let speed = format!("speed={speed}");
        bench.ok(&["--plugin", text(built), "--tasks", "w001/t00", "--param", &speed, "--out", &speed]);
        let record = bench.records(&speed)["w001/t00"].clone();
        assert_eq!(record["fault"], "planner/panic");
        (record["reason"].as_str().expect("a reason").to_owned(), record["log"].to_string())
    };
    let (reason, log) = failed("13");
    assert!(reason.contains("panicked at guest.py:") && reason.contains("IndexError"), "{reason}");
    // Whoever looks for a bug prints and takes the time, which is the simulation's.
    assert!(log.contains("info: printed at 0.0 0.0") && log.contains("warn: to the error"), "{log}");
    let (reason, _) = failed("14");
    assert!(reason.contains("panicked at guest.py:") && reason.contains("step returned None"), "{reason}");
}

/// At one speed the planner takes what isn't there, and at another it returns nothing.
fn plant_a_bug(file: &Path) {
    let source = std::fs::read_to_string(file).expect("the planner can be read");
    let at = "        self.follower.update";
    assert!(source.contains(at));
    let bugs = "        if self.speed == 13.0:\n            [][0]\n        if self.speed == 14.0:\n            return\n";
    std::fs::write(file, source.replacen(at, &format!("{bugs}{at}"), 1)).expect("the planner can be written");
}

/// Its first step prints the time, and something for standard error.
fn plant_prints(file: &Path) {
    let source = std::fs::read_to_string(file).expect("the planner can be read");
    let (top, at) = ("import wit_world.exports.guest\n", "        seen = (");
    assert!(source.contains(top) && source.contains(at));
    let prints = "        if o.time == 0.0:\n            print('printed at', time.time(), time.monotonic())\n            \
                  print('to the error', file=sys.stderr)\n";
    let source = source.replacen(top, &format!("import sys\nimport time\n\n{top}"), 1);
    std::fs::write(file, source.replacen(at, &format!("{prints}{at}"), 1))
        .expect("the planner can be written");
}

/// What lets `build.sh` find its compiler where `cargo xtask examples` has put it.
fn environment(lang: &str) -> Option<BTreeMap<&'static str, std::ffi::OsString>> {
    let cache = std::env::var_os("XDG_CACHE_HOME").filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = cache.or_else(|| std::env::home_dir().map(|home| home.join(".cache")))?;
    let prefix = match lang {
        "c" => "ziglang-",
        "js" => "componentize-qjs-",
        _ => "componentize-py-",
    };
    let folders = std::fs::read_dir(cache.join("verti-bench/languages")).into_iter().flatten().flatten();
    let found = folders
        .map(|e| e.path())
        .filter(|p| p.file_name().is_some_and(|n| text(Path::new(n)).starts_with(prefix)));
    let Some(folder) = found.max() else {
        assert!(!wanted(), "there is no {prefix}* in {}: run `cargo xtask examples`", cache.display());
        vb_testing::skip(format_args!("there is no {prefix}* in the cache; run `cargo xtask examples`"));
        return None;
    };
    let programs = folder.join(if lang == "js" { "node_modules/.bin" } else { "bin" });
    let path = std::env::var_os("PATH").unwrap_or_default();
    let all = [programs].into_iter().chain(std::env::split_paths(&path));
    let path = std::env::join_paths(all).expect("a path that can be joined");
    Some(BTreeMap::from([("PATH", path), ("PYTHONPATH", folder.into_os_string())]))
}

#[test]
fn a_new_project_overwrites_nothing_and_wants_a_sound_name() {
    let bench = Bench::new();
    bench.write("fox/notes.txt", "mine");
    let e = bench.run(&["plugin", "new", "fox", "--lang", "c"]).error(4);
    assert!(e.contains("are not overwritten"), "{e}");
    assert_eq!(bench.files("fox").len(), 1);
    let e = bench.run(&["plugin", "new", "../fox", "--lang", "c"]).error(2);
    assert!(e.contains("\"../fox\" is not a valid planner name"), "{e}");
    let e = bench.run(&["plugin", "new", "hare", "--lang", "c", "--sdk", "/"]).error(2);
    assert!(e.contains("--lang rust"), "{e}");
    let e = bench.run(&["plugin", "new", "hare", "--lang", "rust", "--sdk", "/"]).error(3);
    assert!(e.contains("no Cargo.toml of the SDK"), "{e}");
    assert!(!bench.path("hare").exists());
}
