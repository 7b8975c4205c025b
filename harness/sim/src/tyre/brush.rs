//! The brush: forces in the contact plane.

use crate::spec::TyreSpec;

/// Forces of a tyre in its contact plane: a brush with relaxation.
///
/// The tread deflects by `u` (m) against the ground: u̇ = v_s − |v_r| u/σ with the sliding velocity v_s of the contact
/// patch, the rolling speed v_r and the relaxation length σ of each direction (Pacejka, Tire and Vehicle Dynamics,
/// 2012, eq. 7.8 ff.). The force follows the brush model with a parabolic pressure distribution (ibid. eq. 3.11,
/// 3.40): with e = (C/σ) u the force of full adhesion and x = |e|/(μF_z), F = μF_z(x − x²/3 + x³/27) up to x = 3 and
/// μF_z beyond. At rest the deflection is a spring, so a braked vehicle stays where it is on a slope up to atan μ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brush {
    /// Longitudinal and lateral deflection, m.
    pub deflection: [f64; 2],
}

/// What the brush needs of a tyre, per unit load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrushLaw {
    stiffness: [f64; 2],
    damping: [f64; 2],
    relaxation: [f64; 2],
}

impl BrushLaw {
    pub(crate) fn new(tyre: &TyreSpec) -> Self {
        let stiffness = std::array::from_fn(|k| tyre.slip_stiffness[k] / tyre.relaxation_length[k]);
        // 2 ζ √(k m) per unit load, with k = stiffness · load and m = load / g.
        let damping = stiffness.map(|k: f64| 2.0 * tyre.damping_ratio * (k / crate::GRAVITY).sqrt());
        Self { stiffness, damping, relaxation: tyre.relaxation_length }
    }
}

impl Brush {
    /// Advances the deflection by `dt` and returns the force on the wheel (longitudinal, lateral), N.
    ///
    /// `sliding`: velocity of the contact patch over the ground, m/s; `rolling`: |spin · effective radius|, m/s.
    #[inline]
    pub(crate) fn advance(
        &mut self,
        law: &BrushLaw,
        sliding: [f64; 2],
        rolling: f64,
        load: f64,
        friction: f64,
        dt: f64,
    ) -> [f64; 2] {
        if load <= 0.0 || friction <= 0.0 {
            self.deflection = [0.0; 2];
            return [0.0; 2];
        }
        let limit = friction * load;
        let mut rate = [0.0; 2];
        for k in 0..2 {
            let old = self.deflection[k];
            let new = (old + dt * sliding[k]) / (1.0 + dt * rolling / law.relaxation[k]);
            rate[k] = (new - old) / dt;
            self.deflection[k] = new;
        }
        let e = [law.stiffness[0] * load * self.deflection[0], law.stiffness[1] * load * self.deflection[1]];
        let adhesion = (e[0] * e[0] + e[1] * e[1]).sqrt();
        let x = adhesion / limit;
        if x >= 3.0 {
            // Sliding: the tread deflects no further.
            let keep = 3.0 / x;
            self.deflection[0] *= keep;
            self.deflection[1] *= keep;
            let scale = -limit / adhesion;
            return [e[0] * scale, e[1] * scale];
        }
        let secant = 1.0 - x / 3.0 + x * x / 27.0;
        let tangent = (1.0 - x / 3.0) * (1.0 - x / 3.0);
        let f = [
            -e[0] * secant - law.damping[0] * load * rate[0] * tangent,
            -e[1] * secant - law.damping[1] * load * rate[1] * tangent,
        ];
        let norm = (f[0] * f[0] + f[1] * f[1]).sqrt();
        let clip = if norm > limit { limit / norm } else { 1.0 };
        [f[0] * clip, f[1] * clip]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tyre() -> TyreSpec {
        crate::VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv")
            .unwrap()
            .tyre
    }

    #[test]
    fn steady_slip_gives_the_brush_curve_and_the_friction_limit() {
        let t = tyre();
        let law = BrushLaw::new(&t);
        let (load, mu) = (6000.0, 0.8);
        for slip in [0.005, 0.02, 0.05, 0.3] {
            let mut b = Brush::default();
            let rolling = 10.0;
            let mut f = [0.0; 2];
            for _ in 0..4000 {
                f = b.advance(&law, [-slip * rolling, 0.0], rolling, load, mu, 1e-3);
            }
            // Pacejka 2012, eq. 3.11 with stiffness C = slip_stiffness · load.
            let x = t.slip_stiffness[0] * slip / mu;
            let expected = mu * load * if x < 3.0 { x - x * x / 3.0 + x * x * x / 27.0 } else { 1.0 };
            assert!((f[0] - expected).abs() < 2e-3 * expected, "{slip}: {} {expected}", f[0]);
            assert_eq!(f[1], 0.0);
        }
    }

    #[test]
    fn combined_slip_never_exceeds_friction() {
        let law = BrushLaw::new(&tyre());
        let mut b = Brush::default();
        for k in 0..5000 {
            let a = 0.013 * f64::from(k);
            let s = [3.0 * vb_math::sin(a), 2.0 * vb_math::cos(0.7 * a)];
            let f = b.advance(&law, s, 2.0, 5000.0, 0.6, 1e-3);
            assert!(vb_math::hypot(f[0], f[1]) <= 3000.0 * (1.0 + 1e-12));
        }
    }
}
