//! The command line.

mod common;
#[cfg(feature = "dataset")]
mod dataset;
mod exit_codes;
mod list;
mod plugin;
mod results;
#[cfg(feature = "ros")]
mod ros;
mod run;
mod shell;
#[cfg(feature = "terrain")]
mod site;
mod submission;
mod suite;
mod sweep;
#[cfg(feature = "terrain")]
mod terrain;
mod values;
#[cfg(feature = "vehicle")]
mod vehicle;

use std::ffi::OsString;

use clap::{ColorChoice, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use crate::error::{
    FAILED_START, HOST_ERRORS, INCOMPLETE, INTERRUPTED, NOT_CONFORMING, NOT_VERIFIED, SIM_ERRORS,
};
pub(crate) use common::{
    ForceArgs, FormatArgs, GlobalArgs, JobsArgs, MessageFormat, PERCEPTION, PlannerArgs, PluginArgs, RULES,
    ResumeArgs, SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE,
};
#[cfg(feature = "teleop")]
pub(crate) use dataset::TeleopArgs;
#[cfg(feature = "dataset")]
pub(crate) use dataset::{
    DatasetCommand, DatasetDriveArgs, DatasetMcapArgs, DatasetShowArgs, DatasetValidateArgs, ExploreArgs,
    FailuresArgs, Keeping, MergeArgs, SceneArgs, SplitArgs,
};
use exit_codes::{codes, resumed};
pub(crate) use list::{ListArgs, Listed};
pub(crate) use plugin::{InspectArgs, InstallArgs, Language, NewArgs, PluginCommand, StampArgs};
#[cfg(feature = "replay")]
pub(crate) use results::{CameraName, FilmArgs, McapArgs, McapProfile, ReplayArgs};
pub(crate) use results::{ReplayData, ReportArgs};
#[cfg(feature = "ros")]
pub(crate) use ros::RosArgs;
pub(crate) use run::{CheckArgs, CommandsArgs, MergeRunArgs, RunArgs, ScoreArgs};
pub(crate) use shell::{CompletionsArgs, ManArgs};
#[cfg(feature = "terrain")]
pub(crate) use site::{ImportArgs, SiteArgs};
pub(crate) use submission::{BuildArgs, EvaluateArgs, LeaderboardCommand, SubmitArgs, VerifyArgs};
pub(crate) use suite::{
    DrawnArgs, GenerateArgs, ProveArgs, ShowArgs, SuiteCommand, TasksArgs, TasksCommand, TestbedArgs,
    ValidateArgs,
};
pub(crate) use sweep::{SweepArgs, SweepCommand, SweepRunArgs};
#[cfg(feature = "terrain")]
pub(crate) use terrain::{FitArgs, MeasureArgs, SurfaceArgs, TerrainCommand, TrainArgs};
#[cfg(feature = "vehicle")]
pub(crate) use vehicle::{
    VehicleArgs, VehicleBagArgs, VehicleCommand, VehicleCompareArgs, VehicleImportArgs, VehicleShowArgs,
    VehicleTestArgs,
};

/// Benchmark for off-road planners: runs a planner over the tasks of a suite and scores it.
///
/// First steps: vb-harness list planners, vb-harness run pid.wasm --suite smoke, vb-harness report runs/pid-1
#[derive(Debug, Parser)]
#[command(
    name = "vb-harness",
    version = concat!(env!("CARGO_PKG_VERSION"), " (commit ", env!("VB_COMMIT"), ")"),
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) global: GlobalArgs,
}

impl Cli {
    /// What the program was called with.
    pub(crate) fn of_the_program() -> Result<Self, clap::Error> {
        let args = with_command(std::env::args_os().collect());
        // Help is printed before the options are known.
        let command = Self::documented().color(color(&args));
        let matches = command.clone().try_get_matches_from(args)?;
        Self::from_arg_matches(&matches).map_err(|e| e.format(&mut command.clone()))
    }

    /// The commands, with their exit codes in their help.
    pub(crate) fn documented() -> clap::Command {
        exit_codes::document(Self::command())
    }
}

/// The arguments, with `run` in front of the first option if no command is there: `vb-harness --plugin FILE` is a run.
fn with_command(mut args: Vec<OsString>) -> Vec<OsString> {
    let mut k = 1;
    while let Some(arg) = args.get(k).and_then(|arg| arg.to_str()) {
        match arg {
            "-h" | "--help" | "-V" | "--version" => break,
            "-q" | "--quiet" | "-v" | "--verbose" => k += 1,
            "--color" => k += 2,
            _ if arg.starts_with("--color=") => k += 1,
            _ => {
                if arg.starts_with('-') {
                    args.insert(k, "run".into());
                }
                break;
            }
        }
    }
    args
}

