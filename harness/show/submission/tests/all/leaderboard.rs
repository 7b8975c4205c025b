//! Sites of accepted submissions: ranks, ties, boards, texts of strangers, and what can't be shown.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::common::{Bench, bench, sha256};
use serde_json::{Value, json};
use vb_report::Runs;
use vb_submission::leaderboard::{self, Entry, Site};
use vb_submission::{Scores, SubmissionError};
use vb_world::{Suite, TaskId};

const HOSTILE: &str = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>";

/// An accepted entry: the honest submission after a change, with the verdict that the owner would have given.
fn accept(b: &Bench, dir: &str, id: &str, change: impl FnOnce(&mut Value, &mut Vec<Value>)) {
    let own = format!("{dir}/{id}");
    b.copy("honest", &own);
    let mut manifest = b.json("honest/submission.json");
    let mut records = b.records("honest/run/tasks.jsonl");
    change(&mut manifest, &mut records);
    b.write_records(&format!("{own}/run/tasks.jsonl"), &records);
    b.write_json(&format!("{own}/run/run.json"), &manifest["run"]);
    for file in ["run/tasks.jsonl", "run/run.json"] {
        manifest["files"][file] = sha256(&fs::read(b.path(&own).join(file)).unwrap()).into();
    }
    b.write_json(&format!("{own}/submission.json"), &manifest);
    let verdict = json!({
        "schema": 1, "harness_version": "0.1.0", "verified": true,
        "submission_sha256": sha256(&fs::read(b.path(&own).join("submission.json")).unwrap()),
        "plugin_sha256": manifest["run"]["plugin"]["sha256"], "suite_hash": manifest["run"]["suite"]["hash"],
        "division": manifest["division"], "checks": ["files"], "findings": [],
        "sample": {"seed": 7, "of": 4, "tasks": ["w001/t00"]},
    });
    fs::write(b.path(&own).join("verification.json"), verdict.to_string()).unwrap();
}

/// Another planner: each has a plugin of its own.
fn planner(manifest: &mut Value, name: &str) {
    manifest["run"]["plugin"]["name"] = name.into();
    manifest["run"]["plugin"]["sha256"] = sha256(name.as_bytes()).into();
}

fn fail(record: &mut Value) {
    record["outcome"] = "stuck".into();
    record["three_way"] = "stuck".into();
}

/// The same records in four times as many worlds, eight in all: in two worlds nothing can be certain.
fn spread(records: &mut Vec<Value>) {
    let own = std::mem::take(records);
    for k in 0..4 {
        for record in &own {
            let mut record = record.clone();
            for field in ["task", "world"] {
                record[field] = record[field].as_str().unwrap().replacen("w0", &format!("w{k}"), 1).into();
            }
            records.push(record);
        }
    }
}

fn build(b: &Bench, dir: &str, out: &str) -> Result<Site, SubmissionError> {
    leaderboard::build(&b.path(dir), &b.path(out), "A board", &mut Shelf::default())
}

/// Suites that are at hand, and the entries that were asked about.
#[derive(Default)]
struct Shelf {
    suite: Option<Suite>,
    asked: Vec<String>,
}

impl leaderboard::Source for Shelf {
    fn suite(&mut self, entry: &Entry, _: &Runs) -> Option<Suite> {
        self.asked.push(entry.id.clone());
        self.suite.clone()
    }

    fn replays(&mut self, entry: &Entry, _: &Runs, _: &Path) -> Result<BTreeSet<TaskId>, SubmissionError> {
        self.asked.push(entry.id.clone());
        Ok(BTreeSet::new())
    }
}

