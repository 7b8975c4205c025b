//! `vb-harness`: the command line of the benchmark.

mod args;
mod causes;
mod cli;
mod command;
mod error;
mod output;
mod places;
mod planner;
mod progress;

use std::io::Write as _;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};

fn main() -> ExitCode {
    // Before anything else: a worker must be alone in its process.
    if let Some(end) = vb_host::serve_as_worker() {
        return end;
    }
    report_large_files();
    let cli = match cli::Cli::of_the_program() {
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

/// What is said where a part of the program was left out of it (features in `Cargo.toml`).
fn missing(what: &str, feature: &str) -> String {
    format!(
        "{what} are not available in this build without the feature {feature} (build with all features: `cargo build --release \
         --package vb-harness`)"
    )
}

fn failed(e: &error::CliError) -> ExitCode {
    if !e.is_told() {
        output::error(e);
    }
    ExitCode::from(e.code())
}

/// What is wrong with the command line, without the paragraphs on usage: an error is one line.
fn usage(e: &clap::Error) -> error::CliError {
    let given: Vec<String> = std::env::args().skip(1).collect();
    usage_of(e, &given)
}

/// The error that clap tells so of these arguments, with what people may have meant.
fn usage_of(e: &clap::Error, given: &[String]) -> error::CliError {
    if e.kind() == ErrorKind::MissingSubcommand
        || e.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    {
        return error::CliError::usage("no command given, e.g. run pid.wasm (see --help)");
    }
    if is_of_planner(e) {
        return error::CliError::usage(
            "give one planner, as an argument, e.g. pid.wasm, or with --plugin, e.g. --plugin pid.wasm (see --help)",
        );
    }
    let text = e.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let what = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|end| text.find(end)).min();
    let what = text[..what.unwrap_or(text.len())].lines().map(str::trim).filter(|l| !l.is_empty());
    let meant = meant(text, given);
    // No option takes such a value, or there is a better suggestion: the tip would lead astray.
    let misleading = if meant.is_some() { "tip: " } else { "tip: to pass '" };
    let what = what.filter(|line| !line.starts_with(misleading));
    let what = what
        .collect::<Vec<_>>()
        .join(" ")
        .replace("invalid digit found in string", "want a whole number that is not below 0")
        .replace("number too large to fit in target type", "the number is too large")
        .replace("cannot parse integer from empty string", "want a whole number that is not below 0");
    let hint = meant.map_or_else(|| "see --help".to_owned(), |meant| format!("{meant}; see --help"));
    error::CliError::usage(format!("{what} ({hint})"))
}

/// Whether the planner is what is wrong: none, or both as argument and as option.
fn is_of_planner(e: &clap::Error) -> bool {
    let all: Vec<String> = match e.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(arg)) => vec![arg.clone()],
        Some(ContextValue::Strings(args)) => args.clone(),
        _ => return false,
    };
    matches!(e.kind(), ErrorKind::MissingRequiredArgument | ErrorKind::ArgumentConflict)
        && !all.is_empty()
        && all.iter().all(|arg| arg.contains("PLANNER"))
}

/// A suggestion for an unknown argument.
fn meant(text: &str, given: &[String]) -> Option<String> {
    let unknown = |kind: &str| text.strip_prefix(kind).and_then(|rest| Some(rest.split_once('\'')?.0));
    let is_planner = |name: &&str| [".wasm", ".so", ".dylib", ".dll"].iter().any(|end| name.ends_with(end));
    // The feature that a command needs, where it was left out.
    let left_out = |name: &str| match name {
        "dataset" if cfg!(not(feature = "dataset")) => Some("dataset"),
        "replay" if cfg!(not(feature = "replay")) => Some("replay"),
        "ros" if cfg!(not(feature = "ros")) => Some("ros"),
        "teleop" if cfg!(not(feature = "teleop")) => Some("teleop"),
        "import" | "site" | "terrain" if cfg!(not(feature = "terrain")) => Some("terrain"),
        "vehicle" if cfg!(not(feature = "vehicle")) => Some("vehicle"),
        _ => None,
    };
    if let Some(feature) = unknown("unrecognized subcommand '").and_then(left_out) {
        return Some(missing("its commands", feature));
    }
    if let Some(planner) = unknown("unrecognized subcommand '").filter(is_planner) {
        return Some(format!("to run a planner: vb-harness run {planner}"));
    }
    if let Some(planner) = unknown("unexpected argument '").filter(is_planner) {
        return Some(format!("give the planner with --plugin {planner}"));
    }
    let words: Vec<&str> = given.iter().map(String::as_str).filter(|word| !word.starts_with('-')).collect();
    match (words.first(), words.get(1)) {
        (Some(&"tasks"), second) if second != Some(&"list") => {
            Some(format!("to list tasks: vb-harness tasks list {}", given[1..].join(" ")))
        }
        (Some(group @ (&"suite" | &"vehicle")), Some(&"list")) => {
            Some(format!("to list {group}s: vb-harness list {group}s"))
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
        let e = cli::Cli::documented().try_get_matches_from(all).unwrap_err();
        usage_of(&e, &given).to_string()
    }

    #[test]
    fn mistakes_are_told_with_what_may_be_meant() {
        let planner = "give one planner, as an argument, e.g. pid.wasm, or with --plugin, e.g. --plugin pid.wasm (see --help)";
        for (line, wanted) in [
            ("", "no command given, e.g. run pid.wasm (see --help)"),
            ("run", planner),
            ("check --suite smoke", planner),
            ("run a.wasm --plugin b.wasm", planner),
            ("inspect --plugin b.wasm a.wasm", planner),
            ("pid.wasm", "(to run a planner: vb-harness run pid.wasm; see --help)"),
            ("verify s pid.wasm", "(give the planner with --plugin pid.wasm; see --help)"),
            ("submit a.wasm", "the following required arguments were not provided: --out <DIR> (see --help)"),
            ("tasks --suite smoke", "(to list tasks: vb-harness tasks list --suite smoke; see --help)"),
            (
                "suite list",
                "unrecognized subcommand 'list' (to list suites: vb-harness list suites; see --help)",
            ),
            ("run a.wasm --seed 1.5", "'--seed <N>': want a whole number that is not below 0 (see --help)"),
            ("sweep run sp.yaml --tasks w001", "unexpected argument '--tasks' found (see --help)"),
        ] {
            let said = said(line);
            assert!(said.ends_with(wanted), "{line}: {said}");
            assert!(!said.contains("to pass '"), "{said}");
        }
    }
}
