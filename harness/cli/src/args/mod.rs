//! The command line.

mod common;
mod dataset;
mod exit_codes;
mod plugin;
mod results;
mod run;
mod shell;
mod submission;
mod suite;
mod sweep;
mod terrain;
mod values;
mod vehicle;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

pub(crate) use common::{FormatArgs, JobsArgs, MessageFormat, PlannerArgs};
pub(crate) use dataset::{
    DatasetCommand, DatasetDriveArgs, DatasetMcapArgs, DatasetShowArgs, DatasetValidateArgs, ExploreArgs,
    FailuresArgs, Keeping, MergeArgs, SceneArgs, SplitArgs, TeleopArgs,
};
pub(crate) use plugin::{InspectArgs, InstallArgs, Language, NewArgs, PluginCommand, StampArgs};
pub(crate) use results::{CameraName, FilmArgs, ReplayArgs, ReplayData, ReportArgs};
pub(crate) use run::{CheckArgs, MergeRunArgs, RunArgs, ScoreArgs};
pub(crate) use shell::{CompletionsArgs, ManArgs};
pub(crate) use submission::{BuildArgs, EvaluateArgs, LeaderboardCommand, SubmitArgs, VerifyArgs};
pub(crate) use suite::{
    DrawnArgs, GenerateArgs, ImportArgs, ProveArgs, ShowArgs, SiteArgs, SuiteCommand, SuiteListArgs,
    TasksArgs, TasksCommand, TestbedArgs, ValidateArgs,
};
pub(crate) use sweep::{SweepArgs, SweepCommand, SweepRunArgs};
pub(crate) use terrain::{FitArgs, MeasureArgs, SurfaceArgs, TerrainCommand, TrainArgs};
pub(crate) use vehicle::{VehicleArgs, VehicleCommand, VehicleListArgs, VehicleShowArgs, VehicleTestArgs};

/// Benchmark for off-road planners: runs a planner over the tasks of a suite and scores it.
#[derive(Debug, Parser)]
#[command(
    name = "vb-harness",
    version = concat!(env!("CARGO_PKG_VERSION"), " (commit ", env!("VB_COMMIT"), ")"),
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    override_usage = "vb-harness --plugin FILE [OPTIONS]\n       vb-harness COMMAND"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) run: Option<RunArgs>,
}

impl Cli {
    /// What the program was called with.
    pub(crate) fn of_the_program() -> Result<Self, clap::Error> {
        let matches = Self::documented().try_get_matches()?;
        Self::from_arg_matches(&matches).map_err(|e| e.format(&mut Self::documented()))
    }

    /// The commands, with their exit codes in their help.
    pub(crate) fn documented() -> clap::Command {
        exit_codes::document(Self::command())
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a planner over a suite (default command)
    Run(RunArgs),
    /// Join the shards of a run
    Merge(MergeRunArgs),
    /// Run a sweep: many runs that combine planners, parameters, vehicles, perception profiles and seeds
    #[command(subcommand)]
    Sweep(SweepCommand),
    /// Re-score a finished run from its traces, without simulation
    Score(ScoreArgs),
    /// Write an HTML report, tables and figures of one or more runs
    Report(ReportArgs),
    /// Show a task of one or more runs as a 3D replay in the browser, or write a video, picture or MCAP file
    Replay(ReplayArgs),
    /// Make, show, validate, merge and split datasets for offline learning
    #[command(subcommand)]
    Dataset(DatasetCommand),
    /// Make a submission from a planner or a finished run: a small folder that others can verify
    Submit(SubmitArgs),
    /// Verify a submission: compare it with suite and planner, and re-run tasks
    Verify(VerifyArgs),
    /// Score a planner on a hidden suite, and report only figures over all tasks
    Evaluate(EvaluateArgs),
    /// Build a leaderboard site
    #[command(subcommand)]
    Leaderboard(LeaderboardCommand),
    /// Show a planner's metadata: version, interface, parameters, requested sensors
    Inspect(InspectArgs),
    /// Check whether a planner meets all requirements, such as determinism and head-room
    Check(CheckArgs),
    /// Create planner projects, write metadata into WASM files, install planners
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// List, show, validate, generate and import suites
    #[command(subcommand)]
    Suite(SuiteCommand),
    /// List the tasks of a suite
    #[command(subcommand)]
    Tasks(TasksCommand),
    /// List, show, validate and test vehicles
    #[command(subcommand)]
    Vehicle(VehicleCommand),
    /// Train terrain models on elevation data, generate surfaces from them, measure elevation files
    #[command(subcommand)]
    Terrain(TerrainCommand),
    /// Write a shell completion script to stdout
    Completions(CompletionsArgs),
    /// Write manual pages
    Man(ManArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

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
                Some(Command::Suite(SuiteCommand::Import(args))) => Ground::from(args.ground),
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
    fn the_step_of_the_simulation_has_one_name_and_its_old_one_still_works() {
        for name in ["--time-step", "--step"] {
            let cli = Cli::try_parse_from(["vb-harness", "vehicle", "test", "hmmwv", name, "0.25"]).unwrap();
            let Some(Command::Vehicle(VehicleCommand::Test(args))) = cli.command else { panic!("{name}") };
            assert_eq!(args.time_step, 0.25);
        }
        let mut command = Cli::documented();
        let test =
            command.find_subcommand_mut("vehicle").and_then(|c| c.find_subcommand_mut("test")).unwrap();
        let help = test.render_long_help().to_string();
        assert!(help.contains("--time-step") && !help.contains(" --step"), "{help}");
    }

    #[test]
    fn run_is_the_default_command() {
        let with = |args: &[&str]| Cli::try_parse_from([&["vb-harness"], args].concat());
        let short = with(&["--plugin", "a.wasm", "--seed", "7"]).unwrap();
        assert!(short.command.is_none());
        let Some(Command::Run(long)) = with(&["run", "--plugin", "a.wasm", "--seed", "7"]).unwrap().command
        else {
            panic!("run is a command")
        };
        let short = short.run.unwrap();
        assert_eq!(format!("{short:?}"), format!("{long:?}"));
        assert!(with(&[]).is_err() && with(&["run"]).is_err());
        assert!(with(&["score", "runs/a"]).unwrap().run.is_none());
        assert!(with(&["--plugin", "a.wasm", "--resume"]).unwrap().run.unwrap().out.is_none());
        assert!(with(&["vehicle", "check", "a.yaml"]).is_ok() && with(&["suite", "check", "smoke"]).is_ok());
    }

    #[test]
    fn a_run_for_a_submission_is_one_of_which_nothing_is_said() {
        let said = Cli::try_parse_from(["vb-harness", "--plugin", "a.wasm"]).unwrap().run.unwrap();
        assert_eq!(format!("{said:?}"), format!("{:?}", RunArgs::new(Path::new("a.wasm"))));
    }
}