/// Scores of an entry on a hidden suite, as its owner puts them beside.
fn holdout(b: &Bench, dir: &str, id: &str, suite: &str, success: f64, interval: [f64; 2]) {
    let run = &b.json(&format!("{dir}/{id}/submission.json"))["run"];
    let scores = json!({
        "schema": 1, "harness_version": "0.1.0", "suite": suite, "suite_version": "1", "planner": id,
        "planner_version": "1", "plugin_sha256": run["plugin"]["sha256"], "vehicle": "hmmwv", "rules": "paper",
        "perception": "oracle", "tasks": 100, "outcomes": {}, "flags": {}, "success_percent": success, "success_interval_percent": interval,
        "time_mean_s": 30.0, "roll_mean_deg": 1.0, "pitch_mean_deg": 1.0,
    });
    fs::write(b.path(dir).join(id).join("holdout.json"), scores.to_string()).unwrap();
}

fn board(b: &Bench, out: &str) -> Value {
    serde_json::from_slice(&fs::read(b.path(out).join("leaderboard.json")).unwrap()).unwrap()
}

#[test]
fn ties_share_a_rank_and_certain_differences_part() {
    let b = bench();
    accept(b, "ranks", "best", |m, r| {
        planner(m, "best");
        spread(r);
    });
    // One task of sixteen in one world of eight: nobody knows.
    accept(b, "ranks", "close", |m, r| {
        planner(m, "close");
        spread(r);
        fail(&mut r[0]);
    });
    // All of them in all worlds: p = 2 · 2⁻⁸.
    for name in ["worse", "worst-too"] {
        accept(b, "ranks", name, |m, r| {
            planner(m, name);
            spread(r);
            r.iter_mut().for_each(fail);
        });
    }
    let site = build(b, "ranks", "ranks-site").unwrap();
    let found: Vec<(String, usize, bool)> =
        site.boards[0].entries.iter().map(|r| (r.entry.id.clone(), r.rank, r.tied)).collect();
    let expected = [("best", 1, true), ("close", 1, true), ("worse", 3, true), ("worst-too", 3, true)];
    assert_eq!(found, expected.map(|(id, rank, tied)| (id.to_owned(), rank, tied)));
    let data = board(b, "ranks-site");
    let entries = &data["boards"][0]["entries"];
    assert_eq!((&entries[1]["rank"], &entries[1]["tied"]), (&1.into(), &true.into()));
    assert_eq!(entries[1]["success_rate"]["mean"], 0.9375);
    assert_eq!(entries[1]["behind_first_of_rank"]["mean"], -0.0625);
    assert_eq!(entries[2]["outcomes"]["stuck"], 16);
    for page in ["index.html", "entries/best/index.html", "entries/best/report.html"] {
        let text = fs::read_to_string(b.path("ranks-site").join(page)).unwrap();
        assert!(text.contains("Content-Security-Policy"), "{page}");
    }
    let text = fs::read_to_string(b.path("ranks-site/index.html")).unwrap();
    assert!(text.contains("data-v=\"1\">1<small>=</small>"), "{text}");
    // What no column has is below the name: one of four tasks was driven again, and all of the last entry's are stuck.
    for part in [
        "25 % re-run",
        "rollover 0.0 % (tilt above 30° in ",
        "strict success ",
        "stuck 100.0 %",
        "href=\"https://example.org/code\"",
        ">paper</a>",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn entries_that_all_have_scores_on_the_hidden_suite_are_ranked_by_them() {
    let b = bench();
    let scores = |id: &str, suite: &str, success: f64, interval: [f64; 2]| {
        holdout(b, "hold", id, suite, success, interval);
    };
    // By heart: all public tasks, hardly a hidden one.
    accept(b, "hold", "by-heart", |m, _| planner(m, "by-heart"));
    for id in ["good", "fair"] {
        accept(b, "hold", id, |m, r| {
            planner(m, id);
            r.iter_mut().for_each(fail);
        });
    }
    let ranks = |out: &str| -> (Value, Vec<(String, usize, bool)>) {
        let site = build(b, "hold", out).unwrap();
        let entries = site.boards[0].entries.iter().map(|r| (r.entry.id.clone(), r.rank, r.tied)).collect();
        (board(b, out)["boards"][0]["ranked_by"].clone(), entries)
    };
    scores("by-heart", "secret", 5.0, [2.0, 9.0]);
    scores("good", "secret", 60.0, [50.0, 70.0]);
    // One without scores, or with those of another suite: all are held against each other on what all have.
    let (by, entries) = ranks("hold-site-1");
    assert_eq!((by, entries[0].0.as_str()), ("suite".into(), "by-heart"));
    scores("fair", "older", 55.0, [45.0, 65.0]);
    assert_eq!(ranks("hold-site-2").0, "suite");
    scores("fair", "secret", 55.0, [45.0, 65.0]);
    let (by, entries) = ranks("hold-site-3");
    assert_eq!(by, "holdout");
    let expected = [("good", 1, true), ("fair", 1, true), ("by-heart", 3, false)];
    assert_eq!(entries, expected.map(|(id, rank, tied)| (id.to_owned(), rank, tied)));
    let page = fs::read_to_string(b.path("hold-site-3/index.html")).unwrap();
    assert!(page.contains("ranked by the hidden suite"), "{page}");
    assert!(page.contains("if the two 95 % intervals overlap"));
}

#[test]
fn an_entry_has_a_map_of_each_world_whose_pictures_all_entries_share() {
    let b = bench();
    for (id, failed) in [("good", false), ("bad", true)] {
        accept(b, "maps", id, |m, r| {
            planner(m, id);
            if failed {
                r.iter_mut().for_each(fail);
            }
        });
    }
    let mut shelf = Shelf { suite: Some(b.suite.clone()), asked: Vec::new() };
    leaderboard::build(&b.path("maps"), &b.path("maps-site"), "<b>", &mut shelf).unwrap();
    let read = |page: &str| fs::read_to_string(b.path("maps-site").join(page)).unwrap();
    let folders: Vec<_> = fs::read_dir(b.path("maps-site/worlds")).unwrap().collect();
    assert_eq!(folders.len(), 1, "one suite");
    let pictures = folders[0].as_ref().unwrap().path();
    // Five layers and a small one of each of two worlds, whatever the number of entries.
    assert_eq!(fs::read_dir(&pictures).unwrap().count(), 12);
    // The honest submission carries the trace of its first success alone: one way is there, and of the others the place where they
    // ended.
    let map = read("entries/bad/maps/w001.html");
    assert_eq!(
        (map.matches("class=\"way ").count(), map.matches("<circle class=\"end e2\"").count()),
        (1, 2),
        "{map}"
    );
    assert_eq!(read("entries/good/maps/w002.html").matches("<circle class=\"end e0\"").count(), 2);
    assert!(!map.contains("end unplaced"));
    assert!(
        map.contains("<a href=\"../../../index.html\">&lt;b&gt;</a><a href=\"../index.html#worlds\">bad</a>")
    );
    let shown = format!("../../../worlds/{}/w001-shade.png", pictures.file_name().unwrap().to_str().unwrap());
    assert!(map.contains(&shown) && !map.contains("data:image"));
    let page = read("entries/bad/index.html");
    assert!(page.contains("href=\"maps/w001.html\"") && page.contains("<small>0/2</small>"), "{page}");
    assert_eq!(page.matches("<svg class=\"thumbnail\"").count(), 2);
    // From a task's row to its map.
    assert!(read("entries/good/report.html").contains("[\"w001\",\"low\",\"rigid\",\"sparse\",1]"));
    // A square a world, the one with nothing done brown and the other green.
    let index = read("index.html");
    assert_eq!((index.matches("class=\"q0\"").count(), index.matches("class=\"q5\"").count()), (2, 2));
}

#[test]
fn a_hidden_suite_has_neither_maps_nor_replays_wherever_its_scores_are() {
    let b = bench();
    for id in ["scored", "other"] {
        accept(b, "secret", id, |m, _| planner(m, id));
    }
    // One entry has scores on `tiny`, so nobody's drives on it may be shown.
    holdout(b, "secret", "scored", "tiny", 5.0, [2.0, 9.0]);
    let mut shelf = Shelf { suite: Some(b.suite.clone()), asked: Vec::new() };
    leaderboard::build(&b.path("secret"), &b.path("secret-site"), "A board", &mut shelf).unwrap();
    assert!(shelf.asked.is_empty(), "{:?}", shelf.asked);
    assert!(!b.path("secret-site/worlds").exists());
    for id in ["scored", "other"] {
        let own = b.path("secret-site/entries").join(id);
        assert!(!own.join("maps").exists() && !own.join("replays").exists());
        let page = fs::read_to_string(own.join("index.html")).unwrap();
        assert!(page.contains("the suite is hidden") && !page.contains("<image"), "{page}");
        assert!(!fs::read_to_string(own.join("report.html")).unwrap().contains("\"sparse\",1]"));
    }
}

#[test]
fn a_page_says_that_the_worlds_were_not_at_hand_also_where_they_are_damaged() {
    let b = bench();
    accept(b, "without", "one", |m, _| planner(m, "one"));
    build(b, "without", "without-site").unwrap();
    let page = |out: &str| fs::read_to_string(b.path(out).join("entries/one/index.html")).unwrap();
    assert!(page("without-site").contains("were missing when"));
    let suite = crate::common::suite(&b.path("broken"), [0.9, 0.4]);
    for file in fs::read_dir(b.path("broken/worlds/w002")).unwrap() {
        fs::write(file.unwrap().path(), "x").unwrap();
    }
    let mut shelf = Shelf { suite: Some(suite), asked: Vec::new() };
    leaderboard::build(&b.path("without"), &b.path("broken-site"), "A board", &mut shelf).unwrap();
    assert!(page("broken-site").contains("were missing when"));
    assert!(!b.path("broken-site/entries/one/maps").exists());
}

#[test]
fn other_conditions_are_other_boards() {
    let b = bench();
    accept(b, "boards", "a", |_, _| {});
    accept(b, "boards", "open", |m, _| {
        m["run"]["params"] = json!({"speed": "3"});
        m["division"] = "open".into();
        m["open_because"] = json!([{"field": "params", "text": "parameters were given"}]);
    });
    accept(b, "boards", "other-version", |m, _| {
        planner(m, "x");
        m["run"]["harness_version"] = "0.0.9".into();
    });
    accept(b, "boards", "other-vehicle", |m, _| {
        planner(m, "y");
        m["run"]["vehicle"] = json!({"name": "gator", "hash": "aa"});
    });
    let site = build(b, "boards", "boards-site").unwrap();
    let divisions: Vec<&str> = site.boards.iter().map(|b| b.division.name()).collect();
    assert_eq!(divisions, ["ranked", "ranked", "ranked", "open"]);
    let page = fs::read_to_string(b.path("boards-site/entries/open/index.html")).unwrap();
    assert!(page.contains("params: parameters were given"), "{page}");
    // A site is replaced, what is gone vanishes; anything else in the way is left alone.
    fs::remove_dir_all(b.path("boards/open")).unwrap();
    build(b, "boards", "boards-site").unwrap();
    assert!(!b.path("boards-site/entries/open").exists());
    fs::create_dir_all(b.path("not-a-site")).unwrap();
    fs::write(b.path("not-a-site/thesis.tex"), "").unwrap();
    assert!(build(b, "boards", "not-a-site").unwrap_err().to_string().contains("is not empty"));
}

#[test]
fn texts_of_strangers_reach_pages_as_text() {
    let b = bench();
    accept(b, "hostile", "evil", |m, r| {
        planner(m, HOSTILE);
        m["run"]["plugin"]["version"] = HOSTILE.into();
        m["entrant"] = json!({"name": HOSTILE, "note": HOSTILE});
        m["suite_version"] = HOSTILE.into();
        m["run"]["harness_version"] = HOSTILE.into();
        m["run"]["rules"]["name"] = HOSTILE.into();
        m["run"]["params"] = json!({HOSTILE: HOSTILE});
        m["division"] = "open".into();
        m["open_because"] = json!([{"field": HOSTILE, "text": HOSTILE}]);
        fail(&mut r[0]);
        r[0]["reason"] = HOSTILE.into();
    });
    build(b, "hostile", "hostile-site").unwrap();
    let mut seen = 0;
    for page in ["index.html", "entries/evil/index.html", "entries/evil/report.html"] {
        let text = fs::read_to_string(b.path("hostile-site").join(page)).unwrap();
        assert!(!text.contains("<script>document") && !text.contains("<img"), "{page}: {text}");
        seen += text.matches("&lt;img src=x").count();
    }
    assert!(seen > 8, "{seen}");
}

#[test]
fn what_is_not_verified_or_changed_since_is_refused_by_name() {
    let b = bench();
    let refused = |words: &str, change: &dyn Fn(&Path)| {
        let _ = fs::remove_dir_all(b.path("refused"));
        accept(b, "refused", "a", |_, _| {});
        change(&b.path("refused/a"));
        let e = build(b, "refused", "refused-site").unwrap_err().to_string();
        assert!(e.contains(words) && e.contains("refused/a") && !e.contains('\n'), "{words}: {e}");
        assert!(!b.path("refused-site").exists(), "nothing is written");
    };
    let edit = |dir: &Path, file: &str, from: &str, to: &str| {
        let text = fs::read_to_string(dir.join(file)).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        fs::write(dir.join(file), text.replace(from, to)).unwrap();
    };
    refused("verification.json is missing", &|d| fs::remove_file(d.join("verification.json")).unwrap());
    refused("its verification failed", &|d| {
        edit(d, "verification.json", "\"verified\":true", "\"verified\":false")
    });
    refused("belongs to another submission.json", &|d| edit(d, "submission.json", "A team", "B team"));
    refused("tasks.jsonl: its SHA-256", &|d| edit(d, "run/tasks.jsonl", "success", "rollover"));
    refused("schema 2", &|d| edit(d, "verification.json", "\"schema\":1", "\"schema\":2"));
    refused("does not belong", &|d| fs::write(d.join("x.txt"), "").unwrap());
    // The same plugin twice, under another name.
    accept(b, "refused", "b", |m, _| m["entrant"]["name"] = "Copyist".into());
    let e = build(b, "refused", "refused-site").unwrap_err().to_string();
    assert!(e.contains("x.txt"), "{e}");
    fs::remove_file(b.path("refused/a/x.txt")).unwrap();
    let e = build(b, "refused", "refused-site").unwrap_err().to_string();
    assert!(e.contains("refused/b: the same plugin and conditions as entry a"), "{e}");
}

/// Everything a run knows that scores must not tell.
#[test]
fn scores_hold_nothing_of_tasks_worlds_logs_or_the_suites_identity() {
    let b = bench();
    let mut records = b.records("run/tasks.jsonl");
    fail(&mut records[0]);
    records[0]["reason"] = "SECRET-REASON".into();
    records[0]["log"] = json!(["SECRET-LOG"]);
    records[0]["backtrace"] = json!(["SECRET-TRACE"]);
    records[0]["fault"] = "planner/panic".into();
    b.copy("run", "hidden-run");
    b.write_records("hidden-run/tasks.jsonl", &records);
    let runs = vb_report::Runs::read(&[b.path("hidden-run")]).unwrap();
    let scores = Scores::new(&runs, "1");
    let text = format!("{}{}", serde_json::to_string_pretty(&scores).unwrap(), scores.text());
    let path = b.dir.path().to_str().unwrap();
    for word in [
        "SECRET",
        "planner/panic",
        "w001",
        "w002",
        "t00",
        &b.suite.hash(),
        &b.suite.hash()[..8],
        path,
        "somebody",
    ] {
        assert!(!text.contains(word), "{word}: {text}");
    }
    assert_eq!((scores.tasks, scores.success_percent), (4, 75.0));
    // No number carries more than three digits or so of what the planner did.
    let numbers = [scores.time_mean_s, scores.roll_mean_deg, scores.pitch_mean_deg];
    for v in numbers.into_iter().flatten() {
        assert_eq!(v, (v * 10.0).round() / 10.0);
    }
}
