//! `vb-harness dataset`.

mod failures;
mod hold;
mod scene;
mod show;
#[cfg(feature = "teleop")]
mod teleop;

use std::path::Path;

use serde::Serialize;
use vb_dataset::{
    Amount, DatasetWriter, Exploration, Finished, Header, Kept, Kind, Planner, PlannerHeader, Progress,
};
use vb_host::{Limits, Plugin};
use vb_record::DataHeader;
use vb_runner::{PluginDriver, check_control_period, check_perception, wants};
use vb_score::Rules;

use crate::args::{DatasetCommand, DatasetDriveArgs, ExploreArgs, Keeping, MessageFormat};
use crate::error::CliError;
use crate::{output, planner, run, suite};
use scene::{ALL_WORLDS, Scene};

impl DatasetCommand {
    /// Does what it says.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        match self {
            Self::Explore(args) => explore(args),
            Self::Drive(args) => drive(args),
            #[cfg(feature = "teleop")]
            Self::Teleop(args) => teleop::teleop(args),
            Self::Failures(args) => failures::failures(args),
            Self::Show(args) => show::show(args),
            Self::Mcap(args) => show::mcap(args),
            Self::Validate(args) => hold::validate(args),
            Self::Merge(args) => hold::merge(args),
            Self::Split(args) => hold::split(args),
        }
    }
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
