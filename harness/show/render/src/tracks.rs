//! The belt of a track: pads along the taut way around the wheels of one side.

use crate::solid::Face;
use crate::{Colour, V3};
use std::f64::consts::{FRAC_PI_2, TAU};
use vb_math::{atan2, cos, hypot, sin};

/// Pads alternate between these, so that one sees the belt move.
const PADS: [Colour; 2] = [[52, 54, 58], [34, 35, 38]];
/// The length of a pad over the belt's thickness.
const PAD: f64 = 2.5;
/// Pads of one belt at most.
const MOST: usize = 400;

/// A wheel inside a belt.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Roller {
    /// Its centre in the frame of the chassis, m.
    pub(crate) hub: V3,
    /// Its radius, without the belt, m.
    pub(crate) radius: f64,
}

/// A straight part of the way, or one along a circle.
enum Part {
    Line { from: [f64; 2], along: [f64; 2], length: f64 },
    Arc { centre: [f64; 2], radius: f64, from: f64, length: f64 },
}

impl Part {
    fn length(&self) -> f64 {
        match self {
            Self::Line { length, .. } | Self::Arc { length, .. } => *length,
        }
    }

    /// The place at a distance from the part's beginning, x and z, and the direction away from the wheels.
    fn at(&self, s: f64) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Line { from, along, .. } => {
                ([from[0] + s * along[0], from[1] + s * along[1]], [-along[1], along[0]])
            }
            Self::Arc { centre, radius, from, .. } => {
                let out = [cos(from - s / radius), sin(from - s / radius)];
                ([centre[0] + radius * out[0], centre[1] + radius * out[1]], out)
            }
        }
    }
}

/// The way around wheels from front to rear: below them to the rear, and back above.
fn way(wheels: &[Roller], pins: f64) -> Vec<Part> {
    let n = wheels.len();
    let centre = |j: usize| [wheels[j % n].hub.x, wheels[j % n].hub.z];
    let radius = |j: usize| wheels[j % n].radius + pins;
    // The direction away from the wheels on the straight part behind each wheel, and the part's length.
    let tangents: Vec<([f64; 2], f64)> = (0..n)
        .map(|j| {
            let ([x, z], [u, v]) = (centre(j), centre(j + 1));
            let apart = hypot(u - x, v - z).max(1e-9);
            let [dx, dz] = [(u - x) / apart, (v - z) / apart];
            let sine = ((radius(j) - radius(j + 1)) / apart).clamp(-1.0, 1.0);
            let cosine = (1.0 - sine * sine).sqrt();
            ([dx * sine - dz * cosine, dz * sine + dx * cosine], apart * cosine)
        })
        .collect();
    let mut parts = Vec::with_capacity(2 * n);
    for j in 0..n {
        let (a, (b, length)) = (tangents[(j + n - 1) % n].0, tangents[j]);
        let mut turn = atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        // Around the first and the last wheel it may be more than half a turn.
        if turn > FRAC_PI_2 {
            turn -= TAU;
        }
        let r = radius(j);
        parts.push(Part::Arc {
            centre: centre(j),
            radius: r,
            from: atan2(a[1], a[0]),
            length: (-turn * r).max(0.0),
        });
        let [x, z] = centre(j);
        parts.push(Part::Line { from: [x + r * b[0], z + r * b[1]], along: [b[1], -b[0]], length });
    }
    parts
}

