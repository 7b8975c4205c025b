//! Points and bodies in space.

use vb_vehicle::Point;

pub(crate) fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: Point, k: f64) -> Point {
    a.map(|x| k * x)
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn middle(points: &[Point]) -> Point {
    scale(points.iter().fold([0.0; 3], |a, p| add(a, *p)), 1.0 / points.len().max(1) as f64)
}

pub(crate) fn mirrored(a: Point) -> Point {
    [a[0], -a[1], a[2]]
}

/// A rotation as a matrix of rows.
pub(crate) type Matrix = [[f64; 3]; 3];

pub(crate) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(crate) fn turn(m: &Matrix, p: Point) -> Point {
    [dot(m[0], p), dot(m[1], p), dot(m[2], p)]
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

pub(crate) fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// The rotation of a unit quaternion, real part first.
pub(crate) fn quaternion(q: [f64; 4]) -> Matrix {
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / n);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// A rotation about fixed axes: roll about x, then pitch about y, then yaw about z, rad.
pub(crate) fn roll_pitch_yaw([r, p, y]: Point) -> Matrix {
    let ((sr, cr), (sp, cp), (sy, cy)) = (vb_math::sin_cos(r), vb_math::sin_cos(p), vb_math::sin_cos(y));
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// A rigid body or a sum of bodies: mass, kg, first moment, kg m, and inertia about the origin, kg m².
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mass {
    pub(crate) mass: f64,
    moment: Point,
    inertia: Matrix,
}

impl Mass {
    /// A body with its centre of mass and its inertia about it.
    pub(crate) fn body(mass: f64, com: Point, inertia: &Matrix) -> Self {
        let mut sum = *inertia;
        let square = dot(com, com);
        for i in 0..3 {
            for j in 0..3 {
                let diagonal = if i == j { square } else { 0.0 };
                sum[i][j] += mass * (diagonal - com[i] * com[j]);
            }
        }
        Self { mass, moment: scale(com, mass), inertia: sum }
    }

    pub(crate) fn point(mass: f64, at: Point) -> Self {
        Self::body(mass, at, &[[0.0; 3]; 3])
    }

    /// The same body in a frame in which its own frame lies at a place with these axes.
    pub(crate) fn moved(&self, at: Point, axes: &Matrix) -> Self {
        if self.mass == 0.0 {
            return Self::default();
        }
        let (com, inertia) = self.central();
        let turned = product(&product(axes, &inertia), &transposed(axes));
        Self::body(self.mass, add(at, turn(axes, com)), &turned)
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.mass += other.mass;
        self.moment = add(self.moment, other.moment);
        for i in 0..3 {
            for j in 0..3 {
                self.inertia[i][j] += other.inertia[i][j];
            }
        }
        self
    }

    /// The centre of mass and the inertia about it.
    pub(crate) fn central(&self) -> (Point, Matrix) {
        let com = scale(self.moment, 1.0 / self.mass);
        let mut inertia = self.inertia;
        let square = dot(com, com);
        for i in 0..3 {
            for j in 0..3 {
                let diagonal = if i == j { square } else { 0.0 };
                inertia[i][j] -= self.mass * (diagonal - com[i] * com[j]);
            }
        }
        (com, inertia)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_add_up_by_the_parallel_axis_theorem() {
        let ends = Mass::point(2.0, [1.0, 0.0, 0.0]).plus(&Mass::point(2.0, [-1.0, 0.0, 2.0]));
        let (com, inertia) = ends.central();
        assert_eq!(com, [0.0, 0.0, 1.0]);
        assert!((inertia[0][0] - 4.0).abs() < 1e-12 && (inertia[1][1] - 8.0).abs() < 1e-12);
        assert!((inertia[0][2] - 4.0).abs() < 1e-12, "{inertia:?}");
    }

    #[test]
    fn rotations_turn_as_their_conventions_say() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let [x, y, _] = turn(&quaternion([half, 0.0, 0.0, half]), [1.0, 0.0, 0.0]);
        assert!(x.abs() < 1e-12 && (y - 1.0).abs() < 1e-12);
        let yaw = roll_pitch_yaw([0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        let [x, y, _] = turn(&yaw, [1.0, 0.0, 0.0]);
        assert!(x.abs() < 1e-12 && (y - 1.0).abs() < 1e-12);
    }
}
