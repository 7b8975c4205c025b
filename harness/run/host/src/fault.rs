//! The faults of a planner at work.

use std::fmt;

use serde::Serialize;
use vb_worker::protocol::MALFORMED;

use crate::hint;
use vb_sdk::fault::{Blame, FaultCode};

/// The reason why a planner ended its task.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error("{}: {cause}", self.place())]
pub struct PlannerFault {
    /// The number of the step, from 0; `None` during `init`.
    pub step: Option<u64>,
    /// The simulated time of that step, s; `None` during `init`.
    pub time: Option<f64>,
    pub cause: FaultCause,
}

impl PlannerFault {
    /// The stable name of the cause, for results.
    #[must_use]
    pub fn code(&self) -> FaultCode {
        self.cause.code()
    }

    /// Tells whether the planner is to blame, and not the harness or the machine.
    #[must_use]
    pub fn is_planners(&self) -> bool {
        self.code().blame() == Blame::Planner
    }

    /// The place of the fault: `init`, or `step 12 (t = 1.20 s)`.
    #[must_use]
    pub fn place(&self) -> String {
        match (self.step, self.time) {
            (Some(step), Some(time)) => format!("step {step} (t = {time:.2} s)"),
            (Some(step), None) => format!("step {step}"),
            (None, _) => "init".to_owned(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FaultCause {
    /// The planner computed longer than it may in one call.
    #[error("exceeded its limit of {budget} units of fuel")]
    OutOfFuel { budget: u64 },
    /// The planner computed longer than it may in all of a task.
    #[error("exceeded the task's limit of {budget} units of fuel")]
    OutOfTaskFuel { budget: u64 },
    #[error("requested {wanted} {what}; the limit is {limit}")]
    OutOfMemory {
        what: Resource,
        /// The amount with the request granted.
        wanted: u64,
        limit: u64,
    },
    /// The planner's process had no memory left and gave up.
    #[error("{}", used_up(*.limit))]
    ProcessOutOfMemory {
        /// The memory that it may have, bytes; `None` for a command, which the harness sets no limit.
        limit: Option<u64>,
    },
    #[error("overflowed its stack{}{}", of_bytes(*.limit), in_functions(.backtrace))]
    StackOverflow {
        /// The stack that it may have, bytes; `None` if it was the stack that its compiler keeps in its own memory.
        limit: Option<u64>,
        /// The innermost functions, the failing one first.
        backtrace: Vec<String>,
    },
    /// The calls in the planner's process were nested more deeply than its stack allows.
    #[error("overflowed its stack{}", of_bytes(*.limit))]
    ProcessStackOverflow {
        /// The stack that the system lets it have, bytes; `None` if that isn't known.
        limit: Option<u64>,
    },
    #[error("trapped: {message}{}", in_functions(.backtrace))]
    Trap {
        /// The engine's text.
        message: String,
        /// The innermost functions, the failing one first.
        backtrace: Vec<String>,
    },
    #[error("{message}")]
    Panic {
        /// The text of the panic: `panicked at FILE:LINE:COLUMN: TEXT`.
        message: String,
    },
    /// The planner's `step` returned an error.
    #[error("returned an error: {message}")]
    Error { message: String },
    /// The planner's `init` returned an error.
    #[error("returned an error: {message}")]
    InitFailed { message: String },
    /// The planner's command holds a value that there isn't.
    #[error("{message}")]
    BadCommand {
        /// The field, its value, and what there is.
        message: String,
    },
    #[error("{field} is {value}; a command must be finite")]
    InvalidOutput {
        /// The field of the command: `steering`, `throttle` or `brake`.
        field: &'static str,
        /// The value of the field: `NaN`, `inf` or `-inf`.
        value: String,
    },
    #[error("its result exceeds the limit of {limit} bytes per call")]
    OutputTooLarge {
        /// The greatest size that the result may have, bytes.
        limit: u64,
    },
    #[error("used {import}, which is not available to planners")]
    ImportDenied { import: String },
    /// The worker's plugin speaks another version of the interface than the one it was loaded with.
    #[error("speaks another version of the planner interface: {message}")]
    AbiMismatch { message: String },
    #[error("{how}")]
    Crashed { how: ProcessEnd },
    #[error("did not respond within {limit_ms} ms of wall-clock time")]
    Hung {
        /// The wall-clock time that it had, ms.
        limit_ms: u64,
    },
    #[error("violated the protocol: {message}")]
    Protocol { message: String },
    /// The operating system refused what the host needs to run the planner, address space for instance. The planner is
    /// not to blame.
    #[error("the machine denied a resource to the host: {message}")]
    Machine { message: String },
    /// A WASM call took more wall-clock time than any fuel can explain. Fuel is what judges a planner, so this is the
    /// machine's fault, or a bug of the harness.
    #[error("the call took more than {limit_ms} ms of wall-clock time although it had fuel left")]
    Watchdog {
        /// The wall-clock time that the call had, ms.
        limit_ms: u64,
    },
    /// The process that runs native planners can't be started or confined.
    #[error("the planner's process cannot be started: {message}")]
    Worker { message: String },
    /// No external planner connected within the time limit.
    #[error("{message}")]
    PeerMissing { message: String },
    /// The external planner left during the task.
    #[error("{message}")]
    PeerLeft { message: String },
    /// The external planner did not answer within the time limit.
    #[error("{message}")]
    PeerLate { message: String },
    /// The external planner sent messages that can't be used.
    #[error("{message}")]
    PeerProtocol { message: String },
}

impl FaultCause {
    /// A process that somebody else ended; `who` it was.
    pub(crate) fn killed(who: &str) -> Self {
        let message =
            format!("{who} was killed from outside, by the system for lack of memory or by another process");
        Self::Machine { message }
    }

    /// The cause as that of a failed `init`, where a returned error has a name of its own.
    pub(crate) fn in_init(self) -> Self {
        match self {
            Self::Error { message } => Self::InitFailed { message },
            other => other,
        }
    }

    /// The stable name of the cause.
    #[must_use]
    pub fn code(&self) -> FaultCode {
        match self {
            Self::OutOfFuel { .. } | Self::OutOfTaskFuel { .. } => FaultCode::OutOfFuel,
            Self::OutOfMemory { .. } | Self::ProcessOutOfMemory { .. } => FaultCode::OutOfMemory,
            Self::StackOverflow { .. } | Self::ProcessStackOverflow { .. } => FaultCode::StackOverflow,
            Self::Trap { .. } => FaultCode::Trap,
            Self::Panic { .. } => FaultCode::Panic,
            Self::Error { .. } => FaultCode::Error,
            Self::InitFailed { .. } => FaultCode::InitFailed,
            Self::BadCommand { .. } | Self::InvalidOutput { .. } | Self::OutputTooLarge { .. } => {
                FaultCode::InvalidOutput
            }
            Self::ImportDenied { .. } => FaultCode::ImportDenied,
            Self::AbiMismatch { .. } => FaultCode::AbiMismatch,
            Self::Crashed { .. } | Self::PeerLeft { .. } => FaultCode::Crashed,
            Self::Hung { .. } | Self::PeerMissing { .. } | Self::PeerLate { .. } => FaultCode::Hung,
            Self::Protocol { .. } | Self::PeerProtocol { .. } => FaultCode::Protocol,
            Self::Machine { .. } => FaultCode::Machine,
            Self::Watchdog { .. } => FaultCode::Watchdog,
            Self::Worker { .. } => FaultCode::Worker,
        }
    }

    /// A hint on what the planner's author or user can do about the cause.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::OutOfFuel { .. } => {
                "compute less per call, or raise fuel_init or fuel_per_step (run --limits); one unit is about one instruction"
            }
            Self::OutOfTaskFuel { .. } => {
                "compute less per call or less often, or raise fuel_per_task (run --limits)"
            }
            Self::OutOfMemory { what: Resource::Memory, .. }
            | Self::ProcessOutOfMemory { limit: Some(_) } => {
                "allocate less, or raise memory_bytes (run --limits)"
            }
            Self::OutOfMemory { what: Resource::Table, .. } => {
                "make fewer tables, or raise table_elements (run --limits)"
            }
            Self::ProcessOutOfMemory { limit: None } => {
                "allocate less, or free memory of the machine; commands have no limit of the harness"
            }
            Self::StackOverflow { limit: None, .. } => {
                "recurse less deeply and keep big arrays on the heap, or link it with a larger stack (-z stack-size)"
            }
            Self::StackOverflow { .. } => {
                "recurse less deeply and keep big arrays on the heap, or raise stack_bytes (run --limits)"
            }
            Self::ProcessStackOverflow { .. } => {
                "recurse less deeply and keep large arrays on the heap; the stack size is set by the system (ulimit -s), not \
                 by the harness"
            }
            Self::Trap { backtrace, .. } if backtrace.is_empty() => {
                "the function is unknown; check pointers, lengths and texts in the results of calls"
            }
            Self::Trap { .. } => "look at the functions named; run --verbose shows more of them",
            Self::Panic { message } => hint::panic(message),
            Self::Error { .. } | Self::InitFailed { .. } => {
                "the planner's code reported this error: see there, or run check --plugin"
            }
            Self::BadCommand { .. } => "start from a command that is all zero, and set its fields",
            Self::InvalidOutput { .. } => "look for a division by zero",
            Self::OutputTooLarge { .. } => "send less debug data, or raise output_bytes (run --limits)",
            Self::ImportDenied { .. } => "planners have no files, network or processes: remove the use",
            Self::AbiMismatch { .. } => "rebuild the plugin with the harness's vb-sdk",
            Self::Crashed { .. } => "run the planner under a debugger, or build it for WASM for a backtrace",
            Self::Hung { .. } => "compute less per call, or raise watchdog_ms (run --limits)",
            Self::Protocol { message } if message.starts_with(MALFORMED) => {
                "compare it with the table of fields in docs/worker-protocol.md, and print nothing to standard output"
            }
            Self::Protocol { .. } => "send nothing but the protocol's messages to standard output",
            Self::Machine { .. } => "free memory or lower --jobs; run --resume re-runs the task",
            Self::Watchdog { .. } => {
                "the machine is overloaded: lower --jobs or raise watchdog_ms (run --limits); run --resume re-runs the task"
            }
            Self::Worker { .. } => "see what the system denied; run --resume re-runs the task",
            Self::PeerMissing { .. } => {
                "start the node first, with the same ROS_DOMAIN_ID and a network interface in common (docs/ros2.md)"
            }
            Self::PeerLeft { .. } => "see what the node printed before it ended",
            Self::PeerLate { .. } => {
                "answer each new time on /clock with one command, or call /vertibench/step, or raise --answer-timeout (docs/ros2.md)"
            }
            Self::PeerProtocol { .. } => "docs/ros2.md lists the topics with their types and QoS",
        }
    }

    /// The innermost functions at the fault, the failing one first. It is empty where they aren't known.
    #[must_use]
    pub fn backtrace(&self) -> &[String] {
        match self {
            Self::Trap { backtrace, .. } | Self::StackOverflow { backtrace, .. } => backtrace,
            _ => &[],
        }
    }
}

/// The resources that a planner may run out of, beside fuel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Resource {
    /// Memory, in bytes.
    Memory,
    /// The elements of tables.
    Table,
}

