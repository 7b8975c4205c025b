//! Commands that need no planner. Whole runs, and everything that can be wrong with what they are given, are tested in
//! `tests/` with the built binary and real planners.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use crate::common::{harness, succeed};

#[test]
fn an_error_of_the_command_line_is_one_line() {
    let dir = tempfile::tempdir().unwrap();
    for (args, line) in [
        (
            &["run"][..],
            "error: give one planner, as an argument, e.g. pid.wasm, or with --plugin, e.g. --plugin pid.wasm (see --help)\n",
        ),
        (&["--plugin", "x", "--xyzzy"], "error: unexpected argument '--xyzzy' found (see --help)\n"),
    ] {
        let output = harness(&dir, args);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), line);
    }
}

#[test]
fn the_built_in_suites_are_listed_shown_and_valid() {
    let dir = tempfile::tempdir().unwrap();
    assert!(succeed(&dir, &["list", "suites"]).contains("granular  5 worlds, 10 tasks"));
    assert!(succeed(&dir, &["suite", "validate", "smoke"]).contains("10 worlds, 100 tasks, all valid"));
    let shown = succeed(&dir, &["suite", "show", "smoke"]);
    assert!(shown.contains("w001") && shown.contains("w010"), "{shown}");
    assert_eq!(succeed(&dir, &["tasks", "list", "--suite", "smoke"]).lines().count(), 100);
    assert_eq!(succeed(&dir, &["tasks", "list"]).lines().count(), 1000, "vb-100 is the default");
    assert!(succeed(&dir, &["list", "suites"]).contains("vb-100    100 worlds, 1000 tasks"));
    assert!(succeed(&dir, &["list", "suites"]).contains("testbed   2 worlds, 10 tasks"));
    let listed = succeed(&dir, &["list", "suites", "--json"]);
    let listed: Vec<serde_json::Value> = listed.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let smoke = listed.iter().find(|s| s["name"] == "smoke").unwrap();
    assert_eq!(
        (&smoke["event"], &smoke["worlds"], &smoke["tasks"]),
        (&"suite".into(), &10.into(), &100.into())
    );
    assert!(smoke["hash"].is_string() && smoke["version"].is_string(), "{smoke}");
    succeed(&dir, &["suite", "testbed", "--seed", "1", "--out", "bed"]);
    let valid = succeed(&dir, &["suite", "validate", "bed", "--vehicle", "verti4wheeler"]);
    assert!(valid.contains("2 worlds, 10 tasks, all valid"), "{valid}");
}

