//! The law of one soil: pressure over sinkage, shear stress over shear displacement.

use super::table::Power;
use serde::{Deserialize, Serialize};
use wide::f64x4;

/// The parameters of one soil, as a soil file gives them.
///
/// Pressure over sinkage is Bekker's as Wong restates it (Theory of Ground Vehicles, 4th ed. 2008, eq. 2.61):
/// p = (k_c/b + k_φ) zⁿ with the smaller dimension b of the contact patch. Unloading and reloading follow a straight
/// line of slope `elastic_stiffness`. Shear stress over shear displacement j is Janosi and Hanamoto's (ibid. eq.
/// 2.73): τ = (c + p tan φ)(1 − exp(−j/K)), whose bound is Mohr and Coulomb's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoilLaw {
    /// Frictional modulus k_φ, N/m^(n+2).
    pub k_phi: f64,
    /// Cohesive modulus k_c, N/m^(n+1).
    pub k_c: f64,
    /// Exponent n of sinkage.
    pub n: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Angle of internal friction φ, degrees.
    pub friction_angle_deg: f64,
    /// Shear deformation modulus K of Janosi and Hanamoto, m.
    pub shear_modulus: f64,
    /// Stiffness of unloading and reloading, Pa/m.
    pub elastic_stiffness: f64,
    /// Pressure per speed of penetration, Pa s/m.
    pub damping: f64,
    /// Which way the pressure acts on a wheel.
    pub pressure: PressureDirection,
    /// What becomes of displaced soil; left out, it vanishes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bulldozing: Option<Bulldozing>,
}

/// Which way the pressure of the soil acts on a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PressureDirection {
    /// Normal to the rim, towards the axle, as in the theory of rigid wheels (Wong and Reece 1967): its horizontal
    /// part is the resistance to compaction.
    Radial,
    /// Normal to the undisturbed ground, as in Chrono's soil contact model.
    Ground,
}

/// Displaced soil is heaped up around the footprint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bulldozing {
    /// Slope at which a heap begins to slide, degrees.
    pub erosion_angle_deg: f64,
    /// Share of the displaced volume that is heaped up; the rest is compaction.
    pub flow: f64,
}

/// A soil's law with what a step needs worked out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Soil {
    pub(crate) k_phi: f64,
    pub(crate) k_c: f64,
    pub(crate) power: Power,
    pub(crate) cohesion: f64,
    pub(crate) tan_phi: f64,
    pub(crate) inverse_shear_modulus: f64,
    pub(crate) elastic: f64,
    /// 1 / elastic.
    pub(crate) compliance: f64,
    pub(crate) damping: f64,
    pub(crate) radial: bool,
    /// (greatest slope of a heap, share of the displaced volume).
    pub(crate) heap: Option<(f64, f64)>,
    /// Stress of the shear damper per free shear strength and speed of slow shear, s/m.
    pub(crate) shear_damping: f64,
}

/// Damping ratio of a resting vehicle's shear against the soil, and the speed of shear (m/s) at which half of the damping
/// is gone: choices of ours, the soil's law has none. It takes this much to calm a vehicle whose brakes are off where
/// pressure acts normal to the ground, as such a pressure feeds motion (docs/physics.md).
const SHEAR_DAMPING_RATIO: f64 = 2.0;
const CALM: f64 = 0.03;
/// A wheel's load over the mass that resists its spinning up, m/s²: the damper must not stop it in less than a step.
const SPIN_UP: f64 = 60.0;

impl SoilLaw {
    pub(crate) fn prepare(&self) -> Soil {
        let tan_phi = vb_math::tan(self.friction_angle_deg.to_radians());
        Soil {
            k_phi: self.k_phi,
            k_c: self.k_c,
            power: Power::new(self.n),
            cohesion: self.cohesion,
            tan_phi,
            inverse_shear_modulus: 1.0 / self.shear_modulus,
            elastic: self.elastic_stiffness,
            compliance: 1.0 / self.elastic_stiffness,
            damping: self.damping,
            radial: self.pressure == PressureDirection::Radial,
            heap: self.bulldozing.map(|b| (vb_math::tan(b.erosion_angle_deg.to_radians()), b.flow)),
            // 2 ζ √(k m) of a mass m = load / g on the initial shear stiffness k = load tan φ / K, per strength.
            shear_damping: 2.0 * SHEAR_DAMPING_RATIO
                / (self.shear_modulus * crate::GRAVITY * tan_phi.max(0.2)).sqrt(),
        }
    }

    /// Pressure (Pa) under a plate of smaller dimension `breadth` (m) at a sinkage (m) that was never exceeded.
    #[must_use]
    pub fn pressure(&self, sinkage: f64, breadth: f64) -> f64 {
        (self.k_c / breadth + self.k_phi) * vb_math::pow(sinkage.max(0.0), self.n)
    }
}

impl Soil {
    /// Modulus of sinkage for a contact patch of smaller dimension `breadth`.
    #[inline]
    pub(crate) fn modulus(&self, breadth: f64) -> f64 {
        self.k_c / breadth + self.k_phi
    }

    /// Advances shear by a slip velocity (m/s) under a pressure (Pa), at four stations at once. The state is the share
    /// of the shear strength that is mobilised, along two directions; returns it and the stress on the rim (Pa).
    ///
    /// Janosi and Hanamoto's τ = s (1 − exp(−j/K)) is the solution of dτ/dj = (s − τ)/K under a displacement j in one
    /// direction. In this form it is also defined where the direction changes: stress turns over a displacement of the
    /// order of K and shearing to and fro takes work (the same equation is Dahl's model of friction, 1968), whereas
    /// a stress that depends on the displacement alone would give all work back, as a spring would.
    #[inline]
    pub(crate) fn shear(
        &self,
        state: [f64x4; 2],
        slip: [f64x4; 2],
        pressure: f64x4,
        dt: f64,
    ) -> ([f64x4; 2], [f64x4; 2]) {
        let one = f64x4::splat(1.0);
        let speed = (slip[0] * slip[0] + slip[1] * slip[1]).sqrt();
        let per_speed = f64x4::splat(dt * self.inverse_shear_modulus);
        let u = speed * per_speed;
        // (exp(u) − 1)/u by its series: where the terms left out matter, exp(−u) is as good as none.
        let series =
            one + u * (f64x4::splat(0.5) + u * (f64x4::splat(1.0 / 6.0) + u * f64x4::splat(1.0 / 24.0)));
        let keep = one / (one + u * series);
        let gain = per_speed * series;
        let after = [(state[0] + slip[0] * gain) * keep, (state[1] + slip[1] * gain) * keep];
        // The damper takes a share of the strength that is left. It is for slow motion only, so that sliding soil keeps
        // its law, and as weak as makes the explicit step stable.
        let mobilised = (after[0] * after[0] + after[1] * after[1]).sqrt();
        let damping = self.shear_damping / (1.0 + dt * self.shear_damping * self.tan_phi * SPIN_UP);
        let fades = f64x4::splat(damping * CALM * CALM) / (speed * speed + f64x4::splat(CALM * CALM));
        let damper = (one - mobilised) * fades;
        let strength = f64x4::splat(self.cohesion) + pressure * f64x4::splat(self.tan_phi);
        let stress = |k: usize| -strength * (after[k] + slip[k] * damper);
        (after, [stress(0), stress(1)])
    }
}
