//! Whatever is changed in a submission is found, or declared to be information that nobody checks.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;

use crate::common::{bench, changed, dotted, leaves};
use vb_submission::{Check, Division, Manifest, SubmissionError, Verification};

fn informational(path: &str) -> bool {
    Manifest::INFORMATIONAL.iter().any(|i| path == *i || (i.ends_with('.') && path.starts_with(i)))
}

/// Whether a verification came to nothing good.
fn found(verdict: &Result<Verification, SubmissionError>) -> bool {
    verdict.as_ref().map_or(true, |v| !v.verified && !v.findings.is_empty())
}

/// The findings as lines, or the error.
fn told(verdict: &Result<Verification, SubmissionError>) -> String {
    match verdict {
        Ok(v) => v.findings.iter().map(|f| format!("{f}\n")).collect(),
        Err(e) => e.to_string(),
    }
}

#[test]
fn an_honest_submission_is_verified_and_ranked() {
    let b = bench();
    let verdict = b.verify("honest", None).unwrap();
    assert!(verdict.verified, "{verdict:?}");
    assert_eq!(verdict.division, Division::Ranked);
    assert_eq!(verdict.checks, Check::ALL);
    assert_eq!(verdict.sample.unwrap().tasks, ["w001/t00", "w001/t01", "w002/t00", "w002/t01"]);
    // Nothing of the entrant's machine is in it.
    let text = fs::read_to_string(b.path("honest/submission.json")).unwrap();
    assert!(!text.contains("somebody") && !text.contains(b.dir.path().to_str().unwrap()), "{text}");
}

#[test]
fn each_field_of_the_manifest_is_checked_or_informational() {
    let b = bench();
    let honest = b.json("honest/submission.json");
    let (mut unfound, mut read) = (BTreeSet::new(), 0);
    b.copy("honest", "manifest");
    for leaf in leaves(&honest) {
        let mut forged = honest.clone();
        let value = forged.pointer_mut(&leaf).unwrap();
        *value = changed(value);
        b.write_json("manifest/submission.json", &forged);
        let verdict = b.verify("manifest", Some((1, 1)));
        // As it is read, nothing but this field differs.
        let name = dotted(&leaf);
        let own = told(&verdict).contains(name.strip_prefix("run.").unwrap_or(&name));
        read += usize::from(own);
        if !found(&verdict) {
            unfound.insert(dotted(&leaf));
        } else if let Ok(v) = &verdict {
            // Names of files and of replays are found as files that are missing.
            let file = name.starts_with("files.") || name.starts_with("replays.");
            assert!(own || file, "{leaf}: {v:?}");
        }
    }
    // Most can be read and are found for what they say.
    assert!(read > 60, "{read}");
    // The start of the run is in run.json, too, which the next test changes along.
    let expected =
        ["entrant.code", "entrant.name", "entrant.note", "entrant.paper", "entrant.url"].map(str::to_owned);
    assert_eq!(unfound, expected.clone().into());
    assert!(expected.iter().all(|p| informational(p)));
}

#[test]
fn each_field_of_the_runs_files_is_checked_even_if_its_hash_is_stated_anew() {
    let b = bench();
    let mut named = 0;
    for file in ["run/run.json", "run/summary.json"] {
        let honest = b.json(&format!("honest/{file}"));
        for leaf in leaves(&honest) {
            b.copy("honest", "files");
            let mut forged = honest.clone();
            let value = forged.pointer_mut(&leaf).unwrap();
            *value = changed(value);
            b.write_json(&format!("files/{file}"), &forged);
            b.state_hash_of("files", file);
            let verdict = b.verify("files", Some((1, 1)));
            assert!(found(&verdict), "{file}: {leaf}");
            // A field that can still be read is named.
            let text = told(&verdict);
            let read = !text.contains("at line");
            assert!(!read || text.contains(&dotted(&leaf)), "{file}: {leaf}: {text}");
            named += usize::from(read);
        }
    }
    assert!(named > 150, "{named} fields are named");
}

