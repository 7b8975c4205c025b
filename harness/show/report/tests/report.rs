//! Reports of runs as they are found on disk: whole, half written, hostile, large.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

use common::{HOSTILE, header, record, tasks, write};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use vb_page::map::Sources;
use vb_record::{
    DataHeader, PluginHeader, RUN_SCHEMA, RunHeader, RunStore, Sample, StoreError, TRACE_SCHEMA, Trace,
    TraceMeta, TraceMode,
};
use vb_report::{Beside, MapLinks, Measure, Report, ReportError, Runs, Verdict, write_csv, write_parquet};
use vb_score::{Cause, Outcome, Rules, Summary, TaskRecord};
use vb_world::{Elevation, Heightfield, Pose2, Task, TaskId, TerrainClass, World};

#[test]
fn figures_agree_with_those_of_the_summary() {
    let dir = tempfile::tempdir().unwrap();
    let mut records = tasks(9, |w, t| (w + t) % 3 != 0);
    records[5].outcome = Outcome::HostError;
    let header = header("pid", 36);
    let run = write(&dir.path().join("r"), &header, records.clone());
    let report = Report::new(Runs::read(&[run]).unwrap());
    let rules = Rules::resolve("paper").unwrap();
    let summary = Summary::new(&header, &rules, &records, Vec::new());
    let (ours, theirs) = (&report.figures()[0], summary.all.as_ref().unwrap());
    let mean = |m| ours.all.mean(m).unwrap().mean;
    assert_eq!(
        (ours.all.tasks, ours.all.count(Outcome::Success)),
        (theirs.tasks, theirs.outcomes[&Outcome::Success])
    );
    // One interval everywhere: that of the page is that of terminal and summary.json, to the bit.
    let shown = ours.all.mean(Measure::Success).unwrap().interval.unwrap();
    assert_eq!((Some(shown.low), Some(shown.high)), (theirs.success_low, theirs.success_high));
    let (level, low) = (&ours.splits[0][0].1, &summary.elevation[&Elevation::Low]);
    let shown = level.mean(Measure::Success).unwrap().interval.map(|i| (i.low, i.high));
    assert_eq!(shown, low.success_low.zip(low.success_high));
    for (m, value) in [
        (Measure::Success, theirs.success_rate),
        (Measure::Time, theirs.time_mean_s.unwrap()),
        (Measure::Roll, theirs.metrics.roll_mean_deg.unwrap()),
        (Measure::Pitch, theirs.metrics.pitch_mean_deg.unwrap()),
    ] {
        assert!((mean(m) - value).abs() < 1e-9, "{m:?}: {} {value}", mean(m));
    }
    let (level, low) = &ours.splits[0][0];
    assert_eq!(*level, "low");
    let theirs = &summary.elevation[&Elevation::Low];
    assert_eq!(low.tasks, theirs.tasks);
    assert!((low.mean(Measure::Success).unwrap().mean - theirs.success_rate).abs() < 1e-12);
    let i = ours.all.mean(Measure::Success).unwrap().interval.unwrap();
    assert!(i.low < i.estimate && i.estimate < i.high);
}

#[test]
fn causes_are_counted_and_lead_to_their_tasks() {
    let dir = tempfile::tempdir().unwrap();
    // Of the four tasks of each of five worlds the second to the fourth fail: t01 and t02 dig in, t03 is high-centred.
    let run = write(&dir.path().join("r"), &header("pid", 20), tasks(5, |_, t| t == 0));
    let report = Report::new(Runs::read(&[run]).unwrap());
    let all = &report.figures()[0].all;
    assert_eq!((all.caused(Cause::SpinningOnSoil), all.caused(Cause::HighCentred)), (10, 5));
    assert_eq!(
        report.statistics()["runs"][0]["all"]["causes"],
        serde_json::json!({"high_centred": 5, "spinning_on_soil": 10})
    );
    assert!(
        report.markdown().contains("| spinning on soil | 10 |\n| high-centred | 5 |"),
        "{}",
        report.markdown()
    );
    let page = report.page(&Beside::default());
    assert!(
        page.contains("data-cause=\"spinning_on_soil\" data-run=\"0\">10 <small>50.0 %</small>"),
        "{page}"
    );
    // Records of the version before have no causes: the section says so.
    let old = tasks(5, |_, t| t == 0).into_iter().map(|r| TaskRecord { cause: None, ..r });
    let run = write(&dir.path().join("old"), &header("pid", 20), old);
    let report = Report::new(Runs::read(&[run]).unwrap());
    assert!(report.page(&Beside::default()).contains("a version without causes"));
    assert!(!report.markdown().contains("cause of failure"));
}

