//! Prioritised level replay.

use serde::{Deserialize, Serialize};
use vb_math::pow;
use vb_math::rng::Stream;

use crate::curriculum::spec::ReplaySpec;
use crate::curriculum::{Ending, MOST_DRAWN, pick};

/// Scores of tasks, and when they were driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Replay {
    spec: ReplaySpec,
    tasks: Vec<Driven>,
    /// Episodes that have ended.
    episodes: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Driven {
    /// The learner's score, once there is one.
    score: Option<f64>,
    /// The number of the last episode of it that ended, from 1; 0 if there was none.
    last: u64,
}

impl Replay {
    pub(crate) fn new(spec: &ReplaySpec, tasks: usize) -> Self {
        Self { spec: spec.clone(), tasks: vec![Driven::default(); tasks], episodes: 0 }
    }

    /// Whether a task that was driven may be driven again, and whether there is one that never was.
    fn stock(&self) -> (bool, bool) {
        let scored = self.tasks.iter().filter(|t| t.score.is_some()).count();
        let enough = scored > 0 && scored as f64 >= self.spec.seen * self.tasks.len() as f64;
        (enough, scored < self.tasks.len())
    }

    pub(crate) fn draw(&self, stream: &mut Stream) -> usize {
        let again = stream.unit() < self.spec.replay;
        let weights = match self.stock() {
            (true, is_new) if again || !is_new => self.priorities(),
            _ => self.fresh(),
        };
        pick(weights.iter().copied(), stream)
    }

    /// All tasks alike that have no score.
    fn fresh(&self) -> Vec<f64> {
        self.tasks.iter().map(|t| f64::from(u8::from(t.score.is_none()))).collect()
    }

    /// The chances of tasks that have a score (equations 1 to 3 of the paper).
    fn priorities(&self) -> Vec<f64> {
        let scored: Vec<usize> = (0..self.tasks.len()).filter(|k| self.tasks[*k].score.is_some()).collect();
        let mut by_score = scored.clone();
        let score = |k: usize| self.tasks[k].score.unwrap_or(0.0);
        by_score.sort_by(|a, b| score(*b).total_cmp(&score(*a)).then(a.cmp(b)));
        let mut chances = vec![0.0; self.tasks.len()];
        let weight = |rank: usize| pow(1.0 / (rank + 1) as f64, 1.0 / self.spec.temperature);
        let sum: f64 = (0..by_score.len()).map(weight).sum();
        for (rank, k) in by_score.iter().enumerate() {
            chances[*k] = (1.0 - self.spec.staleness) * weight(rank) / sum;
        }
        let age = |k: usize| (self.episodes - self.tasks[k].last) as f64;
        let ages: f64 = scored.iter().map(|k| age(*k)).sum();
        for k in &scored {
            let stale = if ages > 0.0 { age(*k) / ages } else { 1.0 / scored.len() as f64 };
            chances[*k] += self.spec.staleness * stale;
        }
        chances
    }

    pub(crate) fn report(&mut self, ending: &Ending) {
        self.episodes += 1;
        self.tasks[ending.task].last = self.episodes;
    }

    pub(crate) fn score(&mut self, task: usize, score: f64) {
        let own = &mut self.tasks[task].score;
        *own = Some(own.map_or(score, |old| self.spec.keep * old + (1.0 - self.spec.keep) * score));
    }

    pub(crate) fn chances(&self) -> Vec<f64> {
        let fresh = self.fresh();
        let new: f64 = fresh.iter().sum();
        let again = match self.stock() {
            (true, true) => self.spec.replay,
            (true, false) => 1.0,
            (false, _) => return fresh.iter().map(|f| f / new).collect(),
        };
        let mix =
            |(again_chance, fresh): (f64, f64)| again * again_chance + (1.0 - again) * fresh / new.max(1.0);
        self.priorities().into_iter().zip(fresh).map(mix).collect()
    }

    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.spec == other.spec
            && self.tasks.len() == other.tasks.len()
            && self.episodes <= MOST_DRAWN
            && self.tasks.iter().all(|t| t.last <= self.episodes)
    }
}
