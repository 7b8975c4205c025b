//! Crops of the elevation map that rotate with the vehicle.

use crate::{Map, Pose2, math};

/// The shape of a crop, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The number of samples along the body's x axis, from the rear to the front.
    pub rows: usize,
    /// The number of samples along the body's y axis, from the right to the left.
    pub cols: usize,
    /// The distance between neighbouring samples, m.
    pub resolution: f64,
    /// The distance from the pose to the centre of the window, m, positive ahead.
    pub ahead: f64,
}

impl Window {
    /// The position of sample (row, col) in body axes: metres forward and metres to the left. Row 0 is the rearmost and
    /// column 0 the rightmost, so both count along the axes.
    #[must_use]
    pub fn body_position(&self, row: usize, col: usize) -> (f64, f64) {
        let centred = |i: usize, n: usize| (i as f64 - 0.5 * (n as f64 - 1.0)) * self.resolution;
        (self.ahead + centred(row, self.rows), centred(col, self.cols))
    }
}

/// The terrain within a window. Each list is row-major and has `rows * cols` samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crop {
    /// The heights in the world frame, m.
    pub height: Vec<f32>,
    /// The slopes along the body's x axis, m/m: positive if the terrain rises ahead.
    pub slope_forward: Vec<f32>,
    /// The slopes along the body's y axis, m/m: positive if the terrain rises to the left.
    pub slope_left: Vec<f32>,
}

impl Map<f32> {
    /// Returns the terrain in a window around a pose (world frame), triangulated as in [`Map::ground`]. Outside the
    /// map, the planes of its edge cells are extended.
    ///
    /// # Panics
    /// Panics if the map has fewer than 2 × 2 samples.
    #[must_use]
    pub fn crop(&self, pose: Pose2, window: &Window) -> Crop {
        let (sin, cos) = math::sin_cos(pose.yaw);
        let n = window.rows * window.cols;
        let mut crop = Crop {
            height: Vec::with_capacity(n),
            slope_forward: Vec::with_capacity(n),
            slope_left: Vec::with_capacity(n),
        };
        for row in 0..window.rows {
            for col in 0..window.cols {
                let (forward, left) = window.body_position(row, col);
                let g = self.ground(pose.x + cos * forward - sin * left, pose.y + sin * forward + cos * left);
                crop.height.push(g.z as f32);
                crop.slope_forward.push((cos * g.dzdx + sin * g.dzdy) as f32);
                crop.slope_left.push((cos * g.dzdy - sin * g.dzdx) as f32);
            }
        }
        crop
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridFrame;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

    /// z = 0.5 x − 0.25 y on a 9 × 9 grid of 1 m, centred.
    fn plane() -> Map<f32> {
        let frame = GridFrame { rows: 9, cols: 9, resolution: 1.0, origin_x: -4.0, origin_y: -4.0 };
        let z = |i: i32| 0.5 * (i % 9 - 4) as f32 - 0.25 * (i / 9 - 4) as f32;
        Map { frame, data: (0..81).map(z).collect() }
    }

    #[test]
    fn rows_count_forward_and_columns_to_the_left() {
        let w = Window { rows: 3, cols: 2, resolution: 0.5, ahead: 2.0 };
        assert_eq!(w.body_position(0, 0), (1.5, -0.25));
        assert_eq!(w.body_position(2, 1), (2.5, 0.25));
        // Facing north at the origin: forward is y, left is −x.
        let crop = plane().crop(Pose2 { x: 0.0, y: 0.0, yaw: FRAC_PI_2 }, &w);
        assert!((crop.height[0] - (0.5 * 0.25 - 0.25 * 1.5)).abs() < 1e-6);
        assert!((crop.height[5] - (0.5 * -0.25 - 0.25 * 2.5)).abs() < 1e-6);
    }

    #[test]
    fn slopes_turn_with_the_body() {
        let w = Window { rows: 2, cols: 2, resolution: 1.0, ahead: 0.0 };
        let crop = plane().crop(Pose2 { x: 0.3, y: -0.6, yaw: FRAC_PI_6 }, &w);
        // The gradient (0.5, −0.25) in axes turned by 30°.
        let (c, s) = (3f32.sqrt() / 2.0, 0.5);
        for i in 0..4 {
            assert!((crop.slope_forward[i] - (c * 0.5 - s * 0.25)).abs() < 1e-6);
            assert!((crop.slope_left[i] - (-s * 0.5 - c * 0.25)).abs() < 1e-6);
        }
    }
}
