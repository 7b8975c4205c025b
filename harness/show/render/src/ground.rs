//! The ground as triangles: blocks of cells, coarser in the distance.

use crate::V3;
use crate::camera::Spot;
use crate::canvas::{Canvas, Faces, GROUND, solid};
use crate::light::{FOG, HAZE};
use vb_world::{GranularBed, Heightfield};

/// Cells along a side of a block.
const CELLS: usize = 16;
/// A cell is at least so many samples wide where it is nearest, or stands for several.
const FINEST: f64 = 8.0;

/// Cells of the ground that are drawn in one piece.
#[derive(Clone, Debug)]
struct Block {
    rows: [usize; 2],
    cols: [usize; 2],
    centre: V3,
    radius: f64,
}

/// The blocks of a world.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    blocks: Vec<Block>,
}

/// The nodes of a block that are drawn, in the camera's own axes and on the canvas.
#[derive(Default)]
struct Nodes {
    own: Vec<V3>,
    spots: Vec<Spot>,
}

fn point(field: &Heightfield, row: usize, col: usize) -> V3 {
    let r = field.resolution();
    V3::new(col as f64 * r - field.half_x(), row as f64 * r - field.half_y(), field.node(row, col))
}

impl Ground {
    /// Cuts the ground into blocks.
    pub(crate) fn new(field: &Heightfield) -> Self {
        let cuts = |nodes: usize| (0..nodes - 1).step_by(CELLS).map(move |k| [k, (k + CELLS).min(nodes - 1)]);
        let mut blocks = Vec::new();
        for rows in cuts(field.rows()) {
            for cols in cuts(field.cols()) {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for row in rows[0]..=rows[1] {
                    for col in cols[0]..=cols[1] {
                        low = low.min(field.node(row, col));
                        high = high.max(field.node(row, col));
                    }
                }
                let (mut a, mut b) = (point(field, rows[0], cols[0]), point(field, rows[1], cols[1]));
                (a.z, b.z) = (low, high);
                blocks.push(Block { rows, cols, centre: 0.5 * (a + b), radius: 0.5 * (b - a).norm() });
            }
        }
        Self { blocks }
    }

    /// Draws the ground but the cells within granular beds.
    pub(crate) fn draw(&self, canvas: &mut Canvas, field: &Heightfield, beds: &[GranularBed]) {
        let camera = canvas.camera;
        let seen: Vec<(&Block, usize)> = self
            .blocks
            .iter()
            .filter(|b| !camera.misses(&b.centre, b.radius))
            .map(|b| {
                let depth = camera.own(&b.centre).z - b.radius;
                let wide = camera.samples_a_metre(depth) * field.resolution();
                // Powers of two, by which nodes of neighbours meet.
                let mut stride = 1;
                while stride < CELLS && wide * stride as f64 <= FINEST {
                    stride *= 2;
                }
                (b, stride)
            })
            .collect();
        // Where blocks of different strides meet, strips that hang from their edges hide the gaps.
        let even = seen.iter().all(|(_, s)| *s == seen[0].1);
        let mut nodes = Nodes::default();
        for (block, stride) in seen {
            let hang = if even { 0.0 } else { stride as f64 * field.resolution() };
            block.draw(canvas, field, beds, stride, hang, &mut nodes);
        }
    }

    /// Draws what lies around the world: nothing but a level that fades into the air.
    pub(crate) fn surround(canvas: &mut Canvas, field: &Heightfield, unit: f64) {
        let (rows, cols) = (field.rows(), field.cols());
        let (last_row, last_col) = (rows - 1, cols - 1);
        // Counter-clockwise from the south-western corner.
        let south = (0..last_col).map(|c| (0, c));
        let east = (0..last_row).map(|r| (r, last_col));
        let north = (1..cols).rev().map(|c| (last_row, c));
        let west = (1..rows).rev().map(|r| (r, 0));
        let edge: Vec<V3> =
            south.chain(east).chain(north).chain(west).map(|(r, c)| point(field, r, c)).collect();
        let level = edge.iter().map(|p| p.z).sum::<f64>() / edge.len() as f64;
        let far = 1.0 + 6.0 * FOG * unit / field.half_x().min(field.half_y());
        let out = |p: &V3, by: f64| V3::new(p.x * by, p.y * by, level);
        let near = 1.0 + 0.1 * (FOG * unit / field.half_x().min(field.half_y())).min(1.0);
        let paint = solid(HAZE.map(|c| (f64::from(c) * 0.93) as u8));
        for (k, a) in edge.iter().enumerate() {
            let b = &edge[(k + 1) % edge.len()];
            let (an, bn, af, bf) = (out(a, near), out(b, near), out(a, far), out(b, far));
            for corners in [[*b, *a, an], [*b, an, bn], [bn, an, af], [bn, af, bf]] {
                canvas.face(&corners, Faces::Front, paint);
            }
        }
    }
}

