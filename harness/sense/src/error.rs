//! What can be wrong with a profile, and with what a planner asks of it.

use vb_sdk::metadata::Sensor;

/// The reason why a planner can't perceive by a profile. Every message is one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SenseError {
    /// A profile's file can't be read.
    #[error("{file}: {problem}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the operating system says.
        problem: String,
    },
    /// A profile has a flaw.
    #[error("{file}: {field}: {problem}")]
    Flaw {
        /// The file.
        file: String,
        /// The field, e.g. `lidar.max_range_m`.
        field: String,
        /// The value, and what would be right.
        problem: String,
    },
    /// A planner asks for a sensor that the profile has not.
    #[error("the planner needs {}, which the perception profile {profile} doesn't offer; it offers {offered}", sensor.name())]
    NotOffered {
        /// The profile's name.
        profile: String,
        /// The sensor.
        sensor: Sensor,
        /// The names of the sensors that there are.
        offered: String,
    },
    /// A planner asks for a sensor more often than the profile has it, or at a rate that the samples of a trial don't allow.
    #[error(
        "the planner needs {} at {rate} Hz, and the perception profile {profile} offers {possible} Hz",
        sensor.name()
    )]
    Rate {
        /// The profile's name.
        profile: String,
        /// The sensor.
        sensor: Sensor,
        /// The rate, Hz.
        rate: f64,
        /// The rates that are possible, Hz.
        possible: String,
    },
}
