//! `vb-harness`: the command line of the benchmark.

mod args;
mod check;
mod error;
mod inspect;
mod leaderboard;
mod output;
mod places;
mod planner;
mod plugin;
mod progress;
mod replay;
mod report;
mod run;
mod score;
mod site;
mod submission;
mod suite;
mod terrain;
mod vehicle;

use std::io::Write as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    // Before anything else: a worker must be alone in its process.
    if let Some(end) = vb_host::serve_as_worker() {
        return end;
    }
    report_large_files();
    let cli = match args::Cli::of_the_program() {
        Ok(cli) => cli,
        Err(e) if e.use_stderr() => return failed(&usage(&e)),
        Err(e) => {
            // Help and version go to stdout with exit code 0.
            output::check(e.print().and_then(|()| std::io::stdout().flush()));
            return output::failure().map_or(ExitCode::from(error::DONE), |e| failed(&e));
        }
    };
    let result = match cli.command {
        None => match cli.run {
            Some(args) => run::run(&args),
            // Not reached: clap demands a plugin where there is no subcommand.
            None => Err(error::CliError::usage("no command given (see vb-harness --help)")),
        },
        Some(args::Command::Run(args)) => run::run(&args),
        Some(args::Command::Score(args)) => score::score(&args),
        Some(args::Command::Report(args)) => report::report(&args),
        Some(args::Command::Replay(args)) => replay::replay(&args),
        Some(args::Command::Submit(args)) => submission::submit(&args),
        Some(args::Command::Verify(args)) => submission::verify(&args),
        Some(args::Command::Evaluate(args)) => submission::evaluate(&args),
        Some(args::Command::Leaderboard(args::LeaderboardCommand::Build(args))) => leaderboard::build(&args),
        Some(args::Command::Inspect(args)) => inspect::inspect(&args),
        Some(args::Command::Check(args)) => check::check(&args),
        Some(args::Command::Plugin(args::PluginCommand::New(args))) => plugin::new(&args),
        Some(args::Command::Plugin(args::PluginCommand::Stamp(args))) => plugin::stamp(&args),
        Some(args::Command::Suite(args::SuiteCommand::List(args))) => suite::list(&args),
        Some(args::Command::Suite(args::SuiteCommand::Show(args))) => suite::show(&args),
        Some(args::Command::Suite(args::SuiteCommand::Validate(args))) => suite::validate(&args),
        Some(args::Command::Suite(args::SuiteCommand::Prove(args))) => suite::prove(&args),
        Some(args::Command::Suite(args::SuiteCommand::Import(args))) => suite::import(&args),
        Some(args::Command::Suite(args::SuiteCommand::Generate(args))) => suite::generate(&args),
        Some(args::Command::Suite(args::SuiteCommand::Site(args))) => site::make(&args),
        Some(args::Command::Suite(args::SuiteCommand::Testbed(args))) => suite::testbed(&args),
        Some(args::Command::Tasks(args::TasksCommand::List(args))) => suite::tasks(&args),
        Some(args::Command::Vehicle(args::VehicleCommand::List(args))) => vehicle::list(&args),
        Some(args::Command::Vehicle(args::VehicleCommand::Show(args))) => vehicle::show(&args),
        Some(args::Command::Vehicle(args::VehicleCommand::Validate(args))) => vehicle::validate(&args),
        Some(args::Command::Vehicle(args::VehicleCommand::Test(args))) => vehicle::test(&args),
        Some(args::Command::Terrain(args::TerrainCommand::Train(args))) => terrain::train(&args),
        Some(args::Command::Terrain(args::TerrainCommand::Generate(args))) => terrain::generate(&args),
        Some(args::Command::Terrain(args::TerrainCommand::Measure(args))) => terrain::measure(&args),
    };
    // What went wrong with the work itself says more than that it could not be told.
    match result.and_then(|()| output::failure().map_or(Ok(()), Err)) {
        Ok(()) => ExitCode::from(error::DONE),
        Err(e) => failed(&e),
    }
}

/// Makes a file beyond the user's limit (`ulimit -f`) an error of the write, as a full disk is one, where the system would kill
/// the process without a word.
#[cfg(unix)]
fn report_large_files() {
    extern "C" fn nothing(_: libc::c_int) {}
    // A handler, since a signal that is ignored would stay so in the processes of native planners, whose sandbox counts on it.
    // SAFETY: the handler does nothing, which is safe in a signal, and no thread runs yet.
    unsafe { libc::signal(libc::SIGXFSZ, nothing as *const () as libc::sighandler_t) };
}

#[cfg(not(unix))]
fn report_large_files() {}

fn failed(e: &error::CliError) -> ExitCode {
    if !e.is_told() {
        output::error(e);
    }
    ExitCode::from(e.code())
}

/// What is wrong with the command line, without the paragraphs on usage: an error is one line.
fn usage(e: &clap::Error) -> error::CliError {
    let text = e.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let what = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|end| text.find(end)).min();
    let what = text[..what.unwrap_or(text.len())].lines().map(str::trim).filter(|l| !l.is_empty());
    error::CliError::usage(format!("{} (see --help)", what.collect::<Vec<_>>().join(" ")))
}
