//! Path of minimum cost over positions and headings.

use vb_sdk::search::Search;
use vb_sdk::{Point2, Task, math};

use crate::ground::{Ground, HEADINGS};

/// Cost of a turn by one heading, in metres.
const TURN: f32 = 0.5;

/// Points from start to goal; none without a path. A* over (row, column, heading): one move straight ahead, or one move
/// ahead and one in the adjacent heading, which approximates an arc within the steering limit.
pub(crate) fn route(task: &Task, ground: &Ground) -> Option<Vec<Point2>> {
    let frame = ground.frame;
    let n = HEADINGS.len();
    let place = |row: i32, col: i32, heading: usize| {
        (row as usize * frame.cols as usize + col as usize) * n + heading
    };
    let unplace = |i: usize| {
        let cell = i / n;
        ((cell / frame.cols as usize) as i32, (cell % frame.cols as usize) as i32, i % n)
    };
    let nearest = |x: f64, y: f64| {
        let (r, c) = frame.fractional(x, y);
        (
            ((r + 0.5) as i32).clamp(0, frame.rows as i32 - 1),
            ((c + 0.5) as i32).clamp(0, frame.cols as i32 - 1),
        )
    };
    let (row, col) = nearest(task.start.x, task.start.y);
    let (goal_row, goal_col) = nearest(task.goal.x, task.goal.y);
    let away = |row: i32, col: i32| {
        let (dr, dc) = ((row - goal_row) as f32, (col - goal_col) as f32);
        (dr * dr + dc * dc).sqrt()
    };
    let heading = (0..n).min_by(|&a, &b| {
        let off = |h: usize| {
            let (dx, dy) = HEADINGS[h];
            math::turn(task.start.yaw, math::atan2(f64::from(dy), f64::from(dx))).abs()
        };
        off(a).total_cmp(&off(b))
    })?;
    let mut search = Search::new((frame.rows * frame.cols) as usize * n);
    search.start(place(row, col, heading), away(row, col));
    while let Some(node) = search.pop() {
        let (row, col, heading) = unplace(node);
        if away(row, col) < 1.5 {
            let on_grid = |node: usize| {
                let (row, col, _) = unplace(node);
                let (x, y) = frame.position(row as u32, col as u32);
                Point2 { x, y }
            };
            let mut points = vec![Point2 { x: task.start.x, y: task.start.y }];
            points.extend(search.path(node).into_iter().map(on_grid));
            points.push(task.goal);
            return Some(points);
        }
        for turn in [0, 1, n - 1] {
            let next = (heading + turn) % n;
            let (mut r, mut c, mut step) = (row, col, 0.0);
            if turn != 0 {
                step += leg(ground, &mut r, &mut c, heading) + TURN;
            }
            step += leg(ground, &mut r, &mut c, next);
            if !step.is_finite() {
                continue;
            }
            search.offer(place(r, c, next), node, search.cost(node) + step, away(r, c));
        }
    }
    None
}

/// Moves by one step, and returns its cost.
fn leg(ground: &Ground, row: &mut i32, col: &mut i32, heading: usize) -> f32 {
    let (dx, dy) = HEADINGS[heading];
    let length = ((dx * dx + dy * dy) as f32).sqrt();
    // For a knight's move, the mean of the two cells next to its midpoint.
    let middle = if dx.abs() + dy.abs() == 3 {
        let (hx, hy) = (dx / 2, dy / 2);
        0.5 * (ground.cost(*row + hy, *col + hx, heading)
            + ground.cost(*row + dy - hy, *col + dx - hx, heading))
    } else {
        ground.cost(*row, *col, heading)
    };
    (*row, *col) = (*row + dy, *col + dx);
    length * 0.5 * (middle + ground.cost(*row, *col, heading))
}
