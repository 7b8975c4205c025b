//! Errors of profiles and of planners' sensor requirements.

use vb_sdk::metadata::Sensor;

/// The reason why a planner can't be used with a profile. Every message is one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SenseError {
    #[error("the planner needs {}, which the perception profile {profile} does not provide; it provides {offered}", sensor.name())]
    NotOffered { profile: String, sensor: Sensor, offered: String },
    /// A planner requests a sensor at a higher rate than that of the profile, or at a rate that the samples of a trial
    /// don't permit.
    #[error(
        "the planner needs {} at {rate} Hz, but the perception profile {profile} provides {possible} Hz",
        sensor.name()
    )]
    Rate {
        profile: String,
        sensor: Sensor,
        /// The rate, Hz.
        rate: f64,
        /// The rates that are possible, Hz.
        possible: String,
    },
}
