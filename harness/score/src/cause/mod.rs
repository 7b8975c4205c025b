//! Why a vehicle rolled over or got stuck, judged by its last seconds.
//!
//! The outcome says that a trial failed; the cause says what the vehicle was up against. It is a judgement by simple rules
//! on loads, slip, sinkage, attitude and what stands near, and it changes no score.

mod rollover;
mod stuck;

use std::fmt;

use serde::{Deserialize, Serialize};
use vb_world::geometry;

/// The standard acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;
/// The distance to an obstacle's outline within which it is touched, at scale 1, m.
const TOUCH: f64 = 0.3;

/// The cause of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// It tipped over while it stood at an obstacle, or climbed it.
    RolloverAtObstacle,
    /// It tipped over in a turn or a leap that was too fast.
    RolloverAtSpeed,
    /// It tipped over sideways on ground that was too steep.
    RolloverOnSideSlope,
    /// It tipped over its front or rear.
    RolloverEndOverEnd,
    /// The driver gave no throttle.
    NotDriven,
    /// The hull carries the vehicle, and the wheels lack load.
    HighCentred,
    /// An obstacle stands in the way.
    AgainstObstacle,
    /// Wheels hang in the air and spin, mostly those of a diagonal.
    WheelsOffGround,
    /// The wheels spin or are sunk in soil.
    SpinningOnSoil,
    /// The ground ahead is so steep that the wheels slip or the engine doesn't suffice.
    TooSteep,
    /// None of these.
    Other,
}

impl Cause {
    /// All causes in the order of tables.
    pub const ALL: [Self; 11] = [
        Self::RolloverAtObstacle,
        Self::RolloverAtSpeed,
        Self::RolloverOnSideSlope,
        Self::RolloverEndOverEnd,
        Self::NotDriven,
        Self::HighCentred,
        Self::AgainstObstacle,
        Self::WheelsOffGround,
        Self::SpinningOnSoil,
        Self::TooSteep,
        Self::Other,
    ];

    /// The name of the cause in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RolloverAtObstacle => "rollover_at_obstacle",
            Self::RolloverAtSpeed => "rollover_at_speed",
            Self::RolloverOnSideSlope => "rollover_on_side_slope",
            Self::RolloverEndOverEnd => "rollover_end_over_end",
            Self::NotDriven => "not_driven",
            Self::HighCentred => "high_centred",
            Self::AgainstObstacle => "against_obstacle",
            Self::WheelsOffGround => "wheels_off_ground",
            Self::SpinningOnSoil => "spinning_on_soil",
            Self::TooSteep => "too_steep",
            Self::Other => "other",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What a judgement needs to know of the vehicle, as simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// The mass, kg.
    pub mass: f64,
    /// The length, m.
    pub length: f64,
    /// The width, m.
    pub width: f64,
    /// The radius of the wheels, m.
    pub wheel_radius: f64,
    /// The size of the world over that of the full-size one.
    pub scale: f64,
}

/// The state of a wheel at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelMoment {
    /// The angular velocity about the axle, rad/s, positive when rolling forward.
    pub spin: f64,
    /// The normal force of ground and obstacles, N.
    pub load: f64,
    /// The depth in soil, m.
    pub sinkage: f64,
}

/// The state of a vehicle at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The time, s.
    pub time: f64,
    /// The position of the reference point in the world, m.
    pub position: [f64; 3],
    /// The roll, rad, positive with the right side down.
    pub roll: f64,
    /// The pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// The heading, rad.
    pub yaw: f64,
    /// The velocity in body axes, m/s.
    pub velocity: [f64; 3],
    /// The angular velocity about the body's upward axis, rad/s.
    pub yaw_rate: f64,
    /// The throttle, in [0, 1].
    pub throttle: f64,
    /// Whether the reverse gear is in.
    pub reverse: bool,
    /// The wheels, front to back, left before right.
    pub wheels: Vec<WheelMoment>,
}

impl Moment {
    /// The angle between the vehicle's upward axis and the vertical, rad.
    fn tilt(&self) -> f64 {
        vb_math::acos((vb_math::cos(self.pitch) * vb_math::cos(self.roll)).clamp(-1.0, 1.0))
    }

    /// The corners of the vehicle, seen from above and grown by a margin (m) to the front, the rear and the sides, in the
    /// world.
    fn outline(&self, body: &Body, [front, rear, side]: [f64; 3]) -> Vec<[f64; 2]> {
        let (sin, cos) = vb_math::sin_cos(self.yaw);
        let (l, w) = (0.5 * body.length, 0.5 * body.width + side);
        [[l + front, w], [-l - rear, w], [-l - rear, -w], [l + front, -w]]
            .map(|[x, y]| [self.position[0] + cos * x - sin * y, self.position[1] + sin * x + cos * y])
            .to_vec()
    }
}

/// Whether two convex outlines meet.
fn meet(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    let edges = |p: &[[f64; 2]]| -> Vec<([f64; 2], [f64; 2])> {
        (0..p.len()).map(|k| (p[k], p[(k + 1) % p.len()])).collect()
    };
    edges(a).iter().any(|(p, q)| geometry::segment_to_polygon(*p, *q, b) == 0.0)
        || b.first().is_some_and(|p| geometry::contains(&geometry::convex_hull(a), *p))
}

/// The cause of a failure, by the moments of its last seconds in the order of time. `obstacles` are the outlines of those in
/// the world, seen from above, convex and counter-clockwise (m). `rolled_over` says which failure it is.
#[must_use]
pub fn cause(moments: &[Moment], body: &Body, obstacles: &[Vec<[f64; 2]>], rolled_over: bool) -> Cause {
    if rolled_over {
        rollover::cause(moments, body, obstacles)
    } else {
        stuck::cause(moments, body, obstacles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files() {
        for cause in Cause::ALL {
            let text = serde_json::to_string(&cause).unwrap();
            assert_eq!(text, format!("\"{cause}\""));
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
