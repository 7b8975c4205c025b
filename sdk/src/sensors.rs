//! Conversion of sensor measurements to points in the body frame.

use crate::{DepthImage, DepthInfo, LidarInfo, LidarScan, Mount, Vec3, math};

impl Mount {
    /// Transforms the point `v` from the sensor frame to the body frame, m.
    #[must_use]
    pub fn to_body(&self, v: Vec3) -> Vec3 {
        // Roll about x, then pitch about y, then yaw about z: rotations of a vector are in reverse order of the
        // attitude's.
        let (sin, cos) = math::sin_cos(self.roll);
        let (y, z) = (cos * v.y - sin * v.z, sin * v.y + cos * v.z);
        let (sin, cos) = math::sin_cos(self.pitch);
        let (x, z) = (cos * v.x + sin * z, cos * z - sin * v.x);
        let (sin, cos) = math::sin_cos(self.yaw);
        let (x, y) = (cos * x - sin * y, sin * x + cos * y);
        Vec3 { x: self.position.x + x, y: self.position.y + y, z: self.position.z + z }
    }
}

impl LidarInfo {
    /// The direction of a beam in the sensor frame, a unit vector.
    #[must_use]
    pub fn direction(&self, row: u32, col: u32) -> Vec3 {
        let steps = f64::from(self.rows.max(2) - 1);
        let elevation = self.lowest + (self.highest - self.lowest) * f64::from(row) / steps;
        let turn = (f64::from(col) + 0.5) / f64::from(self.cols.max(1));
        let azimuth = std::f64::consts::PI * (2.0 * turn - 1.0);
        let ((sin_a, cos_a), (sin_e, cos_e)) = (math::sin_cos(azimuth), math::sin_cos(elevation));
        Vec3 { x: cos_e * cos_a, y: cos_e * sin_a, z: sin_e }
    }

    /// The points of a scan, in the body frame at the time of each measurement, m: row, column, point. Beams without an
    /// echo are omitted.
    pub fn points(&self, scan: &LidarScan) -> impl Iterator<Item = (u32, u32, Vec3)> {
        places(self.rows, self.cols, &scan.ranges).map(|(row, col, range)| {
            let d = self.direction(row, col);
            (row, col, self.mount.to_body(Vec3 { x: range * d.x, y: range * d.y, z: range * d.z }))
        })
    }
}

impl DepthInfo {
    /// The point at depth 1 on the ray through a pixel's centre, in the sensor frame: x along the camera's axis, y to
    /// the left, z up.
    #[must_use]
    pub fn direction(&self, row: u32, col: u32) -> Vec3 {
        // Half the image width at depth 1, over half of its columns: the side of a pixel.
        let half = 0.5 * self.field_of_view;
        let side = 2.0 * math::tan(half) / f64::from(self.cols.max(1));
        let off = |i: u32, n: u32| (0.5 * f64::from(n) - (f64::from(i) + 0.5)) * side;
        Vec3 { x: 1.0, y: off(col, self.cols), z: off(row, self.rows) }
    }

    /// The points of an image, in the body frame, m: row, column, point. Pixels without a depth are omitted.
    pub fn points(&self, image: &DepthImage) -> impl Iterator<Item = (u32, u32, Vec3)> {
        places(self.rows, self.cols, &image.depths).map(|(row, col, depth)| {
            let d = self.direction(row, col);
            (row, col, self.mount.to_body(Vec3 { x: depth, y: depth * d.y, z: depth * d.z }))
        })
    }
}

/// Row, column and value of the positive values.
fn places(rows: u32, cols: u32, values: &[f32]) -> impl Iterator<Item = (u32, u32, f64)> {
    let all = (0..rows).flat_map(move |row| (0..cols).map(move |col| (row, col)));
    all.zip(values).filter(|(_, v)| **v > 0.0).map(|((row, col), v)| (row, col, f64::from(*v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn near(a: Vec3, b: [f64; 3]) -> bool {
        <[f64; 3]>::from(a).iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn a_mount_turns_roll_first_and_yaw_last() {
        let at = |roll, pitch, yaw| Mount { position: Vec3 { x: 1.0, y: 2.0, z: 3.0 }, roll, pitch, yaw };
        let forward = Vec3 { x: 1.0, y: 0.0, z: 0.0 };
        assert!(near(at(0.0, 0.0, FRAC_PI_2).to_body(forward), [1.0, 3.0, 3.0]), "to the left");
        assert!(near(at(0.0, FRAC_PI_2, 0.0).to_body(forward), [1.0, 2.0, 2.0]), "down");
        let left = Vec3 { x: 0.0, y: 1.0, z: 0.0 };
        assert!(near(at(FRAC_PI_2, 0.0, 0.0).to_body(left), [1.0, 2.0, 4.0]), "up");
        // Up by the roll, then forward by the pitch, then to the left by the yaw.
        assert!(near(at(FRAC_PI_2, FRAC_PI_2, FRAC_PI_2).to_body(left), [1.0, 3.0, 3.0]));
    }

    #[test]
    fn a_lidar_begins_behind_and_turns_to_the_left() {
        let lidar = LidarInfo { rows: 2, cols: 4, lowest: -0.5, highest: 0.0, ..LidarInfo::default() };
        // Row 1 is level; columns look at -135, -45, 45 and 135 degrees.
        let half = 0.5f64.sqrt();
        assert!(near(lidar.direction(1, 0), [-half, -half, 0.0]));
        assert!(near(lidar.direction(1, 2), [half, half, 0.0]));
        assert!((lidar.direction(0, 1).z - math::sin(-0.5)).abs() < 1e-12);
        let scan = LidarScan { time: 0.0, ranges: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0] };
        let points: Vec<_> = lidar.points(&scan).collect();
        assert!(points.len() == 1 && (points[0].0, points[0].1) == (1, 2));
        assert!(near(points[0].2, [2.0 * half, 2.0 * half, 0.0]));
    }

    #[test]
    fn a_pixel_of_the_edge_looks_along_the_edge_of_the_field_of_view() {
        let camera = DepthInfo { rows: 2, cols: 4, field_of_view: FRAC_PI_2, ..DepthInfo::default() };
        // At depth 1 the image is 2 m wide, so a pixel is 0.5 m, and the leftmost one's middle 0.75 m to the left.
        assert!(near(camera.direction(0, 0), [1.0, 0.75, 0.25]));
        assert!(near(camera.direction(1, 3), [1.0, -0.75, -0.25]));
        let image =
            DepthImage { depths: vec![4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..DepthImage::default() };
        let points: Vec<_> = camera.points(&image).collect();
        assert!(points.len() == 1 && near(points[0].2, [4.0, 3.0, 1.0]));
        assert!(DepthInfo { field_of_view: 0.5 * PI, ..DepthInfo::default() }.direction(0, 0).y.is_finite());
    }
}
