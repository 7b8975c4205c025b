//! Shock and ride at the driver's seat, and how the vehicle stood: measured at every step of the simulation.

mod filter;
mod meter;
#[cfg(test)]
mod tests;
mod weighting;

use serde::{Deserialize, Serialize};

use crate::measures::Extent::Pages;
use crate::measures::measures;

pub use meter::{RideMeter, RideStep};

/// The limit of shock at the driver's seat, g (NATO Reference Mobility Model, edition II: the peak vertical acceleration that a
/// driver accepts where obstacles are crossed).
pub const SHOCK_LIMIT_G: f64 = 2.5;
/// The limit of ride, W of absorbed power (NATO Reference Mobility Model, edition II: what a driver accepts in the long run).
pub const POWER_LIMIT_W: f64 = 6.0;
/// The factor on horizontal accelerations in the total vibration value, for the health of a seated person (ISO 2631-1:1997, 7.2.3).
const HORIZONTAL: f64 = 1.4;
/// The cosine of the tilt below which a vehicle is upright: 60°, ours, as in the rules that end a trial by `overturned`.
const UPRIGHT: f64 = 0.5;
/// How long a vehicle has to stand upright on its wheels until it has landed, s at scale 1: ours. A hop of a wheel takes less.
const LANDED_S: f64 = 0.2;

measures! {
    /// Shock and ride over the steps of a simulation, from the start of the trial to the sample that decided it. Accelerations are
    /// those of the chassis at the driver's seat, without gravity, along the axes of the body.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    "ride": pub struct Ride {
        /// Peak magnitude of the acceleration at the seat, below 30 Hz, g.
        pub seat_peak_g: f64,
        /// Peak vertical acceleration at the seat, below 30 Hz, g.
        pub seat_peak_z_g: f64
            => column("peak g") drawn(Pages, "Peak vertical acceleration at the seat", "g"),
        /// Total vibration value at the seat, m/s²: the root of 1.4² (x² + y²) + z², weighted by W_d, W_d and W_k.
        pub seat_rms_m_per_s2: f64,
        /// Vertical vibration at the seat, m/s²: the RMS value weighted by W_k.
        pub seat_rms_z_m_per_s2: f64,
        /// Mean power that the driver absorbs from vertical vibration, W.
        pub absorbed_power_w: f64 => column("absorbed W") drawn(Pages, "Absorbed power", "W"),
        /// Fraction of the time without load on any wheel or on the hull.
        pub airborne_fraction: f64,
        /// Whether the vehicle was upright (tilt below 60°) with a load on two wheels or more in the last 0.2 s.
        pub landed: bool,
        /// Maximum mechanical energy without a physical source, J.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub energy_surplus_j: Option<f64>,
        /// Fraction of the steps in which the contact depth of a wheel was limited.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub held_fraction: Option<f64>,
    }
}
