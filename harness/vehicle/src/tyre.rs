//! Tyres as data.

use serde::de::{self, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// A tyre: `model: rigid | brush | fiala | tmeasy`, which is the first key, followed by that model's own fields.
///
/// All models share the enveloping contact (`vb_sim::tyre::Envelope`) and the dynamics of the contact patch
/// (`vb_sim::tyre::Patch`); they differ in the radial force and in the force that a steady slip gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "model", rename_all = "lowercase")]
pub enum TyreSpec {
    /// A hard cylinder with Coulomb friction.
    Rigid(RigidTyre),
    /// A brush with a parabolic pressure.
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
    /// The greatest gap at which the solver still sees a contact, m.
    pub reach: f64,
}

/// A brush with a parabolic pressure and relaxation lengths (Pacejka, Tire and Vehicle Dynamics, 2012, ch. 3 and 7).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BrushTyre {
    /// The unloaded radius, m.
    pub radius: f64,
    /// The width, m.
    pub width: f64,
    /// The friction coefficient. The lesser of it and the ground's counts.
    pub friction: f64,
    /// The vertical stiffness, N/m.
    pub vertical_stiffness: f64,
    /// The vertical damping, N s/m.
    pub vertical_damping: f64,
    /// The longitudinal and the lateral slope of the force over the slip at zero slip, per unit load.
    pub slip_stiffness: [f64; 2],
    /// The longitudinal and the lateral relaxation length, m.
    pub relaxation_length: [f64; 2],
    /// The damping ratio of the carcass against a quarter of the vehicle's mass.
    pub damping_ratio: f64,
    /// The rolling resistance as a fraction of the load.
    pub rolling_resistance: f64,
}

/// Fiala's model with the names of Adams/Tire (Chrono's ChFialaTire.cpp).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FialaTyre {
    /// `UNLOADED_RADIUS`: the unloaded radius, m.
    pub radius: f64,
    /// `WIDTH`: the width, m, which is also the arm of the aligning torque.
    pub width: f64,
    /// The vertical force over the deflection: rising points \[m, N\] from \[0, 0\], continued beyond the last with its
    /// last slope.
    pub vertical_map: Vec<[f64; 2]>,
    /// `VERTICAL_DAMPING`: the vertical damping, N s/m.
    pub vertical_damping: f64,
    /// `CSLIP`: the longitudinal force over the slip at zero slip, N.
    pub c_slip: f64,
    /// `CALPHA`: the lateral force over the tangent of the slip angle at zero, N.
    pub c_alpha: f64,
    /// `UMIN`: the friction coefficient at a slip of one.
    pub mu_min: f64,
    /// `UMAX`: the friction coefficient at no slip.
    pub mu_max: f64,
    /// The friction of the ground for which the two coefficients hold. They scale with the ground's own friction.
    pub mu_0: f64,
    /// `ROLLING_RESISTANCE`: the moment over the load, m.
    pub rolling_resistance: f64,
    /// The longitudinal and the lateral stiffness of the carcass, N/m. The relaxation lengths are `c_slip` and
    /// `c_alpha` over these.
    pub carcass_stiffness: [f64; 2],
    /// The longitudinal and the lateral damping of the carcass, N s/m.
    pub carcass_damping: [f64; 2],
}

