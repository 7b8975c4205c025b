//! What an entrant makes large, or numbers no trial can have, are findings, at once.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::fs::{self, File};

use serde_json::{Value, json};
use vb_submission::Verification;

use crate::common::{Bench, bench, sha256};

/// The findings as lines.
fn told(verdict: &Verification) -> String {
    verdict.findings.iter().map(|f| format!("{f}\n")).collect()
}

/// Changes the manifest of a submission, and writes it as the harness does.
fn edit(b: &Bench, name: &str, change: impl FnOnce(&mut Value)) {
    let file = format!("{name}/submission.json");
    let mut manifest = b.json(&file);
    change(&mut manifest);
    b.write_json(&file, &manifest);
}

/// A file of zeros of this size, with its hash in the manifest.
fn put(b: &Bench, name: &str, file: &str, size: u64) {
    File::create(b.path(name).join(file)).unwrap().set_len(size).unwrap();
    let hash = sha256(&fs::read(b.path(name).join(file)).unwrap());
    edit(b, name, |manifest| manifest["files"][file] = hash.into());
}

#[test]
fn a_file_above_its_limit_is_a_finding() {
    let b = bench();
    let replay = b.json("honest/submission.json")["replays"][0].as_str().unwrap().to_owned();
    for (file, most) in [
        // The true series may be above the limit and left out: what lies there instead is nobody's.
        (format!("run/traces/{replay}.debug.parquet"), 8 << 20),
        (format!("run/traces/{replay}.parquet"), 64 << 20),
        ("run/run.json".to_owned(), 1 << 20),
        ("report.html".to_owned(), 64 << 20),
    ] {
        b.copy("honest", "large");
        put(b, "large", &file, most + 1);
        let verdict = b.verify("large", Some((1, 1))).unwrap();
        let text = told(&verdict);
        let want = format!("files: {file}: is larger than its limit: {} bytes, at most {most}", most + 1);
        assert!(!verdict.verified && text.contains(&want), "{text}");
        assert!(verdict.sample.is_none(), "nothing is driven for it");
    }
}

#[test]
fn series_that_a_drive_does_not_give_are_a_finding() {
    let b = bench();
    let replay = b.json("honest/submission.json")["replays"][0].as_str().unwrap().to_owned();
    let file = format!("run/traces/{replay}.debug.parquet");
    b.copy("honest", "series");
    put(b, "series", &file, 1000);
    let verdict = b.verify("series", Some((1, 1))).unwrap();
    assert!(!verdict.verified && told(&verdict).contains(&file), "{}", told(&verdict));
}

#[test]
fn a_number_that_no_trial_has_is_a_finding_and_ends_nothing() {
    let b = bench();
    let honest = b.records("honest/run/tasks.jsonl");
    let fields = honest[0]["metrics"].as_object().unwrap().keys().filter(|k| *k != "samples");
    for field in fields {
        b.copy("honest", "number");
        let mut records = honest.clone();
        records[0]["metrics"][field] = json!(1e308);
        b.write_records("number/run/tasks.jsonl", &records);
        b.state_hash_of("number", "run/tasks.jsonl");
        let verdict = b.verify("number", Some((1, 1))).unwrap();
        let text = told(&verdict);
        assert!(text.contains(&format!("metrics.{field}: 1e308 must lie in")), "{text}");
    }
}

#[test]
fn records_without_end_are_not_read_to_their_end() {
    let b = bench();
    b.copy("honest", "lines");
    let path = b.path("lines/run/tasks.jsonl");
    let mut text = fs::read(&path).unwrap();
    text.extend(std::iter::repeat_n(b'\n', 30 << 20));
    fs::write(&path, &text).unwrap();
    b.state_hash_of("lines", "run/tasks.jsonl");
    let verdict = b.verify("lines", Some((1, 1))).unwrap();
    // Four tasks, and a hundred lines for findings; the hundred and first finding is that there are more.
    assert_eq!(verdict.findings.len(), 100);
    assert!(verdict.more_findings < 10, "{}", verdict.more_findings);
}

#[test]
fn a_manifest_that_is_long_for_nothing_is_refused_before_it_is_built() {
    let b = bench();
    b.copy("honest", "long");
    let path = b.path("long/submission.json");
    let text = fs::read_to_string(&path).unwrap();
    for (from, to) in [
        ("\"replays\": [", format!("\"replays\": [{}", "\"\",".repeat(500_000))),
        ("\"params\": {}", format!("\"params\": {{\"a\": \"{}\"}}", "x".repeat(2 << 20))),
    ] {
        assert!(text.contains(from), "{text}");
        fs::write(&path, text.replacen(from, &to, 1)).unwrap();
        let e = b.verify("long", Some((1, 1))).unwrap_err().to_string();
        assert!(e.contains("a manifest without tasks, in bytes, exceeds 1048576"), "{e}");
    }
}