/// A trace along x from the start of a task to so far.
fn trace(task: &TaskId, end: f64) -> Trace {
    let meta = TraceMeta {
        schema: TRACE_SCHEMA,
        task: task.clone(),
        start: [0.0, 0.0, 0.0],
        goal: [20.0, 0.0],
        goal_z: 0.0,
        half_extent: [32.0, 32.0],
        scale: 1.0,
        max_speed: 30.0,
        time_step: 0.001,
        sample_period: 0.01,
        mode: TraceMode::TenHz,
    };
    let samples = (0..=100).map(|k| Sample { x: end * f64::from(k) / 100.0, y: 3.0, ..Sample::default() });
    Trace { meta, samples: samples.collect(), wheels: 0, wheel_samples: Vec::new() }
}

#[test]
fn a_map_has_the_way_of_each_run_and_where_it_ended() {
    let dir = tempfile::tempdir().unwrap();
    let hostile = |label: &str| RunHeader {
        plugin: PluginHeader { name: label.into(), ..header("x", 2).plugin },
        ..header("x", 2)
    };
    let mut world = World::uniform("w000", Heightfield::flat(33, 33, 2.0, 0.0), TerrainClass::Gravel, 0.5);
    world.tasks = ["t00", "t01", "t02"]
        .map(|id| Task {
            id: id.into(),
            start: Pose2 { x: 0.0, y: 3.0, yaw: 0.0 },
            goal: [20.0, 3.0],
            path: vec![[0.0, 3.0], [20.0, 3.0]],
        })
        .to_vec();
    let run = |label: &str, success: bool| {
        let at = dir.path().join(label.len().to_string());
        let store = RunStore::create(&at, &hostile(label)).unwrap();
        for t in 0..3 {
            let mut record = record(0, t, success);
            // The first task of a run alone kept its trace, and of the others the last says where it ended.
            // The second ended before its first sample.
            if t == 1 {
                record.metrics = None;
            } else if let Some(m) = &mut record.metrics {
                (m.end_x_m, m.end_y_m) = (if success { 18.0 } else { -7.5 }, 4.0);
            }
            if t == 0 {
                store.write_trace(&trace(&record.task, if success { 20.0 } else { 12.5 })).unwrap();
            }
            store.append(&record).unwrap();
        }
        at
    };
    let runs = Runs::read(&[run("good", true), run("<script>bad", false)]).unwrap();
    let links = MapLinks {
        above: vec![("<b>", "../../index.html")],
        report: "../index.html",
        next: Some("w007"),
        replays: ["w000/t00".parse().unwrap()].into(),
        ..MapLinks::default()
    };
    let report = Report::new(runs);
    let map = report.map(&world).unwrap();
    let page = map.page(&links);
    // A straight way has two points, y turned; of the two that are drawn only the failure's has an end, which is where it stopped.
    assert_eq!(page.matches("d=\"M0.00 -3.00L20.00 -3.00\"><title>good").count(), 1, "{page}");
    assert_eq!(page.matches("d=\"M0.00 -3.00L12.50 -3.00\"><title>&lt;script&gt;bad").count(), 1);
    assert_eq!(page.matches("<circle class=\"end e").count(), 3);
    assert!(page.contains("<circle class=\"end e2\" cx=\"12.50\" cy=\"-3.00\""));
    assert!(page.contains("high-centred") && !page.contains("<script>bad"));
    // Without a trace the outcome stands where the record says that it ended, a success, too, since no way leads there.
    assert!(page.contains("<circle class=\"end e0\" cx=\"18.00\" cy=\"-4.00\""), "{page}");
    assert!(page.contains("<circle class=\"end e2\" cx=\"-7.50\" cy=\"-4.00\""));
    // Where no record says it, it stands at the goal, (20, 3), one run's to the north and the other's to the south of it: by 3.4
    // units of a 64th of the half side, 32 m.
    assert!(page.contains("their traces were not recorded"));
    assert!(page.contains("<circle class=\"end unplaced e0\" cx=\"20.00\" cy=\"-4.70\""), "{page}");
    assert!(page.contains("<circle class=\"end unplaced e2\" cx=\"20.00\" cy=\"-1.30\""));
    assert!(
        page.contains(
            "<a href=\"../../index.html\">&lt;b&gt;</a><a href=\"../index.html#worlds\">Report</a>"
        ) && page.contains("data:image/png")
    );
    assert!(
        page.contains("<th><a href=\"../index.html#task=w000/t00\" title=\"in the report\">t00</a></th>")
    );
    // With pictures in files beside it the page has none, and may load them.
    let beside = map.page(&MapLinks { pictures: Some(Sources::files("../x/w000")), ..links });
    assert!(beside.contains("href=\"../x/w000-shade.png\"") && !beside.contains("data:image/png"));
    assert!(beside.contains("img-src data: 'self'") && !page.contains("img-src data: 'self'"));
    // Small, the way that is known has a dot, and the others have rings.
    let small = map.thumbnail("w000.png", "<i>");
    assert_eq!(
        (small.matches("end known").count(), small.matches("class=\"end e").count()),
        (4, 2),
        "{small}"
    );
    assert!(
        small.contains("aria-label=\"&lt;i&gt;\"")
            && small.contains("class=\"end known e2\" cx=\"12.5\" cy=\"-3.0\"")
    );
    assert!(
        page.contains("href=\"../replays/w000/t00.html\"")
            && page.contains("rel=\"next\" href=\"w007.html\"")
    );
    assert!(!page.contains("rel=\"prev\""));
}

