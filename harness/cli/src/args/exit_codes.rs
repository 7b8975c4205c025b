//! The exit codes in the help: of the program all, of each command those that it can give.

use clap::Command;

use crate::error::{
    BAD_INPUT, CHECKS_FAILED, DONE, FAILED_START, HOST_ERRORS, INCOMPLETE, INTERNAL, INTERRUPTED, MEANINGS,
    NOT_CONFORMING, NOT_VERIFIED, OUTPUT, SIM_ERRORS, USAGE,
};

/// What every command can give; what it tells may not reach its file.
const ALWAYS: [u8; 5] = [DONE, INTERNAL, USAGE, BAD_INPUT, OUTPUT];

/// What a command can give beside [`ALWAYS`].
const OF: [(&str, &[u8]); 16] = [
    ("run", &[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]),
    ("merge", &[SIM_ERRORS, INCOMPLETE]),
    ("sweep run", &[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]),
    ("sweep report", &[INCOMPLETE]),
    ("submit", &[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]),
    ("verify", &[HOST_ERRORS, NOT_VERIFIED, INTERRUPTED]),
    ("evaluate", &[SIM_ERRORS, HOST_ERRORS, INTERRUPTED]),
    ("check", &[HOST_ERRORS, NOT_CONFORMING, INTERRUPTED]),
    ("dataset explore", &[INTERRUPTED]),
    ("dataset drive", &[INTERRUPTED]),
    ("dataset teleop", &[INTERRUPTED]),
    ("dataset failures", &[INTERRUPTED]),
    ("dataset validate", &[NOT_VERIFIED]),
    ("vehicle test", &[CHECKS_FAILED]),
    ("terrain train", &[INTERRUPTED]),
    // The program without a command is `run`, but its help is that of all commands.
    (
        "",
        &[
            SIM_ERRORS,
            CHECKS_FAILED,
            HOST_ERRORS,
            NOT_CONFORMING,
            NOT_VERIFIED,
            FAILED_START,
            INCOMPLETE,
            INTERRUPTED,
        ],
    ),
];

/// What a command that has `--resume` says of it beside a code's meaning.
const RESUMED: [(u8, &str); 2] =
    [(HOST_ERRORS, "; --resume re-runs them"), (INTERRUPTED, "; --resume continues")];

/// The program's commands with their exit codes at the end of their help.
pub(super) fn document(program: Command) -> Command {
    add(program, "")
}

fn add(command: Command, path: &str) -> Command {
    let inner = |name: &str| format!("{path} {name}").trim_start().to_owned();
    let command = command.mut_subcommands(|c| {
        let path = inner(c.get_name());
        add(c, &path)
    });
    // A group of commands gives none itself.
    if command.has_subcommands() && !path.is_empty() {
        return command;
    }
    let resumes = command.get_arguments().any(|option| option.get_long() == Some("resume"));
    command.after_help(text(path, resumes))
}

/// What is said of the codes of a command, which may be one that resumes what it began.
fn text(path: &str, resumes: bool) -> String {
    let own = OF.iter().find(|(name, _)| *name == path).map_or(&[][..], |(_, codes)| codes);
    let rows = MEANINGS.iter().filter(|(code, _)| ALWAYS.contains(code) || own.contains(code));
    rows.fold("Exit codes:".to_owned(), |text, (code, meaning)| {
        let hint =
            RESUMED.iter().find(|(resumed, _)| resumes && resumed == code).map_or("", |(_, hint)| hint);
        format!("{text}\n  {code:>3}  {meaning}{hint}")
    })
}

#[cfg(test)]
mod tests {
    use super::super::Cli;
    use super::*;
    use clap::CommandFactory as _;

    /// The paths of all commands that do something.
    fn commands(command: &Command, path: &str, found: &mut Vec<String>) {
        for c in command.get_subcommands() {
            let path = format!("{path} {}", c.get_name()).trim_start().to_owned();
            if c.has_subcommands() {
                commands(c, &path, found);
            } else {
                assert!(
                    c.get_after_help().unwrap().to_string().starts_with("Exit codes:\n    0  completed\n"),
                    "{path}"
                );
                found.push(path);
            }
        }
    }

    /// Whether a command, and all below it, name `--resume` beside their codes only if they have it.
    fn names_its_own(command: &Command) {
        for c in command.get_subcommands() {
            let resumes = c.get_arguments().any(|option| option.get_long() == Some("resume"));
            let told = c.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(resumes || !told.contains("--resume"), "{}: {told}", c.get_name());
            names_its_own(c);
        }
    }

    #[test]
    fn no_code_is_told_with_an_option_that_its_command_lacks() {
        let program = document(Cli::command());
        names_its_own(&program);
        let run = program.find_subcommand("run").unwrap().get_after_help().unwrap().to_string();
        assert!(run.contains("--resume re-runs them") && run.contains("--resume continues"), "{run}");
    }

    #[test]
    fn every_command_tells_its_codes_and_no_other_is_listed() {
        let mut found = vec![String::new()];
        commands(&document(Cli::command()), "", &mut found);
        for (name, _) in OF {
            assert!(found.iter().any(|path| path == name), "{name}");
        }
        let text_of = |path: &str| text(path, false);
        let not_verified = "failed verification";
        assert!(text_of("verify").contains(not_verified) && !text_of("run").contains(not_verified));
        assert_eq!(text_of("").lines().count(), 1 + MEANINGS.len());
        assert_eq!(text_of("suite list").lines().count(), 1 + ALWAYS.len());
    }
}
