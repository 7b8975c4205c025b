//! What the file says of the vehicle, as a data sheet has it.

use crate::bench::Bench;
use crate::event::{Event, Outcome, Place, Vehicles};
use vb_sim::SimError;

pub(super) const DATA_SHEET: Event = Event {
    name: "data-sheet",
    title: "Data sheet",
    about: "Computed from the vehicle file at rest on level ground: clearance and angles of the hull, turning radius without \
            slip, ratios of the driveline, ride frequency, damping ratio, roll gradient and articulation.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: data_sheet,
};

fn data_sheet(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let c = bench.characteristics();
    let mut known = |name: &str, value: Option<f64>, unit: &'static str| {
        if let Some(value) = value {
            o.figure(name, value, unit);
        }
    };
    known("ground clearance", c.ground_clearance_m, "m");
    known("approach angle", Some(c.approach_angle_deg), "°");
    known("departure angle", Some(c.departure_angle_deg), "°");
    known("break-over angle", c.break_over_angle_deg, "°");
    known("radius of the outer front wheel without slip", c.outer_front_wheel_radius_m, "m");
    let p = &bench.spec.powertrain;
    let driven = bench.spec.axles.iter().filter(|a| a.driven).zip(&p.driveline.axles);
    for (axle, drive) in driven.clone() {
        known(&format!("{}: final drive ratio", axle.name), Some(1.0 / drive.final_drive), "");
    }
    if let (Some(first), Some((_, drive))) = (p.gearbox.ratios.first(), driven.clone().next()) {
        known("first gear: overall ratio", Some(1.0 / (first * drive.final_drive)), "");
    }
    for a in &c.axles {
        let Some(ride) = a.ride else { continue };
        let name = &a.name;
        known(&format!("{name}: sprung mass on a wheel"), Some(ride.sprung_mass_kg), "kg");
        known(&format!("{name}: motion ratio"), ride.motion_ratio, "");
        known(&format!("{name}: wheel rate"), Some(1e-3 * ride.wheel_rate_n_per_m), "kN/m");
        known(&format!("{name}: ride frequency"), Some(ride.ride_frequency_hz), "Hz");
        known(&format!("{name}: ride frequency, tyres in series"), Some(ride.frequency_with_tyre_hz), "Hz");
        known(&format!("{name}: damping ratio in jounce"), Some(ride.damping_ratio[0]), "");
        known(&format!("{name}: damping ratio in rebound"), Some(ride.damping_ratio[1]), "");
        known(&format!("{name}: height of the roll centre"), Some(a.roll_centre_height_m), "m");
    }
    known("roll gradient", c.roll_gradient_deg_per_g, "°/g");
    known("articulation", c.articulation_m, "m");
    known("articulation over the wheelbase", c.articulation_over_wheelbase(), "");
    known("diagonal articulation", c.diagonal_articulation_m, "m");
    for warning in c.warnings() {
        o.note(warning);
    }
    Ok(o)
}
