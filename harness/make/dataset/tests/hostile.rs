//! Invalid values in an untrusted dataset are refused with field and value, or reported as findings.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;
#[path = "common/place.rs"]
mod place;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float32Array, Int64Array, RecordBatch, StringArray};
use common::header;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use place::{LAYOUT, Place, episode};
use vb_dataset::{Dataset, DatasetWriter, Dtype, Episode, EpisodeInfo, Values, merge, validate};

impl Place {
    /// A dataset of one episode, changed before it is written: all its hashes are right.
    fn made(&self, name: &str, change: impl FnOnce(&mut Episode)) -> PathBuf {
        let out = self.path(name);
        let mut writer =
            DatasetWriter::create(&out, header("made", LAYOUT, &self.suite), &self.suite, 10).unwrap();
        let mut own = episode(&self.suite, 0);
        change(&mut own);
        writer.add(&own).unwrap();
        writer.finish().unwrap();
        out
    }
}

fn findings(dir: &Path) -> String {
    validate(dir, &[]).unwrap().0.join("\n")
}

fn refused(dir: &Path) -> String {
    Dataset::open(dir).err().map_or_else(|| "it was opened".into(), |e| e.to_string())
}

#[test]
fn an_honest_dataset_is_as_it_should_be() {
    let place = Place::new();
    assert_eq!(findings(&place.made("good", |_| {})), "");
}

#[test]
fn numbers_that_no_vehicle_has_are_findings() {
    let place = Place::new();
    let mut tried = 0;
    for (k, feature) in LAYOUT.features().into_iter().enumerate() {
        if feature.dtype != Dtype::F32 {
            continue;
        }
        for (n, value) in [1e38, -1e38, 1e10, f32::INFINITY, f32::NAN].into_iter().enumerate() {
            let out = place.made(&format!("f{k}-{n}"), |e| {
                let Values::F32(values) = &mut e.columns[k] else { return };
                let last = values.len() - 1;
                values[last] = value;
            });
            let text = findings(&out);
            assert!(text.contains(feature.name), "{} = {value}: {text}", feature.name);
            tried += 1;
        }
    }
    assert!(tried >= 30, "{tried}");
    let action = LAYOUT.features().iter().position(|f| f.name == "action").unwrap();
    let out = place.made("steering", |e| e.columns[action] = Values::F32(vec![1.5; 8]));
    let told = "episode 0: action steering: 1.5 of frame 0 must lie in -1 to 1";
    assert_eq!(findings(&out), told);
    // Nobody who reads the episodes gets them, and no dataset is made of them.
    let good = place.made("good", |e| e.info.state_hash = "1".repeat(16));
    let [good, odd] = [good, out].map(|dir| Dataset::open(&dir).unwrap());
    assert!(odd.episodes().next().unwrap().unwrap_err().to_string().contains(told));
    let merged = place.path("merged");
    let refused = merge(&[good, odd], &merged, None, Vec::new()).unwrap_err().to_string();
    assert!(refused.contains(told) && refused.contains("steering/data/"), "{refused}");
    assert!(!merged.exists());
    let ground = LAYOUT.features().iter().position(|f| f.name == "truth.ground").unwrap();
    let out = place.made("ground", |e| e.columns[ground] = Values::I64(vec![i64::MAX; 2]));
    assert!(findings(&out).contains("truth.ground: "), "{}", findings(&out));
}

#[test]
fn frames_are_counted_and_timed_as_they_come() {
    let place = Place::new();
    for (k, column) in ["index", "frame_index", "episode_index", "task_index"].into_iter().enumerate() {
        let out = place.made(&format!("n{k}"), |_| {});
        edit(&out.join("data/chunk-000/file-000.parquet"), column, i64::MAX);
        assert!(findings(&out).contains("\nepisode 0: "), "{column}: {}", findings(&out));
    }
    let out = place.made("time", |_| {});
    edit_to(&out.join("data/chunk-000/file-000.parquet"), "timestamp", |rows| {
        Arc::new(Float32Array::from(vec![f32::NAN; rows]))
    });
    assert!(findings(&out).contains("timestamp NaN of frame 0 is not 0"), "{}", findings(&out));
}

type Change = fn(&mut EpisodeInfo);

#[test]
fn what_is_said_of_an_episode_is_known_or_possible() {
    let place = Place::new();
    let texts = [
        ("outcome", "won", "unknown variant `won`"),
        ("cause", "x", "unknown variant `x`"),
        ("elevation", "", "unknown variant ``"),
        ("terrain", "x", "unknown variant `x`"),
        ("density", "x", "unknown variant `x`"),
        ("ground", "x", "unknown variant `x`"),
        ("task", "../t00", "\"../t00\" is not the name of a task"),
    ];
    for (column, value, problem) in texts {
        let out = place.made(column, |_| {});
        edit_to(&out.join("meta/episodes/chunk-000/file-000.parquet"), column, |rows| {
            Arc::new(StringArray::from(vec![value; rows]))
        });
        let want = format!("file-000.parquet: row 0: {column}: {problem}");
        assert!(refused(&out).contains(&want), "{want}: {}", refused(&out));
        assert!(findings(&out).contains(&want), "{want}: {}", findings(&out));
    }
    let cases: [(&str, Change); 5] = [
        ("time_s: 1e308", |i| i.time_s = 1e308),
        ("distance_m: -1", |i| i.distance_m = -1.0),
        ("start: 1e308", |i| i.start[2] = 1e308),
        ("goal: -1e308", |i| i.goal[0] = -1e308),
        ("a text of 5000 bytes", |i| i.instruction = "x".repeat(5000)),
    ];
    for (k, (want, change)) in cases.into_iter().enumerate() {
        let out = place.made(&format!("i{k}"), |e| change(&mut e.info));
        assert!(refused(&out).contains(want), "{want}: {}", refused(&out));
        assert!(findings(&out).contains(want), "{want}: {}", findings(&out));
    }
}

