//! How a run looks everywhere on the page and in files: its colour, its dashes and its marker.
//!
//! They go by the order in which the runs are given. Colours repeat after eight runs, dashes and markers after five, so no two
//! of forty runs look the same, and who sees no colours has the shapes. What the colours are is in `vb_page::TABLE_STYLE`, whose test holds
//! them apart for colour-blind eyes.

use std::fmt::Write as _;

use vb_page::{SERIES_COLOURS, escape};

use super::{TEXT, fit, width};

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

/// Units that [`draw_sample`] takes across.
const SAMPLE: f64 = 34.0;

/// A piece of a run's line with its marker, from `x` on and at the height `y`.
fn draw_sample(s: &mut String, run: usize, [x, y]: [f64; 2]) {
    let _ = write!(s, "<path class=\"{}\" d=\"M{:.1} {y:.1}h{:.1}\"/>", line(run), x + 1.0, SAMPLE - 2.0);
    marker(s, run, [x + 0.5 * SAMPLE, y], 4.4, "");
}

/// The same as a picture of the page, for legends and beside names.
pub(crate) fn sample(run: usize) -> String {
    let mut s = format!(
        "<svg class=\"sample\" viewBox=\"0 0 {SAMPLE} 12\" aria-hidden=\"true\" data-sample=\"{run}\">"
    );
    draw_sample(&mut s, run, [0.0, 6.0]);
    s.push_str("</svg>");
    s
}

/// What stands in a row of a key: how wide its sign is, and its name.
pub(crate) struct Entry<'a> {
    pub(crate) sign: f64,
    pub(crate) name: &'a str,
}

/// Signs with their names behind each other from `at` on, in as many rows as the width needs; `sign` draws the sign of an entry
/// whose left end and middle are given. Returns the height of the rows.
pub(crate) fn rows(
    s: &mut String,
    entries: &[Entry<'_>],
    at: [f64; 2],
    most: f64,
    sign: impl Fn(&mut String, usize, [f64; 2]),
) -> f64 {
    let (row, gap, between) = (17.0, 6.0, 16.0);
    let [mut x, mut y] = at;
    for (k, entry) in entries.iter().enumerate() {
        let name = fit(entry.name, TEXT, most - entry.sign - gap);
        let all = entry.sign + gap + width(&name, TEXT);
        if x > at[0] && x + all > at[0] + most {
            (x, y) = (at[0], y + row);
        }
        sign(s, k, [x, y + 0.5 * row]);
        let _ = write!(
            s,
            "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            x + entry.sign + gap,
            y + 0.5 * row + 4.2,
            escape(&name)
        );
        x += all + between;
    }
    if entries.is_empty() { 0.0 } else { y + row - at[1] }
}

/// A legend as a part of a drawing; returns its height.
pub(crate) fn draw_legend(s: &mut String, labels: &[&str], at: [f64; 2], most: f64) -> f64 {
    let entries: Vec<Entry<'_>> = labels.iter().map(|name| Entry { sign: SAMPLE, name }).collect();
    rows(s, &entries, at, most, draw_sample)
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
