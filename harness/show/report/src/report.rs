//! Everything that is told of some runs.

use std::collections::BTreeSet;
use std::path::Path;

use crate::compare::Comparison;
use crate::figures::RunFigures;
use crate::ranking::Ranking;
use crate::robustness::Robustness;
use crate::runs::{Run, Runs, one_line};
use vb_score::Conditions;
use vb_world::TaskId;

/// What lies beside a page, which leads to it.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// The tasks of which there is a replay, `replays/WORLD/TASK.html`.
    pub replays: BTreeSet<TaskId>,
    /// The worlds of which there is a map, `maps/WORLD.html`.
    pub maps: BTreeSet<String>,
    /// The names of further files.
    pub files: Vec<String>,
}

#[derive(Clone, Debug)]
pub struct Report {
    pub(crate) runs: Runs,
    pub(crate) figures: Vec<RunFigures>,
    pub(crate) comparison: Option<Comparison>,
    /// The runs in the order in which comparisons have them.
    pub(crate) order: Option<Ranking>,
    /// Why the runs aren't ranked.
    pub(crate) unranked: Option<String>,
    pub(crate) robustness: Option<Robustness>,
    /// What it is called, if not by its runs.
    pub(crate) title: Option<String>,
}

impl Report {
    /// Computes all figures.
    #[must_use]
    pub fn new(runs: Runs) -> Self {
        let figures: Vec<RunFigures> = runs.runs.iter().map(|run| RunFigures::new(&runs, run)).collect();
        let comparison = Comparison::new(&runs);
        let order = comparison.as_ref().map(|c| Ranking::new(&figures, c));
        let unranked = runs.unranked();
        let robustness = Robustness::new(&runs);
        Self { runs, figures, comparison, order, unranked, robustness, title: None }
    }

    /// The same with a title: that of its page, and above its figures.
    #[must_use]
    pub fn titled(self, title: &str) -> Self {
        let title = one_line(title, 200);
        Self { title: Some(title).filter(|t| !t.is_empty()), ..self }
    }

    /// The same with its runs in this directory: pages name it for commands.
    #[must_use]
    pub fn placed(mut self, dir: &Path) -> Self {
        for run in &mut self.runs.runs {
            run.dir = dir.to_owned();
        }
        self
    }

    #[must_use]
    pub fn runs(&self) -> &Runs {
        &self.runs
    }

    /// Each run's figures, in the order of the runs.
    #[must_use]
    pub fn figures(&self) -> &[RunFigures] {
        &self.figures
    }

    /// How the runs compare; none if there is but one.
    #[must_use]
    pub fn comparison(&self) -> Option<&Comparison> {
        self.comparison.as_ref()
    }

    /// Who wins; none if there is but one run, or if the runs can't be ranked ([`Self::unranked`]).
    #[must_use]
    pub fn ranking(&self) -> Option<&Ranking> {
        self.order.as_ref().filter(|_| self.unranked.is_none())
    }

    /// Why the runs aren't ranked: the conditions in which they differ. None if they are ranked, or if there is but one run.
    #[must_use]
    pub fn unranked(&self) -> Option<&str> {
        self.unranked.as_deref()
    }

    /// How the planners bear what they perceive; none if none was run under several perception profiles.
    #[must_use]
    pub fn robustness(&self) -> Option<&Robustness> {
        self.robustness.as_ref()
    }

    /// A sentence on each run whose settings aren't the benchmark's.
    pub(crate) fn settings_notes(&self) -> Vec<String> {
        let note = |run: &Run| {
            let departures = Conditions::of(&run.header).departures();
            (!departures.is_empty()).then(|| {
                format!(
                    "{}: not the benchmark's settings ({}); comparable only with runs of the same settings.",
                    run.label,
                    one_line(&departures.join(", "), 240)
                )
            })
        };
        self.runs.runs.iter().filter_map(note).collect()
    }
}
