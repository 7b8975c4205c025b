//! Stages by hand, on which each environment goes up and down by its own successes.

use serde::{Deserialize, Serialize};
use vb_math::rng::Stream;

use crate::curriculum::Ending;
use crate::curriculum::spec::StageRule;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Manual {
    rule: StageRule,
    /// The tasks of each stage.
    stages: Vec<Vec<usize>>,
    places: Vec<Place>,
}

/// An environment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Place {
    stage: usize,
    /// Episodes at this stage since it was reached or last decided on, and successes among them.
    episodes: u32,
    successes: u32,
}

impl Manual {
    pub(crate) fn new(rule: StageRule, stages: Vec<Vec<usize>>, environments: usize) -> Self {
        Self { rule, stages, places: vec![Place::default(); environments] }
    }

    pub(crate) fn draw(&self, environment: usize, stream: &mut Stream) -> usize {
        let at = self.places[environment].stage;
        let is_review = stream.unit() < self.rule.review && at > 0;
        let own = if is_review { &self.stages[..at] } else { &self.stages[at..=at] };
        let all: usize = own.iter().map(Vec::len).sum();
        let mut k = stream.below(all as u64) as usize;
        for stage in own {
            match stage.get(k) {
                Some(task) => return *task,
                None => k -= stage.len(),
            }
        }
        unreachable!("k is below the number of tasks")
    }

    /// An episode counts if its task is of the stage at which the environment is.
    pub(crate) fn report(&mut self, ending: &Ending) {
        let place = &mut self.places[ending.environment];
        if !self.stages[place.stage].contains(&ending.task) {
            return;
        }
        place.episodes += 1;
        place.successes += u32::from(ending.is_success);
        if place.episodes < self.rule.window {
            return;
        }
        let share = f64::from(place.successes) / f64::from(place.episodes);
        let last = self.stages.len() - 1;
        let stage = if share >= self.rule.promote {
            (place.stage + 1).min(last)
        } else if share <= self.rule.demote {
            place.stage.saturating_sub(1)
        } else {
            place.stage
        };
        *place = Place { stage, ..Place::default() };
    }

    pub(crate) fn chances(&self, tasks: usize) -> Vec<f64> {
        let mut chances = vec![0.0; tasks];
        let mut spread = |stages: &[Vec<usize>], chance: f64| {
            let all: usize = stages.iter().map(Vec::len).sum();
            stages.iter().flatten().for_each(|task| chances[*task] += chance / all as f64);
        };
        let one = 1.0 / self.places.len() as f64;
        for place in &self.places {
            let review = if place.stage > 0 { self.rule.review } else { 0.0 };
            spread(&self.stages[place.stage..=place.stage], one * (1.0 - review));
            if review > 0.0 {
                spread(&self.stages[..place.stage], one * review);
            }
        }
        chances
    }

    pub(crate) fn at(&self) -> Vec<usize> {
        self.places.iter().map(|p| p.stage).collect()
    }

    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.rule == other.rule
            && self.stages == other.stages
            && self.places.len() == other.places.len()
            && self.places.iter().all(|p| {
                // Counts are reset when a window is full.
                p.stage < self.stages.len()
                    && p.successes <= p.episodes
                    && p.episodes < self.rule.window.max(1)
            })
    }
}
