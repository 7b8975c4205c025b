//! Causes of rollover and immobilisation, determined from the last seconds of a trial.
//!
//! The outcome states that a trial failed; the cause states the reason, and the evidence the measured values. It
//! follows from simple rules on loads, slip, sinkage, attitude, terrain and nearby obstacles, and affects no score.

mod moment;
mod rollover;
mod stuck;

use std::fmt;

use serde::{Deserialize, Serialize};
use vb_world::{Heightfield, geometry};

use crate::Outcome;

pub use moment::{Moment, WheelMoment};

/// The standard acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;
/// The distance to an obstacle's outline within which it is touched, at scale 1, m.
const TOUCH: f64 = 0.3;

/// Declares the causes together with their list, their names in files and what people call them.
macro_rules! causes {
    ($($(#[$about:meta])+ $variant:ident = $name:literal, $title:literal;)+) => {
        /// The cause of a failure.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Cause {
            $($(#[$about])+ #[serde(rename = $name)] $variant,)+
        }

        impl Cause {
            /// All causes in the order of tables.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The name of the cause in files.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }

            /// The name of the cause in tables and sentences.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self {
                    $(Self::$variant => $title),+
                }
            }
        }
    };
}

causes! {
    /// The vehicle tipped over at or on an obstacle.
    RolloverAtObstacle = "rollover_at_obstacle", "tipped over at an obstacle";
    /// The vehicle tipped over an edge beyond which the terrain drops.
    RolloverOverEdge = "rollover_over_edge", "tipped over an edge";
    /// The vehicle tipped over in a turn or jump at excessive speed.
    RolloverAtSpeed = "rollover_at_speed", "tipped over at speed";
    /// The vehicle tipped over its front or rear.
    RolloverEndOverEnd = "rollover_end_over_end", "tipped end over end";
    /// The vehicle tipped over sideways on too steep a side slope.
    RolloverOnSideSlope = "rollover_on_side_slope", "tipped over on a side slope";
    /// The planner commanded no throttle.
    NotDriven = "not_driven", "not driven";
    /// The hull bears the vehicle, and the wheels lack load.
    HighCentred = "high_centred", "high-centred";
    /// An obstacle blocks the vehicle.
    AgainstObstacle = "against_obstacle", "against an obstacle";
    /// Two diagonally opposite wheels are unloaded and spin, while the loaded wheels don't drive.
    CrossAxled = "cross_axled", "spinning across a diagonal";
    /// Wheels that are not diagonally opposite are off the ground and spin.
    WheelsOffGround = "wheels_off_ground", "wheels off the ground";
    /// A steep rise blocks a leading wheel.
    AgainstWall = "against_wall", "against a wall";
    /// The wheels spin on soil, or have sunk into it.
    SpinningOnSoil = "spinning_on_soil", "spinning on soil";
    /// The terrain ahead is too steep for the traction or the engine.
    TooSteep = "too_steep", "too steep";
    /// The vehicle slides down the slope on which it drives.
    Sliding = "sliding", "sliding";
    /// Wheels spin on firm ground, and the others don't move the vehicle.
    SpinningOnFirm = "spinning_on_firm", "spinning on firm ground";
    /// None of the above.
    Other = "other", "other";
}

impl Cause {
    /// The outcome of which it is a cause: a rollover, or getting stuck.
    #[must_use]
    pub fn outcome(self) -> Outcome {
        match self {
            Self::RolloverAtObstacle
            | Self::RolloverOverEdge
            | Self::RolloverAtSpeed
            | Self::RolloverEndOverEnd
            | Self::RolloverOnSideSlope => Outcome::Rollover,
            Self::NotDriven
            | Self::HighCentred
            | Self::AgainstObstacle
            | Self::CrossAxled
            | Self::WheelsOffGround
            | Self::AgainstWall
            | Self::SpinningOnSoil
            | Self::TooSteep
            | Self::Sliding
            | Self::SpinningOnFirm
            | Self::Other => Outcome::Stuck,
        }
    }

    /// The causes with how often each was one, which `count` says: the most frequent first, those alike in the order of
    /// tables, and without those that were none.
    #[must_use]
    pub fn by_frequency(count: impl Fn(Self) -> u64) -> Vec<(Self, u64)> {
        let mut found: Vec<(Self, u64)> =
            Self::ALL.iter().map(|cause| (*cause, count(*cause))).filter(|(_, n)| *n > 0).collect();
        found.sort_by_key(|(cause, n)| (std::cmp::Reverse(*n), *cause));
        found
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A cause and the measured values on which it is based.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// The cause.
    pub cause: Cause,
    /// The evidence as text, e.g. "the hull bears 43 % of the weight"; empty if there is none.
    pub evidence: String,
}

impl Diagnosis {
    fn new(cause: Cause, evidence: impl Into<String>) -> Self {
        Self { cause, evidence: evidence.into() }
    }
}

/// What a judgement needs to know of the vehicle, as simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The mass, kg.
    pub mass: f64,
    /// How far what collides reaches in front of the reference point, m.
    pub front: f64,
    /// How far it reaches behind it, m.
    pub rear: f64,
    /// Half of its width, m.
    pub half_width: f64,
    /// The centres of the wheels in body axes at the design position, front to back, left before right, m.
    pub wheels: Vec<[f64; 3]>,
    /// The radius of the wheels, m.
    pub wheel_radius: f64,
    /// The size of the world over that of the full-size one.
    pub scale: f64,
}

/// What is around the vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    /// The outlines of the obstacles, seen from above, convex and counter-clockwise, m.
    pub obstacles: &'a [Vec<[f64; 2]>],
    /// The ground as it was before the vehicle came, without ruts.
    pub ground: &'a Heightfield,
}

