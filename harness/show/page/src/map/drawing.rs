//! A world as SVG in metres: pictures of the ground, footprints, paths, starts and goals.

use crate::escape;
use crate::map::picture::Sources;
use std::fmt::Write as _;
use vb_math::{hypot, sin_cos};
use vb_world::{ObstacleKind, Task, World};

/// How far waypoints may lie from the drawn line, m: less than one sees.
const FLAT: f64 = 0.02;

/// A world's map, north up, with SVG in metres `over` its tasks. y is turned, since SVG counts downwards. The ground is shown by
/// `pictures`.
#[must_use]
pub fn map(world: &World, pictures: &Sources, over: &str) -> String {
    let (x, y) = (world.heightfield.half_x(), world.heightfield.half_y());
    // Sizes of signs in metres on the original's worlds, and in proportion on others.
    let unit = x.max(y) / 64.0;
    let mut s = String::new();
    let _ = write!(
        s,
        "<svg class=\"map\" viewBox=\"{:.3} {:.3} {:.3} {:.3}\" style=\"--u:{unit:.4}px\" role=\"img\" \
         aria-label=\"Map of {}\">",
        -x,
        -y,
        2.0 * x,
        2.0 * y,
        escape(&world.id),
    );
    for (layer, source) in pictures.each() {
        let kind = if layer == "shade" { "" } else { "layer " };
        let _ = write!(
            s,
            "<image class=\"{kind}{layer}\" x=\"{:.3}\" y=\"{:.3}\" width=\"{:.3}\" height=\"{:.3}\" preserveAspectRatio=\"none\" \
             href=\"{}\"/>",
            -x,
            -y,
            2.0 * x,
            2.0 * y,
            escape(source),
        );
    }
    obstacles(&mut s, world);
    s.push_str("<g class=\"tasks\">");
    // Lines first: no path runs over the sign of a start.
    for task in &world.tasks {
        let line = line(&task.path);
        let id = escape(&task.id);
        let _ = write!(
            s,
            "<g data-task=\"{id}\"><path class=\"casing\" d=\"{line}\"/><path class=\"line\" d=\"{line}\"/></g>"
        );
    }
    for task in &world.tasks {
        ends(&mut s, task, [x, y], unit);
    }
    s.push_str("</g>");
    s.push_str(over);
    scale_bar(&mut s, x, y, unit);
    s.push_str("</svg>");
    s
}

fn obstacles(s: &mut String, world: &World) {
    let outlines = |trunks: bool| {
        let mut d = String::new();
        let chosen =
            world.obstacles.iter().filter(|o| matches!(o.kind, ObstacleKind::Trunk { .. }) == trunks);
        for o in chosen {
            d.push_str(&polygon(&o.footprint()));
        }
        d
    };
    let _ = write!(
        s,
        "<g class=\"obstacles\"><path class=\"boulder\" d=\"{}\"/><path class=\"trunk\" d=\"{}\"/></g>",
        outlines(false),
        outlines(true)
    );
}

/// Start, goal and name of a task. `half` is the half extent of the map.
fn ends(s: &mut String, task: &Task, half: [f64; 2], unit: f64) {
    let ([x, y], (sin, cos)) = ([task.start.x, task.start.y], sin_cos(task.start.yaw));
    let at = |ahead: f64, left: f64| {
        [x + unit * (ahead * cos - left * sin), y + unit * (ahead * sin + left * cos)]
    };
    let arrow = polygon(&[at(2.6, 0.0), at(-1.4, 1.4), at(-0.7, 0.0), at(-1.4, -1.4)]);
    // The name stands beside the way to the goal, where no path runs; a line of text is wider than high.
    let [dx, dy] = [task.goal[0] - x, task.goal[1] - y];
    let along = hypot(dx, dy).max(1e-9);
    let name = [
        within(x - 5.4 * unit * dy / along, half[0] - 4.0 * unit),
        within(y + 4.0 * unit * dx / along, half[1] - 2.5 * unit),
    ];
    let id = escape(&task.id);
    let _ = write!(
        s,
        "<g data-task=\"{id}\"><circle class=\"goal\" cx=\"{:.2}\" cy=\"{:.2}\" r=\"{:.2}\"/><path class=\"start\" d=\"{arrow}\"/>\
         <text x=\"{:.2}\" y=\"{:.2}\">{id}</text></g>",
        task.goal[0],
        -task.goal[1],
        1.9 * unit,
        name[0],
        -name[1],
    );
}

