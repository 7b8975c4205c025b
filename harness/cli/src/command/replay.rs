//! `vb-harness replay`, and the replays of a report.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};
use serde::Serialize;
use vb_record::{RunHeader, RunReader};
use vb_replay::{
    Links, Motion, PlannerSeries, Repeat, Replay, ReplayError, ReplayRun, SCRIPT_FILE, Sensed, Sensors,
    Setting, page, write_mcap, write_ros2_mcap,
};
use vb_report::Runs;
use vb_score::{Rules, TaskRecord};
use vb_sdk::metadata::Need;
use vb_sense::{Perception, Profile, Seed};
use vb_sim::{SimOptions, Soils};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Suite, TaskId, World};

use crate::args::{ForceArgs, FormatArgs, MessageFormat, ReplayData};
use crate::command::film::{self, FilmArgs};
use crate::error::CliError;
use crate::output;
use crate::places::{self, suite_of};

/// The messages of MCAP files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum McapProfile {
    /// Foxglove's schemas, with the world and the vehicle as solids.
    #[default]
    Foxglove,
    /// Messages of ROS 2, as in bags of rosbag2.
    Ros2,
}

/// Which messages MCAP files have.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct McapArgs {
    /// Messages of MCAP files: Foxglove's schemas, or those of ROS 2
    #[arg(long = "profile", value_name = "PROFILE", value_enum, default_value_t)]
    pub(crate) mcap_profile: McapProfile,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Run directories of one suite; the camera follows the first run, the others are ghosts
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Sensors to show, including sensors that the planner didn't request, e.g. lidar,depth,local-map, or none; default: the
    /// planner's sensors
    #[arg(long, value_name = "SENSOR,…", value_delimiter = ',')]
    pub(crate) sensors: Option<Vec<String>>,
    /// Perception profile of the sensors: a name from list profiles, or a file; default: the run's profile
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// Task to show, e.g. w012/t03
    #[arg(long, value_name = "WORLD/TASK")]
    pub(crate) task: TaskId,
    /// HTML file for the replay; default: a temporary file, opened in the browser
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Write an MCAP file; no HTML replay without --out
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) profile: McapArgs,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
    // The last, since its heading is over all that follows.
    #[command(flatten)]
    pub(crate) film: FilmArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Replay {
        task: &'a TaskId,
        exact: Vec<bool>,
        page: Option<&'a Path>,
        mcap: Option<&'a Path>,
        video: Option<&'a Path>,
        png: Option<&'a Path>,
    },
}

