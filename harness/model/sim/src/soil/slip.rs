//! Slip sinkage: a wheel or track that slips digs itself in.

use serde::{Deserialize, Serialize};
use vb_files::Flaw;
use vb_files::document::within;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum SlipSinkage {
    /// Sinkage does not depend on slip.
    #[default]
    None,
    /// Lyasko's coefficient (Lyasko, "Slip sinkage effect in soil–vehicle mechanics", Journal of Terramechanics 47,
    /// 2010, 21–31): sinkage under the same pressure is K = (1 + s)/(1 − 0.5 s) times as deep at the slip s of a
    /// driven wheel or track, up to 4 times at s = 1. The law's pressure is that of the sinkage z/K'.
    Lyasko {
        /// Part of the effect that the soil has, from 0 to 1: K' = 1 + strength (K − 1). It is strong in loose sand and
        /// weak in clay (Reece, "Principles of soil–vehicle mechanics", Proc. IMechE 180, 1965).
        strength: f64,
    },
}

impl SlipSinkage {
    /// The part of Lyasko's effect that the soil has; 0 for none.
    pub(super) fn strength(&self) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Lyasko { strength } => strength,
        }
    }

    pub(super) fn check(&self) -> Result<(), Flaw> {
        within("slip_sinkage.strength", self.strength(), 0.0, 1.0)
    }
}

/// Reciprocal of the factor K' by which a slip from 0 to 1 deepens the sinkage; exactly 1 for a strength of 0.
#[inline]
pub(super) fn shallower(strength: f64, slip: f64) -> f64 {
    1.0 / (1.0 + strength * (1.5 * slip / (1.0 - 0.5 * slip)))
}

/// The slip (from 0 to 1) after a time step under a rim or belt of a speed `drive` that moves over the ground by
/// `travel` (m/s). It follows the slip s = 1 − travel/drive of a driven wheel over a distance `renewal` (m) of the
/// faster of the two, within which the soil under it becomes other soil. So it has a value at standstill, and does not
/// jump. Braked wheels have none: Lyasko's coefficient is of driven wheels.
#[inline]
pub(super) fn follow(slip: f64, drive: f64, travel: f64, renewal: f64, dt: f64) -> f64 {
    let pace = drive.abs();
    // Not `clamp`, which panics where a simulation that diverges has no numbers any more.
    let lost = (pace - travel * drive.signum()).max(0.0).min(pace);
    let part = (pace.max(travel.abs()) * dt / renewal).min(1.0);
    let wanted = if pace > 0.0 { lost / pace } else { 0.0 };
    slip + (wanted - slip) * part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sinkage_grows_by_lyaskos_coefficient() {
        for (slip, coefficient) in [(0.0, 1.0), (0.2, 4.0 / 3.0), (0.5, 2.0), (1.0, 4.0)] {
            assert!((1.0 / shallower(1.0, slip) - coefficient).abs() < 1e-12);
            assert!((1.0 / shallower(0.1, slip) - (1.0 + 0.1 * (coefficient - 1.0))).abs() < 1e-12);
            assert_eq!(shallower(0.0, slip).to_bits(), 1.0_f64.to_bits());
        }
    }

    #[test]
    fn the_slip_that_counts_is_that_of_a_driven_wheel_in_either_direction_and_waits_at_standstill() {
        let after =
            |drive: f64, travel: f64| (0..10_000).fold(0.5, |s, _| follow(s, drive, travel, 0.4, 1e-3));
        for (drive, travel, slip) in [(2.0, 1.5, 0.25), (-2.0, -1.5, 0.25), (2.0, 0.0, 1.0), (2.0, -1.0, 1.0)]
        {
            assert!((after(drive, travel) - slip).abs() < 1e-6, "{drive} {travel}: {}", after(drive, travel));
        }
        for (drive, travel) in [(1.0, 2.0), (0.0, 2.0), (-0.5, -2.0)] {
            assert!(after(drive, travel) < 1e-6, "braked");
        }
        assert_eq!(after(0.0, 0.0), 0.5);
    }
}
