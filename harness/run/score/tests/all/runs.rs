//! Summaries and re-scoring of whole runs.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::Path;

use vb_math::rng::Stream;
use vb_math::sin;
use vb_record::{
    DataHeader, LogMode, PluginHeader, PluginKind, RUN_SCHEMA, RulesHeader, RunHeader, RunStore, Sample,
    SuiteHeader, TRACE_SCHEMA, TraceMeta, TraceMode, TraceRecorder,
};
use vb_score::{
    Conditions, Fault, Flag, FuelUse, Outcome, RescoreError, Ride, Rules, Scorer, Summary, TaskGeometry,
    TaskRecord, TaskScore, ThreeWay, rescore,
};
use vb_sdk::fault::FaultCode;
use vb_world::{Density, Elevation, Terrain};

fn header(rules: &Rules, trace: TraceMode, tasks: u64) -> RunHeader {
    RunHeader {
        schema: RUN_SCHEMA,
        harness_version: "0.1.0".into(),
        harness_commit: "unknown".into(),
        started_at: "2026-01-01T00:00:00Z".into(),
        suite: SuiteHeader { name: "suite".into(), hash: "aa".into(), path: ".".into(), tasks },
        selector: None,
        shard: None,
        tasks,
        plugin: PluginHeader {
            name: "pid".into(),
            version: "1.0.0".into(),
            sha256: "bb".into(),
            kind: PluginKind::Wasm,
            path: "pid.wasm".into(),
            control_period: 0.1,
            eligible_for_ranking: true,
            sensors: Vec::new(),
            sandbox: None,
        },
        params: BTreeMap::new(),
        vehicle: Conditions::standard().vehicle.clone(),
        soils: Conditions::standard().soils.clone(),
        perception: DataHeader { name: "oracle".into(), hash: "ee".into() },
        scale: 1.0,
        seed: 0,
        time_step: 0.001,
        soil_resolution: 0.1,
        sample_period: 0.01,
        rules: RulesHeader {
            name: rules.name.clone(),
            hash: rules.hash(),
            profile: serde_json::to_value(rules).unwrap(),
        },
        limits: BTreeMap::new(),
        trace,
        logs: LogMode::default(),
    }
}

fn record(task: &str, elevation: Elevation, score: TaskScore) -> TaskRecord {
    let mut record = TaskRecord {
        task: task.parse().unwrap(),
        world: task.split_once('/').unwrap().0.into(),
        elevation,
        terrain: Terrain::Rigid,
        density: Density::Sparse,
        outcome: score.outcome,
        three_way: score.three_way,
        flags: BTreeMap::new(),
        departures: Vec::new(),
        reason: score.reason,
        cause: None,
        evidence: String::new(),
        fault: (score.outcome == Outcome::PlannerError).then_some(FaultCode::OutOfFuel),
        time_s: score.time_s,
        state_hash: "0123456789abcdef".into(),
        sim_steps: 1000,
        planner_steps: 10,
        clamped: 1,
        fuel: Some(FuelUse { total: 100, max_step: 20, ..FuelUse::default() }),
        metrics: score.metrics,
        ride: Some(RIDE),
        log: Vec::new(),
        backtrace: Vec::new(),
    };
    record.judge();
    record
}

/// A ride with a shock above 2.5 g.
const RIDE: Ride = Ride {
    seat_peak_g: 4.0,
    seat_peak_z_g: 3.0,
    seat_rms_m_per_s2: 2.0,
    seat_rms_z_m_per_s2: 1.5,
    absorbed_power_w: 4.0,
    airborne_fraction: 0.25,
    landed: true,
    energy_surplus_j: Some(100.0),
    held_fraction: None,
};

const GEOMETRY: TaskGeometry =
    TaskGeometry { goal: [60.0, 0.0], goal_z: 0.0, half_extent: [64.0, 64.0], scale: 1.0, max_speed: 30.0 };

/// Runs task `name`, a wobbly straight drive at `speed`, under `rules`; the planner fails at `fault` (s).
fn run(
    store: &RunStore,
    rules: &Rules,
    mode: TraceMode,
    name: &str,
    speed: f64,
    fault: Option<f64>,
) -> TaskRecord {
    drive(store, rules, mode, name, fault, |time| {
        let wobble = sin(3.0 * time) / 3.0;
        Sample {
            time,
            x: -60.0 + speed * time,
            y: wobble / 10.0,
            roll: wobble,
            pitch: wobble / 2.0,
            vx: speed,
            steering: wobble,
            throttle: 1.0 / 3.0,
            ..Sample::default()
        }
    })
}

