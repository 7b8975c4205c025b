//! Shear stress over shear displacement: a file for each law, and their list, which declares them. The footprint is
//! compiled for each law.

use fearless_simd::{Simd, f64x4, prelude::*};
use serde::{Deserialize, Serialize};

/// A law by which shear displacement mobilises the shear strength, at four stations at once.
pub(crate) trait ShearLaw {
    /// The law of a soil with a shear deformation modulus, m.
    fn new(modulus: f64) -> Self;

    /// Advances shear by a slip velocity (m/s) of a size `speed`. The state is the displacement (m) that mobilises the
    /// stress, along two directions; 0 is unsheared.
    fn mobilise<S: Simd>(
        &self,
        simd: S,
        state: [f64x4<S>; 2],
        slip: [f64x4<S>; 2],
        speed: f64x4<S>,
        dt: f64,
    ) -> Mobilised<S>;
}

/// The shear of four stations after a step.
pub(crate) struct Mobilised<S: Simd> {
    /// The displacement that mobilises the stress, along two directions, m.
    pub(crate) state: [f64x4<S>; 2],
    /// Stress over strength along the two directions, in the sense of the slip.
    pub(crate) fraction: [f64x4<S>; 2],
    /// The size of `fraction`.
    pub(crate) level: f64x4<S>,
}

macro_rules! laws {
    ($d:tt $($(#[$doc:meta])* $module:ident $law:ident,)*) => {
        /// The law of shear stress over shear displacement of a soil, as a soil file gives it.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
        pub enum Shear {
            $($(#[$doc])* $law,)*
        }

        $(mod $module;)*

        /// A soil's law, ready for steps.
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) enum Prepared {
            $($law($module::$law),)*
        }

        impl Prepared {
            pub(super) fn new(law: Shear, modulus: f64) -> Self {
                match law { $(Shear::$law => Self::$law($module::$law::new(modulus)),)* }
            }
        }

        /// The value of an expression in which `$name` is the law, of whatever type.
        macro_rules! with_law {
            ($d prepared:expr, $d name:ident => $d body:expr) => {
                match $d prepared { $($crate::soil::shear::Prepared::$law($d name) => $d body,)* }
            };
        }
    };
}
laws! { $
    /// Janosi and Hanamoto's: the stress rises towards the strength as 1 − exp(−j/K).
    #[default]
    janosi Janosi,
}
pub(crate) use with_law;

impl Shear {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The greater of two numbers, lane by lane; on every machine the second where they are equal.
#[inline(always)]
pub(super) fn greater<S: Simd>(a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
    a.simd_gt(b).select(a, b)
}
