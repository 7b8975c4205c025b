//! A dataset is handed on as it was written, once, or not at all.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;
#[path = "common/place.rs"]
mod place;

use std::fs;
use std::path::Path;

use common::header;
use place::{LAYOUT, Place, episode};
use vb_dataset::{Dataset, DatasetError, DatasetWriter, Header, Part, merge, split};
use vb_record::StoreError;

/// So many frames an episode might have that each has a data file of its own.
const FRAMES: usize = usize::MAX;

impl Place {
    fn header(&self) -> Header {
        header("made", LAYOUT, &self.suite)
    }

    fn create(&self, name: &str) -> Result<DatasetWriter, DatasetError> {
        DatasetWriter::create(&self.path(name), self.header(), &self.suite, FRAMES)
    }

    fn resume(&self, name: &str) -> Result<DatasetWriter, DatasetError> {
        DatasetWriter::resume(&self.path(name), self.header(), &self.suite, FRAMES)
    }

    fn made(&self, name: &str, episodes: &[u64]) -> Dataset {
        let mut writer = self.create(name).unwrap();
        for k in episodes {
            writer.add(&episode(&self.suite, *k)).unwrap();
        }
        writer.finish().unwrap();
        Dataset::open_whole(&self.path(name)).unwrap()
    }
}

/// Damages a file and puts it right again afterwards.
fn damaged(path: &Path, look: impl Fn(&str)) {
    let whole = fs::read(path).unwrap();
    let mut changed = whole.clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    fs::write(path, changed).unwrap();
    look("its SHA-256 differs");
    fs::remove_file(path).unwrap();
    look("it is missing");
    fs::write(path, whole).unwrap();
}

const FILES: [&str; 5] = [
    "data/chunk-000/file-000.parquet",
    "meta/episodes/chunk-000/file-001.parquet",
    "suite/suite.yaml",
    "meta/info.json",
    "README.md",
];

#[test]
fn a_damaged_dataset_is_neither_read_as_a_whole_nor_gone_on_with() {
    let place = Place::new();
    place.made("d", &[0, 1, 2]);
    let sums = fs::read(place.path("d/SHA256SUMS")).unwrap();
    for file in FILES {
        damaged(&place.path("d").join(file), |problem| {
            for e in [Dataset::open_whole(&place.path("d")).err(), place.resume("d").err()] {
                let e = e.unwrap().to_string();
                assert!(e.contains(file) && e.contains(problem) && e.contains("validate"), "{e}");
            }
            // Who only looks at it must not take a part for the whole.
            if problem == "it is missing" {
                let e = Dataset::open(&place.path("d")).err();
                let tells = e.is_some_and(|e| e.to_string().contains(file));
                assert_eq!(tells, file.starts_with("meta/episodes"), "{file}");
            }
        });
    }
    // What is not of the dataset would be read as if it were.
    let stranger = place.path("d/meta/episodes/chunk-000/file-003.parquet");
    fs::copy(place.path("d").join(FILES[1]), &stranger).unwrap();
    for e in [Dataset::open_whole(&place.path("d")).err(), place.resume("d").err()] {
        let e = e.unwrap().to_string();
        assert!(e.contains("file-003.parquet") && e.contains("it does not belong to the dataset"), "{e}");
    }
    fs::remove_file(stranger).unwrap();
    fs::remove_file(place.path("d/SHA256SUMS")).unwrap();
    let e = place.resume("d").err().unwrap().to_string();
    assert!(e.contains("SHA256SUMS: it is missing"), "{e}");
    fs::write(place.path("d/SHA256SUMS"), &sums).unwrap();

    // It goes on as a whole, and what is hidden doesn't count.
    fs::create_dir(place.path("d/.git")).unwrap();
    fs::write(place.path("d/.git/config"), "").unwrap();
    place.resume("d").unwrap().finish().unwrap();
    assert_eq!(fs::read(place.path("d/SHA256SUMS")).unwrap(), sums);
}