/// Runs task `name`, in which the vehicle moves as `motion` says by the time (s).
fn drive(
    store: &RunStore,
    rules: &Rules,
    mode: TraceMode,
    name: &str,
    fault: Option<f64>,
    motion: impl Fn(f64) -> Sample,
) -> TaskRecord {
    let mut scorer = Scorer::new(rules, &GEOMETRY);
    let mut trace = TraceRecorder::new(mode, 0);
    let mut score = None;
    for k in 0.. {
        let time = f64::from(k) * 0.01;
        if fault.is_some_and(|at| time > at) {
            score = Some(scorer.clone().fail(Fault::Planner, "out of fuel"));
            break;
        }
        let sample = motion(time);
        trace.push(&sample, &[]);
        if scorer.push(&sample).is_some() {
            break;
        }
    }
    let meta = TraceMeta {
        schema: TRACE_SCHEMA,
        task: name.parse().unwrap(),
        start: [-60.0, 0.0, 0.0],
        goal: GEOMETRY.goal,
        goal_z: GEOMETRY.goal_z,
        half_extent: GEOMETRY.half_extent,
        scale: GEOMETRY.scale,
        max_speed: 30.0,
        time_step: 0.001,
        sample_period: 0.01,
        mode,
    };
    if let Some(trace) = trace.finish(meta) {
        store.write_trace(&trace).unwrap();
    }
    let record = record(name, Elevation::Low, score.or_else(|| scorer.finish()).unwrap());
    store.append(&record).unwrap();
    record
}

/// Four tasks: success, crawling success, stuck, planner error.
fn make_run(dir: &Path, rules: &Rules, mode: TraceMode) -> Vec<TaskRecord> {
    let store = RunStore::create(dir, &header(rules, mode, 4)).unwrap();
    vec![
        run(&store, rules, mode, "w/a", 5.0, None),
        run(&store, rules, mode, "w/b", 1.95, None),
        run(&store, rules, mode, "w/c", 0.05, None),
        run(&store, rules, mode, "w/d", 4.0, Some(3.0)),
    ]
}

#[test]
fn full_traces_and_the_same_rules_repeat_the_run_bit_for_bit() {
    let tmp = tempfile::tempdir().unwrap();
    let rules = Rules::paper();
    let records = make_run(tmp.path(), &rules, TraceMode::Full);
    let outcomes: Vec<Outcome> = records.iter().map(|r| r.outcome).collect();
    assert_eq!(outcomes, [Outcome::Success, Outcome::Success, Outcome::Stuck, Outcome::PlannerError]);
    let again = rescore(tmp.path(), &rules).unwrap();
    assert_eq!(again.records, records);
    assert_eq!(
        again.summary,
        Summary::new(&header(&rules, TraceMode::Full, 4), &rules, &records, Vec::new())
    );
    assert!(again.exact && (again.resolution_s - 0.01).abs() < 1e-15);
}

