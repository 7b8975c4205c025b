//! `vb-harness dataset`.

mod failures;
mod hold;
mod scene;
mod show;
#[cfg(feature = "teleop")]
mod teleop;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use vb_dataset::{
    Amount, DatasetWriter, Exploration, Finished, Header, Kept, Kind, Planner, PlannerHeader, Progress,
};
use vb_host::{Limits, Plugin};
use vb_record::DataHeader;
use vb_runner::{PluginDriver, check_control_period, check_perception, wants};
use vb_score::Rules;

use crate::args::exit_codes::{codes, resumed};
use crate::args::values::{duration, key_value, planner};
use crate::args::{JobsArgs, MessageFormat, RULES};
#[cfg(feature = "teleop")]
use crate::command::dataset::teleop::TeleopArgs;
use crate::command::{run, suite};
use crate::error::{CliError, HOST_ERRORS, INTERRUPTED, NOT_VERIFIED};
use crate::{output, planner};
use failures::FailuresArgs;
use hold::{DatasetValidateArgs, MergeArgs, SplitArgs};
use scene::{ALL_WORLDS, Scene, SceneArgs};
use show::{DatasetMcapArgs, DatasetShowArgs};

commands! {
    DatasetCommand

    /// Record random exploration of training worlds: sinusoidal steering and random speeds
    #[command(
        after_help = resumed(&[HOST_ERRORS, INTERRUPTED]),
        mut_arg("jobs", |arg| arg.help("Number of episodes that are driven in parallel; default: number of cores")),
        mut_arg("worlds", |arg| {
            let text = "Number of generated training worlds; default: one per four episodes, 10 to 90";
            arg.help(text).long_help(text)
        })
    )]
    Explore(ExploreArgs) => explore,
    /// Record demonstrations by planners, in tasks of training worlds
    #[command(after_help = resumed(&[HOST_ERRORS, INTERRUPTED]))]
    Drive(DatasetDriveArgs) => drive,
    /// Record demonstrations by people, who drive in the browser with keyboard or gamepad
    #[command(after_help = resumed(&[INTERRUPTED]))]
    Teleop(TeleopArgs) if feature = "teleop" => teleop::teleop,
    /// Extract the last seconds before each rollover or stuck end from a dataset or a run
    #[command(after_help = codes(&[HOST_ERRORS, INTERRUPTED]))]
    Failures(FailuresArgs) => failures::failures,
    /// Write an HTML report of a dataset, with figures and replays of example episodes
    Show(DatasetShowArgs) => show::show,
    /// Write episodes of a dataset as MCAP files for Foxglove
    Mcap(DatasetMcapArgs) => show::mcap,
    /// Validate a dataset: hashes, gaps, ranges, totals, worlds
    #[command(after_help = codes(&[NOT_VERIFIED]))]
    Validate(DatasetValidateArgs) => hold::validate,
    /// Merge several datasets
    Merge(MergeArgs) => hold::merge,
    /// Split a dataset by world, so that no world is in two parts
    Split(SplitArgs) => hold::split,
}

#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Exploration parameters: default (1 to 6 m/s), paper (2 m/s), or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) exploration: String,
    /// Duration of driving, s or with a unit
    #[arg(long, value_name = "TIME", default_value = "10h", value_parser = duration, conflicts_with = "episodes")]
    pub(crate) duration: f64,
    /// Number of episodes, instead of --duration
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) episodes: Option<u32>,
}

/// Which drives of planners become episodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Keeping {
    /// All drives.
    #[default]
    All,
    /// Drives that reach the goal.
    Success,
    /// Drives that don't reach the goal.
    Failure,
}

#[derive(Debug, Args)]
pub(crate) struct DatasetDriveArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    /// Planner: a WASM file, a native library, or a command; may be repeated
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner(), required = true)]
    pub(crate) plugin: Vec<PathBuf>,
    /// Planner parameter, with a single --plugin only; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Tasks to run, e.g. w001-w004,w007/t03 or elevation=high,terrain=rigid (different keys must hold together, values of one key
    /// are alternatives); default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Drives that become episodes
    #[arg(long, value_name = "WHICH", value_enum, default_value_t)]
    pub(crate) keep: Keeping,
    /// Rule profile: a name from list rules, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = RULES)]
    pub(crate) rules: String,
}

fn explore(args: &ExploreArgs) -> Result<(), CliError> {
    let exploration = Exploration::resolve(&args.exploration).map_err(CliError::input)?;
    let rules = Rules::resolve("exploration").map_err(CliError::internal)?;
    let frames = args.duration * f64::from(args.scene.hz);
    let (amount, shown) = match args.episodes {
        Some(n) => (Amount::Episodes(n as usize), Total::Episodes(n as usize)),
        None => (Amount::Frames(frames.ceil() as usize), Total::Frames(frames.ceil() as usize)),
    };
    let scene = Scene::of_worlds(&args.scene, rules, worlds_for(args))?;
    let layout = scene.layout(true, false);
    let header = Header { exploration: Some(exploration.clone()), ..scene.header(Kind::Explore, layout) };
    let mut writer = scene.writer(header)?;
    let mut told = Told::new(args.scene.format.get(), shown, args.scene.hz);
    let cancel = run::stop_on_ctrl_c()?;
    let done = scene
        .making(&cancel, args.jobs)
        .explore(&mut writer, &exploration, amount, &mut |p| told.progress(p))?;
    finish(writer, done, &args.scene.out, args.scene.format.get())
}

