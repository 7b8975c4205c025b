//! Test rigs put the wheels where no step has brought them.

use super::Vehicle;
use super::facets::FacetPatches;
use super::obstacles::ObstaclePatches;
use super::state::{SteeringState, Wheel};
use crate::state::VehicleState;
use crate::tyre::Patch;

impl Vehicle {
    /// Brings all wheels to design height, at rest and without tyre forces.
    pub(crate) fn reset_wheels(&mut self) {
        let state = &mut self.state;
        state.wheels.fill(Wheel::default());
        for contacts in &mut state.contacts {
            (contacts.ground, contacts.ground_depth) = (Patch::default(), 0.0);
            contacts.obstacles = ObstaclePatches::default();
            contacts.facets = FacetPatches::default();
        }
        for (belt, track) in state.belts.iter_mut().zip(&self.design.tracks) {
            belt.reset(track);
        }
        self.last.forces.iter_mut().for_each(|f| f.load = 0.0);
    }

    /// Gives the wheels speeds and travels, and puts steering, engine and gear as they are told.
    pub(crate) fn put_wheels(&mut self, told: &VehicleState, gear: usize) {
        let state = &mut self.state;
        let known = state.wheels.iter_mut().zip(&mut state.contacts).zip(&self.design.corners);
        for (((own, contacts), corner), wheel) in known.zip(&told.wheels) {
            (own.travel, own.spin) = (wheel.deflection, wheel.speed / corner.gearing);
            // However deep the wheels are there.
            (contacts.ground_depth, contacts.obstacles) = (f64::MAX, ObstaclePatches::at_any_depth());
        }
        state.steering =
            SteeringState { command: told.steering, work: state.steering.work, ..SteeringState::default() };
        state.drive.engage(told.gear, gear, told.engine_speed);
    }

    /// Makes the wheels of each side turn at these speeds (rad/s). Returns whether the vehicle has motors for its sides.
    pub(crate) fn prescribe_spins(&mut self, spins: Option<[f64; 2]>) -> bool {
        self.state.drive.prescribe(spins)
    }
}
