//! Scoring again from traces, and the messages for programs.

use serde_json::Value;
use vb_tests::{Bench, pid};

const TASKS: &str = "w001/t00-t01,w003/t00,w006/t08";

fn run(bench: &Bench, out: &str, more: &[&str]) -> String {
    let pid = pid();
    let plugin = pid.to_str().expect("paths of tests are text");
    let args = ["--plugin", plugin, "--param", "speed=5", "--tasks", TASKS, "--out", out];
    bench.ok(&[&args[..], more].concat())
}

/// The messages on stdout: one JSON object a line.
fn messages(stdout: &str) -> Vec<Value> {
    let parse = |line: &str| serde_json::from_str::<Value>(line).unwrap_or_else(|e| panic!("{e}: {line}"));
    let messages: Vec<Value> = stdout.lines().map(parse).collect();
    assert!(messages.iter().all(|m| m["event"].is_string()), "{stdout}");
    messages
}

fn of<'a>(messages: &'a [Value], event: &str) -> Vec<&'a Value> {
    messages.iter().filter(|m| m["event"] == event).collect()
}

fn score(bench: &Bench, args: &[&str]) -> Vec<Value> {
    messages(&bench.ok(&[&["score"], args, &["--message-format", "json"]].concat()))
}

#[test]
fn the_messages_of_a_run_are_json_lines_that_agree_with_its_files() {
    let bench = Bench::new();
    let told = messages(&run(&bench, "r", &["--message-format", "json"]));
    let events: Vec<&str> = told.iter().filter_map(|m| m["event"].as_str()).collect();
    assert_eq!(events, ["started", "task", "task", "task", "task", "finished"]);
    assert_eq!((&told[0]["total"], &told[0]["resumed"]), (&4.into(), &0.into()));
    let records = bench.records("r");
    for (i, task) in of(&told, "task").into_iter().enumerate() {
        assert_eq!((&task["done"], &task["total"]), (&(i + 1).into(), &4.into()));
        assert_eq!(task["record"], records[task["record"]["task"].as_str().expect("a name")]);
    }
    let finished = &told[5];
    assert_eq!((&finished["out"], &finished["interrupted"]), (&"r".into(), &false.into()));
    assert_eq!(finished["summary"], bench.json("r/summary.json"));

    // A run that is complete already is resumed to the same end, and says so.
    let again = messages(&run(&bench, "r", &["--resume", "--message-format", "json"]));
    assert_eq!((&again[0]["event"], &again[0]["resumed"]), (&"started".into(), &4.into()));
    assert_eq!(again.len(), 2, "no task is run twice");
    assert_eq!(again[1], *finished);
}

#[test]
fn without_a_terminal_plain_lines_tell_the_course() {
    let bench = Bench::new();
    let pid = pid();
    let done = bench.run(&["--plugin", pid.to_str().expect("text"), "--tasks", "w001/t00"]);
    let (out, err) = (&done.stdout, &done.stderr);
    assert!(
        err.lines().any(|l| l.starts_with("[1/1] w001/t00 success ")) && err.contains("real time"),
        "{err}"
    );
    assert!(out.contains("success % (95 % CI)") && out.contains("rules: paper"), "{out}");
    assert!(!err.contains('\u{1b}') && !out.contains('\u{1b}'), "no control characters");
    // Where no directory is named, the first of the planner's name that is free is taken.
    assert!(bench.path("runs/pid-1/summary.json").is_file());
    bench.ok(&["--plugin", pid.to_str().expect("text"), "--tasks", "w001/t00"]);
    assert!(bench.path("runs/pid-2/summary.json").is_file());
}

#[test]
fn full_traces_score_to_the_same_bits_without_simulating() {
    let bench = Bench::new();
    run(&bench, "r", &["--trace", "full"]);
    let before = bench.files("r");
    let told = score(&bench, &["r"]);
    let summary = of(&told, "summary")[0];
    assert_eq!((&summary["exact"], &summary["resolution_s"]), (&true.into(), &0.01.into()));
    assert_eq!(summary["summary"], bench.json("r/summary.json"));
    let records = bench.records("r");
    for message in of(&told, "task") {
        let record = &message["record"];
        assert_eq!(*record, records[record["task"].as_str().expect("a name")]);
    }
    assert_eq!(of(&told, "task").len(), 4);
    assert!(before == bench.files("r"), "scoring changes no file of the run");
}

