//! Files and streams that are not what they should be: pipes, devices, full disks, limits of the system, links, records of
//! others. Each is one line of error with its exit code, at once.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

use vb_tests::{Bench, Done, Mini, copy_dir, pid};

/// Exit codes of docs/results.md.
const BAD_INPUT: i32 = 3;
const OUTPUT: i32 = 4;

#[test]
fn pipes_and_devices_are_refused_at_once_wherever_a_file_can_be_named() {
    let bench = Bench::new();
    assert!(Command::new("mkfifo").arg(bench.path("fifo")).status().expect("mkfifo runs").success());
    symlink("/dev/zero", bench.path("zero")).expect("a link");
    fs::create_dir_all(bench.path("suite")).expect("a folder");
    symlink("/dev/zero", bench.path("suite/suite.yaml")).expect("a link");
    fs::create_dir_all(bench.path("run")).expect("a folder");
    symlink(bench.path("fifo"), bench.path("run/run.json")).expect("a link");
    let pid = pid();
    let pid = pid.to_str().expect("text");
    for file in ["fifo", "zero"] {
        for option in ["--vehicle", "--soils", "--rules", "--limits"] {
            let told = bench.run(&["--plugin", pid, option, &format!("./{file}")]).error(BAD_INPUT);
            assert!(told.contains(file) && told.contains("no regular file"), "{option} {file}: {told}");
        }
        for args in [
            ["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "s", "--params"].as_slice(),
            &["vehicle", "validate"],
            &["terrain", "measure"],
        ] {
            let told = bench.run(&[args, &[&format!("./{file}")[..]]].concat()).error(BAD_INPUT);
            assert!(told.contains(file), "{args:?} {file}: {told}");
        }
    }
    let told = bench.run(&["--plugin", pid, "--suite", "suite"]).error(BAD_INPUT);
    assert!(told.contains("suite.yaml") && told.contains("no regular file"), "{told}");
    for command in [&["score", "run"][..], &["report", "run", "--out", "page"]] {
        let told = bench.run(command).error(BAD_INPUT);
        assert!(told.contains("run.json") && told.contains("no regular file"), "{command:?}: {told}");
    }
}

#[test]
fn results_that_do_not_reach_stdout_are_an_error_and_a_reader_that_went_away_is_none() {
    let bench = Bench::new();
    for args in [["list", "suites"].as_slice(), &["tasks", "list", "--json"], &["--help"], &["-V"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let done = Done::of(bench.command(args).stdout(full));
        let told = done.error(OUTPUT);
        assert!(told.contains("standard output") && told.contains("No space left"), "{args:?}: {told}");
    }
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let status = bench.command(&["tasks", "list"]).stdout(writer).status().expect("it runs");
    assert_eq!(status.code(), Some(0));
}

#[test]
fn a_limit_on_the_size_of_files_is_an_error_like_a_full_disk() {
    let bench = Bench::new();
    // Units of 512 bytes, or of 1024: enough for a page of text, not for the picture of a world.
    let script = "ulimit -f 8; exec \"$0\" suite generate --seed 1 --worlds 1 --out s";
    let mut command = bench.command_of("sh".as_ref(), &["-c", script]);
    let told = Done::of(command.arg(vb_tests::release_harness())).error(OUTPUT);
    assert!(told.contains("File too large") && told.contains("elevation.png"), "{told}");
}

#[test]
fn a_record_of_a_task_that_was_not_chosen_is_not_counted_by_resume() {
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("text");
    let run = |task: &str, out: &str, more: &[&str]| {
        bench.run(&[&["--plugin", pid, "--suite", "smoke", "--tasks", task, "--out", out], more].concat())
    };
    let _ = run("w001/t00", "a", &[]).ok();
    let _ = run("w001/t01", "b", &[]).ok();
    copy_dir(&bench.path("a"), &bench.path("c"));
    let both = [fs::read(bench.path("a/tasks.jsonl")), fs::read(bench.path("b/tasks.jsonl"))];
    let both = both.map(|b| b.expect("records")).concat();
    bench.write("c/tasks.jsonl", both);
    fs::remove_file(bench.path("c/checksums.txt")).expect("checksums");
    let told = run("w001/t00", "c", &["--resume"]).error(BAD_INPUT);
    assert!(told.contains("w001/t01") && told.contains("not a task of the run"), "{told}");
    let _ = run("w001/t00", "a", &["--resume"]).ok();
}

#[test]
fn a_part_of_a_suite_and_given_parameters_are_named_in_terminal_page_and_submission() {
    let bench = Bench::new();
    let pid = pid();
    let pid = pid.to_str().expect("text");
    let args =
        ["--plugin", pid, "--suite", "smoke", "--tasks", "w001/t00-t01", "--param", "speed=5", "--out", "r"];
    let told = bench.ok(&args);
    assert!(told.contains("(speed=5) on smoke, 2 of 100 tasks: w001/t00-t01; rules: paper"), "{told}");
    let summary = bench.json("r/summary.json");
    assert_eq!((&summary["suite_tasks"], &summary["selector"]), (&100.into(), &"w001/t00-t01".into()));
    bench.ok(&["report", "r", "--out", "page"]);
    let page = fs::read_to_string(bench.path("page/index.html")).expect("a page");
    assert!(page.contains("smoke, 2 of 100 tasks: w001/t00-t01") && page.contains("(speed=5)"), "{page}");
    bench.ok(&["submit", "--plugin", pid, "--run", "r", "--out", "s"]);
    let manifest = bench.json("s/submission.json");
    let reasons = manifest["open_because"].to_string();
    assert!(reasons.contains("2 of 100 tasks") && reasons.contains("speed=5"), "{reasons}");
    // Where it is from: run.json and -V say the same.
    let version = bench.ok(&["-V"]);
    let commit = manifest["run"]["harness_commit"].as_str().expect("text");
    assert!(version.contains(&format!("(commit {commit})")), "{version}");
    assert!(commit == "unknown" || commit.split(',').next().is_some_and(|c| c.len() == 40), "{commit}");
}

#[test]
fn verify_looks_names_up_among_its_own_and_writes_through_no_link() {
    let mini = Mini::new();
    let pid = pid();
    let pid = pid.to_str().expect("text");
    mini.ok(&["--plugin", pid, "--suite", "mini", "--tasks", "w001/t00", "--out", "run"]);
    mini.ok(&["submit", "--plugin", pid, "--run", "run", "--out", "s"]);
    // What a stranger left in the working folder under these names.
    mini.bench.write("mini/suite.yaml", "not the suite");
    mini.bench.write("hmmwv", "not the vehicle");
    mini.bench.write("default", "not the soils");
    mini.bench.write("precious", "mine");
    fs::hard_link(mini.path("precious"), mini.path("s/verification.json")).expect("a link");
    mini.ok(&["verify", "s", "--plugin", pid]);
    assert_eq!(fs::read(mini.path("precious")).expect("it is there"), b"mine");
    assert_eq!(mini.bench.json("s/verification.json")["verified"], true);
    symlink(mini.path("precious"), mini.path("v.json")).expect("a link");
    let told = mini.run(&["verify", "s", "--plugin", pid, "--out", "v.json"]).error(OUTPUT);
    assert!(told.contains("v.json") && told.contains("in the way"), "{told}");
}