/// The strongest forger: he changes his run before he makes the submission, so that everything in it agrees.
#[test]
fn each_field_of_a_record_that_is_driven_again_is_checked_by_its_trajectory() {
    let b = bench();
    let honest = b.records("run/tasks.jsonl");
    let at = honest.iter().position(|r| r["task"] == "w002/t01").unwrap();
    b.copy("run", "forged-run");
    let mut checked = 0;
    for leaf in leaves(&honest[at]) {
        let mut records = honest.clone();
        let value = records[at].pointer_mut(&leaf).unwrap();
        *value = changed(value);
        b.write_records("forged-run/tasks.jsonl", &records);
        let _ = fs::remove_dir_all(b.path("forged"));
        // What isn't even made is found.
        let made = b.make_with("forged-run", "forged", Some(vec!["w002/t01".parse().unwrap()]));
        if made.is_err() {
            continue;
        }
        // One task by lot, and the one with a trace.
        let verdict = b.verify("forged", Some((1, 0)));
        assert!(found(&verdict), "{leaf}");
        let text = told(&verdict);
        assert!(text.contains("w002/t01"), "{leaf}: {text}");
        if text.starts_with("rerun") {
            checked += 1;
            assert!(text.contains(&dotted(&leaf)), "{leaf}: {text}");
        }
    }
    // Outcome, times, metrics, fuel, steps, hash: what no other check knows.
    assert!(checked > 28, "{checked}");
}

#[test]
fn each_field_of_what_was_run_is_checked_or_costs_the_rank() {
    let b = bench();
    let honest = b.json("run/run.json");
    b.copy("run", "header-run");
    let mut unfound = BTreeSet::new();
    for leaf in leaves(&honest) {
        let mut forged = honest.clone();
        let value = forged.pointer_mut(&leaf).unwrap();
        *value = changed(value);
        b.write_json("header-run/run.json", &forged);
        let _ = fs::remove_dir_all(b.path("header"));
        if let Ok(manifest) = b.make("header-run", "header") {
            let verdict = b.verify("header", Some((1, 1)));
            // A planner that makes nothing of its seed does drive the same with another one; but nobody ranks that.
            if !found(&verdict) && manifest.division == Division::Ranked {
                unfound.insert(dotted(&leaf));
            }
        }
    }
    // Paths are not in submissions; the commit and the start are for people.
    let expected = ["harness_commit", "plugin.path", "started_at", "suite.path"].map(str::to_owned);
    assert_eq!(unfound, expected.into());
    assert!(informational("run.started_at") && informational("run.harness_commit"));
}

#[test]
fn missing_added_and_repeated_tasks_are_named() {
    let b = bench();
    let honest = b.records("honest/run/tasks.jsonl");
    let forge = |records: &[serde_json::Value], words: &str| {
        b.copy("honest", "tasks");
        b.write_records("tasks/run/tasks.jsonl", records);
        b.state_hash_of("tasks", "run/tasks.jsonl");
        let verdict = b.verify("tasks", Some((1, 1)));
        assert!(found(&verdict) && told(&verdict).contains(words), "{words}: {}", told(&verdict));
    };
    forge(&honest[1..], &format!("{}: is missing", honest[0]["task"].as_str().unwrap()));
    let twice = [&honest[..], &honest[..1]].concat();
    forge(&twice, &format!("{}: is a duplicate", honest[0]["task"].as_str().unwrap()));
    let mut more = honest.clone();
    more.push(honest[0].clone());
    more[4]["task"] = "w003/t00".into();
    forge(&more, "w003/t00: is not a task of the run");
    let mut labels = honest.clone();
    labels[0]["density"] = "dense".into();
    forge(&labels, "its world or labels differ from those of the suite");
    let mut failed = honest.clone();
    failed[0]["outcome"] = "host_error".into();
    forge(&failed, "failed because of the machine");
    let mut odd = honest;
    odd[0]["unknown"] = 1.into();
    forge(&odd, "differs from the format of `submit`");
}