#[test]
fn a_suite_is_shown_in_figures_as_events_and_as_a_page() {
    let dir = tempfile::tempdir().unwrap();
    let shown = succeed(&dir, &["suite", "show", "smoke"]);
    // Six rigid, three deformable, one mixed world (docs/worlds.md): the choices without a world show as dashes.
    for part in [
        "Worlds by label",
        "low        mixed       1       –       –      1",
        "Surface",
        "Ground",
        "Obstacles",
    ] {
        assert!(shown.contains(part), "{part:?} is not in {shown}");
    }
    assert!(!dir.path().join("index.html").exists());
    let events = succeed(&dir, &["suite", "show", "smoke", "--json", "-o", "page"]);
    // A page that is there is replaced only on purpose.
    let again = ["suite", "show", "smoke", "--message-format", "json", "--out", "page"];
    let refused = harness(&dir, &again);
    assert_eq!(refused.status.code(), Some(4), "{refused:?}");
    assert!(String::from_utf8(refused.stderr).unwrap().contains("--force"));
    assert_eq!(events, succeed(&dir, &[&again[..], &["--force"]].concat()), "two names for one format");
    let events: Vec<serde_json::Value> = events.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(events.len(), 11);
    assert!(events[..10].iter().all(|e| e["event"] == "world" && e["tasks"].as_array().unwrap().len() == 10));
    let suite = &events[10];
    assert_eq!(
        (&suite["event"], &suite["world_count"], &suite["task_count"]),
        (&"suite".into(), &10.into(), &100.into())
    );
    assert_eq!(suite["cells"].as_array().unwrap().len(), 27);
    let page = std::fs::read_to_string(dir.path().join("page/index.html")).unwrap();
    assert_eq!(page.matches("<article").count(), 10);
    let file = std::fs::read_to_string(dir.path().join("page/statistics.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    assert_eq!((&file["schema"], &file["hash"]), (&1.into(), &suite["hash"]));
    assert_eq!(file["worlds"][0]["id"], "w001");
    // What can't be written is an error of output, docs/results.md.
    std::fs::write(dir.path().join("taken"), "").unwrap();
    let output = harness(&dir, &["suite", "show", "smoke", "--out", "taken"]);
    assert_eq!(output.status.code(), Some(4), "{output:?}");
}

#[test]
fn a_suite_is_refused_with_all_that_is_wrong_with_it() {
    let dir = tempfile::tempdir().unwrap();
    succeed(&dir, &["suite", "generate", "--seed", "4", "--worlds", "2", "--out", "two"]);
    let valid = succeed(&dir, &["suite", "validate", "./two"]);
    assert!(valid.contains("2 worlds, 20 tasks, all valid"), "{valid}");
    // Below 4 m from an obstacle each path that bends round one is warned of, which only --strict refuses.
    let near = ["suite", "validate", "./two", "--clearance", "4", "--json"];
    let told = succeed(&dir, &near);
    let told: Vec<serde_json::Value> = told.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let (summary, findings) = told.split_last().unwrap();
    assert_eq!(
        (&summary["event"], &summary["valid"], &summary["errors"]),
        (&"summary".into(), &true.into(), &0.into())
    );
    assert!(!findings.is_empty() && summary["warnings"] == findings.len());
    assert!(findings.iter().all(|f| f["event"] == "finding" && f["severity"] == "warning"), "{findings:?}");
    assert!(
        findings.iter().any(|f| f["rule"] == "path" && f["text"].as_str().unwrap().contains("less than 4 m"))
    );
    let strict = harness(&dir, &[&near[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(3), "{strict:?}");
    // A flaw in each world: both are told on stdout, and the first again as the error.
    for (world, from, to) in [("w001", "goal: [-60.0", "goal: [-600.0"), ("w002", "id: t03", "id: t02")] {
        let file = dir.path().join(format!("two/worlds/{world}/tasks.yaml"));
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from));
        std::fs::write(file, text.replacen(from, to, 1)).unwrap();
    }
    let output = harness(&dir, &["suite", "validate", "./two"]);
    assert_eq!(output.status.code(), Some(3));
    let (stdout, stderr) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    let lines: Vec<&str> = stdout.lines().collect();
    assert!(
        lines.len() == 2 && lines.iter().all(|l| l.starts_with("error[format]: ./two/worlds/w00")),
        "{stdout}"
    );
    assert!(lines[0].contains("-600") && lines[1].contains("t02"), "{stdout}");
    assert!(
        stderr.starts_with("error: ./two: 2 errors and 0 warnings; the first: ") && stderr.contains("-600"),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1);
}

#[test]
fn a_suite_can_be_generated_and_its_tasks_chosen() {
    let dir = tempfile::tempdir().unwrap();
    succeed(&dir, &["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "one"]);
    assert_eq!(succeed(&dir, &["tasks", "list", "--suite", "./one"]).lines().count(), 10);
    let one = ["tasks", "list", "--suite", "./one", "--tasks", "w001/t03", "--message-format", "json"];
    let one = succeed(&dir, &one);
    assert!(one.starts_with("{\"event\":\"task\",\"task\":\"w001/t03\","), "{one}");
    assert_eq!(one.lines().count(), 1);
}

#[test]
fn what_is_shipped_is_listed_with_descriptions() {
    let dir = tempfile::tempdir().unwrap();
    for (what, event, name) in [
        ("vehicles", "vehicle", "hmmwv"),
        ("rules", "rules", "paper"),
        ("soils", "soils", "wong"),
        ("profiles", "profile", "onboard"),
    ] {
        let text = succeed(&dir, &["list", what]);
        assert!(text.lines().any(|line| line.starts_with(&format!("{name} "))), "{what}: {text}");
        let listed = succeed(&dir, &["list", what, "--json"]);
        for line in listed.lines() {
            let entry: serde_json::Value = serde_json::from_str(line).unwrap();
            assert_eq!(entry["event"], event);
            assert!(
                !entry["description"].as_str().unwrap().is_empty() && entry["name"].is_string(),
                "{entry}"
            );
        }
        assert_eq!(text.lines().count(), listed.lines().count());
    }
}

#[test]
fn the_number_of_selected_tasks_is_told_unless_the_user_wants_quiet() {
    let dir = tempfile::tempdir().unwrap();
    let list = ["tasks", "list", "--tasks", "elevation=high,terrain=rigid"];
    let told = harness(&dir, &list);
    assert_eq!(String::from_utf8(told.stderr).unwrap(), "200 of 1000 tasks selected\n");
    assert_eq!(told.stdout.iter().filter(|b| **b == b'\n').count(), 200);
    assert!(harness(&dir, &[&list[..], &["-q"]].concat()).stderr.is_empty());
    assert!(harness(&dir, &[&["--quiet"], &list[..]].concat()).stderr.is_empty());
}

#[test]
fn help_has_colours_only_where_they_are_wanted() {
    let dir = tempfile::tempdir().unwrap();
    let is_coloured = |args: &[&str]| succeed(&dir, args).contains("\u{1b}[");
    assert!(!is_coloured(&["--help"]), "stdout is no terminal");
    assert!(
        is_coloured(&["--color", "always", "--help"]) && is_coloured(&["run", "--help", "--color=always"])
    );
    assert!(!is_coloured(&["--color", "never", "--help"]));
}
