//! The static pose of a vehicle on the terrain, and the load on its hull.
//!
//! Where the terrain drops away under a wheel, its load moves to the hull on contact, and the wheel loses traction. The
//! networks use a coarse patch; this module checks the hull on the full elevation map.

use hybrid::{HEADINGS, heading};
use vb_sdk::{HeightMap, Vehicle};

/// The static load and tilt of a vehicle at a position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stance {
    /// The fraction of the weight on the hull, 0 to 1.
    pub(crate) hull: f32,
    /// Tilt of the vehicle out of the plane through its wheels by hull contact: sum of roll and pitch, as slopes.
    pub(crate) tilt: f32,
}

/// A point at which the terrain can support the vehicle.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// Ahead of the reference point, m.
    forward: f32,
    /// To the left of it, m.
    left: f32,
    /// Above the wheels' lowest points, m.
    above: f32,
}

/// The static pose of a vehicle at every node of an elevation map, for every heading of [`hybrid::heading`]. All nodes
/// share the same offsets of contact points, so that heights are read at fixed offsets.
pub(crate) struct Stances {
    supports: [Support; SUPPORTS],
    /// Half the wheelbase and half the track, m.
    half: [f32; 2],
    /// Static deflection of tyres and springs, m.
    sag: f32,
    /// Sampled heights, by heading.
    taps: Vec<Taps>,
    /// The heights, padded by those of the edge as far as the vehicle extends, and the padded row length.
    heights: Vec<f32>,
    width: usize,
    around: usize,
}

/// Sampled heights of one heading.
struct Taps {
    wheels: [[Tap; 2 * RIM.len()]; WHEELS],
    hull: [Tap; HULL],
}

/// A height between nodes: an added offset, the south-western node of its cell relative to the vehicle's node, and the
/// interpolation weights of that node and of the south-eastern, north-western and north-eastern nodes.
#[derive(Clone, Copy, Debug, Default)]
struct Tap {
    above: f32,
    node: usize,
    parts: [f32; 4],
}

/// The outer wheels.
const WHEELS: usize = 4;
/// Points of the belly, and of the lower edges of both ends.
const HULL: usize = 12 + 6;
const SUPPORTS: usize = WHEELS + HULL;
/// Static deflection of suspension and tyres, in wheelbases: the HMMWV's springs and tyres of 150 kN/m in series
/// (`tasks/vehicles/hmmwv.yaml`), rounded. Planners do not receive the value of other vehicles.
const SAG: f32 = 0.017;
/// Stiffness of the hull relative to a wheel.
const HARD: f32 = 2.7;
/// The belly in half wheelbases and half tracks. The hull tapers towards its ends, whose lower edges are higher by
/// about the ground clearance: the HMMWV's by 0.38 and 0.44 m (`tasks/vehicles/hmmwv.yaml`).
const BELLY: ([f32; 4], [f32; 3]) = ([0.68, 0.24, -0.2, -0.65], [0.6, 0.0, -0.6]);
const ENDS: (f32, f32) = (0.94, 1.95);
/// Points on a wheel's circumference, in radii ahead of its centre.
const RIM: [f32; 7] = [-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75];
/// Half the width of a tyre, in half tracks.
const TYRE: f32 = 0.13;
/// Newton iterations, and their damping factor: supports gain and lose contact during the iteration.
const STEPS: usize = 8;
const STEP: f32 = 0.8;
/// Stiffness of supports without contact, which keeps the equations regular.
const FAINT: f32 = 0.003;

