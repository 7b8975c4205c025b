//! The soil's states move through the footprint as the wheel moves over the ground.

use super::super::grid::Grid;
use super::press::store;
use super::{FIRST, Footprint, LANES, Row, Step};
use crate::V3;
use fearless_simd::{Simd, f64x4, prelude::*};

/// Part of the grid's resolution by which a wheel slides before it looks at the ground beside it again.
const SLIDE: f64 = 0.02;
/// Speed below which nothing moves, m/s.
pub(super) const STILL: f64 = 1e-6;
/// The cells that a wheel leaves in a step, at most: 200 m/s over cells of 1 mm at the longest time step.
const MOST_CELLS: usize = 1000;

impl<const N: usize> Footprint<N> {
    /// Moves the states by upwind differences.
    #[inline(always)]
    pub(super) fn transport<S: Simd>(&mut self, simd: S, grid: &mut Grid, step: &Step<'_>) {
        let Step { motion: m, frame: f, dt, .. } = step;
        let edge = self.shape.xs[Self::LAST];
        let one = f64x4::splat(simd, 1.0);
        for strip in 0..self.shape.strips {
            let arm = m.axis * self.shape.offset(strip);
            let speed = (m.velocity + m.rotation.cross(&arm)).dot(&f.along);
            if speed.abs() < STILL {
                continue;
            }
            let origin = m.hub + arm;
            let forward = speed > 0.0;
            let direction = speed.signum();
            let travel = speed.abs() * dt;
            let entering = origin + f.along * (edge * direction);
            let cell = grid.at(entering.x, entering.y);
            // Upwind differences are stable up to one station a step. After as many as there are stations all is new ground, however
            // fast a simulation that fails has become.
            let parts = ((travel * self.shape.finest) as usize).min(N) + 1;
            let part = travel / parts as f64;
            let mut fractions: Row<N> = [0.0; N];
            for g in (0..N).step_by(LANES) {
                let share = f64x4::splat(simd, part)
                    * f64x4::from_slice(simd, &self.shape.inverse_lengths[g..g + LANES]);
                store(&mut fractions, g, share.simd_lt(one).select(share, one));
            }
            let [a, b] = &mut self.shear;
            for _ in 0..parts {
                advect(simd, &mut self.plastic[strip], cell.plastic, forward, &fractions);
                advect(simd, &mut self.raised[strip], cell.raised, forward, &fractions);
                advect(simd, &mut a[strip], 0.0, forward, &fractions);
                advect(simd, &mut b[strip], 0.0, forward, &fractions);
            }
            // Fast wheels leave more than a cell a step.
            let last = if forward { FIRST } else { Self::LAST };
            let cells = ((travel / grid.resolution()) as usize).min(MOST_CELLS) + 1;
            for i in 0..cells {
                let back = edge * direction + direction * travel * i as f64 / cells as f64;
                self.leave(strip, last, grid, origin - f.along * back);
            }
        }
        let distance = m.velocity.dot(&m.axis) * dt;
        if distance.abs() > STILL * dt {
            self.slide(simd, grid, step, distance);
        }
    }

    /// Moves the states across the footprint of a wheel that slides to the left by `distance`. What lies beside the
    /// wheel is taken from and left to the grid every couple of millimetres.
    #[inline(always)]
    fn slide<S: Simd>(&mut self, simd: S, grid: &mut Grid, step: &Step<'_>, distance: f64) {
        let Step { motion: m, frame: f, .. } = step;
        let (strips, width) = (self.shape.strips, self.shape.width);
        let strip = |i: usize| if distance > 0.0 { i } else { strips - 1 - i };
        let turned = self.aside * distance < 0.0;
        self.aside += distance;
        // At the start it is infinite.
        if turned || self.aside.abs() >= SLIDE * grid.resolution() {
            self.aside = 0.0;
            let side: V3 = m.axis * (distance.signum() * 0.5 * (width + grid.resolution()));
            for k in FIRST..=Self::LAST {
                let middle = m.hub + f.along * self.shape.xs[k];
                self.leave(strip(0), k, grid, middle - side);
                let entering = middle + side;
                let cell = grid.at(entering.x, entering.y);
                self.beside[0][k] = cell.plastic;
                self.beside[1][k] = cell.raised;
            }
        }
        let c = (distance.abs() * strips as f64 / width).min(1.0);
        let (zero, c) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, c));
        let load = |row: &Row<N>, g: usize| f64x4::from_slice(simd, &row[g..g + LANES]);
        // From where states leave towards where they enter, so that each still finds its neighbour's old state.
        for i in 0..strips {
            let (to, from) = (strip(i), (i + 1 < strips).then(|| strip(i + 1)));
            for g in (0..N).step_by(LANES) {
                let (plastic, raised) = match from {
                    Some(from) => (load(&self.plastic[from], g), load(&self.raised[from], g)),
                    None => (load(&self.beside[0], g), load(&self.beside[1], g)),
                };
                let (depth, heap) = (load(&self.plastic[to], g), load(&self.raised[to], g));
                // A strip that is partly on new ground is pressed into it as deep as it stands: new ground adds its
                // share of the pressure under which it yields, not the stiffness of a wall that lifts the wheel.
                let pressed = load(&self.pressed[to], g);
                let change = c * (raised - heap);
                let entering = plastic.simd_gt(pressed).select(plastic, pressed);
                let moved = depth + c * (entering - depth);
                let deepened = moved + change;
                let deepened = deepened.simd_gt(zero).select(deepened, zero);
                store(&mut self.plastic[to], g, pressed.simd_gt(zero).select(deepened, moved));
                store(&mut self.raised[to], g, heap + change);
                for states in &mut self.shear {
                    let upstream = from.map_or(zero, |from| load(&states[from], g));
                    let state = load(&states[to], g);
                    store(&mut states[to], g, state + c * (upstream - state));
                }
            }
        }
    }
}

/// Moves a row of states backward (`forward`: the wheel moves forward) by the given shares of each station's length.
#[inline(always)]
fn advect<S: Simd, const N: usize>(
    simd: S,
    row: &mut Row<N>,
    inflow: f64,
    forward: bool,
    fractions: &Row<N>,
) {
    let load = |row: &Row<N>, g: usize| f64x4::from_slice(simd, &row[g..g + LANES]);
    let moved = |old: f64x4<S>, neighbour: f64x4<S>, g: usize| old + (neighbour - old) * load(fractions, g);
    // In place, from where states leave towards where they enter, so that each still finds its neighbour's old state.
    // What has no neighbour is no station, and moves nowhere.
    if forward {
        row[N - 2] = inflow;
        let mut old = load(row, 0);
        for g in (0..N).step_by(LANES) {
            let next = if g + LANES < N { load(row, g + LANES) } else { old };
            store(row, g, moved(old, old.slide::<1>(next), g));
            old = next;
        }
    } else {
        row[FIRST - 1] = inflow;
        let mut old = load(row, N - LANES);
        for g in (0..N).step_by(LANES).rev() {
            let next = if g > 0 { load(row, g - LANES) } else { old };
            store(row, g, moved(old, next.slide::<{ LANES - 1 }>(old), g));
            old = next;
        }
    }
}
