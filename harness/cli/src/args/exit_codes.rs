//! The exit codes in the help: of the program all, of each command those that it can give. Commands with codes of their own name them
//! where they are declared ([`codes`], [`resumed`]); the others give those that every command can give.

use clap::Command;

use crate::error::{BAD_INPUT, DONE, EXIT_CODES, HOST_ERRORS, INTERNAL, INTERRUPTED, OUTPUT, USAGE};

/// What every command can give; what it tells may not reach its file.
const ALWAYS: [u8; 5] = [DONE, INTERNAL, USAGE, BAD_INPUT, OUTPUT];

/// What a command that has `--resume` says of it beside a code's meaning.
const RESUMED: [(u8, &str); 2] =
    [(HOST_ERRORS, "; --resume re-runs them"), (INTERRUPTED, "; --resume continues")];

/// The end of the help of a command that can give these codes in addition to [`ALWAYS`].
pub(crate) fn codes(own: &[u8]) -> String {
    text(own, &[])
}

/// The end of the help of such a command that has `--resume`.
pub(crate) fn resumed(own: &[u8]) -> String {
    text(own, &RESUMED)
}

fn text(own: &[u8], hints: &[(u8, &str)]) -> String {
    let rows = EXIT_CODES.iter().filter(|(code, _)| ALWAYS.contains(code) || own.contains(code));
    rows.fold("Exit codes:".to_owned(), |text, (code, meaning)| {
        let hint = hints.iter().find(|(of, _)| of == code).map_or("", |(_, hint)| hint);
        format!("{text}\n  {code:>3}  {meaning}{hint}")
    })
}

/// The program's commands with their exit codes at the end of their help.
pub(crate) fn document(program: Command) -> Command {
    let all: Vec<u8> = EXIT_CODES.iter().map(|(code, _)| *code).collect();
    program.after_help(codes(&all)).mut_subcommands(add)
}

fn add(command: Command) -> Command {
    let command = command.mut_subcommands(add);
    // A group of commands gives none itself.
    if command.has_subcommands() || command.get_after_help().is_some() {
        return command;
    }
    command.after_help(codes(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use crate::error::{NOT_VERIFIED, SIM_ERRORS};

    /// Each command that does something, with its path and the end of its help.
    fn commands(command: &Command, path: &str, found: &mut Vec<(String, String, bool)>) {
        for c in command.get_subcommands() {
            let path = format!("{path} {}", c.get_name()).trim_start().to_owned();
            if c.has_subcommands() {
                assert!(c.get_after_help().is_none(), "{path}");
                commands(c, &path, found);
            } else {
                let resumes = c.get_arguments().any(|option| option.get_long() == Some("resume"));
                let told = c.get_after_help().map(ToString::to_string).unwrap_or_default();
                found.push((path, told, resumes));
            }
        }
    }

    #[test]
    fn every_command_tells_its_codes_and_names_resume_only_if_it_has_it() {
        let program = Cli::documented();
        let mut found = Vec::new();
        commands(&program, "", &mut found);
        for (path, told, resumes) in &found {
            assert!(told.starts_with("Exit codes:\n    0  completed\n"), "{path}: {told}");
            assert_eq!(told.contains("--resume"), *resumes, "{path}: {told}");
        }
        let has = |path: &str, code: u8| {
            let (_, told, _) = found.iter().find(|(p, ..)| p == path).unwrap();
            told.lines().any(|line| line.trim_start().starts_with(&format!("{code}  ")))
        };
        assert!(has("verify", NOT_VERIFIED) && !has("run", NOT_VERIFIED));
        assert!(has("run", SIM_ERRORS) && has("submit", SIM_ERRORS) && !has("suite show", SIM_ERRORS));
        let all = program.get_after_help().unwrap().to_string();
        assert_eq!(all.lines().count(), 1 + EXIT_CODES.len());
    }
}
