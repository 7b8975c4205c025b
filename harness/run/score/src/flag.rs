//! Properties of a trial in addition to its outcome, which are true or false and are counted in tables.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::ride::{POWER_LIMIT_W, SHOCK_LIMIT_G};
use crate::{Metrics, Outcome, Ride};

/// The angle of roll or pitch beyond which the authors' evaluation scripts take a vehicle for rolled over, degrees.
pub const TILT_LIMIT_DEG: f64 = 30.0;

/// Declares the flags together with their list, their names in files, what people call them, and how a record is judged.
macro_rules! flags {
    ($($(#[doc = $about:literal])+ $variant:ident = $name:literal, $title:literal, $of:expr;)+) => {
        /// A property of a trial in addition to its outcome. Tables count the trials that have it.
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

            /// Whether it is true for a trial; `None` without the metrics or ride on which it depends.
            #[must_use]
            pub fn of(self, outcome: Outcome, metrics: Option<&Metrics>, ride: Option<&Ride>) -> Option<bool> {
                let judge: fn(Outcome, Option<&Metrics>, Option<&Ride>) -> Option<bool> = match self {
                    $(Self::$variant => $of),+
                };
                judge(outcome, metrics, ride)
            }
        }
    };
}

flags! {
    /// |roll| or |pitch| exceeded 30° at any sample: the rollover rule of the authors' evaluation scripts, for all
    /// trials.
    Tilted = "tilted", "tilt > 30°", |_, metrics, _| metrics.map(tilted);
    /// The trial succeeded, the vehicle had landed at the end, and the vertical peak at the seat was at most 2.5 g.
    Strict = "strict", "strict", |outcome, _, ride| strict(outcome, ride);
    /// The vertical peak at the seat was above 2.5 g, the shock limit of NRMM.
    Shock = "over_2_5_g", "> 2.5 g", |_, _, ride| Some(ride?.seat_peak_z_g > SHOCK_LIMIT_G);
    /// The mean absorbed power was above 6 W, the ride limit of NRMM.
    Power = "over_6_w", "> 6 W", |_, _, ride| Some(ride?.absorbed_power_w > POWER_LIMIT_W);
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

/// Whether a trial succeeded under the strict rules. A failure under the rules in force is a failure under these too.
fn strict(outcome: Outcome, ride: Option<&Ride>) -> Option<bool> {
    if outcome != Outcome::Success {
        return Some(false);
    }
    ride.map(|ride| ride.landed && ride.seat_peak_z_g <= SHOCK_LIMIT_G)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::TaskRecord;

    #[test]
    fn names_are_those_of_files() {
        for flag in Flag::ALL {
            assert_eq!(serde_json::to_string(&flag).unwrap(), format!("\"{flag}\""));
        }
    }

    /// A record with this outcome, greatest roll and pitch (degrees), and ride.
    fn record(outcome: &str, [roll, pitch]: [f64; 2], ride: &str) -> TaskRecord {
        let metrics = Metrics { samples: 1, roll_max_deg: roll, pitch_max_deg: pitch, ..Metrics::default() };
        let metrics = serde_json::to_string(&metrics).unwrap();
        let text = format!(
            r#"{{"task":"w001/t00","world":"w001","elevation":"low","terrain":"rigid","density":"sparse","outcome":"{outcome}",
            "three_way":"stuck","reason":"","time_s":1.0,"state_hash":"","sim_steps":1,"planner_steps":1,"clamped":0,"fuel":null,
            "metrics":{metrics},"ride":{ride}}}"#
        );
        let mut record: TaskRecord = serde_json::from_str(&text).unwrap();
        record.judge();
        record
    }

    /// A ride with this vertical peak (g) and absorbed power (W).
    fn ride(peak: f64, power: f64, landed: bool) -> String {
        let ride = Ride { seat_peak_z_g: peak, absorbed_power_w: power, landed, ..Ride::default() };
        serde_json::to_string(&ride).unwrap()
    }

    #[test]
    fn a_tilt_is_above_30_degrees_of_roll_or_pitch_at_any_time_whatever_the_outcome() {
        let tilted = |outcome, angles| record(outcome, angles, "null").flags.get(&Flag::Tilted).copied();
        assert_eq!(tilted("success", [30.0, 30.0]), Some(false));
        assert_eq!(tilted("success", [30.1, 0.0]), Some(true));
        assert_eq!(tilted("stuck", [0.0, 31.0]), Some(true));
        assert_eq!(record("stuck", [0.0; 2], "null").flags.len(), 2, "shock and power are not known");
    }

    #[test]
    fn a_strict_success_has_landed_without_a_shock() {
        let strict = |outcome, ride: &str| record(outcome, [0.0; 2], ride).flags.get(&Flag::Strict).copied();
        assert_eq!(strict("success", &ride(2.5, 1.0, true)), Some(true));
        assert_eq!(strict("success", &ride(2.6, 1.0, true)), Some(false));
        assert_eq!(strict("success", &ride(1.0, 1.0, false)), Some(false));
        assert_eq!(strict("success", "null"), None, "scored again with another end");
        assert_eq!(strict("stuck", "null"), Some(false));
    }

    #[test]
    fn limits_are_those_of_nrmm() {
        let flags = |peak, power| record("stuck", [0.0; 2], &ride(peak, power, true)).flags;
        let of = |flags: &BTreeMap<Flag, bool>| (flags[&Flag::Shock], flags[&Flag::Power]);
        assert_eq!(of(&flags(2.5, 6.0)), (false, false));
        assert_eq!(of(&flags(2.51, 6.01)), (true, true));
    }

    #[test]
    fn a_record_of_a_stranger_with_an_impossible_ride_is_refused_with_field_and_value() {
        let text = serde_json::to_string(&record("stuck", [0.0; 2], &ride(2.5, 6.0, true))).unwrap();
        for (from, to, told) in [
            ("\"seat_peak_z_g\":2.5", "\"seat_peak_z_g\":-2.5", "ride.seat_peak_z_g: -2.5 must lie in 0 to"),
            ("\"absorbed_power_w\":6.0", "\"absorbed_power_w\":1e10", "ride.absorbed_power_w: 1e10 must"),
            (
                "\"airborne_fraction\":0.0",
                "\"airborne_fraction\":1.01",
                "ride.airborne_fraction: 1.01 must lie in 0 to 1",
            ),
        ] {
            assert!(text.contains(from), "{text}");
            let error = serde_json::from_str::<TaskRecord>(&text.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
        assert!(serde_json::from_str::<TaskRecord>(&text).is_ok());
    }
}
