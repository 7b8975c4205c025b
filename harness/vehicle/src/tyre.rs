//! Tyres as data.

use serde::de::{self, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// A tyre: `model: rigid | brush | fiala | tmeasy`, which is the first key, followed by that model's own fields.
///
/// All models share the enveloping contact ([`crate::Envelope`]) and the dynamics of the contact patch
/// ([`crate::Patch`]); they differ in the radial force and in the force that a steady slip gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "model", rename_all = "lowercase")]
pub enum TyreSpec {
    /// A hard cylinder with Coulomb friction.
    Rigid(RigidTyre),
    /// A brush with parabolic pressure.
    Brush(BrushTyre),
    /// Fiala's model as Adams/Tire has it.
    Fiala(FialaTyre),
    /// Rill's TMeasy, the "handling" tyre.
    Tmeasy(TmeasyTyre),
}

/// A hard cylinder with Coulomb friction: the tyre of the original's wheeled vehicles (Chrono's ChRigidTire.cpp).
///
/// The original's contact is a complementarity problem, without compliance or slip. Here a stiff spring keeps the
/// penetration to millimetres, and friction is a bristle that reaches the friction circle at a small slip,
/// `friction · load / (tangential_stiffness · relaxation_length)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidTyre {
    /// Of the cylinder, m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Friction coefficient, combined with the ground's by the minimum.
    pub friction: f64,
    /// Of the contact along the ground's normal, N/m.
    pub vertical_stiffness: f64,
    /// N s/m; critical for an unsprung mass m at 2 √(stiffness · m).
    pub vertical_damping: f64,
    /// Of the bristle in the contact plane, N/m.
    pub tangential_stiffness: f64,
    /// N s/m.
    pub tangential_damping: f64,
    /// Distance over which a rolling wheel sheds its bristle's deflection, m.
    pub relaxation_length: f64,
    /// How it meets rigid ground.
    #[serde(default, skip_serializing_if = "HardContact::is_envelope")]
    pub contact: HardContact,
    /// How sliding lifts the wheel off rigid ground; left out: not at all, as in nature. Of contacts with facets alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilation: Option<Dilation>,
}

/// How a hard wheel meets rigid ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HardContact {
    /// With one contact for all of its outline, without a jump of force from facet to facet, as other tyres do.
    #[default]
    Envelope,
    /// With a contact for each facet that it touches, as a cylinder does: in a corner it stands on the floor and leans on
    /// the wall.
    Facets,
}

impl HardContact {
    fn is_envelope(&self) -> bool {
        *self == Self::Envelope
    }
}

/// What the cone complementarity of a time-stepping solver does to a contact that slides: it keeps a gap of step · μ ·
/// sliding speed, since its friction cone is made convex by letting the normal velocity grow with the sliding one
/// (Anitescu, Optimization-based simulation of nonsmooth rigid multibody dynamics, Mathematical Programming 105, 2006;
/// Tasora and Anitescu, Computer Methods in Applied Mechanics and Engineering 200, 2011). A wheel that spins stands
/// on ground that a wheel which rolls doesn't reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dilation {
    /// The solver's step, s.
    pub step: f64,
    /// Greatest gap at which it still sees a contact, m.
    pub reach: f64,
}

/// A brush with parabolic pressure and relaxation lengths (Pacejka, Tire and Vehicle Dynamics, 2012, ch. 3 and 7).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BrushTyre {
    /// Unloaded radius, m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Friction coefficient, combined with the ground's by the minimum.
    pub friction: f64,
    /// N/m.
    pub vertical_stiffness: f64,
    /// N s/m.
    pub vertical_damping: f64,
    /// Slope of force over slip at zero slip, per unit load: longitudinal, lateral.
    pub slip_stiffness: [f64; 2],
    /// Longitudinal, lateral, m.
    pub relaxation_length: [f64; 2],
    /// Damping ratio of the carcass against a quarter of the vehicle's mass.
    pub damping_ratio: f64,
    /// Rolling resistance as a fraction of load.
    pub rolling_resistance: f64,
}

