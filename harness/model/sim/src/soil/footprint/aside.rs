//! The resistance of the ground beside a wheel, or a belt, that slides into it.

use super::super::law::Soil;
use super::press::{Sum, store, total};
use super::transport::STILL;
use super::{Footprint, LANES, Row, Step};
use fearless_simd::{Simd, f64x4, prelude::*};

/// Speed to the side, m/s, at which half of the resistance acts: it is a friction, made smooth for the integration. Ours.
const HALF: f64 = 0.03;

impl<const N: usize> Footprint<N> {
    /// Resists sliding to the side by the work of compaction that this takes: the ground that comes under the leading edge
    /// is pressed as deep as the rim stands, which takes ∫p dz an area, and the energy of its elastic rebound. In the
    /// direction of travel the same work is the horizontal component of the pressure on the rim (Bekker, Introduction to
    /// Terrain-Vehicle Systems, 1969, part II, ch. 1: R = b ∫p dz); a pressure without a component along the axle leaves it
    /// out, and a wheel that slides into a bank would be lifted for nothing.
    #[inline(always)]
    pub(super) fn resist_aside<S: Simd>(&mut self, simd: S, soil: &Soil, step: &Step<'_>, sum: &mut Sum) {
        let Step { motion: m, frame: f, dt, .. } = step;
        let speed = m.velocity.dot(&f.axis);
        if !soil.radial || speed.abs() < STILL || !self.aside.is_finite() {
            return;
        }
        let leading = if speed > 0.0 { self.shape.strips - 1 } else { 0 };
        let all = |x: f64| f64x4::splat(simd, x);
        let load = |row: &Row<N>, g: usize| f64x4::from_slice(simd, &row[g..g + LANES]);
        let (zero, half) = (all(0.0), all(0.5));
        let (modulus, shallower) = (all(soil.modulus(self.breadth)), all(soil.shallower(self.slip)));
        let damping = all(1.0 / (speed.abs() + HALF));
        let (mut along_axis, mut about_heading, mut about_up) = (zero, zero, zero);
        for g in (0..N).step_by(LANES) {
            let pressed = load(&self.pressed[leading], g);
            // Depths below the surface beside, with its heaps.
            let from = load(&self.beside[0], g);
            let to = pressed + load(&self.beside[1], g) - load(&self.raised[leading], g);
            let meets = pressed.simd_gt(zero) & to.simd_gt(from);
            if !meets.any_true() {
                continue;
            }
            let first = pressure(simd, soil, from, modulus, shallower);
            let middle = pressure(simd, soil, (from + to) * half, modulus, shallower);
            let last = pressure(simd, soil, to, modulus, shallower);
            let plastic = (to - from) * (first + middle * all(4.0) + last) * all(1.0 / 6.0);
            let elastic = last * last * all(0.5 * soil.compliance);
            // N s/m.
            let lengths = load(&self.shape.lengths, g);
            let resistance = meets.select((plastic + elastic) * lengths * damping, zero);
            let force = zero - resistance * all(speed);
            along_axis += resistance;
            about_heading += load(&self.shape.half, g) * force;
            about_up += load(&self.shape.xs, g) * force;
            if let Some(stations) = &mut self.stations {
                let row = &mut stations.force[1];
                let with = load(row, g) + force;
                store(row, g, with);
            }
        }
        let damping = total(along_axis);
        sum.force.y -= damping * speed;
        sum.moment.x += total(about_heading);
        sum.moment.z += total(about_up);
        // Of the inertia's components, that along the axle.
        sum.inertia[3] += dt * damping;
    }
}

/// The pressure (Pa) at depths (m). A closure would be compiled without the instructions of its caller, and would call each one.
#[inline(always)]
fn pressure<S: Simd>(
    simd: S,
    soil: &Soil,
    depth: f64x4<S>,
    modulus: f64x4<S>,
    shallower: f64x4<S>,
) -> f64x4<S> {
    soil.curve.at(simd, depth * shallower) * modulus
}

#[cfg(test)]
mod tests {
    use super::super::super::ground::SoilGround;
    use super::super::super::law::SoilLaw;
    use super::super::super::sinkage::{Bekker, Sinkage};
    use super::super::tests::linear;
    use super::*;
    use crate::V3;
    use crate::tyre::WheelMotion;
    use vb_world::Heightfield;

    const RADIUS: f64 = 0.47;
    const WIDTH: f64 = 0.3;
    const MODULUS: f64 = 1e6;

    /// A wheel that slides at 1 m/s to the left, over a plane that rises to the left, with its middle at a constant depth (m):
    /// the force on it (N) after 0.5 m and the power (W) that the soil gives it. The soil has no shear strength.
    fn slide(rise: f64, depth: f64) -> (V3, f64) {
        let law = SoilLaw {
            sinkage: Sinkage::Bekker(Bekker { k_phi: MODULUS, k_c: 0.0, exponent: 1.0 }),
            friction_angle_deg: 0.0,
            ..linear()
        };
        let surface = Heightfield::new(9, 9, 1.0, (0..81).map(|i| rise * f64::from(i / 9)).collect());
        let mut ground = SoilGround::of_one(law.prepare(), [4.0, 4.0], 0.05);
        let mut wheel = Footprint::wheel(RADIUS, WIDTH, 0.05);
        let velocity = V3::new(0.0, 1.0, rise);
        let from = V3::new(0.0, -1.0, surface.height(0.0, -1.0) + RADIUS - depth);
        let mut force = V3::zeros();
        for step in 0..500 {
            let hub = from + velocity * (1e-3 * f64::from(step));
            let motion = WheelMotion { hub, velocity, rotation: V3::zeros(), axis: V3::y(), spin: 0.0 };
            let under = ground.under(hub.x, hub.y, RADIUS);
            force = wheel.step(&mut ground, &surface, under, &motion, 1e-3).expect("it is in the soil").force;
        }
        (force, force.dot(&velocity))
    }

    #[test]
    fn sliding_into_level_ground_takes_the_work_of_its_compaction() {
        let depth = 0.08;
        // ∫∫p dz dx over the outline of a circle.
        let sinkage = |x: f64| (depth - RADIUS + (RADIUS * RADIUS - x * x).sqrt()).max(0.0);
        let steps = 1000;
        let width = RADIUS / f64::from(steps);
        let work = (-steps..=steps).map(|k| {
            0.5 * MODULUS
                * {
                    let z = sinkage(width * f64::from(k));
                    z * z
                }
                * width
        });
        let expected = work.sum::<f64>() / (1.0 + HALF);
        let (force, _) = slide(0.0, depth);
        assert!((-force.y / expected - 1.0).abs() < 0.05, "{} N, by theory {expected} N", -force.y);
    }

    #[test]
    fn a_bank_does_not_lift_a_wheel_that_slides_into_it_for_nothing() {
        for rise in [0.2, 0.4, 0.7] {
            let (force, power) = slide(rise, 0.08);
            assert!(force.z > 1e3, "{} N", force.z);
            // The friction at this speed is short of the whole by HALF.
            assert!(power < HALF * force.z * rise, "{rise}: {power} W, {force:?}");
        }
    }
}
