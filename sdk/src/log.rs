//! Lines of the task log.

/// The severity of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LogLevel {
    /// A failure.
    Error,
    /// A possible problem.
    Warn,
    /// An action of the planner.
    Info,
    /// A detail for the planner's author.
    Debug,
}

/// Appends a line to the task's log. It has no effect outside a call of the harness, e.g. in unit tests.
pub fn log(level: LogLevel, message: &str) {
    #[cfg(target_family = "wasm")]
    crate::wasm::log(level, message);
    #[cfg(not(target_family = "wasm"))]
    crate::native::log(level, message);
}
