//! Misclassification of terrain classes.

use serde::Deserialize;
use std::collections::BTreeMap;

/// The label of an obstacle in images, after the ten terrain classes.
pub(crate) const OBSTACLE: u8 = 10;
/// The label of what is unknown.
pub(crate) const UNKNOWN: u8 = 255;

/// The recognised class of a pixel or a map cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
#[repr(u8)]
pub enum Seen {
    Clay = 0,
    Concrete,
    Dirt,
    Grass,
    Gravel,
    Rock,
    Wood,
    Mud,
    Sand,
    Snow,
    Obstacle,
}

/// Confusion probabilities: for each class the classes it may be misclassified as. The remainder to 1 is the
/// probability of correct classification.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Confusions(pub BTreeMap<Seen, BTreeMap<Seen, f64>>);

/// The confusions of a recogniser, ready for many draws.
#[derive(Clone, Debug)]
pub(crate) struct Recogniser {
    /// For each label, other labels with the sums of the probabilities up to them.
    mistakes: [Vec<(f64, u8)>; OBSTACLE as usize + 1],
}

impl Recogniser {
    pub(crate) fn new(confusions: &Confusions) -> Self {
        let mut mistakes: [Vec<(f64, u8)>; OBSTACLE as usize + 1] = Default::default();
        for (truth, others) in &confusions.0 {
            let mut sum = 0.0;
            mistakes[*truth as usize] = others
                .iter()
                .map(|(seen, p)| {
                    sum += p;
                    (sum, *seen as u8)
                })
                .collect();
        }
        Self { mistakes }
    }

    /// The label that is recognised where `truth` is, by a uniform number in [0, 1).
    pub(crate) fn see(&self, truth: u8, u: f64) -> u8 {
        self.mistakes[usize::from(truth)].iter().find(|(sum, _)| u < *sum).map_or(truth, |(_, label)| *label)
    }
}
