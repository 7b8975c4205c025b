//! What engine, differentials and brakes do to the wheels.

use wide::f32x8;

use super::vector::{all, within};
use super::{Controls, Shape, Twin, WHEELS, Wheel};

/// The HMMWV's engine and converter (`tasks/vehicles/hmmwv.yaml`), in rad/s and N m at full scale. Idle speed, and where the governor
/// begins to close and has closed.
pub(super) const IDLE: f32 = 68.0;
pub(super) const GOVERNED: [f32; 2] = [377.0, 398.0];
/// The torque at full throttle, `most − by (speed − at)²`, and the one at none, `at rest + by speed`.
const FULL: [f32; 3] = [325.0, 0.0022, 220.0];
const CLOSED: [f32; 2] = [-41.0, -0.095];
/// The inertia of the engine, kg m².
const ROTOR: f32 = 1.1;
/// What the converter's pump takes over the square of its speed, N m s²: at low ratios of speed; a line through 0.5 and 0.9; and one to
/// nothing where both sides turn alike, and on where the wheels drive the engine.
const PUMP: f32 = 0.0073;
const PUMP_FALLS: [f32; 2] = [0.0055, 0.051];
/// The ratio of torques over that of speeds: the least of three lines, and 1 at least.
const RATIO: [[f32; 2]; 3] = [[2.0, -0.8], [2.1, -1.2], [2.2, -1.4]];
/// From the turbine to all wheels in the first gear and in reverse, and the HMMWV's weight times the radius of its wheels, N m.
const GEARS: [f32; 2] = [13.0, 10.9];
const ARM: f32 = 11_426.0;
/// What a Torsen differential with a bias of 4 to 1 gives the slower wheel more and the faster one less than half of the axle's torque,
/// as a fraction of that half: (4 − 1) / (4 + 1).
const BIAS: f32 = 0.6;
/// How much less the wheels of an axle, and all wheels, spin up by the same torques than a wheel that turns against its neighbour, with
/// which no shaft turns: of the HMMWV's inertia (`tasks/vehicles/hmmwv.yaml`) a wheel has 7.8 kg m², the shafts of an axle, seen from its
/// wheels, 14.3 besides, and those between the axles another 30.2.
const TOGETHER: [f32; 2] = [15.6 / 29.9, 31.2 / 90.0];

/// Means of the wheels of either axle, and of all.
fn means(of: [f32x8; WHEELS]) -> ([f32x8; 2], f32x8) {
    let axles = [(of[0] + of[1]) * all(0.5), (of[2] + of[3]) * all(0.5)];
    (axles, (axles[0] + axles[1]) * all(0.5))
}

impl Twin {
    /// Torques of the wheels, and the most that each brake resists with, N m, after a step of `dt` (s) in which the engine (rad/s at full
    /// scale) gathers speed.
    pub(super) fn torques(
        &self,
        wheels: &[Wheel; WHEELS],
        engine: &mut f32x8,
        c: &Controls,
        dt: f32,
    ) -> ([f32x8; WHEELS], f32x8) {
        let Shape { arm, brake, clutch, root, .. } = self.shape;
        let spins = wheels.map(|w| w.spin);
        let ([front, rear], mean) = means(spins);
        let (zero, one) = (all(0.0), all(1.0));
        let gear = c.way.simd_gt(zero).select(all(GEARS[0]), all(GEARS[1]));
        let ratio = mean * c.way * gear * all(root) / *engine;
        let equal = (one - ratio) * all(PUMP_FALLS[1]);
        let pump = all(PUMP).min(all(PUMP + 0.5 * PUMP_FALLS[0]) - ratio * all(PUMP_FALLS[0])).min(equal);
        let taken = pump.max(all(-PUMP)) * *engine * *engine;
        let [a, b, c3] = RATIO.map(|[at, by]| all(at) + ratio * all(by));
        let turbine = taken * a.min(b).min(c3).max(one).min(all(RATIO[0][0]));
        let away = *engine - all(FULL[2]);
        let full = all(FULL[0]) - away * away * all(FULL[1]);
        let full = full * ((all(GOVERNED[1]) - *engine) * all(1.0 / (GOVERNED[1] - GOVERNED[0]))).min(one);
        let closed = all(CLOSED[0]) + *engine * all(CLOSED[1]);
        let torque = closed + (full - closed) * c.pedal.max(zero);
        *engine = (*engine + (torque - taken) * all(dt / (ROTOR * root))).max(all(IDLE));
        let drive = turbine * gear * c.way * all(0.25 * arm / ARM);
        // A lock between the axles, and differentials that bear a ratio of torques between the sides.
        let axles = within((rear - front) * all(clutch[0]), all(arm));
        let torques = std::array::from_fn(|i| {
            let of_axle = drive + if i < 2 { axles } else { -axles };
            let most = of_axle.abs() * all(BIAS) + all(clutch[1]);
            of_axle + within((spins[i ^ 1] - spins[i]) * all(clutch[1]), most)
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
        // With 7.8 N m s on each wheel.
        assert!(near(spun([1.0, -1.0, 0.0, 0.0]), [1.0, -1.0, 0.0, 0.0]));
        let axles = 7.8 * 2.0 / (2.0 * 7.8 + 14.3);
        assert!(near(spun([1.0, 1.0, -1.0, -1.0]), [axles, axles, -axles, -axles]));
        let together = 7.8 * 4.0 / (4.0 * 7.8 + 2.0 * 14.3 + 30.2);
        assert!(near(spun([1.0; WHEELS]), [together; WHEELS]));
    }
}
