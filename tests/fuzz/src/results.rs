//! Run directories.

use std::path::PathBuf;

use vb_record::RunReader;
use vb_score::{Rules, TaskRecord, rescore};

use crate::site::Site;

const HEADER: &[u8] = include_bytes!("../seeds/run/run.json");
const TASKS: &[u8] = include_bytes!("../seeds/run/tasks.jsonl");
const TRACE: &[u8] = include_bytes!("../seeds/run/trace.parquet");

fn site() -> Site {
    Site::new().with(vec![
        (PathBuf::from("run.json"), HEADER.to_vec()),
        (PathBuf::from("tasks.jsonl"), TASKS.to_vec()),
        (PathBuf::from("traces/w001/t00.parquet"), TRACE.to_vec()),
    ])
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            let Ok(reader) = RunReader::open(dir) else { return };
            let Ok(records) = reader.records::<TaskRecord>() else { return };
            for record in &records {
                let _ = reader.trace(&record.task);
            }
            let _ = rescore(dir, &Rules::paper());
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The seed is a run as the program wrote it.
    #[test]
    fn a_run_is_read_and_rescored() {
        let site = site();
        let again = rescore(site.path(), &Rules::paper()).expect("a run");
        assert_eq!(again.records.len(), 1);
        assert_eq!(again.records[0].state_hash, "e6cd64a260edc399");
    }
}
