//! Log lines of a native planner, and their levels.

use vb_sdk::LogLevel;

/// Where log lines of a planner go.
pub(crate) type Log<'a> = &'a mut dyn FnMut(LogLevel, &str);

/// The level of a number: 0 error, 1 warn, 2 info, else debug.
pub(crate) fn level_of(level: u32) -> LogLevel {
    match level {
        0 => LogLevel::Error,
        1 => LogLevel::Warn,
        2 => LogLevel::Info,
        _ => LogLevel::Debug,
    }
}
