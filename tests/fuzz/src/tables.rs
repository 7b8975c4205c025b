//! Parquet files of runs: a planner's series, traces, and recorded commands.

use std::path::{Path, PathBuf};

use vb_record::{AppliedCommand, DebugSeries, Recording, RunReader, RunStore, Trace};

use crate::site::Site;

const HEADER: &[u8] = include_bytes!("../seeds/run/run.json");
const TRACE: &[u8] = include_bytes!("../seeds/run/trace.parquet");
/// The file that an input becomes.
const FILE: &str = "file.parquet";

fn read(data: &[u8], reader: fn(&Path)) {
    thread_local!(static SITE: Site = Site::new());
    SITE.with(|site| {
        site.write(Path::new(FILE), data);
        reader(&site.path().join(FILE));
    });
}

/// A planner's series, and what a replay makes of them.
pub(crate) fn series(data: &[u8]) {
    read(data, |path| {
        if let Ok(entries) = DebugSeries::read(path) {
            let values: usize = entries.iter().map(|e| e.values.len()).sum();
            assert!(values <= DebugSeries::MAX_VALUES);
            assert!(entries.iter().all(|e| e.name.len() <= DebugSeries::MAX_NAME));
        }
    });
}

pub(crate) fn trace(data: &[u8]) {
    read(data, |path| {
        if let Ok(trace) = Trace::read(path) {
            assert_eq!(trace.samples.len() * trace.wheels, trace.wheel_samples.len());
        }
    });
}

pub(crate) fn trace_seeds() -> Vec<Vec<u8>> {
    vec![TRACE.to_vec()]
}

/// Recorded commands of a run, which a submission to the open division has as its planner.
pub(crate) fn recording(data: &[u8]) {
    read(data, |path| {
        if let Ok((recording, _)) = Recording::read(path) {
            let commands = recording.tasks.values().flatten();
            assert!(commands.flat_map(|c| [c.steering, c.throttle, c.brake, c.gear]).all(f64::is_finite));
        }
    });
}

pub(crate) fn recording_seeds() -> Vec<Vec<u8>> {
    let site = Site::new().with(vec![(PathBuf::from("run/run.json"), HEADER.to_vec())]);
    let header = RunReader::open(&site.path().join("run")).expect("a run").header().clone();
    let command = AppliedCommand { steering: -0.25, throttle: 0.5, brake: 0.0, gear: 0.0 };
    let tasks = [("w001/t00", 1), ("w001/t01", 300)]
        .map(|(task, n)| (task.parse().expect("a task"), vec![command; n]));
    let recording = Recording { header, departures: vec!["time step 5 ms".into()], tasks: tasks.into() };
    let path = site.path().join(FILE);
    recording.write(&path).expect("a file");
    vec![std::fs::read(path).expect("the file")]
}

/// The files that a run writes of series of one value, of many names, and of many values.
pub(crate) fn series_seeds() -> Vec<Vec<u8>> {
    let site = Site::new().with(vec![(PathBuf::from("old/run.json"), HEADER.to_vec())]);
    let header = RunReader::open(&site.path().join("old")).expect("a run").header().clone();
    let store = RunStore::create(&site.path().join("new"), &header).expect("a new run");
    let mut few = DebugSeries::default();
    few.push(0.0, "cost", &[1.5]);
    let mut names = DebugSeries::default();
    for k in 0..40 {
        names.push(0.1 * f64::from(k), &format!("name {k}.xy"), &[0.0, f32::NAN]);
    }
    let mut values = DebugSeries::default();
    values.push(1.0, "trajectories", &[2.0; 3000]);
    let all = [few, names, values];
    let file = |(k, series): (usize, &DebugSeries)| {
        store.write_debug(&format!("w001/t{k}").parse().expect("a task"), series).expect("a file");
        std::fs::read(site.path().join(format!("new/traces/w001/t{k}.debug.parquet"))).expect("the file")
    };
    all.iter().enumerate().map(file).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The decoder of version 60.1 panics on it: a page of a dictionary's numbers says more bits than it has.
    #[test]
    fn a_file_on_which_the_decoder_panics_is_damaged() {
        let site = Site::new();
        site.write(Path::new(FILE), include_bytes!("../seeds/damaged/series.parquet"));
        let told = DebugSeries::read(&site.path().join(FILE)).unwrap_err().to_string();
        assert!(told.contains("it can't be decoded: range end index 4 out of range"), "{told}");
    }

    /// A seed that is refused at the door tests nothing behind it.
    #[test]
    fn the_seeds_are_read() {
        let site = Site::new();
        for (seeds, is_read) in [
            (series_seeds(), (|path| DebugSeries::read(path).is_ok()) as fn(&Path) -> bool),
            (trace_seeds(), |path| Trace::read(path).is_ok()),
            (recording_seeds(), |path| Recording::read(path).is_ok_and(|(r, _)| r.tasks.len() == 2)),
        ] {
            for seed in seeds {
                site.write(Path::new(FILE), &seed);
                assert!(is_read(&site.path().join(FILE)));
            }
        }
    }
}
