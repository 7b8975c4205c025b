//! A run directory survives what happens to it, and says what is wrong with it.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use vb_record::{
    DataHeader, DebugSeries, LogMode, PluginHeader, PluginKind, RUN_SCHEMA, RulesHeader, RunHeader,
    RunJoiner, RunReader, RunStore, Sample, ShardHeader, StoreError, SuiteHeader, TRACE_SCHEMA, Trace,
    TraceMeta, TraceMode, TraceRecorder,
};
use vb_world::TaskId;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Record {
    task: TaskId,
    value: f64,
    #[serde(default)]
    text: String,
}

fn id(task: &str) -> TaskId {
    task.parse().unwrap()
}

fn record(task: &str, value: f64) -> Record {
    Record { task: id(task), value, text: String::new() }
}

fn header() -> RunHeader {
    RunHeader {
        schema: RUN_SCHEMA,
        harness_version: "0.1.0".into(),
        harness_commit: "unknown".into(),
        started_at: "2026-01-01T00:00:00Z".into(),
        suite: SuiteHeader { name: "s".into(), hash: "aa".into(), path: "tasks/s".into(), tasks: 9 },
        selector: None,
        shard: None,
        tasks: 3,
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
        params: BTreeMap::from([("speed".into(), "3".into())]),
        vehicle: DataHeader { name: "hmmwv".into(), hash: "cc".into() },
        soils: DataHeader { name: "default".into(), hash: "dd".into() },
        perception: DataHeader { name: "oracle".into(), hash: "ee".into() },
        scale: 1.0 / 6.0,
        seed: u64::MAX,
        time_step: 0.001,
        soil_resolution: 0.1,
        sample_period: 0.01,
        rules: RulesHeader {
            name: "paper".into(),
            hash: "dd".into(),
            profile: serde_json::json!({"radius": 10.0}),
        },
        limits: BTreeMap::from([("memory_bytes".into(), 1 << 28)]),
        trace: TraceMode::Full,
        logs: LogMode::default(),
    }
}

fn trace(task: &str) -> Trace {
    let mut recorder = TraceRecorder::new(TraceMode::Full, 0);
    recorder.push(&Sample::default(), &[]);
    recorder
        .finish(TraceMeta {
            schema: TRACE_SCHEMA,
            task: id(task),
            start: [0.0; 3],
            goal: [1.0, 0.0],
            goal_z: 0.0,
            half_extent: [64.0, 64.0],
            scale: 1.0,
            max_speed: 30.0,
            time_step: 0.001,
            sample_period: 0.01,
            mode: TraceMode::Full,
        })
        .unwrap()
}

fn resume(dir: &Path) -> Result<(RunStore, Vec<Record>), StoreError> {
    RunStore::resume(dir, &header(), |_| true)
}

#[test]
fn what_is_written_reads_back() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("a/b");
    let store = RunStore::create(&dir, &header()).unwrap();
    let trace = trace("w001/t00");
    store.write_trace(&trace).unwrap();
    let mut debug = DebugSeries::default();
    debug.push(0.0, "cost", &[1.0]);
    store.write_debug(&id("w001/t00"), &debug).unwrap();
    // 1/3 and a neighbour of 0.1: figures must read back to the same bits, else a resumed summary would differ.
    let records = [record("w001/t00", 1.0 / 3.0), record("w001/t01", f64::from_bits(0.1f64.to_bits() + 1))];
    for r in &records {
        store.append(r).unwrap();
    }
    store.finish(&records[0]).unwrap();

    // Reading doesn't need the lock.
    let reader = RunReader::open(&dir).unwrap();
    assert_eq!(reader.header(), &header());
    assert_eq!(reader.records::<Record>().unwrap(), records);
    assert!(reader.has_trace(&id("w001/t00")).unwrap() && !reader.has_trace(&id("w001/t01")).unwrap());
    assert_eq!(reader.trace(&id("w001/t00")).unwrap(), trace);
    assert!(dir.join("traces/w001/t00.debug.parquet").exists() && dir.join("summary.json").exists());
}

/// All files of a folder by their names.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    fn add(dir: &Path, root: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in fs::read_dir(dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                add(&path, root, found);
            } else {
                let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    let mut found = BTreeMap::new();
    add(dir, dir, &mut found);
    found
}

