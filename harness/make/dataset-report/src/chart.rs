//! The pictures of the page: distributions, and the way of an episode.

use std::fmt::Write as _;

use vb_page::plot::Frame;
use vb_page::{escape, grouped};
use vb_world::World;

use crate::figures::{Histogram, Quantity};

/// The fraction of the values at either end that a plot leaves out: the far tail would press the rest together.
const TAIL: f64 = 0.0005;

/// The first and the last bin, but for the tails.
fn range(histogram: &Histogram) -> Option<[i64; 2]> {
    let all = histogram.count() as f64;
    let (mut below, mut first, mut last) = (0.0, None, None);
    for (bin, n) in &histogram.0 {
        if below + *n as f64 > TAIL * all {
            first = first.or(Some(*bin));
        }
        if below < (1.0 - TAIL) * all {
            last = Some(*bin);
        }
        below += *n as f64;
    }
    Some([first?, last?])
}

/// The distributions of a quantity, one a group, as fractions of all frames of the group.
pub(crate) fn distribution(s: &mut String, quantity: &Quantity, groups: &[(&str, &Histogram)]) {
    let ranges: Vec<[i64; 2]> = groups.iter().filter_map(|(_, h)| range(h)).collect();
    let first = ranges.iter().map(|r| r[0]).min().unwrap_or(0);
    let last = ranges.iter().map(|r| r[1]).max().unwrap_or(0);
    let fraction =
        |h: &Histogram, bin: i64| h.0.get(&bin).map_or(0.0, |n| 100.0 * *n as f64 / h.count().max(1) as f64);
    let heights = groups.iter().flat_map(|(_, h)| (first..=last).map(move |bin| fraction(h, bin)));
    let top = heights.fold(1e-3, f64::max);
    let edge = |bin: i64| (bin as f64 - 0.5) * quantity.bin;
    let f = Frame {
        width: 460.0,
        height: 240.0,
        left: 46.0,
        right: 12.0,
        top: 10.0,
        bottom: 42.0,
        x: [edge(first), edge(last + 1)],
        y: [0.0, 1.05 * top],
    };
    let _ = write!(s, "<figure><figcaption>{}</figcaption>", escape(quantity.name));
    f.open(s, quantity.name);
    f.y_axis(s, 4.0);
    f.x_axis(s, 7.0);
    for (k, (_, h)) in groups.iter().enumerate() {
        let mut d = format!("M{:.1} {:.1}", f.sx(edge(first)), f.sy(0.0));
        for bin in first..=last {
            let y = f.sy(fraction(h, bin));
            let _ = write!(d, "L{:.1} {y:.1}L{:.1} {y:.1}", f.sx(edge(bin)), f.sx(edge(bin + 1)));
        }
        let _ = write!(d, "L{:.1} {:.1}", f.sx(edge(last + 1)), f.sy(0.0));
        let _ = write!(s, "<path class=\"curve f{k} s{k}\" d=\"{d}\"/>");
    }
    f.texts(s, quantity.unit, "% of frames");
    s.push_str("</svg><ul class=\"legend\">");
    for (k, (name, h)) in groups.iter().enumerate() {
        let frames = grouped(h.count());
        let _ = write!(s, "<li><i class=\"swatch b{k}\"></i>{}, {frames} frames</li>", escape(name));
    }
    s.push_str("</ul></figure>");
}

/// The way of an episode in its world, seen from above, north up.
pub(crate) fn way(s: &mut String, world: &World, way: &[[f64; 2]]) {
    let (x, y) = (world.heightfield.half_x(), world.heightfield.half_y());
    let unit = x.max(y) / 64.0;
    let _ = write!(
        s,
        "<svg class=\"way\" viewBox=\"{:.3} {:.3} {:.3} {:.3}\" role=\"img\" aria-label=\"Trajectory in {}\"><rect class=\"world\" \
         x=\"{:.3}\" y=\"{:.3}\" width=\"{:.3}\" height=\"{:.3}\"/>",
        -x,
        -y,
        2.0 * x,
        2.0 * y,
        escape(&world.id),
        -x,
        -y,
        2.0 * x,
        2.0 * y,
    );
    let mut outlines = String::new();
    for obstacle in &world.obstacles {
        for (k, p) in obstacle.footprint().iter().enumerate() {
            let _ = write!(outlines, "{}{:.2} {:.2}", if k == 0 { 'M' } else { 'L' }, p[0], -p[1]);
        }
        outlines.push('Z');
    }
    let _ = write!(s, "<path class=\"obstacle\" d=\"{outlines}\"/>");
    let mut line = String::new();
    for (k, p) in way.iter().enumerate() {
        let _ = write!(line, "{}{:.2} {:.2}", if k == 0 { 'M' } else { 'L' }, p[0], -p[1]);
    }
    let _ = write!(s, "<path class=\"line s0\" style=\"stroke-width:{:.3}\" d=\"{line}\"/>", 1.2 * unit);
    for (class, end) in [("start", way.first()), ("end", way.last())] {
        if let Some([px, py]) = end {
            let _ = write!(
                s,
                "<circle class=\"{class}\" cx=\"{px:.2}\" cy=\"{:.2}\" r=\"{:.2}\"/>",
                -py,
                2.2 * unit
            );
        }
    }
    s.push_str("</svg>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_leaves_out_tails() {
        let h = Histogram([(-9, 1), (0, 5000), (1, 4000), (2, 5), (3, 994)].into());
        // One of ten thousand is in the tail, 994 are not.
        assert_eq!(range(&h), Some([0, 3]));
        assert_eq!(range(&Histogram([(4, 1)].into())), Some([4, 4]));
        assert_eq!(range(&Histogram::default()), None);
    }

    #[test]
    fn a_distribution_of_nothing_is_still_drawn() {
        let mut s = String::new();
        distribution(&mut s, &crate::QUANTITIES[0], &[("<rigid>", &Histogram::default())]);
        assert!(s.contains("&lt;rigid&gt;") && !s.contains("NaN") && !s.contains("inf"), "{s}");
    }
}
