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
    let given: Vec<String> = std::env::args().skip(1).collect();
    usage_of(&e.render().to_string(), &given)
}

/// The error that clap tells so of these arguments, with what people may have meant.
fn usage_of(text: &str, given: &[String]) -> error::CliError {
    let text = text.strip_prefix("error: ").unwrap_or(text);
    let what = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|end| text.find(end)).min();
    let what = text[..what.unwrap_or(text.len())].lines().map(str::trim).filter(|l| !l.is_empty());
    // No option takes such a value: the tip would lead astray.
    let what = what.filter(|line| !line.starts_with("tip: to pass '"));
    let what = what
        .collect::<Vec<_>>()
        .join(" ")
        .replace("invalid digit found in string", "want a whole number that is not below 0")
        .replace("number too large to fit in target type", "the number is too large")
        .replace("cannot parse integer from empty string", "want a whole number that is not below 0");
    let hint =
        meant(text, given).map_or_else(|| "see --help".to_owned(), |meant| format!("{meant}; see --help"));
    error::CliError::usage(format!("{what} ({hint})"))
}

/// A suggestion for an unknown argument.
fn meant(text: &str, given: &[String]) -> Option<String> {
    let argument = text
        .strip_prefix("unexpected argument '")
        .or_else(|| text.strip_prefix("unrecognized subcommand '"))?
        .split_once('\'')?
        .0;
    let planner = |name: &str| {
        let ends = [".wasm", ".so", ".dylib", ".dll"].iter().any(|end| name.ends_with(end));
        ends.then(|| format!("a planner is given by --plugin {name}"))
    };
    if let Some(meant) = planner(argument) {
        return Some(meant);
    }
    let words: Vec<&str> = given.iter().map(String::as_str).filter(|word| !word.starts_with('-')).collect();
    match (words.first(), words.get(1)) {
        (Some(&"tasks"), second) if second != Some(&"list") => {
            Some(format!("tasks are listed by: vb-harness tasks list {}", given[1..].join(" ")))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error message for these arguments.
    fn said(line: &str) -> String {
        let given: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let all = std::iter::once("vb-harness".to_owned()).chain(given.clone());
        let e = args::Cli::documented().try_get_matches_from(all).unwrap_err();
        usage_of(&e.render().to_string(), &given).to_string()
    }

    #[test]
    fn mistakes_are_told_with_what_may_be_meant() {
        for (line, wanted) in [
            ("run pid.wasm", "(a planner is given by --plugin pid.wasm; see --help)"),
            ("pid.wasm", "(a planner is given by --plugin pid.wasm; see --help)"),
            ("tasks --suite smoke", "(tasks are listed by: vb-harness tasks list --suite smoke; see --help)"),
            (
                "--plugin a.wasm --seed 1.5",
                "'--seed <N>': want a whole number that is not below 0 (see --help)",
            ),
            ("sweep run sp.yaml --tasks w001", "unexpected argument '--tasks' found (see --help)"),
        ] {
            let said = said(line);
            assert!(said.ends_with(wanted), "{line}: {said}");
            assert!(!said.contains("to pass '"), "{said}");
        }
    }
}
