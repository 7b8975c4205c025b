//! The commands. Each has a file or a folder with its arguments and its work; a new one is that file and a line here.

/// Declares a set of commands as an enum for clap, with a method that executes the chosen one: a line for each,
/// `Name(Arguments) => function`, or `Name(Arguments) if feature = "…" => function` where it needs a feature. Attributes are clap's.
macro_rules! commands {
    ($set:ident $($(#[$about:meta])* $name:ident($args:ty) $(if $needs:meta)? => $run:path,)*) => {
        #[derive(Debug, clap::Subcommand)]
        pub(crate) enum $set {
            $($(#[cfg($needs)])? $(#[$about])* $name($args),)*
        }

        impl $set {
            /// Executes the command.
            pub(crate) fn run(&self) -> Result<(), crate::error::CliError> {
                match self {
                    $($(#[cfg($needs)])? Self::$name(args) => $run(args),)*
                }
            }
        }
    };
}

mod check;
#[cfg(feature = "dataset")]
mod dataset;
#[cfg(feature = "replay")]
mod film;
#[cfg_attr(not(feature = "terrain"), path = "without_geojson.rs")]
mod geojson;
mod inspect;
mod leaderboard;
mod list;
mod merge;
mod plugin;
mod recording;
#[cfg_attr(not(feature = "replay"), path = "without_replay.rs")]
mod replay;
mod report;
#[cfg(feature = "ros")]
mod ros;
mod run;
mod score;
mod shell;
mod submission;
mod suite;
mod sweep;
#[cfg(feature = "terrain")]
mod terrain;
#[cfg(feature = "vehicle")]
mod vehicle;

use crate::args::exit_codes::{codes, resumed};
use crate::error::{
    FAILED_START, HOST_ERRORS, INCOMPLETE, INTERRUPTED, NOT_CONFORMING, NOT_VERIFIED, SIM_ERRORS,
};

commands! {
    Command

    /// Run a planner over a suite
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Run(run::RunArgs) => run::run,
    /// Run a planner that is a ROS 2 node over a suite, in lockstep over DDS
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Ros(ros::RosArgs) if feature = "ros" => ros::ros,
    /// List what is shipped or installed: suites, vehicles, planners, rules, soils, perception profiles
    List(list::ListArgs) => list::list,
    /// Join the shards of a run
    #[command(after_help = codes(&[SIM_ERRORS, INCOMPLETE]))]
    Merge(merge::MergeRunArgs) => merge::merge,
    /// Run a sweep: many runs that combine planners, parameters, vehicles, perception profiles and seeds
    #[command(subcommand)]
    Sweep(sweep::SweepCommand) => sweep::SweepCommand::run,
    /// Re-score a finished run from its traces, without simulation
    Score(score::ScoreArgs) => score::score,
    /// Write an HTML report, tables and figures of one or more runs
    Report(report::ReportArgs) => report::report,
    /// Show a task of one or more runs as a 3D replay in the browser, or write a video, picture or MCAP file
    Replay(replay::ReplayArgs) if feature = "replay" => replay::replay,
    /// Make, show, validate, merge and split datasets for offline learning
    #[command(subcommand)]
    Dataset(dataset::DatasetCommand) if feature = "dataset" => dataset::DatasetCommand::run,
    /// Write the commands of a run as a file that drives its tasks again without the planner
    Commands(recording::CommandsArgs) => recording::commands,
    /// Make a submission from a planner or a finished run: a small folder that others can verify
    #[command(
        after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]),
        mut_arg("planner", |arg| arg.help("Planner: a WASM file, or for the open division a native library or a recording"))
    )]
    Submit(submission::SubmitArgs) => submission::submit,
    /// Verify a submission: compare it with suite and planner, and re-run tasks
    #[command(after_help = codes(&[HOST_ERRORS, NOT_VERIFIED, INTERRUPTED]))]
    Verify(submission::VerifyArgs) => submission::verify,
    /// Score a planner on a hidden suite, and report only figures over all tasks
    #[command(
        after_help = codes(&[SIM_ERRORS, HOST_ERRORS, INTERRUPTED]),
        mut_arg("planner", |arg| arg.help("Planner: a WASM file"))
    )]
    Evaluate(submission::EvaluateArgs) => submission::evaluate,
    /// Build a leaderboard site
    #[command(subcommand)]
    Leaderboard(leaderboard::LeaderboardCommand) => leaderboard::LeaderboardCommand::run,
    /// Show a planner's metadata: version, interface, parameters, requested sensors
    #[command(mut_arg("planner", |arg| arg.help("Planner: a WASM file, a native library, or a command, which is started")))]
    Inspect(inspect::InspectArgs) => inspect::inspect,
    /// Check whether a planner meets all requirements, such as determinism and head-room
    #[command(after_help = codes(&[HOST_ERRORS, NOT_CONFORMING, INTERRUPTED]))]
    Check(check::CheckArgs) => check::check,
    /// Create planner projects, write metadata into WASM files, install planners
    #[command(subcommand)]
    Plugin(plugin::PluginCommand) => plugin::PluginCommand::run,
    /// Show, validate, generate and import suites
    #[command(subcommand)]
    Suite(suite::SuiteCommand) => suite::SuiteCommand::run,
    /// List the tasks of a suite
    #[command(subcommand)]
    Tasks(suite::TasksCommand) => suite::TasksCommand::run,
    /// Show, validate and test vehicles
    #[command(subcommand)]
    Vehicle(vehicle::VehicleCommand) if feature = "vehicle" => vehicle::VehicleCommand::run,
    /// Train terrain models on elevation data, generate surfaces from them, measure elevation files
    #[command(subcommand)]
    Terrain(terrain::TerrainCommand) if feature = "terrain" => terrain::TerrainCommand::run,
    /// Write a shell completion script to stdout
    Completions(shell::CompletionsArgs) => shell::completions,
    /// Write manual pages
    Man(shell::ManArgs) => shell::man,
}
