//! The traversability map, from network predictions at every position and heading, and the cost-to-go over it.

use vb_sdk::mppi::{Field, LANES, Lanes};
use vb_sdk::search::Search;
use vb_sdk::{GridFrame, Point2};

use crate::kinodynamics::Kinodynamics;
use crate::table::{HEADINGS, heading};

/// Moves on the grid, one per heading: (columns, rows).
const MOVES: [(i32, i32); HEADINGS] = [
    (1, 0),
    (2, 1),
    (1, 1),
    (1, 2),
    (0, 1),
    (-1, 2),
    (-1, 1),
    (-2, 1),
    (-1, 0),
    (-2, -1),
    (-1, -1),
    (-1, -2),
    (0, -1),
    (1, -2),
    (1, -1),
    (2, -1),
];
/// Cost of a turn by one heading in addition to the path, in nodes.
const TURN: f32 = 0.5;

/// Path costs per metre in addition to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prices {
    /// At a probability of 1 of getting stuck.
    pub stuck: f32,
    /// At a probability of 1 of tipping over.
    pub over: f32,
    /// Where the target speed is lost within a second.
    pub slow: f32,
    /// In contact with an obstacle.
    pub obstacle: f32,
}

/// The cost-to-go from every position and heading, in m of easy terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Indexed by heading, row and column.
    values: Vec<f32>,
    rows: usize,
    cols: usize,
    per_metre: f32,
    origin: [f32; 2],
}

/// Path cost per metre at each position, by heading, row and column; 1 on easy terrain.
#[must_use]
pub fn costs(
    frame: GridFrame,
    model: &Kinodynamics,
    clearance: &Field,
    (radius, margin): (f32, f32),
    target: f32,
    prices: &Prices,
) -> Vec<f32> {
    let (rows, cols) = (frame.rows as usize, frame.cols as usize);
    let mut costs = vec![1.0; HEADINGS * rows * cols];
    for h in 0..HEADINGS {
        let [cos, sin] = heading(h);
        for row in 0..rows {
            for first in (0..cols).step_by(LANES) {
                let at = |l: usize| frame.position(row as u32, (first + l).min(cols - 1) as u32);
                let x: Lanes = std::array::from_fn(|l| at(l).0 as f32);
                let y: Lanes = std::array::from_fn(|l| at(l).1 as f32);
                let [stuck, over, slow] = model.hazards_at([&x, &y], [cos, sin], target);
                let clear = clearance.at(&x, &y);
                let own = &mut costs[(h * rows + row) * cols + first..][..LANES.min(cols - first)];
                for (l, cost) in own.iter_mut().enumerate() {
                    let near = (1.0 - (clear[l] - radius) / margin).clamp(0.0, 1.0);
                    *cost += prices.stuck * stuck[l]
                        + prices.over * over[l]
                        + prices.slow * slow[l]
                        + prices.obstacle * (0.1 * near * near + if clear[l] < radius { 1.0 } else { 0.0 });
                }
            }
        }
    }
    costs
}

impl Values {
    /// Computes the cost-to-go (Dijkstra 1959, backwards from the goal) over these costs. The vehicle moves straight
    /// ahead, or ahead and then in the adjacent heading, which approximates an arc within the steering limit.
    #[must_use]
    pub fn new(frame: GridFrame, costs: &[f32], goal: Point2) -> Self {
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let area = rows * cols;
        let (r, c) = frame.fractional(goal.x, goal.y);
        let nearest = |v: f64, n: usize| ((v + 0.5).max(0.0) as usize).min(n - 1);
        let at = nearest(r, rows) * cols + nearest(c, cols);
        let mut search = Search::new(HEADINGS * area);
        (0..HEADINGS).for_each(|h| search.start(h * area + at, 0.0));
        // The cell before a move in a heading, and the cost of the move.
        let before = |cell: usize, h: usize| {
            let (dc, dr) = MOVES[h];
            let (row, col) = ((cell / cols) as i32 - dr, (cell % cols) as i32 - dc);
            let inside = (0..rows as i32).contains(&row) && (0..cols as i32).contains(&col);
            inside.then(|| {
                let from = row as usize * cols + col as usize;
                let length = ((dc * dc + dr * dr) as f32).sqrt();
                (from, 0.5 * length * (costs[h * area + from] + costs[h * area + cell]))
            })
        };
        while let Some(node) = search.pop() {
            let (h, cell) = (node / area, node % area);
            let Some((from, way)) = before(cell, h) else { continue };
            let cost = search.cost(node) + way;
            search.offer(h * area + from, node, cost, 0.0);
            for turn in [1, HEADINGS - 1] {
                let earlier = (h + turn) % HEADINGS;
                if let Some((first, more)) = before(from, earlier) {
                    search.offer(earlier * area + first, node, cost + more + TURN, 0.0);
                }
            }
        }
        let mut values = search.into_costs();
        let resolution = frame.resolution as f32;
        let worst = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        // Cells without a path get a cost above the maximum.
        values.iter_mut().for_each(|v| *v = resolution * if v.is_finite() { *v } else { 1.1 * worst });
        let origin = [frame.origin_x as f32, frame.origin_y as f32];
        Self { values, rows, cols, per_metre: 1.0 / resolution, origin }
    }

