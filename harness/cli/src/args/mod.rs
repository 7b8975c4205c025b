//! The command line.

mod exit_codes;
mod results;
mod submission;
mod suite;
mod terrain;

use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand, ValueEnum};
use vb_record::{LogMode, TraceMode};
use vb_runner::SAMPLE_PERIOD;

pub(crate) use results::{ReplayArgs, ReplayData, ReportArgs};
pub(crate) use submission::{BuildArgs, EvaluateArgs, LeaderboardCommand, SubmitArgs, VerifyArgs};
pub(crate) use suite::{
    DrawnArgs, GenerateArgs, ImportArgs, ProveArgs, ShowArgs, SiteArgs, SuiteCommand, SuiteListArgs,
    TestbedArgs, ValidateArgs,
};
pub(crate) use terrain::{MeasureArgs, SurfaceArgs, TerrainCommand, TrainArgs};

/// Benchmark for off-road mobility planners: runs a planner over the tasks of a suite and scores it.
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
    fn documented() -> clap::Command {
        exit_codes::document(Self::command())
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a planner over a suite; the default command
    Run(RunArgs),
    /// Score a finished run again from its traces, without simulating
    Score(ScoreArgs),
    /// Make a page, and tables, of one or more runs
    Report(ReportArgs),
    /// Show a task of one or more runs in three dimensions, in the browser
    Replay(ReplayArgs),
    /// Make a submission of a planner, or of a finished run: a small folder that others can verify
    Submit(SubmitArgs),
    /// Verify a submission: hold it against suite and planner, and drive tasks again
    Verify(VerifyArgs),
    /// Score a planner on a hidden suite and tell nothing but the scores
    Evaluate(EvaluateArgs),
    /// Make the site of a leaderboard
    #[command(subcommand)]
    Leaderboard(LeaderboardCommand),
    /// Show what a plugin says of itself, without running it
    Inspect(InspectArgs),
    /// Check what planners promise: determinism, hygiene, head-room, and more
    Check(CheckArgs),
    /// Start a planner's project, and describe planners that are not written in Rust
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// List, show, check, import and generate suites
    #[command(subcommand)]
    Suite(SuiteCommand),
    /// List tasks
    #[command(subcommand)]
    Tasks(TasksCommand),
    /// List, show, check and test vehicles
    #[command(subcommand)]
    Vehicle(VehicleCommand),
    /// Train terrain models on elevation data, draw surfaces from them, measure elevation
    #[command(subcommand)]
    Terrain(TerrainCommand),
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// Make a project for a planner: source, build, README and CI
    New(NewArgs),
    /// Write a planner's name, version and parameters into its WASM file; Rust's export_planner! does it by itself
    Stamp(StampArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum TasksCommand {
    /// List the tasks of a suite, or those that a selector chooses
    List(TasksArgs),
}

#[derive(Debug, Subcommand)]
pub(crate) enum VehicleCommand {
    /// List the vehicles that come with the harness
    List(VehicleListArgs),
    /// Show what a vehicle is made of, and draw it
    Show(VehicleShowArgs),
    /// Read a vehicle file and check every value
    Validate(VehicleArgs),
    /// Drive a vehicle through standard events and hold it against theory, published figures and Project Chrono
    Test(VehicleTestArgs),
}

/// How results are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// For people.
    #[default]
    Human,
    /// One JSON object a line on stdout.
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    // Whether there is a run without a subcommand is seen by this: clap leaves the group of a struct with a flattened one empty.
    #[arg(long, value_name = "FILE|COMMAND", group = "RunArgs")]
    pub(crate) plugin: PathBuf,
    /// Refuse a native planner where the system can't confine it in every way, and any command
    #[arg(long)]
    pub(crate) require_sandbox: bool,
    /// Suite to run: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks to run, e.g. w001/t03 or w001-w004,elevation=high; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    /// Tasks run at a time; default: number of cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Directory for the results; default: runs/PLANNER-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run in --out
    #[arg(long, requires = "out")]
    pub(crate) resume: bool,
    /// Drive all tasks even if the planner fails alike in the first 20, or hangs in the first 3, before its first command
    #[arg(long)]
    pub(crate) keep_going: bool,
    /// Seed of the planner's randomness
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Parameter of the planner; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Samples to keep: none, 10hz, or full, which allows exact re-scoring
    #[arg(long, value_name = "none|10hz|full", default_value = "10hz", value_parser = trace_mode)]
    pub(crate) trace: TraceMode,
    /// Tasks whose results keep the last lines that the planner logged: all, those that failed, or none
    #[arg(long, value_name = "all|failed|none", default_value = "failed", value_parser = log_mode)]
    pub(crate) logs: LogMode,
    /// Rules: paper, release, dev, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "paper")]
    pub(crate) rules: String,
    /// Vehicle: a name, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    pub(crate) vehicle: String,
    /// Soils of deformable ground: default, original, wong, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub(crate) soils: String,
    /// Side of the cells in which soil remembers ruts, in metres; scaled with the world
    #[arg(long, value_name = "METRES", default_value = "0.1", value_parser = soil_resolution)]
    pub(crate) soil_resolution: f64,
    /// Step of the simulation in milliseconds, for studies of convergence; scores are comparable at 1 only
    #[arg(long, value_name = "MS", default_value = "1", value_parser = time_step)]
    pub(crate) time_step: f64,
    /// Factor on every length of the world: 1, 1/6, 1/10; default: the scale that the vehicle is made for
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Limits of the planner, by name as in docs/abi.md; default: those documented there
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Fuel of a WASM planner for one step (about one unit an instruction), whatever --limits says
    #[arg(long, value_name = "N")]
    pub(crate) fuel_per_step: Option<u64>,
    /// Memory of a WASM planner in bytes, or with a suffix K, M or G, whatever --limits says
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) memory: Option<u64>,
    /// Show the functions in which a planner trapped, and every log that is kept, not those of errors alone
    #[arg(long)]
    pub(crate) debug: bool,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

impl RunArgs {
    /// A run of a planner as it is if nothing else is said.
    pub(crate) fn new(plugin: &Path) -> Self {
        Self {
            plugin: plugin.to_owned(),
            require_sandbox: false,
            suite: None,
            tasks: None,
            jobs: None,
            out: None,
            resume: false,
            keep_going: false,
            seed: 0,
            params: Vec::new(),
            trace: TraceMode::default(),
            logs: LogMode::default(),
            rules: "paper".into(),
            vehicle: "hmmwv".into(),
            soils: "default".into(),
            soil_resolution: 0.1,
            time_step: 0.001,
            scale: None,
            limits: None,
            fuel_per_step: None,
            memory: None,
            debug: false,
            format: FormatArgs::default(),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Directory of the run
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,
    /// Rules: paper, release, dev, or a file; default: those of the run
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) rules: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// The planner: a WASM file, a native library, or a command, which is started for it
    #[arg(long, value_name = "FILE|COMMAND")]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The planner: a WASM file, a native library, or a command such as "python3 my_planner.py"
    #[arg(long, value_name = "FILE|COMMAND")]
    pub(crate) plugin: PathBuf,
    /// Refuse a native planner where the system can't confine it in every way, and any command
    #[arg(long)]
    pub(crate) require_sandbox: bool,
    /// Limits of the planner, by name as in docs/abi.md; default: those documented there
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// Parameter of the planner; may be repeated
    #[arg(long = "param", value_name = "KEY=VALUE", value_parser = key_value)]
    pub(crate) params: Vec<(String, String)>,
    /// Suite to take tasks from: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Tasks of which three are driven: the first, the middle and the last; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Name of the planner: a-z, 0-9, - and _
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Language that it is written in
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub(crate) lang: Language,
    /// Folder for the project; default: NAME
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
    /// For Rust, where the SDK is: a folder or a git URL; default: the folder sdk beside the built-in tasks
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) sdk: Option<String>,
}

/// The language of a planner's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Rust, with the SDK.
    Rust,
    /// C, by zig's compiler.
    C,
    /// Python, with its interpreter in the plugin.
    Python,
    /// JavaScript, with the QuickJS engine in the plugin.
    Js,
}

