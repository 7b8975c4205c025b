//! The command line as a whole: the program's options and its help. Each command declares its own arguments (`command`).

use std::ffi::OsString;

use clap::{ColorChoice, CommandFactory as _, FromArgMatches as _, Parser};

use crate::args::{GlobalArgs, exit_codes};
use crate::command::Command;
use crate::error::CliError;
use crate::output;

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
    /// Parses the program's arguments.
    pub(crate) fn of_the_program() -> Result<Self, clap::Error> {
        let args = with_command(std::env::args_os().collect());
        // Help is printed before the options are known.
        let command = Self::documented().color(color(&args));
        let matches = command.clone().try_get_matches_from(args)?;
        Self::from_arg_matches(&matches).map_err(|e| e.format(&mut command.clone()))
    }

    /// Executes the command.
    ///
    /// # Errors
    /// Returns the error of the command.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        output::set_up(self.global);
        self.command.run()
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

/// The command of a command line, for tests.
#[cfg(test)]
pub(crate) fn parse(args: &[&str]) -> Result<Command, clap::Error> {
    let args = ["vb-harness"].iter().chain(args).map(OsString::from).collect();
    Cli::try_parse_from(with_command(args)).map(|cli| cli.command)
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

    /// Where the default depends on another option it is in the text alone.
    #[test]
    fn the_help_of_submit_names_the_suite_without_options() {
        let mut command = Cli::documented();
        let help = command.find_subcommand_mut("submit").unwrap().render_help().to_string();
        let suite = format!("default: {}, or the suite of --run", vb_catalog::DEFAULT_SUITE);
        assert!(help.split_whitespace().collect::<Vec<_>>().join(" ").contains(&suite), "{help}");
    }
}
