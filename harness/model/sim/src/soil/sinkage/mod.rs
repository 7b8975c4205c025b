//! Pressure over sinkage: a file for each law, and their list, which declares them. Steps look the pressure up in a table
//! of the law.

use serde::{Deserialize, Serialize};
use vb_files::Flaw;

/// A law of pressure over sinkage.
trait PressureSinkage: Sized {
    /// See [`Sinkage::formula`].
    const FORMULA: &'static str;
    /// See [`Sinkage::source`].
    const SOURCE: &'static str;

    /// Frictional and cohesive modulus: the pressure is (k_c/b + k_φ) times [`Self::shape`], with the smaller dimension
    /// b of the contact patch.
    fn moduli(&self) -> [f64; 2] {
        [1.0, 0.0]
    }

    /// The pressure at a sinkage (m) over the modulus.
    fn shape(&self, sinkage: f64) -> f64;

    /// See [`Sinkage::plate_sinkage`].
    fn plate_sinkage(&self, pressure: f64, breadth: f64) -> f64;

    /// See [`Sinkage::softer`].
    fn softer(self, factor: f64) -> Self {
        let _ = factor;
        self
    }

    /// A field that is out of its range, with what is allowed.
    fn check(&self) -> Result<(), Flaw>;

    /// Stiffness (Pa/m) below which unloading would give back more than loading took.
    fn softest_unloading(&self) -> f64;
}

macro_rules! laws {
    ($($(#[$doc:meta])* $module:ident: $law:ident,)*) => {
        /// The pressure of the soil over sinkage.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "type", rename_all = "snake_case")]
        pub enum Sinkage {
            $($(#[$doc])* $law($law),)*
        }

        $(
            mod $module;
            pub use $module::$law;
        )*

        impl Sinkage {
            pub(super) fn moduli(&self) -> [f64; 2] {
                match self { $(Self::$law(law) => law.moduli(),)* }
            }

            pub(super) fn shape(&self, sinkage: f64) -> f64 {
                match self { $(Self::$law(law) => law.shape(sinkage),)* }
            }

            /// The sinkage (m) of a plate under a pressure (Pa) by the closed form of the law; `breadth` is the plate's
            /// smaller dimension, m.
            #[must_use]
            pub fn plate_sinkage(&self, pressure: f64, breadth: f64) -> f64 {
                match self { $(Self::$law(law) => law.plate_sinkage(pressure, breadth),)* }
            }

            /// The closed form of [`Self::plate_sinkage`], for people.
            #[must_use]
            pub fn formula(&self) -> &'static str {
                match self { $(Self::$law(_) => $law::FORMULA,)* }
            }

            /// The publication of the law.
            #[must_use]
            pub fn source(&self) -> &'static str {
                match self { $(Self::$law(_) => $law::SOURCE,)* }
            }

            /// The same law with its moduli divided by `factor`; snow, which has none, is unchanged.
            #[must_use]
            pub fn softer(self, factor: f64) -> Self {
                match self { $(Self::$law(law) => Self::$law(law.softer(factor)),)* }
            }

            pub(super) fn check(&self) -> Result<(), Flaw> {
                match self { $(Self::$law(law) => law.check(),)* }
            }

            pub(super) fn softest_unloading(&self) -> f64 {
                match self { $(Self::$law(law) => law.softest_unloading(),)* }
            }
        }
    };
}
laws! {
    /// Soil without a bottom.
    bekker: Bekker,
    /// Snow over firm ground.
    snow: Snow,
}

impl Sinkage {
    /// The pressure (Pa) under a plate whose smaller dimension is `breadth` (m), at a sinkage (m) that was never
    /// exceeded.
    #[must_use]
    pub fn pressure(&self, sinkage: f64, breadth: f64) -> f64 {
        let [k_phi, k_c] = self.moduli();
        (k_c / breadth + k_phi) * self.shape(sinkage.max(0.0))
    }
}