#[derive(Debug, Args)]
pub(crate) struct StampArgs {
    /// The planner: a WASM component, or a core module as wit-bindgen leaves it
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// What the planner says of itself, as YAML: name, version, authors, about, control_period, params
    #[arg(long, value_name = "FILE")]
    pub(crate) meta: PathBuf,
    /// Where to write it; default: in place
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// How results are told, with a short name for programs: the same options on every command that has results.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct FormatArgs {
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    message_format: MessageFormat,
    /// The same as --message-format json
    #[arg(long, conflicts_with = "message_format")]
    json: bool,
}

impl FormatArgs {
    /// What the user chose by either option.
    pub(crate) fn get(self) -> MessageFormat {
        if self.json { MessageFormat::Json } else { self.message_format }
    }

    pub(crate) fn is_json(self) -> bool {
        self.get() == MessageFormat::Json
    }
}

#[derive(Debug, Args)]
pub(crate) struct TasksArgs {
    /// The suite: a directory, or the name of one that comes with the harness; default: vb-100
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Which tasks, e.g. w001/t03 or w001-w004,elevation=high; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleListArgs {
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleShowArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// Draw its side and top view into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE", required_unless_present = "list")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Tyre to put on: the name of one of the vehicle's, e.g. rigid. References with a set-up of their own are held against
    /// the vehicle in that set-up, whatever this says
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// List the events and do nothing else
    #[arg(long)]
    pub(crate) list: bool,
    /// Figures to hold the vehicle against beside theory; default: tasks/validation/VEHICLE.yaml, if it is there
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Step of the simulation in milliseconds
    // --step is what it was called before it had the name that it has in a run.
    #[arg(long, alias = "step", value_name = "MS", default_value_t = 1.0)]
    pub(crate) time_step: f64,
    /// Events run at a time; default: number of cores
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// A number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "want a number above 0".into())
}

fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("want KEY=VALUE, e.g. speed=5".into()),
    }
}

