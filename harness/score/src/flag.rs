//! What of a trial is true or false beside its outcome, and is counted in tables.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::ride::{POWER_LIMIT_W, SHOCK_LIMIT_G};
use crate::{Metrics, Outcome, Ride, TaskRecord};

/// The angle of roll or pitch beyond which the authors' evaluation scripts take a vehicle for rolled over, degrees.
pub const TILT_LIMIT_DEG: f64 = 30.0;

/// Declares the flags together with their list, their names in files, what people call them, and how a record is judged.
macro_rules! flags {
    ($($(#[doc = $about:literal])+ $variant:ident = $name:literal, $title:literal, $of:expr;)+) => {
        /// What of a trial is true or false beside its outcome. Tables count the trials of which it is true.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Flag {
            $($(#[doc = $about])+ #[serde(rename = $name)] $variant,)+
        }

        impl Flag {
            /// All flags in the order of tables.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// The name of the flag in files.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }

            /// The name of the flag in tables.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self {
                    $(Self::$variant => $title),+
                }
            }

            /// A description of the flag.
            #[must_use]
            pub fn about(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!($($about),+).trim_ascii()),+
                }
            }

            /// Whether it is true of a trial; `None` where its record lacks what it takes to know.
            #[must_use]
            pub fn of(self, record: &TaskRecord) -> Option<bool> {
                let judge: fn(&TaskRecord) -> Option<bool> = match self {
                    $(Self::$variant => $of),+
                };
                judge(record)
            }
        }
    };
}

flags! {
    /// |roll| or |pitch| was above 30° at any sample: the rollover rule of the authors' evaluation scripts, for all trials.
    Tilted = "tilted", "tilt > 30°", |r| r.metrics.as_ref().map(tilted);
    /// The trial succeeded, the vehicle had landed at the end, and the peak at the seat was at most 2.5 g.
    Strict = "strict", "strict", |r| strict(r.outcome, r.ride.as_ref());
    /// The vertical peak at the seat was above 2.5 g, the limit of shock of NRMM.
    Shock = "over_2_5_g", "> 2.5 g", |r| Some(r.ride?.seat_peak_z_g > SHOCK_LIMIT_G);
    /// The mean absorbed power was above 6 W, the limit of ride of NRMM.
    Power = "over_6_w", "> 6 W", |r| Some(r.ride?.absorbed_power_w > POWER_LIMIT_W);
}

impl fmt::Display for Flag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Whether |roll| or |pitch| was above 30° at any sample.
fn tilted(m: &Metrics) -> bool {
    m.roll_max_deg > TILT_LIMIT_DEG || m.pitch_max_deg > TILT_LIMIT_DEG
}

/// Whether a trial succeeded by the strict rules. What failed by the rules in force is no success by these either.
fn strict(outcome: Outcome, ride: Option<&Ride>) -> Option<bool> {
    if outcome != Outcome::Success {
        return Some(false);
    }
    ride.map(|ride| ride.landed && ride.seat_peak_z_g <= SHOCK_LIMIT_G)
}