#[test]
fn a_comparison_pairs_the_tasks_that_both_have_done() {
    let dir = tempfile::tempdir().unwrap();
    let a = write(&dir.path().join("a"), &header("a", 40), tasks(10, |_, t| t == 0));
    // The second has done the first nine worlds only, and in another order.
    let mut others = tasks(9, |_, t| t < 2);
    others.reverse();
    let b = write(&dir.path().join("b"), &header("b", 40), others);
    let report = Report::new(Runs::read(&[a, b]).unwrap());
    let pair = &report.comparison().unwrap().pairs[0];
    assert_eq!((pair.common, pair.both, pair.only_a, pair.only_b), (36, 9, 0, 9));
    let success = &pair.differences[0];
    assert!((success.difference.unwrap().mean - 0.25).abs() < 1e-12);
    // One task more in each of nine worlds: 2 · 2⁻⁹. It is the only test of its family, so nothing corrects it; McNemar's on 0
    // and 9 tasks happens to be the same.
    for p in [success.p, success.adjusted, success.secondary] {
        assert!((p.unwrap() - 2.0 / 512.0).abs() < 1e-12);
    }
    assert_eq!((success.worlds, success.verdict), (9, Some(Verdict::Better)));
    let time = &pair.differences[1];
    assert_eq!((time.p, time.verdict), (Some(1.0), Some(Verdict::Equal)), "equal times");
    let page = report.page(&Beside::default());
    assert!(page.contains("4 of 40 tasks are pending"), "what is missing is said");
    assert!(page.contains("The runs contain different tasks"));
}

