//! How a vehicle stands on the ground, and whether its hull bears a part of it.
//!
//! A wheel under which the ground falls away leaves its load to the hull as soon as that touches, and then nothing drives the vehicle
//! on. The networks see the ground as a coarse patch; here the hull is held against the very surface.

use vb_sdk::{HeightMap, Point2, Vehicle};

/// What a place does to a vehicle that stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stance {
    /// The fraction of the weight that the hull bears, in [0, 1].
    pub(crate) hull: f32,
    /// By how much the hull tilts the vehicle out of the plane through its wheels: the sum for roll and pitch, as slopes.
    pub(crate) tilt: f32,
}

/// A point at which the ground can bear the vehicle.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// Ahead of the reference point, m.
    forward: f32,
    /// To the left of it, m.
    left: f32,
    /// Above the wheels' lowest points, m.
    above: f32,
}

/// Where a vehicle can touch the ground.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    wheels: [Support; WHEELS],
    hull: [Support; HULL],
    /// Half the wheelbase and half the track, m.
    half: [f32; 2],
    /// By how much the weight presses tyres and springs in, m.
    sag: f32,
    radius: f32,
}

/// The outer wheels.
const WHEELS: usize = 4;
/// Points of the belly, and of the lower edges of both ends.
const HULL: usize = 12 + 6;
/// What suspension and tyres give under the weight, in wheelbases: the HMMWV's springs and tyres of 150 kN/m together
/// (`tasks/vehicles/hmmwv.yaml`), rounded. That of other vehicles isn't told.
const SAG: f32 = 0.017;
/// The hull is harder than a wheel by this factor.
const HARD: f32 = 2.7;
/// The belly in half wheelbases and half tracks. The hull tapers towards its ends, whose lower edges are higher by about the
/// clearance: the HMMWV's by 0.38 and 0.44 m (`tasks/vehicles/hmmwv.yaml`).
const BELLY: ([f32; 4], [f32; 3]) = ([0.68, 0.24, -0.2, -0.65], [0.6, 0.0, -0.6]);
const ENDS: (f32, f32) = (0.94, 1.95);
/// Points of a wheel's circumference, in radii ahead of its centre.
const RIM: [f32; 7] = [-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75];
/// Half the width of a tyre, in half tracks.
const TYRE: f32 = 0.13;
/// Newton's steps, and the part of each that is taken: supports come into and out of touch on the way.
const STEPS: usize = 8;
const STEP: f32 = 0.8;
/// What a support that doesn't touch is counted for, so that the equations have a solution however few do.
const FAINT: f32 = 0.003;

impl Shape {
    /// The shape of a vehicle, as far as a planner is told.
    pub(crate) fn of(vehicle: &Vehicle) -> Self {
        let half = [0.5 * vehicle.wheelbase as f32, 0.5 * vehicle.track as f32];
        let point = |along: f32, across: f32, above: f32| Support {
            forward: along * half[0],
            left: across * half[1],
            above,
        };
        let clearance = vehicle.ground_clearance as f32;
        let end = ENDS.0 * 0.5 * vehicle.length as f32 / half[0];
        let (along, across) = BELLY;
        let hull = std::array::from_fn(|i| match i.checked_sub(along.len() * across.len()) {
            None => point(along[i / across.len()], across[i % across.len()], clearance),
            Some(i) => {
                point(if i < across.len() { end } else { -end }, across[i % across.len()], ENDS.1 * clearance)
            }
        });
        Self {
            wheels: [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(u, v)| point(u, v, 0.0)),
            hull,
            half,
            sag: SAG * vehicle.wheelbase as f32,
            radius: vehicle.wheel_radius as f32,
        }
    }

