//! The way of least cost over places and headings.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use vb_sdk::{Point2, Task, math};

use crate::ground::{Ground, HEADINGS};

/// Cost of a turn by one heading, in metres.
const TURN: f32 = 0.5;

/// Points from start to goal, if there is a way. A* over (row, column, heading): straight on by one move, or on by one
/// and by another in the next heading, which is an arc that a car can drive.
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
    let count = (frame.rows * frame.cols) as usize * n;
    let mut cost = vec![f32::INFINITY; count];
    let mut parent = vec![u32::MAX; count];
    let mut closed = vec![false; count];
    let first = place(row, col, heading);
    cost[first] = 0.0;
    let mut open = BinaryHeap::from([Open { estimate: away(row, col), node: first }]);
    while let Some(Open { node, .. }) = open.pop() {
        if std::mem::replace(&mut closed[node], true) {
            continue;
        }
        let (row, col, heading) = unplace(node);
        if away(row, col) < 1.5 {
            let mut points = vec![task.goal];
            let mut at = node;
            loop {
                let (row, col, _) = unplace(at);
                let (x, y) = frame.position(row as u32, col as u32);
                points.push(Point2 { x, y });
                if at == first {
                    break;
                }
                at = parent[at] as usize;
            }
            points.push(Point2 { x: task.start.x, y: task.start.y });
            points.reverse();
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
            let there = place(r, c, next);
            let total = cost[node] + step;
            if !closed[there] && total < cost[there] {
                cost[there] = total;
                parent[there] = node as u32;
                open.push(Open { estimate: total + away(r, c), node: there });
            }
        }
    }
    None
}

/// Goes on by one move; its cost.
fn leg(ground: &Ground, row: &mut i32, col: &mut i32, heading: usize) -> f32 {
    let (dx, dy) = HEADINGS[heading];
    let length = ((dx * dx + dy * dy) as f32).sqrt();
    // Of a knight's move the places beside its middle.
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

/// An entry of the open list: the least estimate is the greatest, ties go to the smaller node.
#[derive(PartialEq)]
struct Open {
    estimate: f32,
    node: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.estimate.total_cmp(&self.estimate).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
