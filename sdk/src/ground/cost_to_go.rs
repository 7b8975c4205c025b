//! What the way to a goal costs from each place.

use super::{Ground, HEADINGS};
use crate::search::Search;
use crate::{GridFrame, Point2};

/// What the best way to a goal costs from each place, in distances between neighbours on level, firm ground, over the moves of [`HEADINGS`] and whatever the vehicle's heading there: a
/// vehicle that has to turn first needs longer.
#[derive(Clone, Debug)]
pub struct CostToGo {
    frame: GridFrame,
    /// By row and column; infinite where there is no way.
    cost: Vec<f32>,
}

impl CostToGo {
    /// Searches the whole grid from the goal (Dijkstra's algorithm).
    #[must_use]
    pub fn new(ground: &Ground, goal: Point2) -> Self {
        let frame = ground.frame();
        let (rows, cols) = (frame.rows as i32, frame.cols as i32);
        let node = |[row, col]: [i32; 2]| (row * cols + col) as usize;
        let (row, col) = frame.fractional(goal.x, goal.y);
        let nearest = |v: f64, n: i32| ((v + 0.5) as i32).clamp(0, n - 1);
        let last = [nearest(row, rows), nearest(col, cols)];
        let mut cost = vec![f32::INFINITY; (rows * cols) as usize];
        let mut search = Search::new(cost.len());
        search.start(node(last), 0.0_f32);
        while let Some(at) = search.pop() {
            let so_far = search.cost(at);
            cost[at] = so_far;
            let [row, col] = [at as i32 / cols, at as i32 % cols];
            for (heading, (dx, dy)) in HEADINGS.into_iter().enumerate() {
                // From where a move leads here.
                let from = [row - dy, col - dx];
                if !(0..rows).contains(&from[0]) || !(0..cols).contains(&from[1]) {
                    continue;
                }
                let step = ground.leg(from, heading).1;
                if step.is_finite() {
                    search.offer(node(from), at, so_far + step, 0.0);
                }
            }
        }
        Self { frame, cost }
    }

    /// The cost of the way from a point, between the places around it; `None` if there is no way from any of them.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> Option<f64> {
        let (row, col) = self.frame.fractional(x, y);
        let corner = |v: f64, n: u32| v.floor().clamp(0.0, f64::from(n.max(2) - 2));
        let (r, c) = (corner(row, self.frame.rows), corner(col, self.frame.cols));
        let (u, v) = ((row - r).clamp(0.0, 1.0), (col - c).clamp(0.0, 1.0));
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dr, dc) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let weight = if dr == 0 { 1.0 - u } else { u } * if dc == 0 { 1.0 - v } else { v };
            let cost = self.cost[(r as usize + dr) * self.frame.cols as usize + c as usize + dc];
            if cost.is_finite() {
                sum += weight * f64::from(cost);
                weights += weight;
            }
        }
        (weights > 1e-9).then(|| sum / weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Level ground of 41 × 41 m, with a wall from the south that leaves 10 m in the north, all costs as given.
    fn ground(wall: bool) -> Ground {
        let frame = GridFrame { rows: 41, cols: 41, resolution: 1.0, origin_x: -20.0, origin_y: -20.0 };
        let mut ground = Ground { frame, cost: vec![1.0; 41 * 41 * HEADINGS.len()] };
        for (k, costs) in ground.places_mut().enumerate() {
            if wall && k % 41 == 20 && k / 41 <= 30 {
                costs.fill(f32::INFINITY);
            }
        }
        ground
    }

    #[test]
    fn on_level_ground_the_way_costs_its_length_in_the_directions_of_the_moves() {
        let to_go = CostToGo::new(&ground(false), Point2 { x: 10.0, y: 0.0 });
        for (x, y, length) in
            [(10.0, 0.0, 0.0), (-10.0, 0.0, 20.0), (0.0, 10.0, 200f64.sqrt()), (0.0, 5.0, 125f64.sqrt()), (-9.5, 0.0, 19.5)]
        {
            let cost = to_go.at(x, y).unwrap();
            assert!((cost - length).abs() < 1e-4, "({x}, {y}): {cost}");
        }
    }

    #[test]
    fn a_wall_makes_the_way_longer_and_a_place_without_a_way_has_no_cost() {
        let goal = Point2 { x: 10.0, y: 0.0 };
        let to_go = CostToGo::new(&ground(true), goal);
        // Through the gap at (0, 11), or a node beside it, on either side 15 m in a straight line.
        let straight = 2.0 * 11f64.hypot(10.0);
        let cost = to_go.at(-10.0, 0.0).unwrap();
        assert!(cost > straight && cost < 1.1 * straight, "{cost}");
        assert!(to_go.at(0.0, 0.0).is_none());
        let mut closed = ground(true);
        closed.places_mut().skip(31 * 41).for_each(|costs| costs.fill(f32::INFINITY));
        assert!(CostToGo::new(&closed, goal).at(-10.0, 0.0).is_none());
    }
}
