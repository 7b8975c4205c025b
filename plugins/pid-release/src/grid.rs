//! The original's global planner (systems/PID/PID.py): A* on pixels, and one Bézier curve.
//!
//! Pixels are numbered (row, column) from the north-west. The planner assumes that pixel k covers k − n/2 to k + 1 −
//! n/2 of n, half a pixel off the elevation, and its path uses the lower bound of each pixel, as in the original.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use vb_sdk::{Map, PlannerError};

/// A pixel: row from the north, column from the west.
pub type Cell = (usize, usize);

/// Occupancy of the pixels.
#[derive(Clone, Debug)]
pub struct Grid {
    side: usize,
    pixel: f64,
    /// Row-major.
    blocked: Vec<bool>,
}

/// Points of a smoothed path.
const SAMPLES: usize = 100;

impl Grid {
    /// A free grid of `side` × `side` pixels of `pixel` metres.
    #[must_use]
    pub fn new(side: usize, pixel: f64) -> Self {
        Self { side, pixel, blocked: vec![false; side * side] }
    }

    /// Size of a pixel, m.
    #[must_use]
    pub fn pixel(&self) -> f64 {
        self.pixel
    }

    /// Blocks squares given as `ROW:COLUMN:HALF;...`, each extending `HALF` pixels from its centre.
    ///
    /// # Errors
    /// Returns an error for any other text, or a centre outside the grid.
    pub fn block_squares(&mut self, text: &str) -> Result<(), PlannerError> {
        for square in text.split(';') {
            let numbers: Vec<usize> = square.split(':').map_while(|s| s.parse().ok()).collect();
            let &[row, col, half] = numbers.as_slice() else {
                return Err(format!("parameter `obstacles`: {square:?} is not ROW:COLUMN:HALF").into());
            };
            if row >= self.side || col >= self.side {
                let last = self.side - 1;
                return Err(
                    format!("parameter `obstacles`: {square:?} lies outside pixels 0 to {last}").into()
                );
            }
            self.block(row, col, half);
        }
        Ok(())
    }

    /// Blocks the pixels with centres in occupied cells of an occupancy map.
    pub fn block_occupied(&mut self, occupancy: &Map<u8>) {
        for row in 0..self.side {
            for col in 0..self.side {
                let [x, y] = self.position((row as f64, col as f64));
                if occupancy.nearest(x, y) != 0 {
                    self.block(row, col, 0);
                }
            }
        }
    }

    fn block(&mut self, row: usize, col: usize, half: usize) {
        let span = |k: usize| k.saturating_sub(half)..=(k + half).min(self.side - 1);
        for i in span(row) {
            for j in span(col) {
                self.blocked[i * self.side + j] = true;
            }
        }
    }

    /// The grid with every blocked pixel dilated to a square that extends `half` pixels from it.
    #[must_use]
    pub fn inflated(&self, half: usize) -> Self {
        let mut grown = Self::new(self.side, self.pixel);
        for k in (0..self.blocked.len()).filter(|&k| self.blocked[k]) {
            grown.block(k / self.side, k % self.side, half);
        }
        grown
    }

    /// The pixel of a position, m; outside the map the nearest pixel.
    #[must_use]
    pub fn cell(&self, x: f64, y: f64) -> Cell {
        let half = 0.5 * self.side as f64;
        // The cast truncates the fraction and clamps negative values to 0.
        let index = |v: f64| ((v / self.pixel + half) as usize).min(self.side - 1);
        (index(-y), index(x))
    }

    /// The position of a (fractional) pixel, m.
    fn position(&self, (row, col): (f64, f64)) -> [f64; 2] {
        let half = 0.5 * self.side as f64;
        [(col - half) * self.pixel, (half - row) * self.pixel]
    }