impl Stances {
    /// The static poses of a vehicle with the shape data of the planner interface.
    pub(crate) fn new(map: &HeightMap, vehicle: &Vehicle) -> Self {
        let half = [0.5 * vehicle.wheelbase as f32, 0.5 * vehicle.track as f32];
        let point = |along: f32, across: f32, above: f32| Support {
            forward: along * half[0],
            left: across * half[1],
            above,
        };
        let clearance = vehicle.ground_clearance as f32;
        let end = ENDS.0 * 0.5 * vehicle.length as f32 / half[0];
        let (along, across) = BELLY;
        let hull = |i: usize| match i.checked_sub(along.len() * across.len()) {
            None => point(along[i / across.len()], across[i % across.len()], clearance),
            Some(i) => {
                point(if i < across.len() { end } else { -end }, across[i % across.len()], ENDS.1 * clearance)
            }
        };
        let wheels = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(u, v)| point(u, v, 0.0));
        let supports = std::array::from_fn(|i| if i < WHEELS { wheels[i] } else { hull(i - WHEELS) });
        let frame = map.frame;
        let reach = (vehicle.length + vehicle.track + vehicle.wheel_radius) / frame.resolution;
        let around = reach as usize + 2;
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let (width, height) = (cols + 2 * around, rows + 2 * around);
        let inside = |k: usize, n: usize| k.saturating_sub(around).min(n - 1);
        let heights = (0..width * height)
            .map(|k| map.data[inside(k / width, rows) * cols + inside(k % width, cols)])
            .collect();
        let mut all = Self {
            supports,
            half,
            sag: SAG * vehicle.wheelbase as f32,
            taps: vec![],
            heights,
            width,
            around,
        };
        let grid = (1.0 / frame.resolution) as f32;
        all.taps =
            (0..HEADINGS).map(|h| all.taps_of(heading(h), grid, vehicle.wheel_radius as f32)).collect();
        all
    }

    /// Offsets of sampled heights in a direction (cosine and sine) on a grid of so many nodes per metre.
    fn taps_of(&self, [cos, sin]: [f32; 2], grid: f32, radius: f32) -> Taps {
        let tap = |forward: f32, left: f32, above: f32| {
            let col = (cos * forward - sin * left) * grid + self.around as f32;
            let row = (sin * forward + cos * left) * grid + self.around as f32;
            let (u, v) = (col - col.floor(), row - row.floor());
            // Each cell is cut into two triangles from the south-west to the north-east, as in `HeightMap::ground`.
            let parts = if v >= u { [1.0 - v, 0.0, v - u, u] } else { [1.0 - u, u - v, 0.0, v] };
            Tap { above, node: row as usize * self.width + col as usize, parts }
        };
        let tyre = TYRE * self.half[1];
        let wheel = |w: usize| {
            let Support { forward, left, .. } = self.supports[w];
            std::array::from_fn(|i| {
                let part = RIM[i / 2];
                let up = radius * ((1.0 - part * part).sqrt() - 1.0);
                tap(forward + part * radius, left + if i % 2 == 0 { -tyre } else { tyre }, up)
            })
        };
        let hull = |i: usize| {
            let Support { forward, left, above } = self.supports[WHEELS + i];
            tap(forward, left, -above)
        };
        Taps { wheels: std::array::from_fn(wheel), hull: std::array::from_fn(hull) }
    }

    /// The static pose at a node, with a heading.
    pub(crate) fn at(&self, row: usize, col: usize, heading: usize) -> Stance {
        // The vehicle's node without padding, which the offsets include.
        let ground = &self.heights[row * self.width + col..];
        let height = |tap: &Tap| {
            let south = &ground[tap.node..tap.node + 2];
            let north = &ground[tap.node + self.width..tap.node + self.width + 2];
            let [a, b, c, d] = tap.parts;
            a * south[0] + b * south[1] + c * north[0] + d * north[1] + tap.above
        };
        let taps = &self.taps[heading];
        // A wheel rests on the first point of its circumference that touches the terrain.
        let lowest = |taps: &[Tap; 2 * RIM.len()]| taps.iter().map(height).fold(f32::NEG_INFINITY, f32::max);
        let [fl, fr, rl, rr] = taps.wheels.each_ref().map(lowest);
        let [a, b] = self.half;
        let plane =
            [0.25 * (fl + fr + rl + rr), 0.25 * (fl + fr - rl - rr) / a, 0.25 * (fl + rl - fr - rr) / b];
        let hull = taps.hull.each_ref().map(height);
        let over = |p: &[f32; 3], s: &Support, z: f32| z - (p[0] + p[1] * s.forward + p[2] * s.left);
        let (wheel_points, hull_points) = self.supports.split_at(WHEELS);
        // Where the clearance of the hull exceeds its maximum travel, the wheels carry everything. Two diagonal wheels
        // have no equilibrium, and nothing is solved.
        if hull_points.iter().zip(hull).all(|(s, z)| over(&plane, s, z) < -self.sag) {
            return Stance::default();
        }
        // Equilibrium of weight and moments. Forces are in quarters of the weight.
        let mut pose = plane;
        let mut borne = 0.0;
        for _ in 0..STEPS {
            let (mut sums, mut m) = ([-(WHEELS as f32), 0.0, 0.0], [0.0; 6]);
            borne = 0.0;
            let wheels = wheel_points.iter().zip([fl, fr, rl, rr]).map(|s| (s, 1.0 / self.sag, 1.0));
            let hull = hull_points.iter().zip(hull).map(|s| (s, HARD / self.sag, 0.0));
            for ((s, z), stiffness, preload) in wheels.chain(hull) {
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

    fn hmmwv() -> Vehicle {
        Vehicle {
            wheelbase: 3.302,
            track: 1.819,
            length: 4.67,
            wheel_radius: 0.467,
            ground_clearance: 0.41,
            ..Vehicle::default()
        }
    }

    const EAST: usize = 0;
    const NORTH: usize = HEADINGS / 4;

    /// The static pose of the HMMWV in the middle.
    fn stand(map: &HeightMap, heading: usize) -> Stance {
        Stances::new(map, &hmmwv()).at(40, 40, heading)
    }

    #[test]
    fn on_a_plane_the_wheels_bear_everything() {
        for (along, across) in [(0.0, 0.0), (0.3, 0.0), (-0.1, 0.2)] {
            let stance = stand(&ground(|x, y| along * x + across * y), EAST);
            assert_eq!(stance, Stance::default(), "{along}, {across}");
        }
    }

    #[test]
    fn the_hull_bears_a_vehicle_on_a_ridge_that_is_higher_than_its_clearance() {
        let ridge = |top: f64| ground(move |x, _| if x.abs() < 0.6 { top } else { 0.0 });
        assert_eq!(stand(&ridge(0.3), EAST).hull, 0.0);
        let hung = stand(&ridge(0.6), EAST);
        assert!(hung.hull > 0.5, "{hung:?}");
        // Along the ridge, which is narrower than the track, the belly stands on it as well.
        let along = stand(&ridge(0.6), NORTH);
        assert!(along.hull > 0.5, "{along:?}");
    }

    /// A vehicle lifted by a bump below its left side rolls to the right; the mirror image does the opposite.
    #[test]
    fn a_bump_beside_the_middle_tilts_the_vehicle() {
        let bump = |side: f64| {
            ground(move |x, y| if x.abs() < 0.5 && (y * side - 0.5).abs() < 0.3 { 0.7 } else { 0.0 })
        };
        let [left, right] = [1.0, -1.0].map(|side| stand(&bump(side), EAST));
        assert!(left.tilt > 0.01 && left.hull > 0.1, "{left:?}");
        assert!((left.tilt - right.tilt).abs() < 0.02, "{left:?} {right:?}");
    }

    /// Compares the hull's points with the planner's terrain map, at positions up to beyond the edge.
    #[test]
    fn heights_are_those_of_the_ground() {
        let map = ground(|x, y| 0.3 * x * y + (x - 0.4 * y).abs());
        let stances = Stances::new(&map, &hmmwv());
        for (row, col, h) in [(40, 40, 0), (13, 60, 3), (57, 21, 6), (30, 30, 11), (66, 40, 15)] {
            let (x, y) = map.frame.position(row, col);
            let [cos, sin] = heading(h).map(f64::from);
            for (support, tap) in stances.supports[WHEELS..].iter().zip(&stances.taps[h].hull) {
                let (u, v) = (f64::from(support.forward), f64::from(support.left));
                let wanted =
                    map.ground(x + cos * u - sin * v, y + sin * u + cos * v).z - f64::from(support.above);
                let node = row as usize * stances.width + col as usize + tap.node;
                let corners = [0, 1, stances.width, stances.width + 1].map(|k| stances.heights[node + k]);
                let own = tap.above + corners.iter().zip(tap.parts).map(|(z, part)| z * part).sum::<f32>();
                assert!((f64::from(own) - wanted).abs() < 1e-4, "{row} {col} {h}: {own} for {wanted}");
            }
        }
    }
}