#[test]
fn planners_are_ranked_with_ties_and_a_sentence_says_who_wins() {
    let dir = tempfile::tempdir().unwrap();
    let run = |name: &str, worlds: usize, success: &dyn Fn(usize, usize) -> bool| {
        write(&dir.path().join(format!("{name}-{worlds}")), &header(name, 36), tasks(worlds, success))
    };
    // Of four tasks a world the good one does three, another three but in two worlds two, the bad one one.
    let good = |_: usize, t: usize| t < 3;
    let near = |w: usize, t: usize| t < if w < 2 { 2 } else { 3 };
    let bad = |_: usize, t: usize| t < 1;
    let runs = |worlds: usize| {
        let dirs = [run("bad", worlds, &bad), run("good", worlds, &good), run("near", worlds, &near)];
        Report::new(Runs::read(&dirs).unwrap())
    };
    let report = runs(9);
    let places: Vec<(usize, usize, usize, &[usize])> =
        report.ranking().unwrap().places.iter().map(|p| (p.run, p.rank, p.last, &p.ties[..])).collect();
    assert_eq!(places, [(1, 1, 2, &[2][..]), (2, 1, 2, &[1]), (0, 3, 3, &[])]);
    // 27 of 36 tasks and 18 fewer; in all nine worlds, so p = 2 · 2⁻⁹, and by Holm three times that: it is the least of three.
    let c = report.comparison().unwrap();
    let d = c.between(1, 0, Measure::Success).unwrap();
    assert_eq!((d.difference.unwrap().mean, d.verdict), (0.5, Some(Verdict::Better)));
    assert!((d.adjusted.unwrap() - 6.0 / 512.0).abs() < 1e-12);
    let other = c.between(0, 1, Measure::Success).unwrap();
    assert_eq!((other.difference.unwrap().mean, other.verdict), (-0.5, Some(Verdict::Worse)));
    // Two worlds differ; with all others decided, six would be needed, before them seven: 3 · 2⁻⁶ = 0.047.
    assert_eq!(c.between(1, 2, Measure::Success).unwrap().verdict, Some(Verdict::TooFewWorlds { needed: 7 }));
    let told = "good has the highest success rate: 75.0 % of 36 tasks, 50.0 points more than bad (p = 0.012); its lead over near is not \
                significant: 9 worlds are too few (2 differ, 7 needed; run the 100 worlds of vb-100).";
    assert_eq!(report.headline().as_deref(), Some(told));
    let page = report.page(&Beside::default());
    let markdown = report.markdown();
    for (text, what) in [(&page, "page"), (&markdown, "markdown")] {
        assert!(text.replace("&#39;", "'").replace('\u{a0}', " ").contains(told), "{what}");
        assert!(text.contains("too few worlds (2 differ, 7 needed)"), "{what}");
    }
    assert!(
        markdown.contains("| 1–2 | good | 36 | 75.0 ") && markdown.contains("| 3 | bad | 36 |"),
        "{markdown}"
    );
    assert!(markdown.contains("| good |  | +5.6 | **+50.0** |"), "{markdown}");
    assert!(markdown.contains("| near − bad | +44.4 "), "{markdown}");
    let statistics = report.statistics();
    assert_eq!(statistics["headline"], told);
    assert_eq!(
        statistics["ranking"][0],
        serde_json::json!({"run": 1, "rank": 1, "rank_last": 2, "ties": [2]})
    );
    let success = &statistics["pairs"][0]["differences"]["success_rate"];
    assert_eq!((&success["verdict"], &success["worlds"]), (&"better".into(), &9.into()));
    assert!((success["p_adjusted"].as_f64().unwrap() - 6.0 / 512.0).abs() < 1e-12);

    // In three worlds nothing can be certain.
    let told = "good has the highest success rate: 75.0 % of 12 tasks, but its lead over near and bad is not significant: 3 worlds are too \
                few (2 to 3 differ, 7 needed; run the 100 worlds of vb-100).";
    let report = runs(3);
    assert_eq!(report.headline().as_deref(), Some(told));
    assert!(report.ranking().unwrap().places.iter().all(|p| (p.rank, p.last) == (1, 3)));
    let dirs = [run("x", 2, &|_, _| false), run("y", 2, &|_, _| false)];
    let report = Report::new(Runs::read(&dirs).unwrap());
    assert_eq!(report.headline().as_deref(), Some("No planner solves any of the tasks."));
    let dirs = [run("x", 7, &bad), run("y", 7, &bad), run("z", 7, &|_, _| false)];
    let report = Report::new(Runs::read(&dirs).unwrap());
    let told = "x and y have the highest success rate: 25.0 % of 28 tasks, each 25.0 points more than z (p = 0.047).";
    assert_eq!(report.headline().as_deref(), Some(told));
}

