//! The ways in which a trial can end.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The outcome of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The vehicle reached the goal in time.
    Success,
    /// The trial failed and the vehicle was rolled over.
    Rollover,
    /// The vehicle didn't make progress.
    Stuck,
    /// The time limit was reached.
    Timeout,
    /// The vehicle left the world.
    OutOfBounds,
    /// The planner failed: it crashed, ran out of its budget, or returned a command that is not a number.
    PlannerError,
    /// The simulation failed.
    SimError,
    /// The harness or the machine failed: the trial is not evidence about the planner and is not counted in rates.
    HostError,
}

impl Outcome {
    /// All outcomes in the order of tables.
    pub const ALL: [Self; 8] = [
        Self::Success,
        Self::Rollover,
        Self::Stuck,
        Self::Timeout,
        Self::OutOfBounds,
        Self::PlannerError,
        Self::SimError,
        Self::HostError,
    ];

    /// The index of the outcome in [`Self::ALL`], which determines its colour in HTML pages.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The name of the outcome in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Success => "success",
            Self::Rollover => "rollover",
            Self::Stuck => "stuck",
            Self::Timeout => "timeout",
            Self::OutOfBounds => "out_of_bounds",
            Self::PlannerError => "planner_error",
            Self::SimError => "sim_error",
            Self::HostError => "host_error",
        }
    }

    /// The paper's class of a trial with this outcome. The paper's table has only success, rollover and stuck, which
    /// sum to 100 %; the other failures are assigned to them: a vehicle that left the world counts as stuck, and any
    /// other failed trial as a rollover if the vehicle was rolled over by the rules in force (`rolled_over`), else as
    /// stuck.
    #[must_use]
    pub fn three_way(self, rolled_over: bool) -> ThreeWay {
        match self {
            Self::Success => ThreeWay::Success,
            Self::Rollover => ThreeWay::Rollover,
            Self::Stuck | Self::OutOfBounds => ThreeWay::Stuck,
            Self::Timeout | Self::PlannerError | Self::SimError | Self::HostError if rolled_over => {
                ThreeWay::Rollover
            }
            Self::Timeout | Self::PlannerError | Self::SimError | Self::HostError => ThreeWay::Stuck,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The three classes of the paper's failure table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ThreeWay {
    /// The vehicle reached the goal.
    Success,
    /// The trial failed, and the vehicle was rolled over.
    Rollover,
    /// The trial failed otherwise.
    Stuck,
}

impl ThreeWay {
    /// All classes in the order of tables.
    pub const ALL: [Self; 3] = [Self::Success, Self::Rollover, Self::Stuck];
}

/// The part that failed when a trial could not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The planner failed.
    Planner,
    /// The simulation failed.
    Simulation,
    /// The harness or the machine failed.
    Host,
}

impl Fault {
    /// The outcome of such a trial.
    #[must_use]
    pub fn outcome(self) -> Outcome {
        match self {
            Self::Planner => Outcome::PlannerError,
            Self::Simulation => Outcome::SimError,
            Self::Host => Outcome::HostError,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_is_the_place_among_all() {
        assert_eq!(Outcome::ALL.map(Outcome::index), [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn names_in_files_and_in_text_agree() {
        for outcome in Outcome::ALL {
            assert_eq!(serde_json::to_string(&outcome).unwrap(), format!("\"{outcome}\""));
        }
    }

    #[test]
    fn failures_that_the_paper_does_not_know_are_folded_into_its_classes() {
        // docs/scoring.md: boundary into stuck, timeout by the roll at the end.
        assert_eq!(Outcome::Timeout.three_way(false), ThreeWay::Stuck);
        assert_eq!(Outcome::Timeout.three_way(true), ThreeWay::Rollover);
        assert_eq!(Outcome::OutOfBounds.three_way(true), ThreeWay::Stuck);
        assert_eq!(Outcome::Success.three_way(true), ThreeWay::Success);
        assert_eq!(Outcome::PlannerError.three_way(false), ThreeWay::Stuck);
    }
}
