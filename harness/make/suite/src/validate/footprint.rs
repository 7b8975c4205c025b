//! The vehicle as checks see it: a rectangle on the ground.

use vb_math::{angle::degrees, atan, hypot, sin_cos};
use vb_world::{Heightfield, Pose2};

/// A vehicle seen from above: a rectangle about its reference point, in lengths of the full-size world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// The length of what collides, m.
    pub length: f64,
    /// The width of what collides, m.
    pub width: f64,
}

impl Vehicle {
    /// Its corners at a pose, counter-clockwise, m.
    pub(super) fn outline(&self, at: Pose2) -> [[f64; 2]; 4] {
        let (l, w) = (0.5 * self.length, 0.5 * self.width);
        [[l, w], [-l, w], [-l, -w], [l, -w]].map(|p| place(at, p))
    }

    /// Tilt of the plane that fits the ground under it best (least squares over 5 × 5 points), degrees.
    pub(super) fn tilt(&self, ground: &Heightfield, at: Pose2) -> f64 {
        let steps = [-0.5, -0.25, 0.0, 0.25, 0.5];
        let (mut rise, mut square) = ([0.0; 2], 0.0);
        for u in steps {
            for v in steps {
                let [x, y] = place(at, [u * self.length, v * self.width]);
                let z = ground.height(x, y);
                rise = [rise[0] + z * u, rise[1] + z * v];
                square += u * u;
            }
        }
        // The points lie evenly about the pose, so that the two slopes of the fit do not depend on each other.
        let slope = [rise[0] / (square * self.length), rise[1] / (square * self.width)];
        degrees(atan(hypot(slope[0], slope[1])))
    }
}

/// A point of the vehicle's frame in the world.
fn place(at: Pose2, p: [f64; 2]) -> [f64; 2] {
    let (s, c) = sin_cos(at.yaw);
    [at.x + p[0] * c - p[1] * s, at.y + p[0] * s + p[1] * c]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: Vehicle = Vehicle { length: 4.6, width: 2.1 };

    #[test]
    fn the_tilt_is_that_of_the_ground_whatever_the_heading() {
        // A plane that rises by 0.3 a metre eastwards and by 0.4 northwards: 0.5 in all, 26.565°.
        let heights = (0..41 * 41).map(|i| 0.3 * f64::from(i % 41) + 0.4 * f64::from(i / 41)).collect();
        let plane = Heightfield::new(41, 41, 1.0, heights);
        for yaw in [0.0, 0.7, 2.0, -1.5] {
            let tilt = CAR.tilt(&plane, Pose2 { x: 1.3, y: -2.1, yaw });
            assert!((tilt - 26.565).abs() < 1e-3, "{tilt}");
        }
    }

    #[test]
    fn ground_that_is_rough_but_level_does_not_tilt() {
        let heights = (0..41 * 41).map(|i| f64::from((i % 41 - 20_i32).abs() % 2)).collect();
        let ridges = Heightfield::new(41, 41, 1.0, heights);
        assert!(CAR.tilt(&ridges, Pose2 { x: 0.0, y: 0.0, yaw: 0.0 }) < 1e-9);
    }

    #[test]
    fn the_outline_turns_with_the_heading() {
        let v = Vehicle { length: 4.0, width: 2.0 };
        let o = v.outline(Pose2 { x: 10.0, y: 0.0, yaw: std::f64::consts::FRAC_PI_2 });
        let expected = [[9.0, 2.0], [9.0, -2.0], [11.0, -2.0], [11.0, 2.0]];
        for (p, e) in o.iter().zip(expected) {
            assert!(hypot(p[0] - e[0], p[1] - e[1]) < 1e-12, "{o:?}");
        }
    }
}
