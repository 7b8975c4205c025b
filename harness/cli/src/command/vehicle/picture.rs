//! Side and top view of a vehicle, drawn from its own geometry.

use std::fmt::Write as _;

use super::standing::{Standing, Wheel};

/// Width of the drawing, in its own units; the vehicle takes up this less a margin.
const WIDTH: f64 = 800.0;
const MARGIN: f64 = 30.0;

const STYLE: &str = "\
svg{color:#1b2733;background:#fff;font:13px sans-serif}\
.hull{fill:#7d99b3;fill-opacity:.35;stroke:#33536f;stroke-width:1.2}\
.wheel{fill:#39424c;fill-opacity:.55;stroke:#11161b;stroke-width:1.2}\
.belt{fill:#39424c;fill-opacity:.8;fill-rule:evenodd;stroke:#11161b;stroke-width:1}\
.link{stroke:#b3541e;stroke-width:2;fill:none}\
.strut{stroke:#1f7a43;stroke-width:3;fill:none;stroke-dasharray:5 3}\
.ground,.size{stroke:currentColor;stroke-width:1;fill:none}\
.com{fill:none;stroke:#c02942;stroke-width:2}\
text{fill:currentColor}\
@media (prefers-color-scheme:dark){svg{color:#d6dee6;background:#10161c}.wheel{fill:#9aa7b4;stroke:#d6dee6}}";

/// A view: which coordinates of a place go to the right and up.
#[derive(Clone, Copy)]
struct View {
    across: usize,
    up: usize,
    /// Units a metre.
    unit: f64,
    /// Where the origin lies.
    origin: [f64; 2],
}

impl View {
    fn at(self, p: [f64; 3]) -> [f64; 2] {
        [self.origin[0] + self.unit * p[self.across], self.origin[1] - self.unit * p[self.up]]
    }
}

/// The drawing as an SVG document.
pub(super) fn draw(standing: &Standing) -> String {
    let points = || {
        let belts = standing.belts.iter().flat_map(|[outer, _]| outer.iter().copied());
        let wheels = standing.wheels.iter().flat_map(outline).chain(belts);
        standing.hull.iter().flatten().copied().chain(wheels)
    };
    let range =
        |k: usize| points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[k]), b.max(p[k])));
    let ((x0, x1), (y0, y1), (_, z1)) = (range(0), range(1), range(2));
    let unit = (WIDTH - 2.0 * MARGIN) / (x1 - x0);
    let left = MARGIN - unit * x0;
    let ground = MARGIN + 20.0 + unit * z1;
    let side = View { across: 0, up: 2, unit, origin: [left, ground] };
    let middle = ground + 60.0 + unit * y1;
    let top = View { across: 0, up: 1, unit, origin: [left, middle] };
    let height = middle - unit * y0 + MARGIN;
    let mut s = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH:.0} {height:.0}\" role=\"img\" \
         aria-label=\"{}: side and top view\"><style>{STYLE}</style>\n",
        standing.spec.name
    );
    let _ = writeln!(
        s,
        "<text x=\"{MARGIN}\" y=\"22\">{}: side and top view, front to the right; hull, wheels, links, springs and \
         dampers, centre of sprung mass</text>",
        standing.spec.name
    );
    let _ = writeln!(
        s,
        "<path class=\"ground\" d=\"M0 {ground:.1}H{WIDTH:.0}\"/>\
         <path class=\"size\" d=\"M{a:.1} {y:.1}H{b:.1}M{a:.1} {up:.1}v8M{b:.1} {up:.1}v8\"/>\
         <text x=\"{m:.1}\" y=\"{t:.1}\" text-anchor=\"middle\">{length} m long, {width} m wide, {tall} m high, wheelbase \
         {base:.3} m</text>",
        a = side.at([x0, 0.0, 0.0])[0],
        b = side.at([x1, 0.0, 0.0])[0],
        y = ground + 16.0,
        up = ground + 12.0,
        m = 0.5 * WIDTH,
        t = ground + 34.0,
        length = standing.spec.length,
        width = standing.spec.width,
        tall = standing.spec.height,
        base = standing.shape.wheelbase,
    );
    for view in [side, top] {
        for part in &standing.hull {
            polygon(&mut s, "hull", &hull(part.iter().map(|p| view.at(*p)).collect()));
        }
        for wheel in &standing.wheels {
            polygon(&mut s, "wheel", &hull(outline(wheel).map(|p| view.at(p)).collect()));
        }
        belts(&mut s, standing, view);
        for (class, lines) in [("link", &standing.links), ("strut", &standing.struts)] {
            for [a, b] in lines {
                let (a, b) = (view.at(*a), view.at(*b));
                let _ = writeln!(
                    s,
                    "<path class=\"{class}\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
                    a[0], a[1], b[0], b[1]
                );
            }
        }
        let com = standing.state.position
            + standing.state.attitude * nalgebra::Vector3::from(standing.spec.chassis.com);
        let [x, y] = view.at(com.into());
        let _ = writeln!(
            s,
            "<path class=\"com\" d=\"M{:.1} {y:.1}h12M{x:.1} {:.1}v12\"/><circle class=\"com\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>",
            x - 6.0,
            y - 6.0
        );
    }
    s + "</svg>\n"
}

/// The belts: rings from the side, and what they cover from above.
fn belts(s: &mut String, standing: &Standing, view: View) {
    for edges in standing.belts.chunks(2) {
        if view.up == 2 {
            let ring = |points: &[[f64; 3]]| {
                let places: Vec<String> =
                    points.iter().map(|p| view.at(*p)).map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
                format!("M{}Z", places.join("L"))
            };
            let [outer, inner] = &edges[0];
            let _ = writeln!(s, "<path class=\"belt\" d=\"{}{}\"/>", ring(outer), ring(inner));
        } else {
            let covered = edges.iter().flat_map(|[outer, _]| outer).map(|p| view.at(*p)).collect();
            polygon(s, "belt", &hull(covered));
        }
    }
}

/// Points on both edges of a tyre.
fn outline(wheel: &Wheel) -> impl Iterator<Item = [f64; 3]> + '_ {
    let w = wheel.axis;
    // Two directions across the axle: ahead, and what is left.
    let ahead = unit([w[1], -w[0], 0.0]);
    let up = [
        ahead[1] * w[2] - ahead[2] * w[1],
        ahead[2] * w[0] - ahead[0] * w[2],
        ahead[0] * w[1] - ahead[1] * w[0],
    ];
    (0..72).map(move |k| {
        let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * f64::from(k / 2) / 36.0);
        let half = if k % 2 == 0 { 0.5 } else { -0.5 } * wheel.width;
        std::array::from_fn(|i| wheel.centre[i] + wheel.radius * (c * ahead[i] + s * up[i]) + half * w[i])
    })
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / n)
}

fn polygon(s: &mut String, class: &str, points: &[[f64; 2]]) {
    let places: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
    let _ = writeln!(s, "<polygon class=\"{class}\" points=\"{}\"/>", places.join(" "));
}

/// Corners of the convex hull of some points, in order (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn the_outline_of_points_leaves_out_what_lies_within() {
        let square = vec![[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 0.0]];
        assert_eq!(hull(square), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    }
}
