//! A smooth rigid wheel on soil that yields and springs back, in closed form but for two integrals.
//!
//! In front of the axle a rim is pressed into fresh soil: at a depth z the pressure is Bekker's, p = k zⁿ with k = k_c/b + k_φ
//! (Bekker 1956; Wong, Theory of Ground Vehicles, 4th ed. 2008, eq. 2.61), or that of the elastic line p = k_e z while that is
//! less. At the bottom, at a depth z₀, it is p₀. Behind, the soil rises along p = p₀ − k_e (z₀ − z) (Wong's response to repetitive loading,
//! ibid. ch. 2) until nothing is left of the pressure. It acts along the rim's radius, so an element of a rim of width b that
//! spans dx of ground and dz of depth bears b p dx and resists b p dz, in front; behind it pushes as much:
//!
//! - W = b ∫ p dx over both arcs, x² = 2 R y − y² at a height y above the bottom, which gives z₀ of a load W;
//! - R_c = b (∫ p dz in front − ∫ p dz behind), the second of which is p₀² / (2 k_e).
//!
//! With k_e → ∞ and the parabola x² = 2 R y that is Bekker's wheel, whose own closed form also breaks a series off
//! (ibid., eqs. 2.97, 2.98). It has no elasticity.

use std::f64::consts::FRAC_PI_2;
use vb_math::{acos, cos, sin};
use vb_sim::soil::SoilLaw;

/// Parts of an arc in its integrals: a thousandth of the load is less than any check asks for.
const PARTS: u32 = 1000;

/// A wheel and what weighs on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidWheel {
    /// m.
    pub(crate) radius: f64,
    /// Breadth of the rim, m.
    pub(crate) breadth: f64,
    /// N.
    pub(crate) load: f64,
}

/// A wheel that its soil carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    /// Of the rim's lowest point, m.
    pub(crate) sinkage: f64,
    /// What the soil rises by behind the wheel, m.
    pub(crate) rebound: f64,
    /// Compaction resistance R_c, N.
    pub(crate) resistance: f64,
    /// Length of contact along the ground, in front of the axle and behind it, m.
    pub(crate) length: f64,
}

/// Integrals over the arc from the bottom of the rim up to a height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Arc {
    /// b ∫ p dx, N.
    load: f64,
    /// b ∫ p dz, N.
    along: f64,
    /// Its chord along the ground, m.
    length: f64,
}

impl RigidWheel {
    /// The wheel as the soil carries it; none if it sinks in beyond its radius, where a rim has no more front to carry it.
    pub(crate) fn on(&self, law: &SoilLaw) -> Option<Carried> {
        let bears = |sinkage: f64| {
            let [front, rear] = self.arcs(law, sinkage);
            front.load + rear.load
        };
        let (mut low, mut high) = (0.0, self.radius);
        if bears(high) < self.load {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if bears(middle) < self.load { low = middle } else { high = middle }
        }
        let [front, rear] = self.arcs(law, high);
        Some(Carried {
            sinkage: high,
            rebound: self.rebound(law, high),
            resistance: front.along - rear.along,
            length: front.length + rear.length,
        })
    }

    /// Lengths of contact along the ground (m) in front of the axle and behind it, with the bottom at a depth (m).
    pub(crate) fn contact(&self, law: &SoilLaw, depth: f64) -> [f64; 2] {
        self.arcs(law, depth).map(|arc| arc.length)
    }

    /// Pressure on fresh soil at a depth (m): the less of Bekker's and of the elastic line, Pa.
    fn pressure(&self, law: &SoilLaw, depth: f64) -> f64 {
        law.pressure(depth, self.breadth).min(law.elastic_stiffness * depth.max(0.0))
    }

    /// What soil rises by that was pressed to a depth, m.
    fn rebound(&self, law: &SoilLaw, depth: f64) -> f64 {
        self.pressure(law, depth) / law.elastic_stiffness
    }

    /// In front of the axle and behind it, with the bottom at a depth, m.
    fn arcs(&self, law: &SoilLaw, depth: f64) -> [Arc; 2] {
        let most = self.pressure(law, depth);
        [
            self.arc(depth, |height| self.pressure(law, depth - height)),
            self.arc(self.rebound(law, depth), |height| most - law.elastic_stiffness * height),
        ]
    }

