//! `vb-harness`: the command line of the benchmark.

mod args;
mod check;
mod dataset;
mod dispatch;
mod error;
mod film;
mod geojson;
mod inspect;
mod leaderboard;
mod merge;
mod output;
mod places;
mod planner;
mod plugin;
mod progress;
mod replay;
mod report;
mod run;
mod score;
mod shell;
mod submission;
mod suite;
mod sweep;
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
    // What went wrong with the work itself says more than that it could not be told.
    match cli.run().and_then(|()| output::failure().map_or(Ok(()), Err)) {
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