pub(crate) fn replay(args: &ReplayArgs) -> Result<(), CliError> {
    film::check(&args.film)?;
    let (own, drawn) = (args.out.iter().chain(&args.mcap), args.film.video.iter().chain(&args.film.png));
    let files: Vec<&Path> = own.clone().chain(drawn.clone()).map(PathBuf::as_path).collect();
    output::must_spare(&files, &args.runs)?;
    files.iter().try_for_each(|path| output::must_not_replace(path, args.force))?;
    // What can't be written is said before anything is simulated or drawn.
    own.into_iter().try_for_each(|path| output::must_be_writable(path))?;
    drawn.into_iter().try_for_each(|path| output::must_be_replaceable(path))?;
    let runs = Runs::read(&args.runs)?;
    let tasks = BTreeSet::from([args.task.clone()]);
    let filmed = args.film.video.is_some() || args.film.png.is_some();
    // Sensors are shown by the page and by the file for Foxglove.
    let seen = args.out.is_some() || args.mcap.is_some() || !filmed;
    let none = [String::from("none")];
    let sensors = if seen { args.sensors.as_deref() } else { Some(&none[..]) };
    let senses = Senses { sensors, perception: args.perception.as_deref() };
    let mut player = Player::new(&runs, &args.data, senses, &tasks)?;
    let replay = player.replay(&args.task)?.ok_or_else(|| {
        // A single task that some run lacks is a mistake; of many it is one that isn't done yet.
        let without = runs.runs.iter().find(|r| r.rows.iter().all(|row| row.task != args.task));
        let run = without.unwrap_or(&runs.runs[0]);
        CliError::usage(ReplayError::NoTask {
            dir: run.dir.clone(),
            task: args.task.clone(),
            done: run.rows.len(),
            example: run.rows.first().map_or_else(String::new, |r| r.task.to_string()),
        })
    })?;
    for r in replay.runs.iter().filter(|r| r.motion.repeat == Repeat::Samples) {
        output::say(&format!(
            "{}: shown from its samples, without ruts, because the simulation cannot be reproduced with these data (run with --trace \
             full, this version and these vehicle and soil files to reproduce it)",
            r.label
        ));
    }
    if let Some(path) = &args.mcap {
        mcap(path, &replay, args.profile)?;
    }
    if filmed {
        film::write(&replay, &args.film, args.format.get())?;
    }
    let page_file = match &args.out {
        Some(path) => {
            output::write(path, page(&replay, &Links::default(), None))?;
            Some(path.clone())
        }
        None if args.mcap.is_some() || filmed => None,
        None => {
            let path = temporary(&page(&replay, &Links::default(), None))?;
            open(&path);
            Some(path)
        }
    };
    if args.format.get() == MessageFormat::Json {
        let exact = replay.runs.iter().map(|r| r.motion.repeat == Repeat::Exact).collect();
        output::json(&Message::Replay {
            task: &args.task,
            exact,
            page: page_file.as_deref(),
            mcap: args.mcap.as_deref(),
            video: args.film.video.as_deref(),
            png: args.film.png.as_deref(),
        });
        return Ok(());
    }
    for path in page_file.iter().chain(&args.mcap).chain(&args.film.video).chain(&args.film.png) {
        output::say(&format!("wrote {}", path.display()));
    }
    Ok(())
}

/// A page in the folder for temporary files, which stays: the browser reads it after we are gone.
fn temporary(page: &str) -> Result<PathBuf, CliError> {
    let fail = |e: &dyn std::fmt::Display| {
        CliError::output(format!("cannot write a temporary file: {e} (give --out FILE)"))
    };
    let file =
        tempfile::Builder::new().prefix("vb-replay-").suffix(".html").tempfile().map_err(|e| fail(&e))?;
    std::fs::write(file.path(), page).map_err(|e| fail(&e))?;
    file.into_temp_path().keep().map_err(|e| fail(&e))
}

/// Opens the page if there is a screen.
pub(crate) fn open(path: &Path) {
    let screen =
        ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|v| std::env::var_os(v).is_some_and(|v| !v.is_empty()));
    if (cfg!(target_os = "linux") && !screen) || open::that_detached(path).is_err() {
        output::say(&format!("no browser found: open {} in a browser", path.display()));
    }
}

/// Writes replays of those of the tasks that all runs have done, as `WORLD/TASK.html` in a folder, and returns their names. They link to the
/// page `report` of their runs. The script that all share goes to the folder `script_in`; `script` is the way there from a replay.
pub(crate) fn pages(
    runs: &Runs,
    data: &ReplayData,
    tasks: &BTreeSet<TaskId>,
    report: &str,
    folder: &Path,
    (script_in, script): (&Path, &str),
) -> Result<BTreeSet<TaskId>, CliError> {
    let mut player = Player::new(runs, data, Senses::default(), tasks)?;
    let tasks = player.done(tasks);
    output::create_dir(script_in)?;
    output::write(&script_in.join(SCRIPT_FILE), vb_replay::script())?;
    let script = format!("{script}/{SCRIPT_FILE}");
    let mut made = BTreeSet::new();
    for (task, links) in tasks.iter().zip(Links::of_report(report, &tasks)) {
        let Some(replay) = player.replay(task)? else { continue };
        let path = folder.join(format!("{task}.html"));
        path.parent().map_or(Ok(()), output::create_dir)?;
        output::write(&path, page(&replay, &links, Some(&script)))?;
        made.insert(task.clone());
    }
    Ok(made)
}

/// Writes a replay as an MCAP file.
pub(crate) fn mcap(path: &Path, replay: &Replay, profile: McapArgs) -> Result<(), CliError> {
    let write = match profile.mcap_profile {
        McapProfile::Foxglove => write_mcap,
        McapProfile::Ros2 => write_ros2_mcap,
    };
    output::whole(path, |file| {
        let file = file.try_clone().map_err(|e| output::unwritten(path, &e))?;
        write(replay, file, path).map_err(CliError::output)
    })
}

