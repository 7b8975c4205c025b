//! Several datasets in one, and one in several.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;
use vb_math::rng::Stream;
use vb_record::{DataHeader, NewFolder};
use vb_world::{Suite, TaskId};

use crate::episode::EpisodeInfo;
use crate::error::DatasetError;
use crate::header::{Header, Kind};
use crate::part::Part;
use crate::reader::Dataset;
use crate::worlds::{subset, union};
use crate::writer::{DatasetWriter, Finished};

/// The most frames of an episode.
fn longest<'a>(datasets: impl IntoIterator<Item = &'a Dataset>) -> usize {
    datasets.into_iter().flat_map(|d| d.infos().map(|(_, frames)| frames)).max().unwrap_or(1)
}

fn worlds_header(suite: &Suite) -> DataHeader {
    DataHeader { name: suite.meta().name.clone(), hash: suite.hash() }
}

/// Where the worlds of a dataset are gathered while its folder is made.
const GATHERED: &str = "worlds";

/// What an episode is told apart by: the simulation's states, or else where it was cut out, and how it began and how long it took.
/// Its world doesn't count, whose hash changes with its name. Nothing is known of an episode that a person ended.
fn identity(info: &EpisodeInfo) -> Option<String> {
    let of = if info.state_hash.is_empty() { &info.origin } else { &info.state_hash };
    (!of.is_empty()).then(|| format!("{of} {:?} {}", info.start, info.time_s))
}

/// Refuses a dataset that is there twice, or that another has within itself: its episodes would count twice.
fn refuse_repeated(datasets: &[Dataset]) -> Result<(), DatasetError> {
    let place = |d: &Dataset| std::fs::canonicalize(d.dir()).map_err(DatasetError::io("read", d.dir()));
    let places = datasets.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    let frames = datasets.iter().map(Dataset::frames_hash).collect::<Result<Vec<_>, _>>()?;
    let known: Vec<BTreeSet<_>> =
        datasets.iter().map(|d| d.infos().filter_map(|(info, _)| identity(info)).collect()).collect();
    for (k, inner) in datasets.iter().enumerate() {
        for (j, outer) in datasets.iter().enumerate().filter(|(j, _)| *j != k) {
            let is_within =
                || inner.infos().all(|(info, _)| identity(info).is_some_and(|i| known[j].contains(&i)));
            if places[j] == places[k] || frames[j] == frames[k] || is_within() {
                let (outer, inner) = (outer.dir().to_owned(), inner.dir().to_owned());
                return Err(DatasetError::Repeated { inner, outer });
            }
        }
    }
    Ok(())
}

/// The number of episodes that an earlier one of the datasets has as well: they will count as often as they are there.
#[must_use]
pub fn repeated(datasets: &[Dataset]) -> usize {
    let mut seen = BTreeSet::new();
    let mut count = 0;
    for dataset in datasets {
        let own: Vec<_> = dataset.infos().filter_map(|(info, _)| identity(info)).collect();
        count += own.iter().filter(|i| seen.contains(*i)).count();
        seen.extend(own);
    }
    count
}

/// Puts the episodes of several datasets into one, in their order. The worlds are named anew.
///
/// # Errors
/// Returns an error if the datasets have other columns, rates, vehicles or settings, one is there twice, or they can't be read or
/// written.
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
            (a.hz != b.hz, "frames per second"),
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
    refuse_repeated(datasets)?;
    datasets.iter().try_for_each(|dataset| dataset.must_not_hold(out))?;
    let suites = datasets.iter().map(Dataset::worlds).collect::<Result<Vec<_>, _>>()?;
    let folder = NewFolder::new(out)?;
    let (suite, names) = union(&suites, &folder.workshop().join(GATHERED))?;
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
    let mut writer = DatasetWriter::create_whole(folder, header, &suite, longest(datasets))?;
    for (k, dataset) in datasets.iter().enumerate() {
        for (index, episode) in dataset.episodes().enumerate() {
            let mut episode = episode?;
            let info = &mut episode.info;
            if let Some(own) = names.get(&(k, info.world.clone())) {
                info.world.clone_from(own);
                info.world_hash.clone_from(&suite.world_info(own)?.sha256);
                let renamed =
                    |t: TaskId| TaskId::new(own, t.task()).expect("the names of a written suite are valid");
                info.task = info.task.take().map(renamed);
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

/// Splits a dataset by the worlds in which its episodes are, so that no world is in two parts. Which world goes where depends on the seed
/// alone.
///
/// # Errors
/// Returns an error if the parts make no sense, one has no episode, or something can't be read or written. Then none is there.
pub fn split(
    dataset: &Dataset,
    parts: &[Part],
    seed: u64,
    out: &Path,
    command: &[String],
) -> Result<Vec<Finished>, DatasetError> {
    Part::check(parts)?;
    dataset.must_not_hold(out)?;
    let suite = dataset.worlds()?;
    // A world in which nobody drove would be a part of nothing.
    let driven: BTreeSet<&str> = dataset.infos().map(|(info, _)| info.world.as_str()).collect();
    let mut worlds: Vec<&str> =
        suite.worlds().iter().map(|w| w.id.as_str()).filter(|id| driven.contains(id)).collect();
    Stream::new(seed, &["split"]).shuffle(&mut worlds);
    let shares = Part::deal(parts, &worlds);
    if let Some((part, _)) = parts.iter().zip(&shares).find(|(_, own)| own.is_empty()) {
        return Err(DatasetError::Empty(format!(
            "for the part {}: the episodes are in {} worlds, and each of the {} parts needs one (use more worlds, or fewer \
             parts)",
            part.name,
            worlds.len(),
            parts.len()
        )));
    }
    let folders = parts.iter().map(|part| NewFolder::new(&out.join(&part.name)));
    let folders = folders.collect::<Result<Vec<_>, _>>()?;
    let mut writers = Vec::new();
    for ((part, own), folder) in parts.iter().zip(shares).zip(folders) {
        let of_worlds = subset(&suite, own, &folder.workshop().join(GATHERED))?;
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
        let mut writer = DatasetWriter::create_whole(folder, header, &of_worlds, longest([dataset]))?;
        for episode in dataset.episodes() {
            let episode = episode?;
            if own.contains(&episode.info.world.as_str()) {
                writer.add(&episode)?;
            }
        }
        writers.push(writer);
    }
    // Not one by one on the way: what is split half would look as if it were split.
    writers.into_iter().map(DatasetWriter::finish).collect()
}