/// The colours that arguments ask for; auto if they ask for none, or for something else.
fn color(args: &[OsString]) -> ColorChoice {
    let mut values = args.iter().enumerate().filter_map(|(k, arg)| {
        let arg = arg.to_str()?;
        if arg == "--color" { args.get(k + 1)?.to_str() } else { arg.strip_prefix("--color=") }
    });
    values.next_back().and_then(|value| value.parse().ok()).unwrap_or_default()
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a planner over a suite
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Run(RunArgs),
    /// Run a planner that is a ROS 2 node over a suite, in lockstep over DDS
    #[cfg(feature = "ros")]
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Ros(RosArgs),
    /// List what is shipped or installed: suites, vehicles, planners, rules, soils, perception profiles
    List(ListArgs),
    /// Join the shards of a run
    #[command(after_help = codes(&[SIM_ERRORS, INCOMPLETE]))]
    Merge(MergeRunArgs),
    /// Run a sweep: many runs that combine planners, parameters, vehicles, perception profiles and seeds
    #[command(subcommand)]
    Sweep(SweepCommand),
    /// Re-score a finished run from its traces, without simulation
    Score(ScoreArgs),
    /// Write an HTML report, tables and figures of one or more runs
    Report(ReportArgs),
    /// Show a task of one or more runs as a 3D replay in the browser, or write a video, picture or MCAP file
    #[cfg(feature = "replay")]
    Replay(ReplayArgs),
    /// Make, show, validate, merge and split datasets for offline learning
    #[cfg(feature = "dataset")]
    #[command(subcommand)]
    Dataset(DatasetCommand),
    /// Write the commands of a run as a file that drives its tasks again without the planner
    Commands(CommandsArgs),
    /// Make a submission from a planner or a finished run: a small folder that others can verify
    #[command(
        after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]),
        mut_arg("planner", |arg| arg.help("Planner: a WASM file, or for the open division a native library or a recording"))
    )]
    Submit(SubmitArgs),
    /// Verify a submission: compare it with suite and planner, and re-run tasks
    #[command(after_help = codes(&[HOST_ERRORS, NOT_VERIFIED, INTERRUPTED]))]
    Verify(VerifyArgs),
    /// Score a planner on a hidden suite, and report only figures over all tasks
    #[command(
        after_help = codes(&[SIM_ERRORS, HOST_ERRORS, INTERRUPTED]),
        mut_arg("planner", |arg| arg.help("Planner: a WASM file"))
    )]
    Evaluate(EvaluateArgs),
    /// Build a leaderboard site
    #[command(subcommand)]
    Leaderboard(LeaderboardCommand),
    /// Show a planner's metadata: version, interface, parameters, requested sensors
    #[command(mut_arg("planner", |arg| arg.help("Planner: a WASM file, a native library, or a command, which is started")))]
    Inspect(InspectArgs),
    /// Check whether a planner meets all requirements, such as determinism and head-room
    #[command(after_help = codes(&[HOST_ERRORS, NOT_CONFORMING, INTERRUPTED]))]
    Check(CheckArgs),
    /// Create planner projects, write metadata into WASM files, install planners
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// Show, validate, generate and import suites
    #[command(subcommand)]
    Suite(SuiteCommand),
    /// List the tasks of a suite
    #[command(subcommand)]
    Tasks(TasksCommand),
    /// Show, validate and test vehicles
    #[cfg(feature = "vehicle")]
    #[command(subcommand)]
    Vehicle(VehicleCommand),
    /// Train terrain models on elevation data, generate surfaces from them, measure elevation files
    #[cfg(feature = "terrain")]
    #[command(subcommand)]
    Terrain(TerrainCommand),
    /// Write a shell completion script to stdout
    Completions(CompletionsArgs),
    /// Write manual pages
    Man(ManArgs),
}

