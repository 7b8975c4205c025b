use super::{Laid, TrackStep};
use crate::V3;
use crate::dynamics::Vehicle;
use crate::dynamics::contact::Forces;
use crate::dynamics::design::{Design, sprockets};
use crate::dynamics::drive::Shafts;
use crate::dynamics::kinematics::{Kinematics, Placement};
use std::sync::Arc;
use vb_vehicle::VehicleModel;
use vb_vehicle::VehicleSpec;

fn m113() -> Vehicle {
    let text = include_str!("../../../../../../tasks/vehicles/m113.yaml");
    let model = VehicleModel::new(VehicleSpec::parse(text, "m113.yaml").unwrap()).unwrap();
    Vehicle::new(model.spec(), model.axles(), 0.1)
}

/// Its left track, with the load (N) on every wheel and nothing else acting, and the placements of all wheels.
fn with_left<T>(v: &mut Vehicle, load: f64, see: impl FnOnce(&mut TrackStep<'_>, &Kinematics<'_>) -> T) -> T {
    let design: Arc<Design> = v.design.clone();
    let mut belt = v.state.belts[0].clone();
    let kinematics = v.placed();
    let mut forces: Vec<_> = design.corners.iter().map(|c| Forces { load, ..Forces::none(c.mass) }).collect();
    let track = &design.tracks[0];
    let mut laid = Laid::new(track);
    laid.lay(track, &kinematics.turn, kinematics.placements);
    let mut step = TrackStep { track, belt: &mut belt, laid: &mut laid, forces: &mut forces };
    see(&mut step, &kinematics)
}

/// Sum of the forces on all wheels and of their moments about the centre of mass.
fn total(forces: &[Forces], placements: &[Placement]) -> (V3, V3) {
    forces.iter().zip(placements).fold((V3::zeros(), V3::zeros()), |(f, m), (w, p)| {
        (f + w.force, m + p.arm.cross(&w.force) + w.moment)
    })
}

#[test]
fn a_belts_tension_alone_neither_pushes_nor_turns_the_vehicle() {
    let mut v = m113();
    // Wheels at uneven heights, none above its neighbours' line.
    for (i, w) in v.state.wheels.iter_mut().enumerate() {
        w.travel = if (2..12).contains(&i) { -0.01 * ((i / 2) as f64 - 3.0).abs() } else { 0.0 };
    }
    with_left(&mut v, 1e6, |t, kinematics| {
        t.pull(&kinematics.turn, 1e-3);
        let (force, moment) = total(t.forces, kinematics.placements);
        assert!(t.forces[2].force.norm() > 1e3, "it pulls at the wheels: {}", t.forces[2].force);
        assert!(force.norm() < 1e-6, "{force}");
        // In the plane of the belt; the other way the wheels bear it.
        assert!(moment.y.abs() < 1e-5, "{moment}");
    });
}

#[test]
fn thrust_at_any_wheel_reaches_the_hull_as_if_it_acted_there() {
    for sprocket in [0, 6] {
        for wheel in 1..6 {
            let mut v = m113();
            Arc::make_mut(&mut v.design).tracks[0].sprocket = sprocket;
            with_left(&mut v, 1e6, |t, kinematics| {
                let i = t.track.wheel(wheel);
                let (thrust, radius) = (8000.0, t.laid.course.discs()[wheel].radius + 0.03);
                // Ground pushes the belt forward below the wheel.
                t.forces[i].force += V3::x() * thrust;
                t.forces[i].spin_moment = -thrust * radius;
                let contact = kinematics.placements[i].arm - V3::z() * radius;
                t.pull(&kinematics.turn, 1e-3);
                let (force, moment) = total(t.forces, kinematics.placements);
                assert!((force - V3::x() * thrust).norm() < 1e-6, "{force}");
                // The sprocket's shaft takes the torque of the thrust at its radius; the hull holds the shaft.
                let held = thrust * t.track.pitch_radius();
                let outer = contact.cross(&(V3::x() * thrust)).y;
                let belt = t.laid.course.discs()[wheel].radius / radius;
                let got = moment.y - held;
                assert!(
                    (got - outer).abs() < (1.0 - belt) * thrust * radius + 1.0,
                    "{sprocket} {wheel}: {got} {outer}"
                );
            });
        }
    }
}

