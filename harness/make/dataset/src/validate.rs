//! Checking whether a dataset is what it should be.

use std::ops::ControlFlow;
use std::path::Path;

use vb_world::Suite;

use crate::error::DatasetError;
use crate::format::{Batch, Place};
use crate::make::keep_apart;
use crate::reader::{Dataset, finished_header};
use crate::sums::{SUMS, Sums};
use crate::values;

/// Findings that are told at most.
const FINDINGS: usize = 50;

/// What is wrong with a dataset: one line each. No more than 50 are told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings(pub Vec<String>);

impl Findings {
    fn is_full(&self) -> bool {
        self.0.len() >= FINDINGS
    }

    fn add(&mut self, text: String) {
        if self.0.len() < FINDINGS {
            self.0.push(vb_files::one_line(&text));
        }
    }
}

/// Checks a dataset: that all files are there and as they were written, that time goes on without gaps, that values lie
/// within their ranges, that episodes, frames and totals fit together, and that no world belongs to one of the `suites`.
///
/// # Errors
/// Returns an error if there is no dataset, or it isn't finished.
pub fn validate(dir: &Path, suites: &[Suite]) -> Result<Findings, DatasetError> {
    finished_header(dir)?;
    let mut findings = Findings::default();
    hold(dir, &mut findings)?;
    // What can't be opened has been told, by its hash.
    let dataset = match Dataset::open(dir) {
        Ok(dataset) => dataset,
        Err(e) => {
            findings.add(e.to_string());
            return Ok(findings);
        }
    };
    let worlds = worlds(&dataset, suites, &mut findings);
    episodes(&dataset, worlds.as_ref(), &mut findings);
    let flaws = dataset.format().total_flaws(dir, dataset.infos().len(), dataset.frames());
    flaws.into_iter().for_each(|flaw| findings.add(flaw));
    Ok(findings)
}

/// Holds each file against its hash.
fn hold(dir: &Path, findings: &mut Findings) -> Result<(), DatasetError> {
    let sums = match Sums::read(dir, SUMS) {
        Ok(sums) => sums,
        Err(e) => {
            findings.add(e.to_string());
            return Ok(());
        }
    };
    sums.check(dir, |flaw| {
        findings.add(flaw.to_string());
        if findings.is_full() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    for flaw in sums.strangers(dir)?.into_iter().take(FINDINGS) {
        findings.add(flaw.to_string());
    }
    Ok(())
}

fn worlds(dataset: &Dataset, suites: &[Suite], findings: &mut Findings) -> Option<Suite> {
    let suite = match dataset.worlds() {
        Ok(suite) => suite,
        Err(e) => {
            findings.add(e.to_string());
            return None;
        }
    };
    if suite.hash() != dataset.header().worlds.hash {
        findings.add("suite: the worlds differ from those of dataset.json".to_owned());
    }
    for world in suite.worlds() {
        if let Err(e) = suite.verify_world(&world.id) {
            findings.add(e.to_string());
        }
    }
    if !dataset.header().of_a_suite
        && let Err(e) = keep_apart(&suite, suites)
    {
        findings.add(e.to_string());
    }
    Some(suite)
}

/// Checks what is said of the episodes, and their frames.
fn episodes(dataset: &Dataset, worlds: Option<&Suite>, findings: &mut Findings) {
    let features = dataset.features();
    let mut open: Option<(usize, Batch, usize)> = None;
    for (k, row) in dataset.rows().iter().enumerate() {
        let (info, place) = (&row.info, row.place);
        if let Some(suite) = worlds
            && suite.world_info(&info.world).map(|w| &w.sha256).ok() != Some(&info.world_hash)
        {
            findings
                .add(format!("episode {k}: its world {} is missing in the suite, or differs", info.world));
        }
        if open.as_ref().is_none_or(|(file, ..)| *file != place.file) {
            let format = dataset.format();
            match format.read_data(&dataset.dir().join(format.data_path(place.file)), features) {
                Ok(batch) => open = Some((place.file, batch, place.from)),
                Err(e) => {
                    findings.add(e.to_string());
                    return;
                }
            }
        }
        let Some((_, batch, first)) = &open else { return };
        let rows = place.from - first..place.to - first;
        if rows.end > batch.len() {
            findings.add(format!("episode {k}: frames {} to {} are missing", first + batch.len(), place.to));
            return;
        }
        if let Some(problem) = frames(dataset, batch, rows, place, k) {
            findings.add(format!("episode {k}: {problem}"));
        }
    }
}

/// The first flaw of an episode's frames.
fn frames(
    dataset: &Dataset,
    batch: &Batch,
    rows: std::ops::Range<usize>,
    place: Place,
    episode: usize,
) -> Option<String> {
    let hz = f64::from(dataset.header().hz);
    let whole = |v: usize| i64::try_from(v).unwrap_or(i64::MAX);
    for (k, row) in rows.clone().enumerate() {
        if batch.index[row] != whole(place.from + k) {
            return Some(format!("frame {k}: index {} is not {}", batch.index[row], place.from + k));
        }
        if batch.task_index[row] < 0 || batch.task_index[row] > whole(dataset.infos().len()) {
            return Some(format!("frame {k}: task_index {} is not a task", batch.task_index[row]));
        }
        if batch.frame_index[row] != whole(k) || batch.episode_index[row] != whole(episode) {
            return Some(format!("frame {k} has frame_index {}", batch.frame_index[row]));
        }
        let time = k as f64 / hz;
        // A time that is no number is none either.
        let is_then = (f64::from(batch.timestamp[row]) - time).abs() <= 1e-4;
        if !is_then {
            return Some(format!("timestamp {} of frame {k} is not {time}", batch.timestamp[row]));
        }
    }
    values::flaw(dataset.features(), &batch.columns, rows)
}
