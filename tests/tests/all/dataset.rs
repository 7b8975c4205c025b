//! Datasets, as their users make, check, cut and join them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use vb_tests::{Bench, Browser, Done, PluginKind, pid, plugin, root};

const USAGE: i32 = 2;
const BAD_INPUT: i32 = 3;
const OUTPUT: i32 = 4;
const NOT_VERIFIED: i32 = 9;

/// Exploration of few worlds, with crops that are so large that a data file has two episodes.
fn explore<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let args = ["dataset", "explore", "--worlds", "3", "--episodes", "8", "--seed", "5", "--crops", "64"];
    [&args[..], &["--out", out], more].concat()
}

fn sums(bench: &Bench, dataset: &str) -> String {
    fs::read_to_string(bench.path(dataset).join("SHA256SUMS")).expect("a finished dataset")
}

/// What is said of the episodes, without their statistics.
fn episodes(bench: &Bench, dataset: &str) -> Vec<(String, String, i64)> {
    let mut all = Vec::new();
    for file in 0.. {
        let name = format!("{dataset}/meta/episodes/chunk-000/file-{file:03}.parquet");
        if !bench.path(&name).is_file() {
            break;
        }
        all.extend(bench.columns(&name, &["outcome", "world", "length"]).into_iter().map(|row| {
            let text = |k: usize| row[k].as_str().expect("text").to_owned();
            (text(0), text(1), row[2].as_i64().expect("a number"))
        }));
    }
    all
}

#[test]
fn exploration_gives_the_same_bytes_whatever_the_jobs_and_after_kills() {
    let bench = Bench::new();
    bench.ok(&explore("whole", &["--jobs", "2"]));
    bench.ok(&explore("alone", &["--jobs", "1"]));
    assert_eq!(sums(&bench, "whole"), sums(&bench, "alone"));
    for kill in 0..3 {
        let more: &[&str] = if kill == 0 { &["--jobs", "1"] } else { &["--jobs", "1", "--resume"] };
        let mut making = bench.watch(&explore("broken", more));
        // Each dataset file has two episodes, so that a few are on disk by now, and one is begun.
        while making.until("progress")["episodes"].as_u64() < Some(2 * kill + 3) {}
        making.kill();
        assert!(!bench.path("broken/SHA256SUMS").exists(), "the kill came too late to test anything");
    }
    bench.ok(&explore("broken", &["--resume"]));
    assert_eq!(sums(&bench, "whole"), sums(&bench, "broken"));
    bench.ok(&["dataset", "validate", "broken"]);
    // Another seed drives otherwise.
    let other: Vec<&str> =
        explore("other", &[]).into_iter().map(|a| if a == "5" { "6" } else { a }).collect();
    bench.ok(&other);
    assert_ne!(sums(&bench, "whole"), sums(&bench, "other"));
    // Other settings don't go on with what was begun.
    let e = bench.run(&explore("whole", &["--resume", "--hz", "20"])).error(OUTPUT);
    assert!(e.contains("whole") && e.contains("hz is 20, not 10"), "{e}");
    let e = bench.run(&explore("whole", &[])).error(OUTPUT);
    assert!(e.contains("whole is not empty"), "{e}");
}

