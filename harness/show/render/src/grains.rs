//! Granular beds: pits with grains in them.

use crate::V3;
use crate::canvas::{Canvas, Faces, solid};
use crate::light::on_solid;
use vb_world::{GranularBed, World};

/// The colour of a pit's floor and walls over that of its grains.
const PIT: f64 = 0.45;
/// Range of the brightness of grains, relative to the brightest.
const SPREAD: f64 = 0.35;

/// Draws the floors and walls of the pits, and grains, which are octahedra: centres and radii, m.
pub(crate) fn draw(canvas: &mut Canvas, world: &World, grains: &[([f64; 3], f64)]) {
    for bed in &world.beds {
        pit(canvas, world, bed);
    }
    let corners = |radius: f64| [0, 1, 2].map(|k| V3::from_fn(|i, _| if i == k { radius } else { 0.0 }));
    for (k, (centre, radius)) in grains.iter().enumerate() {
        let centre = V3::from(*centre);
        if canvas.camera.misses(&centre, *radius) {
            continue;
        }
        // A grain that has left its bed has the colour of the first.
        let Some(bed) = world.beds.get(world.bed_at(centre.x, centre.y).unwrap_or(0)) else { continue };
        // A fixed brightness for each.
        let shade = 1.0 - SPREAD * f64::from((k as u32).wrapping_mul(2_654_435_761) >> 24) / 255.0;
        let colour = bed.material.class.colour().map(|c| (f64::from(c) * shade) as u8);
        let [x, y, z] = corners(*radius);
        for octant in 0..8 {
            let sign = |bit: u32| if octant & bit == 0 { 1.0 } else { -1.0 };
            let [a, b, c] = [centre + x * sign(1), centre + y * sign(2), centre + z * sign(4)];
            // Counter-clockwise from outside.
            let face = if sign(1) * sign(2) * sign(4) > 0.0 { [a, b, c] } else { [a, c, b] };
            let normal = V3::new(sign(1), sign(2), sign(4)).normalize();
            canvas.face(&face, Faces::Front, solid(on_solid(colour, &normal)));
        }
    }
}

fn pit(canvas: &mut Canvas, world: &World, bed: &GranularBed) {
    let [[west, south], [east, north]] = bed.corners();
    let top = world.heightfield.height(bed.x, bed.y);
    let floor = top - bed.depth;
    let colour = bed.material.class.colour().map(|c| (f64::from(c) * PIT) as u8);
    let paint = solid(on_solid(colour, &V3::z()));
    // Counter-clockwise from above.
    let edge = [[west, south], [east, south], [east, north], [west, north]];
    let at = |k: usize, z: f64| V3::new(edge[k % 4][0], edge[k % 4][1], z);
    let mut square = |a: V3, b: V3, c: V3, d: V3| {
        canvas.face(&[a, b, c], Faces::Both, paint);
        canvas.face(&[a, c, d], Faces::Both, paint);
    };
    square(at(0, floor), at(1, floor), at(2, floor), at(3, floor));
    for k in 0..4 {
        square(at(k, floor), at(k, top), at(k + 1, top), at(k + 1, floor));
    }
}
