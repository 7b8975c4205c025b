//! The place to which a planner's log lines go.

use std::fmt;

use vb_sdk::LogLevel;

use vb_files::printable;

type Take = dyn FnMut(LogLevel, &str) + Send;

/// A sink that takes the log lines of one session.
pub struct LogSink(Box<Take>);

impl LogSink {
    /// A sink that hands each line to `f`. Control characters are replaced beforehand.
    pub fn new(f: impl FnMut(LogLevel, &str) + Send + 'static) -> Self {
        Self(Box::new(f))
    }

    #[must_use]
    pub fn discard() -> Self {
        Self::new(|_, _| {})
    }
}

impl fmt::Debug for LogSink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LogSink")
    }
}

/// A sink with a budget.
#[derive(Debug)]
pub(crate) struct Log {
    sink: LogSink,
    left: usize,
    full: bool,
}

impl Log {
    pub(crate) fn new(sink: LogSink, budget: usize) -> Self {
        Self { sink, left: budget, full: false }
    }

    pub(crate) fn write(&mut self, level: LogLevel, message: &str) {
        if self.full {
            return;
        }
        if message.len() > self.left {
            self.full = true;
            (self.sink.0)(LogLevel::Warn, "the planner's log is full: further lines are dropped");
            return;
        }
        self.left -= message.len();
        (self.sink.0)(level, &printable(message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[test]
    fn a_full_log_says_so_once_and_drops_the_rest() {
        let lines = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&lines);
        let mut log = Log::new(LogSink::new(move |_, m| kept.lock().unwrap().push(m.to_owned())), 10);
        for message in ["123456", "1\u{7}", "long long", "x"] {
            log.write(LogLevel::Info, message);
        }
        let full = "the planner's log is full: further lines are dropped";
        assert_eq!(*lines.lock().unwrap(), ["123456", "1\u{fffd}", full]);
    }
}
