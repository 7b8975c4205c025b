//! What engine, differentials and brakes do to the wheels.

use wide::f32x8;

use super::vector::{all, within};
use super::{Controls, Shape, Twin, WHEELS, Wheel};

/// The greatest torque of all wheels at full throttle, in weights times radius, by their mean spin (rad/s at full scale): the greater of
/// two lines, `[at rest, rise]` and `[at the spin where it begins, that spin, rise]`, and its bound: engine and gears of the HMMWV.
const SLOW: [f32; 2] = [1.07, 0.09];
const RISING: [f32; 3] = [1.33, 2.86, 1.24];
const MOST: f32 = 3.33;
/// How much less the wheels of an axle, and all wheels, spin up by the same torques than a wheel that turns against its neighbour, with
/// which no shaft turns: of the HMMWV's inertia (`tasks/vehicles/hmmwv.yaml`) a wheel has 8.7 kg m², the shafts of an axle, seen from its wheels, 13.1
/// besides, and those between the axles another 27.5.
const TOGETHER: [f32; 2] = [17.4 / 30.5, 34.8 / 88.5];

/// Means of the wheels of either axle, and of all.
fn means(of: [f32x8; WHEELS]) -> ([f32x8; 2], f32x8) {
    let axles = [(of[0] + of[1]) * all(0.5), (of[2] + of[3]) * all(0.5)];
    (axles, (axles[0] + axles[1]) * all(0.5))
}

impl Twin {
    /// Torques of the wheels, and the most that each brake resists with, N m.
    pub(super) fn torques(&self, wheels: &[Wheel; WHEELS], c: &Controls) -> ([f32x8; WHEELS], f32x8) {
        let Shape { arm, power, drag, brake, clutch, root, .. } = self.shape;
        let spins = wheels.map(|w| w.spin);
        let ([front, rear], mean) = means(spins);
        let (speed, pace) = (mean.abs(), mean.abs() * all(root));
        let slow = all(SLOW[0]) + pace * all(SLOW[1]);
        let rising = all(RISING[0]) + (pace - all(RISING[1])) * all(RISING[2]);
        let full = slow.max(rising).min(all(MOST)) * all(arm);
        let full = full.min(all(power) / speed.max(all(0.1)));
        let throttle = c.pedal.max(all(0.0));
        let closed = within(mean * all(drag), all(drag));
        let drive = (throttle * full * c.way - (all(1.0) - throttle) * closed) * all(0.25);
        // Differentials are open but for some friction, which is in full from a difference of 1 rad/s on.
        let slips = |difference: f32x8, torque: f32| within(difference * all(torque), all(torque));
        let axles = slips(rear - front, clutch[0]);
        let torques = std::array::from_fn(|i| {
            let from_axle = if i < 2 { axles } else { -axles };
            drive + from_axle + slips(spins[i ^ 1] - spins[i], clutch[1])
        });
        (torques, (-c.pedal).max(all(0.0)) * all(brake))
    }
}

/// Spins the wheels up by what each would gain if nothing but itself turned with it, rad/s.
pub(super) fn spin_up(wheels: &mut [Wheel; WHEELS], gained: [f32x8; WHEELS]) {
    let (axles, mean) = means(gained);
    for (i, w) in wheels.iter_mut().enumerate() {
        let axle = axles[i / 2];
        let together = (axle - mean) * all(TOGETHER[0]) + mean * all(TOGETHER[1]);
        w.spin += gained[i] - axle + together;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Impulses change angular momenta by as much, whatever turns with the wheels.
    #[test]
    fn shafts_turn_with_wheels_that_turn_together() {
        let spun = |gained: [f32; WHEELS]| {
            let mut wheels = [Wheel::default(); WHEELS];
            spin_up(&mut wheels, gained.map(all));
            wheels.map(|w| w.spin.to_array()[0])
        };
        let near = |a: [f32; WHEELS], b: [f32; WHEELS]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        // With 8.7 N m s on each wheel.
        assert!(near(spun([1.0, -1.0, 0.0, 0.0]), [1.0, -1.0, 0.0, 0.0]));
        let axles = 8.7 * 2.0 / (2.0 * 8.7 + 13.1);
        assert!(near(spun([1.0, 1.0, -1.0, -1.0]), [axles, axles, -axles, -axles]));
        let together = 8.7 * 4.0 / (4.0 * 8.7 + 2.0 * 13.1 + 27.5);
        assert!(near(spun([1.0; WHEELS]), [together; WHEELS]));
    }
}
