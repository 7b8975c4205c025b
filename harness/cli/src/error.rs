//! How the program ends: exit codes, and the error of a command.

use std::fmt;

/// Defines each exit code with its meaning, and the list of all.
macro_rules! exit_codes {
    ($(#[doc = $meaning:literal] $name:ident = $code:literal;)*) => {
        $(
            #[doc = $meaning]
            #[cfg_attr(not(feature = "full"), allow(dead_code, reason = "commands that end so may be left out"))]
            pub(crate) const $name: u8 = $code;
        )*

        /// Every exit code with its meaning, for the help.
        pub(crate) const EXIT_CODES: &[(u8, &str)] = &[$(($code, $meaning.trim_ascii())),*];
    };
}

// The one list of exit codes: the comments are what the help says of them, and tests compare docs/results.md and the errors of the
// Python package with it. How a command is continued is no part of a meaning, since not all commands can be.
exit_codes! {
    /// completed
    DONE = 0;
    /// internal error of the harness
    INTERNAL = 1;
    /// invalid command line, or an unknown task, world or parameter
    USAGE = 2;
    /// unusable input: a suite, plugin, rule file, vehicle file, recorded run or dataset
    BAD_INPUT = 3;
    /// results can't be written (disk full, no permission, directory not empty, in use, or of another run)
    OUTPUT = 4;
    /// completed, but the simulation of some tasks failed
    SIM_ERRORS = 5;
    /// completed, but the vehicle failed some checks of vehicle test
    CHECKS_FAILED = 6;
    /// some tasks failed because of the harness or the machine
    HOST_ERRORS = 7;
    /// completed, but the planner failed some checks
    NOT_CONFORMING = 8;
    /// completed, but the submission or dataset failed verification
    NOT_VERIFIED = 9;
    /// early end: the first tasks all failed in the planner's start, or in the simulation
    FAILED_START = 10;
    /// completed, but some tasks are missing, or some runs aren't finished
    INCOMPLETE = 11;
    /// stopped by Ctrl-C
    INTERRUPTED = 130;
}

/// Why a command failed: one line for people, and the exit code.
#[derive(Debug)]
pub(crate) struct CliError {
    code: u8,
    message: String,
}

impl CliError {
    fn new(code: u8, message: impl fmt::Display) -> Self {
        // Texts of libraries may span lines; ours never do. Nothing is cut, since the advice is at the end.
        Self { code, message: vb_files::cut_line(&message.to_string(), usize::MAX) }
    }

    pub(crate) fn internal(message: impl fmt::Display) -> Self {
        Self::new(INTERNAL, message)
    }

    pub(crate) fn usage(message: impl fmt::Display) -> Self {
        Self::new(USAGE, message)
    }

    pub(crate) fn input(message: impl fmt::Display) -> Self {
        Self::new(BAD_INPUT, message)
    }

    pub(crate) fn output(message: impl fmt::Display) -> Self {
        Self::new(OUTPUT, message)
    }

    pub(crate) fn sim_errors(message: impl fmt::Display) -> Self {
        Self::new(SIM_ERRORS, message)
    }

    pub(crate) fn host_errors(message: impl fmt::Display) -> Self {
        Self::new(HOST_ERRORS, message)
    }

    #[cfg(feature = "vehicle")]
    pub(crate) fn checks_failed(message: impl fmt::Display) -> Self {
        Self::new(CHECKS_FAILED, message)
    }

    pub(crate) fn not_conforming(message: impl fmt::Display) -> Self {
        Self::new(NOT_CONFORMING, message)
    }

    pub(crate) fn not_verified(message: impl fmt::Display) -> Self {
        Self::new(NOT_VERIFIED, message)
    }

    pub(crate) fn failed_start(message: impl fmt::Display) -> Self {
        Self::new(FAILED_START, message)
    }

    pub(crate) fn incomplete(message: impl fmt::Display) -> Self {
        Self::new(INCOMPLETE, message)
    }

    pub(crate) fn interrupted(message: impl fmt::Display) -> Self {
        Self::new(INTERRUPTED, message)
    }

    /// The same error, with where it is in front.
    pub(crate) fn within(self, place: &str) -> Self {
        Self { message: format!("{place}: {}", self.message), ..self }
    }

    /// Another program failed with this code and said why.
    #[cfg(feature = "terrain")]
    pub(crate) fn told(code: u8) -> Self {
        Self::new(code, "")
    }

    /// Whether people know already what is wrong.
    pub(crate) fn is_told(&self) -> bool {
        self.message.is_empty()
    }

    pub(crate) fn code(&self) -> u8 {
        self.code
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn file(path: &str) -> String {
        std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path))
            .unwrap()
    }

    #[test]
    fn the_documentation_has_each_exit_code_with_the_beginning_of_its_meaning() {
        let documented = file("docs/results.md");
        let rows = documented.lines().skip_while(|l| !l.starts_with("| exit code")).skip(2);
        let rows: Vec<(u8, String)> = rows
            .map_while(|row| row.strip_prefix("| ")?.split_once(" | "))
            .map(|(code, text)| (code.parse().unwrap(), text.replace(['`', '['], "")))
            .collect();
        assert_eq!(rows.len(), EXIT_CODES.len());
        for ((code, meaning), (documented, text)) in EXIT_CODES.iter().zip(&rows) {
            // The page goes into detail where the help has a comma, colon or parenthesis.
            let start = meaning.split(&[',', ':', '(']).next().unwrap().trim();
            assert!(code == documented && text.starts_with(start), "{code} {meaning}: {documented} {text}");
        }
    }

    #[test]
    fn the_errors_of_the_python_package_are_of_exit_codes() {
        let text = file("harness/python/vertibench/_runs/errors.py");
        let table =
            text.split_once("_OF_CODE").unwrap().1.split_once("{").unwrap().1.split_once('}').unwrap().0;
        let codes: BTreeSet<u8> =
            table.lines().filter_map(|l| l.trim().split_once(':')?.0.parse().ok()).collect();
        // 5 is a warning there, and these of commands that it doesn't run.
        let without = [DONE, SIM_ERRORS, CHECKS_FAILED, NOT_CONFORMING, NOT_VERIFIED, INCOMPLETE];
        let wanted =
            EXIT_CODES.iter().map(|(code, _)| *code).filter(|code| !without.contains(code)).collect();
        assert_eq!(codes, wanted);
        let classes: Vec<&str> = text.lines().filter(|l| l.contains("\"\"\"Exit code ")).collect();
        assert_eq!(classes.len(), codes.len());
        for line in classes {
            let (code, meaning) = line.split_once("Exit code ").unwrap().1.split_once(": ").unwrap();
            assert!(codes.contains(&code.parse().unwrap()), "{code}: {meaning}");
        }
    }
}
