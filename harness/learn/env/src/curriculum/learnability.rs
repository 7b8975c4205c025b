//! Tasks by how much can be learned from them: p(1 − p), where p is the share of drives that reach the goal.

use serde::{Deserialize, Serialize};
use vb_math::rng::Stream;

use crate::curriculum::spec::LearnabilitySpec;
use crate::curriculum::{Ending, pick};

/// Estimates of how often tasks are done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Learnability {
    spec: LearnabilitySpec,
    /// Of each task, the number of its level.
    levels: Vec<usize>,
    by_task: Vec<Count>,
    by_level: Vec<Count>,
}

/// Outcomes, of which each counts less with each later one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Count {
    successes: f64,
    outcomes: f64,
}

impl Count {
    fn add(&mut self, keep: f64, is_success: bool) {
        self.successes = keep * self.successes + f64::from(u8::from(is_success));
        self.outcomes = keep * self.outcomes + 1.0;
    }

    /// Whether it can be counted: no more successes, but for the last digits, than outcomes, and these no more than there is time for.
    fn is_sound(&self) -> bool {
        (0.0..=1e12).contains(&self.outcomes) && (0.0..=self.outcomes + 1e-6).contains(&self.successes)
    }

    /// The share of successes, where `prior` outcomes with the share `share` are added.
    fn share(&self, prior: f64, share: f64) -> f64 {
        (self.successes + prior * share) / (self.outcomes + prior)
    }
}

impl Learnability {
    pub(crate) fn new(spec: &LearnabilitySpec, levels: Vec<usize>) -> Self {
        let most = levels.iter().max().map_or(0, |m| m + 1);
        let by_task = vec![Count::default(); levels.len()];
        Self { spec: spec.clone(), levels, by_task, by_level: vec![Count::default(); most] }
    }

    /// The estimated share of drives of a task that reach the goal. Of what was never driven, half of them are taken to.
    fn p(&self, task: usize) -> f64 {
        let level = self.by_level[self.levels[task]].share(1.0, 0.5);
        self.by_task[task].share(self.spec.prior, level)
    }

    fn weights(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        (0..self.levels.len()).map(|task| {
            let p = self.p(task);
            p * (1.0 - p)
        })
    }

    pub(crate) fn draw(&self, stream: &mut Stream) -> usize {
        if stream.unit() < self.spec.explore {
            return stream.below(self.levels.len() as u64) as usize;
        }
        pick(self.weights(), stream)
    }

    pub(crate) fn report(&mut self, ending: &Ending) {
        self.by_task[ending.task].add(self.spec.keep, ending.is_success);
        self.by_level[self.levels[ending.task]].add(self.spec.keep_level, ending.is_success);
    }

    pub(crate) fn chances(&self) -> Vec<f64> {
        let (sum, even) = (self.weights().sum::<f64>(), 1.0 / self.levels.len() as f64);
        let share = |w: f64| if sum > 0.0 { w / sum } else { even };
        self.weights().map(|w| self.spec.explore * even + (1.0 - self.spec.explore) * share(w)).collect()
    }

    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.spec == other.spec
            && self.levels == other.levels
            && (self.by_task.len(), self.by_level.len()) == (other.by_task.len(), other.by_level.len())
            && self.by_task.iter().chain(&self.by_level).all(Count::is_sound)
    }
}