/// Rill's TMeasy with the names of its standard (Chrono's ChTMeasyTire.cpp; Rill, Road Vehicle Dynamics, 2012, ch. 3).
/// Pairs are the values at the loads `pn` and 2 `pn`, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TmeasyTyre {
    /// The unloaded radius, m.
    pub radius: f64,
    /// The width, m.
    pub width: f64,
    /// The radius of the rim, m. Deflections that reach the rim meet five times the stiffness more.
    pub rim_radius: f64,
    /// The rolling resistance as a fraction of the load.
    pub rolling_resistance: f64,
    /// The friction of the ground for which the tables hold. Slips and forces scale with the ground's own friction.
    pub mu_0: f64,
    /// The nominal load, N.
    pub pn: f64,
    /// The load beyond which the forces in the contact plane grow no further, N.
    pub pn_max: f64,
    /// The coefficient d1 of the vertical force over the deflection, N/m.
    pub vertical_stiffness: f64,
    /// The coefficient d2 of the vertical force over the squared deflection, N/m².
    #[serde(default)]
    pub vertical_stiffness_growth: f64,
    /// The vertical damping, N s/m.
    pub vertical_damping: f64,
    /// The longitudinal force over the slip at zero slip, N.
    pub dfx0: [f64; 2],
    /// The greatest longitudinal force, N.
    pub fxm: [f64; 2],
    /// The slip at which the greatest longitudinal force acts.
    pub sxm: [f64; 2],
    /// The longitudinal force of full sliding, N.
    pub fxs: [f64; 2],
    /// The longitudinal slip from which on the tyre slides fully.
    pub sxs: [f64; 2],
    /// The lateral force over the slip at zero slip, N.
    pub dfy0: [f64; 2],
    /// The greatest lateral force, N.
    pub fym: [f64; 2],
    /// The slip at which the greatest lateral force acts.
    pub sym: [f64; 2],
    /// The lateral force of full sliding, N.
    pub fys: [f64; 2],
    /// The lateral slip from which on the tyre slides fully.
    pub sys: [f64; 2],
    /// `nL0`: the pneumatic trail over the length of the contact, at zero slip.
    pub nl0: [f64; 2],
    /// The lateral slip at which the trail has vanished.
    pub sq0: [f64; 2],
    /// The lateral slip from which on the trail stays so.
    pub sqe: [f64; 2],
    /// The longitudinal and the lateral stiffness of the carcass, N/m. The relaxation lengths are `dfx0` and `dfy0`
    /// over these.
    pub carcass_stiffness: [f64; 2],
    /// The longitudinal and the lateral damping of the carcass, N s/m.
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
    /// The unloaded radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        any_tyre!(self, t => t.radius)
    }

    /// The width, m.
    #[must_use]
    pub fn width(&self) -> f64 {
        any_tyre!(self, t => t.width)
    }

    /// Sets the tyre's width, m.
    pub fn set_width(&mut self, width: f64) {
        any_tyre!(self, t => t.width = width);
    }

    /// The rolling resistance over the load; it is zero for a rigid tyre, which has none.
    #[must_use]
    pub fn rolling_resistance(&self) -> f64 {
        match self {
            Self::Rigid(_) => 0.0,
            Self::Brush(t) => t.rolling_resistance,
            Self::Fiala(t) => t.rolling_resistance,
            Self::Tmeasy(t) => t.rolling_resistance,
        }
    }

    /// The tyre's own friction coefficient, of which and the ground's the lesser counts: one number whatever the slip.
    /// It is `None` for models whose friction falls with the slip and scales with the ground's.
    #[must_use]
    pub fn coulomb_friction(&self) -> Option<f64> {
        match self {
            Self::Rigid(t) => Some(t.friction),
            Self::Brush(t) => Some(t.friction),
            Self::Fiala(_) | Self::Tmeasy(_) => None,
        }
    }

    /// Sets the friction coefficient that [`coulomb_friction`](Self::coulomb_friction) returns. It does nothing to
    /// tyres that have none.
    pub fn set_coulomb_friction(&mut self, friction: f64) {
        match self {
            Self::Rigid(t) => t.friction = friction,
            Self::Brush(t) => t.friction = friction,
            Self::Fiala(_) | Self::Tmeasy(_) => {}
        }
    }

    /// The damping of the vertical force, N s/m.
    #[must_use]
    pub fn vertical_damping(&self) -> f64 {
        any_tyre!(self, t => t.vertical_damping)
    }

    /// The name of the tyre's model, as it stands in the file.
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