    /// How the vehicle stands at rest at a place, looking in a direction (cosine and sine).
    pub(crate) fn stand(&self, ground: &HeightMap, at: Point2, [cos, sin]: [f32; 2]) -> Stance {
        let height = |forward: f32, left: f32| {
            let x = at.x as f32 + cos * forward - sin * left;
            let y = at.y as f32 + sin * forward + cos * left;
            surface(ground, x, y)
        };
        // The lowest that a wheel comes to is where its circumference meets the ground first.
        let wheels = self.wheels.map(|w| {
            let touch = |part: f32| {
                let up = self.radius * ((1.0 - part * part).sqrt() - 1.0);
                let at =
                    |side: f32| height(w.forward + part * self.radius, w.left + side * TYRE * self.half[1]);
                at(-1.0).max(at(1.0)) + up
            };
            RIM.into_iter().map(touch).fold(f32::NEG_INFINITY, f32::max)
        });
        let [a, b] = self.half;
        let [fl, fr, rl, rr] = wheels;
        let plane =
            [0.25 * (fl + fr + rl + rr), 0.25 * (fl + fr - rl - rr) / a, 0.25 * (fl + rl - fr - rr) / b];
        let hull = self.hull.map(|h| height(h.forward, h.left) - h.above);
        let over = |p: &[f32; 3], s: &Support, z: f32| z - (p[0] + p[1] * s.forward + p[2] * s.left);
        // Where the hull is clear of the ground by more than it can sink, the wheels bear everything. On two of them across a
        // diagonal there is no rest, and nothing to solve.
        if self.hull.iter().zip(hull).all(|(s, z)| over(&plane, s, z) < -self.sag) {
            return Stance::default();
        }
        // Balance of weight and moments. Forces are in quarters of the weight.
        let mut pose = plane;
        let mut borne = 0.0;
        for _ in 0..STEPS {
            let (mut sums, mut m) = ([-(WHEELS as f32), 0.0, 0.0], [0.0; 6]);
            borne = 0.0;
            let supports = self.wheels.iter().zip(wheels).map(|s| (s, 1.0 / self.sag, 1.0));
            let hull = self.hull.iter().zip(hull).map(|s| (s, HARD / self.sag, 0.0));
            for ((s, z), stiffness, preload) in supports.chain(hull) {
                let force = (stiffness * over(&pose, s, z) + preload).max(0.0);
                let k = if force > 0.0 { stiffness } else { FAINT * stiffness };
                borne += if preload == 0.0 { force } else { 0.0 };
                let (u, v) = (s.forward, s.left);
                for (sum, arm) in sums.iter_mut().zip([1.0, u, v]) {
                    *sum += force * arm;
                }
                for (m, product) in m.iter_mut().zip([1.0, u, v, u * u, u * v, v * v]) {
                    *m += k * product;
                }
            }
            let moves = solve(m, sums);
            pose.iter_mut().zip(moves).for_each(|(p, by)| *p += STEP * by);
        }
        Stance {
            hull: (borne / WHEELS as f32).min(1.0),
            tilt: (pose[1] - plane[1]).abs() + (pose[2] - plane[2]).abs(),
        }
    }
}

/// Solves three equations with the symmetric matrix [[m0, m1, m2], [m1, m3, m4], [m2, m4, m5]] by Cramer's rule.
fn solve([m0, m1, m2, m3, m4, m5]: [f32; 6], [r0, r1, r2]: [f32; 3]) -> [f32; 3] {
    let (c0, c1, c2) = (m3 * m5 - m4 * m4, m2 * m4 - m1 * m5, m1 * m4 - m2 * m3);
    let (c4, c5, c8) = (m0 * m5 - m2 * m2, m1 * m2 - m0 * m4, m0 * m3 - m1 * m1);
    let per = 1.0 / (m0 * c0 + m1 * c1 + m2 * c2);
    [
        per * (c0 * r0 + c1 * r1 + c2 * r2),
        per * (c1 * r0 + c4 * r1 + c5 * r2),
        per * (c2 * r0 + c5 * r1 + c8 * r2),
    ]
}