#[test]
fn other_rules_give_other_verdicts_without_simulating() {
    let tmp = tempfile::tempdir().unwrap();
    let records = make_run(tmp.path(), &Rules::paper(), TraceMode::Full);
    // A tighter radius than 10 m is never seen: those traces end at 10 m. The crawler is stuck by the speed rule.
    let again = rescore(tmp.path(), &Rules::resolve("release").unwrap()).unwrap();
    assert_eq!(again.summary.undecided, ["w/a"]);
    let outcomes: Vec<_> = again.records.iter().map(|r| (r.task.as_str(), r.outcome)).collect();
    assert_eq!(outcomes, [("w/b", Outcome::Stuck), ("w/c", Outcome::Stuck), ("w/d", Outcome::PlannerError)]);
    assert_eq!(again.records[2].fault, Some(FaultCode::OutOfFuel));
    assert_eq!(again.records[0].state_hash, records[1].state_hash);
    // A trace doesn't hold what shock and ride are measured by: they stay only where the trial ends as it did.
    assert!(again.records[0].time_s < records[1].time_s && again.records[0].ride.is_none());
    assert!(!again.records[0].flags.contains_key(&Flag::Shock) && !again.records[0].flags[&Flag::Strict]);
    assert_eq!((again.records[2].ride, again.records[2].flags[&Flag::Shock]), (Some(RIDE), true));
    assert_eq!(again.summary.all.as_ref().unwrap().tasks, 3);
    // None of the three decided tasks succeeded; the fourth may have.
    let table = again.summary.table(None);
    assert!(table.contains("1 undecided") && table.contains("between 0.0 % and 25.0 %"), "{table}");

    // A wider radius decides earlier, before the planner's fault at 3 s: 120 m − 4 m/s · 3 s = 108 m.
    let wide = Rules::BUILTIN[0].1.replace("radius_m: 10.0", "radius_m: 110.0");
    let again = rescore(tmp.path(), &Rules::parse(&wide, "wide").unwrap()).unwrap();
    let d = &again.records[3];
    assert_eq!((d.outcome, d.fault), (Outcome::Success, None));
    assert!((d.time_s - 2.5).abs() <= 0.01 + 1e-9, "{}", d.time_s);
    assert_eq!((d.ride, d.flags.get(&Flag::Strict)), (None, None), "how it landed by then is not known");
}

#[test]
fn thinned_traces_say_their_resolution_and_keep_the_verdicts_of_the_same_rules() {
    let tmp = tempfile::tempdir().unwrap();
    let rules = Rules::paper();
    let records = make_run(tmp.path(), &rules, TraceMode::TenHz);
    let again = rescore(tmp.path(), &rules).unwrap();
    assert!(!again.exact && (again.resolution_s - 0.1).abs() < 1e-15);
    let outcomes = |r: &[TaskRecord]| r.iter().map(|r| (r.task.clone(), r.outcome)).collect::<Vec<_>>();
    assert_eq!(outcomes(&again.records), outcomes(&records));
    let (thin, full) = (again.records[0].metrics.unwrap(), records[0].metrics.unwrap());
    assert!(thin.samples < full.samples / 9);
    assert!((thin.roll_mean_deg - full.roll_mean_deg).abs() < 0.05 * full.roll_mean_deg);
}

/// Rules with another rollover rule classify failures by the angles in the records, whatever of the traces is kept.
#[test]
fn another_rollover_rule_needs_no_traces() {
    let paper = Rules::paper();
    let with = |rollover: &str| {
        let (head, rest) = Rules::BUILTIN[0].1.split_once("rollover:").unwrap();
        let tail = rest.split_once("out_of_bounds:").unwrap().1;
        let text = format!("{head}{rollover}out_of_bounds:{tail}");
        Rules::parse(&text.replace("name: paper", "name: other"), "other").unwrap()
    };
    // The vehicle leans by 40° after 1 s, then by 10°, and creeps until it is stuck; its pitch is 20°.
    let leans = |time: f64| Sample {
        time,
        x: -60.0 + 0.05 * time,
        roll: vb_math::angle::radians(if (1.0..1.5).contains(&time) { 40.0 } else { 10.0 }),
        pitch: vb_math::angle::radians(20.0),
        ..Sample::default()
    };
    for mode in [TraceMode::TenHz, TraceMode::None, TraceMode::Full] {
        let tmp = tempfile::tempdir().unwrap();
        let store = RunStore::create(tmp.path(), &header(&paper, mode, 3)).unwrap();
        let records = [
            drive(&store, &paper, mode, "w/a", None, leans),
            drive(&store, &paper, mode, "w/b", Some(3.0), leans),
            run(&store, &paper, mode, "w/c", 5.0, None),
        ];
        let outcomes = [Outcome::Stuck, Outcome::PlannerError, Outcome::Success];
        assert_eq!(records.iter().map(|r| r.outcome).collect::<Vec<_>>(), outcomes);
        let again = |rollover: &str| {
            let again = rescore(tmp.path(), &with(rollover)).unwrap();
            assert!(again.summary.undecided.is_empty() && again.exact, "{mode:?}");
            assert_eq!(again.records[0].departures, ["rules other"]);
            again.records
        };
        let any = again("rollover: {when: any_time, roll_limit_deg: 30.0}\n");
        assert_eq!((any[0].outcome, any[0].three_way), (Outcome::Rollover, ThreeWay::Rollover), "{mode:?}");
        assert_eq!(any[0].reason, format!("roll 40.0° at most; {}", records[0].reason));
        assert_eq!((any[1].outcome, any[1].three_way), (Outcome::PlannerError, ThreeWay::Rollover));
        assert_eq!((any[2].outcome, any[2].time_s), (Outcome::Success, records[2].time_s));
        assert_eq!((any[0].time_s, any[0].metrics), (records[0].time_s, records[0].metrics));
        let end = again("rollover: {when: end, roll_limit_deg: 5.0}\n");
        assert_eq!((end[0].outcome, end[1].three_way), (Outcome::Rollover, ThreeWay::Rollover));
        assert_eq!(end[0].reason, format!("roll 10.0° at the end; {}", records[0].reason));
        let none = again("");
        assert_eq!((none[0].outcome, &none[0].reason), (Outcome::Stuck, &records[0].reason));
        // A run that was driven with this rule has the same records but for the names of rules, and comes back to those.
        let tmp = tempfile::tempdir().unwrap();
        let own = with("rollover: {when: any_time, roll_limit_deg: 30.0}\n");
        let store = RunStore::create(tmp.path(), &header(&own, mode, 1)).unwrap();
        let rolled = drive(&store, &own, mode, "w/a", None, leans);
        assert_eq!((rolled.outcome, &rolled.reason), (Outcome::Rollover, &any[0].reason));
        let back = rescore(tmp.path(), &paper).unwrap();
        assert_eq!((back.records[0].outcome, &back.records[0].reason), (Outcome::Stuck, &records[0].reason));
    }
}

