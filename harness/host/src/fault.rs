//! What can go wrong with a planner at work.

use serde::Serialize;

/// Why a planner ended its task.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error("{}: {cause}", self.place())]
pub struct PlannerFault {
    /// Number of the step, from 0; `None` during `init`.
    pub step: Option<u64>,
    /// What happened.
    pub cause: FaultCause,
}

impl PlannerFault {
    /// A stable name of the cause, for result files: `out-of-fuel`, `out-of-memory`, `trap`, `panic`, `error`,
    /// `invalid-output` or `machine`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self.cause {
            FaultCause::OutOfFuel { .. } => "out-of-fuel",
            FaultCause::OutOfMemory { .. } => "out-of-memory",
            FaultCause::Trap { .. } => "trap",
            FaultCause::Panic { .. } => "panic",
            FaultCause::Error { .. } => "error",
            FaultCause::InvalidOutput { .. } => "invalid-output",
            FaultCause::Machine { .. } => "machine",
        }
    }

    /// Whether the planner is to blame: all causes but a failure of the machine.
    #[must_use]
    pub fn is_planners(&self) -> bool {
        !matches!(self.cause, FaultCause::Machine { .. })
    }

    fn place(&self) -> String {
        self.step.map_or_else(|| "planner init".to_owned(), |n| format!("planner step {n}"))
    }
}

/// The causes of a [`PlannerFault`].
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FaultCause {
    /// It computed longer than it may.
    #[error("it used up its {budget} units of fuel; make it cheaper or raise the limit")]
    OutOfFuel {
        /// Fuel that it had for the call.
        budget: u64,
    },
    /// It wanted more memory than it may have.
    #[error("it wanted more than its {limit} bytes of memory")]
    OutOfMemory {
        /// Bytes that it may have.
        limit: usize,
    },
    /// The WebAssembly code trapped.
    #[error("{message}{}", in_functions(.backtrace))]
    Trap {
        /// The engine's text.
        message: String,
        /// Innermost functions, the failing one first.
        backtrace: Vec<String>,
    },
    /// It panicked.
    #[error("it {message}")]
    Panic {
        /// `panicked at FILE:LINE:COLUMN: TEXT`.
        message: String,
    },
    /// It returned an error.
    #[error("{message}")]
    Error {
        /// The planner's text.
        message: String,
    },
    /// A number of its command is not finite.
    #[error("{field} is {value}; a command must be finite")]
    InvalidOutput {
        /// `steering`, `throttle` or `brake`.
        field: &'static str,
        /// `NaN`, `inf` or `-inf`.
        value: String,
    },
    /// The operating system refused what the host needs to run the planner, address space for instance. No fault of
    /// the planner.
    #[error("the machine refused what the host needs: {message}")]
    Machine {
        /// The system's text.
        message: String,
    },
}

fn in_functions(backtrace: &[String]) -> String {
    if backtrace.is_empty() { String::new() } else { format!(" in {}", backtrace.join(" < ")) }
}

/// Text from a planner as one printable line: terminals act on control characters.
pub(crate) fn one_line(text: &str) -> String {
    /// Long enough for any message meant to be read.
    const MAX: usize = 2000;
    let mut line = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = line.char_indices().nth(MAX) {
        line.truncate(end);
        line.push('…');
    }
    line.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_reads_as_one_line_that_says_where() {
        let cause = FaultCause::InvalidOutput { field: "steering", value: "NaN".into() };
        let fault = PlannerFault { step: Some(12), cause };
        assert_eq!(fault.to_string(), "planner step 12: steering is NaN; a command must be finite");
        assert_eq!(fault.kind(), "invalid-output");
        let fault = PlannerFault { step: None, cause: FaultCause::Error { message: "no path".into() } };
        assert_eq!(fault.to_string(), "planner init: no path");
    }

    #[test]
    fn planner_text_cannot_command_the_terminal() {
        assert_eq!(one_line("a:\n  b\r\n\n\u{1b}[2Jc"), "a: b \u{fffd}[2Jc");
        assert_eq!(one_line(&"x".repeat(5000)).chars().count(), 2001);
    }
}
