//! The standard events.

mod circle;
mod convergence;
mod cornering;
mod courses;
mod data_sheet;
mod energy;
mod grades;
mod grains;
mod kinematics;
mod longitudinal;
mod obstacle;
mod rest;
mod reverse;
mod skid;
mod slopes;
mod soil;
mod soil_published;
mod soil_wheel;
mod tipping;
mod tracks;
mod turning;
mod twist;
mod tyres;
mod vertical;

use crate::error::ValidateError;
use crate::event::Event;

const EVENTS: &[Event] = &[
    data_sheet::DATA_SHEET,
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
    circle::STEADY_CIRCLE,
    turning::TURNING_CIRCLE,
    tracks::TURNING,
    skid::IN_PLACE,
    skid::TURNING,
    grades::GRADE_HELD,
    grades::GRADE_FULL,
    grades::GRADE_PUBLISHED,
    reverse::SPEED,
    reverse::GRADE,
    reverse::TURNING,
    reverse::CHANGE,
    slopes::SIDE_SLOPE,
    slopes::TILT_TABLE,
    vertical::BUMP,
    vertical::DROP,
    vertical::STEP_CLIMB,
    courses::RIDE,
    courses::HALF_ROUND,
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
    soil_published::SLIP,
    soil_published::SNOW,
    soil_published::CONE,
    soil::REST,
    soil::ACCELERATION,
    soil::GRADE,
    soil::GRID,
    tracks::PULL,
    grains::MATERIAL,
    grains::WHEEL,
    grains::VEHICLE,
    convergence::CONVERGENCE,
];

/// The events that drive over courses.
pub(crate) const COURSES: [&str; 2] = [courses::RIDE.name, courses::HALF_ROUND.name];

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
    use crate::event::Place;

    #[test]
    fn an_event_that_speaks_of_soil_is_on_soil_or_on_a_stand() {
        for e in events() {
            let speaks = [e.title, e.about].iter().any(|t| t.to_lowercase().contains("soil"));
            assert_eq!(e.place != Place::Rigid, speaks, "{}", e.name);
        }
    }
}