/// The number of training worlds for an exploration: only as many as it has use for, since each takes seconds to make.
fn worlds_for(args: &ExploreArgs) -> u32 {
    /// Episodes in a world.
    const EPISODES: f64 = 4.0;
    /// About how long an episode of the HMMWV lasts, s.
    const LENGTH_S: f64 = 18.0;
    /// Enough for the parts of a split.
    const LEAST: u32 = 10;
    let episodes = args.episodes.map_or(args.duration / LENGTH_S, f64::from);
    ((episodes / EPISODES).ceil().min(f64::from(ALL_WORLDS)) as u32).max(LEAST)
}

fn drive(args: &DatasetDriveArgs) -> Result<(), CliError> {
    if args.plugin.len() > 1 && !args.params.is_empty() {
        return Err(CliError::usage("--param: ambiguous with several planners (give one --plugin)"));
    }
    let rules = Rules::resolve(&args.rules).map_err(CliError::input)?;
    let scene = Scene::new(&args.scene, rules)?;
    let tasks = suite::select(&scene.worlds, args.tasks.as_deref())?;
    let limits = Limits::default();
    let mut plugins: Vec<Plugin> = Vec::new();
    let mut asked = Vec::new();
    for wanted in &args.plugin {
        let plugin = planner::load(wanted, &limits, false).map_err(|e| planner::unusable(&e))?;
        if plugins.iter().any(|known| known.sha256() == plugin.sha256()) {
            return Err(CliError::usage(format!(
                "--plugin {}: this planner is given twice, and its episodes would be duplicates (give it once)",
                wanted.display()
            )));
        }
        let (setting, metadata) = (&scene.setting, plugin.metadata());
        check_control_period(metadata, setting.options.step)?;
        check_perception(&plugin, &setting.perception)?;
        let params = plugin.params(&args.params).map_err(CliError::usage)?;
        asked.push(wants(&plugin, &setting.perception, params));
        plugins.push(plugin);
    }
    let planner =
        |(plugin, wants)| Planner { wants, driver: Box::new(move || Box::new(PluginDriver::new(plugin))) };
    let planners: Vec<_> = plugins.iter().zip(asked).map(planner).collect();
    let named = |plugin: &Plugin| PlannerHeader {
        name: plugin.metadata().name.clone(),
        version: plugin.metadata().version.clone(),
        sha256: plugin.sha256().to_owned(),
        params: args.params.iter().cloned().collect(),
    };
    let layout = scene.layout(false, true);
    let header =
        Header { planners: plugins.iter().map(named).collect(), ..scene.header(Kind::Drive, layout) };
    let kept = match args.keep {
        Keeping::All => Kept::All,
        Keeping::Success => Kept::Success,
        Keeping::Failure => Kept::Failure,
    };
    let mut writer = scene.writer(header)?;
    let mut told =
        Told::new(args.scene.format.get(), Total::Drives(planners.len() * tasks.len()), args.scene.hz);
    let cancel = run::stop_on_ctrl_c()?;
    let done = scene
        .making(&cancel, args.jobs)
        .drive(&mut writer, &planners, &tasks, kept, &mut |p| told.progress(p))?;
    finish(writer, done, &args.scene.out, args.scene.format.get())
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Progress { drives: usize, episodes: usize, frames: usize },
    Finished { out: &'a Path, episodes: usize, frames: usize, hash: &'a str },
}

/// How much there is to do.
enum Total {
    Episodes(usize),
    Frames(usize),
    Drives(usize),
}

/// Tells how a dataset comes on: a line for each twentieth.
struct Told {
    format: MessageFormat,
    total: Total,
    hz: u32,
    twentieths: usize,
}

impl Told {
    fn new(format: MessageFormat, total: Total, hz: u32) -> Self {
        Self { format, total, hz, twentieths: 0 }
    }

    fn progress(&mut self, p: Progress) {
        let (done, total) = match self.total {
            Total::Episodes(n) => (p.episodes, n),
            Total::Frames(n) => (p.frames, n),
            Total::Drives(n) => (p.drives, n),
        };
        let twentieths = 20 * done.min(total) / total.max(1);
        if twentieths == self.twentieths {
            return;
        }
        self.twentieths = twentieths;
        let Progress { drives, episodes, frames } = p;
        match self.format {
            MessageFormat::Json => output::json(&Message::Progress { drives, episodes, frames }),
            MessageFormat::Human => {
                let hours = frames as f64 / f64::from(self.hz) / 3600.0;
                output::note(&format!("{:3} %: {episodes} episodes, {hours:.2} h", 5 * twentieths));
            }
        }
    }
}

/// Writes what tells of the whole, and says where it is.
fn finish(writer: DatasetWriter, done: bool, out: &Path, format: MessageFormat) -> Result<(), CliError> {
    if !done {
        return Err(CliError::interrupted(format!(
            "stopped after {} episodes (continue with the same command and --resume)",
            writer.episodes()
        )));
    }
    tell(&writer.finish()?, out, format);
    Ok(())
}

/// Says what a finished dataset has.
fn tell(finished: &Finished, out: &Path, format: MessageFormat) {
    let Finished { episodes, frames, hash, summary } = finished;
    let (episodes, frames) = (*episodes, *frames);
    match format {
        MessageFormat::Json => output::json(&Message::Finished { out, episodes, frames, hash }),
        MessageFormat::Human => {
            let outcomes: Vec<String> =
                summary.outcomes.iter().map(|(name, n)| format!("{n} {name}")).collect();
            output::text(&format!(
                "{}: {episodes} episodes ({}), {frames} frames, {:.1} km; hash {hash}\n",
                out.display(),
                outcomes.join(", "),
                summary.distance_m / 1000.0
            ));
        }
    }
}

/// A data file's name and hash.
fn named(name: &str, hash: &str) -> DataHeader {
    DataHeader { name: name.to_owned(), hash: hash.to_owned() }
}