/// Writes a file of a dataset again, with one column changed.
fn edit(path: &Path, column: &str, value: i64) {
    edit_to(path, column, |rows| Arc::new(Int64Array::from(vec![value; rows])));
}

fn edit_to(path: &Path, column: &str, values: impl FnOnce(usize) -> ArrayRef) {
    let table = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let rows = table.build().unwrap().next().unwrap().unwrap();
    let (at, _) = rows.schema().column_with_name(column).unwrap();
    let mut columns = rows.columns().to_vec();
    columns[at] = values(rows.num_rows());
    let changed = RecordBatch::try_new(rows.schema(), columns).unwrap();
    let mut writer = ArrowWriter::try_new(File::create(path).unwrap(), rows.schema(), None).unwrap();
    writer.write(&changed).unwrap();
    writer.close().unwrap();
}

#[test]
fn where_episodes_are_said_to_be_is_where_they_are() {
    let place = Place::new();
    for (k, (column, value)) in [
        ("length", -5),
        ("length", 1 << 62),
        ("length", 3),
        ("dataset_from_index", -1),
        ("dataset_from_index", 1),
        ("dataset_to_index", i64::MAX),
        ("dataset_to_index", 0),
        ("episode_index", 7),
        ("data/chunk_index", i64::MAX),
        ("data/chunk_index", 1 << 40),
        ("data/file_index", 5),
        ("data/file_index", -1),
    ]
    .into_iter()
    .enumerate()
    {
        let out = place.made(&format!("e{k}"), |_| {});
        edit(&out.join("meta/episodes/chunk-000/file-000.parquet"), column, value);
        let text = refused(&out);
        assert!(text.contains("file-000.parquet"), "{column} = {value}: {text}");
        assert!(findings(&out).lines().count() > 1, "{column} = {value}: {}", findings(&out));
    }
    let out = place.made("below", |_| {});
    edit(&out.join("meta/episodes/chunk-000/file-000.parquet"), "length", -5);
    assert!(refused(&out).contains("length: -5 in row 0 is not a count"), "{}", refused(&out));
    let out = place.made("length", |_| {});
    edit(&out.join("meta/episodes/chunk-000/file-000.parquet"), "length", 1 << 62);
    assert!(refused(&out).contains("length: 4611686018427387904 does not match frames 0 to 2"));
}

#[test]
fn a_header_with_numbers_that_no_dataset_has_is_refused_by_every_reader() {
    let place = Place::new();
    let good = Dataset::open(&place.made("good", |_| {})).unwrap();
    for (k, (at, value, want)) in [
        (
            "/layout/wheels",
            serde_json::json!(1_u64 << 60),
            "layout.wheels: 1152921504606846976 must lie in 1 to 64",
        ),
        ("/layout/wheels", serde_json::json!(0), "layout.wheels: 0 must"),
        ("/layout/crops", serde_json::json!(1_000_000_000), "layout.crops: 1000000000 must lie in 0 to 128"),
        ("/hz", serde_json::json!(0), "hz: 0 must lie in 1 to 100"),
        ("/hz", serde_json::json!(4_000_000_000_u32), "hz: 4000000000 must"),
        ("/scale", serde_json::json!(0), "scale: 0 must lie in 0.01 to 10"),
        ("/scale", serde_json::json!(-1e308), "scale: -1e308 must"),
        ("/time_step", serde_json::json!(0.0), "time_step: 0 must"),
    ]
    .into_iter()
    .enumerate()
    {
        let out = place.made(&format!("h{k}"), |_| {});
        let path = out.join("dataset.json");
        let mut json: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        *json.pointer_mut(at).unwrap() = value;
        fs::write(&path, json.to_string()).unwrap();
        assert!(refused(&out).contains(want), "{want}: {}", refused(&out));
        let told = validate(&out, &[]).map_or_else(|e| e.to_string(), |f| f.0.join("\n"));
        assert!(told.contains(want), "{want}: {told}");
        assert!(Dataset::open_whole(&out).is_err());
    }
    // Its own header is one that a merged dataset can have.
    let other = Dataset::open(&place.made("other", |e| {
        e.info.state_hash = "1".repeat(16);
        e.columns[0] = Values::F32(vec![0.5; 30]);
    }))
    .unwrap();
    merge(&[good, other], &place.path("merged"), None, Vec::new()).unwrap();
}
