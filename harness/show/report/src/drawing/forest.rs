//! Differences with their intervals, a row a pair.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, grouped, signed};

use super::series::{colour, marker};
use super::{Drawing, TEXT, fit, width};
use crate::figures::Measure;
use crate::ranking::Ranking;
use crate::{Comparison, Report};

/// The differences of one measure; none without any.
pub(crate) fn forest(
    report: &Report,
    c: &Comparison,
    ranking: &Ranking,
    measure: Measure,
    wide: f64,
) -> Option<Drawing> {
    let found: Vec<_> = ranking
        .lines()
        .into_iter()
        .filter_map(|(x, y)| Some((x, y, c.between(x, y, measure)?)))
        .filter_map(|(x, y, d)| Some((x, y, d.difference?, d)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let ends = found.iter().flat_map(|(_, _, e, _)| {
        let i = e.interval;
        [e.mean, i.map_or(e.mean, |i| i.low), i.map_or(e.mean, |i| i.high)]
    });
    let widest = ends.map(|v| measure.shown(v).abs()).fold(1e-3, f64::max) * 1.1;
    let row = 34.0;
    let f = Frame {
        width: wide,
        height: 12.0 + row * found.len() as f64 + 40.0,
        left: 14.0,
        right: 14.0,
        top: 8.0,
        bottom: 40.0,
        x: [-widest, widest],
        y: [0.0, 1.0],
    };
    let mut body = String::new();
    let s = &mut body;
    let (zero, base) = (f.sx(0.0), f.height - f.bottom);
    let good = if measure.more_is_better() { zero } else { f.left };
    let _ = write!(
        s,
        "<rect class=\"good\" x=\"{good:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
        f.top,
        zero - f.left,
        base - f.top
    );
    f.x_axis(s, 6.0);
    let _ = write!(
        s,
        "<line class=\"zero\" x1=\"{zero:.1}\" x2=\"{zero:.1}\" y1=\"{:.1}\" y2=\"{base:.1}\"/>",
        f.top
    );
    for (k, (x, y, e, d)) in found.iter().enumerate() {
        let at = f.top + row * (k as f64 + 0.7);
        let word = d.short();
        // Both names have the room that the word leaves them; who needs less leaves the rest to the other.
        let [x_name, y_name] = [*x, *y].map(|run| report.runs.runs[run].label.as_str());
        let room = f.width - f.left - f.right - width(" − ", TEXT) - width(&word, TEXT) - 10.0;
        let x_room = room - width(y_name, TEXT).min(0.5 * room);
        let x_name = fit(x_name, TEXT, x_room);
        let y_name = fit(y_name, TEXT, room - width(&x_name, TEXT));
        let _ = write!(
            s,
            "<text class=\"pair {class}\" x=\"{:.1}\" y=\"{y:.1}\">{} − {}</text><text class=\"pair {class}\" x=\"{:.1}\" y=\"{y:.1}\" \
             text-anchor=\"end\">{word}</text>",
            f.left,
            escape(&x_name),
            escape(&y_name),
            f.width - f.right,
            class = d.class(),
            y = at - 9.0,
        );
        let shown = |v: f64| measure.shown(v);
        if let Some(i) = e.interval {
            let _ = write!(
                s,
                "<line class=\"range s{}\" x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>",
                colour(*x),
                f.sx(shown(i.low)),
                f.sx(shown(i.high))
            );
        }
        let told = format!(
            "{} {} ({}), {} tasks; {}",
            signed(shown(e.mean), 2),
            measure.difference_unit(),
            d.interval(),
            grouped(d.tasks),
            d.told()
        );
        marker(s, *x, [f.sx(shown(e.mean)), at], 4.2, &told);
    }
    let (unit, meaning) = match measure {
        Measure::Success => ("points", "right: higher success of the first planner"),
        Measure::Time => ("s", "left: lower time of the first planner"),
        Measure::Roll | Measure::Pitch => ("degrees", "left: lower tilt of the first planner"),
    };
    let whole = format!("{unit} ({meaning})");
    f.texts(s, if width(&whole, TEXT) <= wide { &whole } else { unit }, "");
    Some(Drawing::new(format!("Difference of {}", measure.name()), &f, body))
}