/// Fiala's model with the names of Adams/Tire (Chrono's ChFialaTire.cpp).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FialaTyre {
    /// `UNLOADED_RADIUS`, m.
    pub radius: f64,
    /// `WIDTH`, m; also the arm of the aligning torque.
    pub width: f64,
    /// Force over deflection: rising points (m, N) from (0, 0), continued beyond the last with its last slope.
    pub vertical_map: Vec<[f64; 2]>,
    /// `VERTICAL_DAMPING`, N s/m.
    pub vertical_damping: f64,
    /// `CSLIP`: longitudinal force over slip at zero slip, N.
    pub c_slip: f64,
    /// `CALPHA`: lateral force over the tangent of the slip angle at zero, N.
    pub c_alpha: f64,
    /// `UMIN`: friction coefficient at a slip of one.
    pub mu_min: f64,
    /// `UMAX`: friction coefficient at no slip.
    pub mu_max: f64,
    /// Ground friction for which the two coefficients hold; they scale with the ground's own.
    pub mu_0: f64,
    /// `ROLLING_RESISTANCE`: moment over load, m.
    pub rolling_resistance: f64,
    /// Longitudinal and lateral stiffness of the carcass, N/m. Relaxation lengths are `c_slip` and `c_alpha` over it.
    pub carcass_stiffness: [f64; 2],
    /// Longitudinal and lateral damping of the carcass, N s/m.
    pub carcass_damping: [f64; 2],
}

/// Rill's TMeasy with the names of its standard (Chrono's ChTMeasyTire.cpp; Rill, Road Vehicle Dynamics, 2012,
/// ch. 3). Pairs are the values at the loads `pn` and 2 `pn`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TmeasyTyre {
    /// Unloaded radius, m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Of the rim, m: deflections that reach it meet five times the stiffness more.
    pub rim_radius: f64,
    /// Rolling resistance as a fraction of load.
    pub rolling_resistance: f64,
    /// Ground friction for which the tables hold; slips and forces scale with the ground's own.
    pub mu_0: f64,
    /// Nominal load, N.
    pub pn: f64,
    /// Load beyond which the forces in the contact plane grow no further, N.
    pub pn_max: f64,
    /// d1: vertical force over deflection, N/m.
    pub vertical_stiffness: f64,
    /// d2: vertical force over squared deflection, N/m².
    #[serde(default)]
    pub vertical_stiffness_growth: f64,
    /// N s/m.
    pub vertical_damping: f64,
    /// Longitudinal force over slip at zero slip, N.
    pub dfx0: [f64; 2],
    /// Greatest longitudinal force, N.
    pub fxm: [f64; 2],
    /// Slip at which it acts.
    pub sxm: [f64; 2],
    /// Longitudinal force of full sliding, N.
    pub fxs: [f64; 2],
    /// Slip from which on the tyre slides fully.
    pub sxs: [f64; 2],
    /// Lateral force over slip at zero slip, N.
    pub dfy0: [f64; 2],
    /// Greatest lateral force, N.
    pub fym: [f64; 2],
    /// Slip at which it acts.
    pub sym: [f64; 2],
    /// Lateral force of full sliding, N.
    pub fys: [f64; 2],
    /// Slip from which on the tyre slides fully.
    pub sys: [f64; 2],
    /// `nL0`: pneumatic trail over the length of the contact, at zero slip.
    pub nl0: [f64; 2],
    /// Lateral slip at which the trail has vanished.
    pub sq0: [f64; 2],
    /// Lateral slip from which on it stays so.
    pub sqe: [f64; 2],
    /// Longitudinal and lateral stiffness of the carcass, N/m. Relaxation lengths are `dfx0` and `dfy0` over it.
    pub carcass_stiffness: [f64; 2],
    /// Longitudinal and lateral damping of the carcass, N s/m.
    pub carcass_damping: [f64; 2],
}

