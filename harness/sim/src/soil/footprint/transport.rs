//! The soil's states move through the footprint as the wheel moves over the ground.

use super::super::grid::Grid;
use super::{FIRST, Footprint, Frame, Row};
use crate::V3;
use crate::tyre::WheelMotion;

/// Part of the grid's pitch by which a wheel slides before it looks at the ground beside it again.
const SLIDE: f64 = 0.02;
/// Speed below which nothing moves, m/s.
const STILL: f64 = 1e-6;

impl<const N: usize> Footprint<N> {
    /// Moves the states by upwind differences.
    #[inline(always)]
    pub(super) fn transport(&mut self, grid: &mut Grid, m: &WheelMotion, f: &Frame, dt: f64) {
        let edge = self.shape.xs[Self::LAST];
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
            // Upwind differences are stable up to one station a step.
            let parts = (travel * self.shape.finest) as usize + 1;
            let part = travel / parts as f64;
            let shares: Row<N> = self.shape.inverse_lengths.map(|i| (part * i).min(1.0));
            let [a, b] = &mut self.shear;
            for _ in 0..parts {
                advect(&mut self.plastic[strip], cell.plastic, forward, &shares);
                advect(&mut self.raised[strip], cell.raised, forward, &shares);
                advect(&mut a[strip], 0.0, forward, &shares);
                advect(&mut b[strip], 0.0, forward, &shares);
            }
            // Fast wheels leave more than a cell a step.
            let last = if forward { FIRST } else { Self::LAST };
            let cells = (travel / grid.pitch()) as usize + 1;
            for i in 0..cells {
                let back = edge * direction + direction * travel * i as f64 / cells as f64;
                self.leave(strip, last, grid, origin - f.along * back);
            }
        }
        let distance = m.velocity.dot(&m.axis) * dt;
        if distance.abs() > STILL * dt {
            self.slide(grid, m, f, distance);
        }
    }

    /// Moves the states across the footprint of a wheel that slides to the left by `distance`. What lies beside the
    /// wheel is taken from and left to the grid every couple of millimetres.
    #[inline(always)]
    fn slide(&mut self, grid: &mut Grid, m: &WheelMotion, f: &Frame, distance: f64) {
        let (strips, width) = (self.shape.strips, self.shape.width);
        let strip = |i: usize| if distance > 0.0 { i } else { strips - 1 - i };
        let turned = self.aside * distance < 0.0;
        self.aside += distance;
        // At the start it is infinite.
        if turned || self.aside.abs() >= SLIDE * grid.pitch() {
            self.aside = 0.0;
            let side: V3 = m.axis * (distance.signum() * 0.5 * (width + grid.pitch()));
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
        // From where states leave towards where they enter, so that each still finds its neighbour's old state.
        for i in 0..strips {
            let (to, from) = (strip(i), (i + 1 < strips).then(|| strip(i + 1)));
            let upstream = |states: &[Row<N>], inflow: &Row<N>| from.map_or(*inflow, |from| states[from]);
            let plastic = upstream(&self.plastic, &self.beside[0]);
            let raised = upstream(&self.raised, &self.beside[1]);
            for k in FIRST..=Self::LAST {
                // A strip that is partly on new ground is pressed into it as deep as it stands: new ground adds its
                // share of the pressure under which it yields, not the stiffness of a wall that lifts the wheel.
                let pressed = self.pressed[to][k];
                let change = c * (raised[k] - self.raised[to][k]);
                let depth = &mut self.plastic[to][k];
                *depth += c * (plastic[k].max(pressed) - *depth);
                self.raised[to][k] += change;
                if pressed > 0.0 {
                    *depth = (*depth + change).max(0.0);
                }
            }
            for states in &mut self.shear {
                let upstream = from.map_or([0.0; N], |from| states[from]);
                for (state, up) in states[to].iter_mut().zip(&upstream) {
                    *state += c * (up - *state);
                }
            }
        }
    }
}

/// Moves a row of states backward (`forward`: the wheel moves forward) by the given shares of each station's length.
#[inline(always)]
fn advect<const N: usize>(row: &mut Row<N>, inflow: f64, forward: bool, shares: &Row<N>) {
    // In place, from where states leave towards where they enter, so that each still finds its neighbour's old state.
    if forward {
        row[N - 2] = inflow;
        for k in 0..N - 1 {
            row[k] += (row[k + 1] - row[k]) * shares[k];
        }
    } else {
        row[FIRST - 1] = inflow;
        for k in (1..N).rev() {
            row[k] += (row[k - 1] - row[k]) * shares[k];
        }
    }
}
