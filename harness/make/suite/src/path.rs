//! The global planner: a short, collision-free path from start to goal.
//!
//! A* on a regular grid with true step costs finds a path around the obstacles; then the shortest chain of straight
//! lines through its points that keeps the clearance replaces it, twice, so that the path is taut and any-angle.
//! Elevation and terrain class are ignored, as in the original's planner; finding a path over the terrain is the task
//! of the planner under test.

use serde::Deserialize;
use vb_math::hypot;
use vb_math::search::Search;
use vb_world::{Obstacle, World, geometry};

/// The parameters of the global planner. Lengths are at scale 1 and are multiplied by [`World::scale`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathParams {
    /// The minimum distance from the path to any obstacle, m.
    pub clearance: f64,
    /// The resolution of the search grid, m.
    pub grid: f64,
    /// The maximum distance between waypoints, m.
    pub spacing: f64,
}

impl Default for PathParams {
    /// Clearance 3.5 m, the median over the original's paths, which come as close as 1.99 m (docs/worlds.md): half the
    /// width of the HMMWV (1.05 m) and room for a planner that cuts corners.
    fn default() -> Self {
        Self { clearance: 3.5, grid: 0.5, spacing: 1.0 }
    }
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    #[error("path.{field}: {value} must be a {wanted} length in metres")]
    Parameter { field: &'static str, value: f64, wanted: &'static str },
    #[error(
        "{end} {point:?} is {distance:.2} m from obstacles[{obstacle}], less than the clearance of {clearance} m: move one of them"
    )]
    TooClose {
        /// The end that is meant: `start` or `goal`.
        end: &'static str,
        /// The place (x, y) of that end, m.
        point: [f64; 2],
        obstacle: usize,
        /// The distance from the obstacle, m.
        distance: f64,
        /// The clearance that is wanted, m.
        clearance: f64,
    },
    #[error("{end} {point:?} lies outside the world")]
    Outside {
        /// The end that is meant: `start` or `goal`.
        end: &'static str,
        /// The place (x, y) of that end, m.
        point: [f64; 2],
    },
    #[error(
        "no path from {start:?} to {goal:?} has a clearance of {clearance} m from obstacles: move obstacles or lower the clearance"
    )]
    NoWay {
        /// The start (x, y), m.
        start: [f64; 2],
        /// The goal (x, y), m.
        goal: [f64; 2],
        /// The clearance that is wanted, m.
        clearance: f64,
    },
}

/// Plans a path from start to goal, as (x, y) waypoints in metres, for a single query; see [`Planner`].
pub fn plan(
    world: &World,
    start: [f64; 2],
    goal: [f64; 2],
    params: &PathParams,
) -> Result<Vec<[f64; 2]>, PathError> {
    Planner::new(world, params)?.plan(start, goal)
}

/// The length of a polyline, m.
#[must_use]
pub fn length(path: &[[f64; 2]]) -> f64 {
    path.windows(2).map(|w| distance(w[0], w[1])).sum()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    hypot(a[0] - b[0], a[1] - b[1])
}

struct Body {
    outline: Vec<[f64; 2]>,
    centre: [f64; 2],
    radius: f64,
}

/// A global planner for one world: the obstacles' clearance field is computed once for all of its tasks.
pub struct Planner {
    bodies: Vec<Body>,
    half: [f64; 2],
    scale: f64,
    clearance: f64,
    spacing: f64,
    resolution: f64,
    rows: usize,
    cols: usize,
    /// Distance from each grid node to the nearest obstacle where it may matter, else infinite, m.
    field: Vec<f64>,
}

impl Planner {
    /// Prepares to plan in a world.
    pub fn new(world: &World, params: &PathParams) -> Result<Self, PathError> {
        let wanted = |field, value: f64, low: f64, wanted| {
            if value.is_finite() && value >= low {
                Ok(())
            } else {
                Err(PathError::Parameter { field, value, wanted })
            }
        };
        wanted("clearance", params.clearance, 0.0, "non-negative")?;
        wanted("grid", params.grid, 0.01, "positive (at least 0.01)")?;
        wanted("spacing", params.spacing, 0.01, "positive (at least 0.01)")?;
        let scale = world.scale;
        let half = [world.heightfield.half_x(), world.heightfield.half_y()];
        let resolution = params.grid * scale;
        let count = |h: f64| (2.0 * h / resolution + 1e-9) as usize + 1;
        let (cols, rows) = (count(half[0]), count(half[1]));
        let bodies = world.obstacles.iter().map(body).collect();
        let mut planner = Self {
            bodies,
            half,
            scale,
            clearance: params.clearance * scale,
            spacing: params.spacing * scale,
            resolution,
            rows,
            cols,
            field: vec![f64::INFINITY; rows * cols],
        };
        planner.fill_field();
        Ok(planner)
    }