/// A run of these tasks, driven in this order.
fn driven(dir: &Path, tasks: &[&str]) -> RunStore {
    let store = RunStore::create(dir, &header()).unwrap();
    for task in tasks {
        store.write_trace(&trace(task)).unwrap();
        let mut debug = DebugSeries::default();
        debug.push(0.0, "cost", &[1.0]);
        store.write_debug(&id(task), &debug).unwrap();
        store.append(&record(task, 1.0)).unwrap();
    }
    store
}

#[test]
fn a_whole_run_has_the_same_bytes_in_whichever_order_its_tasks_ended() {
    let tmp = tempfile::tempdir().unwrap();
    let tasks = ["w1/a", "w1/b", "w2/a"];
    let order = tasks.map(id);
    let found = [[0, 1, 2], [2, 0, 1], [1, 2, 0]].map(|places| {
        let dir = tmp.path().join(format!("{places:?}"));
        driven(&dir, &places.map(|k| tasks[k])).finish_whole(&order, &"summary").unwrap();
        let done = RunReader::open(&dir).unwrap().records::<Record>().unwrap();
        assert_eq!(done.iter().map(|r| r.task.as_str()).collect::<Vec<_>>(), tasks);
        files(&dir)
    });
    assert_eq!(found[0].len(), 5 + 6);
    assert!(found.iter().all(|f| *f == found[0]));
    // It can still be gone on with, and be ended again.
    let dir = tmp.path().join("[0, 1, 2]");
    resume(&dir).unwrap().0.finish_whole(&order, &"summary").unwrap();
    assert_eq!(files(&dir), found[0]);
}

