//! How a run looks everywhere on the page: its colour, its dashes and its marker.
//!
//! They go by the order in which the runs are given. Colours repeat after eight runs, dashes and markers after five, so no two
//! of forty runs look the same, and who sees no colours has the shapes. What the colours are is in `vb_page::TABLE_STYLE`, whose test holds
//! them apart for colour-blind eyes.

use std::fmt::Write as _;

use vb_page::{SERIES_COLOURS, escape};

/// Number of dash patterns that the page's style has, and of markers below.
const SHAPES: usize = 5;

/// The number of a run's colour in the page's style.
pub(crate) fn colour(run: usize) -> usize {
    run % SERIES_COLOURS
}

/// The classes of a line that belongs to a run.
pub(crate) fn line(run: usize) -> String {
    format!("line s{} d{}", colour(run), run % SHAPES)
}

/// A run's marker with its middle at (x, y) and about this radius, and with a text that shows under the pointer if it is not
/// empty.
pub(crate) fn marker(s: &mut String, run: usize, [x, y]: [f64; 2], radius: f64, title: &str) {
    let r = radius;
    let d = match run % SHAPES {
        0 => format!(
            "M{:.1} {y:.1}a{r:.1} {r:.1} 0 1 0 {:.1} 0a{r:.1} {r:.1} 0 1 0 {:.1} 0Z",
            x - r,
            2.0 * r,
            -2.0 * r
        ),
        1 => {
            let h = 0.9 * r;
            format!("M{:.1} {:.1}h{:.1}v{:.1}h{:.1}Z", x - h, y - h, 2.0 * h, 2.0 * h, -2.0 * h)
        }
        2 => format!("M{x:.1} {:.1}l{:.1} {:.1}h{:.1}Z", y - 1.2 * r, 1.2 * r, 2.1 * r, -2.4 * r),
        3 => {
            let h = 1.3 * r;
            format!("M{x:.1} {:.1}l{h:.1} {h:.1}l{:.1} {h:.1}l{:.1} {:.1}Z", y - h, -h, -h, -h)
        }
        _ => format!("M{x:.1} {:.1}l{:.1} {:.1}h{:.1}Z", y + 1.2 * r, 1.2 * r, -2.1 * r, -2.4 * r),
    };
    let _ = write!(s, "<path class=\"mark f{}\" d=\"{d}\"", colour(run));
    if title.is_empty() {
        s.push_str("/>");
    } else {
        let _ = write!(s, "><title>{}</title></path>", escape(title));
    }
}

/// A piece of a run's line with its marker, for legends and beside names.
pub(crate) fn sample(run: usize) -> String {
    let mut s = format!(
        "<svg class=\"sample\" viewBox=\"0 0 34 12\" aria-hidden=\"true\" data-sample=\"{run}\"><path class=\"{}\" d=\"M1 6H33\"/>",
        line(run)
    );
    marker(&mut s, run, [17.0, 6.0], 4.4, "");
    s.push_str("</svg>");
    s
}

/// Names with their samples.
pub(crate) fn legend<'a>(s: &mut String, labels: impl IntoIterator<Item = &'a str>) {
    s.push_str("<ul class=\"legend\">");
    for (run, label) in labels.into_iter().enumerate() {
        let _ = write!(s, "<li>{}{}</li>", sample(run), escape(label));
    }
    s.push_str("</ul>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_of_forty_runs_look_the_same() {
        let look = |run: usize| {
            let mut s = String::new();
            marker(&mut s, run, [0.0, 0.0], 4.0, "");
            (line(run), s)
        };
        let all: std::collections::BTreeSet<_> = (0..40).map(look).collect();
        assert_eq!(all.len(), 40);
        // A line and a marker say it each, and neighbours have both another colour and another shape.
        let lines: std::collections::BTreeSet<_> = (0..40).map(line).collect();
        assert_eq!(lines.len(), 40);
        assert!((0..39).all(|k| colour(k) != colour(k + 1) && k % SHAPES != (k + 1) % SHAPES));
    }
}