    fn fill_field(&mut self) {
        // An edge is at most √2 cells long: beyond clearance + one edge an obstacle cannot matter.
        let reach = self.clearance + 1.5 * self.resolution;
        for body in &self.bodies {
            let span = |axis: usize, n: usize| {
                let index = |v: f64| ((v + self.half[axis]) / self.resolution).max(0.0) as usize;
                let far = body.radius + reach;
                index(body.centre[axis] - far)..(index(body.centre[axis] + far) + 2).min(n)
            };
            for row in span(1, self.rows) {
                for col in span(0, self.cols) {
                    let node = row * self.cols + col;
                    let p = [
                        col as f64 * self.resolution - self.half[0],
                        row as f64 * self.resolution - self.half[1],
                    ];
                    self.field[node] = self.field[node].min(geometry::point_to_polygon(p, &body.outline));
                }
            }
        }
    }

    /// Plans a path from start to goal, as (x, y) waypoints in metres: the first is the start, the last the goal; they
    /// are no farther apart than the spacing, and the inner ones are rounded to millimetres. No point of the path is
    /// closer to an obstacle than the clearance, but for that rounding.
    ///
    /// # Errors
    /// Returns an error if start or goal lies outside or too close to an obstacle, or there is no path.
    pub fn plan(&self, start: [f64; 2], goal: [f64; 2]) -> Result<Vec<[f64; 2]>, PathError> {
        let mut margin = self.clearance;
        for (end, p) in [("start", start), ("goal", goal)] {
            let to_edge = (self.half[0] - p[0].abs()).min(self.half[1] - p[1].abs());
            if !(p[0].is_finite() && p[1].is_finite()) || to_edge < 0.0 {
                return Err(PathError::Outside { end, point: p });
            }
            margin = margin.min(to_edge);
            for (obstacle, body) in self.bodies.iter().enumerate() {
                let distance = geometry::point_to_polygon(p, &body.outline);
                if distance < self.clearance {
                    let clearance = self.clearance;
                    return Err(PathError::TooClose { end, point: p, obstacle, distance, clearance });
                }
            }
        }
        let no_way = PathError::NoWay { start, goal, clearance: self.clearance };
        let coarse = self.search(start, goal, margin).ok_or(no_way)?;
        let taut = self.pull(&self.subdivide(&self.pull(&coarse)));
        let mut path = self.subdivide(&taut);
        let inner = 1..path.len() - 1;
        for p in &mut path[inner] {
            *p = p.map(|v| (v / self.scale * 1000.0).round() / 1000.0 * self.scale);
        }
        Ok(path)
    }

    /// Whether the straight line keeps the clearance.
    fn sees(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        self.bodies.iter().all(|body| {
            geometry::point_to_segment(body.centre, a, b) >= body.radius + self.clearance
                || geometry::segment_to_polygon(a, b, &body.outline) >= self.clearance
        })
    }

    fn node(&self, index: usize) -> [f64; 2] {
        let (row, col) = (index / self.cols, index % self.cols);
        [col as f64 * self.resolution - self.half[0], row as f64 * self.resolution - self.half[1]]
    }

