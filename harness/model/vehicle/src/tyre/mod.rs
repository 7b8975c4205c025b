//! Tyres as data: a file for each model, and the list of the models.

pub use rigid::{Dilation, HardContact};

use crate::field::Check;
use serde::de::{self, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use vb_files::Flaw;

/// The list of tyre models, handed to a macro, which also declares the modules. A row has the model's module (of the
/// data here, of the forces in `vb_sim::tyre`), which is also its name in vehicle files, its variant, which is also the
/// name of the type of the forces, and the type of its data, which has the fields `radius`, `width` and
/// `vertical_damping`.
#[doc(hidden)]
#[macro_export]
macro_rules! tyre_models {
    ($with:ident) => {
        $with! {
            /// A hard cylinder with Coulomb friction.
            rigid Rigid RigidTyre,
            /// A brush with a parabolic pressure.
            brush Brush BrushTyre,
            /// Fiala's model as Adams/Tire has it.
            fiala Fiala FialaTyre,
            /// Rill's TMeasy, the "handling" tyre.
            tmeasy Tmeasy TmeasyTyre,
        }
    };
}

/// The properties of a model's data in which models differ.
trait TyreData {
    /// Refuses values that no tyre of the model can have. `at` is the tyre's field in the file.
    fn check(&self, check: &Check, at: &str) -> Result<(), Flaw>;

    /// Doubles the forces at every deflection and slip, as of two such tyres side by side.
    fn double(&mut self);

    /// See [`TyreSpec::rolling_resistance`].
    fn rolling_resistance(&self) -> f64 {
        0.0
    }

    /// See [`TyreSpec::coulomb_friction`].
    fn coulomb_friction(&self) -> Option<f64> {
        None
    }

    /// See [`TyreSpec::set_coulomb_friction`].
    fn set_coulomb_friction(&mut self, _: f64) {}
}

macro_rules! specs {
    ($($(#[$doc:meta])* $module:ident $variant:ident $data:ident,)*) => {
        $(
            mod $module;
            pub use $module::$data;
        )*

        /// A tyre: `model`, which is the first key, followed by that model's own fields.
        ///
        /// All models share the enveloping contact (`vb_sim::tyre::Envelope`) and the dynamics of the contact patch
        /// (`vb_sim::tyre::Patch`); they differ in the radial force and in the force that a steady slip gives.
        #[derive(Clone, Debug, PartialEq, Serialize)]
        #[serde(tag = "model", rename_all = "snake_case")]
        pub enum TyreSpec {
            $($(#[$doc])* $variant($data),)*
        }

        impl TyreSpec {
            /// The names of all models, as they stand in files.
            pub const MODELS: &[&str] = &[$(stringify!($module)),*];

            /// The name of the tyre's model, as it stands in the file.
            #[must_use]
            pub fn model(&self) -> &'static str {
                match self { $(Self::$variant(_) => stringify!($module),)* }
            }

            /// The unloaded radius, m.
            #[must_use]
            pub fn radius(&self) -> f64 {
                match self { $(Self::$variant(t) => t.radius,)* }
            }

            /// The width, m.
            #[must_use]
            pub fn width(&self) -> f64 {
                match self { $(Self::$variant(t) => t.width,)* }
            }

            /// Sets the tyre's width, m.
            pub fn set_width(&mut self, width: f64) {
                match self { $(Self::$variant(t) => t.width = width,)* }
            }

            /// The damping of the vertical force, N s/m.
            #[must_use]
            pub fn vertical_damping(&self) -> f64 {
                match self { $(Self::$variant(t) => t.vertical_damping,)* }
            }

            /// The rolling resistance over the load; it is zero for a rigid tyre, which has none.
            #[must_use]
            pub fn rolling_resistance(&self) -> f64 {
                match self { $(Self::$variant(t) => t.rolling_resistance(),)* }
            }

            /// The tyre's own friction coefficient, of which and the ground's the lesser counts: one number whatever
            /// the slip. It is `None` for models whose friction falls with the slip and scales with the ground's.
            #[must_use]
            pub fn coulomb_friction(&self) -> Option<f64> {
                match self { $(Self::$variant(t) => t.coulomb_friction(),)* }
            }

            /// Sets the friction coefficient that [`coulomb_friction`](Self::coulomb_friction) returns. It does
            /// nothing to tyres that have none.
            pub fn set_coulomb_friction(&mut self, friction: f64) {
                match self { $(Self::$variant(t) => t.set_coulomb_friction(friction),)* }
            }

            /// Turns the tyre into a twin tyre: twice the forces, and wider by `separation`, the distance between the
            /// centres of the two tyres, m.
            pub fn make_twin(&mut self, separation: f64) {
                match self {
                    $(Self::$variant(t) => {
                        t.double();
                        t.width += separation;
                    })*
                }
            }

            /// Refuses values that no tyre of its model can have.
            pub(crate) fn check(&self, check: &Check, at: &str) -> Result<(), Flaw> {
                match self { $(Self::$variant(t) => t.check(check, at),)* }
            }

            /// Reads the fields of the tyre of a model.
            fn of<'de, D: Deserializer<'de>>(model: Model, fields: D) -> Result<Self, D::Error> {
                Ok(match model { $(Model::$variant => Self::$variant($data::deserialize(fields)?),)* })
            }
        }

        #[derive(Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum Model {
            $($variant,)*
        }
    };
}
tyre_models!(specs);

/// Reads `model` first and then the rest straight into that model's fields. serde's own tagged enums read the map
/// into a buffer first, by which messages lose the field and the line.
impl<'de> Deserialize<'de> for TyreSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Tyre;
        impl<'de> Visitor<'de> for Tyre {
            type Value = TyreSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a tyre, whose first key is `model: {}`", TyreSpec::MODELS.join(" | "))
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
                let model = map.next_value()?;
                TyreSpec::of(model, MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_map(Tyre)
    }
}
