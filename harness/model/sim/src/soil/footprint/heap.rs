//! Displaced soil is heaped up around the contact.

use super::super::grid::Grid;
use super::{FIRST, Footprint, Step};

/// Plastic sinkage beyond which the ground counts as a rut, m.
const LOOSE: f64 = 1e-3;
/// Cells beside the wheel over which a heap may slide, as the original lets it (10 propagations in its envs/terrain.py).
const RINGS: usize = 10;
/// Steps between two times that displaced soil is heaped up beside the wheel.
const PAUSE: u32 = 8;

impl<const N: usize> Footprint<N> {
    /// Heaps displaced soil up around the contact: before and behind it within the footprint, beside it on the grid.
    /// Each side gets what its share of the perimeter is, but nothing is heaped on the ground of a rut: the law knows
    /// one surface, so loose soil there would be as hard as the rut's ground.
    pub(super) fn heap(
        &mut self,
        grid: &mut Grid,
        step: &Step<'_>,
        (first, last): (usize, usize),
        volume: f64,
        slope: f64,
    ) {
        let (xs, lengths, width) = (&self.shape.xs, &self.shape.lengths, self.shape.width);
        let length = xs[last] - xs[first] + lengths[first];
        let strip_width = self.shape.strip_width();
        let around = 2.0 * (length + width);
        let end = volume * width / (around * self.shape.strips as f64);
        let mut side = volume * length / around;
        for (from, step) in [(last, 1isize), (first, -1)] {
            let outside = |k: usize| k.checked_add_signed(step).filter(|k| (FIRST..=Self::LAST).contains(k));
            for strip in 0..self.shape.strips {
                let Some(nearest) = outside(from).filter(|k| self.plastic[strip][*k] < LOOSE) else {
                    side += 0.5 * end;
                    continue;
                };
                let row = &mut self.raised[strip];
                row[nearest] += end / (strip_width * lengths[nearest]);
                let mut k = nearest;
                while let Some(next) = outside(k) {
                    let spacing = (xs[next] - xs[k]).abs();
                    let excess = row[k] - row[next] - slope * spacing;
                    if excess <= 0.0 {
                        break;
                    }
                    let (a, b) = (lengths[k], lengths[next]);
                    let moved = excess * a * b / (a + b);
                    row[k] -= moved / a;
                    row[next] += moved / b;
                    k = next;
                }
            }
        }
        self.waiting.0 += side;
        self.waiting.1 += 1;
        if self.waiting.1 >= PAUSE {
            let side = std::mem::take(&mut self.waiting).0;
            self.heap_beside(grid, step, self.shape.xs[first], length, side, slope);
        }
    }

    /// Heaps `side` (m³) up on each side of the wheel, along `length` from `start` on.
    fn heap_beside(&self, grid: &mut Grid, step: &Step<'_>, start: f64, length: f64, side: f64, slope: f64) {
        let (m, f) = (step.motion, &step.frame);
        let resolution = grid.resolution();
        let count = (length / resolution) as usize + 1;
        let each = side / (count as f64 * resolution * resolution);
        for direction in [-1.0, 1.0] {
            for i in 0..count {
                let x = start + length * (i as f64 + 0.5) / count as f64;
                let beside = |ring: usize| {
                    let y = direction * (0.5 * self.shape.width + resolution * (ring as f64 + 0.5));
                    m.hub + f.along * x + m.axis * y
                };
                let at = beside(0);
                let Some(mut inner) = grid.touch(at.x, at.y) else { continue };
                grid.cell_mut(inner).raised += each;
                for ring in 1..RINGS {
                    let at = beside(ring);
                    let Some(outer) = grid.touch(at.x, at.y) else { break };
                    let difference = grid.cell_mut(inner).raised - grid.cell_mut(outer).raised;
                    let moved = 0.5 * (difference - slope * resolution);
                    if moved <= 0.0 {
                        break;
                    }
                    grid.cell_mut(outer).raised += moved;
                    grid.cell_mut(inner).raised -= moved;
                    inner = outer;
                }
            }
        }
    }
}
