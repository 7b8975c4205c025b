//! The records of a run, and the pages and tables that are made of them.

use std::path::PathBuf;

use vb_report::{Beside, Report, Runs};

use crate::site::Site;

const HEADER: &[u8] = include_bytes!("../seeds/run/run.json");
const TASKS: &[u8] = include_bytes!("../seeds/run/tasks.jsonl");
/// A record as this version writes it, with flags, cause and ride.
const RECORD: &[u8] = include_bytes!("../seeds/record-v3.jsonl");

fn site() -> Site {
    let file = |name: &str, bytes: &[u8]| (PathBuf::from(name), bytes.to_vec());
    Site::new().with(vec![file("tasks.jsonl", TASKS), file("tasks.jsonl", RECORD), file("run.json", HEADER)])
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            let Ok(runs) = Runs::read(&[dir.to_owned()]) else { return };
            // No chart is larger because a number is.
            let page = Report::new(runs).page(&Beside::default());
            assert!(page.len() < 8 << 20, "a page of {} bytes", page.len());
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}
