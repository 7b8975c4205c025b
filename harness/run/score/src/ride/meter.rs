//! The meter of shock and ride at the driver's seat.

use super::filter::{Filter, Lanes};
use super::weighting::{ABSORBED_POWER, PEAK_BANDWIDTH, PRADKO_LEE_GAIN, low_pass, stages};
use super::{HORIZONTAL, LANDED_S, Ride, UPRIGHT};

/// Standard acceleration of free fall, m/s² (ISO 80000-3), by which peaks are told.
const G: f64 = 9.806_65;

/// The state of a vehicle at the end of a step of the simulation, as the meter needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RideStep {
    /// The acceleration of the seat in this step, without gravity, along the axes of the body (x forward, y left, z up), m/s².
    pub acceleration: [f64; 3],
    /// The vertical component of the body's upward axis: the cosine of the tilt.
    pub upward: f64,
    /// The number of wheels that bear a load.
    pub loaded_wheels: usize,
    /// Whether the hull is away from ground and obstacles.
    pub hull_is_free: bool,
}

/// Measures shock and ride, step by step. A step takes neither memory nor more than some ten nanoseconds.
#[derive(Clone, Debug)]
pub struct RideMeter {
    stages: [Filter; 4],
    peak: Filter,
    sums: Lanes,
    peak_squared: f64,
    peak_vertical: f64,
    steps: u64,
    airborne: u64,
    /// Steps without a break until now in which the vehicle stood upright on its wheels.
    standing: u64,
    /// As many as it takes to have landed.
    landed: u64,
}

impl RideMeter {
    /// A meter for a simulation with this time step (s) in a world of this scale. By Froude's rule a small vehicle has the
    /// accelerations of a large one in √scale of its time, so the filters run on the time of the large one.
    #[must_use]
    pub fn new(step: f64, scale: f64) -> Self {
        let step = step / scale.sqrt();
        Self {
            stages: stages(step).map(|sections| Filter::new(sections, step)),
            peak: Filter::new([low_pass(PEAK_BANDWIDTH, step); 4], step),
            sums: Lanes::ZERO,
            peak_squared: 0.0,
            peak_vertical: 0.0,
            steps: 0,
            airborne: 0,
            standing: 0,
            landed: (LANDED_S / step).round() as u64,
        }
    }

    /// Takes the next step.
    #[inline]
    pub fn push(&mut self, step: &RideStep) {
        let [x, y, z] = step.acceleration;
        let own = Lanes::new([x, y, z, z]);
        let mut weighted = own;
        for stage in &mut self.stages {
            weighted = stage.push(weighted);
        }
        self.sums += weighted * weighted;
        let [x, y, z, _] = self.peak.push(own).to_array();
        self.peak_squared = self.peak_squared.max(x * x + y * y + z * z);
        self.peak_vertical = self.peak_vertical.max(z.abs());
        self.steps += 1;
        self.airborne += u64::from(step.loaded_wheels == 0 && step.hull_is_free);
        let stands = step.upward > UPRIGHT && step.loaded_wheels >= 2;
        self.standing = if stands { self.standing + 1 } else { 0 };
    }

    /// The measures; `None` without steps, or if a simulation that failed left a number that can't be a measure.
    #[must_use]
    pub fn ride(&self) -> Option<Ride> {
        if self.steps == 0 {
            return None;
        }
        let n = self.steps as f64;
        let [x, y, z, power] = (self.sums / n).to_array();
        let ride = Ride {
            seat_peak_g: self.peak_squared.sqrt() / G,
            seat_peak_z_g: self.peak_vertical / G,
            seat_rms_m_per_s2: (HORIZONTAL * HORIZONTAL * (x + y) + z).sqrt(),
            seat_rms_z_m_per_s2: z.sqrt(),
            absorbed_power_w: ABSORBED_POWER * PRADKO_LEE_GAIN * PRADKO_LEE_GAIN * power,
            airborne_fraction: self.airborne as f64 / n,
            landed: self.standing >= self.landed,
            energy_surplus_j: None,
            held_fraction: None,
        };
        ride.flaw().is_none().then_some(ride)
    }
}
