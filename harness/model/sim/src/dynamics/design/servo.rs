//! The limits of the steering gears.

use vb_vehicle::VehicleSpec;
use vb_vehicle::suspension::SteeringGear;

/// Fraction of its effort that a limited gear keeps for braking at the end of its motion; the rest bears the load. Ours.
const BRAKING: f64 = 0.5;

/// The limits of a vehicle's steering gears.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Servo {
    gears: Vec<Gear>,
}

/// The gear of a steered axle with its limit.
#[derive(Clone, Debug, PartialEq)]
struct Gear {
    /// The gear, which gives its position over the command.
    gear: SteeringGear,
    /// The maximum generalised force on the gear's position, N m: limit times largest travel or angle.
    effort: f64,
    /// The inertia of the axle's wheels against a change of the gear's position, kg m².
    inertia: f64,
}

/// The limits at a steering command, where each gear moves with the slope of its position over the command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    /// The maximum generalised force on the command, N m.
    effort: f64,
    /// The inertia of the steered wheels against a change of the command, kg m².
    inertia: f64,
}

impl Servo {
    /// The limits of all gears; none if a gear is unlimited or nothing is steered. `inertias` are those of each axle's
    /// wheels against a change of the command at command 0 (kg m²).
    pub(crate) fn new(spec: &VehicleSpec, inertias: &[f64]) -> Option<Self> {
        let mut gears = Vec::new();
        for (gear, inertia) in
            spec.axles.iter().zip(inertias).filter_map(|(a, i)| Some((a.steering.as_ref()?, i)))
        {
            let limit = match gear {
                SteeringGear::RackAndPinion { .. } => spec.steering.force?,
                SteeringGear::PitmanArm { .. } | SteeringGear::RotaryArm { .. } => spec.steering.torque?,
            };
            let slope = gear.slope(0.0);
            let inertia = inertia / (slope * slope);
            gears.push(Gear { gear: gear.clone(), effort: limit * gear.reach(), inertia });
        }
        let servo = Self { gears };
        (servo.at(0.0).inertia > 0.0).then_some(servo)
    }

    /// The limits at a command in \[−1, 1\].
    pub(crate) fn at(&self, command: f64) -> Limit {
        let mut limit = Limit { effort: 0.0, inertia: 0.0 };
        for gear in &self.gears {
            let slope = gear.gear.slope(command);
            limit.effort += gear.effort * slope;
            limit.inertia += gear.inertia * (slope * slope);
        }
        limit
    }
}

impl Limit {
    /// The maximum generalised force on the command, N m.
    pub(crate) fn effort(self) -> f64 {
        self.effort
    }

    /// The fastest rate (1/s) at which the gears may approach the asked command from a distance, so that they can stop
    /// there.
    pub(crate) fn approach(self, distance: f64) -> f64 {
        (2.0 * BRAKING * self.effort / self.inertia * distance.abs()).sqrt()
    }

    /// The rate (1/s) after a step of `dt` (s) in which the gears want the rate `wanted` under a load (N m), and whether
    /// their effort sufficed.
    pub(crate) fn drive(self, wanted: f64, rate: f64, load: f64, dt: f64) -> (f64, bool) {
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
    const GEAR: Limit = Limit { effort: 1200.0, inertia: 8.0 };

    #[test]
    fn a_gear_reaches_its_speed_against_a_load_below_its_limit_and_stalls_above() {
        let settle = |load: f64| {
            let mut rate = 0.0;
            for _ in 0..200 {
                rate = GEAR.drive(1.25, rate, load, 1e-3).0;
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
            let next = GEAR.drive(wanted, rate, load, dt).0;
            let effort = GEAR.inertia * (next - rate) / dt - load;
            assert!(effort.abs() <= GEAR.effort * (1.0 + 1e-9), "step {k}: {effort} N m");
            rate = next;
        }
    }

    /// The torque at its arm is the same whatever the command: a gear that moves less per command bears more load on it.
    #[test]
    fn a_servo_stalls_at_the_torque_of_its_arm_at_every_command() {
        let (torque, angle) = (2.0, -0.5);
        let gear = SteeringGear::RotaryArm {
            pivot: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            angle,
            response: vec![[-1.0, -1.0], [0.0, 0.0], [0.5, 0.2], [1.0, 0.8]],
        };
        let servo = Servo { gears: vec![Gear { gear, effort: 1.0, inertia: 0.01 }] };
        // Angle of the arm per command in each segment.
        for (command, slope) in [(-1.0, 1.0), (-0.5, 1.0), (0.25, 0.4), (0.75, 1.2), (1.0, 1.2)] {
            let load = |arm: f64| arm * slope * f64::abs(angle);
            let limit = servo.at(command);
            let moved = |load: f64| limit.drive(0.1, 0.1, load, 1e-3);
            assert_eq!(moved(-load(0.99 * torque)), (0.1, true), "{command}");
            let (rate, sufficed) = moved(-load(1.5 * torque));
            // The acceleration of the arm: the excess torque over the arm's own inertia, 0.01 kg m² at position 1, 0.5 rad.
            let arm = 0.5 * torque / (0.01 / (angle * angle));
            let expected = 0.1 - 1e-3 * arm / (slope * f64::abs(angle));
            assert!(!sufficed && (rate - expected).abs() < 1e-12, "{command}: {rate} 1/s, {expected}");
        }
    }
}
