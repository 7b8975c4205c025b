//! The hard cylinder.

use super::patch::{Carcass, Creep, Patch, Slide, norm, stick};
use vb_vehicle::tyre::{Dilation, RigidTyre};

/// Coulomb friction of a hard cylinder: the bristle's force, up to the friction circle.
#[derive(Clone, Debug)]
pub(crate) struct Rigid {
    pub(crate) stiffness: f64,
    friction: f64,
    pub(crate) bristle: Carcass,
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

    /// Greatest gap at which the wheel still feels the ground, m.
    pub(crate) fn reach(&self) -> f64 {
        self.dilation.map_or(0.0, |d| d.reach)
    }

    /// By how much a contact that slides at `speed` (m/s) on ground of a friction is lifted, m.
    pub(crate) fn lift(&self, speed: f64, friction: f64) -> f64 {
        self.dilation.map_or(0.0, |d| d.step * friction.min(self.friction) * speed)
    }

    pub(crate) fn creep(&self, s: &Slide, elastic: [f64; 2]) -> Creep {
        let limit = s.friction.min(self.friction) * s.load;
        let start = s.rolling_or_still() / self.slip_stiffness;
        let q = stick(start.max(s.speed() / limit), start, norm(elastic) / limit);
        Creep { compliance: [q; 2], limit: [limit; 2] }
    }

    pub(crate) fn advance(&self, patch: &mut Patch, s: &Slide, dt: f64) -> [f64; 2] {
        let creep = self.creep(s, self.bristle.elastic(patch));
        self.bristle.advance(patch, s.sliding, &creep, dt)
    }
}