/// One run is still going on, and another was of selected tasks.
#[test]
fn the_sentence_says_of_which_tasks_it_is_where_runs_have_not_done_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let headline = |runs: &[(&str, std::ops::Range<usize>, usize)]| {
        let made = runs.iter().map(|(name, worlds, successes)| {
            let path = dir.path().join(format!("{name}-{}-{}-{successes}", worlds.start, worlds.end));
            let mut all = tasks(worlds.end, |_, t| t < *successes);
            // So many tasks has a world.
            all.drain(..4 * worlds.start);
            if !path.exists() {
                write(&path, &header(name, 4 * worlds.end as u64), all);
            }
            path
        });
        let dirs: Vec<_> = made.collect();
        Report::new(Runs::read(&dirs).unwrap()).headline().unwrap()
    };
    assert_eq!(
        headline(&[("x", 0..9, 3), ("y", 0..7, 1)]),
        "x has the highest success rate: 75.0 % of the 36 tasks that it has run, 50.0 points more than y on the 28 tasks that both have run \
         (p = 0.016)."
    );
    assert_eq!(
        headline(&[("x", 0..9, 3), ("y", 0..8, 3), ("z", 0..7, 1)]),
        "x and y have the highest success rate: 75.0 % of the tasks that each has run (36 and 32), x 50.0 points more than z on the 28 tasks that both have \
         run (p = 0.047)."
    );
    assert_eq!(
        headline(&[("x", 0..3, 3), ("y", 3..9, 1)]),
        "x has the highest success rate: 75.0 % of the 12 tasks that it has run, but its lead over y is not significant: no common tasks."
    );
}

/// A step of 5 ms, another vehicle, another scale and changed rules: whoever reads the report learns it, and nobody is ranked.
#[test]
fn runs_with_other_settings_are_not_ranked_and_the_report_says_why() {
    let dir = tempfile::tempdir().unwrap();
    let usual = write(&dir.path().join("usual"), &header("a", 36), tasks(9, |_, t| t < 3));
    type Change = fn(&mut vb_record::RunHeader);
    let changes: [(&str, Change, &str); 4] = [
        ("step", |h| h.time_step = 0.005, "time step (1 ms, 5 ms)"),
        ("scale", |h| h.scale = 0.1, "scale (1, 0.1)"),
        ("vehicle", |h| h.vehicle.hash = "12345678ff".into(), "(file 12345678))"),
        ("rules", |h| h.rules.name = "mine".into(), "rules (paper, mine)"),
    ];
    for (name, change, why) in changes {
        let mut other = header("b", 36);
        change(&mut other);
        let other = write(&dir.path().join(name), &other, tasks(9, |_, t| t < 1));
        let report = Report::new(Runs::read(&[usual.clone(), other.clone()]).unwrap());
        assert!(
            report.ranking().is_none() && report.unranked().unwrap().contains(why),
            "{:?}",
            report.unranked()
        );
        let headline = report.headline().unwrap();
        assert!(
            headline.starts_with("Not ranked: the runs differ in ") && headline.contains(why),
            "{headline}"
        );
        let (page, markdown) = (report.page(&Beside::default()), report.markdown());
        assert!(
            !page.contains("id=\"ranking\"") && page.contains("b: not the benchmark&#39;s settings ("),
            "{name}"
        );
        assert!(
            !markdown.contains("| rank |") && markdown.contains("b: not the benchmark's settings ("),
            "{markdown}"
        );
        assert!(markdown.contains("| a | 36 ") && markdown.contains("| b | 36 "), "{markdown}");
        let latex = report.latex();
        let results = &latex.iter().find(|(name, _)| *name == "results").unwrap().1;
        assert!(!results.contains("rank") && !results.contains("\\textbf"), "{results}");
        assert!(results.contains("% b: not the benchmark's settings ("), "{results}");
        let statistics = report.statistics();
        assert!(statistics["ranking"].as_array().unwrap().is_empty() && statistics["unranked"].is_string());
        // Alone, too, the page says it.
        let alone = Report::new(Runs::read(&[other]).unwrap());
        assert!(alone.page(&Beside::default()).contains("not the benchmark&#39;s settings ("), "{name}");
    }
    let report = Report::new(Runs::read(&[usual]).unwrap());
    assert!(!report.page(&Beside::default()).contains("not the benchmark"));
}

