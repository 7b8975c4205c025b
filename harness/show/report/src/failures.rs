//! How tasks fail: what is counted, and over which tasks.

use vb_score::{Cause, Outcome};

use crate::Report;
use crate::figures::{Figures, Split};

/// A way to fail: what stopped the vehicle, or how else the task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// It rolled over or got stuck, by this.
    Cause(Cause),
    /// It rolled over or got stuck, and the record has no cause: re-scoring gave it another outcome.
    Unsaid(Outcome),
    /// It ended so.
    Outcome(Outcome),
}

impl Failure {
    /// What it is called in tables.
    pub(crate) fn title(self) -> String {
        match self {
            Self::Cause(cause) => cause.title().to_owned(),
            Self::Unsaid(outcome) => format!("{}, cause unknown", Self::Outcome(outcome).title()),
            Self::Outcome(outcome) => outcome.name().replace('_', " "),
        }
    }

    pub(crate) fn count(self, figures: &Figures) -> u64 {
        match self {
            Self::Cause(cause) => figures.caused(cause),
            Self::Unsaid(outcome) => {
                let of =
                    Cause::ALL.iter().map(|cause| Self::Cause(*cause)).filter(|f| f.outcome() == outcome);
                figures.count(outcome).saturating_sub(of.map(|f| f.count(figures)).sum())
            }
            Self::Outcome(outcome) => figures.count(outcome),
        }
    }

    pub(crate) fn outcome(self) -> Outcome {
        match self {
            Self::Cause(cause) => cause.outcome(),
            Self::Unsaid(outcome) | Self::Outcome(outcome) => outcome,
        }
    }
}

/// The ways in which tasks of these runs fail: what stopped vehicles, the most frequent first, then how all others ended. What
/// the harness or the machine failed is none.
pub(crate) fn failures(report: &Report) -> Vec<Failure> {
    let total = |f: Failure| report.figures.iter().map(|own| f.count(&own.all)).sum::<u64>();
    let causes = Cause::by_frequency(|cause| total(Failure::Cause(cause)));
    let causes = causes.into_iter().map(|(cause, _)| Failure::Cause(cause));
    let other = |o: &Outcome| {
        !matches!(o, Outcome::Success | Outcome::Rollover | Outcome::Stuck | Outcome::HostError)
    };
    let others = Outcome::ALL.into_iter().filter(other).map(Failure::Outcome);
    let unsaid = [Outcome::Rollover, Outcome::Stuck].map(Failure::Unsaid);
    causes.chain(unsaid).chain(others).filter(|f| total(*f) > 0).collect()
}

/// Tasks over which failures are counted.
pub(crate) struct Group<'a> {
    /// What they have in common.
    pub(crate) split: Option<Split>,
    /// Their name: a run's label, or a level.
    pub(crate) name: String,
    pub(crate) run: usize,
    pub(crate) figures: &'a Figures,
    /// Whether they are all tasks of the run.
    pub(crate) whole: bool,
}

/// Of several runs each, of a single one all of it with its levels of elevation and its kinds of ground.
pub(crate) fn groups(report: &Report) -> Vec<Group<'_>> {
    let runs = report.runs.runs.iter().zip(&report.figures).enumerate();
    let whole =
        |run, name: &str, figures| Group { split: None, name: name.to_owned(), run, figures, whole: true };
    if report.runs.runs.len() > 1 {
        return runs.map(|(run, (r, f))| whole(run, &r.label, &f.all)).collect();
    }
    let Some(own) = report.figures.first() else { return Vec::new() };
    let levels = [Split::Elevation, Split::Terrain].into_iter().flat_map(|split| {
        let levels = own.splits.get(split as usize).into_iter().flatten();
        levels.filter(|(_, f)| f.tasks > 0).map(move |(level, figures)| Group {
            split: Some(split),
            name: (*level).to_owned(),
            run: 0,
            figures,
            whole: false,
        })
    });
    std::iter::once(whole(0, "all tasks", &own.all)).chain(levels).collect()
}