/// The height of the ground as [`HeightMap::ground`] has it, in single precision; beyond the edge, that of the edge.
fn surface(map: &HeightMap, x: f32, y: f32) -> f32 {
    let frame = &map.frame;
    let per = (1.0 / frame.resolution) as f32;
    let (rows, cols) = (frame.rows as usize, frame.cols as usize);
    let c = ((x - frame.origin_x as f32) * per).clamp(0.0, (cols - 1) as f32);
    let r = ((y - frame.origin_y as f32) * per).clamp(0.0, (rows - 1) as f32);
    let (col, row) = ((c as usize).min(cols - 2), (r as usize).min(rows - 2));
    let (u, v) = (c - col as f32, r - row as f32);
    let cell = &map.data[row * cols + col..][..cols + 2];
    let [sw, se, nw, ne] = [cell[0], cell[1], cell[cols], cell[cols + 1]];
    let (gu, gv) = if v >= u { (ne - nw, nw - sw) } else { (se - sw, ne - se) };
    sw + gu * u + gv * v
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{GridFrame, Map};

    /// 20 x 20 m of these heights, with a node every 0.25 m.
    fn ground(height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let frame = GridFrame { rows: 81, cols: 81, resolution: 0.25, origin_x: -10.0, origin_y: -10.0 };
        let data = (0..81 * 81)
            .map(|k| {
                let (x, y) = frame.position(k / 81, k % 81);
                height(x, y) as f32
            })
            .collect();
        Map { frame, data }
    }

    fn hmmwv() -> Shape {
        Shape::of(&Vehicle {
            wheelbase: 3.302,
            track: 1.819,
            length: 4.67,
            wheel_radius: 0.467,
            ground_clearance: 0.41,
            ..Vehicle::default()
        })
    }

    const HERE: Point2 = Point2 { x: 0.0, y: 0.0 };
    const EAST: [f32; 2] = [1.0, 0.0];

    #[test]
    fn on_a_plane_the_wheels_bear_everything() {
        for (along, across) in [(0.0, 0.0), (0.3, 0.0), (-0.1, 0.2)] {
            let stance = hmmwv().stand(&ground(|x, y| along * x + across * y), HERE, EAST);
            assert_eq!(stance, Stance::default(), "{along}, {across}");
        }
    }

    #[test]
    fn the_hull_bears_a_vehicle_on_a_ridge_that_is_higher_than_its_clearance() {
        let ridge = |top: f64| ground(move |x, _| if x.abs() < 0.6 { top } else { 0.0 });
        assert_eq!(hmmwv().stand(&ridge(0.3), HERE, EAST).hull, 0.0);
        let hung = hmmwv().stand(&ridge(0.6), HERE, EAST);
        assert!(hung.hull > 0.5, "{hung:?}");
        // Along the ridge, which is narrower than the track, the belly stands on it as well.
        let along = hmmwv().stand(&ridge(0.6), HERE, [0.0, 1.0]);
        assert!(along.hull > 0.5, "{along:?}");
    }

    /// A vehicle that a bump below its left side lifts there rolls to the right; the mirror image does the same.
    #[test]
    fn a_bump_beside_the_middle_tilts_the_vehicle() {
        let bump = |side: f64| {
            ground(move |x, y| if x.abs() < 0.5 && (y * side - 0.5).abs() < 0.3 { 0.7 } else { 0.0 })
        };
        let [left, right] = [1.0, -1.0].map(|side| hmmwv().stand(&bump(side), HERE, EAST));
        assert!(left.tilt > 0.01 && left.hull > 0.1, "{left:?}");
        assert!((left.tilt - right.tilt).abs() < 0.02, "{left:?} {right:?}");
    }

    #[test]
    fn the_surface_is_the_ground_that_planners_are_told() {
        let map = ground(|x, y| 0.3 * x * y + (x - 0.4 * y).abs());
        for k in 0..200 {
            let (x, y) = (f64::from(k) * 0.09 - 9.0, f64::from(k * 7 % 200) * 0.09 - 9.0);
            assert!(
                (f64::from(surface(&map, x as f32, y as f32)) - map.ground(x, y).z).abs() < 1e-4,
                "{x} {y}"
            );
        }
    }
}