impl Block {
    fn draw(
        &self,
        canvas: &mut Canvas,
        field: &Heightfield,
        beds: &[GranularBed],
        stride: usize,
        hang: f64,
        nodes: &mut Nodes,
    ) {
        let camera = canvas.camera;
        let steps = |[from, to]: [usize; 2]| {
            (from..to).step_by(stride).chain(std::iter::once(to)).collect::<Vec<usize>>()
        };
        let (rows, cols) = (steps(self.rows), steps(self.cols));
        nodes.own.clear();
        nodes.spots.clear();
        let nearest = camera.nearest();
        let mut cut = false;
        for &row in &rows {
            for &col in &cols {
                let own = camera.own(&point(field, row, col));
                cut |= own.z < nearest;
                nodes.own.push(own);
                nodes.spots.push(camera.spot(&own));
            }
        }
        let mut triangle = |nodes: &Nodes, k: [usize; 3]| {
            if cut {
                canvas.face_of_own(&k.map(|k| nodes.own[k]), Faces::Front, GROUND);
            } else {
                canvas.fill(k.map(|k| nodes.spots[k]), Faces::Front, GROUND);
            }
        };
        let n = cols.len();
        for row in 1..rows.len() {
            for col in 1..n {
                let corner = |row: usize, col: usize| point(field, rows[row], cols[col]);
                let (low, high) = (corner(row - 1, col - 1), corner(row, col));
                let within = |bed: &GranularBed| bed.contains(low.x, low.y) && bed.contains(high.x, high.y);
                if beds.iter().any(within) {
                    continue;
                }
                let (sw, nw) = ((row - 1) * n + col - 1, row * n + col - 1);
                triangle(nodes, [sw, sw + 1, nw + 1]);
                triangle(nodes, [sw, nw + 1, nw]);
            }
        }
        if hang > 0.0 {
            let down = hang * V3::new(camera.right.z, camera.up.z, camera.forward.z);
            let last = (rows.len() - 1) * n;
            let south = (1..n).map(|c| [c - 1, c]);
            let north = (1..n).map(|c| [last + c, last + c - 1]);
            let west = (1..rows.len()).map(|r| [r * n, (r - 1) * n]);
            let east = (1..rows.len()).map(|r| [r * n - 1, (r + 1) * n - 1]);
            for [a, b] in south.chain(north).chain(west).chain(east) {
                let (a, b) = (nodes.own[a], nodes.own[b]);
                for corners in [[a, a - down, b - down], [a, b - down, b]] {
                    canvas.face_of_own(&corners, Faces::Both, GROUND);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::canvas::SKY;

    #[test]
    fn ground_has_no_gaps_where_blocks_of_different_coarseness_meet() {
        let n = 513;
        let mut stream = vb_math::rng::Stream::new(4, &["rough"]);
        let heights = (0..n * n).map(|_| stream.uniform(0.0, 0.4)).collect();
        let field = Heightfield::new(n, n, 0.25, heights);
        let eye = V3::new(-50.0, 0.0, 6.0);
        let camera = Camera::looking(eye, eye + V3::new(1.0, 0.0, -0.4), 0.8, 0.2, [320, 240]);
        let mut canvas = Canvas::new(camera);
        Ground::new(&field).draw(&mut canvas, &field, &[]);
        let samples = canvas.exposed();
        // What is 114 m away at the world's end is 5.6 to 6 m below the eye: 2.8 to 3.1 degrees. The picture's middle is
        // 21.8 degrees below the horizon, and its focal length 284 samples: the end is in row 24 or above.
        for (k, paint) in samples.paint.iter().enumerate().skip(25 * 320) {
            assert_eq!(*paint, GROUND, "row {} column {}", k / 320, k % 320);
        }
        assert!(samples.paint[..10 * 320].iter().all(|p| *p == SKY));
    }

    #[test]
    fn ground_in_the_distance_is_drawn_with_fewer_triangles() {
        let draw = |n: usize, resolution: f64| {
            let field = Heightfield::flat(n, n, resolution, 0.0);
            let camera = Camera::above(V3::new(0.0, 0.0, 10.0), 2.0, [256, 256]);
            let mut canvas = Canvas::new(camera);
            Ground::new(&field).draw(&mut canvas, &field, &[]);
            canvas.count()
        };
        // Cells of 2 samples stand for 8 × 8 of them, as cells of 1 sample for 16 × 16.
        assert_eq!(draw(129, 1.0), 2 * 16 * 16);
        assert_eq!(draw(257, 0.5), 2 * 16 * 16);
    }
}
