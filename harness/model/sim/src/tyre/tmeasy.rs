//! Rill's TMeasy.

use super::TyreForce;
use super::patch::{Carcass, Creep, Patch, PlaneForce, SETTLED, Slide, Stance, norm, stick};
use vb_vehicle::tyre::TmeasyTyre;

/// Rolling speed below which friction no longer falls with slip, m/s: a tyre at rest sticks with its greatest force, and
/// falls to that of sliding as it is dragged.
const LOW_SPEED: f64 = 0.5;
/// Rolling speeds between which the aligning torque sets in, m/s (Chrono's ChTMeasyTire.cpp: at 1 m/s).
const ALIGNING_SPEED: [f64; 2] = [0.5, 1.5];
/// Stiffness of the rim's contact over the tyre's own (Chrono's ChTMeasyTire.cpp).
const RIM: f64 = 5.0;
/// How far above the rim its contact begins, m (Chrono's ChTMeasyTire.cpp).
const RIM_FLANGE: f64 = 0.01;

/// TMeasy's characteristics (Chrono's ChTMeasyTire.cpp; Rill, Road Vehicle Dynamics, 2012, ch. 3).
#[derive(Clone, Debug)]
pub(crate) struct Tmeasy {
    t: Box<TmeasyTyre>,
    /// Loads over `pn` up to which forces grow: a parabola's summit, where it has one, or `pn_max`.
    summit: [f64; 6],
    carcass: Carcass,
}

/// A direction's characteristic at a load: initial slope, greatest force, sliding force and their slips.
#[derive(Clone, Copy, Debug)]
struct Characteristic {
    slope: f64,
    peak: f64,
    slide: f64,
    peak_slip: f64,
    slide_slip: f64,
}

/// A quantity that grows linearly with load from its values at pn and 2 pn.
fn linear(w: [f64; 2], q: f64) -> f64 {
    w[0] + (w[1] - w[0]) * (q - 1.0)
}

/// A quantity that is zero at no load and grows as a parabola through its values at pn and 2 pn.
fn parabola(w: [f64; 2], q: f64) -> f64 {
    q * (2.0 * w[0] - 0.5 * w[1] - (w[0] - 0.5 * w[1]) * q)
}

impl Tmeasy {
    pub(crate) fn new(t: &TmeasyTyre) -> Self {
        let most = t.pn_max / t.pn;
        let summit = [t.dfx0, t.fxm, t.fxs, t.dfy0, t.fym, t.fys].map(|w| {
            let curvature = w[0] - 0.5 * w[1];
            if curvature > 0.0 { most.min((w[0] - 0.25 * w[1]) / curvature) } else { most }
        });
        let carcass = Carcass { stiffness: t.carcass_stiffness, damping: t.carcass_damping };
        Self { t: Box::new(t.clone()), summit, carcass }
    }

    /// The longitudinal and the lateral characteristic at a load, N, on the ground for which the tables hold.
    fn characteristics(&self, load: f64) -> [Characteristic; 2] {
        let t = &self.t;
        let q = (load / t.pn).min(t.pn_max / t.pn);
        let force = |w: [f64; 2], k: usize| parabola(w, q.min(self.summit[k]));
        [
            Characteristic {
                slope: force(t.dfx0, 0),
                peak: force(t.fxm, 1),
                slide: force(t.fxs, 2),
                peak_slip: linear(t.sxm, q),
                slide_slip: linear(t.sxs, q),
            },
            Characteristic {
                slope: force(t.dfy0, 3),
                peak: force(t.fym, 4),
                slide: force(t.fys, 5),
                peak_slip: linear(t.sym, q),
                slide_slip: linear(t.sys, q),
            },
        ]
    }

    fn creep(&self, s: &Slide, elastic: [f64; 2]) -> Creep {
        let m = s.friction / self.t.mu_0;
        let [x, y] = self.characteristics(s.load);
        let v = s.speed();
        let rolling = s.rolling_or_still();
        let (cos, sin) = if v > 0.0 {
            (s.sliding[0] / v, s.sliding[1] / v)
        } else {
            (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2)
        };
        let both = |a: f64, b: f64| norm([a * cos, b * sin]);
        let c = Characteristic {
            slope: both(x.slope, y.slope),
            peak: m * both(x.peak, y.peak),
            slide: m * both(x.slide, y.slide),
            peak_slip: m * both(x.peak_slip, y.peak_slip).max(1e-6),
            slide_slip: m * both(x.slide_slip, y.slide_slip),
        };
        let slip = v / rolling;
        let q = if slip < c.peak_slip {
            rolling / c.secant(slip)
        } else {
            let f = c.beyond((v / rolling.max(LOW_SPEED)).max(c.peak_slip));
            stick(v / f, rolling * c.peak_slip / c.peak, norm(elastic) / f)
        };
        Creep { compliance: [q; 2], limit: [m * x.peak, m * y.peak] }
    }