#[test]
fn no_text_of_a_planner_becomes_markup() {
    let dir = tempfile::tempdir().unwrap();
    let mut hostile = header(HOSTILE, 4);
    hostile.plugin.version = HOSTILE.into();
    hostile.params = BTreeMap::from([(HOSTILE.into(), HOSTILE.into())]);
    hostile.suite.name = HOSTILE.into();
    hostile.started_at = HOSTILE.into();
    hostile.vehicle.name = HOSTILE.into();
    hostile.rules.name = HOSTILE.into();
    hostile.soils.name = HOSTILE.into();
    let records = tasks(1, |_, _| false).into_iter().map(|mut r| {
        r.reason = format!("planner {HOSTILE} said\u{202e} {HOSTILE}");
        r.world = format!("w\"{HOSTILE}");
        r
    });
    let a = write(&dir.path().join("a"), &hostile, records);
    let mut other = hostile.clone();
    other.plugin.version = "2".into();
    let b = write(&dir.path().join("b"), &other, tasks(1, |_, _| true));
    let report = Report::new(Runs::read(&[a, b]).unwrap());
    let page = report.page(&Beside { files: vec!["tasks.csv".into()], ..Beside::default() });
    // Its own two script elements, and no other tag that runs anything.
    assert_eq!(page.matches("<script").count(), 2);
    assert_eq!(page.matches("</script").count(), 2);
    assert!(
        !page.contains("<img") && !page.contains("document.title='owned'</script"),
        "markup of a planner"
    );
    assert!(!page.contains('\u{202e}'), "nothing turns the direction of writing");
    let markdown = report.markdown();
    assert!(!markdown.contains('<') || !markdown.contains("<script"), "{markdown}");
    assert!(markdown.contains("&lt;/script&gt;"), "{markdown}");
    let csv = dir.path().join("t.csv");
    write_csv(report.runs(), fs::File::create(&csv).unwrap(), &csv).unwrap();
    let mut reader = csv::Reader::from_path(&csv).unwrap();
    assert_eq!(reader.records().count(), 8, "quotes and commas stay within their cells");
}

#[test]
fn a_half_written_run_is_reported_as_far_as_it_got() {
    let dir = tempfile::tempdir().unwrap();
    let run = write(&dir.path().join("r"), &header("pid", 100), tasks(3, |_, _| true));
    let mut file = fs::OpenOptions::new().append(true).open(run.join("tasks.jsonl")).unwrap();
    file.write_all(br#"{"task":"w009/t00","world":"w0"#).unwrap();
    let report = Report::new(Runs::read(std::slice::from_ref(&run)).unwrap());
    assert_eq!(report.figures()[0].all.tasks, 12);
    assert!(report.page(&Beside::default()).contains("88 of 100 tasks are pending"));
    assert!(report.markdown().contains("88 of 100 tasks are pending"));
}

#[test]
fn a_run_without_a_success_has_no_time_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let run = write(&dir.path().join("r"), &header("pid", 12), tasks(3, |_, _| false));
    let report = Report::new(Runs::read(&[run]).unwrap());
    assert_eq!(report.figures()[0].all.mean(Measure::Time), None);
    let success = report.figures()[0].all.mean(Measure::Success).unwrap();
    // No success in three worlds: Wilson's upper end is z²/(n + z²) for n = 3, z = 1.95996.
    let i = success.interval.unwrap();
    assert_eq!((success.mean, i.low), (0.0, 0.0));
    assert!((i.high - 3.841_458_8 / 6.841_458_8).abs() < 1e-7, "{i:?}");
    let page = report.page(&Beside::default());
    assert!(page.contains("no values") && !page.contains(">0.000<"), "an axis of nothing");
    assert!(
        !page.contains("\"NaN\"") && !page.contains(">NaN") && !page.contains(">inf"),
        "no number that is none"
    );
    assert!(report.markdown().contains("| pid | 12 | 0.0 [0.0, 56.1] | – |"), "{}", report.markdown());
}

