//! The person's part in a trial: commands from the page, in real time, and the vehicle's motion to the page.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use vb_record::Sample;
use vb_sdk::{Command, Gear, Observation, Task};
use vb_sim::{Simulation, VehicleState};
use vb_trial::{Driver, DriverFault, Log, Witness};
use vb_vehicle::{VehicleModel, kinematics::Side};

use crate::server::Motion;
use crate::wheel::Wheel;

/// The time between two looks at what the person does, s.
pub const CONTROL_PERIOD: f64 = 0.02;

/// The time on the clock: a person drives in real time. What is recorded are the commands, so nothing else of it reaches an
/// episode.
#[allow(clippy::disallowed_methods, reason = "a person drives in real time")]
fn now() -> Instant {
    Instant::now()
}

/// Drives by what a person does, as fast as the clock goes.
pub struct PersonDriver {
    wheel: Wheel,
    begun: Option<Instant>,
    /// Set when the person is gone.
    gone: Arc<AtomicBool>,
}

impl PersonDriver {
    /// A driver by this wheel; once `gone` is set it waits for nobody.
    #[must_use]
    pub fn new(wheel: Wheel, gone: Arc<AtomicBool>) -> Self {
        Self { wheel, begun: None, gone }
    }
}

impl Driver for PersonDriver {
    fn name(&self) -> String {
        "person".to_owned()
    }

    fn start(&mut self, _: &Task, _: Log) -> Result<(), DriverFault> {
        self.wheel.set(Command { gear: Gear::Forward, ..Command::default() });
        self.begun = Some(now());
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        if let Some(begun) = self.begun
            && !self.gone.load(Ordering::Relaxed)
        {
            let due = begun + Duration::from_secs_f64(observation.time.max(0.0));
            let early = due.saturating_duration_since(now());
            if early.is_zero() {
                // A machine that can't keep up drives slower than the clock, and doesn't rush after it.
                let late = now().saturating_duration_since(due);
                self.begun = Some(begun + late);
            } else {
                std::thread::sleep(early);
            }
        }
        Ok(self.wheel.get())
    }
}

/// Shows a trial to the page: each sample of the simulation as a list of numbers of 32 bits.
///
/// They are the time (s), the position (m) and the attitude (a quaternion x, y, z, w) of the vehicle, its speed (m/s), roll
/// and pitch (degrees), steering, throttle, brake and gear (-1, 0, 1), and of each wheel its centre and axis in the frame
/// of the chassis and the angle that it has turned (rad).
pub struct Live<'a> {
    vehicle: &'a VehicleModel,
    to: Motion,
    angles: Vec<f64>,
    last: f64,
}

impl<'a> Live<'a> {
    #[must_use]
    pub fn new(vehicle: &'a VehicleModel, to: Motion) -> Self {
        Self { vehicle, to, angles: vec![0.0; 2 * vehicle.axles().len()], last: 0.0 }
    }
}

impl Witness for Live<'_> {
    fn sample(&mut self, _: &Simulation, state: &VehicleState, s: &Sample) {
        let passed = s.time - self.last;
        self.last = s.time;
        for (angle, wheel) in self.angles.iter_mut().zip(&state.wheels) {
            *angle += wheel.speed * passed;
        }
        let q = state.attitude;
        let gear = vb_trial::gear_number(state.gear);
        let mut values = vec![s.time, s.x, s.y, s.z, q.i, q.j, q.k, q.w, state.velocity_body.norm()];
        values.extend([s.roll.to_degrees(), s.pitch.to_degrees(), state.steering, s.throttle, s.brake, gear]);
        for (a, (axle, solved)) in self.vehicle.spec().axles.iter().zip(self.vehicle.axles()).enumerate() {
            let travels = [state.wheels[2 * a].deflection, state.wheels[2 * a + 1].deflection];
            for (i, side) in [Side::Left, Side::Right].into_iter().enumerate() {
                let pose = solved.wheel(side, travels, state.steering);
                let hub = Vector3::from(axle.position) + pose.hub;
                let axis = pose.axis.normalize();
                // To the left whatever side it is on, so that a positive angle rolls forward.
                let axis = if axis.y < 0.0 { -axis } else { axis };
                values.extend(hub.iter().chain(axis.iter()));
                values.push(self.angles[2 * a + i]);
            }
        }
        let values: Vec<f32> = values.iter().map(|v| *v as f32).collect();
        self.to.send(&values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_drives_in_real_time_and_is_not_waited_for_once_gone() {
        let gone = Arc::new(AtomicBool::new(false));
        let mut driver = PersonDriver::new(Wheel::default(), Arc::clone(&gone));
        driver.start(&Task::default(), Box::new(|_, _| {})).unwrap();
        let begun = now();
        let at = |time: f64| Observation { time, ..Observation::default() };
        driver.step(&at(0.2)).unwrap();
        assert!(now().duration_since(begun) >= Duration::from_millis(195));
        gone.store(true, Ordering::Relaxed);
        driver.step(&at(1e6)).unwrap();
    }
}
