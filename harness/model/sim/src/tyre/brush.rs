//! The brush.

use super::TyreForce;
use super::patch::{Patch, PlaneForce, Slide, Stance, norm};
use crate::V3;
use vb_vehicle::tyre::BrushTyre;

/// Forces of a tyre in its contact plane: a brush with relaxation.
///
/// The tread deflects by `u` (m) against the ground: u̇ = v_s − |v_r| u/σ with the sliding velocity v_s of the contact
/// patch, the rolling speed v_r and the relaxation length σ of each direction (Pacejka, Tire and Vehicle Dynamics,
/// 2012, eq. 7.8 ff.). The force follows the brush model with a parabolic pressure distribution (ibid. eq. 3.11,
/// 3.40): with e = (C/σ) u the force of full adhesion and x = |e|/(μF_z), F = μF_z(x − x²/3 + x³/27) up to x = 3 and
/// μF_z beyond. At rest the deflection is a spring, so a braked vehicle stays where it is on a slope up to atan μ.
#[derive(Clone, Debug)]
pub(crate) struct Brush {
    stiffness: f64,
    friction: f64,
    /// Per unit load and deflection, 1/m.
    bristle: [f64; 2],
    damping: [f64; 2],
    relaxation: [f64; 2],
    rolling_resistance: f64,
}

impl Brush {
    pub(crate) fn new(t: &BrushTyre) -> Self {
        let bristle = std::array::from_fn(|k| t.slip_stiffness[k] / t.relaxation_length[k]);
        // 2 ζ √(k m) per unit load, with k = stiffness · load and m = load / g.
        let damping = bristle.map(|k: f64| 2.0 * t.damping_ratio * (k / vb_vehicle::GRAVITY).sqrt());
        Self {
            stiffness: t.vertical_stiffness,
            friction: t.friction,
            bristle,
            damping,
            relaxation: t.relaxation_length,
            rolling_resistance: t.rolling_resistance,
        }
    }

    /// Advances the deflection; returns the force on the wheel, N.
    #[inline]
    fn drag(&self, patch: &mut Patch, s: &Slide, dt: f64) -> [f64; 2] {
        let load = s.load;
        let limit = s.friction.min(self.friction) * load;
        let mut rate = [0.0; 2];
        for (k, rate) in rate.iter_mut().enumerate() {
            let old = patch.deflection[k];
            let new = (old + dt * s.sliding[k]) / (1.0 + dt * s.rolling / self.relaxation[k]);
            *rate = (new - old) / dt;
            patch.deflection[k] = new;
        }
        let e: [f64; 2] = std::array::from_fn(|k| self.bristle[k] * load * patch.deflection[k]);
        let x = norm(e) / limit;
        if x >= 3.0 {
            // Sliding: the tread deflects no further.
            let keep = 3.0 / x;
            patch.deflection[0] *= keep;
            patch.deflection[1] *= keep;
            let scale = -1.0 / x;
            return [e[0] * scale, e[1] * scale];
        }
        let secant = secant(x);
        let tangent = (1.0 - x / 3.0) * (1.0 - x / 3.0);
        let f: [f64; 2] =
            std::array::from_fn(|k| -e[k] * secant - self.damping[k] * load * rate[k] * tangent);
        let clip = (norm(f) / limit).max(1.0);
        [f[0] / clip, f[1] / clip]
    }
}

impl TyreForce for Brush {
    const ROLLING_SHARE: f64 = 1.0 / 3.0;

    #[inline]
    fn vertical(&self, deflection: f64) -> f64 {
        self.stiffness * deflection
    }

    #[inline]
    fn advance(&self, patch: &mut Patch, s: &Slide, on: &Stance, dt: f64) -> PlaneForce {
        let sign = (on.spin * on.lever / 0.1).clamp(-1.0, 1.0);
        let resistance = self.rolling_resistance * s.load * on.lever * sign;
        PlaneForce { force: self.drag(patch, s, dt), twist: V3::zeros(), resistance }
    }

    fn steady(&self, s: &Slide) -> ([f64; 2], f64) {
        let rolling = s.rolling_or_still();
        let e: [f64; 2] =
            std::array::from_fn(|k| self.bristle[k] * self.relaxation[k] * s.load * s.sliding[k] / rolling);
        let limit = s.friction.min(self.friction) * s.load;
        let x = norm(e) / limit;
        let factor = if x < 3.0 { -secant(x) } else { -1.0 / x };
        ([e[0] * factor, e[1] * factor], 0.0)
    }
}

/// Force over that of full adhesion.
fn secant(x: f64) -> f64 {
    1.0 - x / 3.0 + x * x / 27.0
}
