//! How the program ends.

use std::fmt;

use vb_catalog::CatalogError;
use vb_record::StoreError;
use vb_report::ReportError;
use vb_suite::generate::GenerateError;
use vb_world::SuiteError;

/// All went well.
pub(crate) const DONE: u8 = 0;
/// A fault of the harness itself.
pub(crate) const INTERNAL: u8 = 1;
/// The command line makes no sense, or names a task, world or parameter that doesn't exist.
pub(crate) const USAGE: u8 = 2;
/// A suite, plugin, rule file, vehicle file or recorded run can't be used.
pub(crate) const BAD_INPUT: u8 = 3;
/// Results can't be written: disk full, no permission, directory not empty, in use or of another run.
pub(crate) const OUTPUT: u8 = 4;
/// The run was completed, but the simulation of some tasks failed.
pub(crate) const SIM_ERRORS: u8 = 5;
/// The test of a vehicle was completed, but some checks failed.
pub(crate) const CHECKS_FAILED: u8 = 6;
/// The harness or the machine failed some tasks, of which nothing is known.
pub(crate) const HOST_ERRORS: u8 = 7;
/// The checks of a planner were made, but it failed some.
pub(crate) const NOT_CONFORMING: u8 = 8;
/// A submission, or a dataset, does not verify.
pub(crate) const NOT_VERIFIED: u8 = 9;
/// The run was ended early: the planner failed alike in all of the first tasks, before its first command, or the simulation failed
/// in all of them.
pub(crate) const FAILED_START: u8 = 10;
/// Some tasks were not done by anybody.
pub(crate) const INCOMPLETE: u8 = 11;
/// Stopped by Ctrl-C.
pub(crate) const INTERRUPTED: u8 = 130;

/// Every code and what it means, for the help. How a command goes on is no part of it, since not all do so in the same way.
pub(crate) const MEANINGS: [(u8, &str); 13] = [
    (DONE, "completed"),
    (INTERNAL, "internal error of the harness"),
    (USAGE, "invalid command line, or an unknown task, world or parameter"),
    (BAD_INPUT, "unusable input: a suite, plugin, rule file, vehicle file, recorded run or dataset"),
    (
        OUTPUT,
        "results can't be written (disk full, no permission, directory not empty, in use, or of another run)",
    ),
    (SIM_ERRORS, "completed, but the simulation of some tasks failed"),
    (CHECKS_FAILED, "completed, but the vehicle failed some checks of vehicle test"),
    (HOST_ERRORS, "some tasks failed because of the harness or the machine"),
    (NOT_CONFORMING, "completed, but the planner failed some checks"),
    (NOT_VERIFIED, "completed, but the submission or dataset failed verification"),
    (FAILED_START, "early end: the first tasks all failed in the planner's start, or in the simulation"),
    (INCOMPLETE, "completed, but some tasks are missing, or some runs aren't finished"),
    (INTERRUPTED, "stopped by Ctrl-C"),
];

/// Why a command failed: one line for people, and the exit code.
#[derive(Debug)]
pub(crate) struct CliError {
    code: u8,
    message: String,
}

impl CliError {
    fn new(code: u8, message: impl fmt::Display) -> Self {
        // Texts of libraries may span lines; ours never do.
        let message = message.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" ");
        Self { code, message }
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

impl From<StoreError> for CliError {
    fn from(e: StoreError) -> Self {
        match &e {
            StoreError::Encode { .. } => Self::internal(e),
            _ if e.is_of_output() => Self::output(e),
            // A run that can't be read is the same, whatever was to be done with it.
            _ => Self::input(e),
        }
    }
}

impl From<ReportError> for CliError {
    fn from(e: ReportError) -> Self {
        match e {
            ReportError::Write { .. } => Self::output(e),
            ReportError::Twice(_)
            | ReportError::NoRuns
            | ReportError::Label { .. }
            | ReportError::LabelTaken { .. } => Self::usage(e),
            _ => Self::input(e),
        }
    }
}

impl From<CatalogError> for CliError {
    fn from(e: CatalogError) -> Self {
        match &e {
            CatalogError::KeptForTraining(_) => Self::usage(e),
            // The option's name is the command line's.
            CatalogError::NoTrainingSeed(_) => Self::usage(format!("--{e}")),
            CatalogError::Write { .. }
            | CatalogError::NoDataFolder
            | CatalogError::Unpack { .. }
            | CatalogError::Generate(GenerateError::Suite(
                SuiteError::Write { .. } | SuiteError::NotEmpty { .. },
            )) => Self::output(e),
            _ => Self::input(e),
        }
    }
}