#[test]
fn the_slack_side_is_in_front_of_a_front_sprocket_that_drives() {
    with_left(&mut m113(), 0.0, |t, kinematics| {
        let i = t.track.wheel(3);
        t.forces[i].spin_moment = -30_000.0 * 0.365;
        t.pull(&kinematics.turn, 1e-3);
        let tensions: Vec<f64> = t.belt.spans.iter().map(|s| s.tension).collect();
        assert!(tensions[0] < 1.0 && tensions[5] > 29_999.0, "{tensions:?}");
    });
}

/// A string under T gives way at its middle by F L/(4 T); near its ends it is stiffer.
#[test]
fn a_span_yields_as_a_string_does_and_tightens() {
    with_left(&mut m113(), 0.0, |t, _| {
        let length = t.laid.course.spans()[2].length;
        let tension = t.belt.spans[2].tension;
        let force = t.string_force(2, 0.5, 1e-4);
        assert!((force / (4.0 * tension / length * 1e-4) - 1.0).abs() < 1e-3, "{force}");
        assert!((t.string_force(2, 0.25, 1e-4) / force - 4.0 / 3.0).abs() < 1e-3);
        // T + k 2 δ²/L at 0.1 m.
        let deep = 4.0 * (tension + 250_000.0 * 2.0 * 0.01 / length) / length * 0.1;
        assert!((t.string_force(2, 0.5, 0.1) / deep - 1.0).abs() < 1e-9);
    });
}

/// s = q L²/(8 T).
#[test]
fn under_an_even_pressure_a_span_bends_as_a_parabola_under_its_tension() {
    with_left(&mut m113(), 0.0, |t, _| {
        let length = t.laid.course.spans()[2].length;
        let q = 5_000.0;
        let mut loads = [(0.0, 0.0); 6];
        loads[2].0 = 2.0 / 3.0 * q * length;
        for _ in 0..2_000 {
            t.bend(&loads, 1e-3);
        }
        let expected = q * length * length / (8.0 * t.belt.spans[2].tension);
        assert!((t.belt.spans[2].sag / expected - 1.0).abs() < 1e-6, "{} {expected}", t.belt.spans[2].sag);
        assert_eq!(t.belt.spans[1].sag, 0.0);
    });
}

#[test]
fn the_sprockets_turn_all_that_turns_with_the_belt() {
    let text = include_str!("../../../../../../tasks/vehicles/m113.yaml");
    let spec = VehicleSpec::parse(text, "m113.yaml").unwrap();
    let load = sprockets(&spec).unwrap();
    assert_eq!(load.mass, spec.total_mass());
    // Sheet: sprocket 1.283, five road wheels 2.16 at 0.305 m, idler 1.12 at 0.255 m, belt 1144.27 kg, all at 0.2492 m.
    let p: f64 = 0.2492;
    let expected =
        1.283 + 1144.27 * p * p + 5.0 * 2.16 * (p / 0.305) * (p / 0.305) + 1.12 * (p / 0.255) * (p / 0.255);
    assert!((load.pairs[0].inertia - expected).abs() < 1e-6, "{}", load.pairs[0].inertia);
}

#[test]
fn a_track_whose_load_is_negative_has_no_friction() {
    // The drive of the M113 over w090 of vb-100 that ended in a panic: a clamp with a negative bound.
    let v = m113();
    let loaded = |load| {
        let forces: Vec<_> =
            v.design.corners.iter().map(|c| Forces { load, ..Forces::none(c.mass) }).collect();
        Shafts::of_sprockets(&v.design, &v.state.belts, [0.0; 2], &forces, 0.0, 0.0).brakes()
    };
    assert!(loaded(1000.0).iter().all(|b| *b > 0.0));
    assert_eq!(loaded(-1000.0), [0.0; 2]);
}
