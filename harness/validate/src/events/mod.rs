//! The standard events.

mod convergence;
mod cornering;
mod energy;
mod grades;
mod kinematics;
mod longitudinal;
mod obstacle;
mod rest;
mod slopes;
mod soil;
mod soil_wheel;
mod tipping;
mod tracks;
mod turning;
mod twist;
mod tyres;
mod vertical;

use crate::error::ValidateError;
use crate::event::Event;
use vb_vehicle::VehicleSpec;

const EVENTS: &[Event] = &[
    kinematics::SUSPENSION,
    tyres::TYRES,
    rest::STATIC,
    rest::PARKED,
    longitudinal::ACCELERATION,
    longitudinal::BRAKING,
    longitudinal::COAST_DOWN,
    longitudinal::ROLLING,
    cornering::CORNERING,
    cornering::STEP_STEER,
    cornering::BODY_ROLL,
    turning::TURNING_CIRCLE,
    tracks::TURNING,
    grades::GRADE_HELD,
    grades::GRADE_FULL,
    grades::GRADE_PUBLISHED,
    slopes::SIDE_SLOPE,
    slopes::TILT_TABLE,
    vertical::BUMP,
    vertical::DROP,
    vertical::STEP_CLIMB,
    tracks::TRENCH,
    obstacle::OBSTACLES,
    twist::TWIST,
    twist::SPLIT_GRIP,
    tipping::TIP_OVER,
    tipping::OVERTURNED,
    energy::FREE_FALL,
    energy::ENERGY,
    soil_wheel::PLATE,
    soil_wheel::WHEEL,
    soil_wheel::SECOND_PASS,
    soil::REST,
    soil::ACCELERATION,
    soil::GRADE,
    soil::GRID,
    tracks::PULL,
    convergence::CONVERGENCE,
];

/// Of tyres, of wheels that roll without slip about one centre, and of single wheels: nothing of a track.
const WHEELS_ONLY: [&str; 10] = [
    tyres::TYRES.name,
    longitudinal::ROLLING.name,
    cornering::CORNERING.name,
    cornering::STEP_STEER.name,
    cornering::BODY_ROLL.name,
    obstacle::OBSTACLES.name,
    twist::TWIST.name,
    twist::SPLIT_GRIP.name,
    soil_wheel::WHEEL.name,
    soil_wheel::SECOND_PASS.name,
];
/// Of the vehicle on soil, where its set-up may be another than on rigid ground.
const ON_SOIL: [&str; 5] =
    [soil::REST.name, soil::ACCELERATION.name, soil::GRADE.name, soil::GRID.name, tracks::PULL.name];
const TRACKS_ONLY: [&str; 3] = [tracks::TURNING.name, tracks::TRENCH.name, tracks::PULL.name];

/// Whether an event says something of a vehicle: some are of wheels, some of tracks.
#[must_use]
pub fn fits(event: &Event, spec: &VehicleSpec) -> bool {
    let not: &[&str] = if spec.tracks.is_some() { &WHEELS_ONLY } else { &TRACKS_ONLY };
    !not.contains(&event.name)
}

/// Whether an event puts the vehicle on soil.
pub(crate) fn on_soil(event: &Event) -> bool {
    ON_SOIL.contains(&event.name)
}

/// All events, in the order of the report.
#[must_use]
pub fn events() -> &'static [Event] {
    EVENTS
}

/// The event of this name.
///
/// # Errors
/// [`ValidateError::UnknownEvent`], which names all that exist.
pub fn event(name: &str) -> Result<&'static Event, ValidateError> {
    EVENTS.iter().find(|e| e.name == name).ok_or_else(|| ValidateError::UnknownEvent {
        name: name.to_owned(),
        known: EVENTS.iter().map(|e| e.name).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_that_speaks_of_soil_and_drives_a_vehicle_is_on_soil() {
        let of_plates_and_single_wheels =
            [soil_wheel::PLATE.name, soil_wheel::WHEEL.name, soil_wheel::SECOND_PASS.name];
        for e in events().iter().filter(|e| !of_plates_and_single_wheels.contains(&e.name)) {
            let speaks = [e.title, e.about].iter().any(|t| t.to_lowercase().contains("soil"));
            assert_eq!(on_soil(e), speaks, "{}", e.name);
        }
    }
}
