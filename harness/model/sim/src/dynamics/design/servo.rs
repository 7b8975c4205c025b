//! The limit of the steering gears.

use vb_vehicle::VehicleSpec;
use vb_vehicle::suspension::SteeringGear;

/// Fraction of its effort that a limited gear keeps for braking at the end of its motion; the rest bears the load. Ours.
const BRAKING: f64 = 0.5;

/// The limit of a vehicle's steering gears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Servo {
    /// The maximum generalised force on the command, N m.
    effort: f64,
    /// The inertia of the steered wheels against a change of the command, kg m².
    inertia: f64,
}

impl Servo {
    /// The limit of all gears together: the sum of force times travel and torque times angle over the steered axles; none
    /// if a gear is unlimited or nothing is steered. `inertia` is that of the steered wheels (kg m²).
    pub(crate) fn new(spec: &VehicleSpec, inertia: f64) -> Option<Self> {
        let mut effort = None;
        for gear in spec.axles.iter().filter_map(|a| a.steering.as_ref()) {
            let limit = match gear {
                SteeringGear::RackAndPinion { .. } => spec.steering.force?,
                SteeringGear::PitmanArm { .. } | SteeringGear::RotaryArm { .. } => spec.steering.torque?,
            };
            effort = Some(effort.unwrap_or(0.0) + limit * gear.stroke());
        }
        effort.filter(|_| inertia > 0.0).map(|effort| Self { effort, inertia })
    }

    /// The maximum generalised force on the command, N m.
    pub(crate) fn effort(&self) -> f64 {
        self.effort
    }

    /// The fastest rate (1/s) at which the gear may approach the asked command from a distance, so that it can stop there.
    pub(crate) fn approach(&self, distance: f64) -> f64 {
        (2.0 * BRAKING * self.effort / self.inertia * distance.abs()).sqrt()
    }

    /// The rate (1/s) after a step of `dt` (s) in which the gear wants the rate `wanted` under a load (N m), and whether
    /// its effort sufficed.
    pub(crate) fn drive(&self, wanted: f64, rate: f64, load: f64, dt: f64) -> (f64, bool) {
        let needed = self.inertia * (wanted - rate) / dt - load;
        if needed.abs() <= self.effort {
            return (wanted, true);
        }
        (rate + dt * (load + self.effort * needed.signum()) / self.inertia, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rack of 15 kN and 80 mm of travel with 8 kg m² of wheels.
    const SERVO: Servo = Servo { effort: 1200.0, inertia: 8.0 };

    #[test]
    fn a_gear_reaches_its_speed_against_a_load_below_its_limit_and_stalls_above() {
        let settle = |load: f64| {
            let mut rate = 0.0;
            for _ in 0..200 {
                rate = SERVO.drive(1.25, rate, load, 1e-3).0;
            }
            rate
        };
        assert_eq!(settle(0.0), 1.25);
        assert_eq!(settle(-1100.0), 1.25);
        // 100 N m more than it can bear drive it back by 100/8 1/s².
        let driven_back = settle(-1300.0);
        assert!((driven_back + 100.0 / 8.0 * 0.2).abs() < 1e-9, "{driven_back}");
    }

    #[test]
    fn a_gear_never_exerts_more_than_its_limit() {
        let (mut rate, dt) = (0.0, 1e-3);
        for k in 0..2000 {
            let load = 3000.0 * vb_math::sin(0.01 * f64::from(k));
            let wanted = 1.25 * vb_math::sin(0.037 * f64::from(k));
            let next = SERVO.drive(wanted, rate, load, dt).0;
            let effort = SERVO.inertia * (next - rate) / dt - load;
            assert!(effort.abs() <= SERVO.effort * (1.0 + 1e-9), "step {k}: {effort} N m");
            rate = next;
        }
    }
}
