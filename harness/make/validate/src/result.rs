//! What an event came to.

use crate::check::{Check, Kind, Verdict};
use crate::event::{Event, Outcome};

/// One event, driven and judged.
#[derive(Clone, Debug)]
pub struct EventResult {
    pub event: &'static Event,
    /// What it measured; empty if its simulation failed.
    pub outcome: Outcome,
    /// Why its simulation failed, if it did.
    pub failure: Option<String>,
    /// The same event driven in the set-ups of references that it has; see [`crate::Setup`].
    pub setups: Vec<InSetup>,
    /// Its figures held against theory, then against the references: those with a set-up against the figures in it.
    pub checks: Vec<Check>,
}

/// One event, driven in the set-up of a kind of references.
#[derive(Clone, Debug)]
pub struct InSetup {
    /// The references.
    pub kind: Kind,
    /// What it measured; empty if its simulation failed.
    pub outcome: Outcome,
    /// Why its simulation failed, if it did.
    pub failure: Option<String>,
}

impl EventResult {
    /// Whether it was driven to its end, in every set-up, and no check failed.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.broken().next().is_none() && self.checks.iter().all(|c| c.verdict != Verdict::Fail)
    }

    /// Why simulations failed, if any did, and in which set-up.
    pub fn broken(&self) -> impl Iterator<Item = String> {
        let in_setup = |s: &InSetup| s.failure.as_ref().map(|why| format!("in {}: {why}", s.kind.setup()));
        self.failure.clone().into_iter().chain(self.setups.iter().filter_map(in_setup))
    }
}
