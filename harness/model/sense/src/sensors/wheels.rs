//! What is measured at the wheels: spins from encoders that count, and suspension travels.

use super::DT;
use crate::noise::{Seed, White};
use crate::profile::{WheelModel, WheelNoise};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use vb_sdk::Wheel;
use vb_sim::{VehicleState, WheelState};

/// An encoder counts the marks that pass it. The spin is the number of marks that passed within a window of time, over the
/// window, so it is a multiple of one mark for each window, and no part of the way is lost in the long run.
#[derive(Clone, Debug)]
struct Encoder {
    /// Turned so far, in marks.
    angle: f64,
    /// Counts at the samples of the window, oldest first.
    counts: VecDeque<f64>,
    travel: White,
}

/// The sensors of all wheels.
#[derive(Clone, Debug)]
pub(crate) struct Wheels {
    /// Samples between readings; none for a reading whenever the planner looks.
    every: Option<u64>,
    noise: Option<WheelNoise>,
    encoders: Vec<Encoder>,
    measured: Vec<Wheel>,
    /// Of the last sample that was due; empty when it has been read.
    ready: Vec<Wheel>,
    scale: f64,
    seed: Seed,
}

fn exact(w: &WheelState) -> Wheel {
    Wheel { spin: w.speed, travel: w.deflection }
}

impl Wheels {
    pub(crate) fn new(model: &WheelModel, every: Option<u64>, scale: f64, seed: &Seed) -> Self {
        let noise = match model {
            WheelModel::Exact => None,
            WheelModel::Measured(noise) => Some(noise.clone()),
        };
        let (measured, ready) = (Vec::new(), Vec::new());
        Self { every, noise, encoders: Vec::new(), measured, ready, scale, seed: seed.clone() }
    }

    /// Whether it needs samples at all.
    pub(crate) fn is_idle(&self) -> bool {
        self.noise.is_none() && self.every.is_none()
    }

    fn first(&mut self, noise: &WheelNoise, now: &VehicleState) {
        for i in 0..now.wheels.len() {
            let stream = |part: &str| self.seed.stream("wheel-odometry", &format!("{i} {part}"));
            // Where the first mark is, nobody knows.
            let angle = stream("phase").unit();
            let travel = White::new(noise.travel_std_m * self.scale, stream("travel"));
            self.encoders.push(Encoder { angle, counts: VecDeque::from([angle.floor()]), travel });
        }
    }

    /// Takes the state at sample `k` and the one before it.
    pub(crate) fn sample(&mut self, k: u64, before: &VehicleState, now: &VehicleState) {
        let Some(noise) = self.noise.clone() else {
            if self.every.is_some_and(|n| k.is_multiple_of(n)) {
                self.ready = now.wheels.iter().map(exact).collect();
            }
            return;
        };
        if self.encoders.is_empty() {
            self.first(&noise, now);
        }
        let marks = f64::from(noise.counts_per_turn) / TAU;
        let window = (noise.window_s / DT).round() as usize;
        self.measured.clear();
        for ((encoder, w0), w1) in self.encoders.iter_mut().zip(&before.wheels).zip(&now.wheels) {
            encoder.angle += 0.5 * (w0.speed + w1.speed) * (now.time - before.time) * marks;
            encoder.counts.push_back(encoder.angle.floor());
            if encoder.counts.len() > window + 1 {
                encoder.counts.pop_front();
            }
            let passed = encoder.counts[encoder.counts.len() - 1] - encoder.counts[0];
            let travel = w1.deflection + encoder.travel.step();
            self.measured.push(Wheel { spin: passed / marks / noise.window_s, travel });
        }
        if self.every.is_some_and(|n| k.is_multiple_of(n)) {
            self.ready.clone_from(&self.measured);
        }
    }

    /// The reading at a step of the planner; empty if there is no new one.
    pub(crate) fn read(&mut self, state: &VehicleState) -> Vec<Wheel> {
        if self.is_idle() {
            return state.wheels.iter().map(exact).collect();
        }
        if self.every.is_none() { self.measured.clone() } else { std::mem::take(&mut self.ready) }
    }
}