/// Whether two convex outlines meet.
fn meet(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    // Most obstacles are far away.
    let are_apart = |k: usize| {
        let extent = |p: &[[f64; 2]]| {
            p.iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[k]), high.max(p[k])))
        };
        let (a, b) = (extent(a), extent(b));
        a.1 < b.0 || b.1 < a.0
    };
    if are_apart(0) || are_apart(1) {
        return false;
    }
    let edges = |p: &[[f64; 2]]| -> Vec<([f64; 2], [f64; 2])> {
        (0..p.len()).map(|k| (p[k], p[(k + 1) % p.len()])).collect()
    };
    edges(a).iter().any(|(p, q)| geometry::segment_to_polygon(*p, *q, b) == 0.0)
        || b.first().is_some_and(|p| geometry::contains(&geometry::convex_hull(a), *p))
}

/// The cause of a failure, by the moments of its last seconds in the order of time. `rolled_over` says which failure it is.
#[must_use]
pub fn diagnose(moments: &[Moment], body: &Body, site: Site<'_>, rolled_over: bool) -> Diagnosis {
    if rolled_over { rollover::diagnose(moments, body, site) } else { stuck::diagnose(moments, body, site) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_frequent_cause_is_first_and_one_that_was_none_is_left_out() {
        let count = |cause| match cause {
            Cause::Other | Cause::HighCentred => 2,
            Cause::TooSteep => 5,
            _ => 0,
        };
        let expected = [(Cause::TooSteep, 5), (Cause::HighCentred, 2), (Cause::Other, 2)];
        assert_eq!(Cause::by_frequency(count), expected);
    }

    #[test]
    fn names_are_those_of_files() {
        for cause in Cause::ALL {
            let text = serde_json::to_string(&cause).unwrap();
            assert_eq!(text, format!("\"{cause}\""));
        }
    }

    #[test]
    fn every_cause_is_explained_in_the_docs() {
        let text = include_str!("../../../../../docs/scoring.md");
        for cause in Cause::ALL {
            assert!(
                text.contains(&format!("| `{cause}` | {} |", cause.title())),
                "docs/scoring.md lacks {cause}"
            );
        }
    }

    #[test]
    fn outlines_meet_where_they_overlap_or_one_holds_the_other() {
        let square = |x: f64, half: f64| {
            vec![[x - half, -half], [x + half, -half], [x + half, half], [x - half, half]]
        };
        assert!(meet(&square(0.0, 1.0), &square(1.9, 1.0)));
        assert!(!meet(&square(0.0, 1.0), &square(2.1, 1.0)));
        assert!(meet(&square(0.0, 1.0), &square(0.1, 0.2)) && meet(&square(0.1, 0.2), &square(0.0, 1.0)));
    }
}
