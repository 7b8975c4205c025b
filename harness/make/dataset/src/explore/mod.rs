//! Exploration: a driver that drives about by chance, and the places where it starts.

mod place;
mod rules;

pub(crate) use place::random_start;
pub use rules::{Exploration, ReverseDraws, SpeedDraws, StartDraws, SteeringDraws};

use std::f64::consts::TAU;

use vb_math::rng::Stream;
use vb_math::{exp, ln, sin};
use vb_sdk::speed::SpeedKeeper;
use vb_sdk::{Command, Observation, Series, Task};
use vb_trial::{Driver, DriverFault, Log};

use crate::episode::SPEED_SERIES;

/// Drives about: sinusoidal steering, and speeds that are drawn again and again.
pub(crate) struct Explorer<'a> {
    rules: &'a Exploration,
    random: Stream,
    /// The root of the world's scale, by which times and speeds are multiplied.
    pace: f64,
    period: f64,
    speed: Held,
    steering: Held,
    /// m/s, negative in reverse.
    target: f64,
    wave: Wave,
    keeper: SpeedKeeper,
}

/// When the next draw is due, s.
#[derive(Default)]
struct Held(f64);

#[derive(Default)]
struct Wave {
    offset: f64,
    amplitude: f64,
    frequency: f64,
    phase: f64,
}

impl<'a> Explorer<'a> {
    pub(crate) fn new(rules: &'a Exploration, random: Stream) -> Self {
        Self {
            rules,
            random,
            pace: 1.0,
            period: 0.1,
            speed: Held::default(),
            steering: Held::default(),
            target: 0.0,
            wave: Wave::default(),
            keeper: SpeedKeeper::new(1.0),
        }
    }

    fn draw(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.random.uniform(low, high)
    }

    fn draw_wave(&mut self) {
        let steering = self.rules.steering;
        let [low, high] = steering.frequency_hz;
        self.wave = Wave {
            offset: self.draw(steering.offset),
            amplitude: self.draw(steering.amplitude),
            frequency: exp(self.draw([ln(low), ln(high)])) / self.pace,
            phase: self.draw([0.0, TAU]),
        };
        self.steering.0 += self.draw(steering.hold_s) * self.pace;
    }

    fn draw_speed(&mut self) {
        let forward = self.draw(self.rules.speed.range_m_per_s);
        // Drawn whether it is used or not, so that the other draws stay the same.
        let chance = self.random.unit();
        let backward = self.rules.reverse.map(|r| (r.probability, self.draw(r.range_m_per_s)));
        let target = match backward {
            Some((probability, speed)) if chance < probability => -speed,
            _ => forward,
        };
        self.target = target * self.pace;
        self.keeper.aim(self.target);
        self.speed.0 += self.draw(self.rules.speed.hold_s) * self.pace;
    }
}

impl Driver for Explorer<'_> {
    fn name(&self) -> String {
        format!("exploration {}", self.rules.name)
    }

    fn start(&mut self, brief: &Task, _: Log) -> Result<(), DriverFault> {
        self.pace = brief.vehicle.scale.sqrt();
        self.period = brief.control_period;
        self.keeper = SpeedKeeper::new(brief.vehicle.scale);
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        let time = observation.time;
        while self.steering.0 <= time {
            self.draw_wave();
        }
        while self.speed.0 <= time {
            self.draw_speed();
        }
        let Wave { offset, amplitude, frequency, phase } = self.wave;
        let steering = (offset + amplitude * sin(TAU * frequency * time + phase)).clamp(-1.0, 1.0);
        let speed = observation.pose.map_or(0.0, |p| p.linear_velocity.x);
        let (throttle, brake, gear) = self.keeper.update(speed, self.period);
        let series = Series { name: SPEED_SERIES.to_owned(), values: vec![self.target as f32] };
        Ok(Command { steering, throttle, brake, gear, debug: vec![series] })
    }
}