    /// The path found by A* from `start` to `goal`, both included; none without a path.
    ///
    /// All eight neighbours cost 1, the heuristic is the Euclidean distance (which overestimates diagonals); ties go to
    /// the smaller row, then to the smaller column. The start may be blocked.
    #[must_use]
    pub fn plan(&self, start: Cell, goal: Cell) -> Option<Vec<Cell>> {
        let index = |(row, col): Cell| row * self.side + col;
        let estimate = |(row, col): Cell| {
            let (dr, dc) = (row as f64 - goal.0 as f64, col as f64 - goal.1 as f64);
            (dr * dr + dc * dc).sqrt()
        };
        let mut cost = vec![u32::MAX; self.blocked.len()];
        let mut parent = vec![start; self.blocked.len()];
        let mut closed = vec![false; self.blocked.len()];
        // Estimates are not negative: their bits have the same order.
        let mut open = BinaryHeap::from([Reverse((0u64, start))]);
        cost[index(start)] = 0;
        while let Some(Reverse((_, cell))) = open.pop() {
            if cell == goal {
                let mut way = vec![goal];
                while way[way.len() - 1] != start {
                    way.push(parent[index(way[way.len() - 1])]);
                }
                way.reverse();
                return Some(way);
            }
            if std::mem::replace(&mut closed[index(cell)], true) {
                continue;
            }
            let next_cost = cost[index(cell)] + 1;
            let rows = cell.0.saturating_sub(1)..=(cell.0 + 1).min(self.side - 1);
            for next in rows.flat_map(|r| {
                (cell.1.saturating_sub(1)..=(cell.1 + 1).min(self.side - 1)).map(move |c| (r, c))
            }) {
                let k = index(next);
                if self.blocked[k] || closed[k] || next_cost >= cost[k] {
                    continue;
                }
                cost[k] = next_cost;
                parent[k] = cell;
                open.push(Reverse(((f64::from(next_cost) + estimate(next)).to_bits(), next)));
            }
        }
        None
    }

    /// The Bézier curve with these cells as its control points, at 100 parameters from 0 to 1, m. Fewer than three
    /// cells are returned unchanged.
    #[must_use]
    pub fn smooth(&self, cells: &[Cell]) -> Vec<[f64; 2]> {
        let exact = |&(row, col): &Cell| (row as f64, col as f64);
        if cells.len() < 3 {
            return cells.iter().map(|c| self.position(exact(c))).collect();
        }
        let curve = (0..SAMPLES).map(|k| k as f64 / (SAMPLES - 1) as f64);
        curve
            .map(|t| {
                let weights = bernstein(cells.len() - 1, t);
                let sum: f64 = weights.iter().sum();
                let (mut row, mut col) = (0.0, 0.0);
                for (w, cell) in weights.iter().zip(cells) {
                    row += w / sum * cell.0 as f64;
                    col += w / sum * cell.1 as f64;
                }
                self.position((row, col))
            })
            .collect()
    }
}