/// The vehicle stops so that it has moved less than 1 m in 10 s at a time that full samples see and thinned ones miss by a
/// hair. Its task keeps its verdict, but it is measured by the same samples as all others, so that it weighs no more.
#[test]
fn thinned_traces_pool_the_means_of_the_run() {
    let tmp = tempfile::tempdir().unwrap();
    let rules = Rules::paper();
    let mode = TraceMode::TenHz;
    let head = header(&rules, mode, 2);
    let store = RunStore::create(tmp.path(), &head).unwrap();
    let halts = |time: f64| Sample {
        time,
        x: -60.0 + 5.0 * time.min(5.05),
        roll: if time < 12.0 { 0.5 } else { 0.4 },
        pitch: -0.25,
        ..Sample::default()
    };
    let records =
        vec![run(&store, &rules, mode, "w/a", 2.0, None), drive(&store, &rules, mode, "w/b", None, halts)];
    assert_eq!((records[1].outcome, records[1].time_s), (Outcome::Stuck, 14.86));
    let again = rescore(tmp.path(), &rules).unwrap();
    assert_eq!((again.records[1].outcome, &again.records[1].reason), (Outcome::Stuck, &records[1].reason));
    for (thin, full) in again.records.iter().zip(&records) {
        let (thin, full) = (thin.metrics.unwrap(), full.metrics.unwrap());
        assert!(thin.samples.abs_diff(full.samples / 10) <= 2, "{} of {}", thin.samples, full.samples);
    }
    let own = Summary::new(&head, &rules, &records, Vec::new()).all.unwrap();
    let thin = again.summary.all.unwrap();
    let near = |thin: Option<f64>, own: Option<f64>| {
        let (thin, own) = (thin.unwrap(), own.unwrap());
        assert!((thin - own).abs() < 0.01 * own, "{thin}, the run has {own}");
    };
    near(thin.metrics.roll_mean_deg, own.metrics.roll_mean_deg);
    near(thin.metrics.roll_variance_deg2, own.metrics.roll_variance_deg2);
    near(thin.metrics.pitch_mean_deg, own.metrics.pitch_mean_deg);
    near(thin.metrics.pitch_variance_deg2, own.metrics.pitch_variance_deg2);
    near(thin.metrics.roll_task_mean_deg, own.metrics.roll_task_mean_deg);
}

#[test]
fn without_traces_a_run_can_not_be_scored_again_and_the_message_says_what_to_do() {
    let tmp = tempfile::tempdir().unwrap();
    let records = make_run(tmp.path(), &Rules::paper(), TraceMode::None);
    assert_eq!(rescore(tmp.path(), &Rules::paper()).unwrap().records, records, "its own rules need none");
    let e = rescore(tmp.path(), &Rules::resolve("release").unwrap()).unwrap_err();
    assert!(matches!(e, RescoreError::NoTraces(_)) && e.to_string().contains("--trace full"), "{e}");
}

