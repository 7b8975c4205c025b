//! Where tasks start and end: opposite each other on a circle, on ground that a vehicle can stand on.

use super::broken::{Broken, Rule};
use super::params::StandParams;
use vb_math::{angle::degrees, atan, hypot};
use vb_world::{Heightfield, Obstacle, Semantics};

/// Directions in which a pair of start and goal is looked for.
pub(crate) const DIRECTIONS: usize = 360;
/// Points along the diameter of the disc whose ground is looked at.
const SAMPLES: i32 = 13;

/// Start and goal of each task, m, and how evenly they lie.
pub(crate) struct Ends {
    /// In the tasks' order.
    pub(crate) pairs: Vec<[[f64; 2]; 2]>,
    /// Whether each lies no farther from its place on the evenly divided circle than the next place, and no two are one.
    pub(crate) spread: bool,
}

/// The directions from the middle in which tasks can start: both ends have a stand, and a vehicle can start towards the goal.
pub(crate) struct Starts {
    radius: f64,
    usable: Vec<usize>,
    /// How often which rule is broken in the others.
    pub(crate) broken: Broken,
}

impl Starts {
    /// Those on a circle of this radius, m, about the middle of a ground, with a distance to obstacles, m.
    pub(crate) fn new(
        ground: &Heightfield,
        semantics: &Semantics,
        obstacles: &[Obstacle],
        clearance: f64,
        radius: f64,
        stand: &StandParams,
    ) -> Self {
        let clear = |p: [f64; 2]| {
            obstacles.iter().all(|o| {
                let [a, b, _] = o.size();
                hypot(o.x - p[0], o.y - p[1]) > 0.5 * hypot(a, b) + clearance
            })
        };
        let mut broken = Broken::default();
        let free: Vec<bool> = (0..DIRECTIONS)
            .map(|k| {
                let at = place(radius, k);
                let flaws = if clear(at) { stand_flaws(ground, at, stand) } else { vec![Rule::Obstacles] };
                broken.stands.add(&flaws);
                flaws.is_empty()
            })
            .collect();
        let mut usable = Vec::new();
        for k in (0..DIRECTIONS).filter(|&k| free[k] && free[(k + DIRECTIONS / 2) % DIRECTIONS]) {
            let flaws = start_flaws(ground, semantics, place(radius, k), stand);
            broken.starts.add(&flaws);
            if flaws.is_empty() {
                usable.push(k);
            }
        }
        Self { radius, usable, broken }
    }

    /// The number of tasks that can start in directions of their own.
    pub(crate) fn room(&self) -> usize {
        self.usable.len()
    }

    /// Each of so many pairs in the direction nearest to where an even division of the circle would have it, of those in which no
    /// other task starts; places in millimetres. Where fewer directions are left than there are tasks, some tasks share one. None
    /// if there is no direction at all.
    pub(crate) fn ends(&self, count: usize) -> Option<Ends> {
        let mut left = self.usable.clone();
        let mut ends = Ends { pairs: Vec::with_capacity(count), spread: true };
        for k in 0..count {
            if left.is_empty() {
                left.clone_from(&self.usable);
                ends.spread = false;
            }
            let nearest = (0..left.len()).min_by_key(|&i| away(left[i], k, count))?;
            let direction = left.remove(nearest);
            ends.spread &= is_near(direction, k, count);
            let start = place(self.radius, direction);
            ends.pairs.push([start, start.map(|v| 0.0 - v)]);
        }
        Some(ends)
    }
}

/// The directions in which tasks could start on any of several grounds.
pub(crate) struct Possible([bool; DIRECTIONS]);

impl Possible {
    pub(crate) fn none() -> Self {
        Self([false; DIRECTIONS])
    }

    pub(crate) fn add(&mut self, starts: &Starts) {
        starts.usable.iter().for_each(|&k| self.0[k] = true);
    }

    /// Whether each of so many tasks could start near its place on the evenly divided circle, if the others did elsewhere.
    pub(crate) fn all_around(&self, count: usize) -> bool {
        (0..count).all(|k| (0..DIRECTIONS).any(|direction| self.0[direction] && is_near(direction, k, count)))
    }
}

/// How far a direction lies from the place of one of so many tasks on the evenly divided circle.
fn away(direction: usize, task: usize, count: usize) -> usize {
    let d = direction.abs_diff(task * DIRECTIONS / count);
    d.min(DIRECTIONS - d)
}

/// Whether it lies no farther than the place of the next task.
fn is_near(direction: usize, task: usize, count: usize) -> bool {
    away(direction, task, count) * count <= DIRECTIONS
}