#[test]
fn what_was_begun_is_held_against_its_hashes_and_no_damage_gets_new_ones() {
    let place = Place::new();
    let all = place.made("whole", &[0, 1, 2]).hash().unwrap();
    let begin = || {
        let mut writer = place.create("d").unwrap();
        for k in [0, 1] {
            writer.add(&episode(&place.suite, k)).unwrap();
        }
    };
    begin();
    for file in &FILES[..3] {
        damaged(&place.path("d").join(file), |problem| {
            let e = place.resume("d").err().unwrap().to_string();
            assert!(e.contains(file) && e.contains(problem), "{e}");
        });
    }
    // Killed after the frames, and after the episodes, but before their hashes.
    let so_far = fs::read(place.path("d/.SHA256SUMS")).unwrap();
    let goes_on = |next: &[u64]| {
        let mut writer = place.resume("d").unwrap();
        assert_eq!(writer.next_drive(), next[0]);
        for k in next {
            writer.add(&episode(&place.suite, *k)).unwrap();
        }
        assert_eq!(writer.finish().unwrap().hash, all);
        assert!(!place.path("d/.SHA256SUMS").exists() && !place.path("d/.lock").exists());
        fs::remove_dir_all(place.path("d")).unwrap();
    };
    place.resume("d").unwrap().add(&episode(&place.suite, 2)).unwrap();
    fs::write(place.path("d/.SHA256SUMS"), &so_far).unwrap();
    let mut writer = place.resume("d").unwrap();
    assert_eq!(writer.next_drive(), 3);
    assert_eq!(writer.save().unwrap().hash, all);
    drop(writer);
    fs::remove_file(place.path("d/meta/episodes/chunk-000/file-002.parquet")).unwrap();
    fs::write(place.path("d/.SHA256SUMS"), so_far).unwrap();
    goes_on(&[2]);

    // What is damaged while it is made is found afterwards.
    let mut writer = place.create("d").unwrap();
    writer.add(&episode(&place.suite, 0)).unwrap();
    let data = place.path("d").join(FILES[0]);
    let mut bytes = fs::read(&data).unwrap();
    bytes[100] ^= 1;
    fs::write(&data, bytes).unwrap();
    writer.finish().unwrap();
    let e = Dataset::open_whole(&place.path("d")).err().unwrap().to_string();
    assert!(e.contains(FILES[0]), "{e}");
}

#[test]
fn a_folder_that_is_not_of_a_dataset_is_left_alone_whatever_is_resumed() {
    let place = Place::new();
    fs::create_dir_all(place.path("mine/suite")).unwrap();
    fs::write(place.path("mine/suite/suite.yaml"), "precious").unwrap();
    for _ in 0..2 {
        let e = place.resume("mine").err().unwrap();
        assert!(matches!(e, DatasetError::NotEmpty { .. }), "{e}");
        assert_eq!(fs::read(place.path("mine/suite/suite.yaml")).unwrap(), b"precious");
    }
    // A dataset that was killed while its worlds were copied is begun anew.
    drop(place.create("d").unwrap());
    fs::remove_file(place.path("d/dataset.json")).unwrap();
    fs::remove_file(place.path("d/suite/suite.yaml")).unwrap();
    let mut writer = place.resume("d").unwrap();
    writer.add(&episode(&place.suite, 0)).unwrap();
    writer.finish().unwrap();
    Dataset::open_whole(&place.path("d")).unwrap();
}

#[test]
fn one_dataset_has_one_writer() {
    let place = Place::new();
    let mut writer = place.create("d").unwrap();
    writer.add(&episode(&place.suite, 0)).unwrap();
    let is_locked = |e: Option<DatasetError>| {
        let e = e.unwrap();
        assert!(matches!(e, DatasetError::Record(StoreError::Locked(_))), "{e}");
    };
    is_locked(place.create("d").err());
    is_locked(place.resume("d").err());
    let a = place.made("a", &[1]);
    is_locked(merge(&[a], &place.path("d"), None, Vec::new()).err());
    writer.finish().unwrap();
    Dataset::open_whole(&place.path("d")).unwrap();
    // The lock goes with its process.
    drop(place.create("e").unwrap());
    place.resume("e").unwrap();
}

