//! What can be wrong with a profile, and with what a planner asks of it.

use vb_sdk::metadata::Sensor;

/// The reason why a planner can't perceive by a profile. Every message is one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SenseError {
    #[error("the planner needs {}, which the perception profile {profile} does not provide; it provides {offered}", sensor.name())]
    NotOffered { profile: String, sensor: Sensor, offered: String },
    /// A planner asks for a sensor more often than the profile has it, or at a rate that the samples of a trial don't allow.
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
