//! The hard cylinder.

use super::TyreForce;
use super::patch::{Carcass, Creep, Patch, PlaneForce, SETTLED, Slide, Stance, norm, stick};
use crate::V3;
use vb_vehicle::tyre::{Dilation, RigidTyre};

/// Coulomb friction of a hard cylinder: the bristle's force, up to the friction circle.
#[derive(Clone, Debug)]
pub(crate) struct Rigid {
    stiffness: f64,
    friction: f64,
    bristle: Carcass,
    /// Force over slip of a rolling wheel, N.
    slip_stiffness: f64,
    dilation: Option<Dilation>,
}

impl Rigid {
    pub(crate) fn new(t: &RigidTyre) -> Self {
        Self {
            stiffness: t.vertical_stiffness,
            friction: t.friction,
            bristle: Carcass { stiffness: [t.tangential_stiffness; 2], damping: [t.tangential_damping; 2] },
            slip_stiffness: t.tangential_stiffness * t.relaxation_length,
            dilation: t.dilation,
        }
    }

    fn creep(&self, s: &Slide, elastic: [f64; 2]) -> Creep {
        let limit = s.friction.min(self.friction) * s.load;
        let start = s.rolling_or_still() / self.slip_stiffness;
        let q = stick(start.max(s.speed() / limit), start, norm(elastic) / limit);
        Creep { compliance: [q; 2], limit: [limit; 2] }
    }
}

impl TyreForce for Rigid {
    const ROLLING_SHARE: f64 = 0.0;

    #[inline]
    fn vertical(&self, deflection: f64) -> f64 {
        self.stiffness * deflection
    }

    fn reach(&self) -> f64 {
        self.dilation.map_or(0.0, |d| d.reach)
    }

    fn lift(&self, speed: f64, friction: f64) -> f64 {
        self.dilation.map_or(0.0, |d| d.step * friction.min(self.friction) * speed)
    }

    #[inline]
    fn advance(&self, patch: &mut Patch, s: &Slide, _: &Stance, dt: f64) -> PlaneForce {
        let creep = self.creep(s, self.bristle.elastic(patch));
        let force = self.bristle.advance(patch, s.sliding, &creep, dt);
        PlaneForce { force, twist: V3::zeros(), resistance: 0.0 }
    }

    fn steady(&self, s: &Slide) -> ([f64; 2], f64) {
        (self.creep(s, SETTLED).steady(s.sliding), 0.0)
    }
}
