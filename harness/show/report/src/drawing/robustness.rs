//! Success of planners against what they perceive.

use std::fmt::Write as _;

use vb_page::number;
use vb_page::plot::Frame;

use super::Drawing;
use super::series::{colour, line as series_line, marker};
use crate::Report;
use crate::figures::Measure;
use crate::robustness::Robustness;

/// How far the lines of planners stand apart, in distances between profiles.
const APART: f64 = 0.05;

/// The curves of all planners.
pub(crate) fn robustness(report: &Report, r: &Robustness, wide: f64) -> Drawing {
    let last = (r.profiles.len() - 1) as f64;
    let f = Frame {
        width: wide,
        height: 320.0,
        left: 52.0,
        right: 14.0,
        top: 10.0,
        bottom: 42.0,
        x: [-0.35, last + 0.35],
        y: [0.0, 100.0],
    };
    let mut body = String::new();
    let s = &mut body;
    f.y_axis(s, 5.0);
    let names: Vec<(f64, String)> =
        r.profiles.iter().enumerate().map(|(k, name)| (k as f64, name.clone())).collect();
    f.x_ticks(s, &names);
    let middle = (r.lines.len() as f64 - 1.0) / 2.0;
    for (k, line) in r.lines.iter().enumerate() {
        let aside = (k as f64 - middle) * APART;
        let mut path = String::new();
        let mut marks = String::new();
        for point in &line.points {
            let Some(e) = report.figures[point.run].all.mean(Measure::Success) else { continue };
            let shown = |v: f64| Measure::Success.shown(v);
            let (x, y) = (f.sx(point.profile as f64 + aside), f.sy(shown(e.mean)));
            let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "M" } else { "L" });
            if let Some(i) = e.interval {
                let _ = write!(
                    marks,
                    "<line class=\"range s{}\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>",
                    colour(k),
                    f.sy(shown(i.low)),
                    f.sy(shown(i.high))
                );
            }
            let title =
                format!("{}, {}: {} %", line.label, r.profiles[point.profile], number(shown(e.mean), 1));
            marker(&mut marks, k, [x, y], 4.4, &title);
        }
        let _ = write!(s, "<path class=\"{}\" d=\"{path}\"/>{marks}", series_line(k));
    }
    f.texts(s, "perception profile", "success, %");
    Drawing::new("Success against the perception profile", &f, body)
}
