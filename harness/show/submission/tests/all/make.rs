//! Which runs become submissions, and what becomes of those that others wrote.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::fs;

use crate::common::bench;
use vb_record::TraceMode;
use vb_submission::{Division, Submission};

#[test]
fn a_half_written_run_is_refused_with_what_is_missing() {
    let b = bench();
    let text = fs::read_to_string(b.path("run/tasks.jsonl")).unwrap();
    b.copy("run", "torn");
    // Killed in the third line.
    let lines: Vec<&str> = text.lines().collect();
    fs::write(b.path("torn/tasks.jsonl"), format!("{}\n{}\n{}", lines[0], lines[1], &lines[2][..40]))
        .unwrap();
    let e = b.make("torn", "torn-out").unwrap_err().to_string();
    assert!(e.contains("not finished: 2 of 4 tasks are missing") && e.contains("--resume"), "{e}");
    assert!(!b.path("torn-out").exists(), "nothing is left behind");
}

#[test]
fn runs_of_other_versions_are_refused_with_the_version_that_is_needed() {
    let b = bench();
    let mut header = b.json("run/run.json");
    header["harness_version"] = "0.0.9".into();
    b.copy("run", "old");
    b.write_json("old/run.json", &header);
    let e = b.make("old", "old-out").unwrap_err().to_string();
    assert!(e.contains("created with version 0.0.9 of the harness; this is 0.1.0"), "{e}");
    header["schema"] = 9.into();
    b.write_json("old/run.json", &header);
    let e = b.make("old", "old-out").unwrap_err().to_string();
    assert!(e.contains("schema 9 is not supported"), "{e}");

    b.copy("honest", "newer");
    let mut manifest = b.json("honest/submission.json");
    manifest["schema"] = 2.into();
    manifest["unknown"] = 1.into();
    b.write_json("newer/submission.json", &manifest);
    let e = Submission::open(&b.path("newer")).unwrap_err().to_string();
    assert!(e.contains("schema 2 is not supported; this version reads up to 1"), "{e}");
    assert!(Submission::open(&b.path("run")).unwrap_err().to_string().contains("is not a submission"));
}

#[test]
fn the_same_run_gives_the_same_submission() {
    let b = bench();
    b.make("run", "again").unwrap();
    let read = |dir: &str| fs::read(b.path(dir).join("submission.json")).unwrap();
    assert_eq!(read("again"), read("honest"));
    let e = b.make("run", "again").unwrap_err().to_string();
    assert!(e.contains("is not empty"), "{e}");
}

#[test]
fn replays_are_the_first_of_each_outcome_or_those_wanted() {
    let b = bench();
    let manifest = b.make("run", "own-choice").unwrap();
    assert_eq!(manifest.replays, ["w001/t00"], "all four succeed");
    let wanted = Some(["w002/t01", "w001/t01"].map(|t| t.parse().unwrap()).to_vec());
    let manifest = b.make_with("run", "wanted", wanted).unwrap();
    assert_eq!(manifest.replays, ["w001/t01", "w002/t01"]);
    assert!(b.verify("wanted", Some((1, 0))).unwrap().verified);
    let e = b.make_with("run", "none", Some(vec!["w009/t00".parse().unwrap()])).unwrap_err().to_string();
    assert!(e.contains("w009/t00: not a task of the run"), "{e}");
    b.run("no-trace", |c| c.trace = TraceMode::None);
    let e = b.make_with("no-trace", "none", Some(vec!["w001/t00".parse().unwrap()])).unwrap_err().to_string();
    assert!(e.contains("has no trace"), "{e}");
    let manifest = b.make("no-trace", "traceless").unwrap();
    assert!(manifest.replays.is_empty() && manifest.division == Division::Ranked);
    assert!(b.verify("traceless", None).unwrap().verified);
}

#[test]
fn every_condition_of_the_ranked_division_is_one() {
    let b = bench();
    let with = |name: &str, field: &str, value: serde_json::Value| {
        let mut header = b.json("run/run.json");
        *header.pointer_mut(field).unwrap() = value;
        b.copy("run", name);
        b.write_json(&format!("{name}/run.json"), &header);
        let out = format!("{name}-out");
        let manifest = b.make(name, &out).unwrap();
        assert_eq!(manifest.division, Division::Open, "{field}");
        let fields: Vec<String> = manifest.open_because.into_iter().map(|r| r.field).collect();
        assert_eq!(fields, [field[1..].replace('/', ".")], "{field}");
    };
    with("o1", "/params", serde_json::json!({"speed": "3"}));
    with("o2", "/seed", 1.into());
    with("o3", "/time_step", 0.0005.into());
    with("o4", "/soil_resolution", 0.05.into());
    with("o5", "/scale", 0.5.into());
    with("o6", "/limits/memory_bytes", (1u64 << 30).into());
    with("o7", "/limits/wasm_watchdog", 1.into());
    with("o9", "/plugin/control_period", 0.019.into());
    b.copy("run", "o8");
    let mut header = b.json("run/run.json");
    header["perception"]["hash"] = "0".repeat(64).into();
    b.write_json("o8/run.json", &header);
    assert_eq!(b.make("o8", "o8-out").unwrap().open_because[0].field, "perception");
    let rules = vb_score::Rules::resolve("dev").unwrap();
    b.run("dev-rules", |c| c.rules = rules);
    let manifest = b.make("dev-rules", "dev-out").unwrap();
    assert_eq!(manifest.open_because[0].text.split(' ').next(), Some("dev"));
    assert!(b.verify("dev-out", None).unwrap().verified);
}

#[test]
fn the_least_control_period_is_ranked_and_what_a_run_says_of_it_is_held_against_the_plugin() {
    let b = bench();
    let with = |name: &str, period: f64| {
        let mut header = b.json("run/run.json");
        header["plugin"]["control_period"] = period.into();
        b.copy("run", name);
        b.write_json(&format!("{name}/run.json"), &header);
        let out = format!("{name}-out");
        (b.make(name, &out).unwrap(), b.verify(&out, Some((1, 0))).unwrap())
    };
    // The planner's own.
    let (manifest, verdict) = with("p1", 0.1);
    assert!(verdict.verified && manifest.division == Division::Ranked);
    // A planner that hides that it acts more often, or less often, is found.
    for (name, period) in [("p2", 0.02), ("p3", 0.2)] {
        let (manifest, verdict) = with(name, period);
        assert_eq!(manifest.division, Division::Ranked, "{period}");
        let found = &verdict.findings[0];
        assert!(!verdict.verified && found.place.contains("run.plugin.control_period"), "{found}");
    }
}

#[test]
fn each_perception_profile_that_comes_with_the_harness_has_a_division() {
    let b = bench();
    for (division, profile) in Division::ALL.into_iter().filter_map(|d| d.profile().map(|p| (d, p))) {
        let out = format!("{profile}-out");
        b.run(profile, |c| c.perception = vb_sense::Profile::built_in(profile).unwrap());
        let manifest = b.make(profile, &out).unwrap();
        assert_eq!((manifest.division, manifest.open_because), (division, vec![]), "{profile}");
        let own: &'static _ = Box::leak(Box::new(vb_sense::Profile::built_in(profile).unwrap()));
        let load = |_: &vb_host::Limits| Ok(b.plugin.clone());
        let verdict = b.verify_with(&out, None, &load, |expected| expected.perception = own);
        assert!(verdict.is_ok_and(|v| v.verified && v.division == division), "{profile}");
    }
    let names = Division::ALL.map(|d| d.profile().unwrap_or("any"));
    assert_eq!(names, ["oracle", "onboard", "degraded", "any"]);
}