/// The value in [-limit, limit]; 0 on a map too narrow for that.
fn within(value: f64, limit: f64) -> f64 {
    let limit = limit.max(0.0);
    value.clamp(-limit, limit)
}

/// A round length of about a sixth of the side of a map with this half extent, m.
#[must_use]
pub fn bar_length(half: f64) -> f64 {
    let mut length = 1e-3;
    let steps = [2.0, 2.5, 2.0];
    for step in steps.iter().cycle() {
        if length * step > half / 3.0 {
            break;
        }
        length *= step;
    }
    length
}

fn scale_bar(s: &mut String, x: f64, y: f64, unit: f64) {
    let length = bar_length(x);
    let (left, base) = (-x + 4.0 * unit, y - 4.0 * unit);
    let _ = write!(
        s,
        "<g class=\"bar\"><path d=\"M{left:.2} {:.2}v{:.2}h{length:.3}v{:.2}\"/><text x=\"{:.2}\" y=\"{:.2}\">{} m</text></g>",
        base - 1.6 * unit,
        1.6 * unit,
        -1.6 * unit,
        left + 0.5 * length,
        base - 3.6 * unit,
        (length * 1000.0).round() / 1000.0,
    );
}

fn polygon(outline: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (k, p) in outline.iter().enumerate() {
        let _ = write!(d, "{}{:.2} {:.2}", if k == 0 { 'M' } else { 'L' }, p[0], -p[1]);
    }
    d.push('Z');
    d
}

/// A path as the commands of an SVG path, without the waypoints that lie on the line.
#[must_use]
pub fn line(path: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (k, p) in simplified(path, FLAT).iter().enumerate() {
        let _ = write!(d, "{}{:.2} {:.2}", if k == 0 { 'M' } else { 'L' }, p[0], -p[1]);
    }
    d
}

/// The first and the last point, and between them those that keep every point within `flat` (m) of the line.
#[must_use]
pub fn simplified(path: &[[f64; 2]], flat: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = path.first().copied().into_iter().collect();
    let mut from = 0;
    while from + 1 < path.len() {
        let straight = |to: usize| {
            path[from + 1..to]
                .iter()
                .all(|&p| vb_world::geometry::point_to_segment(p, path[from], path[to]) <= flat)
        };
        let mut to = from + 1;
        while to + 1 < path.len() && straight(to + 1) {
            to += 1;
        }
        kept.push(path[to]);
        from = to;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_has_a_round_length() {
        let lengths = [64.0, 32.0, 6.0].map(bar_length);
        // At most a third of the half extent: of 1, 2 and 5 times a power of ten the longest.
        for (length, wanted) in lengths.iter().zip([20.0, 10.0, 2.0]) {
            assert!((length - wanted).abs() < 1e-9, "{length} {wanted}");
        }
    }

    #[test]
    fn a_drawn_path_has_its_corners_and_nothing_between() {
        let mut path: Vec<[f64; 2]> = (0..=60).map(|k| [f64::from(k), 0.0]).collect();
        path.extend((1..=30).map(|k| [60.0, f64::from(k)]));
        assert_eq!(simplified(&path, FLAT), [[0.0, 0.0], [60.0, 0.0], [60.0, 30.0]]);
        assert_eq!(line(&path), "M0.00 -0.00L60.00 -0.00L60.00 -30.00");
        assert_eq!(simplified(&path[..1], FLAT), [[0.0, 0.0]]);
        assert!(simplified(&[], FLAT).is_empty());
    }
}