/// The faces of a belt in the frame of the chassis. `rolled` is the way that it has moved around its wheels, m, positive
/// when rolling forward.
pub(crate) fn belt(wheels: &[Roller], thickness: f64, width: f64, rolled: f64) -> Vec<Face> {
    if wheels.len() < 2 || thickness <= 0.0 {
        return Vec::new();
    }
    let parts = way(wheels, 0.5 * thickness);
    let length: f64 = parts.iter().map(Part::length).sum();
    // An even number, so that colours alternate all around.
    let pads = 2 * ((0.5 * length / (PAD * thickness)).round() as usize).clamp(2, MOST / 2);
    let pitch = length / pads as f64;
    let pair = 2.0 * pitch;
    let phase = rolled - (rolled / pair).floor() * pair;
    // Driven forward, the lower run moves to the rear.
    let places: Vec<_> = (0..pads)
        .map(|k| {
            let mut s = phase + k as f64 * pitch;
            if s >= length {
                s -= length;
            }
            // Rounding may leave a little of the way beyond the last part.
            let mut part = 0;
            while part + 1 < parts.len() && s > parts[part].length() {
                s -= parts[part].length();
                part += 1;
            }
            parts[part].at(s)
        })
        .collect();
    let y = wheels[0].hub.y;
    let edge = |([x, z], [ox, oz]): ([f64; 2], [f64; 2]), out: f64, side: f64| {
        let off = 0.5 * out * thickness;
        V3::new(x + off * ox, y + 0.5 * side * width, z + off * oz)
    };
    let mut faces = Vec::with_capacity(8 * pads);
    for k in 0..pads {
        let (p, q) = (places[k], places[(k + 1) % pads]);
        let mut strip = |a: V3, b: V3, c: V3, d: V3| {
            let colour = PADS[k % 2];
            faces.push(Face { corners: [a, b, c], colour });
            faces.push(Face { corners: [a, c, d], colour });
        };
        // Outer and inner face, left and right edge.
        strip(edge(p, 1.0, 1.0), edge(p, 1.0, -1.0), edge(q, 1.0, -1.0), edge(q, 1.0, 1.0));
        strip(edge(p, -1.0, -1.0), edge(p, -1.0, 1.0), edge(q, -1.0, 1.0), edge(q, -1.0, -1.0));
        strip(edge(p, -1.0, 1.0), edge(p, 1.0, 1.0), edge(q, 1.0, 1.0), edge(q, -1.0, 1.0));
        strip(edge(p, 1.0, -1.0), edge(p, -1.0, -1.0), edge(q, -1.0, -1.0), edge(q, 1.0, -1.0));
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::volume;
    use std::f64::consts::PI;

    fn rollers(places: &[[f64; 3]]) -> Vec<Roller> {
        places.iter().map(|&[x, z, radius]| Roller { hub: V3::new(x, 1.0, z), radius }).collect()
    }

    #[test]
    fn a_belt_around_equal_wheels_is_two_lines_and_a_circle_long() {
        // Pins 0.02 m outside of wheels of 0.3 m that are 4 m apart, with a wheel between that touches below only.
        let wheels = rollers(&[[2.0, 0.0, 0.3], [0.0, 0.0, 0.3], [-2.0, 0.0, 0.3]]);
        let length: f64 = way(&wheels, 0.02).iter().map(Part::length).sum();
        assert!((length - (8.0 + 2.0 * PI * 0.32)).abs() < 1e-9, "{length}");
        // Its pads are prisms whose cross-sections are a little shorter than the way.
        let faces = belt(&wheels, 0.04, 0.5, 0.0);
        let filled = volume(&faces);
        assert!((filled / (length * 0.04 * 0.5) - 1.0).abs() < 0.02, "{filled}");
    }

    #[test]
    fn the_lower_run_of_a_belt_moves_to_the_rear_when_it_rolls_forward() {
        let wheels = rollers(&[[2.0, 0.0, 0.3], [-2.0, 0.0, 0.3]]);
        // Edges between pads on the lower run: the places of outer faces' corners.
        let edges = |rolled: f64| {
            let mut x: Vec<f64> = belt(&wheels, 0.04, 0.5, rolled)
                .iter()
                .filter(|f| f.colour == PADS[0])
                .flat_map(|f| f.corners)
                .filter(|p| p.z < -0.33 && p.x.abs() < 1.5)
                .map(|p| p.x)
                .collect();
            x.sort_by(f64::total_cmp);
            x.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            x
        };
        let (before, after) = (edges(0.0), edges(0.03));
        for x in &before[1..before.len() - 1] {
            assert!(after.iter().any(|y| (y - (x - 0.03)).abs() < 1e-9), "{x}");
        }
    }
}
