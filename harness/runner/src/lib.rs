//! Runs a planner over the tasks of a suite and records what happened.