#[test]
fn a_dataset_is_merged_once() {
    let place = Place::new();
    let [a, b] = [("a", [0, 1]), ("b", [2, 3])].map(|(name, of)| place.made(name, &of));
    let into = |datasets: &[&Dataset], out: &str| {
        let datasets: Vec<_> = datasets.iter().map(|d| Dataset::open_whole(d.dir()).unwrap()).collect();
        merge(&datasets, &place.path(out), None, Vec::new())
    };
    assert_eq!(into(&[&a, &b], "ab").unwrap().episodes, 4);
    let ab = Dataset::open_whole(&place.path("ab")).unwrap();
    fs::create_dir(place.path("elsewhere")).unwrap();
    copy(a.dir(), &place.path("elsewhere/a"));
    let copy = Dataset::open_whole(&place.path("elsewhere/a")).unwrap();
    let dotted = Dataset::open_whole(&place.path("elsewhere/../a")).unwrap();
    for twice in [[&a, &a], [&a, &dotted], [&copy, &a], [&ab, &b], [&b, &ab]] {
        let e = into(&twice, "no").unwrap_err();
        assert!(matches!(e, DatasetError::Repeated { .. }), "{e}");
        assert!(!place.path("no").exists());
    }
    // Some of a dataset may be in another, which is told.
    let c = place.made("c", &[3, 4]);
    assert_eq!(into(&[&ab, &c], "abc").unwrap().episodes, 6);
    assert_eq!(vb_dataset::repeated(&[ab, c]), 1);
    let names: Vec<_> = fs::read_dir(place.path("ab")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(names.iter().all(|n| !n.to_string_lossy().starts_with('.')), "{names:?}");
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

#[test]
fn parts_that_make_no_sense_or_have_nothing_leave_nothing_behind() {
    let place = Place::new();
    let a = place.made("a", &[0, 1]);
    let parts = |of: &[(&str, f64)]| -> Vec<Part> {
        of.iter().map(|(name, fraction)| Part { name: (*name).into(), fraction: *fraction }).collect()
    };
    let out = place.path("parts");
    let refused = |of: &[(&str, f64)], why: &str| {
        let e = split(&a, &parts(of), 0, &out, &[]).unwrap_err().to_string();
        assert!(e.contains(why), "{e}");
        assert!(!out.exists());
    };
    refused(&[("../escape", 1.0)], "is not a valid name");
    refused(&[("a", 0.5), ("a", 0.5)], "have the same folder");
    refused(&[("a", 0.5), ("b", 0.4)], "sum to 0.900");
    let e = split(&a, &parts(&[("a", 1.0)]), 0, &a.dir().join("x/parts"), &[]).unwrap_err();
    assert!(matches!(e, DatasetError::Within { .. }), "{e}");
    Dataset::open_whole(a.dir()).unwrap();
    // There is one world, so that one of the two has none.
    refused(
        &[("a", 0.9), ("b", 0.1)],
        "for the part b: the episodes are in 1 worlds, and each of the 2 parts needs one",
    );
    assert_eq!(split(&a, &parts(&[("all", 1.0)]), 0, &out, &[]).unwrap()[0].episodes, 2);
    Dataset::open_whole(&out.join("all")).unwrap();
}

#[test]
fn statistics_have_the_index_columns_of_lerobot() {
    let place = Place::new();
    let a = place.made("a", &[0, 1]);
    let text = fs::read_to_string(a.dir().join("meta/stats.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    for name in ["timestamp", "frame_index", "episode_index", "index", "task_index"] {
        assert_eq!(stats[name]["min"][0], 0.0, "{name}");
    }
    // Frames are numbered from 0 to n − 1: mean (n − 1) / 2, variance (n² − 1) / 12.
    let index = &stats["index"];
    let n = index["count"][0].as_f64().unwrap();
    let near =
        |what: &str, wanted: f64| (index[what][0].as_f64().unwrap() - wanted).abs() < 1e-9 * wanted.max(1.0);
    assert!(n > 1.0 && near("max", n - 1.0) && near("mean", 0.5 * (n - 1.0)), "{index}");
    assert!(near("std", ((n * n - 1.0) / 12.0).sqrt()), "{index}");
    assert_eq!(stats["episode_index"]["max"][0], 1.0);
}