    /// Up to a height (m) over the bottom, under a pressure (Pa) that depends on the height.
    fn arc(&self, height: f64, pressure: impl Fn(f64) -> f64) -> Arc {
        let (r, b) = (self.radius, self.breadth);
        let end = acos(1.0 - (height / r).min(1.0)).min(FRAC_PI_2);
        let part = end / f64::from(PARTS);
        let mut arc = Arc { length: r * sin(end), ..Arc::default() };
        for k in 0..PARTS {
            let angle = (f64::from(k) + 0.5) * part;
            let force = b * pressure(r * (1.0 - cos(angle))).max(0.0) * r * part;
            arc.load += force * cos(angle);
            arc.along += force * sin(angle);
        }
        arc
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::pow;
    use vb_sim::soil::{Bekker, PressureDirection, Shear, Sinkage, SlipSinkage};

    const WHEEL: RigidWheel = RigidWheel { radius: 0.467, breadth: 0.3175, load: 6369.0 };

    fn soil(k_phi: f64, n: f64, elastic_stiffness: f64) -> SoilLaw {
        SoilLaw {
            sinkage: Sinkage::Bekker(Bekker { k_phi, k_c: 0.0, exponent: n }),
            slip_sinkage: SlipSinkage::None,
            cohesion: 0.0,
            friction_angle_deg: 0.0,
            shear: Shear::Janosi,
            shear_modulus: 0.01,
            elastic_stiffness,
            damping: 0.0,
            pressure: PressureDirection::Radial,
            steel_friction: None,
            bulldozing: None,
        }
    }

    /// Bekker's wheel: z = [3 W / (b (3 − n) k √D)]^(2 / (2 n + 1)), R_c = b k z^(n + 1) / (n + 1).
    fn bekker(k: f64, n: f64) -> (f64, f64) {
        let RigidWheel { radius, breadth, load } = WHEEL;
        let z = pow(3.0 * load / (breadth * (3.0 - n) * k * (2.0 * radius).sqrt()), 2.0 / (2.0 * n + 1.0));
        (z, breadth * k * pow(z, n + 1.0) / (n + 1.0))
    }

    fn near(a: f64, b: f64, fraction: f64) -> bool {
        (a / b - 1.0).abs() <= fraction
    }

    #[test]
    fn without_elasticity_it_is_bekkers_wheel() {
        // Of n = 1 Bekker's series has no more terms, so that only the parabola in place of the circle is left. Of other n it
        // has: ∫ (1 − s²)ⁿ ds from 0 to 1 is 2 % more than the (3 − n)/3 that it keeps for n = 1.1, 4 % less for 0.8.
        for (k, n, fraction) in [(2e7, 1.0, 0.01), (2e7, 1.1, 0.03), (8e6, 0.8, 0.07)] {
            let wheel = WHEEL.on(&soil(k, n, 1e13)).unwrap();
            let (z, rc) = bekker(k, n);
            assert!(z < 0.03, "{z} m is small beside the radius");
            assert!(near(wheel.sinkage, z, fraction), "n {n}: {} m, Bekker {z}", wheel.sinkage);
            assert!(near(wheel.resistance, rc, fraction), "n {n}: {} N, Bekker {rc}", wheel.resistance);
            assert!(
                near(wheel.length, (2.0 * WHEEL.radius * z - z * z).sqrt(), fraction),
                "{}",
                wheel.length
            );
            assert!(wheel.rebound < 1e-5 * z);
        }
    }

    #[test]
    fn both_arcs_bear_the_load_and_resist_by_the_work_that_does_not_come_back() {
        for (k, n) in [(2e6, 1.1), (5.6e6, 0.793), (2e5, 1.1)] {
            let law = soil(k, n, 4e8);
            let wheel = WHEEL.on(&law).unwrap();
            let [front, rear] = WHEEL.arcs(&law, wheel.sinkage);
            assert!(near(front.load + rear.load, WHEEL.load, 1e-9), "{front:?} {rear:?}");
            assert!(rear.load > 0.01 * WHEEL.load && rear.load < 0.2 * WHEEL.load, "{rear:?}");
            let p = k * pow(wheel.sinkage, n);
            let kept = k * pow(wheel.sinkage, n + 1.0) / (n + 1.0) - p * p / (2.0 * law.elastic_stiffness);
            assert!(near(wheel.resistance, WHEEL.breadth * kept, 1e-4), "{} N", wheel.resistance);
            assert!(near(wheel.rebound, p / law.elastic_stiffness, 1e-12));
            // The chords of both arcs, each by its height.
            let chord = |y: f64| (2.0 * WHEEL.radius * y - y * y).sqrt();
            assert!(near(wheel.length, chord(wheel.sinkage) + chord(wheel.rebound), 1e-9));
        }
    }

    #[test]
    fn soil_that_only_springs_carries_it_alike_in_front_and_behind_without_resistance() {
        let law = soil(1e9, 0.1, 4e6);
        let wheel = WHEEL.on(&law).unwrap();
        // W = 2 b k_e ∫ (z₀ − y) dx, on a parabola 2 b k_e (2/3) z₀ √(2 R z₀).
        let z = wheel.sinkage;
        let load = 4.0 / 3.0 * WHEEL.breadth * 4e6 * z * (2.0 * WHEEL.radius * z).sqrt();
        assert!(near(load, WHEEL.load, 0.01), "{z} m: {load} N");
        assert!(wheel.resistance.abs() < 1e-9 * WHEEL.load, "{} N", wheel.resistance);
        assert!(near(wheel.rebound, z, 1e-12));
    }

    #[test]
    fn what_sinks_in_beyond_its_radius_is_carried_by_no_theory() {
        assert!(WHEEL.on(&soil(2e4, 1.4, 1e7)).is_none());
    }
}