impl fmt::Display for Resource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Memory => "bytes of memory",
            Self::Table => "table elements",
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProcessEnd {
    Signal(i32),
    Exit(i32),
    /// It was ended by the harness, since it closed its output and stayed.
    Mute,
}

impl fmt::Display for ProcessEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Signals that planners die of, with the numbers that Linux and macOS share, and what they mean.
        const SIGNALS: [(i32, &str); 8] = [
            (4, "SIGILL: illegal instruction"),
            (6, "SIGABRT: aborted"),
            (8, "SIGFPE: integer division by zero"),
            (9, "SIGKILL: killed from outside, or for lack of memory"),
            (11, "SIGSEGV: invalid memory access"),
            (13, "SIGPIPE: write to a closed pipe"),
            (15, "SIGTERM: terminated from outside"),
            (24, "SIGXCPU: processor time limit exceeded"),
        ];
        match *self {
            Self::Exit(code) => write!(f, "it exited with code {code}"),
            Self::Mute => f.write_str("its process closed its output and was killed"),
            // SIGBUS and SIGSYS have other numbers elsewhere.
            #[cfg(target_os = "linux")]
            Self::Signal(7) => {
                f.write_str("its process died of signal 7 (SIGBUS: access to nonexistent memory)")
            }
            #[cfg(target_os = "linux")]
            Self::Signal(31) => f.write_str("its process died of signal 31 (SIGSYS: forbidden system call)"),
            Self::Signal(signal) => {
                write!(f, "its process died of signal {signal}")?;
                SIGNALS.iter().find(|(n, _)| *n == signal).map_or(Ok(()), |(_, text)| write!(f, " ({text})"))
            }
        }
    }
}