#[test]
fn a_run_that_is_joined_of_others_has_the_bytes_of_one_that_was_driven() {
    let tmp = tempfile::tempdir().unwrap();
    let [first, second, one, joined] = ["first", "second", "one", "joined"].map(|name| tmp.path().join(name));
    let order = ["w1/a", "w1/b", "w2/a"].map(id);
    driven(&one, &["w1/a", "w1/b", "w2/a"]).finish_whole(&order, &"summary").unwrap();
    drop((driven(&first, &["w2/a", "w1/a"]), driven(&second, &["w1/b"])));
    let parts = [&first, &second].map(|dir| RunReader::open(dir).unwrap());
    let join = || {
        let mut joiner = RunJoiner::new(&joined, &header())?;
        for task in &order {
            let mut lines = BTreeMap::new();
            for (k, part) in parts.iter().enumerate() {
                part.each_line(|r: Record, line| drop(lines.insert(r.task, (line.to_vec(), k)))).unwrap();
            }
            let (line, k) = &lines[task];
            joiner.add(task, line, &parts[*k])?;
        }
        joiner.finish(&"summary")
    };
    join().unwrap();
    assert_eq!(files(&joined), files(&one));
    assert!(matches!(join().unwrap_err(), StoreError::Taken(_)));

    // A damaged trace isn't handed on, and nothing is left behind.
    fs::remove_dir_all(&joined).unwrap();
    fs::write(second.join("traces/w1/b.parquet"), "?").unwrap();
    assert!(join().unwrap_err().to_string().contains("another checksum"));
    let left: Vec<_> = fs::read_dir(tmp.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn a_file_that_is_lost_in_a_part_is_not_lost_in_silence() {
    let tmp = tempfile::tempdir().unwrap();
    let (part, joined) = (tmp.path().join("part"), tmp.path().join("joined"));
    drop(driven(&part, &["w1/a"]));
    let join = || {
        let run = RunReader::open(&part).unwrap();
        let mut joiner = RunJoiner::new(&joined, &header())?;
        let mut line = Vec::new();
        run.each_line(|_: Record, own| line = own.to_vec()).unwrap();
        joiner.add(&id("w1/a"), &line, &run)?;
        joiner.finish(&"summary")
    };
    for lost in ["traces/w1/a.parquet", "traces/w1/a.debug.parquet"] {
        let kept = fs::read(part.join(lost)).unwrap();
        fs::remove_file(part.join(lost)).unwrap();
        let e = join().unwrap_err().to_string();
        assert!(e.contains(lost) && e.contains("missing") && e.contains("checksums.txt"), "{e}");
        assert!(!joined.exists());
        let reader = RunReader::open(&part).unwrap();
        assert!(reader.has_trace(&id("w1/a")).is_err() || reader.debug(&id("w1/a")).is_err(), "{lost}");
        fs::write(part.join(lost), kept).unwrap();
    }
    // Who removes files on purpose removes what tells of them, too.
    fs::remove_file(part.join("traces/w1/a.parquet")).unwrap();
    fs::remove_file(part.join("checksums.txt")).unwrap();
    join().unwrap();
    assert!(!joined.join("traces/w1/a.parquet").exists());
    assert!(joined.join("traces/w1/a.debug.parquet").exists());
}

#[test]
fn two_who_join_into_one_directory_do_not_spoil_it() {
    let tmp = tempfile::tempdir().unwrap();
    let joined = tmp.path().join("joined");
    let first = RunJoiner::new(&joined, &header()).unwrap();
    assert!(matches!(RunJoiner::new(&joined, &header()).unwrap_err(), StoreError::Locked(_)));
    first.finish(&"summary").unwrap();
    assert_eq!(RunReader::open(&joined).unwrap().header(), &header());
}

#[test]
fn a_directory_with_something_in_it_is_refused_and_left_as_it_was() {
    let tmp = tempfile::tempdir().unwrap();
    fs::write(tmp.path().join("thesis.tex"), "x").unwrap();
    let e = RunStore::create(tmp.path(), &header()).unwrap_err();
    assert!(matches!(e, StoreError::NotEmpty(_)), "{e}");
    assert!(e.to_string().contains("--resume"), "{e}");
    assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 1);

    let run = tmp.path().join("run");
    drop(RunStore::create(&run, &header()).unwrap());
    assert!(matches!(RunStore::create(&run, &header()).unwrap_err(), StoreError::NotEmpty(_)));
}

#[test]
fn one_run_has_one_writer() {
    let tmp = tempfile::tempdir().unwrap();
    let store = RunStore::create(tmp.path(), &header()).unwrap();
    assert!(matches!(resume(tmp.path()).unwrap_err(), StoreError::Locked(_)));
    assert!(matches!(RunStore::create(tmp.path(), &header()).unwrap_err(), StoreError::Locked(_)));
    drop(store);
    resume(tmp.path()).unwrap();
}

#[test]
fn a_torn_last_line_is_cut_away_and_its_task_counts_as_not_done() {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("tasks.jsonl");
    let store = RunStore::create(tmp.path(), &header()).unwrap();
    store.append(&record("w/a", 1.0)).unwrap();
    store.append(&record("w/b", 2.0)).unwrap();
    drop(store);
    let whole = fs::read(&path).unwrap();
    let first = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
    // Cut anywhere within the second line (its end included), or with it overwritten by what a power cut leaves.
    let mut cases: Vec<Vec<u8>> = (first..whole.len()).map(|n| whole[..n].to_vec()).collect();
    cases.push([&whole[..first], &[0; 40]].concat());
    for torn in cases {
        fs::write(&path, &torn).unwrap();
        assert_eq!(RunReader::open(tmp.path()).unwrap().records::<Record>().unwrap(), [record("w/a", 1.0)]);
        let (store, done) = resume(tmp.path()).unwrap();
        assert_eq!(done, [record("w/a", 1.0)]);
        store.append(&record("w/b", 2.0)).unwrap();
        drop(store);
        assert_eq!(fs::read(&path).unwrap(), whole);
    }
}

#[test]
fn damage_in_the_middle_and_a_task_twice_are_errors_that_name_the_line() {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("tasks.jsonl");
    drop(RunStore::create(tmp.path(), &header()).unwrap());
    // Changed by hand, as its owner may: he deletes the checksums.
    fs::remove_file(tmp.path().join("checksums.txt")).unwrap();
    fs::write(
        &path,
        "{\"task\":\"w/a\",\"value\":1}\n{\"task\":\"w/b\",\"val\n{\"task\":\"w/c\",\"value\":1}\n",
    )
    .unwrap();
    let text = resume(tmp.path()).unwrap_err().to_string();
    assert!(text.contains("tasks.jsonl: line 2:") && !text.contains('\n'), "{text}");
    fs::write(&path, "{\"task\":\"w/a\",\"value\":1}\n{\"task\":\"w/a\",\"value\":2}\n").unwrap();
    let text = resume(tmp.path()).unwrap_err().to_string();
    assert!(text.contains("line 2: task w/a is a duplicate"), "{text}");
}

#[test]
fn a_run_is_resumed_only_with_its_own_settings_and_the_difference_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    drop(RunStore::create(tmp.path(), &header()).unwrap());
    let mut same = header();
    same.started_at = "2027-01-01T00:00:00Z".into();
    same.plugin.path = "elsewhere/pid.wasm".into();
    same.suite.path = "elsewhere".into();
    RunStore::resume::<Record>(tmp.path(), &same, |_| true).unwrap();

    type Change = fn(&mut RunHeader);
    let changes: [(&str, Change); 11] = [
        ("suite.hash", |h| h.suite.hash = "x".into()),
        ("plugin.sha256", |h| h.plugin.sha256 = "x".into()),
        ("params.speed", |h| h.params = BTreeMap::from([("speed".into(), "5".into())])),
        ("params.kp", |h| h.params.extend([("kp".into(), "2".into())])),
        ("seed", |h| h.seed -= 1),
        ("rules.hash", |h| {
            h.rules.hash = "x".into();
            h.rules.profile = serde_json::json!({"radius": 8.0});
        }),
        ("limits.memory_bytes", |h| h.limits = BTreeMap::from([("memory_bytes".into(), 5)])),
        ("vehicle.hash", |h| h.vehicle.hash = "x".into()),
        ("selector", |h| h.selector = Some("w001".into())),
        ("trace", |h| h.trace = TraceMode::None),
        ("shard.index", |h| h.shard = Some(ShardHeader { index: 1, of: 2, tasks: 9 })),
    ];
    for (want, change) in changes {
        let mut other = header();
        change(&mut other);
        match RunStore::resume::<Record>(tmp.path(), &other, |_| true).unwrap_err() {
            StoreError::Differs { field, .. } => assert_eq!(field, want),
            e => panic!("{want}: {e}"),
        }
    }
}