#[test]
fn what_was_changed_or_cut_off_is_found() {
    let bench = Bench::new();
    bench.ok(&explore("d", &[]));
    bench.ok(&["dataset", "validate", "d"]);
    let data = bench.path("d/data/chunk-000/file-000.parquet");
    let whole = fs::read(&data).expect("a data file");
    let findings = |says: &str| {
        let done = bench.run(&["dataset", "validate", "d"]);
        assert!(done.stdout.contains(says), "{says} is not in {}", done.stdout);
        let e = done.error(NOT_VERIFIED);
        assert!(e.contains(" finding"), "{e}");
    };
    fs::write(&data, &whole[..whole.len() / 2]).expect("written");
    findings("file-000.parquet: its SHA-256 differs");
    // Nothing is made of it that would look as it should, and it doesn't get new hashes.
    bench.ok(&explore("other", &["--world-seed", "7200"]));
    let before = bench.files("d");
    let used: [&[&str]; 4] = [
        &["dataset", "split", "d", "--parts", "all=1", "--out", "s"],
        &["dataset", "failures", "d", "--out", "s"],
        &["dataset", "merge", "other", "d", "--out", "s"],
        &explore("d", &["--resume"]),
    ];
    for args in used {
        let e = bench.run(args).error(BAD_INPUT);
        assert!(e.contains("file-000.parquet: its SHA-256 differs"), "{e}");
        assert!(e.contains("dataset validate"), "{e}");
        assert!(!bench.path("s").exists());
    }
    fs::remove_file(bench.path("d/.lock")).expect("what resuming leaves");
    assert_eq!(bench.files("d"), before);
    fs::write(&data, &whole).expect("written");
    bench.ok(&["dataset", "validate", "d"]);
    bench.write("d/data/extra.parquet", "x");
    findings("data/extra.parquet: it does not belong to the dataset");
    fs::remove_file(bench.path("d/data/extra.parquet")).expect("removed");
    let header = fs::read_to_string(bench.path("d/dataset.json")).expect("a header");
    bench.write("d/dataset.json", header.replace("\"schema\": 1", "\"schema\": 2"));
    let e = bench.run(&["dataset", "validate", "d"]).error(BAD_INPUT);
    assert!(e.contains("dataset version 2 is not supported; this build reads version 1"), "{e}");
    fs::remove_file(bench.path("d/SHA256SUMS")).expect("removed");
    bench.write("d/dataset.json", header);
    let e = bench.run(&["dataset", "validate", "d"]).error(BAD_INPUT);
    assert!(e.contains("not finished") && e.contains("--resume"), "{e}");
    let e = bench.run(&["dataset", "validate", "nowhere"]).error(BAD_INPUT);
    assert!(e.contains("nowhere: not a dataset"), "{e}");
}

#[test]
fn suites_and_training_worlds_are_kept_apart_in_both_directions() {
    let bench = Bench::new();
    let generate = |seed: &str, more: &[&str]| {
        let args = ["suite", "generate", "--worlds", "1", "--seed", seed, "--out", "g"];
        bench.run(&[&args, more].concat())
    };
    let e = generate("7500", &[]).error(USAGE);
    assert!(e.contains("7000 to 7999") && e.contains("--training"), "{e}");
    let e = generate("12", &["--training"]).error(USAGE);
    assert!(e.contains("--seed 12") && e.contains("7000 to 7999"), "{e}");
    // By their content, whatever they are called.
    vb_tests::copy_dir(&root().join("tasks/smoke"), &bench.path("mine"));
    let e = bench
        .run(&["dataset", "explore", "--suite", "mine", "--episodes", "1", "--out", "d"])
        .error(BAD_INPUT);
    assert!(e.contains("must not contain worlds of a suite") && e.contains("smoke/w001"), "{e}");
    assert!(!bench.path("d").exists());
    // A suite of one's own, such as a hidden one, is told.
    let _ = generate("7500", &["--training"]).ok();
    let from_g = ["dataset", "explore", "--suite", "g", "--episodes", "2"];
    bench.ok(&[&from_g[..], &["--out", "d"]].concat());
    let e = bench.run(&[&from_g[..], &["--out", "e", "--apart-from", "g"]].concat()).error(BAD_INPUT);
    assert!(e.contains("must not contain worlds of a suite"), "{e}");
    let done = bench.run(&["dataset", "validate", "d", "--apart-from", "g"]);
    assert!(done.stdout.contains("must not contain worlds of a suite"), "{}", done.stdout);
    let _ = done.error(NOT_VERIFIED);
}

#[test]
fn planners_drive_and_only_their_successes_are_kept_if_that_is_wanted() {
    let bench = Bench::new();
    let (pid, pursuit) = (pid(), plugin("pursuit", PluginKind::Native));
    let path = |p: &Path| p.to_str().expect("paths of tests are text").to_owned();
    let (pid, pursuit) = (path(&pid), path(&pursuit));
    let drive = |out: &str, more: &[&str]| {
        let args = ["dataset", "drive", "--plugin", &pid, "--plugin", &pursuit, "--worlds", "3"];
        bench.ok(&[&args[..], &["--tasks", "w*/t00-t01", "--out", out], more].concat())
    };
    drive("all", &[]);
    drive("good", &["--keep", "success"]);
    drive("bad", &["--keep", "failure"]);
    let of = |name: &str| episodes(&bench, name);
    let good: Vec<_> = of("all").into_iter().filter(|e| e.0 == "success").collect();
    let bad: Vec<_> = of("all").into_iter().filter(|e| e.0 != "success").collect();
    assert_eq!(of("all").len(), 12);
    assert!(!good.is_empty() && !bad.is_empty(), "{good:?} {bad:?}");
    assert_eq!((of("good"), of("bad")), (good, bad));
    bench.ok(&["dataset", "failures", "all", "--out", "failures"]);
    bench.ok(&["dataset", "validate", "failures"]);
    let clips = of("failures");
    assert!(clips.iter().all(|(outcome, _, length)| outcome != "success" && *length <= 100), "{clips:?}");
    let e = bench.run(&["dataset", "failures", "good", "--out", "none"]).error(BAD_INPUT);
    assert!(e.contains("it contains no failed episode"), "{e}");
    let two =
        ["dataset", "drive", "--plugin", &pid, "--plugin", &pursuit, "--param", "speed=2", "--out", "x"];
    assert!(bench.run(&two).error(USAGE).contains("--param"));
    let twice = ["dataset", "drive", "--plugin", &pid, "--plugin", &pid, "--worlds", "3", "--out", "x"];
    assert!(bench.run(&twice).error(USAGE).contains("this planner is given twice"));
    assert!(!bench.path("x").exists());
}