#[test]
fn a_truncated_or_missing_trace_is_an_error_that_names_it() {
    let tmp = tempfile::tempdir().unwrap();
    make_run(tmp.path(), &Rules::paper(), TraceMode::Full);
    let path = tmp.path().join("traces/w/b.parquet");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let e = rescore(tmp.path(), &Rules::paper()).unwrap_err().to_string();
    assert!(e.contains("b.parquet") && !e.contains('\n'), "{e}");
    std::fs::remove_file(&path).unwrap();
    let e = rescore(tmp.path(), &Rules::paper()).unwrap_err().to_string();
    assert!(e.contains("b.parquet"), "{e}");
}

/// Records of tasks of known figures: `n` samples of constant |roll| each.
fn constant_roll(task: &str, elevation: Elevation, samples: u32, roll_deg: f64, success: bool) -> TaskRecord {
    let mut scorer = Scorer::new(&Rules::paper(), &GEOMETRY);
    for k in 0..samples {
        let last = k + 1 == samples;
        let x = if last && success { 60.0 } else { -60.0 };
        let roll = vb_math::angle::radians(roll_deg);
        scorer.push(&Sample { time: f64::from(k) * 0.01, x, roll, ..Sample::default() });
    }
    let score = if success { scorer.finish().unwrap() } else { scorer.fail(Fault::Planner, "gave up") };
    record(task, elevation, score)
}

fn some_records() -> Vec<TaskRecord> {
    vec![
        constant_roll("w1/t0", Elevation::High, 101, 1.0, true),
        constant_roll("w1/t1", Elevation::High, 301, 1.0, true),
        constant_roll("w2/t0", Elevation::Low, 402, 3.0, false),
        constant_roll("w2/t1", Elevation::Low, 804, 7.0, false),
    ]
}

#[test]
fn what_the_host_failed_counts_for_nobody() {
    let rules = Rules::paper();
    let header = header(&rules, TraceMode::None, 5);
    let mut records = some_records();
    let without = Summary::new(&header, &rules, &records, Vec::new());
    let mut failed = records[0].clone();
    failed.task = "w9/t9".parse().unwrap();
    failed.outcome = Outcome::HostError;
    failed.fault = Some(FaultCode::Machine);
    records.push(failed);
    let with = Summary::new(&header, &rules, &records, Vec::new());
    assert_eq!(with.host_errors, ["w9/t9"]);
    assert_eq!((&with.all, &with.world, &with.terrain), (&without.all, &without.world, &without.terrain));
    assert_eq!((without.missing(), with.missing()), (1, 0));
    assert!(with.table(None).contains("1 failed because of the harness or the machine, not counted above"));
}

#[test]
fn a_summary_counts_and_averages_as_documented() {
    let rules = Rules::paper();
    let summary = Summary::new(&header(&rules, TraceMode::None, 5), &rules, &some_records(), Vec::new());
    let all = summary.all.as_ref().unwrap();
    let near = |got: Option<f64>, want: f64| assert!((got.unwrap() - want).abs() < 1e-9, "{got:?} {want}");
    assert_eq!((all.tasks, summary.missing()), (4, 1));
    assert_eq!(all.success_rate, 0.5);
    // One of two worlds succeeds in all tasks and one in none: a quarter of the draws is of either alone.
    assert_eq!((all.success_low, all.success_high), (Some(0.0), Some(1.0)));
    assert_eq!(summary.world["w1"].success_low, None, "one world tells nothing of how worlds differ");
    // Successes at 1.00 s and 3.00 s.
    near(all.time_mean_s, 2.0);
    near(all.time_std_s, 1.0);
    // 402 samples of 1°, 402 of 3°, 804 of 7°: mean (1 + 3 + 14) / 4, mean square (1 + 9 + 98) / 4.
    near(all.metrics.roll_mean_deg, 4.5);
    near(all.metrics.roll_variance_deg2, 27.0 - 20.25);
    near(all.metrics.roll_max_deg, 7.0);
    near(all.metrics.roll_task_mean_deg, (1.0 + 1.0 + 3.0 + 7.0) / 4.0);
    assert_eq!(all.outcomes[&Outcome::PlannerError], 2);
    assert_eq!(all.three_way[&ThreeWay::Stuck], 2);
    // No roll above 30°; a shock in each, so no success is a strict one.
    let flags = [(Flag::Tilted, 0), (Flag::Strict, 0), (Flag::Shock, 4), (Flag::Power, 0)];
    assert_eq!(all.flags, BTreeMap::from(flags));
    assert_eq!((all.ride["seat_peak_z_g"], all.ride["airborne_fraction"]), (3.0, 0.25));
    assert!(!all.ride.contains_key("held_fraction") && !all.ride.contains_key("landed"));
    assert_eq!(all.outcomes.values().sum::<u64>(), 4);
    assert_eq!(
        (all.clamped, all.fuel),
        (4, Some(FuelUse { total: 400, max_step: 20, ..FuelUse::default() }))
    );
    assert_eq!(summary.elevation.keys().copied().collect::<Vec<_>>(), [Elevation::Low, Elevation::High]);
    let high = &summary.elevation[&Elevation::High];
    assert_eq!((high.tasks, high.success_rate), (2, 1.0));
    near(high.metrics.roll_variance_deg2, 0.0);
    assert_eq!(summary.elevation[&Elevation::Low].time_mean_s, None);
    assert_eq!(summary.world.len(), 2);
}

