//! What the datasets that are driven are made of: worlds, vehicle, perception.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use clap::Args;
use vb_dataset::{DATASET_SCHEMA, DatasetWriter, Format, Header, Kind, LICENCE, Layout, Making, keep_apart};
use vb_host::Limits;
use vb_record::DataHeader;
use vb_score::Rules;
use vb_trial::Setting;
use vb_world::Suite;

use super::named;
use crate::args::values::scale;
use crate::args::{FormatArgs, JobsArgs, PERCEPTION, ResumeArgs, SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE};
use crate::command::suite;
use crate::error::CliError;
use crate::places;

/// Options of the commands that record datasets.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Directory for the dataset
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) resume: ResumeArgs,
    /// Dataset name; default: COMMAND-VEHICLE-SEED
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Random seed; equal options and seeds give equal bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Suite of training worlds, from vb-harness suite generate --training; default: generated worlds
    #[arg(long, value_name = "DIR", conflicts_with_all = ["worlds", "world_seed"])]
    pub(crate) suite: Option<PathBuf>,
    /// Number of generated training worlds; default: 90
    ///
    /// 90 worlds contain all combinations of elevation level, terrain type and obstacle density equally often.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=999))]
    pub(crate) worlds: Option<u32>,
    /// Seed of the generated training worlds, 7000 to 7999
    #[arg(long, value_name = "N", default_value_t = 7100)]
    pub(crate) world_seed: u64,
    /// Another suite whose worlds must not be in the dataset, in addition to the shipped suites; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) apart_from: Vec<PathBuf>,
    /// Vehicle: a name from list vehicles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = VEHICLE)]
    pub(crate) vehicle: String,
    /// Soil set of deformable terrain: a name from list soils, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = SOILS)]
    pub(crate) soils: String,
    /// Perception profile (maps, sensors and their errors): a name from list profiles, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = PERCEPTION)]
    pub(crate) perception: String,
    /// Factor on all lengths of the world, 0.01 to 10, e.g. 1/6; default: the vehicle's scale
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Frames per second, 1 to 100
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub(crate) hz: u32,
    /// Rows and columns of the map crops around the vehicle in each frame; 0 for no crops
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=128))]
    pub(crate) crops: u16,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Training worlds that cover all combinations of relief, terrain and obstacles equally.
pub(super) const ALL_WORLDS: u32 = 90;
/// Options that change nothing of what a dataset has, and whether a value follows them.
const ELSEWHERE: [(&str, bool); 12] = [
    ("--out", true),
    ("-o", true),
    ("--jobs", true),
    ("-j", true),
    ("--resume", false),
    ("--json", false),
    ("--message-format", true),
    ("--quiet", false),
    ("-q", false),
    ("--verbose", false),
    ("-v", false),
    ("--color", true),
];

pub(super) struct Scene<'a> {
    args: &'a SceneArgs,
    pub(super) worlds: Suite,
    pub(super) setting: Setting,
    rules: DataHeader,
    vehicle: DataHeader,
    soils: DataHeader,
}

impl<'a> Scene<'a> {
    pub(super) fn new(args: &'a SceneArgs, rules: Rules) -> Result<Self, CliError> {
        Self::of_worlds(args, rules, ALL_WORLDS)
    }

    /// The same with so many training worlds, unless the user says how many.
    pub(super) fn of_worlds(args: &'a SceneArgs, rules: Rules, worlds: u32) -> Result<Self, CliError> {
        let vehicle = places::catalog().vehicle(&args.vehicle)?;
        let soils = places::catalog().soils(&args.soils, SOIL_RESOLUTION)?;
        let perception = places::catalog().perception(&args.perception)?;
        let worlds = match &args.suite {
            Some(dir) => suite::open(dir)?,
            None => suite::training(args.world_seed, args.worlds.unwrap_or(worlds))?,
        };
        let mut others = Vec::new();
        for dir in places::catalog().suites()?.iter().chain(&args.apart_from) {
            others.push(Suite::open(dir)?);
        }
        keep_apart(&worlds, &others)?;
        let scale = args.scale.unwrap_or(vehicle.spec.scale);
        let setting = Setting::new(&vehicle, &soils, &rules, &perception, TIME_STEP, scale, args.seed)?;
        Ok(Self {
            args,
            worlds,
            setting,
            rules: named(&rules.name, &rules.hash()),
            vehicle: named(&vehicle.spec.name, &vehicle.hash),
            soils: named(&soils.set.name, &soils.hash),
        })
    }

    /// The columns of a dataset whose driver tells the speed that it aims at, or has a goal.
    pub(super) fn layout(&self, speed: bool, goal: bool) -> Layout {
        let wheels = self.setting.vehicle.wheels as usize;
        let truth = !self.setting.perception.tells_the_truth();
        Layout { wheels, speed, goal, truth, crops: usize::from(self.args.crops) }
    }

    pub(super) fn header(&self, kind: Kind, layout: Layout) -> Header {
        let SceneArgs { seed, hz, name, .. } = self.args;
        let default = || format!("{}-{}-{seed}", kind.name(), self.vehicle.name);
        let Setting { perception, scale, options, .. } = &self.setting;
        Header {
            schema: DATASET_SCHEMA,
            format: Format::default(),
            name: name.clone().unwrap_or_else(default),
            kind,
            licence: LICENCE.to_owned(),
            harness_version: env!("CARGO_PKG_VERSION").to_owned(),
            harness_commit: env!("VB_COMMIT").to_owned(),
            command: command(),
            seed: *seed,
            hz: *hz,
            layout,
            vehicle: self.vehicle.clone(),
            soils: self.soils.clone(),
            rules: self.rules.clone(),
            perception: named(perception.name(), perception.sha256()),
            scale: *scale,
            time_step: options.step,
            worlds: named(&self.worlds.meta().name, &self.worlds.hash()),
            exploration: None,
            planners: Vec::new(),
            of_a_suite: false,
            options: std::collections::BTreeMap::new(),
        }
    }

    /// Begins the dataset, or goes on with it.
    pub(super) fn writer(&self, header: Header) -> Result<DatasetWriter, CliError> {
        let limit = self.setting.rules.time_limit(self.setting.scale, self.setting.vehicle.max_speed);
        let frames = limit * f64::from(header.hz);
        let begin = if self.args.resume.resume { DatasetWriter::resume } else { DatasetWriter::create };
        Ok(begin(&self.args.out, header, &self.worlds, frames.ceil() as usize)?)
    }

    pub(super) fn making(&self, cancel: &'a AtomicBool, jobs: JobsArgs) -> Making<'_> {
        let jobs = jobs.get();
        let stack_bytes = Limits::default().thread_stack_bytes();
        Making { setting: &self.setting, worlds: &self.worlds, hz: self.args.hz, jobs, stack_bytes, cancel }
    }
}

/// The arguments that the program was called with, without those that change nothing of a dataset.
pub(super) fn command() -> Vec<String> {
    let mut kept = Vec::new();
    let mut args = std::env::args_os().skip(1).map(|a| PathBuf::from(a).display().to_string());
    while let Some(arg) = args.next() {
        let elsewhere = ELSEWHERE.iter().find(|(name, _)| arg.split('=').next() == Some(name));
        // A value may follow the short name of an option at once, as in -j4.
        let has_value = ["-o", "-j"].iter().any(|short| arg.starts_with(short));
        match elsewhere {
            Some((_, true)) if !arg.contains('=') => drop(args.next()),
            Some(_) => {}
            None if has_value => {}
            None => kept.push(arg),
        }
    }
    kept
}