#[test]
fn failures_of_a_run_are_repeated_exactly_and_marked_where_nothing_may_be_learnt_from_them() {
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("paths of tests are text");
    bench.ok(&["--plugin", pid, "--suite", "smoke", "--tasks", "w003,w009/t00-t03", "--out", "run"]);
    let e = bench.run(&["dataset", "failures", "run", "--out", "f"]).error(USAGE);
    assert!(e.contains("smoke") && e.contains("--of-a-suite"), "{e}");
    // A suite of the harness that can't be read may have the worlds.
    bench.write("tasks/broken/suite.yaml", "schema: 1\n");
    let smoke = root().join("tasks/smoke");
    let smoke = smoke.to_str().expect("paths of tests are text");
    for more in [&[][..], &["--of-a-suite"]] {
        let args = ["dataset", "failures", "run", "--suite", smoke, "--out", "unread"];
        let mut command = bench.command(&[&args[..], more].concat());
        let e = Done::of(command.env("VB_TASKS", bench.path("tasks"))).error(BAD_INPUT);
        assert!(e.contains("broken") && !e.contains("--of-a-suite"), "{e}");
    }
    bench.ok(&["dataset", "failures", "run", "--of-a-suite", "--out", "f"]);
    let failed = bench
        .records("run")
        .values()
        .filter(|r| r["outcome"] == "stuck" || r["outcome"] == "rollover")
        .count();
    assert!(failed > 0);
    assert_eq!(episodes(&bench, "f").len(), failed);
    assert!(
        fs::read_to_string(bench.path("f/README.md"))
            .expect("a card")
            .contains("must not be used for training")
    );
    bench.ok(&["dataset", "validate", "f"]);
    // They can't slip into training data.
    bench.ok(&explore("d", &[]));
    let e = bench.run(&["dataset", "merge", "d", "f", "--out", "m"]).error(BAD_INPUT);
    assert!(e.contains("are incompatible"), "{e}");
}

#[test]
fn datasets_are_split_by_world_and_joined() {
    let bench = Bench::new();
    bench.ok(&explore("a", &[]));
    let other: Vec<&str> = explore("b", &[]).into_iter().map(|a| if a == "5" { "6" } else { a }).collect();
    bench.ok(&[&other[..], &["--world-seed", "7200"]].concat());
    bench.ok(&["dataset", "merge", "a", "b", "--out", "ab"]);
    bench.ok(&["dataset", "validate", "ab"]);
    let all = episodes(&bench, "ab");
    assert_eq!(all.len(), 16);
    // Worlds of the same name that are others become others.
    let worlds = |list: &[(String, String, i64)]| -> std::collections::BTreeSet<String> {
        list.iter().map(|e| e.1.clone()).collect()
    };
    assert_eq!(worlds(&all).len(), 6);
    // Eight episodes are dealt to three worlds, one after the other.
    let names: Vec<String> = episodes(&bench, "a").into_iter().map(|e| e.1).collect();
    assert_eq!(names, ["w001", "w002", "w003", "w001", "w002", "w003", "w001", "w002"]);
    bench.ok(&["dataset", "split", "ab", "--parts", "train=0.5,rest=0.5", "--out", "parts", "--seed", "3"]);
    let (train, rest) = (episodes(&bench, "parts/train"), episodes(&bench, "parts/rest"));
    assert_eq!(train.len() + rest.len(), 16);
    assert!(worlds(&train).is_disjoint(&worlds(&rest)));
    bench.ok(&["dataset", "validate", "parts/train"]);
    for (parts, says) in [
        ("a b=1", "\"a b\" is not a valid name"),
        ("../p=1", "\"../p\" is not a valid name"),
        ("a=0.5,a=0.5", "a and a have the same folder"),
        ("a=0.8,b=0.1", "the fractions sum to 0.900, not 1"),
    ] {
        let e = bench.run(&["dataset", "split", "ab", "--parts", parts, "--out", "p"]).error(USAGE);
        assert!(e.contains(says), "{e}");
    }
    // Worlds of one dataset in two, and the dataset itself, count once.
    for twice in [["a", "./a"], ["ab", "b"]] {
        let e = bench.run(&["dataset", "merge", twice[0], twice[1], "--out", "p"]).error(BAD_INPUT);
        assert!(e.contains("would be duplicates"), "{e}");
    }
    assert!(!bench.path("p").exists());
}