#[test]
fn runs_that_cannot_be_reported_are_refused_with_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let good = write(&dir.path().join("good"), &header("a", 4), tasks(1, |_, _| true));
    let mut foreign = header("b", 4);
    foreign.suite.hash = "ff".repeat(32);
    let foreign = write(&dir.path().join("foreign"), &foreign, tasks(1, |_, _| true));
    let empty = write(&dir.path().join("empty"), &header("c", 4), []);
    let newer = write(&dir.path().join("newer"), &header("d", 4), tasks(1, |_, _| true));
    let text = fs::read_to_string(newer.join("run.json")).unwrap();
    let needle = format!("\"schema\": {RUN_SCHEMA}");
    assert!(text.contains(&needle));
    fs::write(newer.join("run.json"), text.replace(&needle, "\"schema\": 99")).unwrap();
    let refused = |dirs: &[&PathBuf]| {
        let dirs: Vec<PathBuf> = dirs.iter().map(|d| (*d).clone()).collect();
        let e = Runs::read(&dirs).unwrap_err();
        let text = e.to_string();
        assert!(!text.contains('\n'), "{text}");
        e
    };
    assert!(matches!(refused(&[&good, &foreign]), ReportError::Suites { .. }));
    assert!(matches!(refused(&[&good, &good]), ReportError::Twice(_)));
    assert!(matches!(refused(&[&empty]), ReportError::Empty(_)));
    let e = refused(&[&newer]);
    assert!(matches!(e, ReportError::Store(StoreError::Schema { found: 99, .. })), "{e}");
    assert!(matches!(refused(&[&dir.path().join("nowhere")]), ReportError::Store(StoreError::NoRun(_))));
    assert!(matches!(refused(&[]), ReportError::NoRuns));
}

#[test]
fn runs_of_one_planner_are_told_apart_by_what_differs() {
    let dir = tempfile::tempdir().unwrap();
    let mut fast = header("pid", 4);
    fast.params = BTreeMap::from([("speed".into(), "5".into())]);
    let plain = header("pid", 4);
    let make = |name: &str, h: &RunHeader| write(&dir.path().join(name), h, tasks(1, |_, _| true));
    let dirs = [make("x", &fast), make("y", &plain), make("z", &plain)];
    let labels = |dirs: &[PathBuf]| -> Vec<String> {
        Runs::read(dirs).unwrap().runs.into_iter().map(|r| r.label).collect()
    };
    assert_eq!(labels(&dirs[..2]), ["pid (speed 5)", "pid (speed default)"]);
    assert_eq!(labels(&dirs[1..]), ["pid [y]", "pid [z]"]);
    assert_eq!(labels(&dirs[..1]), ["pid"]);
}

#[test]
fn planners_under_several_profiles_have_a_line_each_with_paired_differences() {
    let dir = tempfile::tempdir().unwrap();
    let under = |name: &str, profile: &str, success: &dyn Fn(usize, usize) -> bool| {
        let perception = DataHeader { name: profile.into(), hash: profile.into() };
        let header = RunHeader { perception, ..header(name, 36) };
        write(&dir.path().join(format!("{name}-{profile}")), &header, tasks(9, success))
    };
    // Of four tasks a world: three succeed, two of those and another one, one of those.
    let dirs = [
        under("a", "degraded", &|_, t| t == 0),
        under("a", "oracle", &|_, t| t < 3),
        under("b", "oracle", &|_, t| t < 2),
        under("a", "onboard", &|_, t| t < 2 || t == 3),
        under("b", "onboard", &|_, t| t < 2),
    ];
    let report = Report::new(Runs::read(&dirs).unwrap());
    let r = report.robustness().unwrap();
    assert_eq!(r.profiles, ["oracle", "degraded", "onboard"], "the exact one first, the others as they come");
    let labels: Vec<&str> = r.lines.iter().map(|l| l.label.as_str()).collect();
    assert_eq!(labels, ["a", "b"]);
    let points: Vec<(usize, usize)> = r.lines[0].points.iter().map(|p| (p.run, p.profile)).collect();
    assert_eq!(points, [(1, 0), (0, 1), (3, 2)]);
    let difference = |line: usize, point: usize| {
        let d = r.lines[line].points[point].difference.clone().unwrap();
        (d.tasks, d.difference.unwrap().mean, d.p.unwrap())
    };
    assert!(r.lines[0].points[0].difference.is_none());
    // One of four instead of three: 18 tasks fewer of 36, two in each of nine worlds: p = 2 · 2⁻⁹.
    let (common, lost, p) = difference(0, 1);
    assert_eq!((common, lost), (36, -0.5));
    assert_eq!(p, 2.0 / 512.0);
    // Nine lost and nine won.
    assert_eq!(difference(0, 2), (36, 0.0, 1.0));
    assert_eq!(difference(1, 1), (36, 0.0, 1.0));
    let page = report.page(&Beside::default());
    assert!(page.contains("id=\"robustness\"") && page.contains("Success against the perception profile"));
    assert!(report.markdown().contains("| a | degraded | 25.0"), "{}", report.markdown());

    // Other parameters are another planner, and one profile is no curve.
    let other = RunHeader { params: BTreeMap::from([("k".into(), "2".into())]), ..header("b", 36) };
    let perception = DataHeader { name: "onboard".into(), hash: "o".into() };
    let other = RunHeader { perception, ..other };
    let alone = write(&dir.path().join("b-2"), &other, tasks(9, |_, _| true));
    let report = Report::new(Runs::read(&[dirs[2].clone(), alone]).unwrap());
    assert_eq!(report.robustness(), None);
    assert!(!report.page(&Beside::default()).contains("id=\"robustness\""));
}

