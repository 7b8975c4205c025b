//! Shock and ride of a drive, from what the simulation does at every step.

use vb_score::{Ride, RideMeter, RideStep};
use vb_sim::{Diagnostics, Simulation};

use crate::Trial;

/// Follows the driver's seat from step to step.
#[derive(Clone, Debug)]
pub(crate) struct RideWatch {
    meter: RideMeter,
    /// The place of the seat in the chassis frame, m.
    seat: [f64; 3],
    step: f64,
    /// The velocity of the seat after the last step, world axes, m/s.
    velocity: Option<[f64; 3]>,
    /// Steps until then in which the hull was near to something.
    contact_steps: u64,
    diagnostics: Diagnostics,
}

impl RideWatch {
    pub(crate) fn new(trial: &Trial<'_>) -> Self {
        let step = trial.options.step;
        Self {
            meter: RideMeter::new(step, trial.world().scale),
            seat: trial.vehicle.spec().seat(),
            step,
            velocity: None,
            contact_steps: 0,
            diagnostics: Diagnostics::default(),
        }
    }

    /// Takes the state at the start.
    pub(crate) fn begin(&mut self, sim: &Simulation) {
        self.velocity = Some(sim.velocity_of(self.seat));
        self.contact_steps = sim.contact_steps();
    }

    /// Takes the state after a step.
    #[inline]
    pub(crate) fn push(&mut self, sim: &Simulation) {
        let velocity = sim.velocity_of(self.seat);
        let last = self.velocity.replace(velocity).unwrap_or(velocity);
        let change = [0, 1, 2].map(|k| (velocity[k] - last[k]) / self.step);
        let contact_steps = sim.contact_steps();
        self.meter.push(&RideStep {
            acceleration: sim.in_body_axes(change),
            upward: sim.upward(),
            loaded_wheels: sim.loaded_wheels(),
            hull_is_free: contact_steps == self.contact_steps,
        });
        self.contact_steps = contact_steps;
    }

    /// Takes the diagnostics of the simulation, at a sample.
    pub(crate) fn sample(&mut self, sim: &Simulation) {
        self.diagnostics = sim.diagnostics();
    }

    /// The measurements; `None` without steps.
    pub(crate) fn ride(&self) -> Option<Ride> {
        let ride = Ride {
            energy_surplus_j: Some(self.diagnostics.energy_surplus),
            held_fraction: Some(self.diagnostics.held),
            ..self.meter.ride()?
        };
        ride.flaw().is_none().then_some(ride)
    }
}
