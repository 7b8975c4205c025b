//! The belt on soil: its outline under the wheels, which the soil presses back, and which bends where it does.

use super::super::{Corner, Forces, Ground, Vehicle};
use super::Track;
use super::span::lever;
use crate::soil::Under;
use crate::tyre::WheelMotion;
use crate::{M3, V3};

/// Damping of a span's bend over what is critical.
const DAMPING: f64 = 0.5;
/// Greatest bend of a span over its length.
const DEEPEST: f64 = 0.3;

impl Track {
    /// Sets the outline of the footprint to where the belt's face is: arcs about the wheels, and between them spans that
    /// bend as parabolas.
    fn outline(&mut self, forces: &[Forces], corners: &[Corner], up: &V3) {
        let [middle, level] = self.data.middle;
        let face = 0.5 * self.data.spec.thickness;
        let discs = self.course.discs();
        let spans = self.course.spans();
        let last = discs.len() - 1;
        let first = self.first;
        let rising = |j: usize| {
            let i = first + 2 * j;
            forces[i].tangent.dot(up) * corners[i].travel_rate
        };
        for (k, place) in self.footprint.places() {
            let x = middle + place;
            // The first span that ends behind the station, and whether it begins before it.
            let edge = |j: usize, part: f64| {
                let out = spans[j].outward();
                let at = spans[j].at(part);
                [at[0] + face * out[0], at[1] + face * out[1]]
            };
            let j = (0..last).find(|&j| edge(j, 1.0)[0] <= x).unwrap_or(last);
            if j < last && edge(j, 0.0)[0] > x {
                let ([x0, z0], s) = (edge(j, 0.0), &spans[j]);
                let [dx, dz] = s.direction;
                let run = s.length * dx;
                let part = (x - x0) / run;
                let bend = self.spans[j].sag / -dx;
                let shape = 4.0 * part * (1.0 - part);
                let z = z0 + (x - x0) * dz / dx + shape * bend;
                let slope = dz / dx + 4.0 * (1.0 - 2.0 * part) * bend / run;
                let rate =
                    rising(j) * (1.0 - part) + rising(j + 1) * part + shape * self.spans[j].sag_rate / -dx;
                self.footprint.set(k, level - z, slope, rate);
                self.fractions[k] = (j, part);
            } else {
                // On the wheel before the span that begins further back.
                let d = &discs[j];
                let radius = d.radius + face;
                let ahead = (x - d.centre[0]).clamp(-0.95 * radius, 0.95 * radius);
                let down = (radius * radius - ahead * ahead).sqrt();
                self.footprint.set(k, level - d.centre[1] + down, ahead / down, rising(j));
                self.fractions[k] = (j, 0.0);
            }
        }
    }

    /// How much longer the way is for the bend of the spans, m: (8/3) s²/L each, as parabolas.
    pub(super) fn bent(&self) -> f64 {
        let longer = |(s, c): (&super::Span, &crate::track::Span)| 8.0 / 3.0 * s.sag * s.sag / c.length;
        self.spans.iter().zip(self.course.spans()).map(longer).sum()
    }

    /// Bends the spans under the soil's pressure and their tension; for each span the generalised force Σ f φ, N, and the mass
    /// that the soil's implicit treatment adds, kg.
    ///
    /// With the shape of a parabola, w = s φ, φ = 4 ξ (1 − ξ), virtual work gives (8/15) μ L s̈ = Σ f φ − (16/3) (T/L) s with μ
    /// the mass of a metre. At rest under an even pressure that is the parabola's own law s = q L²/(8 T).
    pub(super) fn bend(&mut self, loads: &[(f64, f64)], dt: f64) {
        for ((span, course), &(load, added)) in self.spans.iter_mut().zip(self.course.spans()).zip(loads) {
            let mass = 8.0 / 15.0 * self.data.line_density * course.length;
            let stiffness = (16.0 / 3.0) * span.tension / course.length;
            let damping = 2.0 * DAMPING * (mass * stiffness).sqrt();
            let force = load - stiffness * span.sag - damping * span.sag_rate;
            span.sag_rate += dt * force / (mass + added + dt * damping + dt * dt * stiffness);
            let sag = span.sag + dt * span.sag_rate;
            span.sag = sag.clamp(0.0, DEEPEST * course.length);
            if span.sag != sag {
                span.sag_rate = 0.0;
            }
        }
    }
}

impl Vehicle {
    /// Forces of the soil on a track.
    pub(super) fn press_soil(
        &mut self,
        t: &mut Track,
        ground: &mut Ground<'_>,
        under: Under,
        turn: &M3,
        dt: f64,
    ) {
        if under != Under::Rigid {
            t.outline(&self.forces, &self.corners, &turn.column(2).into_owned());
        }
        let [forward, level] = t.data.middle;
        let middle = V3::new(forward, t.aside, level);
        let arm = turn * middle;
        let axis = turn.column(1).into_owned();
        let motion = WheelMotion {
            hub: self.x + arm,
            velocity: self.v + self.w.cross(&arm),
            rotation: self.w,
            axis,
            spin: 0.0,
        };
        let axes = [turn.column(0).into_owned(), turn.column(2).into_owned()];
        let touched =
            t.footprint.step_belt(ground.soil, ground.heightfield, under, &motion, axes, t.speed, dt);
        let mut loads = [(0.0, 0.0); vb_vehicle::MAX_WHEELS];
        if touched.is_some()
            && let Some(stations) = t.footprint.stations()
        {
            for (k, place) in t.footprint.places() {
                let force = V3::new(stations.force[0][k], stations.force[1][k], stations.force[2][k]);
                if force == V3::zeros() {
                    continue;
                }
                let (j, part) = t.fractions[k];
                let (below, normal) = t.footprint.outline(k);
                let normal = Track::in_world(turn, normal);
                let at = arm + turn * V3::new(place, 0.0, -below);
                let (a, b) = (t.wheel(j), t.wheel((j + 1).min(t.count() - 1)));
                let fraction = if part > 0.0 && a != b {
                    lever(&at, &self.forces[a].arm, &self.forces[b].arm, &normal, &axis)
                } else {
                    0.0
                };
                let force = turn * force;
                let inertia = normal * normal.transpose() * stations.inertia[k];
                let pressed = force.dot(&normal);
                let load = force.dot(&axes[1]);
                self.share_out(a, b, fraction, &at, &force, &inertia, load, &axis);
                let turning = turn * V3::new(stations.moment[0][k], 0.0, stations.moment[1][k]);
                self.forces[a].moment += turning * (1.0 - fraction);
                self.forces[b].moment += turning * fraction;
                t.thrust[j] += stations.thrust[k] * (1.0 - fraction);
                t.thrust[(j + 1).min(t.spans.len())] += stations.thrust[k] * fraction;
                for i in [a, b] {
                    let c = &mut self.corners[i];
                    c.sinkage = c.sinkage.max(stations.sinkage[k]);
                }
                if part > 0.0 {
                    let shape = 4.0 * part * (1.0 - part);
                    let (sum, added) = &mut loads[j];
                    *sum += pressed * shape;
                    *added += stations.inertia[k] * shape * shape;
                }
            }
        }
        t.bend(&loads, dt);
    }
}