    /// The pneumatic trail at a lateral slip, m.
    fn trail(&self, s: &Slide, slip: f64) -> f64 {
        let t = &self.t;
        let q = (s.load.min(t.pn_max)) / t.pn;
        let (start, zero) = (linear(t.nl0, q), linear(t.sq0, q));
        let end = linear(t.sqe, q).max(zero);
        let w = zero / end;
        let ratio = if slip >= end {
            0.0
        } else if slip <= zero {
            let r = slip / zero;
            (1.0 - w) * start * (1.0 - r) + w * start * (1.0 - (3.0 - 2.0 * r) * r * r)
        } else {
            let r = (end - slip) / (end - zero);
            -start * (1.0 - w) * (slip - zero) / zero * r * r
        };
        ratio * 2.0 * (t.radius * s.depth).sqrt()
    }

    fn aligning(&self, s: &Slide, lateral: f64) -> f64 {
        let [from, to] = ALIGNING_SPEED;
        let r = ((s.rolling - from) / (to - from)).clamp(0.0, 1.0);
        if r == 0.0 {
            return 0.0;
        }
        -lateral * self.trail(s, (s.sliding[1] / s.rolling).abs()) * r * r * (3.0 - 2.0 * r)
    }

    /// Moment of rolling resistance against the spin, N m.
    fn rolling_moment(&self, load: f64, spin: f64) -> f64 {
        self.t.rolling_resistance * load * self.t.radius * vb_math::tanh(spin)
    }

    /// What the overturning torque w²/12 (d1 + 2 d2 d) has beyond w²/12 F_z/d, which the contact's offset gives, N m
    /// per radian of inclination.
    fn extra_overturning(&self, depth: f64) -> f64 {
        self.t.width * self.t.width / 12.0 * self.t.vertical_stiffness_growth * depth
    }
}

impl TyreForce for Tmeasy {
    const ROLLING_SHARE: f64 = 1.0 / 3.0;

    fn vertical(&self, depth: f64) -> f64 {
        let t = &self.t;
        let rim = depth - (t.radius - t.rim_radius - RIM_FLANGE);
        t.vertical_stiffness * (depth + RIM * rim.max(0.0)) + t.vertical_stiffness_growth * depth * depth
    }

    #[inline]
    fn advance(&self, patch: &mut Patch, s: &Slide, on: &Stance, dt: f64) -> PlaneForce {
        let resistance = self.rolling_moment(s.load, on.spin);
        let creep = self.creep(s, self.carcass.elastic(patch));
        let force = self.carcass.advance(patch, s.sliding, &creep, dt);
        let aligning = self.aligning(s, force[1]);
        let overturning = self.extra_overturning(s.depth) * on.axis.dot(&on.normal);
        PlaneForce { force, twist: on.normal * aligning - on.along * overturning, resistance }
    }

    fn steady(&self, s: &Slide) -> ([f64; 2], f64) {
        let force = self.creep(s, SETTLED).steady(s.sliding);
        (force, self.aligning(s, force[1]))
    }
}

impl Characteristic {
    /// The slope at zero slip, at least such that the greatest force is the curve's own maximum.
    fn steepness(&self) -> f64 {
        self.slope.max(2.0 * self.peak / self.peak_slip)
    }

    /// Force over slip, up to the slip of the greatest force.
    fn secant(&self, slip: f64) -> f64 {
        let slope = self.steepness();
        let sigma = slip / self.peak_slip;
        slope / (1.0 + (sigma + slope * self.peak_slip / self.peak - 2.0) * sigma)
    }

    /// Force beyond the slip of the greatest one: two parabolas, or a cubic, down to the force of sliding.
    fn beyond(&self, slip: f64) -> f64 {
        let (peak, slide) = (self.peak, self.slide);
        if slip >= self.slide_slip {
            return slide;
        }
        let secant = peak / self.peak_slip;
        let a = secant * secant / (self.steepness() * self.peak_slip);
        let span = self.slide_slip - self.peak_slip;
        let join = self.peak_slip + (peak - slide) / (a * span);
        let past = slip - self.peak_slip;
        if join > self.slide_slip {
            let r = past / span;
            peak - (peak - slide) * r * r * (3.0 - 2.0 * r)
        } else if slip <= join {
            peak - a * past * past
        } else {
            let b = a * (join - self.peak_slip) / (self.slide_slip - join);
            let left = self.slide_slip - slip;
            slide + b * left * left
        }
    }
}