#[test]
fn a_summary_does_not_depend_on_the_order_of_the_tasks() {
    let rules = Rules::paper();
    let head = header(&rules, TraceMode::None, 4);
    let mut stream = Stream::new(1, &["order"]);
    // Figures whose sums depend on the order of summation in their last bits.
    let mut records: Vec<TaskRecord> = (0..40)
        .map(|i| {
            let mut r = constant_roll(&format!("w{}/t{i:02}", i % 3), Elevation::Low, 10, 1.0, i % 2 == 0);
            let m = r.metrics.as_mut().unwrap();
            m.roll_mean_deg = stream.uniform(0.0, 20.0);
            m.roll_variance_deg2 = stream.uniform(0.0, 90.0);
            m.distance_m = stream.uniform(0.0, 200.0);
            r.time_s = stream.uniform(10.0, 60.0);
            r
        })
        .collect();
    let want = serde_json::to_string(&Summary::new(&head, &rules, &records, Vec::new())).unwrap();
    for _ in 0..5 {
        stream.shuffle(&mut records);
        assert_eq!(serde_json::to_string(&Summary::new(&head, &rules, &records, Vec::new())).unwrap(), want);
    }
}

#[test]
fn records_and_summaries_read_back_as_written() {
    let rules = Rules::paper();
    let records = some_records();
    let summary =
        Summary::new(&header(&rules, TraceMode::None, 4), &rules, &records, vec!["w9/t9".parse().unwrap()]);
    let text = serde_json::to_string(&summary).unwrap();
    assert_eq!(serde_json::from_str::<Summary>(&text).unwrap(), summary);
    for r in records {
        assert_eq!(serde_json::from_str::<TaskRecord>(&serde_json::to_string(&r).unwrap()).unwrap(), r);
    }
}

#[test]
fn a_run_without_a_finished_task_has_an_empty_summary_and_a_table() {
    let rules = Rules::paper();
    let summary = Summary::new(&header(&rules, TraceMode::None, 7), &rules, &[], Vec::new());
    assert!(summary.all.is_none());
    assert!(summary.table(None).contains("7 of 7 tasks pending"));
    serde_json::to_string(&summary).unwrap();
}

#[test]
fn the_table_has_a_row_for_each_level_and_aligned_columns() {
    let rules = Rules::paper();
    let table =
        Summary::new(&header(&rules, TraceMode::None, 4), &rules, &some_records(), Vec::new()).table(None);
    let lines: Vec<&str> = table.lines().collect();
    let names: Vec<&str> = lines[1..6].iter().map(|l| l[..15].trim()).collect();
    assert_eq!(names, ["all", "elevation low", "elevation high", "terrain rigid", "density sparse"]);
    assert!(lines[1].contains("50.0 (0.0-100.0)"), "{table}");
    let width = |l: &str| l.chars().count();
    assert!(lines[..6].iter().all(|l| width(l) == width(lines[0])), "{table}");
    assert!(table.contains("pid 1.0.0 on suite; rules: paper"), "{table}");
}
