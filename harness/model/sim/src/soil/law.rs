//! The law of one soil: pressure over sinkage, shear stress over shear displacement.

use super::shear::{Mobilised, Prepared, Shear, ShearLaw, greater};
use super::sinkage::Sinkage;
use super::slip::{self, SlipSinkage};
use super::table::Curve;
use fearless_simd::{Simd, f64x4, prelude::*};
use serde::{Deserialize, Serialize};

/// The parameters of one soil, as a soil file gives them.
///
/// Unloading and reloading follow a straight line of slope `elastic_stiffness`. The bound of shear stress is Mohr and
/// Coulomb's, c + p tan φ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoilLaw {
    /// The pressure over sinkage.
    pub sinkage: Sinkage,
    /// The growth of sinkage with slip.
    #[serde(default)]
    pub slip_sinkage: SlipSinkage,
    /// The cohesion c, Pa.
    pub cohesion: f64,
    /// The angle of internal friction φ, degrees.
    pub friction_angle_deg: f64,
    /// The growth of shear stress with shear displacement.
    #[serde(default, skip_serializing_if = "Shear::is_default")]
    pub shear: Shear,
    /// The shear deformation modulus K, m.
    pub shear_modulus: f64,
    /// The stiffness of unloading and reloading, Pa/m.
    pub elastic_stiffness: f64,
    /// The pressure per speed of penetration, Pa s/m.
    pub damping: f64,
    pub pressure: PressureDirection,
    /// The friction coefficient of a hull of steel that slides on the soil. If it is left out, it follows from the angle of
    /// internal friction: tan(0.6 φ).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steel_friction: Option<f64>,
    /// The heaping of displaced soil. If it is left out, displaced soil vanishes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bulldozing: Option<Bulldozing>,
}

/// The direction in which the pressure of the soil acts on a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PressureDirection {
    /// The pressure acts normal to the rim, towards the axle, as in the theory of rigid wheels (Wong and Reece 1967):
    /// its horizontal part is the resistance to compaction.
    Radial,
    /// The pressure acts normal to the undisturbed ground, as in Chrono's soil contact model.
    Ground,
}

/// The heaping of displaced soil around the footprint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bulldozing {
    /// The slope at which a heap begins to slide, degrees.
    pub erosion_angle_deg: f64,
    /// The share of the displaced volume that is heaped up; the rest is compaction.
    pub flow: f64,
}

/// A soil's law with what a step needs worked out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Soil {
    pub(crate) k_phi: f64,
    pub(crate) k_c: f64,
    /// Pressure over sinkage, over the modulus.
    pub(crate) curve: Curve,
    /// Part of Lyasko's slip sinkage that the soil has, from 0 to 1.
    slip_sinkage: f64,
    pub(crate) shear: Prepared,
    pub(crate) cohesion: f64,
    pub(crate) tan_phi: f64,
    /// Of steel on the soil.
    pub(crate) steel_friction: f64,
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

/// The angle of friction of steel on soil over the soil's angle of internal friction. Potyondy (Skin friction between various
/// soils and construction materials, Géotechnique 11, 1961) found 0.5 on clay and 0.5 to 0.8 on sand, from smooth and dry to
/// rough and wet steel. With φ = 30° this value gives 0.32; NAVFAC DM-7.2 (1982) has 0.30 for steel on clean sand. Adhesion
/// is left out.
const STEEL: f64 = 0.6;
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
        let [k_phi, k_c] = self.sinkage.moduli();
        Soil {
            k_phi,
            k_c,
            curve: Curve::new(|z| self.sinkage.shape(z)),
            slip_sinkage: self.slip_sinkage.strength(),
            shear: Prepared::new(self.shear, self.shear_modulus),
            cohesion: self.cohesion,
            tan_phi,
            steel_friction: self
                .steel_friction
                .unwrap_or_else(|| vb_math::tan(STEEL * self.friction_angle_deg.to_radians())),
            elastic: self.elastic_stiffness,
            compliance: 1.0 / self.elastic_stiffness,
            damping: self.damping,
            radial: self.pressure == PressureDirection::Radial,
            heap: self.bulldozing.map(|b| (vb_math::tan(b.erosion_angle_deg.to_radians()), b.flow)),
            // 2 ζ √(k m) of a mass m = load / g on the initial shear stiffness k = load tan φ / K, per strength.
            shear_damping: 2.0 * SHEAR_DAMPING_RATIO
                / (self.shear_modulus * vb_vehicle::GRAVITY * tan_phi.max(0.2)).sqrt(),
        }
    }

    /// The pressure (Pa) under a plate whose smaller dimension is `breadth` (m), at a sinkage (m) that was never
    /// exceeded.
    #[must_use]
    pub fn pressure(&self, sinkage: f64, breadth: f64) -> f64 {
        self.sinkage.pressure(sinkage, breadth)
    }
}

impl Soil {
    /// Modulus of sinkage for a contact patch of smaller dimension `breadth`.
    #[inline]
    pub(crate) fn modulus(&self, breadth: f64) -> f64 {
        self.k_c / breadth + self.k_phi
    }

    /// Whether sinkage depends on slip.
    pub(crate) fn digs(&self) -> bool {
        self.slip_sinkage > 0.0
    }

    /// Factor from 0 to 1 of the sinkage whose pressure the law gives at a slip from 0 to 1.
    #[inline]
    pub(crate) fn shallower(&self, slip: f64) -> f64 {
        slip::shallower(self.slip_sinkage, slip)
    }

