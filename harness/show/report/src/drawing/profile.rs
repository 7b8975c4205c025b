//! Performance profiles by traversal time.

use std::fmt::Write as _;

use vb_page::escape;
use vb_page::plot::Frame;

use super::Drawing;
use super::series::{line, marker};
use crate::{Comparison, Report};

/// The profiles of all runs; none if there is no task that all have done.
pub(crate) fn profile(report: &Report, c: &Comparison, wide: f64) -> Option<Drawing> {
    if c.profile_tasks == 0 {
        return None;
    }
    let last = c.profiles.iter().filter_map(|p| p.steps.last()).map(|l| l[0]).fold(1.0, f64::max);
    // On a logarithmic axis, up to where all have risen or four times the best.
    let end = (1.05 * last).clamp(1.2, 4.0);
    let f = Frame {
        width: wide,
        height: 280.0,
        left: 52.0,
        right: 14.0,
        top: 10.0,
        bottom: 42.0,
        x: [0.0, vb_math::ln(end)],
        y: [0.0, 100.0],
    };
    let mut body = String::new();
    let s = &mut body;
    f.y_axis(s, 5.0);
    let marks: Vec<_> = [1.0, 1.1, 1.2, 1.5, 2.0, 3.0, 4.0]
        .into_iter()
        .filter(|t| *t <= end && (end < 2.2 || *t != 1.1))
        .map(|t: f64| (vb_math::ln(t), if t.fract() == 0.0 { format!("{t:.0}") } else { format!("{t}") }))
        .collect();
    f.x_ticks(s, &marks);
    for (k, p) in c.profiles.iter().enumerate() {
        let mut y = f.sy(100.0 * p.at(1.0));
        let mut d = format!("M{:.1} {y:.1}", f.sx(0.0));
        for [factor, fraction] in p.steps.iter().filter(|st| st[0] > 1.0 && st[0] <= end) {
            let next = f.sy(100.0 * fraction);
            // Thousands of tiny steps are one line to the eye.
            if (y - next).abs() >= 0.3 {
                let _ = write!(d, "H{:.1}V{next:.1}", f.sx(vb_math::ln(*factor)));
                y = next;
            }
        }
        let _ = write!(d, "H{:.1}", f.sx(f.x[1]));
        let _ = write!(
            s,
            "<path class=\"{}\" d=\"{d}\"><title>{}</title></path>",
            line(k),
            escape(&report.runs.runs[k].label)
        );
        // Markers of several lines stand apart along the axis, also where the lines lie on each other.
        let at = vb_math::exp(f.x[1] * (k as f64 + 0.5) / c.profiles.len() as f64);
        marker(s, k, [f.sx(vb_math::ln(at)), f.sy(100.0 * p.at(at))], 4.2, "");
    }
    f.texts(s, "times the best planner's time", &format!("% of {} tasks", c.profile_tasks));
    Some(Drawing::new("Performance profile by traversal time", &f, body))
}
