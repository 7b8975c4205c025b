//! The choice of the tasks whose records keep what the planner logged.

use serde::{Deserialize, Serialize};

/// The tasks whose records keep the last lines of the planner's log. The mode doesn't affect the trials; since records
/// contain the lines, a run and its re-run for verification must use the same mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogMode {
    /// No record keeps its log.
    None,
    /// The records of tasks that didn't succeed keep their logs, whatever the reason of the failure.
    #[default]
    Failed,
    /// All records keep their logs.
    All,
}

impl LogMode {
    /// All modes.
    pub const ALL: [Self; 3] = [Self::All, Self::Failed, Self::None];

    /// Tells whether the log of a task is kept, by whether the task succeeded.
    #[must_use]
    pub fn keeps(self, succeeded: bool) -> bool {
        match self {
            Self::None => false,
            Self::Failed => !succeeded,
            Self::All => true,
        }
    }

    /// The name as written in run.json and on the command line: `none`, `failed` or `all`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Failed => "failed",
            Self::All => "all",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_kept_if_nothing_is_said_and_successes_on_demand() {
        let kept = |mode: LogMode| (mode.keeps(true), mode.keeps(false));
        assert_eq!(kept(LogMode::default()), (false, true));
        assert_eq!(kept(LogMode::All), (true, true));
        assert_eq!(kept(LogMode::None), (false, false));
        for mode in LogMode::ALL {
            assert_eq!(serde_json::to_value(mode).unwrap(), mode.name());
        }
    }
}