#[test]
fn a_field_that_is_there_twice_or_unknown_is_found() {
    let b = bench();
    let honest = fs::read_to_string(b.path("honest/submission.json")).unwrap();
    let forge = |from: &str, to: &str| {
        b.copy("honest", "twice");
        assert!(honest.contains(from), "{from}");
        fs::write(b.path("twice/submission.json"), honest.replacen(from, to, 1)).unwrap();
        let verdict = b.verify("twice", Some((1, 1)));
        assert!(found(&verdict), "{to}");
    };
    forge("\"abi\": \"1.0\",", "\"abi\": \"1.0\", \"abi\": \"0.1\",");
    forge("\"abi\": \"1.0\",", "\"abi\": \"1.0\", \"bonus\": 1,");
    // In a list of names the last one would count.
    forge(
        "\"tasks\": {",
        "\"tasks\": {\"w001/t00\": {\"outcome\": \"stuck\", \"time_s\": 1.0, \"state_hash\": \"\"},",
    );
    forge("\"params\": {}", "\"params\": { }");
}

#[test]
fn fewer_tasks_than_the_suite_has_are_found_or_open() {
    let b = bench();
    // A run that leaves the hard half out, and says so.
    b.run("half-run", |c| {
        c.tasks.truncate(2);
        c.selector = Some("w001".into());
    });
    let manifest = b.make("half-run", "half").unwrap();
    assert_eq!(manifest.division, Division::Open);
    assert_eq!(manifest.open_because[0].field, "selector");
    assert!(b.verify("half", None).unwrap().verified, "open, but true");
    // The same without saying so.
    b.copy("half-run", "half-run-2");
    let mut header = b.json("half-run/run.json");
    header["selector"] = serde_json::Value::Null;
    b.write_json("half-run-2/run.json", &header);
    b.make("half-run-2", "half-2").unwrap();
    let text = told(&b.verify("half-2", None));
    assert!(text.contains("run.tasks: is 2, not 4") && text.contains("w002/t01: is missing"), "{text}");
}

#[test]
fn another_suite_plugin_vehicle_or_other_limits_are_named() {
    let b = bench();
    let other = crate::common::suite(&b.path("other"), [0.9, 0.5]);
    // Compiling is what costs: whatever a hash can tell is told before.
    let unloaded = |_: &vb_host::Limits| panic!("a plugin was loaded though something was found already");
    let text = told(&b.verify_with("honest", None, &unloaded, |e| e.suite = Box::leak(Box::new(other))));
    assert!(text.starts_with("suite: submission.json: run.suite.hash"), "{text}");
    let text = told(&b.verify_with("honest", None, &unloaded, |e| e.plugin_sha256 = "00"));
    assert!(text.starts_with("plugin: submission.json: run.plugin.sha256"), "{text}");
    // A file that is another one by the time it is loaded.
    let file = crate::common::repository("tests/golden/abi-1.0/pursuit-c.wasm");
    let other = |limits: &vb_host::Limits| vb_host::Plugin::load(&file, limits, None);
    let text = told(&b.verify_with("honest", None, &other, |_| {}));
    assert!(text.contains("the plugin file changed"), "{text}");
    let vehicle = vb_vehicle::Vehicle { hash: "00".repeat(32), ..b.vehicle.clone() };
    let text = told(&b.verify_with("honest", None, &unloaded, |e| e.vehicle = Box::leak(Box::new(vehicle))));
    assert!(text.starts_with("vehicle: submission.json: run.vehicle.hash"), "{text}");
    let own: &'static _ = Box::leak(Box::new(vb_sense::Profile::built_in("onboard").unwrap()));
    let verdict = b.verify_with("honest", None, &unloaded, |e| e.perception = own);
    let text = told(&verdict);
    assert!(text.starts_with("perception: submission.json: run.perception.hash"), "{text}");
    let verdict = verdict.unwrap();
    assert!(verdict.findings.iter().all(|f| verdict.checks.contains(&f.check)), "{verdict:?}");
    // A run with more fuel is open, and one that hides it is found by the fractions in its records.
    let mut header = b.json("run/run.json");
    header["limits"]["fuel_per_step"] = 4_000_000_000u64.into();
    b.copy("run", "limits-run");
    b.write_json("limits-run/run.json", &header);
    let manifest = b.make("limits-run", "limits").unwrap();
    assert_eq!(manifest.open_because[0].field, "limits.fuel_per_step");
    let text = told(&b.verify("limits", None));
    assert!(text.contains("fuel.max_fraction"), "{text}");
}