#[test]
fn resuming_where_there_is_no_run_says_so() {
    let tmp = tempfile::tempdir().unwrap();
    assert!(matches!(resume(tmp.path()).unwrap_err(), StoreError::NoRun(_)));
    assert!(matches!(RunReader::open(&tmp.path().join("none")).unwrap_err(), StoreError::NoRun(_)));
    assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 0);
}

#[test]
fn records_that_do_not_count_are_run_again_and_leave_no_line() {
    let tmp = tempfile::tempdir().unwrap();
    let store = RunStore::create(tmp.path(), &header()).unwrap();
    let records = [record("w001/t00", 1.0), record("w001/t01", -1.0), record("w001/t02", 2.0)];
    records.iter().for_each(|r| store.append(r).unwrap());
    drop(store);
    let counts = |r: &Record| r.value > 0.0;
    let (store, found) = RunStore::resume(tmp.path(), &header(), counts).unwrap();
    assert_eq!(found, [records[0].clone(), records[2].clone()]);
    // Its place is free again, behind the others.
    store.append(&record("w001/t01", 3.0)).unwrap();
    drop(store);
    let order: Vec<f64> =
        RunReader::open(tmp.path()).unwrap().records::<Record>().unwrap().iter().map(|r| r.value).collect();
    assert_eq!(order, [1.0, 2.0, 3.0]);
}

#[test]
fn a_run_of_another_schema_or_a_broken_header_is_refused() {
    let tmp = tempfile::tempdir().unwrap();
    drop(RunStore::create(tmp.path(), &header()).unwrap());
    let path = tmp.path().join("run.json");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("\"schema\": 3", "\"schema\": 9")).unwrap();
    assert!(matches!(RunReader::open(tmp.path()).unwrap_err(), StoreError::Schema { found: 9, .. }));
    fs::write(&path, &text[..text.len() / 2]).unwrap();
    let e = RunReader::open(tmp.path()).unwrap_err();
    assert!(matches!(e, StoreError::Damaged { .. }) && e.to_string().contains("run.json"), "{e}");
}

