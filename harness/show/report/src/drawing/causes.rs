//! Why tasks fail: a bar a run, of parts by what stopped the vehicle.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{SERIES_COLOURS, escape, number};

use super::series::{Entry, rows};
use super::{Drawing, TEXT, fit, width};
use crate::Report;
use crate::failures::{Failure, Group, failures, groups};
use crate::figures::Figures;

/// Parts that have a colour of their own; those behind them are one.
const PARTS: usize = SERIES_COLOURS - 1;

struct Part {
    name: String,
    of: Vec<Failure>,
}

/// The parts: the most frequent failures, and all others as one.
fn parts(report: &Report) -> Vec<Part> {
    let mut all = failures(report);
    let total = |f: &Failure| report.figures.iter().map(|own| f.count(&own.all)).sum::<u64>();
    all.sort_by_key(|f| std::cmp::Reverse(total(f)));
    let one = |f: &Failure| Part { name: f.title(), of: vec![*f] };
    if all.len() <= PARTS + 1 {
        return all.iter().map(one).collect();
    }
    let (own, rest) = all.split_at(PARTS);
    let others = Part { name: format!("{} other causes", rest.len()), of: rest.to_vec() };
    own.iter().map(one).chain([others]).collect()
}

/// The letter of a part, for those who see no colours.
fn letter(part: usize) -> char {
    char::from(b'a' + (part % 26) as u8)
}

/// A part's letter with its middle at (x, y), on a ground of its own, since no letter is legible on all colours.
fn sign(s: &mut String, part: usize, [x, y]: [f64; 2]) {
    let _ = write!(
        s,
        "<rect class=\"ground\" x=\"{:.1}\" y=\"{:.1}\" width=\"10\" height=\"11\" rx=\"2\"/><text class=\"letter\" x=\"{x:.1}\" \
         y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        x - 5.0,
        y - 5.5,
        y + 3.4,
        letter(part)
    );
}

/// The bars; none if no task failed.
pub(crate) fn causes(report: &Report, wide: f64) -> Option<Drawing> {
    let (parts, groups) = (parts(report), groups(report));
    if parts.is_empty() {
        return None;
    }
    let share = |n: u64, tasks: u64| 100.0 * n as f64 / tasks.max(1) as f64;
    let count = |part: &Part, figures: &Figures| part.of.iter().map(|f| f.count(figures)).sum::<u64>();
    let failed = |g: &Group<'_>| share(parts.iter().map(|p| count(p, g.figures)).sum(), g.figures.tasks);
    let names: Vec<String> = groups
        .iter()
        .map(|g| match g.split {
            Some(split) => format!("{}: {}", split.name(), g.name),
            None => g.name.clone(),
        })
        .collect();
    let total = |g: &Group<'_>| format!("{}\u{2009}%", number(failed(g), 1));
    let widest = names.iter().map(|n| width(n, TEXT)).fold(0.0, f64::max);
    let left = 10.0 + widest.min(0.36 * wide);
    let ends = groups.iter().map(|g| width(&total(g), TEXT)).fold(0.0, f64::max);
    let (row, top) = (23.0, 4.0);
    let plot = row * groups.len() as f64;
    let longest = groups.iter().map(failed).fold(1e-9, f64::max);
    let mut f = Frame {
        width: wide,
        height: top + plot + 42.0,
        left,
        right: 12.0 + ends,
        top,
        bottom: 42.0,
        x: [0.0, longest],
        y: [0.0, 1.0],
    };
    let mut s = String::new();
    f.x_axis(&mut s, ((wide - left) / 60.0).clamp(2.0, 6.0));
    for (k, (g, name)) in groups.iter().zip(&names).enumerate() {
        let y = top + row * k as f64;
        let _ = write!(
            s,
            "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 8.0,
            y + 0.5 * row + 4.2,
            escape(&fit(name, TEXT, left - 10.0))
        );
        let mut from = 0;
        for (p, part) in parts.iter().enumerate() {
            let n = count(part, g.figures);
            if n == 0 {
                continue;
            }
            let [x0, x1] = [from, from + n].map(|v| f.sx(share(v, g.figures.tasks)));
            let _ = write!(
                s,
                "<g><title>{}, {}: {n} of {} tasks, {} %</title><rect class=\"part f{p}\" x=\"{x0:.1}\" y=\"{:.1}\" width=\"{:.1}\" \
                 height=\"{:.1}\"/>",
                escape(name),
                escape(&part.name),
                g.figures.tasks,
                number(share(n, g.figures.tasks), 1),
                y + 3.0,
                x1 - x0,
                row - 6.0,
            );
            if x1 - x0 > 14.0 {
                sign(&mut s, p, [0.5 * (x0 + x1), y + 0.5 * row]);
            }
            s.push_str("</g>");
            from += n;
        }
        let _ = write!(
            s,
            "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            f.sx(share(from, g.figures.tasks)) + 6.0,
            y + 0.5 * row + 4.2,
            total(g)
        );
    }
    f.texts(&mut s, "% of the tasks", "");
    let entries: Vec<Entry<'_>> = parts.iter().map(|p| Entry { sign: 22.0, name: &p.name }).collect();
    let swatch = |s: &mut String, part: usize, [x, y]: [f64; 2]| {
        let _ = write!(
            s,
            "<rect class=\"part f{part}\" x=\"{x:.1}\" y=\"{:.1}\" width=\"22\" height=\"15\"/>",
            y - 7.5
        );
        sign(s, part, [x + 11.0, y]);
    };
    f.height += 6.0 + rows(&mut s, &entries, [8.0, f.height + 4.0], wide - 16.0, swatch);
    Some(Drawing::new("Causes of failures", &f, s))
}
