//! The belt on soil: its outline under the wheels, which the soil presses back, and which bends where it does.

use super::super::ground::Ground;
use super::super::kinematics::Kinematics;
use super::super::state::Span;
use super::{Push, TrackStep, in_world, lever, share_out};
use crate::V3;
use crate::soil::Under;
use crate::tyre::WheelMotion;

/// Damping of a span's bend over what is critical.
const DAMPING: f64 = 0.5;
/// Greatest bend of a span over its length.
const DEEPEST: f64 = 0.3;

impl TrackStep<'_> {
    /// Sets the outline of the footprint to where the belt's face is: arcs about the wheels, and between them spans that
    /// bend as parabolas.
    fn outline(&mut self, kinematics: &Kinematics<'_>) {
        let up = kinematics.turn.column(2).into_owned();
        let track = self.track;
        let [middle, level] = track.middle;
        let face = 0.5 * track.spec.thickness;
        let discs = self.laid.course.discs();
        let spans = self.laid.course.spans();
        let last = discs.len() - 1;
        let rising = |j: usize| {
            let i = track.wheel(j);
            kinematics.placements[i].tangent.dot(&up) * kinematics.wheels[i].travel_rate
        };
        for (k, place) in self.belt.footprint.places() {
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
                let bend = self.belt.spans[j].sag / -dx;
                let shape = 4.0 * part * (1.0 - part);
                let z = z0 + (x - x0) * dz / dx + shape * bend;
                let slope = dz / dx + 4.0 * (1.0 - 2.0 * part) * bend / run;
                let rate = rising(j) * (1.0 - part)
                    + rising(j + 1) * part
                    + shape * self.belt.spans[j].sag_rate / -dx;
                self.belt.footprint.set(k, level - z, slope, rate);
                self.laid.fractions[k] = (j, part);
            } else {
                // On the wheel before the span that begins further back.
                let d = &discs[j];
                let radius = d.radius + face;
                let ahead = vb_math::clamp(x - d.centre[0], -0.95 * radius, 0.95 * radius);
                let down = (radius * radius - ahead * ahead).sqrt();
                self.belt.footprint.set(k, level - d.centre[1] + down, ahead / down, rising(j));
                self.laid.fractions[k] = (j, 0.0);
            }
        }
    }

    /// How much longer the way is for the bend of the spans, m: (8/3) s²/L each, as parabolas.
    pub(super) fn bent(&self) -> f64 {
        let longer = |(s, c): (&Span, &crate::track::Span)| 8.0 / 3.0 * s.sag * s.sag / c.length;
        self.belt.spans.iter().zip(self.laid.course.spans()).map(longer).sum()
    }

    /// Bends the spans under the soil's pressure and their tension; for each span the generalised force Σ f φ, N, and the mass
    /// that the soil's implicit treatment adds, kg.
    ///
    /// With the shape of a parabola, w = s φ, φ = 4 ξ (1 − ξ), virtual work gives (8/15) μ L s̈ = Σ f φ − (16/3) (T/L) s with μ
    /// the mass of a metre. At rest under an even pressure that is the parabola's own law s = q L²/(8 T).
    pub(super) fn bend(&mut self, loads: &[(f64, f64)], dt: f64) {
        for ((span, course), &(load, added)) in
            self.belt.spans.iter_mut().zip(self.laid.course.spans()).zip(loads)
        {
            let mass = 8.0 / 15.0 * self.track.line_density * course.length;
            let stiffness = (16.0 / 3.0) * span.tension / course.length;
            let damping = 2.0 * DAMPING * (mass * stiffness).sqrt();
            let force = load - stiffness * span.sag - damping * span.sag_rate;
            span.sag_rate += dt * force / (mass + added + dt * damping + dt * dt * stiffness);
            let sag = span.sag + dt * span.sag_rate;
            span.sag = vb_math::clamp(sag, 0.0, DEEPEST * course.length);
            if span.sag != sag {
                span.sag_rate = 0.0;
            }
        }
    }

    pub(super) fn press_soil(
        &mut self,
        kinematics: &Kinematics<'_>,
        ground: &mut Ground<'_>,
        under: Under,
        dt: f64,
    ) {
        if under.has_soil() {
            self.outline(kinematics);
        }
        let Kinematics { body, turn, placements, .. } = kinematics;
        let track = self.track;
        let [forward, level] = track.middle;
        let middle = V3::new(forward, track.aside, level);
        let arm = turn * middle;
        let axis = turn.column(1).into_owned();
        let motion = WheelMotion {
            hub: body.x_world + arm,
            velocity: body.v_world + body.w_world.cross(&arm),
            rotation: body.w_world,
            axis,
            spin: 0.0,
        };
        let axes = [turn.column(0).into_owned(), turn.column(2).into_owned()];
        let touched = self.belt.footprint.step_belt(
            ground.soil,
            ground.heightfield,
            under,
            &motion,
            axes,
            self.belt.speed,
            dt,
        );
        let mut loads = [(0.0, 0.0); vb_vehicle::MAX_WHEELS];
        if touched.is_some()
            && let Some(stations) = self.belt.footprint.stations()
        {
            for (k, place) in self.belt.footprint.places() {
                let force = V3::new(stations.force[0][k], stations.force[1][k], stations.force[2][k]);
                if force == V3::zeros() {
                    continue;
                }
                let (j, part) = self.laid.fractions[k];
                let (below, normal) = self.belt.footprint.outline(k);
                let normal = in_world(turn, normal);
                let at = arm + turn * V3::new(place, 0.0, -below);
                let (a, b) = (track.wheel(j), track.wheel((j + 1).min(track.count() - 1)));
                let fraction = if part > 0.0 && a != b {
                    lever(&at, &placements[a].arm, &placements[b].arm, &normal, &axis)
                } else {
                    0.0
                };
                let force = turn * force;
                let inertia = normal * normal.transpose() * stations.inertia[k];
                let pressed = force.dot(&normal);
                let push = Push { at, force, inertia, load: force.dot(&axes[1]) };
                share_out(self.forces, placements, [a, b], fraction, &push, &axis);
                let turning = turn * V3::new(stations.moment[0][k], 0.0, stations.moment[1][k]);
                self.forces[a].moment += turning * (1.0 - fraction);
                self.forces[b].moment += turning * fraction;
                self.laid.thrust[j] += stations.thrust[k] * (1.0 - fraction);
                self.laid.thrust[(j + 1).min(self.belt.spans.len())] += stations.thrust[k] * fraction;
                for i in [a, b] {
                    let f = &mut self.forces[i];
                    f.sinkage = f.sinkage.max(stations.sinkage[k]);
                }
                if part > 0.0 {
                    let shape = 4.0 * part * (1.0 - part);
                    let (sum, added) = &mut loads[j];
                    *sum += pressed * shape;
                    *added += stations.inertia[k] * shape * shape;
                }
            }
        }
        self.bend(&loads, dt);
    }
}