/// It is a text that people can edit, and a step or a scale of 0 would keep a simulation busy for ever.
#[test]
fn a_setting_that_no_run_can_have_is_named_with_what_is_allowed() {
    let tmp = tempfile::tempdir().unwrap();
    drop(RunStore::create(tmp.path(), &header()).unwrap());
    fs::remove_file(tmp.path().join("checksums.txt")).unwrap();
    let path = tmp.path().join("run.json");
    let text = fs::read_to_string(&path).unwrap();
    let shard = |index: u32, of: u32, tasks: u64| {
        format!("\"tasks\": 3, \"shard\": {{\"index\": {index}, \"of\": {of}, \"tasks\": {tasks}}}")
    };
    let whole = "\"tasks\": 3";
    let scale = "\"scale\": 0.16666666666666666";
    let cases = [
        (scale, "\"scale\": 0".to_owned(), "scale: 0 must lie in 0.01 to 10"),
        (scale, "\"scale\": 1e300".to_owned(), "must lie in 0.01 to 10"),
        ("\"time_step\": 0.001", "\"time_step\": 0".to_owned(), "time_step: 0 must lie in 0.0001 to 0.005"),
        ("\"time_step\": 0.001", "\"time_step\": 0.003".to_owned(), "divide sample_period, 0.01"),
        ("\"sample_period\": 0.01", "\"sample_period\": -1".to_owned(), "sample_period: -1 must lie in"),
        ("\"soil_resolution\": 0.1", "\"soil_resolution\": 1e-9".to_owned(), "soil_resolution: 0.000000001"),
        ("\"control_period\": 0.1", "\"control_period\": 0.0".to_owned(), "plugin.control_period: 0"),
        (whole, shard(0, 2, 6), "shard.index: 0 must be at least 1"),
        (whole, shard(3, 2, 6), "shard.index: 3 must not exceed shard.of, 2"),
        (whole, shard(1, 2, 2), "tasks: 3 must not exceed shard.tasks, 2"),
        ("\"tasks\": 9", "\"tasks\": 2".to_owned(), "tasks: 3 must not exceed suite.tasks, 2"),
    ];
    for (old, new, says) in cases {
        assert!(text.contains(old), "{old}");
        fs::write(&path, text.replace(old, &new)).unwrap();
        let e = RunReader::open(tmp.path()).unwrap_err();
        assert!(matches!(e, StoreError::Damaged { .. }), "{new}: {e}");
        assert!(e.to_string().contains("run.json") && e.to_string().contains(says), "{new}: {e}");
    }
    fs::write(&path, text.replace(whole, &shard(1, 2, 6))).unwrap();
    assert!(RunReader::open(tmp.path()).is_ok());
}

#[test]
fn task_names_cannot_lead_out_of_the_run_directory() {
    let tmp = tempfile::tempdir().unwrap();
    drop(driven(tmp.path(), &["w/a"]));
    fs::remove_file(tmp.path().join("checksums.txt")).unwrap();
    for name in ["../evil", "w/../../x", "w", "/t", "w/", "w/a b", "w\\\\a/t", ".w/t"] {
        let lines = format!("{{\"task\":\"{name}\",\"value\":1}}\n{{\"task\":\"w/a\",\"value\":1}}\n");
        fs::write(tmp.path().join("tasks.jsonl"), lines).unwrap();
        let e = RunReader::open(tmp.path()).unwrap().records::<Record>().unwrap_err().to_string();
        assert!(
            e.contains(&format!("tasks.jsonl: line 1: task: \"{name}\" is not the name of a task")),
            "{e}"
        );
    }
}

#[test]
fn a_path_that_can_not_be_written_is_an_error_with_advice() {
    let tmp = tempfile::tempdir().unwrap();
    let file = tmp.path().join("file");
    fs::write(&file, "x").unwrap();
    let text = RunStore::create(&file.join("run"), &header()).unwrap_err().to_string();
    assert!(text.contains("cannot make directory") && text.contains("--out"), "{text}");
}

/// Mounts a small tmpfs, which takes root; unmounted on drop.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn new(bytes: u32) -> Option<Self> {
        let dir = tempfile::tempdir().unwrap();
        let ok = std::process::Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={bytes}"), "tmpfs"])
            .arg(dir.path())
            .output()
            .is_ok_and(|o| o.status.success());
        ok.then_some(Self(dir))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount").arg(self.0.path()).output();
    }
}

#[test]
fn results_before_a_full_disk_survive_and_the_run_goes_on_when_there_is_room() {
    let Some(disk) = SmallDisk::new(64 * 1024) else {
        vb_testing::skip("mounting a small file system takes root");
        return;
    };
    let dir = disk.0.path().join("run");
    let store = RunStore::create(&dir, &header()).unwrap();
    store.append(&record("w/a", 1.0)).unwrap();
    let ballast = disk.0.path().join("ballast");
    while fs::OpenOptions::new().append(true).create(true).open(&ballast).is_ok_and(|mut f| {
        use std::io::Write as _;
        f.write_all(&[0; 4096]).is_ok()
    }) {}
    let long = Record { text: "b".repeat(8000), ..record("w/b", 2.0) };
    let e = store.append(&long).unwrap_err();
    assert!(e.is_disk_full(), "{e}");
    assert!(store.write_trace(&trace("w/b")).unwrap_err().is_disk_full());
    assert_eq!(RunReader::open(&dir).unwrap().records::<Record>().unwrap(), [record("w/a", 1.0)]);
    fs::remove_file(&ballast).unwrap();
    store.append(&long).unwrap();
    drop(store);
    assert_eq!(resume(&dir).unwrap().1, [record("w/a", 1.0), long]);
}