    /// A* over the grid nodes, with start and goal as two more nodes that join the nodes of the cells around them.
    /// The heuristic is the straight distance, which never exceeds the cost of any chain of steps.
    fn search(&self, start: [f64; 2], goal: [f64; 2], margin: f64) -> Option<Vec<[f64; 2]>> {
        if self.sees(start, goal) {
            return Some(vec![start, goal]);
        }
        let count = self.rows * self.cols;
        let (first, last) = (count, count + 1);
        let place = |n: usize| {
            if n == first {
                start
            } else if n == last {
                goal
            } else {
                self.node(n)
            }
        };
        let inside = |p: [f64; 2]| {
            p[0].abs() <= self.half[0] - margin + 1e-9 && p[1].abs() <= self.half[1] - margin + 1e-9
        };
        let mut search = Search::new(count + 2);
        search.start(first, distance(start, goal));
        while let Some(node) = search.pop() {
            if node == last {
                return Some(search.path(last).into_iter().map(place).collect());
            }
            let here = place(node);
            let mut relax = |next: usize, free: &dyn Fn(f64) -> bool| {
                let there = place(next);
                let step = distance(here, there);
                let cost = search.cost(node) + step;
                if search.improves(next, cost) && inside(there) && free(step) {
                    search.offer(next, node, cost, distance(there, goal));
                }
            };
            if node == first {
                for next in self.around(start) {
                    relax(next, &|_| self.sees(start, place(next)));
                }
                continue;
            }
            let (row, col) = (node / self.cols, node % self.cols);
            for (dr, dc) in [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)] {
                let (Some(r), Some(c)) = (row.checked_add_signed(dr), col.checked_add_signed(dc)) else {
                    continue;
                };
                if r < self.rows && c < self.cols {
                    let next = r * self.cols + c;
                    relax(next, &|step| self.step_is_free(node, next, step));
                }
            }
            if distance(here, goal) < 2.0 * self.resolution {
                relax(last, &|_| self.sees(here, goal));
            }
        }
        None
    }

    /// Whether the step between two neighbours keeps the clearance: by the field where that decides it (distance
    /// changes no faster than one moves), else exactly.
    fn step_is_free(&self, a: usize, b: usize, step: f64) -> bool {
        let (da, db) = (self.field[a], self.field[b]);
        if da.min(db) < self.clearance {
            return false;
        }
        0.5 * (da + db - step) >= self.clearance || self.sees(self.node(a), self.node(b))
    }

    /// The grid nodes of the 4 × 4 block about a point.
    fn around(&self, p: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        let low = |v: f64, h: f64| ((v + h) / self.resolution) as usize;
        let (col, row) = (low(p[0], self.half[0]), low(p[1], self.half[1]));
        let rows = row.saturating_sub(1)..(row + 3).min(self.rows);
        rows.flat_map(move |r| {
            (col.saturating_sub(1)..(col + 3).min(self.cols)).map(move |c| r * self.cols + c)
        })
    }

    /// The shortest chain of straight lines that leads from the first to the last point through points in order.
    fn pull(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let n = points.len();
        let mut cost = vec![f64::INFINITY; n];
        let mut next = vec![n; n];
        cost[n - 1] = 0.0;
        for i in (0..n - 1).rev() {
            for j in i + 1..n {
                let c = distance(points[i], points[j]) + cost[j];
                // The step to the neighbour is part of a path that is known to be free.
                if c < cost[i] - 1e-9 * self.scale && (j == i + 1 || self.sees(points[i], points[j])) {
                    (cost[i], next[i]) = (c, j);
                }
            }
        }
        let mut chain = vec![points[0]];
        let mut i = 0;
        while i < n - 1 {
            i = next[i];
            chain.push(points[i]);
        }
        chain
    }

    /// The same polyline with pieces no longer than the spacing.
    fn subdivide(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut out = vec![points[0]];
        for w in points.windows(2) {
            // A hair less, so that 60 m at 1 m give 60 pieces and not 61 by rounding.
            let pieces = (distance(w[0], w[1]) / self.spacing - 1e-6).ceil().max(1.0) as usize;
            for k in 1..pieces {
                let t = k as f64 / pieces as f64;
                out.push([w[0][0] + t * (w[1][0] - w[0][0]), w[0][1] + t * (w[1][1] - w[0][1])]);
            }
            out.push(w[1]);
        }
        out
    }
}

fn body(obstacle: &Obstacle) -> Body {
    let outline = obstacle.footprint();
    let centre = [obstacle.x, obstacle.y];
    let radius = outline.iter().map(|&p| distance(p, centre)).fold(0.0, f64::max);
    Body { outline, centre, radius }
}
