//! The law of one soil: pressure over sinkage, shear stress over shear displacement.

use super::table::{Power, SATURATED, Saturation};
use serde::{Deserialize, Serialize};

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
    power: Power,
    saturation: Saturation,
    pub(crate) cohesion: f64,
    pub(crate) tan_phi: f64,
    pub(crate) inverse_shear_modulus: f64,
    pub(crate) elastic: f64,
    /// 1 / elastic.
    compliance: f64,
    pub(crate) damping: f64,
    pub(crate) radial: bool,
    /// (greatest slope of a heap, share of the displaced volume).
    pub(crate) heap: Option<(f64, f64)>,
    /// Stress of the shear damper per shear strength and speed of shear, s/m.
    pub(crate) shear_damping: f64,
}

/// Damping ratio of a resting vehicle's shear against the soil: a choice of ours, the soil's law has none.
const SHEAR_DAMPING_RATIO: f64 = 0.25;

impl SoilLaw {
    pub(crate) fn prepare(&self) -> Soil {
        let tan_phi = vb_math::tan(self.friction_angle_deg.to_radians());
        Soil {
            k_phi: self.k_phi,
            k_c: self.k_c,
            power: Power::new(self.n),
            saturation: Saturation::new(),
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

    /// Loads soil that has a plastic sinkage to a total sinkage; returns the pressure (0 where it doesn't reach) and
    /// whether it yields, and updates the plastic sinkage. The pressure is the smaller of the elastic line's and
    /// Bekker's: where they meet, the soil yields.
    #[inline]
    pub(crate) fn load(&self, modulus: f64, sinkage: f64, plastic: &mut f64) -> (f64, bool) {
        let elastic = self.elastic * (sinkage - *plastic);
        if elastic <= 0.0 {
            return (0.0, false);
        }
        let yielding = modulus * self.power.at(sinkage);
        if elastic <= yielding {
            return (elastic, false);
        }
        *plastic = sinkage - yielding * self.compliance;
        (yielding, true)
    }

    /// Shear stress (Pa) at a shear displacement under a pressure.
    #[inline]
    pub(crate) fn shear(&self, pressure: f64, displacement: f64) -> f64 {
        (self.cohesion + pressure * self.tan_phi)
            * self.saturation.at(displacement * self.inverse_shear_modulus)
    }

    /// Advances the shear displacement (m) by a slip velocity (m/s); returns the stress on the rim (Pa).
    #[inline]
    pub(crate) fn shear_stress(
        &self,
        displacement: &mut [f64; 2],
        slip: [f64; 2],
        pressure: f64,
        dt: f64,
    ) -> [f64; 2] {
        let j = [displacement[0] + dt * slip[0], displacement[1] + dt * slip[1]];
        *displacement = j;
        let square = j[0] * j[0] + j[1] * j[1];
        if square < 1e-24 {
            return [0.0; 2];
        }
        let size = square.sqrt();
        let inverse = 1.0 / size;
        let unit = [j[0] * inverse, j[1] * inverse];
        if size * self.inverse_shear_modulus > SATURATED {
            let most = SATURATED / self.inverse_shear_modulus;
            *displacement = [unit[0] * most, unit[1] * most];
        }
        let strength = self.cohesion + pressure * self.tan_phi;
        let stress = self.shear(pressure, size);
        // The damper fades as the soil shears.
        let damper = self.shear_damping * (strength - stress);
        let s = [-stress * unit[0] - damper * slip[0], -stress * unit[1] - damper * slip[1]];
        let total = s[0] * s[0] + s[1] * s[1];
        if total <= strength * strength {
            return s;
        }
        let scale = strength / total.sqrt();
        [s[0] * scale, s[1] * scale]
    }
}
