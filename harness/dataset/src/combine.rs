//! Several datasets in one, and one in several.

use std::path::Path;

use serde_json::json;
use vb_math::rng::Stream;
use vb_record::DataHeader;
use vb_world::Suite;

use crate::error::DatasetError;
use crate::header::{Header, Kind};
use crate::reader::Dataset;
use crate::worlds::{subset, union};
use crate::writer::{DatasetWriter, Finished};

/// The most frames of an episode.
fn longest(datasets: &[&Dataset]) -> usize {
    datasets.iter().flat_map(|d| d.infos().map(|(_, frames)| frames)).max().unwrap_or(1)
}

fn worlds_header(suite: &Suite) -> DataHeader {
    DataHeader { name: suite.meta().name.clone(), hash: suite.hash() }
}

/// A folder for a suite while a dataset is made beside it.
fn workshop(out: &Path) -> Result<tempfile::TempDir, DatasetError> {
    let parent = out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent).map_err(DatasetError::io("create", parent))?;
    let made = tempfile::Builder::new().prefix(".making-").tempdir_in(parent);
    made.map_err(DatasetError::io("create a folder in", parent))
}

/// Puts the episodes of several datasets into one, in their order. The worlds are named anew.
///
/// # Errors
/// Returns an error if the datasets have other columns, rates, vehicles or settings, or can't be read or written.
pub fn merge(
    datasets: &[Dataset],
    out: &Path,
    name: Option<&str>,
    command: Vec<String>,
) -> Result<Finished, DatasetError> {
    let first = &datasets[0];
    let a = first.header();
    for other in &datasets[1..] {
        let b = other.header();
        let what = [
            (a.layout != b.layout, "columns"),
            (a.hz != b.hz, "frames a second"),
            (a.vehicle != b.vehicle, "vehicle"),
            (a.soils != b.soils, "soils"),
            (a.perception != b.perception, "perception profile"),
            (a.scale != b.scale, "scale"),
            (a.time_step != b.time_step, "time step"),
            (a.of_a_suite != b.of_a_suite, "whether their worlds are for training"),
        ];
        if let Some((_, what)) = what.iter().find(|(differs, _)| *differs) {
            let (a, b) = (first.dir().to_owned(), other.dir().to_owned());
            return Err(DatasetError::Unlike { a, b, what: format!("they differ in {what}") });
        }
    }
    let suites = datasets.iter().map(Dataset::worlds).collect::<Result<Vec<_>, _>>()?;
    let workshop = workshop(out)?;
    let (suite, names) = union(&suites, &workshop.path().join("suite"))?;
    let of: Vec<_> = datasets
        .iter()
        .map(|d| Ok(json!({"name": d.header().name, "hash": d.hash()?})))
        .collect::<Result<_, DatasetError>>()?;
    let header = Header {
        name: name.map_or_else(|| format!("merged-{}", a.vehicle.name), str::to_owned),
        kind: Kind::Merged,
        command,
        worlds: worlds_header(&suite),
        exploration: None,
        planners: Vec::new(),
        options: [("of".to_owned(), json!(of))].into(),
        ..a.clone()
    };
    let mut writer =
        DatasetWriter::create(out, header, &suite, longest(&datasets.iter().collect::<Vec<_>>()))?;
    for (k, dataset) in datasets.iter().enumerate() {
        for (index, episode) in dataset.episodes().enumerate() {
            let mut episode = episode?;
            let info = &mut episode.info;
            if let Some(own) = names.get(&(k, info.world.clone())) {
                info.world.clone_from(own);
                info.world_hash.clone_from(&suite.world_info(own)?.sha256);
                if let Some((_, task)) = info.task.split_once('/') {
                    info.task = format!("{own}/{task}");
                }
            }
            if info.origin.is_empty() {
                info.origin = format!("{}: episode {index}", dataset.header().name);
            }
            info.drive = writer.episodes() as u64;
            writer.add(&episode)?;
        }
    }
    writer.finish()
}

/// A part of a dataset: its name, and its fraction of the worlds.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name, which is that of its folder.
    pub name: String,
    /// The fraction, between 0 and 1.
    pub fraction: f64,
}

/// Splits a dataset by its worlds, so that no world is in two parts. Which world goes where depends on the seed alone.
///
/// # Errors
/// Returns an error if a part has no episode, or something can't be read or written.
pub fn split(
    dataset: &Dataset,
    parts: &[Part],
    seed: u64,
    out: &Path,
    command: &[String],
) -> Result<Vec<Finished>, DatasetError> {
    let suite = dataset.worlds()?;
    let mut worlds: Vec<&str> = suite.worlds().iter().map(|w| w.id.as_str()).collect();
    Stream::new(seed, &["split"]).shuffle(&mut worlds);
    let whole: f64 = parts.iter().map(|p| p.fraction).sum();
    let (mut from, mut sum) = (0, 0.0);
    let mut finished = Vec::new();
    let workshop = workshop(out)?;
    for part in parts {
        sum += part.fraction;
        let to = (worlds.len() as f64 * sum / whole).round() as usize;
        let own = &worlds[from..to];
        from = to;
        let of_worlds = subset(&suite, own, &workshop.path().join(&part.name))?;
        let header = dataset.header();
        let options = [
            ("of".to_owned(), json!({"name": header.name, "hash": dataset.hash()?})),
            ("part".to_owned(), json!(part.name)),
            ("split_seed".to_owned(), json!(seed)),
        ];
        let header = Header {
            name: format!("{}-{}", header.name, part.name),
            kind: Kind::Split,
            command: command.to_vec(),
            worlds: worlds_header(&of_worlds),
            options: options.into(),
            ..header.clone()
        };
        let dir = out.join(&part.name);
        let mut writer = DatasetWriter::create(&dir, header, &of_worlds, longest(&[dataset]))?;
        for episode in dataset.episodes() {
            let episode = episode?;
            if own.contains(&episode.info.world.as_str()) {
                writer.add(&episode)?;
            }
        }
        if writer.episodes() == 0 {
            return Err(DatasetError::Empty(format!(
                "the part {} of {} worlds has none (give it a larger fraction)",
                part.name,
                own.len()
            )));
        }
        finished.push(writer.finish()?);
    }
    Ok(finished)
}
