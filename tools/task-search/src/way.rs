//! How far it still is to the goal over ground that is not too steep: what the search goes by, and no more than that.

use vb_sdk::search::Search;
use vb_sdk::{Map, Point2, Task, math};

/// The slope that makes a metre of ground cost twice as much.
const STEEP: f64 = 0.35;
/// What a metre costs that lies within an obstacle or within half a track's width of one.
const BLOCKED: f64 = 30.0;
/// The greatest turn that is looked at, rad, and how many there are to each side.
const MOST: f64 = 1.4;
const WIDE: i32 = 7;
/// Steps to the eight neighbours of a cell.
const NEIGHBOURS: [(i64, i64); 8] = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)];

/// The cost of the way to the goal from each cell of the map of heights, in metres of level ground.
pub(crate) struct Way {
    left: Map<f32>,
}

impl Way {
    /// Of a task whose maps of heights and obstacles are known; `None` if they aren't.
    pub(crate) fn new(task: &Task) -> Option<Self> {
        let heights = task.elevation.as_ref()?;
        let blocked = task.occupancy.as_ref()?;
        let frame = heights.frame;
        let (rows, cols) = (i64::from(frame.rows), i64::from(frame.cols));
        let place = |node: usize| {
            let (x, y) = frame.position((node as i64 / cols) as u32, (node as i64 % cols) as u32);
            Point2 { x, y }
        };
        let clearance = 0.5 * task.vehicle.track;
        let around = [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let is_blocked = |p: Point2| {
            around
                .iter()
                .map(|(x, y)| (p.x + x * clearance, p.y + y * clearance))
                .any(|(x, y)| !blocked.frame.covers(x, y) || blocked.nearest(x, y) != 0)
        };
        let dear: Vec<bool> = (0..heights.data.len()).map(|node| is_blocked(place(node))).collect();
        let (row, col) = frame.fractional(task.goal.x, task.goal.y);
        let nearest = |v: f64, n: i64| (v.round().max(0.0) as i64).min(n - 1);
        let goal = (nearest(row, rows) * cols + nearest(col, cols)) as usize;
        let mut search = Search::new(heights.data.len());
        search.start(goal, 0.0);
        let mut left = vec![f32::INFINITY; heights.data.len()];
        while let Some(at) = search.pop() {
            left[at] = search.cost(at) as f32;
            let (row, col) = (at as i64 / cols, at as i64 % cols);
            for (dr, dc) in NEIGHBOURS {
                let (r, c) = (row + dr, col + dc);
                if !(0..rows).contains(&r) || !(0..cols).contains(&c) {
                    continue;
                }
                let next = (r * cols + c) as usize;
                let length = frame.resolution * ((dr * dr + dc * dc) as f64).sqrt();
                let slope = f64::from(heights.data[next] - heights.data[at]) / length / STEEP;
                let price = if dear[next] { BLOCKED } else { 1.0 + slope * slope };
                search.offer(next, at, search.cost(at) + length * price, 0.0);
            }
        }
        Some(Self { left: Map { frame, data: left } })
    }

    /// The cost from a place, m of level ground.
    pub(crate) fn left(&self, x: f64, y: f64) -> f64 {
        self.left.bilinear(x, y)
    }

    /// By how much, in rad, a vehicle with this pose has to turn left so that the way from `ahead` (m) farther on is the shortest.
    pub(crate) fn turn(&self, [x, y]: [f64; 2], yaw: f64, ahead: f64) -> f64 {
        let there = |turn: f64| {
            let (sin, cos) = math::sin_cos(yaw + turn);
            self.left(x + ahead * cos, y + ahead * sin)
        };
        let turns = (-WIDE..=WIDE).map(|k| f64::from(k) * MOST / f64::from(WIDE));
        turns.min_by(|a, b| there(*a).total_cmp(&there(*b))).unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{GridFrame, Vehicle};

    /// A world of 40 m, flat but for what is told: heights by x and y, and what is blocked.
    fn task(height: impl Fn(f64, f64) -> f64, blocked: impl Fn(f64, f64) -> bool) -> Task {
        let frame = GridFrame { rows: 41, cols: 41, resolution: 1.0, origin_x: -20.0, origin_y: -20.0 };
        let places: Vec<(f64, f64)> = (0..41 * 41).map(|k| frame.position(k / 41, k % 41)).collect();
        let heights = places.iter().map(|(x, y)| height(*x, *y) as f32).collect();
        let labels = places.iter().map(|(x, y)| u8::from(blocked(*x, *y))).collect();
        Task {
            vehicle: Vehicle { track: 1.8, ..Vehicle::default() },
            elevation: Some(Map { frame, data: heights }),
            occupancy: Some(Map { frame, data: labels }),
            goal: Point2 { x: 10.0, y: 0.0 },
            ..Task::default()
        }
    }

    #[test]
    fn on_level_ground_it_is_as_far_as_it_is() {
        let way = Way::new(&task(|_, _| 0.0, |_, _| false)).unwrap();
        assert!((way.left(-10.0, 0.0) - 20.0).abs() < 1e-3);
        assert!((way.left(0.0, 10.0) - 200_f64.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn a_wall_and_a_bank_are_gone_round_where_that_is_nearer() {
        let wall = Way::new(&task(|_, _| 0.0, |x, y| x.abs() < 0.6 && y < 6.0)).unwrap();
        let bank =
            Way::new(&task(|x, y| if x.abs() < 0.6 && y < 6.0 { 1.5 } else { 0.0 }, |_, _| false)).unwrap();
        for way in [wall, bank] {
            // Through it, a wall costs 30 m a metre and a bank 37 m over its two sides; round it there are 5 m more.
            let left = way.left(-10.0, 0.0);
            assert!((24.0..32.0).contains(&left), "{left}");
        }
    }

    #[test]
    fn who_looks_past_the_goal_turns_to_it() {
        let way = Way::new(&task(|_, _| 0.0, |_, _| false)).unwrap();
        assert!(way.turn([0.0, 0.0], 0.0, 5.0).abs() < 0.11);
        let turn = way.turn([0.0, 0.0], 0.8, 5.0);
        assert!((turn + 0.8).abs() < 0.2, "{turn}");
    }

    #[test]
    fn without_maps_there_is_no_way() {
        let whole = task(|_, _| 0.0, |_, _| false);
        assert!(Way::new(&Task { elevation: None, ..whole.clone() }).is_none());
        assert!(Way::new(&Task { occupancy: None, ..whole }).is_none());
    }
}
