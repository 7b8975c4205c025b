//! Engine, differentials and brakes.

use wide::f32x8;

use super::vector::{all, within};
use super::{Controls, Shape, Twin, WHEELS, Wheel};

/// The HMMWV's engine and converter (`tasks/vehicles/hmmwv.yaml`), in rad/s and N m at full scale. Idle speed, and the
/// speeds at which the governor begins to close and is closed.
pub(super) const IDLE: f32 = 68.0;
pub(super) const GOVERNED: [f32; 2] = [377.0, 398.0];
/// Torque at full throttle, `maximum − coefficient (speed − peak)²`, and at closed throttle,
/// `constant + coefficient · speed`.
const FULL: [f32; 3] = [325.0, 0.0022, 220.0];
const CLOSED: [f32; 2] = [-41.0, -0.095];
/// The inertia of the engine, kg m².
const ROTOR: f32 = 1.1;
/// Pump torque of the converter over its squared speed, N m s²: constant at low speed ratios; a line through 0.5 and
/// 0.9; and a line through 0 at equal speeds, extended to overrun.
const PUMP: f32 = 0.0073;
const PUMP_FALLS: [f32; 2] = [0.0055, 0.051];
/// Torque ratio over speed ratio: the minimum of three lines, at least 1.
const RATIO: [[f32; 2]; 3] = [[2.0, -0.8], [2.1, -1.2], [2.2, -1.4]];
/// Ratio from the turbine to all wheels in first gear and in reverse, and the HMMWV's weight times its wheel radius, N
/// m.
const GEARS: [f32; 2] = [13.0, 10.9];
const ARM: f32 = 11_426.0;
/// Torque bias of a Torsen differential with a ratio of 4 to 1: the slower wheel gets this fraction of half the axle
/// torque more, and the faster wheel less, (4 − 1) / (4 + 1).
const BIAS: f32 = 0.6;
/// Spin-up of the wheels of an axle and of all wheels relative to two wheels that counter-rotate without turning a
/// shaft: of the HMMWV's inertia (`tasks/vehicles/hmmwv.yaml`) a wheel has 7.8 kg m², the shafts of an axle, referred
/// to its wheels, 14.3 in addition, and the shafts between the axles another 30.2.
const TOGETHER: [f32; 2] = [15.6 / 29.9, 31.2 / 90.0];

/// Means of the wheels of each axle, and of all.
fn means(of: [f32x8; WHEELS]) -> ([f32x8; 2], f32x8) {
    let axles = [(of[0] + of[1]) * all(0.5), (of[2] + of[3]) * all(0.5)];
    (axles, (axles[0] + axles[1]) * all(0.5))
}

impl Twin {
    /// Wheel torques and the maximum torque of each brake, N m, after a step of `dt` (s) that also accelerates the
    /// engine (rad/s at full scale).
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
        // A lock between the axles, and differentials with a torque bias between the sides.
        let axles = within((rear - front) * all(clutch[0]), all(arm));
        let torques = std::array::from_fn(|i| {
            let of_axle = drive + if i < 2 { axles } else { -axles };
            let most = of_axle.abs() * all(BIAS) + all(clutch[1]);
            of_axle + within((spins[i ^ 1] - spins[i]) * all(clutch[1]), most)
        });
        (torques, (-c.pedal).max(all(0.0)) * all(brake))
    }
}

/// Accelerates the wheels by the spin that each would gain without connected shafts, rad/s.
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

    /// Impulses change angular momentum equally, whatever inertia is coupled to the wheels.
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