/// A place on a circle, m.
fn place(radius: f64, direction: usize) -> [f64; 2] {
    let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64);
    [c, s].map(|v| millimetres(radius * v))
}

/// Rounded to whole millimetres, which people can read, and never to a negative zero.
pub(crate) fn millimetres(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0 + 0.0
}

/// The rules that the ground about a point breaks, which is to be all there, level and even enough.
fn stand_flaws(ground: &Heightfield, [x, y]: [f64; 2], stand: &StandParams) -> Vec<Rule> {
    let half = SAMPLES / 2;
    let offset = |k: i32| f64::from(k) / f64::from(half) * stand.reach;
    let disc = (-half..=half)
        .flat_map(|i| (-half..=half).map(move |j| [i, j]))
        .filter(|[i, j]| i * i + j * j <= half * half)
        .map(|[i, j]| [offset(i), offset(j)]);
    let mut points = Vec::new();
    for [u, v] in disc {
        if !ground.contains(x + u, y + v) {
            return vec![Rule::Edge];
        }
        points.push([u, v, ground.height(x + u, y + v)]);
    }
    // The disc's points lie evenly about its middle, so that mean and slopes of the fit do not depend on each other.
    let sum = |f: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let mean = sum(&|p| p[2]) / points.len() as f64;
    let square = sum(&|p| p[0] * p[0]);
    let slope = [sum(&|p| p[0] * p[2]) / square, sum(&|p| p[1] * p[2]) / square];
    let uneven = |p: &[f64; 3]| (p[2] - mean - slope[0] * p[0] - slope[1] * p[1]).abs() > stand.unevenness;
    let kept = [
        (Rule::Tilt, degrees(atan(hypot(slope[0], slope[1]))) <= stand.tilt),
        (Rule::Unevenness, !points.iter().any(uneven)),
    ];
    broken_of(&kept)
}

/// The rules that wheels break at a point that head for the middle, and so for the goal, which are to stand neither too steeply
/// uphill nor too much on two of them, and to hold: what else makes a vehicle spin its wheels before it has moved, above all
/// where the ground yields.
fn start_flaws(
    ground: &Heightfield,
    semantics: &Semantics,
    [x, y]: [f64; 2],
    stand: &StandParams,
) -> Vec<Rule> {
    let distance = hypot(x, y);
    let [c, s] = [-x / distance, -y / distance];
    let [along, across] = stand.wheels.map(|l| 0.5 * l);
    let z = |u: f64, v: f64| ground.height(x + c * u - s * v, y + s * u + c * v);
    let [fl, fr, rl, rr] = [z(along, across), z(along, -across), z(-along, across), z(-along, -across)];
    let rise = 0.5 * (fl + fr - rl - rr) / stand.wheels[0];
    let roll = 0.5 * (fl + rl - fr - rr) / stand.wheels[1];
    let holds = match semantics.friction_at(x, y) {
        // Ground that yields has none.
        0.0 => true,
        friction => hypot(rise, roll) <= stand.grip * friction,
    };
    let kept = [
        (Rule::Grip, holds),
        (Rule::Climb, degrees(atan(rise)) <= stand.climb),
        (Rule::Twist, 0.5 * (fl - fr - rl + rr).abs() <= stand.twist),
    ];
    broken_of(&kept)
}

fn broken_of(rules: &[(Rule, bool)]) -> Vec<Rule> {
    rules.iter().filter(|(_, is_kept)| !is_kept).map(|(rule, _)| *rule).collect()
}

#[cfg(test)]
mod tests {
    use super::super::TaskParams;
    use super::*;
    use vb_world::{SoilLevels, TerrainClass};

    fn ends(
        ground: &Heightfield,
        semantics: &Semantics,
        obstacles: &[Obstacle],
        clearance: f64,
        radius: f64,
        tasks: &TaskParams,
    ) -> Option<Ends> {
        Starts::new(ground, semantics, obstacles, clearance, radius, &tasks.stand).ends(tasks.count)
    }

    const STAND: StandParams = StandParams {
        reach: 3.0,
        tilt: 10.0,
        unevenness: 0.2,
        wheels: [3.0, 2.0],
        climb: 90.0,
        twist: 10.0,
        grip: 1.0,
    };
    const TASKS: TaskParams = TaskParams { count: 4, radius: 20.0, stand: STAND };

    fn ground(z: impl Fn(f64, f64) -> f64) -> Heightfield {
        let at = |i: usize| (i as f64 - 32.0) * 1.0;
        Heightfield::new(65, 65, 1.0, (0..65 * 65).map(|i| z(at(i % 65), at(i / 65))).collect())
    }