#[test]
fn files_that_are_changed_added_left_out_or_linked_are_named() {
    let b = bench();
    let forge = |what: &str, change: &dyn Fn(&std::path::Path)| {
        b.copy("honest", "odd-files");
        change(&b.path("odd-files"));
        let verdict = b.verify("odd-files", Some((1, 1)));
        assert!(found(&verdict) && told(&verdict).contains(what), "{what}: {}", told(&verdict));
    };
    forge("report.html: its SHA-256", &|d| fs::write(d.join("report.html"), "<script>").unwrap());
    forge("run/notes.txt: does not belong", &|d| fs::write(d.join("run/notes.txt"), "hello").unwrap());
    forge("run/summary.json: is missing", &|d| fs::remove_file(d.join("run/summary.json")).unwrap());
    let trace = "run/traces/w001/t00.parquet";
    forge(&format!("{trace}: is missing"), &|d| fs::remove_file(d.join(trace)).unwrap());
    #[cfg(unix)]
    forge("neither a file nor a folder", &|d| {
        fs::remove_file(d.join("report.html")).unwrap();
        std::os::unix::fs::symlink("/etc/passwd", d.join("report.html")).unwrap();
    });
    // A report and a trace with their hashes stated anew.
    for (file, words) in [("report.html", "differs from the report"), (trace, "differs from the re-run")] {
        b.copy("honest", "odd-files");
        let path = b.path("odd-files").join(file);
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
        b.state_hash_of("odd-files", file);
        let text = told(&b.verify("odd-files", Some((1, 1))));
        assert!(text.contains(file) && text.contains(words), "{file}: {text}");
    }
}

#[test]
fn a_forged_result_survives_only_if_it_is_not_drawn() {
    let b = bench();
    let mut records = b.records("run/tasks.jsonl");
    let at = records.iter().position(|r| r["task"] == "w002/t01").unwrap();
    records[at]["time_s"] = 1.0.into();
    b.copy("run", "lucky-run");
    b.write_records("lucky-run/tasks.jsonl", &records);
    b.make_with("lucky-run", "lucky", Some(vec!["w001/t00".parse().unwrap()])).unwrap();
    let mut caught = 0;
    for seed in 0..6 {
        let verdict = b.verify("lucky", Some((1, seed))).unwrap();
        let drawn = verdict.sample.as_ref().unwrap().tasks.iter().any(|t| *t == "w002/t01");
        assert_eq!(!verdict.verified, drawn, "{verdict:?}");
        assert_eq!(verdict.sample.unwrap().seed, Some(seed));
        caught += usize::from(drawn);
    }
    // One of three is drawn each time.
    assert!((1..6).contains(&caught), "{caught}");
    let verdict = b.verify("lucky", None);
    assert!(told(&verdict).contains("w002/t01: time_s: is 1.0"), "{}", told(&verdict));
}

#[test]
fn lines_without_end_are_not_read_and_a_hundred_findings_are_kept() {
    let b = bench();
    b.copy("honest", "newlines");
    let lines = 1_000_000;
    fs::write(b.path("newlines/run/tasks.jsonl"), "\n".repeat(lines)).unwrap();
    b.state_hash_of("newlines", "run/tasks.jsonl");
    let verdict = b.verify("newlines", None).unwrap();
    assert!(!verdict.verified);
    assert_eq!(verdict.findings.len(), 100);
    // Of four tasks a hundred and four lines are looked at; that there are more is one finding, and what the file lacks are others.
    assert!((5..100).contains(&verdict.more_findings), "{}", verdict.more_findings);
}
