//! A map as a small picture.

use std::fmt::Write as _;

use vb_page::escape;

use super::WorldMap;

pub(super) fn of_world(map: &WorldMap<'_>, ground: &str, label: &str) -> String {
    let (x, y) = (map.world.heightfield.half_x(), map.world.heightfield.half_y());
    let mut s = format!(
        "<svg class=\"thumbnail\" viewBox=\"{:.2} {:.2} {:.2} {:.2}\" role=\"img\" aria-label=\"{}\"><image x=\"{:.2}\" y=\"{:.2}\" \
         width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\" href=\"{}\"/>",
        -x,
        -y,
        2.0 * x,
        2.0 * y,
        escape(label),
        -x,
        -y,
        2.0 * x,
        2.0 * y,
        escape(ground),
    );
    let radius = 0.045 * x.max(y);
    // Failures over successes: they are fewer where a planner is good, and what one looks for.
    for failed in [false, true] {
        for way in map.ways.iter().filter(|w| w.row.succeeded() != failed) {
            let Some(([x, y], known)) = way.end() else { continue };
            let outcome = way.row.outcome.index();
            let known = if known { " known" } else { "" };
            let _ = write!(
                s,
                "<circle class=\"end{known} e{outcome}\" cx=\"{x:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"/>",
                -y
            );
        }
    }
    s.push_str("</svg>");
    s
}