/// The n + 1 Bernstein polynomials of degree n at t, up to a common factor: the maximum is 1, so that high degrees
/// neither overflow nor vanish.
fn bernstein(n: usize, t: f64) -> Vec<f64> {
    let mode = ((n as f64 * t) as usize).min(n);
    let mut weights = vec![0.0; n + 1];
    weights[mode] = 1.0;
    // B(i + 1) / B(i) = (n − i) / (i + 1) · t / (1 − t).
    let ratio = |i: usize| (n - i) as f64 / (i + 1) as f64 * t / (1.0 - t);
    for i in mode..n {
        weights[i + 1] = weights[i] * ratio(i);
    }
    for i in (0..mode).rev() {
        weights[i] = if t < 1.0 { weights[i + 1] / ratio(i) } else { 0.0 };
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(path: &[[f64; 2]]) -> f64 {
        path.windows(2).map(|w| vb_sdk::math::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1])).sum()
    }

    /// `tasks.csv` has the cells and lengths of the way that the original's own code finds on its obstacle bitmaps
    /// (8 bits, 129 rows of 132 bytes from byte 1078 on, bottom row first; 255 is an obstacle, envs/gen-VertiBench.py).
    #[test]
    fn ways_are_as_long_as_those_of_the_original() {
        let Some(_) = vb_testing::shared("verti-bench/BenchMaps") else { return };
        let shared = vb_testing::shared_folder();
        let table = std::fs::read_to_string(shared.join("reference/tasks.csv")).unwrap();
        let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
        let mut checked = 0;
        for line in table.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |name: &str| cells[column(name)].parse::<f64>().unwrap();
            let world = cells[column("world")];
            let folder = shared.join("verti-bench/BenchMaps/sampled_maps/Configs/Final");
            let file = ["low", "mid", "high"]
                .iter()
                .map(|level| folder.join(format!("obs{world}_{level}.bmp")))
                .find(|f| f.is_file());
            let Some(file) = file else { continue };
            let bytes = std::fs::read(file).unwrap();
            let mut grid = Grid::new(129, 1.0);
            for row in 0..129 {
                for col in 0..129 {
                    grid.blocked[row * 129 + col] = bytes[1078 + 132 * (128 - row) + col] == 255;
                }
            }
            let grid = grid.inflated(4);
            let start = grid.cell(number("start_x"), number("start_y"));
            let goal = grid.cell(number("goal_x"), number("goal_y"));
            let way = grid.plan(start, goal).unwrap();
            let task = cells[column("task")];
            assert_eq!(way.len() as f64, number("astar_cells"), "world {world}, task {task}");
            let corners: Vec<_> = way.iter().map(|c| grid.position((c.0 as f64, c.1 as f64))).collect();
            for (name, value) in
                [("astar_len_m", length(&corners)), ("bezier_len_m", length(&grid.smooth(&way)))]
            {
                assert!((value - number(name)).abs() < 1.1e-4, "world {world}, task {task}: {name}: {value}");
            }
            checked += 1;
        }
        assert_eq!(checked % 10, 0);
        assert!(checked >= 100, "{checked}");
    }

    #[test]
    fn the_first_cells_and_the_curve_are_those_of_the_reference_vector() {
        // testvectors.json, world 1, task 0: start and the first cells; without obstacles the way is straight.
        let grid = Grid::new(129, 1.0);
        assert_eq!((grid.cell(60.0, 0.0), grid.cell(-60.0, 0.0)), ((64, 124), (64, 4)));
        assert_eq!(grid.position((64.0, 124.0)), [59.5, 0.5]);
        assert_eq!((grid.cell(-99.0, 99.0), grid.cell(99.0, -99.0)), ((0, 0), (128, 128)));
        let curve = grid.smooth(&[(64, 124), (64, 123), (63, 122)]);
        // A parabola: at t = 1/2 a quarter of the ends and half of the middle; samples 49 and 50 lie about it.
        assert_eq!(curve.len(), 100);
        assert_eq!((curve[0], curve[99]), ([59.5, 0.5], [57.5, 1.5]));
        let t = 49.0 / 99.0;
        assert!((curve[49][1] - (0.5 + t * t)).abs() < 1e-12);
        assert_eq!(grid.smooth(&[(64, 124), (64, 123)]), [[59.5, 0.5], [58.5, 0.5]]);
    }

    #[test]
    fn a_way_leads_around_and_none_through_a_wall() {
        let mut grid = Grid::new(20, 1.0);
        for row in 0..19 {
            grid.block(row, 10, 0);
        }
        let way = grid.plan((2, 2), (2, 17)).unwrap();
        assert!(way.contains(&(19, 10)) && way.windows(2).all(|w| w[0] != w[1]));
        grid.block(19, 10, 0);
        assert_eq!(grid.plan((2, 2), (2, 17)), None);
        // Out of a blocked pixel there is a way, as the start is not looked at.
        grid.block(2, 2, 1);
        assert_eq!(grid.plan((2, 2), (8, 8)), None);
        grid.blocked[3 * 20 + 3] = false;
        assert!(grid.plan((2, 2), (8, 8)).is_some());
    }

    #[test]
    fn weights_of_high_degree_are_those_of_a_binomial_distribution() {
        // Mean n·t and variance n·t·(1 − t), at a degree at which plain powers underflow near the ends.
        let n = 400;
        for t in [0.0, 0.01, 0.3, 0.97, 1.0] {
            let weights = bernstein(n, t);
            let sum: f64 = weights.iter().sum();
            let moment = |f: &dyn Fn(f64) -> f64| {
                weights.iter().enumerate().map(|(i, w)| w / sum * f(i as f64)).sum::<f64>()
            };
            let mean = moment(&|i| i);
            assert!((mean - n as f64 * t).abs() < 1e-9, "{t}: {mean}");
            let variance = moment(&|i| (i - mean) * (i - mean));
            assert!((variance - n as f64 * t * (1.0 - t)).abs() < 1e-8, "{t}: {variance}");
        }
    }
}