/// Does `$body` with the fields of whichever model it is.
macro_rules! any_tyre {
    ($spec:expr, $t:ident => $body:expr) => {
        match $spec {
            TyreSpec::Rigid($t) => $body,
            TyreSpec::Brush($t) => $body,
            TyreSpec::Fiala($t) => $body,
            TyreSpec::Tmeasy($t) => $body,
        }
    };
}

impl TyreSpec {
    /// Unloaded radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        any_tyre!(self, t => t.radius)
    }

    /// Width, m.
    #[must_use]
    pub fn width(&self) -> f64 {
        any_tyre!(self, t => t.width)
    }

    /// Sets its width, m.
    pub fn set_width(&mut self, width: f64) {
        any_tyre!(self, t => t.width = width);
    }

    /// Rolling resistance over load; zero for a rigid tyre, which has none.
    #[must_use]
    pub fn rolling_resistance(&self) -> f64 {
        match self {
            Self::Rigid(_) => 0.0,
            Self::Brush(t) => t.rolling_resistance,
            Self::Fiala(t) => t.rolling_resistance,
            Self::Tmeasy(t) => t.rolling_resistance,
        }
    }

    /// Its own friction coefficient, of which and the ground's the lesser counts: one number whatever the slip. None for
    /// models whose friction falls with slip and scales with the ground's.
    #[must_use]
    pub fn coulomb_friction(&self) -> Option<f64> {
        match self {
            Self::Rigid(t) => Some(t.friction),
            Self::Brush(t) => Some(t.friction),
            Self::Fiala(_) | Self::Tmeasy(_) => None,
        }
    }

    /// Sets what [`coulomb_friction`](Self::coulomb_friction) says; does nothing to tyres that have none.
    pub fn set_coulomb_friction(&mut self, friction: f64) {
        match self {
            Self::Rigid(t) => t.friction = friction,
            Self::Brush(t) => t.friction = friction,
            Self::Fiala(_) | Self::Tmeasy(_) => {}
        }
    }

    /// Damping of the vertical force, N s/m.
    #[must_use]
    pub fn vertical_damping(&self) -> f64 {
        any_tyre!(self, t => t.vertical_damping)
    }

    /// The name of its model, as the file has it.
    #[must_use]
    pub fn model(&self) -> &'static str {
        match self {
            Self::Rigid(_) => "rigid",
            Self::Brush(_) => "brush",
            Self::Fiala(_) => "fiala",
            Self::Tmeasy(_) => "tmeasy",
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Model {
    Rigid,
    Brush,
    Fiala,
    Tmeasy,
}

/// Reads `model` first and then the rest straight into that model's fields. serde's own tagged enums read the map
/// into a buffer first, by which messages lose the field and the line.
impl<'de> Deserialize<'de> for TyreSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Tyre;
        impl<'de> Visitor<'de> for Tyre {
            type Value = TyreSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a tyre, whose first key is `model: rigid | brush | fiala | tmeasy`")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TyreSpec, A::Error> {
                match map.next_key::<String>()? {
                    Some(key) if key == "model" => {}
                    Some(key) => {
                        let found = de::Unexpected::Other(&key);
                        return Err(de::Error::invalid_value(found, &self));
                    }
                    None => return Err(de::Error::missing_field("model")),
                }
                let model = map.next_value::<Model>()?;
                let rest = MapAccessDeserializer::new(map);
                Ok(match model {
                    Model::Rigid => TyreSpec::Rigid(RigidTyre::deserialize(rest)?),
                    Model::Brush => TyreSpec::Brush(BrushTyre::deserialize(rest)?),
                    Model::Fiala => TyreSpec::Fiala(FialaTyre::deserialize(rest)?),
                    Model::Tmeasy => TyreSpec::Tmeasy(TmeasyTyre::deserialize(rest)?),
                })
            }
        }
        deserializer.deserialize_map(Tyre)
    }
}