#[test]
fn a_bit_that_was_flipped_anywhere_is_found_by_whoever_reads_it() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path().join("run");
    let store = RunStore::create(&dir, &header()).unwrap();
    let mut debug = DebugSeries::default();
    debug.push(0.0, "cost", &[1.0, 2.0]);
    for task in ["w001/t00", "w001/t01"] {
        store.write_trace(&trace(task)).unwrap();
        store.write_debug(&id(task), &debug).unwrap();
        store.append(&record(task, 1.0 / 3.0)).unwrap();
    }
    drop(store);
    let read = || -> Result<usize, StoreError> {
        let reader = RunReader::open(&dir)?;
        let records = reader.records::<Record>()?;
        for r in &records {
            reader.trace(&r.task)?;
            reader.debug(&r.task)?;
        }
        Ok(records.len())
    };
    assert_eq!(read().unwrap(), 2);
    let files = [
        "run.json",
        "tasks.jsonl",
        "checksums.txt",
        "traces/w001/t00.parquet",
        "traces/w001/t00.debug.parquet",
    ];
    let mut accepted = Vec::new();
    for file in files {
        let path = dir.join(file);
        let whole = fs::read(&path).unwrap();
        for k in 0..200 {
            let mut flipped = whole.clone();
            let at = k * whole.len() / 200;
            flipped[at] ^= 1 << (k % 8);
            fs::write(&path, &flipped).unwrap();
            match read() {
                // A last line without its end is what a killed process leaves: its task counts as not done.
                Ok(1) if file == "tasks.jsonl" && flipped.last() != Some(&b'\n') => {}
                Ok(_) => accepted.push((file, at)),
                Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
            }
        }
        fs::write(&path, &whole).unwrap();
    }
    assert!(accepted.is_empty(), "{accepted:?}");
    assert_eq!(read().unwrap(), 2);
}

#[test]
fn a_run_without_checksums_is_gone_on_with_and_has_them_from_then_on() {
    let tmp = tempfile::tempdir().unwrap();
    let store = RunStore::create(tmp.path(), &header()).unwrap();
    store.append(&record("w/a", 1.0)).unwrap();
    drop(store);
    fs::remove_file(tmp.path().join("checksums.txt")).unwrap();
    let (store, done) = resume(tmp.path()).unwrap();
    assert_eq!(done, [record("w/a", 1.0)]);
    store.append(&record("w/b", 2.0)).unwrap();
    drop(store);
    assert_eq!(RunReader::open(tmp.path()).unwrap().records::<Record>().unwrap().len(), 2);
    let path = tmp.path().join("tasks.jsonl");
    let changed = fs::read_to_string(&path).unwrap().replace("w/a", "w/c");
    fs::write(&path, changed).unwrap();
    assert!(RunReader::open(tmp.path()).and_then(|run| run.records::<Record>()).is_err());
}

#[test]
fn what_a_kill_leaves_of_checksums_is_gone_on_with() {
    let tmp = tempfile::tempdir().unwrap();
    let store = RunStore::create(tmp.path(), &header()).unwrap();
    store.append(&record("w/a", 1.0)).unwrap();
    drop(store);
    let path = tmp.path().join("checksums.txt");
    // Killed within the checksum of a task that is not recorded yet.
    let mut torn = fs::read(&path).unwrap();
    torn.extend_from_slice(b"0123456789abcdef");
    fs::write(&path, &torn).unwrap();
    let (store, done) = resume(tmp.path()).unwrap();
    assert_eq!(done, [record("w/a", 1.0)]);
    store.append(&record("w/b", 2.0)).unwrap();
    drop(store);
    assert_eq!(RunReader::open(tmp.path()).unwrap().records::<Record>().unwrap().len(), 2);
    // Killed before run.json was there.
    fs::remove_file(tmp.path().join("run.json")).unwrap();
    fs::remove_file(tmp.path().join("tasks.jsonl")).unwrap();
    drop(RunStore::create(tmp.path(), &header()).unwrap());
    RunReader::open(tmp.path()).unwrap();
}