    /// Advances shear by a slip velocity (m/s) under a pressure (Pa), at four stations at once. The state is the
    /// displacement (m) that mobilises the stress, along two directions; returns it and the stress on the rim (Pa).
    /// `shear` is the law of [`Self::shear`].
    #[inline(always)]
    pub(crate) fn sheared<S: Simd>(
        &self,
        simd: S,
        shear: &impl ShearLaw,
        state: [f64x4<S>; 2],
        slip: [f64x4<S>; 2],
        pressure: f64x4<S>,
        dt: f64,
    ) -> ([f64x4<S>; 2], [f64x4<S>; 2]) {
        let all = |x: f64| f64x4::splat(simd, x);
        let (zero, one) = (all(0.0), all(1.0));
        let speed = (slip[0] * slip[0] + slip[1] * slip[1]).sqrt();
        let Mobilised { state, fraction, level } = shear.mobilise(simd, state, slip, speed, dt);
        // The damper takes a share of the strength that is left. It is for slow motion only, so that sliding soil keeps
        // its law, and as weak as makes the explicit step stable.
        let damping = self.shear_damping / (1.0 + dt * self.shear_damping * self.tan_phi * SPIN_UP);
        let fades = all(damping * CALM * CALM) / (speed * speed + all(CALM * CALM));
        let damper = greater(one - level, zero) * fades;
        let strength = all(self.cohesion) + pressure * all(self.tan_phi);
        let stress = |k: usize| -strength * (fraction[k] + slip[k] * damper);
        (state, [stress(0), stress(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::shear::with_law;
    use super::super::sinkage::Bekker;
    use super::*;
    use fearless_simd::{Level, dispatch};

    fn sand() -> Soil {
        SoilLaw {
            sinkage: Sinkage::Bekker(Bekker { k_phi: 5.301e6, k_c: 102.0e3, exponent: 0.793 }),
            slip_sinkage: SlipSinkage::None,
            cohesion: 1.3e3,
            friction_angle_deg: 31.1,
            shear: Shear::Janosi,
            shear_modulus: 0.012,
            elastic_stiffness: 4.0e8,
            damping: 0.0,
            pressure: PressureDirection::Radial,
            steel_friction: None,
            bulldozing: None,
        }
        .prepare()
    }

    /// Shears one station along a way of (velocity along and across, time); returns the stresses after each step and
    /// the work done on the soil, J/m².
    fn sheared(soil: &Soil, pressure: f64, way: &[([f64; 2], f64)], dt: f64) -> (Vec<[f64; 2]>, f64) {
        let (mut state, mut work, mut stresses) = ([0.0; 2], 0.0, vec![]);
        for &(velocity, time) in way {
            for _ in 0..(time / dt).round() as usize {
                let (after, stress) = dispatch!(Level::new(), simd => {
                    let lanes = |x: [f64; 2]| x.map(|x| f64x4::splat(simd, x));
                    let pressure = f64x4::splat(simd, pressure);
                    let (state, slip) = (lanes(state), lanes(velocity));
                    let (after, stress) =
                        with_law!(&soil.shear, law => soil.sheared(simd, law, state, slip, pressure, dt));
                    (after.map(|s| s[2]), stress.map(|s| s[2]))
                });
                state = after;
                work -= (stress[0] * velocity[0] + stress[1] * velocity[1]) * dt;
                stresses.push(stress);
            }
        }
        (stresses, work)
    }

    #[test]
    fn shear_in_one_direction_is_janosi_and_hanamotos_at_any_speed_of_sliding() {
        let soil = sand();
        let (p, dt) = (4e4, 1e-3);
        let strength = 1.3e3 + p * vb_math::tan(31.1_f64.to_radians());
        for speed in [0.3, 1.0, 5.0, 30.0] {
            let (stresses, _) = sheared(&soil, p, &[([0.6 * speed, -0.8 * speed], 0.1)], dt);
            for (k, s) in stresses.iter().enumerate() {
                let j = speed * dt * (k + 1) as f64;
                let theory = strength * (1.0 - vb_math::exp(-j / 0.012));
                let size = vb_math::hypot(s[0], s[1]);
                // The damper for slow shear is what is left of the difference.
                assert!((size - theory).abs() < 0.04 * strength, "{speed} m/s, {j} m: {size}, {theory}");
                assert!(size <= strength * (1.0 + 1e-12) && s[0] < 0.0 && s[1] > 0.0, "opposes the motion");
            }
        }
    }

    #[test]
    fn shearing_to_and_fro_takes_work_and_at_rest_the_stress_stays() {
        let soil = sand();
        for amplitude in [0.001, 0.01, 0.1] {
            let way = [([0.5, 0.0], amplitude / 0.5), ([-0.5, 0.0], amplitude / 0.5)];
            let (_, first) = sheared(&soil, 4e4, &way, 1e-4);
            let (_, both) = sheared(&soil, 4e4, &[way[0], way[1], way[0], way[1]], 1e-4);
            assert!(first > 0.0 && both > first, "{amplitude} m: {first} J/m², then {both}");
        }
        let (stresses, _) = sheared(&soil, 4e4, &[([0.2, 0.0], 0.02), ([0.0, 0.0], 10.0)], 1e-3);
        assert_eq!(stresses[20], stresses[stresses.len() - 1]);
        assert!(stresses[20][0] < -1e3);
    }
}