#[test]
fn two_at_once_do_not_spoil_what_they_make() {
    let bench = Bench::new();
    bench.ok(&explore("a", &[]));
    // Long enough not to end before its neighbours have tried; its first report of progress is at a twentieth.
    let long = ["dataset", "explore", "--worlds", "3", "--episodes", "200", "--jobs", "1", "--out", "d"];
    let mut first = bench.watch(&long);
    while !bench.path("d/dataset.json").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    for args in [&long[..], &[&long[..], &["--resume"]].concat(), &["dataset", "merge", "a", "--out", "d"]] {
        let e = bench.run(args).error(OUTPUT);
        assert!(e.contains("d is in use by another process"), "{e}");
    }
    first.until("progress");
    first.kill();
    // The lock goes with its process.
    let e = bench.run(&["dataset", "merge", "a", "--out", "d"]).error(OUTPUT);
    assert!(e.contains("d is not empty"), "{e}");

    let generate = ["suite", "generate", "--seed", "1", "--worlds", "20", "--out", "g"];
    let mut first = bench.command(&generate).stderr(Stdio::null()).spawn().expect("it starts");
    while !bench.path("g/.lock").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let e = bench.run(&generate).error(OUTPUT);
    assert!(e.contains("g is in use by another process"), "{e}");
    // What a kill leaves is no suite, and in nobody's way.
    first.kill().expect("it goes on");
    first.wait().expect("it ends");
    assert!(!bench.path("g/suite.yaml").exists());
    bench.ok(&["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "g"]);
    let names: Vec<_> =
        fs::read_dir(bench.path("g")).expect("a folder").map(|e| e.expect("a file").file_name()).collect();
    assert!(names.iter().all(|n| !n.to_string_lossy().starts_with('.')), "{names:?}");
    bench.ok(&["suite", "validate", "g"]);
}

/// Python with these packages and that of this repository: what `VB_PYTHON` names, or that of the path.
fn python(packages: &str) -> Option<Command> {
    let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut folders = vec![root().join("harness/python")];
    folders.extend(std::env::var_os("VB_PYTHON_LIBS").map(PathBuf::from));
    let path = std::env::join_paths(folders).expect("folders without colons");
    let python = || {
        let mut python = Command::new(&program);
        python.env("PYTHONPATH", &path).arg("-B");
        python
    };
    let import = format!("import {packages}");
    if python().args(["-c", &import]).output().is_ok_and(|o| o.status.success()) {
        return Some(python());
    }
    vb_testing::skip(format_args!(
        "{program} lacks one of {packages} (pip install them, or set VB_PYTHON or VB_PYTHON_LIBS)"
    ));
    None
}

#[test]
fn the_example_learns_from_a_dataset_what_the_bicycle_does_not_know() {
    let Some(mut python) = python("numpy, pyarrow") else { return };
    let bench = Bench::new();
    bench.ok(&["dataset", "explore", "--worlds", "15", "--episodes", "120", "--seed", "1", "--out", "d"]);
    let script = root().join("examples/dataset/fit_bicycle.py");
    let told = Done::of(python.arg(script).arg(bench.path("d"))).ok();
    let words: Vec<&str> = told.split_whitespace().collect();
    let metres = words.windows(2).filter(|w| w[1].trim_end_matches(',') == "m");
    let errors: Vec<f64> = metres.map(|w| w[0].parse().expect("a number")).collect();
    // In worlds that it never saw, the residual takes away an eighth of the error at least.
    assert!(errors.len() == 2 && errors[1] < 0.875 * errors[0], "{told}");
}

#[test]
fn the_docs_quote_the_example_as_it_is() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("a text");
    let (docs, example) = (read("docs/datasets.md"), read("examples/dataset/fit_bicycle.py"));
    let (_, code) = example.split_once("\n").expect("a line that says what it is");
    assert!(docs.contains(&format!("```python\n{code}```\n")), "examples/dataset/fit_bicycle.py was changed");
}

#[test]
fn a_dataset_is_looked_at_and_its_examples_lead_to_replays() {
    let bench = Bench::new();
    bench.ok(&["dataset", "explore", "--worlds", "3", "--episodes", "8", "--seed", "5", "--out", "d"]);
    bench.ok(&["dataset", "show", "d", "--out", "page", "--clips", "3"]);
    bench.ok(&["dataset", "mcap", "d", "--out", "mcap", "--episodes", "0,2-3"]);
    let files = bench.files("mcap");
    assert_eq!(files.len(), 3);
    // The magic bytes of MCAP at both ends of each file.
    assert!(files.values().all(|f| f.starts_with(b"\x89MCAP0\r\n") && f.ends_with(b"\x89MCAP0\r\n")));
    let e = bench.run(&["dataset", "mcap", "d", "--out", "x", "--episodes", "8"]).error(USAGE);
    assert!(e.contains("there is no episode 8 (the dataset has 8, from 0)"), "{e}");
    let e = bench.run(&["dataset", "show", "d", "--vehicle", "gator"]).error(BAD_INPUT);
    assert!(e.contains("the available vehicle gator differs from that of the dataset"), "{e}");
    // A vehicle file that can't be read is no other vehicle.
    bench.write("tasks/vehicles/hmmwv.yaml", "schema: 1\n");
    let mut command = bench.command(&["dataset", "mcap", "d", "--out", "x"]);
    let e = Done::of(command.env("VB_TASKS", bench.path("tasks"))).error(BAD_INPUT);
    assert!(e.contains("hmmwv.yaml") && !e.contains("the available vehicle"), "{e}");
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    browser.open(&bench.path("page/index.html"));
    // Every table counts each episode once.
    let sums = browser.eval(
        "[...document.querySelectorAll('#outcomes table')].slice(0, 3).map(t => \
         [...t.querySelectorAll('tbody td:last-child')].reduce((s, c) => s + Number(c.textContent), 0))",
    );
    assert_eq!(sums, serde_json::json!([8, 8, 8]));
    assert_eq!(browser.eval("document.querySelectorAll('#distributions svg').length"), 8);
    assert!(browser.screenshot().content() > 0.03, "a page without content");
    let links =
        browser.eval("[...document.querySelectorAll('#episodes a')].map(a => a.getAttribute('href'))");
    let links = links.as_array().expect("a list");
    assert_eq!(links.len(), 3);
    assert_eq!(browser.errors(), [] as [String; 0]);
    browser.open(&bench.path("page").join(links[0].as_str().expect("an address")));
    assert!(browser.screenshot().content() > 0.1, "a replay without content");
    assert_eq!(browser.errors(), [] as [String; 0]);
}

#[test]
fn what_can_not_be_explored_is_refused_in_one_line() {
    let bench = Bench::new();
    let refused = |more: &[&str], code: i32, says: &[&str]| {
        let args = [&["dataset", "explore", "--worlds", "1", "--episodes", "1", "--out", "d"], more].concat();
        let e = bench.run(&args).error(code);
        assert!(says.iter().all(|s| e.contains(s)), "{says:?}: {e}");
    };
    refused(&["--vehicle", "tricycle"], BAD_INPUT, &["there is no vehicle tricycle", "hmmwv"]);
    refused(&["--exploration", "wander"], BAD_INPUT, &["wander", "default, paper"]);
    refused(&["--perception", "blind"], BAD_INPUT, &["blind", "oracle"]);
    refused(&["--world-seed", "12"], USAGE, &["--world-seed 12", "7000 to 7999"]);
    refused(&["--hz", "0"], USAGE, &["0"]);
    // A planner that can't begin ends it at once; one that dies on the way leaves what it drove.
    let faulty = plugin("faulty", PluginKind::Wasm);
    let faulty = faulty.to_str().expect("paths of tests are text");
    let args = ["dataset", "drive", "--plugin", faulty, "--worlds", "1", "--tasks", "w001/t00"];
    let e = bench.run(&[&args[..], &["--out", "f", "--param", "fault=init-error"]].concat()).error(BAD_INPUT);
    assert!(e.contains("faulty") && e.contains("init"), "{e}");
    bench.ok(&[&args[..], &["--out", "g", "--param", "fault=panic", "--param", "at=7"]].concat());
    assert_eq!(episodes(&bench, "g"), [("planner_error".to_owned(), "w001".to_owned(), 7)]);
}
