//! Bodies of triangles.

use crate::canvas::{Canvas, Faces, beacon, solid};
use crate::light::on_solid;
use crate::{Colour, V3};
use nalgebra::UnitQuaternion;
use parry3d_f64::math::Vector;
use std::f64::consts::TAU;
use vb_math::sin_cos;

/// A triangle, counter-clockwise from outside, with its colour in full light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    pub(crate) corners: [V3; 3],
    pub(crate) colour: Colour,
}

impl Face {
    /// The unit normal, outwards; none for a triangle without area.
    fn normal(&self) -> Option<V3> {
        let [a, b, c] = &self.corners;
        (b - a).cross(&(c - a)).try_normalize(0.0)
    }

    pub(crate) fn placed(&self, turn: &UnitQuaternion<f64>, to: &V3) -> Self {
        Self { corners: self.corners.each_ref().map(|p| turn * p + to), colour: self.colour }
    }

    /// Draws it in the light of the sun.
    pub(crate) fn draw(&self, canvas: &mut Canvas) {
        if let Some(normal) = self.normal() {
            canvas.face(&self.corners, Faces::Front, solid(on_solid(self.colour, &normal)));
        }
    }

    /// Draws it as what has to be seen from far away.
    pub(crate) fn draw_as_beacon(&self, canvas: &mut Canvas) {
        if let Some(normal) = self.normal() {
            canvas.face(&self.corners, Faces::Front, beacon(on_solid(self.colour, &normal)));
        }
    }
}

/// The convex hull of points. There is none of points that lie in a plane, which files of vehicles and obstacles don't
/// have.
pub(crate) fn hull(points: &[V3], colour: Colour) -> Vec<Face> {
    let given: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let Ok((corners, triangles)) = parry3d_f64::transformation::try_convex_hull(&given) else {
        return Vec::new();
    };
    let corner = |k: u32| {
        let p = corners[k as usize];
        V3::new(p.x, p.y, p.z)
    };
    triangles.iter().map(|t| Face { corners: t.map(corner), colour }).collect()
}

/// The faces of a body of revolution about the y axis, whose outline (distance from the axis, y) goes from its left end
/// (greatest y) to its right one. `colour` tells that of the strip behind each part of the outline, by the part's and
/// the side's number.
pub(crate) fn turned(
    outline: &[[f64; 2]],
    sides: usize,
    colour: impl Fn(usize, usize) -> Colour,
) -> Vec<Face> {
    let corner = |k: usize, side: usize| {
        let (s, c) = sin_cos(TAU * (side % sides) as f64 / sides as f64);
        let [r, y] = outline[k];
        V3::new(r * s, y, r * c)
    };
    let mut faces = Vec::new();
    for part in 1..outline.len() {
        for side in 0..sides {
            let [a, b] = [corner(part - 1, side), corner(part - 1, side + 1)];
            let [c, d] = [corner(part, side + 1), corner(part, side)];
            let colour = colour(part - 1, side);
            if outline[part - 1][0] > 0.0 {
                faces.push(Face { corners: [a, c, b], colour });
            }
            if outline[part][0] > 0.0 {
                faces.push(Face { corners: [a, d, c], colour });
            }
        }
    }
    faces
}

/// The volume of a closed body, m³, by the divergence theorem.
pub(crate) fn volume(faces: &[Face]) -> f64 {
    faces.iter().map(|f| f.corners[0].dot(&f.corners[1].cross(&f.corners[2])) / 6.0).sum()
}

/// The smallest sphere about the middle of the faces' box: centre and radius.
pub(crate) fn sphere<'a>(faces: impl Iterator<Item = &'a Face> + Clone) -> (V3, f64) {
    let points = || faces.clone().flat_map(|f| f.corners.iter());
    let least = points().fold(V3::repeat(f64::INFINITY), |a, b| a.inf(b));
    let most = points().fold(V3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
    if least.x > most.x {
        return (V3::zeros(), 0.0);
    }
    let centre = 0.5 * (least + most);
    (centre, points().map(|p| (p - centre).norm()).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_look_outwards_and_close_a_body() {
        let corners: Vec<V3> = (0..8u8)
            .map(|k| V3::new(f64::from(k & 1) * 2.0, f64::from(k >> 1 & 1) * 3.0, f64::from(k >> 2) * 4.0))
            .collect();
        assert!((volume(&hull(&corners, [0; 3])) - 24.0).abs() < 1e-9);
        // A regular prism of n sides has the area n/2 sin(2π/n) r².
        let wheel = turned(&[[0.0, 0.5], [2.0, 0.5], [2.0, -0.5], [0.0, -0.5]], 12, |_, _| [0; 3]);
        assert!((volume(&wheel) - 6.0 * 0.5 * 4.0).abs() < 1e-9, "{}", volume(&wheel));
        let (centre, radius) = sphere(wheel.iter());
        assert!(centre.norm() < 1e-12 && (radius - 4.25_f64.sqrt()).abs() < 1e-9);
    }
}