    /// The cost-to-go at these positions (m) and headings, interpolated between the nodes and the two adjacent
    /// headings.
    #[must_use]
    pub fn at(&self, [x, y]: [&Lanes; 2], [cos, sin]: [&Lanes; 2]) -> Lanes {
        std::array::from_fn(|l| {
            let most = |n: usize| (n - 1) as f32;
            let c = ((x[l] - self.origin[0]) * self.per_metre).clamp(0.0, most(self.cols));
            let r = ((y[l] - self.origin[1]) * self.per_metre).clamp(0.0, most(self.rows));
            let (col, row) = ((c as usize).min(self.cols - 2), (r as usize).min(self.rows - 2));
            let (u, v) = (c - col as f32, r - row as f32);
            let around = around(cos[l], sin[l]);
            let lower = around as usize % HEADINGS;
            let part = around - around.floor();
            let plane = |h: usize| {
                let i = (h * self.rows + row) * self.cols + col;
                let (a, b) = (&self.values[i..i + 2], &self.values[i + self.cols..i + self.cols + 2]);
                let (south, north) = (a[0] + u * (a[1] - a[0]), b[0] + u * (b[1] - b[0]));
                south + v * (north - south)
            };
            let (a, b) = (plane(lower), plane((lower + 1) % HEADINGS));
            a + part * (b - a)
        })
    }
}

/// A direction as a fractional heading index from 0 to [`HEADINGS`].
fn around(cos: f32, sin: f32) -> f32 {
    crate::table::around(cos, sin).clamp(0.0, HEADINGS as f32 - 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: GridFrame =
        GridFrame { rows: 41, cols: 41, resolution: 1.0, origin_x: -20.0, origin_y: -20.0 };

    fn lanes(v: f32) -> Lanes {
        [v; LANES]
    }

    #[test]
    fn on_good_ground_the_way_is_as_long_as_it_is() {
        let values = Values::new(FRAME, &vec![1.0; HEADINGS * 41 * 41], Point2 { x: 10.0, y: 0.0 });
        let at = |x: f32, y: f32, cos: f32, sin: f32| {
            values.at([&lanes(x), &lanes(y)], [&lanes(cos), &lanes(sin)])[0]
        };
        assert!((at(-10.0, 0.0, 1.0, 0.0) - 20.0).abs() < 1e-3);
        assert!((at(-10.5, 0.0, 1.0, 0.0) - 20.5).abs() < 1e-3);
        // Along the diagonal of the grid.
        let half = 0.5_f32.sqrt();
        assert!((at(0.0, -10.0, half, half) - 200_f32.sqrt()).abs() < 1e-2);
        // Facing away from the goal requires a turn first.
        assert!(at(-10.0, 0.0, -1.0, 0.0) > 28.0);
    }

    #[test]
    fn a_way_leads_around_what_is_dear() {
        // A wall from the south edge to y = 5 with ten times the cost.
        let mut costs = vec![1.0; HEADINGS * 41 * 41];
        for (k, cost) in costs.iter_mut().enumerate() {
            let (row, col) = (k / 41 % 41, k % 41);
            if (20..=22).contains(&col) && row < 25 {
                *cost = 10.0;
            }
        }
        let values = Values::new(FRAME, &costs, Point2 { x: 12.0, y: 0.0 });
        let at = |x: f32, y: f32| values.at([&lanes(x), &lanes(y)], [&lanes(1.0), &lanes(0.0)])[0];
        // 22 m straight, of which 3 m have ten times the cost: 49; the path around the wall is cheaper.
        let way = at(-10.0, 0.0);
        assert!(way > 24.0 && way < 32.0, "{way}");
    }
}
