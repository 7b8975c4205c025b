//! Checking whether a dataset is what it should be.

use std::ops::ControlFlow;
use std::path::Path;

use vb_world::{Suite, TerrainClass};

use crate::error::DatasetError;
use crate::feature::Values;
use crate::lerobot::{Batch, Place, data_path, read_data};
use crate::make::keep_apart;
use crate::reader::{Dataset, finished_header};
use crate::sums::{SUMS, Sums};

/// The greatest number that a frame may have, whatever its unit: no quantity of a vehicle, from the load of a wheel (N) to the
/// speed of its engine (rad/s), comes near it.
const MOST: f64 = 1e9;
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
            self.0.push(text.split_whitespace().collect::<Vec<_>>().join(" "));
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
    let frames = dataset.frames();
    let totals = vb_files::read_text(&dir.join("meta/info.json"), vb_files::DOCUMENT).ok();
    let totals: Option<serde_json::Value> = totals.and_then(|text| serde_json::from_str(&text).ok());
    let total = |name: &str| totals.as_ref().and_then(|t| t[name].as_u64());
    for (name, is) in [("total_frames", frames), ("total_episodes", dataset.infos().len())] {
        if total(name) != Some(is as u64) {
            findings.add(format!("meta/info.json: {name} is not {is}, which the episodes sum to"));
        }
    }
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

/// Checks the worlds.
fn worlds(dataset: &Dataset, suites: &[Suite], findings: &mut Findings) -> Option<Suite> {
    let suite = match dataset.worlds() {
        Ok(suite) => suite,
        Err(e) => {
            findings.add(e.to_string());
            return None;
        }
    };
    if suite.hash() != dataset.header().worlds.hash {
        findings.add("suite: the worlds are not those of dataset.json".to_owned());
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
                .add(format!("episode {k}: its world {} is not in the suite, or another there", info.world));
        }
        if open.as_ref().is_none_or(|(file, ..)| *file != place.file) {
            match read_data(&dataset.dir().join(data_path(place.file)), features) {
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
    let last = rows.end - 1;
    for (k, row) in rows.clone().enumerate() {
        if batch.index[row] != whole(place.from + k) {
            return Some(format!("frame {k}: index {} is not {}", batch.index[row], place.from + k));
        }
        if batch.task_index[row] < 0 || batch.task_index[row] > whole(dataset.infos().len()) {
            return Some(format!("frame {k}: task_index {} is of no task", batch.task_index[row]));
        }
        if batch.frame_index[row] != whole(k) || batch.episode_index[row] != whole(episode) {
            return Some(format!("frame {k} says that it is {}", batch.frame_index[row]));
        }
        let time = k as f64 / hz;
        // A time that is no number is none either.
        let is_then = (f64::from(batch.timestamp[row]) - time).abs() <= 1e-4;
        if !is_then {
            return Some(format!("timestamp {} of frame {k} is not {time}", batch.timestamp[row]));
        }
    }
    for (feature, values) in dataset.features().iter().zip(&batch.columns) {
        let width = feature.width();
        let own = || rows.start * width..rows.end * width;
        if let Values::F32(v) = values
            && let Some(k) = own().find(|k| !v[*k].is_finite())
        {
            return Some(format!("{} of frame {} is not finite", feature.name, k / width - rows.start));
        }
        let within = |entry: usize, low: f64, high: f64| {
            let at = rows.clone().find(|row| {
                let v = values.number(row * width + entry);
                v < low || v > high
            })?;
            let (name, v) = (&feature.names[entry], values.number(at * width + entry));
            Some(format!(
                "{} {name}: {v:e} of frame {} must lie in {low} to {high}",
                feature.name,
                at - rows.start
            ))
        };
        let flaw = match feature.name {
            "action" | "action.applied" => {
                let unit = [(-1.0, 1.0), (0.0, 1.0), (0.0, 1.0), (-1.0, 1.0)];
                unit.into_iter().enumerate().find_map(|(entry, (low, high))| within(entry, low, high))
            }
            "observation.state" | "truth.state" => {
                let turn = std::f64::consts::PI + 1e-3;
                (3..6).find_map(|entry| within(entry, -turn, turn))
            }
            "next.done" => {
                let done = |row: &usize| values.number(*row) != f64::from(u8::from(*row == last));
                let frame = rows.clone().find(done);
                // The last frames before a failure are the end of their episode too.
                frame.map(|row| format!("next.done of frame {} is wrong", row - rows.start))
            }
            "truth.ground" => {
                let known = TerrainClass::ALL.len() as f64;
                let odd = rows.clone().find(|row| !(0.0..known).contains(&values.number(*row)));
                odd.map(|row| {
                    let (v, at) = (values.number(row), row - rows.start);
                    format!("{}: {v:e} of frame {at} is no kind of ground", feature.name)
                })
            }
            _ => None,
        };
        let flaw = flaw.or_else(|| {
            let odd = own().find(|k| values.number(*k).abs() > MOST)?;
            let (v, at) = (values.number(odd), odd / width - rows.start);
            Some(format!("{}: {v:e} of frame {at} must lie in {:e} to {MOST:e}", feature.name, -MOST))
        });
        if flaw.is_some() {
            return flaw;
        }
    }
    None
}
