//! Everything that is told of some runs.

use std::collections::BTreeSet;
use std::path::Path;

use crate::compare::Comparison;
use crate::figures::RunFigures;
use crate::page;
use crate::ranking::Ranking;
use crate::robustness::Robustness;
use crate::runs::{Runs, one_line};

/// What lies beside a page, which leads to it.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// The tasks of which there is a replay, `replays/WORLD/TASK.html`.
    pub replays: BTreeSet<String>,
    /// The worlds of which there is a map, `maps/WORLD.html`.
    pub maps: BTreeSet<String>,
    /// The names of further files.
    pub files: Vec<String>,
}

/// Runs with their figures and comparison.
#[derive(Clone, Debug)]
pub struct Report {
    pub(crate) runs: Runs,
    pub(crate) figures: Vec<RunFigures>,
    pub(crate) comparison: Option<Comparison>,
    pub(crate) ranking: Option<Ranking>,
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
        let ranking = comparison.as_ref().map(|c| Ranking::new(&figures, c));
        let robustness = Robustness::new(&runs);
        Self { runs, figures, comparison, ranking, robustness, title: None }
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

    /// The runs.
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

    /// Who wins; none if there is but one run.
    #[must_use]
    pub fn ranking(&self) -> Option<&Ranking> {
        self.ranking.as_ref()
    }

    /// How the planners bear what they perceive; none if none was run under several perception profiles.
    #[must_use]
    pub fn robustness(&self) -> Option<&Robustness> {
        self.robustness.as_ref()
    }

    /// The page: one file that needs nothing else, no network either.
    #[must_use]
    pub fn page(&self, beside: &Beside) -> String {
        page::page(self, beside)
    }
}