fn used_up(limit: Option<u64>) -> String {
    limit.map_or_else(|| "ran out of memory".into(), |n| format!("exceeded its memory limit of {n} bytes"))
}

fn of_bytes(limit: Option<u64>) -> String {
    limit.map_or_else(String::new, |n| format!(" of {n} bytes"))
}

fn in_functions(backtrace: &[String]) -> String {
    /// More than these are for --verbose.
    const SHOWN: usize = 5;
    if backtrace.is_empty() {
        return String::new();
    }
    let shown = &backtrace[..backtrace.len().min(SHOWN)];
    format!(" in {}", shown.join(" < "))
}

#[cfg(test)]
mod tests {
    use vb_worker::protocol::FrameError;

    use super::*;

    #[test]
    fn a_fault_reads_as_one_line_that_says_where() {
        let cause = FaultCause::InvalidOutput { field: "steering", value: "NaN".into() };
        let fault = PlannerFault { step: Some(12), time: Some(1.2), cause };
        assert_eq!(fault.to_string(), "step 12 (t = 1.20 s): steering is NaN; a command must be finite");
        assert_eq!(fault.code().name(), "planner/invalid-output");
        let cause = FaultCause::InitFailed { message: "no path".into() };
        let fault = PlannerFault { step: None, time: None, cause };
        assert_eq!(fault.to_string(), "init: returned an error: no path");
    }