/// The command of a command line, for tests.
#[cfg(test)]
pub(crate) fn parsed(args: &[&str]) -> Command {
    Cli::parse_from(["vb-harness"].iter().chain(args)).command
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A snapshot, so that a change of any text is seen where it is made: `INSTA_UPDATE=always cargo test -p vb-harness` takes it.
    #[test]
    fn the_help_of_every_command_is_as_it_was() {
        fn add(command: &mut clap::Command, path: &str, text: &mut String) {
            use std::fmt::Write as _;
            write!(text, "# vb-harness{path}\n\n{}\n", command.render_long_help()).expect("it is text");
            let inner: Vec<_> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
            for name in inner.iter().filter(|name| *name != "help") {
                let command = command.find_subcommand_mut(name).expect("it is one of them");
                add(command, &format!("{path} {name}"), text);
            }
        }
        let mut text = String::new();
        let mut program = Cli::documented().term_width(120);
        program.build();
        add(&mut program, "", &mut text);
        let text: Vec<&str> = text.lines().map(str::trim_end).collect();
        insta::assert_snapshot!("help", text.join("\n"));
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::documented().debug_assert();
    }

    #[test]
    fn an_import_takes_each_ground_by_its_name_and_the_described_one_without() {
        use vb_suite::import::Ground;
        let ground = |more: &[&str]| {
            let args = [&["vb-harness", "suite", "import", "BenchMaps", "--out", "original"], more].concat();
            match Cli::try_parse_from(args).unwrap().command {
                Command::Suite(SuiteCommand::Import(args)) => Ground::from(args.ground),
                other => panic!("{other:?}"),
            }
        };
        for wanted in Ground::ALL {
            assert_eq!(ground(&["--ground", wanted.name()]), wanted);
        }
        assert_eq!(ground(&[]), Ground::AsDescribed);
    }

    #[test]
    fn every_command_with_results_takes_json_by_either_option() {
        fn options(command: &clap::Command, path: &str, bare: &mut Vec<String>) {
            let has = |name: &str| command.get_arguments().any(|a| a.get_long() == Some(name));
            assert_eq!(has("json"), has("message-format"), "{path}");
            if !command.has_subcommands() && !has("json") {
                bare.push(path.trim_start().to_owned());
            }
            command.get_subcommands().for_each(|c| options(c, &format!("{path} {}", c.get_name()), bare));
        }
        let mut bare = Vec::new();
        options(&Cli::documented(), "", &mut bare);
        // They write files, or say that all is well.
        let makers = [
            "plugin new",
            "plugin stamp",
            "plugin install",
            "suite import",
            "suite generate",
            "suite site",
            "suite testbed",
            "vehicle validate",
            "vehicle import",
            "terrain train",
            "terrain generate",
            "terrain measure",
            "terrain fit",
            "completions",
            "man",
        ];
        assert_eq!(bare, makers);
    }

    #[test]
    fn out_and_jobs_have_the_same_short_names_on_every_command() {
        fn look(command: &clap::Command, path: &str) {
            for (long, short) in [("out", 'o'), ("jobs", 'j'), ("quiet", 'q'), ("verbose", 'v')] {
                for arg in command.get_arguments() {
                    assert_eq!(arg.get_long() == Some(long), arg.get_short() == Some(short), "{path} {arg}");
                }
            }
            command.get_subcommands().for_each(|c| look(c, &format!("{path} {}", c.get_name())));
        }
        look(&Cli::documented(), "");
    }

    fn parse(args: &[&str]) -> Result<Command, clap::Error> {
        let args = ["vb-harness"].iter().chain(args).map(OsString::from).collect();
        Cli::try_parse_from(with_command(args)).map(|cli| cli.command)
    }

    fn parsed_run(args: &[&str]) -> RunArgs {
        match parse(args) {
            Ok(Command::Run(args)) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn run_is_the_command_before_a_first_option_and_not_in_the_help_of_the_program() {
        let long = parsed_run(&["run", "--plugin", "a.wasm", "--seed", "7"]);
        for short in [
            &["--plugin", "a.wasm", "--seed", "7"][..],
            &["-q", "--color", "never", "--seed", "7", "--plugin=a.wasm"],
        ] {
            assert_eq!(format!("{:?}", parsed_run(short)), format!("{long:?}"));
        }
        assert!(parse(&[]).is_err() && parse(&["run"]).is_err() && parse(&["a.wasm"]).is_err());
        assert!(matches!(parse(&["score", "runs/a"]), Ok(Command::Score(_))));
        assert_eq!(parse(&["-v", "vehicle", "validate", "a.yaml"]).is_ok(), cfg!(feature = "vehicle"));
        // No command has a second name that the help omits.
        for group in ["suite", "vehicle", "dataset"] {
            assert!(parse(&[group, "check", "a"]).is_err(), "{group}");
        }
        let help = parse(&["--help"]).unwrap_err().to_string();
        assert!(
            help.contains("Usage: vb-harness [OPTIONS] <COMMAND>") && !help.contains("--trace"),
            "{help}"
        );
    }

    #[test]
    fn the_default_of_a_list_is_what_a_user_could_give() {
        let friction = |more: &[&str]| match parse(&[&["vehicle", "compare", "v", "r.csv"], more].concat()) {
            Ok(Command::Vehicle(VehicleCommand::Compare(args))) => args.friction,
            other => panic!("{other:?}"),
        };
        assert_eq!(friction(&[]), friction(&["--friction", "0.2,0.3,0.4,0.5,0.6,0.8,1"]));
        assert_eq!(friction(&[]).len(), 7);
    }

    #[test]
    fn a_planner_is_an_argument_or_an_option() {
        for command in ["run", "check", "inspect"] {
            assert!(parse(&[command, "a.wasm"]).is_ok() && parse(&[command, "--plugin", "a.wasm"]).is_ok());
            assert!(parse(&[command]).is_err() && parse(&[command, "a.wasm", "--plugin", "b.wasm"]).is_err());
        }
        assert!(parse(&["submit", "a.wasm", "-o", "s"]).is_ok());
        assert!(parse(&["evaluate", "a.wasm", "--suite", "hidden"]).is_ok());
        let plugin = |args: &[&str]| parsed_run(args).plugin.path().to_owned();
        assert_eq!(plugin(&["run", "./a.wasm"]), plugin(&["run", "--plugin", "./a.wasm"]));
    }

    #[test]
    fn a_task_can_be_filmed_and_pictured_at_once_and_each_option_needs_its_output() {
        let replay = |more: &[&str]| parse(&[&["replay", "r", "--task", "w001/t00"], more].concat());
        assert!(replay(&["--video", "v.gif", "--png", "p.png", "--fps", "5", "--camera", "top"]).is_ok());
        assert!(replay(&["--png", "p.png", "--camera", "top", "--at", "500ms"]).is_ok());
        for lacking in [&["--png", "p.png", "--fps", "5"][..], &["--camera", "top"], &["--no-captions"]] {
            assert!(replay(lacking).is_err(), "{lacking:?}");
        }
    }

    #[test]
    fn global_options_are_taken_before_and_after_the_command() {
        for args in [["vb-harness", "-q", "score", "r"], ["vb-harness", "score", "r", "-q"]] {
            assert!(Cli::try_parse_from(args).unwrap().global.quiet);
        }
        assert!(Cli::try_parse_from(["vb-harness", "-q", "-v", "score", "r"]).is_err());
        let asked = |args: &[&str]| color(&args.iter().map(OsString::from).collect::<Vec<_>>());
        assert_eq!(asked(&["vb-harness", "--help"]), ColorChoice::Auto);
        assert_eq!(asked(&["vb-harness", "--color", "never", "--help"]), ColorChoice::Never);
        assert_eq!(asked(&["vb-harness", "run", "--color=always"]), ColorChoice::Always);
    }

    /// The defaults of runs as the documentation has them, and as the benchmark's conditions want them.
    #[test]
    fn the_defaults_of_a_run_are_those_of_the_benchmark() {
        let run = RunArgs::new(std::path::Path::new("-a.wasm"));
        assert_eq!(run.plugin.path(), std::path::Path::new("-a.wasm"));
        let super::run::DriveArgs { rules, vehicle, soils, perception, .. } = &run.drive;
        let names = [rules, vehicle, soils, perception].map(String::as_str);
        assert_eq!(names, ["paper", "hmmwv", "default", "oracle"]);
        assert_eq!(run.drive.suite, std::path::Path::new("vb-100"));
        assert_eq!((run.drive.time_step, run.drive.soil_resolution, run.drive.seed), (0.001, 0.1, 0));
        assert_eq!(
            (run.drive.trace, run.drive.logs),
            (vb_record::TraceMode::TenHz, vb_record::LogMode::Failed)
        );
        assert!(
            run.drive.tasks.is_none()
                && run.drive.out.is_none()
                && run.drive.scale.is_none()
                && !run.drive.resume.resume
        );
        let parsed = parsed_run(&["run", "--plugin=-a.wasm"]);
        assert_eq!(format!("{run:?}"), format!("{parsed:?}"));
        // Where the default depends on another option it is in the text alone.
        let mut command = Cli::documented();
        let help = command.find_subcommand_mut("submit").unwrap().render_help().to_string();
        let suite = format!("default: {}, or the suite of --run", vb_catalog::DEFAULT_SUITE);
        assert!(help.split_whitespace().collect::<Vec<_>>().join(" ").contains(&suite), "{help}");
    }
}