fn trace_mode(text: &str) -> Result<TraceMode, String> {
    [TraceMode::None, TraceMode::TenHz, TraceMode::Full]
        .into_iter()
        .find(|mode| mode.name() == text)
        .ok_or_else(|| "want none, 10hz or full".into())
}

fn log_mode(text: &str) -> Result<LogMode, String> {
    LogMode::ALL.into_iter().find(|mode| mode.name() == text).ok_or_else(|| "want all, failed or none".into())
}

/// A number or a fraction.
fn scale(text: &str) -> Result<f64, String> {
    let number = |s: &str| s.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
        None => number(text),
    };
    value
        .filter(|v| v.is_finite() && *v >= 0.01 && *v <= 10.0)
        .ok_or_else(|| "want a number or a fraction from 1/100 to 10, e.g. 1, 1/6 or 1/10".into())
}

/// A step in milliseconds, of which a whole number makes the time between two samples; returns seconds.
fn time_step(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|v| (0.1..=5.0).contains(v));
    value
        .map(|ms| 1e-3 * ms)
        .filter(|s| ((SAMPLE_PERIOD / s).round() * s - SAMPLE_PERIOD).abs() < 1e-9)
        .ok_or_else(|| "want milliseconds from 0.1 to 5 that divide 10, e.g. 0.5".into())
}

/// A length in metres that a soil's memory can have.
fn soil_resolution(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value.filter(|v| (0.01..=0.5).contains(v)).ok_or_else(|| "want metres from 0.01 to 0.5, e.g. 0.05".into())
}

/// A number of bytes with an optional binary suffix.
fn bytes(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.chars().last() {
        Some('K' | 'k') => (&text[..text.len() - 1], 10),
        Some('M' | 'm') => (&text[..text.len() - 1], 20),
        Some('G' | 'g') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    digits
        .parse::<u64>()
        .ok()
        .and_then(|n| n.checked_mul(1 << shift))
        .filter(|n| *n > 0)
        .ok_or_else(|| "want a number of bytes, e.g. 268435456 or 256M".into())
}

#[cfg(test)]
mod tests {
    use super::terrain::nodes;
    use super::*;

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
            "suite import",
            "suite generate",
            "suite site",
            "suite testbed",
            "vehicle validate",
            "terrain train",
            "terrain generate",
            "terrain measure",
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
        assert!(with(&["--plugin", "a.wasm", "--resume"]).is_err());
    }

    #[test]
    fn a_run_for_a_submission_is_one_of_which_nothing_is_said() {
        let said = Cli::try_parse_from(["vb-harness", "--plugin", "a.wasm"]).unwrap().run.unwrap();
        assert_eq!(format!("{said:?}"), format!("{:?}", RunArgs::new(Path::new("a.wasm"))));
    }

    #[test]
    fn values_are_read_as_people_write_them() {
        assert_eq!((scale("1"), scale("1/10"), scale("0.25")), (Ok(1.0), Ok(0.1), Ok(0.25)));
        assert!(
            scale("1/0").is_err() && scale("-1").is_err() && scale("nan").is_err() && scale("big").is_err()
        );
        assert_eq!((bytes("4096"), bytes("256M"), bytes("1g")), (Ok(4096), Ok(256 << 20), Ok(1 << 30)));
        assert!(bytes("").is_err() && bytes("M").is_err() && bytes("-1").is_err());
        assert!(
            bytes("99999999999999999999G").is_err()
                && bytes("18446744073709551615K").is_err()
                && bytes("é").is_err()
        );
        assert_eq!(key_value("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(key_value("a").is_err() && key_value("=b").is_err());
        assert_eq!((nodes("129"), nodes("200x100")), (Ok((129, 129)), Ok((200, 100))));
        assert!(nodes("").is_err() && nodes("3x").is_err() && nodes("-1").is_err());
        assert!(positive("0").is_err() && positive("inf").is_err() && positive("0.5") == Ok(0.5));
        assert_eq!(trace_mode("10hz"), Ok(TraceMode::TenHz));
        assert!(trace_mode("20hz").is_err());
        assert_eq!(log_mode("all"), Ok(LogMode::All));
        assert!(log_mode("some").is_err());
    }
}
