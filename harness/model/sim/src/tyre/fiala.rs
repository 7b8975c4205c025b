//! Fiala's tyre.

use super::TyreForce;
use super::patch::{Carcass, Creep, Patch, PlaneForce, SETTLED, Slide, Stance, stick};
use vb_vehicle::tyre::FialaTyre;

/// Hub speed below which friction no longer falls with slip, m/s: a slip over no speed says nothing, and at rest the
/// tyre sticks with its greatest friction.
const LOW_SPEED: f64 = 0.5;

/// Fiala's slip curves (Chrono's ChFialaTire.cpp; Adams/Tire's documentation).
///
/// Two things are ours. Friction is scaled by the ground before the critical slips are computed, so that the curves are
/// continuous on every ground (Chrono scales it between the two). And forces in both directions together are held to the
/// friction circle, which the model leaves by up to √2 in combined slip.
#[derive(Clone, Debug)]
pub(crate) struct Fiala {
    map: Vec<[f64; 2]>,
    width: f64,
    c_slip: f64,
    c_alpha: f64,
    mu: [f64; 2],
    mu_0: f64,
    carcass: Carcass,
    rolling_resistance: f64,
}

impl Fiala {
    pub(crate) fn new(t: &FialaTyre) -> Self {
        Self {
            map: t.vertical_map.clone(),
            width: t.width,
            c_slip: t.c_slip,
            c_alpha: t.c_alpha,
            mu: [t.mu_min, t.mu_max],
            mu_0: t.mu_0,
            carcass: Carcass { stiffness: t.carcass_stiffness, damping: t.carcass_damping },
            rolling_resistance: t.rolling_resistance,
        }
    }

    /// U F_z: what friction bears at this slip.
    fn bearable(&self, s: &Slide) -> f64 {
        let slip = (s.speed() / s.forward.max(LOW_SPEED)).min(1.0);
        let [least, most] = self.mu;
        (most - (most - least) * slip) * s.friction / self.mu_0 * s.load
    }

    fn creep(&self, s: &Slide, elastic: [f64; 2]) -> Creep {
        let limit = self.bearable(s);
        let speed = s.forward_or_still();
        let [vx, vy] = s.sliding.map(f64::abs);
        let start = [speed / self.c_slip, speed / self.c_alpha];
        // |κ| below or above S_c = U F_z/(2 C_s).
        let fx = if 2.0 * self.c_slip * vx < limit * speed {
            vx / start[0]
        } else {
            limit - limit * limit * speed / (4.0 * vx * self.c_slip)
        };
        // t = C_α |tan α|/(U F_z) below or above 3; 1 − H³ expanded, with H = 1 − t/3.
        let t = self.c_alpha * vy / (limit * speed);
        let (fy, qy) = if t < 3.0 {
            let secant = 1.0 - t / 3.0 + t * t / 27.0;
            (vy / start[1] * secant, start[1] / secant)
        } else {
            (limit, vy / limit)
        };
        let qx = if fx > 0.0 && vx > 0.0 { vx / fx } else { start[0] };
        let held = |e: f64, f: f64| if f > 0.0 { e.abs() / f } else { f64::INFINITY };
        // The lateral curve ends, at t = 3, where it yields three times as easily as at first. Slips are over the speed
        // of the hub, but only a wheel that turns sheds its deflection short of sliding.
        let creeping = 3.0 * s.rolling_or_still();
        let compliance = [
            stick(qx, creeping / self.c_slip, held(elastic[0], fx)),
            stick(qy, creeping / self.c_alpha, held(elastic[1], fy)),
        ];
        Creep { compliance, limit: [limit; 2] }
    }

    /// Moment of rolling resistance against the spin, N m: with a sine step over the speed, as in Chrono's
    /// ChFialaTire.cpp.
    fn rolling_moment(&self, load: f64, forward: f64, spin: f64) -> f64 {
        let t = ((forward - 0.125) / 0.375).clamp(0.0, 1.0);
        let turn = 2.0 * std::f64::consts::PI;
        let step = if t < 1.0 { t - vb_math::sin(turn * t) / turn } else { 1.0 };
        step * self.rolling_resistance * load * vb_math::tanh(spin)
    }

    /// M_z = U F_z w (1 − H) H³ with U F_z = |F_y|/(1 − H³), so that it follows the lateral force that acts. It fades
    /// at low speed, where no slip shifts the force within the contact.
    fn aligning(&self, s: &Slide, lateral: f64, limit: f64) -> f64 {
        let t = self.c_alpha * s.sliding[1].abs() / (limit * s.forward.max(LOW_SPEED));
        let h = (1.0 - t / 3.0).max(0.0);
        let trail = self.width * h * h * h / (1.0 + h + h * h);
        -lateral * trail * (s.forward / LOW_SPEED).min(1.0)
    }
}

impl TyreForce for Fiala {
    const ROLLING_SHARE: f64 = 1.0;

    /// Piecewise linear, beyond the last point with the last slope.
    fn vertical(&self, depth: f64) -> f64 {
        let last = self.map.len() - 1;
        let k = self.map[1..last].iter().take_while(|p| p[0] < depth).count();
        let ([d0, f0], [d1, f1]) = (self.map[k], self.map[k + 1]);
        f0 + (depth - d0) / (d1 - d0) * (f1 - f0)
    }

    #[inline]
    fn advance(&self, patch: &mut Patch, s: &Slide, on: &Stance, dt: f64) -> PlaneForce {
        let resistance = self.rolling_moment(s.load, s.forward, on.spin);
        let creep = self.creep(s, self.carcass.elastic(patch));
        let force = self.carcass.advance(patch, s.sliding, &creep, dt);
        PlaneForce { force, twist: on.normal * self.aligning(s, force[1], creep.limit[0]), resistance }
    }

    fn steady(&self, s: &Slide) -> ([f64; 2], f64) {
        let creep = self.creep(s, SETTLED);
        let force = creep.steady(s.sliding);
        (force, self.aligning(s, force[1], creep.limit[0]))
    }
}