#[test]
fn tables_hold_every_task_with_its_figures_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let mut records = tasks(2, |w, _| w == 0);
    records[0].time_s = 1.0 / 3.0;
    if let Some(m) = &mut records[0].metrics {
        m.end_x_m = -1.0 / 7.0;
    }
    records[1].metrics = None;
    records[1].fuel = None;
    records[2].reason = "=HYPERLINK(\"x\")".into();
    let run = write(&dir.path().join("r"), &header("pid", 8), records);
    let runs = Runs::read(&[run]).unwrap();
    let (csv_path, parquet_path) = (dir.path().join("t.csv"), dir.path().join("t.parquet"));
    write_csv(&runs, fs::File::create(&csv_path).unwrap(), &csv_path).unwrap();
    write_parquet(&runs, fs::File::create(&parquet_path).unwrap(), &parquet_path).unwrap();

    let mut reader = csv::Reader::from_path(&csv_path).unwrap();
    let columns = reader.headers().unwrap().clone();
    let at = |name: &str| columns.iter().position(|c| c == name).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 8);
    assert_eq!(rows[0][at("time_s")].parse::<f64>().unwrap(), 1.0 / 3.0);
    assert_eq!(rows[0][at("end_x_m")].parse::<f64>().unwrap(), -1.0 / 7.0);
    assert_eq!((&rows[1][at("roll_mean_deg")], &rows[1][at("fuel_total")]), ("", ""));
    assert_eq!(&rows[1][at("end_x_m")], "");
    assert_eq!(&rows[2][at("reason")], "'=HYPERLINK(\"x\")", "no formula for a spreadsheet");

    let file = SerializedFileReader::new(fs::File::open(&parquet_path).unwrap()).unwrap();
    let rows: Vec<BTreeMap<String, String>> = file
        .get_row_iter(None)
        .unwrap()
        .map(|r| r.unwrap().get_column_iter().map(|(n, f)| (n.clone(), f.to_string())).collect())
        .collect();
    assert_eq!(rows.len(), 8);
    assert_eq!(rows[0].len(), columns.len(), "the same columns");
    assert_eq!(rows[0]["time_s"].parse::<f64>().unwrap(), 1.0 / 3.0);
    assert_eq!(rows[1]["roll_mean_deg"], "null");
    assert_eq!((rows[0]["end_x_m"].parse::<f64>().unwrap(), &*rows[1]["end_x_m"]), (-1.0 / 7.0, "null"));
    assert_eq!(rows[7]["task"], "\"w001/t03\"");
}

#[test]
fn the_page_of_very_many_tasks_stays_small() {
    let dir = tempfile::tempdir().unwrap();
    let header = header("pid", 60_000);
    let run = write(&dir.path().join("r"), &header, []);
    let mut file = std::io::BufWriter::new(fs::File::create(run.join("tasks.jsonl")).unwrap());
    for k in 0..60_000 {
        let mut r = record(k / 10, k % 10, k % 4 != 0);
        r.task = format!("w{:05}/t{}", k / 10, k % 10).parse().unwrap();
        r.world = format!("w{:05}", k / 10);
        r.reason = "x".repeat(2000);
        serde_json::to_writer(&mut file, &r).unwrap();
        file.write_all(b"\n").unwrap();
    }
    file.into_inner().unwrap();
    // They are of records that were there before.
    fs::remove_file(run.join("checksums.txt")).unwrap();
    let report = Report::new(Runs::read(&[run]).unwrap());
    let page = report.page(&Beside::default());
    assert!(page.len() < 12 << 20, "{} bytes", page.len());
    assert!(page.contains("of 60\u{2009}000 tasks are listed, failures first"));
    assert_eq!(report.figures()[0].all.tasks, 60_000);
}
