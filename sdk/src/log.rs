//! Lines for the harness's task log.

/// The importance of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LogLevel {
    /// Something failed.
    Error,
    /// Something is odd.
    Warn,
    /// Something is worth knowing.
    Info,
    /// Something is of use to the planner's author only.
    Debug,
}

/// Appends a line to the task's log. It does nothing outside a call of the harness, e.g. in unit tests.
pub fn log(level: LogLevel, message: &str) {
    #[cfg(target_family = "wasm")]
    crate::wasm::log(level, message);
    #[cfg(not(target_family = "wasm"))]
    crate::native::log(level, message);
}
