//! The hard cylinder.

use super::TyreData;
use crate::field::Check;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;

/// A hard cylinder with Coulomb friction: the tyre of the original's wheeled vehicles (Chrono's ChRigidTire.cpp).
///
/// The original's contact is a complementarity problem, without compliance or slip. Here a stiff spring keeps the
/// penetration to millimetres, and friction is a bristle that reaches the friction circle at a small slip,
/// `friction · load / (tangential_stiffness · relaxation_length)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidTyre {
    /// The radius of the cylinder, m.
    pub radius: f64,
    /// The width of the cylinder, m.
    pub width: f64,
    /// The friction coefficient. The lesser of it and the ground's counts.
    pub friction: f64,
    /// The stiffness of the contact along the ground's normal, N/m.
    pub vertical_stiffness: f64,
    /// The damping of the contact along the ground's normal, N s/m; it is critical for an unsprung mass m at 2
    /// √(stiffness · m).
    pub vertical_damping: f64,
    /// The stiffness of the bristle in the contact plane, N/m.
    pub tangential_stiffness: f64,
    /// The damping of the bristle in the contact plane, N s/m.
    pub tangential_damping: f64,
    /// The distance over which a rolling wheel sheds its bristle's deflection, m.
    pub relaxation_length: f64,
    /// The way in which the tyre meets rigid ground.
    #[serde(default, skip_serializing_if = "HardContact::is_envelope")]
    pub contact: HardContact,
    /// The lift of the wheel off rigid ground by sliding. If it is left out, sliding doesn't lift the wheel, as in
    /// nature. It concerns contacts with facets alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilation: Option<Dilation>,
}

/// The way in which a hard wheel meets rigid ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HardContact {
    /// The wheel meets the ground with one contact for all of its outline, without a jump of force from facet to facet,
    /// as other tyres do.
    #[default]
    Envelope,
    /// The wheel meets the ground with a contact for each facet that it touches, as a cylinder does: in a corner it
    /// stands on the floor and leans on the wall.
    Facets,
}

impl HardContact {
    fn is_envelope(&self) -> bool {
        *self == Self::Envelope
    }
}

/// The lift that the cone complementarity of a time-stepping solver gives to a contact that slides. The solver keeps a
/// gap of step · μ · sliding speed, since its friction cone is made convex by letting the normal velocity grow with the
/// sliding one (Anitescu, Optimization-based simulation of nonsmooth rigid multibody dynamics, Mathematical Programming
/// 105, 2006; Tasora and Anitescu, Computer Methods in Applied Mechanics and Engineering 200, 2011). A wheel that spins
/// stands on ground that a wheel which rolls doesn't reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dilation {
    /// The solver's step, s.
    pub step: f64,
    /// The maximum gap at which the solver still sees a contact, m.
    pub reach: f64,
}

impl TyreData for RigidTyre {
    fn check(&self, check: &Check, at: &str) -> Result<(), Flaw> {
        check.all_positive(
            at,
            &[
                ("friction", self.friction),
                ("vertical_stiffness", self.vertical_stiffness),
                ("tangential_stiffness", self.tangential_stiffness),
                ("relaxation_length", self.relaxation_length),
            ],
        )?;
        if let Some(d) = self.dilation {
            if self.contact != HardContact::Facets {
                let reason = "given, but contact is not facets: an envelope ends at the ground".to_owned();
                return check.fail(&format!("{at}.dilation"), reason);
            }
            check.all_positive(&format!("{at}.dilation"), &[("step", d.step), ("reach", d.reach)])?;
            if d.reach > self.radius {
                let reason = format!("{} is more than the tyre's radius, {}", d.reach, self.radius);
                return check.fail(&format!("{at}.dilation.reach"), reason);
            }
        }
        check.not_negative(&format!("{at}.tangential_damping"), self.tangential_damping)
    }

    fn double(&mut self) {
        self.vertical_stiffness *= 2.0;
        self.vertical_damping *= 2.0;
        self.tangential_stiffness *= 2.0;
        self.tangential_damping *= 2.0;
    }

    fn coulomb_friction(&self) -> Option<f64> {
        Some(self.friction)
    }

    fn set_coulomb_friction(&mut self, friction: f64) {
        self.friction = friction;
    }
}
