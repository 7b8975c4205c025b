//! The inertial measurement unit.
//!
//! Specific force and angular velocity are means over a sample, as sensors that integrate give them. The errors are those
//! of IEEE Std 952-1997, annex C: white noise of the density N, a first-order Gauss–Markov bias whose Allan deviation has its
//! greatest value, 0.617 σ at 1.89 correlation times, where data sheets state the bias instability, and a rate random walk.

use super::DT;
use crate::V3;
use crate::frame::{Frame, vec3};
use crate::noise::{GaussMarkov, RandomWalk, Seed, White};
use crate::profile::{ImuModel, Inertial};
use vb_sdk::ImuSample;
use vb_sim::VehicleState;
use vb_vehicle::GRAVITY;

/// The greatest Allan deviation of a first-order Gauss–Markov process over its standard deviation: √(2/r·(1 − (3 − 4e⁻ʳ +
/// e⁻²ʳ)/(2r))) at r = 1.89.
const PEAK: f64 = 0.617;

/// The errors along one axis.
#[derive(Clone, Debug)]
struct Axis {
    white: White,
    bias: GaussMarkov,
    walk: RandomWalk,
}

impl Axis {
    fn new(model: &Inertial, seed: &Seed, name: &str) -> Self {
        let stream = |part: &str| seed.stream("imu", &format!("{name} {part}"));
        let start = White::new(model.turn_on_bias, stream("turn-on")).step();
        Self {
            // A mean over the time DT of white noise of the density N has the deviation N/√DT.
            white: White::new(model.random_walk / DT.sqrt(), stream("white")),
            bias: GaussMarkov::new(
                model.bias_instability / PEAK,
                model.bias_correlation_s,
                DT,
                stream("bias"),
            ),
            walk: RandomWalk::new(model.rate_random_walk, start, stream("walk")),
        }
    }

    fn step(&mut self) -> f64 {
        self.white.step() + self.bias.step() + self.walk.step(DT)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Imu {
    /// Samples that one measurement is the mean of.
    every: u64,
    force: [Axis; 3],
    rate: [Axis; 3],
    /// Sums since the last measurement.
    sum: [V3; 2],
    count: u64,
    measured: Vec<ImuSample>,
}

impl Imu {
    pub(crate) fn new(model: &ImuModel, every: u64, seed: &Seed) -> Self {
        let axes = |model: &Inertial, name: &str| {
            ["x", "y", "z"].map(|axis| Axis::new(model, seed, &format!("{name} {axis}")))
        };
        Self {
            every,
            force: axes(&model.accelerometer, "force"),
            rate: axes(&model.gyroscope, "rate"),
            sum: [V3::zeros(); 2],
            count: 0,
            measured: Vec::new(),
        }
    }

    /// Measures the time from one state to the next.
    pub(crate) fn sample(&mut self, before: &VehicleState, now: &VehicleState) {
        let (v0, v1) = (before.attitude * before.velocity_body, now.attitude * now.velocity_body);
        let middle = Frame::of(before).towards(&Frame::of(now), 0.5).turn;
        let force = middle.inverse() * ((v1 - v0) / DT + V3::new(0.0, 0.0, GRAVITY));
        let rate = 0.5 * (before.angular_velocity_body + now.angular_velocity_body);
        for k in 0..3 {
            self.sum[0][k] += force[k] + self.force[k].step();
            self.sum[1][k] += rate[k] + self.rate[k].step();
        }
        self.count += 1;
        if self.count == self.every {
            let [force, rate] = self.sum.map(|s| s / self.every as f64);
            self.measured.push(ImuSample {
                time: now.time,
                specific_force: vec3(&force),
                angular_velocity: vec3(&rate),
            });
            self.sum = [V3::zeros(); 2];
            self.count = 0;
        }
    }

    /// What was measured since the last call, oldest first.
    pub(crate) fn take(&mut self) -> Vec<ImuSample> {
        std::mem::take(&mut self.measured)
    }
}