/// A run with what its simulations take.
struct Part {
    header: RunHeader,
    label: String,
    reader: RunReader,
    records: BTreeMap<TaskId, TaskRecord>,
    rules: Option<Rules>,
    vehicle: VehicleModel,
    /// None where vehicle or soils at hand are not those of the run.
    soils: Option<Soils>,
    /// The profile, and the sensors that are shown under it; none where there are none beside pose and wheels.
    senses: Option<(Profile, Vec<Need>)>,
}

/// What is shown of sensors.
#[derive(Clone, Copy, Default)]
struct Senses<'a> {
    /// The sensors; those that the planner had if it isn't said.
    sensors: Option<&'a [String]>,
    /// The profile; that of the run if it isn't said.
    perception: Option<&'a str>,
}

impl Senses<'_> {
    /// The profile and the sensors for a run.
    fn of(self, header: &RunHeader) -> Result<Option<(Profile, Vec<Need>)>, CliError> {
        let named = match self.sensors {
            Some([none]) if none == "none" => return Ok(None),
            Some(named) => named,
            None => &header.plugin.sensors,
        };
        // What the user didn't say is in run.json.
        let unusable = |e: &dyn std::fmt::Display| match self.sensors {
            Some(_) => CliError::usage(format!("--sensors: {e}")),
            None => CliError::input(format!("run.json: plugin.sensors: {e}")),
        };
        let mut needs = Vec::new();
        for text in named {
            Need::add(&mut needs, text).map_err(|e| unusable(&format!("{text}: {e}")))?;
        }
        let name = self.perception.unwrap_or(&header.perception.name);
        let shows_nothing = needs.is_empty()
            || (needs.iter().all(|n| Need::DEFAULT.iter().any(|d| d.sensor == n.sensor))
                && self.sensors.is_none()
                && name == vb_sense::profile::ORACLE);
        if shows_nothing {
            return Ok(None);
        }
        let profile = places::catalog().perception(name)?;
        if self.perception.is_none() && profile.sha256() != header.perception.hash {
            output::say(&format!(
                "the available perception profile {name} differs from that of the run, so its sensor data are not shown (give the run's \
                 file with --perception)"
            ));
            return Ok(None);
        }
        vb_sense::check_needs(&profile, &needs).map_err(|e| unusable(&e))?;
        Ok(Some((profile, needs)))
    }
}

impl Part {
    /// The sensors of a task's vehicle; none if none is shown.
    fn sensors(&self, world: &Arc<World>, task: &TaskId) -> Option<Sensors> {
        let (profile, needs) = self.senses.as_ref()?;
        let seed = Seed { run: self.header.seed, task: task.to_string() };
        let scene = Sensors::scene(world);
        // The needs were held against the profile when the run was opened.
        let perception = Perception::new(profile, needs, &scene, self.vehicle.spec(), &seed).ok()?;
        Some(Sensors { perception })
    }
}

/// Makes replays of tasks.
struct Player {
    suite: Suite,
    parts: Vec<Part>,
    world: Option<Arc<World>>,
}

impl Player {
    /// Opens what replays of `tasks` take.
    fn new(
        runs: &Runs,
        data: &ReplayData,
        senses: Senses<'_>,
        tasks: &BTreeSet<TaskId>,
    ) -> Result<Self, CliError> {
        let first = &runs.runs[0];
        for other in &runs.runs[1..] {
            if other.header.scale != first.header.scale {
                return Err(CliError::usage(ReplayError::Differ {
                    first: first.dir.clone(),
                    second: other.dir.clone(),
                    field: "scale",
                }));
            }
        }
        let suite = suite_of(&first.header, data.suite.as_deref())?;
        let parts =
            runs.runs.iter().map(|r| part(r, data, senses, tasks)).collect::<Result<_, CliError>>()?;
        Ok(Self { suite, parts, world: None })
    }