#[test]
fn other_rules_judge_the_same_traces_otherwise() {
    let bench = Bench::new();
    run(&bench, "r", &["--trace", "full"]);
    // The paper's rules but for the time limit.
    let rules = std::fs::read_to_string(vb_tests::root().join("tasks/rules/paper.yaml")).expect("paper.yaml");
    let short: Vec<String> = rules
        .lines()
        .map(|line| if line.starts_with("time_limit_s:") { "time_limit_s: 5.0".into() } else { line.into() })
        .collect();
    assert_ne!(short.join("\n"), rules.trim_end());
    bench.write("short.yaml", short.join("\n"));
    let told = score(&bench, &["r", "--rules", "short.yaml"]);
    let judged = of(&told, "task");
    assert_eq!(judged.len(), 4);
    for message in judged {
        let record = &message["record"];
        assert_eq!((&record["outcome"], &record["time_s"]), (&"timeout".into(), &5.0.into()), "{record}");
    }
    // What those rules make of a run of their own is the same, but for what was simulated beyond.
    run(&bench, "short", &["--trace", "full", "--rules", "short.yaml"]);
    let own = bench.records("short");
    for message in of(&told, "task") {
        let record = &message["record"];
        let own = &own[record["task"].as_str().expect("a name")];
        for field in ["outcome", "three_way", "reason", "time_s", "metrics"] {
            assert_eq!(record[field], own[field], "{field}");
        }
    }
}

/// `release` wants 8 m where `paper` wants 10 m: a trace that ended with the paper's success can't tell.
#[test]
fn rules_that_decide_later_than_the_trace_ends_leave_tasks_undecided() {
    let bench = Bench::new();
    run(&bench, "r", &["--trace", "full"]);
    let told = score(&bench, &["r", "--rules", "release"]);
    let summary = &of(&told, "summary")[0]["summary"];
    assert_eq!(summary["rules"], "release");
    let undecided: Vec<&str> =
        summary["undecided"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(undecided.contains(&"w001/t00") && undecided.contains(&"w001/t01"), "{undecided:?}");
    let table = bench.ok(&["score", "r", "--rules", "release"]);
    assert!(table.contains("rules: release") && table.contains("undecided"), "{table}");
}

#[test]
fn coarse_traces_say_their_resolution_and_come_close() {
    let bench = Bench::new();
    run(&bench, "r", &[]);
    let told = score(&bench, &["r"]);
    let summary = of(&told, "summary")[0];
    assert_eq!((&summary["exact"], &summary["resolution_s"]), (&false.into(), &0.1.into()));
    let done = bench.run(&["score", "r"]);
    assert!(
        done.stderr.contains("samples every 0.1 s") && done.stderr.contains("--trace full"),
        "{}",
        done.stderr
    );
    let records = bench.records("r");
    for message in of(&told, "task") {
        let record = &message["record"];
        let own = &records[record["task"].as_str().expect("a name")];
        assert_eq!((&record["outcome"], &record["time_s"]), (&own["outcome"], &own["time_s"]));
    }
    // Every task is measured by the samples of its trace, so none weighs more than in the run.
    let own = &bench.json("r/summary.json")["all"];
    for mean in ["roll_mean_deg", "pitch_mean_deg", "roll_task_mean_deg", "pitch_task_mean_deg"] {
        let of = |all: &Value| all[mean].as_f64().expect("a mean");
        let (thin, own) = (of(&summary["summary"]["all"]), of(own));
        assert!((thin - own).abs() < 0.02 * own, "{mean}: {thin}, the run has {own}");
    }
}

#[test]
fn without_traces_failures_can_be_classified_and_no_more() {
    let bench = Bench::new();
    run(&bench, "r", &["--trace", "none"]);
    let told = score(&bench, &["r"]);
    assert_eq!(of(&told, "summary")[0]["summary"], bench.json("r/summary.json"));
    let e = bench.run(&["score", "r", "--rules", "release"]).error(3);
    assert!(e.contains("r") && e.contains("--trace"), "{e}");
}
