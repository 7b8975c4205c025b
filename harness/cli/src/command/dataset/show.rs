//! `vb-harness dataset show` and `mcap`.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde_json::json;
use vb_catalog::CatalogError;
use vb_dataset::Dataset;
use vb_dataset_report::{Clip, Figures, Overview, clip, examples};
use vb_replay::{Link, Links};
use vb_trial::Cache;
use vb_vehicle::VehicleModel;
use vb_world::{Suite, World};

use crate::args::{ForceArgs, FormatArgs};
use crate::command::replay::{self, McapArgs};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct DatasetShowArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for index.html and the replays; default: a temporary directory, opened in the browser
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Number of example episodes, of each outcome in turn
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub(crate) clips: usize,
    /// Vehicle of the dataset: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetMcapArgs {
    /// Dataset directory
    #[arg(value_name = "DATASET")]
    pub(crate) dataset: PathBuf,
    /// Directory for the files, one per episode
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) profile: McapArgs,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Episode numbers, e.g. 3,10-19; default: all
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = episodes)]
    pub(crate) episodes: Vec<RangeInclusive<usize>>,
    /// Vehicle of the dataset: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Numbers of episodes, e.g. `7` or `10-19`.
fn episodes(text: &str) -> Result<RangeInclusive<usize>, String> {
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    match (from.parse(), to.parse()) {
        (Ok(from), Ok(to)) if from <= to => Ok(from..=to),
        _ => Err(format!("\"{text}\" is neither a number nor a range, e.g. 10-19")),
    }
}

/// Worlds that are kept in memory at most.
const WORLDS: usize = 128;

/// The worlds of a dataset, at its scale.
struct Worlds {
    suite: Suite,
    scale: f64,
    loaded: Cache<Arc<World>>,
}

impl Worlds {
    fn load(&self, id: &str) -> Result<Arc<World>, CliError> {
        self.loaded.get(id, || Ok(Arc::new(self.suite.load_world(id)?.at_scale(self.scale))))
    }
}

fn open(dir: &Path) -> Result<(Dataset, Worlds), CliError> {
    let dataset = Dataset::open(dir)?;
    let suite = dataset.worlds()?;
    let worlds = Worlds { suite, scale: dataset.header().scale, loaded: Cache::new(WORLDS) };
    Ok((dataset, worlds))
}

/// The vehicle of a dataset, if what is at hand, or what the user names, is it.
fn vehicle(dataset: &Dataset, wanted: Option<&str>) -> Result<VehicleModel, CliError> {
    let own = &dataset.header().vehicle;
    let found = places::catalog().vehicle(wanted.unwrap_or(&own.name));
    match found {
        Ok(found) if found.hash == own.hash => VehicleModel::new(found.spec).map_err(CliError::input),
        Err(e) if wanted.is_some() || !matches!(e, CatalogError::Unknown { .. }) => Err(e.into()),
        // Another vehicle has the name, or none that comes with the harness has it.
        Ok(_) | Err(_) => Err(CliError::input(format!(
            "the available vehicle {} differs from that of the dataset (give its file with --vehicle)",
            wanted.unwrap_or(&own.name)
        ))),
    }
}

/// The name of an episode's file.
fn file(index: usize, kind: &str) -> String {
    format!("episode-{index:06}.{kind}")
}

/// Where the clip of an episode leads to, among those of the chosen episodes.
fn links(chosen: &BTreeSet<usize>, index: usize) -> Links {
    let link = |&k: &usize| Link { name: format!("episode {k}"), href: file(k, "html") };
    Links {
        report: Some(Link { name: "dataset".into(), href: "index.html".into() }),
        previous: chosen.range(..index).next_back().map(link),
        next: chosen.range(index + 1..).next().map(link),
    }
}

pub(super) fn show(args: &DatasetShowArgs) -> Result<(), CliError> {
    let (dataset, worlds) = open(&args.dataset)?;
    let vehicle = match vehicle(&dataset, args.vehicle.as_deref()) {
        Ok(vehicle) => Some(vehicle),
        Err(e) if args.vehicle.is_some() => return Err(e),
        Err(e) => {
            output::say(&format!("{e}: there are no replays"));
            None
        }
    };
    let out = match &args.out {
        Some(dir) => dir.clone(),
        None => tempfile::Builder::new()
            .prefix("vb-dataset-")
            .tempdir()
            .map_err(|e| {
                CliError::output(format!("cannot make a temporary directory: {e} (give --out DIR)"))
            })?
            .keep(),
    };
    output::must_not_replace(&out.join("index.html"), args.force)?;
    output::create_dir(&out)?;
    let chosen = examples(&dataset, args.clips);
    if vehicle.is_some() && !chosen.is_empty() {
        output::write(&out.join(vb_replay::SCRIPT_FILE), vb_replay::script())?;
    }
    let (mut figures, mut clips) = (Figures::default(), Vec::new());
    for (index, episode) in dataset.episodes().enumerate() {
        let episode = episode?;
        let world = worlds.load(&episode.info.world)?;
        figures.add(dataset.features(), &episode, &world);
        if !chosen.contains(&index) {
            continue;
        }
        let mut replay = None;
        if let Some(vehicle) = &vehicle {
            let name = file(index, "html");
            let clip = clip(&dataset, index, &episode, &world, vehicle);
            output::write(
                &out.join(&name),
                vb_replay::page(&clip, &links(&chosen, index), Some(vb_replay::SCRIPT_FILE)),
            )?;
            replay = Some(name);
        }
        clips.push(Clip::new(&dataset, index, &episode, &world, replay));
    }
    let hash = dataset.hash()?;
    let overview = Overview { header: dataset.header(), hash: &hash, figures: &figures, clips: &clips };
    let index = out.join("index.html");
    output::write(&index, overview.html())?;
    if args.format.is_json() {
        let (episodes, clips) = (figures.episodes, clips.len());
        output::json(&json!({"event": "shown", "page": index, "episodes": episodes, "clips": clips}));
    } else {
        output::say(&format!("wrote {}", index.display()));
    }
    if args.out.is_none() {
        replay::open(&index);
    }
    Ok(())
}

pub(super) fn mcap(args: &DatasetMcapArgs) -> Result<(), CliError> {
    let (dataset, worlds) = open(&args.dataset)?;
    let vehicle = vehicle(&dataset, args.vehicle.as_deref())?;
    let count = dataset.infos().len();
    if let Some(range) = args.episodes.iter().find(|r| *r.end() >= count) {
        return Err(CliError::usage(format!(
            "--episodes: there is no episode {} (the dataset has {count}, from 0)",
            range.end()
        )));
    }
    let all = vec![0..=count.saturating_sub(1)];
    let ranges = if args.episodes.is_empty() { &all } else { &args.episodes };
    let chosen: BTreeSet<usize> = ranges.iter().cloned().flatten().collect();
    output::must_be_empty(&args.out, args.force)?;
    output::create_dir(&args.out)?;
    let mut files: Vec<PathBuf> = Vec::new();
    for (index, episode) in chosen.iter().zip(dataset.select(chosen.iter().copied())) {
        let episode = episode?;
        let world = worlds.load(&episode.info.world)?;
        let path = args.out.join(file(*index, "mcap"));
        replay::mcap(&path, &clip(&dataset, *index, &episode, &world, &vehicle), args.profile)?;
        files.push(path);
    }
    if args.format.is_json() {
        output::json(&json!({"event": "written", "files": files}));
    } else {
        output::say(&format!("wrote {} files to {}", files.len(), args.out.display()));
    }
    Ok(())
}