    /// Those of the tasks that all runs have done, in their order.
    fn done<'a>(&self, tasks: impl IntoIterator<Item = &'a TaskId>) -> Vec<TaskId> {
        let all = |task: &&TaskId| self.parts.iter().all(|p| p.records.contains_key(*task));
        tasks.into_iter().filter(all).cloned().collect()
    }

    /// The replay of one of the tasks; none if a run hasn't done it.
    fn replay(&mut self, task: &TaskId) -> Result<Option<Replay>, CliError> {
        if self.parts.iter().any(|p| !p.records.contains_key(task)) {
            return Ok(None);
        }
        let scale = self.parts[0].header.scale;
        // Tasks come world by world.
        let world = match &self.world {
            Some(world) if world.id == task.world() => world.clone(),
            _ => {
                let world = self.suite.load_world(task.world())?;
                Arc::new(world.at_scale(scale))
            }
        };
        self.world = Some(world.clone());
        let found = world.task(task.task()).cloned();
        let found = found.ok_or_else(|| CliError::input(ReplayError::OtherSuite(task.clone())))?;
        let mut runs = Vec::new();
        for part in &self.parts {
            let Some(record) = part.records.get(task) else { return Ok(None) };
            if !part.reader.has_trace(task)? {
                return Err(CliError::input(ReplayError::NoTrace {
                    dir: part.reader.dir().to_owned(),
                    task: task.clone(),
                }));
            }
            let trace = part.reader.trace(task)?;
            let repeated = part.soils.as_ref().zip(part.rules.as_ref()).and_then(|(soils, rules)| {
                let start = vb_trial::start(rules.start, scale);
                let header = &part.header;
                let options = SimOptions {
                    step: header.time_step,
                    soil_resolution: header.soil_resolution,
                    start,
                    ..SimOptions::default()
                };
                let setting = Setting {
                    world: &world,
                    task: &found,
                    vehicle: &part.vehicle,
                    soils: &soils.set,
                    options,
                };
                Motion::repeated(&trace, &setting, part.sensors(&world, task), &record.state_hash)
            });
            let alone = || (Motion::sampled(&trace, Some(&part.vehicle)), Sensed::default());
            let (motion, sensed) = repeated.unwrap_or_else(alone);
            runs.push(ReplayRun {
                label: part.label.clone(),
                record: record.clone(),
                rules: part.rules.clone(),
                vehicle: Arc::new(part.vehicle.spec().clone()),
                motion,
                sensed,
                series: PlannerSeries::new(part.reader.debug(task)?),
            });
        }
        let goal_radius = self.parts[0].rules.as_ref().map(|rules| rules.goal_radius(scale));
        Ok(Some(Replay {
            world,
            task: found,
            suite: self.suite.meta().name.clone(),
            has_goal: true,
            goal_radius,
            runs,
        }))
    }
}

fn part(
    r: &vb_report::Run,
    data: &ReplayData,
    senses: Senses<'_>,
    tasks: &BTreeSet<TaskId>,
) -> Result<Part, CliError> {
    let header = r.header.clone();
    let vehicle = places::catalog()
        .vehicle(data.vehicle.as_deref().unwrap_or(&header.vehicle.name))
        .map_err(|e| CliError::input(format!("{e}; give the run's vehicle with --vehicle")))?;
    let same_vehicle = vehicle.hash == header.vehicle.hash;
    let soils = places::catalog()
        .soils(data.soils.as_deref().unwrap_or(&header.soils.name), header.soil_resolution)
        .ok();
    let spec: VehicleSpec = vehicle.spec;
    let vehicle = VehicleModel::new(spec).map_err(CliError::input)?;
    let reader = RunReader::open(&r.dir)?;
    let mut records = BTreeMap::new();
    reader.each_record(|record: TaskRecord| {
        if tasks.contains(&record.task) {
            records.insert(record.task.clone(), record);
        }
    })?;
    Ok(Part {
        soils: soils.filter(|s| same_vehicle && s.hash == header.soils.hash),
        rules: Rules::recorded(&header).ok(),
        label: r.label.clone(),
        senses: senses.of(&header)?,
        header,
        reader,
        records,
        vehicle,
    })
}