    fn firm(friction: f64) -> Semantics {
        let (classes, friction) = (vec![TerrainClass::Dirt], vec![friction]);
        Semantics { rows: 1, cols: 1, patch: 64.0, classes, friction, soil: SoilLevels::default() }
    }

    #[test]
    fn on_level_ground_the_circle_is_divided_evenly() {
        let pairs = ends(&ground(|_, _| 1.0), &firm(0.5), &[], 3.5, 20.0, &TASKS).unwrap().pairs;
        let starts = [[20.0, 0.0], [0.0, 20.0], [-20.0, 0.0], [0.0, -20.0]];
        assert_eq!(pairs, starts.map(|s| [s, s.map(|v: f64| 0.0 - v)]));
    }

    #[test]
    fn both_ends_stand_on_ground_that_is_neither_steep_nor_uneven() {
        // tan 10° = 0.176: the east is too steep, and with it the west, whose tasks end there.
        let steep = ends(&ground(|x, _| 0.2 * x.max(0.0)), &firm(0.5), &[], 3.5, 20.0, &TASKS).unwrap().pairs;
        assert!(steep.iter().all(|[s, _]| s[0].abs() < 3.1), "{steep:?}");
        assert!(ends(&ground(|x, _| 0.17 * x), &firm(0.5), &[], 3.5, 20.0, &TASKS).is_some());
        assert!(ends(&ground(|x, _| 0.18 * x), &firm(0.5), &[], 3.5, 20.0, &TASKS).is_none());
        // Ridges of 1 m do not tilt the plane that fits best.
        let ridges = |x: f64, _| 0.5 * vb_math::cos(std::f64::consts::PI * x);
        assert!(ends(&ground(ridges), &firm(0.5), &[], 3.5, 20.0, &TASKS).is_none());
    }

    #[test]
    fn tasks_share_a_direction_only_if_there_are_too_few() {
        let pairs = ends(&ground(|x, _| 0.2 * x.max(0.0)), &firm(0.5), &[], 3.5, 20.0, &TASKS).unwrap().pairs;
        for (k, a) in pairs.iter().enumerate() {
            assert!(pairs[..k].iter().all(|b| a != b), "{pairs:?}");
        }
        // Only the directions due north and south are left.
        let gap = |x: f64, y: f64| if y.abs() > 8.0 && x.abs() < 3.5 { 0.0 } else { x * x };
        let pairs = ends(&ground(gap), &firm(0.5), &[], 3.5, 20.0, &TASKS).unwrap().pairs;
        assert!(pairs.iter().all(|[s, _]| s[0].abs() < 1.0), "{pairs:?}");
    }

    #[test]
    fn starts_are_not_steeply_uphill_nor_on_two_wheels() {
        // The ground rises eastwards by tan 5°: westward starts in the east are downhill, those in the west are uphill.
        let climb = TaskParams { stand: StandParams { climb: 4.0, ..STAND }, ..TASKS };
        let ends = ends(&ground(|x, _| 0.0875 * x), &firm(0.5), &[], 3.5, 20.0, &climb).unwrap();
        assert!(ends.pairs.iter().all(|[s, _]| s[0] > -16.0), "cos(angle) tan 5° <= tan 4° {:?}", ends.pairs);
        assert!(ends.pairs[2][0][1].abs() > 11.9, "the third can't start due west: {:?}", ends.pairs);
        // A saddle z = a x y lifts one pair of diagonal wheels that head along x above the other by 2 a · 1.5 m · 1 m.
        let stand = StandParams { twist: 0.04, tilt: 45.0, unevenness: 1.0, ..STAND };
        let twist = TaskParams { stand, ..TASKS };
        let first = |a: f64| {
            let saddle = ground(move |x, y| a * (x * y));
            self::ends(&saddle, &firm(0.9), &[], 3.5, 20.0, &twist).unwrap().pairs[0][0]
        };
        assert_eq!(first(0.012), [20.0, 0.0], "0.036 m");
        assert!(first(0.015)[1].abs() > 0.1, "0.045 m on the axis, nothing on the diagonals");
    }

    #[test]
    fn a_vehicle_at_a_start_does_not_slide() {
        let tasks = TaskParams { stand: StandParams { grip: 0.7, ..STAND }, ..TASKS };
        let slope = |grade: f64| ground(move |x, y| grade * (x + y) / std::f64::consts::SQRT_2);
        assert!(ends(&slope(0.13), &firm(0.2), &[], 3.5, 20.0, &tasks).is_some(), "0.7 * 0.2 = 0.14");
        assert!(ends(&slope(0.15), &firm(0.2), &[], 3.5, 20.0, &tasks).is_none());
        assert!(ends(&slope(0.15), &firm(0.25), &[], 3.5, 20.0, &tasks).is_some());
    }
}