    #[test]
    fn a_refusal_of_memory_tells_what_was_wanted_and_the_limit() {
        let cause = |what| FaultCause::OutOfMemory { what, wanted: 128, limit: 64 };
        assert_eq!(cause(Resource::Memory).to_string(), "requested 128 bytes of memory; the limit is 64");
        assert_eq!(cause(Resource::Table).to_string(), "requested 128 table elements; the limit is 64");
        // Each names the limit that is to be raised, and no other.
        assert!(!cause(Resource::Memory).hint().contains("table_elements"));
        assert!(!cause(Resource::Table).hint().contains("memory_bytes"));
        let process = |limit| FaultCause::ProcessOutOfMemory { limit };
        assert_eq!(process(Some(64)).to_string(), "exceeded its memory limit of 64 bytes");
        assert_eq!(process(None).to_string(), "ran out of memory");
        assert!(!process(None).hint().contains("--limits"));
    }

    #[test]
    fn a_message_of_the_wrong_shape_is_told_apart_from_one_at_the_wrong_time() {
        let hint = |message: String| FaultCause::Protocol { message }.hint();
        let shape = FrameError::Malformed("missing field `brake`".into()).to_string();
        assert!(hint(shape).contains("fields in docs/worker-protocol.md"));
        assert!(hint("it closed its output".into()).contains("nothing but the protocol's messages"));
    }

    #[test]
    fn the_end_of_a_process_is_told_in_words() {
        let text = |how| FaultCause::Crashed { how }.to_string();
        assert_eq!(text(ProcessEnd::Exit(3)), "it exited with code 3");
        assert!(text(ProcessEnd::Signal(11)).contains("signal 11 (SIGSEGV"));
        assert_eq!(text(ProcessEnd::Signal(60)), "its process died of signal 60");
    }
}
