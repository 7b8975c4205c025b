use crate::dynamics::Vehicle;
use crate::{M3, V3};
use vb_vehicle::VehicleModel;
use vb_vehicle::VehicleSpec;

fn m113() -> Vehicle {
    let text = include_str!("../../../../../tasks/vehicles/m113.yaml");
    let model = VehicleModel::new(VehicleSpec::parse(text, "m113.yaml").unwrap()).unwrap();
    Vehicle::new(model.spec(), model.axles(), 0.1)
}

/// With its wheels placed, and nothing acting on them.
fn placed(v: &mut Vehicle) {
    v.place_wheels(&M3::identity(), 0.0);
    for t in &mut v.tracks {
        t.lay(&M3::identity(), &v.forces);
        t.thrust.fill(0.0);
    }
}

/// Sum of the forces on all wheels and of their moments about the centre of mass.
fn total(v: &Vehicle) -> (V3, V3) {
    v.forces
        .iter()
        .fold((V3::zeros(), V3::zeros()), |(f, m), w| (f + w.force, m + w.arm.cross(&w.force) + w.moment))
}

#[test]
fn a_belts_tension_alone_neither_pushes_nor_turns_the_vehicle() {
    let mut v = m113();
    // Wheels at uneven heights, none above its neighbours' line.
    for (i, c) in v.corners.iter_mut().enumerate() {
        c.travel = if (2..12).contains(&i) { -0.01 * ((i / 2) as f64 - 3.0).abs() } else { 0.0 };
    }
    for c in &mut v.corners {
        c.load = 1e6;
    }
    placed(&mut v);
    let mut tracks = std::mem::take(&mut v.tracks);
    tracks[0].pull(&M3::identity(), &v.corners, &mut v.forces, 1e-3);
    let (force, moment) = total(&v);
    assert!(v.forces[2].force.norm() > 1e3, "it pulls at the wheels: {}", v.forces[2].force);
    assert!(force.norm() < 1e-6, "{force}");
    // In the plane of the belt; the other way the wheels bear it.
    assert!(moment.y.abs() < 1e-5, "{moment}");
}

#[test]
fn thrust_at_any_wheel_reaches_the_hull_as_if_it_acted_there() {
    for sprocket in [0, 6] {
        for wheel in 1..6 {
            let mut v = m113();
            v.corners.iter_mut().for_each(|c| c.load = 1e6);
            placed(&mut v);
            let mut tracks = std::mem::take(&mut v.tracks);
            let t = &mut tracks[0];
            t.sprocket = sprocket;
            let i = t.wheel(wheel);
            let (thrust, radius) = (8000.0, t.course.discs()[wheel].radius + 0.03);
            // Ground pushes the belt forward below the wheel.
            v.forces[i].force += V3::x() * thrust;
            v.forces[i].spin_moment = -thrust * radius;
            let contact = v.forces[i].arm - V3::z() * radius;
            t.pull(&M3::identity(), &v.corners, &mut v.forces, 1e-3);
            let (force, moment) = total(&v);
            assert!((force - V3::x() * thrust).norm() < 1e-6, "{force}");
            // The sprocket's shaft takes the torque of the thrust at its radius; the hull holds the shaft.
            let held = thrust * t.pitch_radius();
            let outer = contact.cross(&(V3::x() * thrust)).y;
            let belt = t.course.discs()[wheel].radius / radius;
            let got = moment.y - held;
            assert!(
                (got - outer).abs() < (1.0 - belt) * thrust * radius + 1.0,
                "{sprocket} {wheel}: {got} {outer}"
            );
        }
    }
}

#[test]
fn the_slack_side_is_in_front_of_a_front_sprocket_that_drives() {
    let mut v = m113();
    placed(&mut v);
    let mut tracks = std::mem::take(&mut v.tracks);
    let i = tracks[0].wheel(3);
    v.forces[i].spin_moment = -30_000.0 * 0.365;
    tracks[0].pull(&M3::identity(), &v.corners, &mut v.forces, 1e-3);
    let tensions: Vec<f64> = tracks[0].spans.iter().map(|s| s.tension).collect();
    assert!(tensions[0] < 1.0 && tensions[5] > 29_999.0, "{tensions:?}");
}

/// A string under T gives way at its middle by F L/(4 T); near its ends it is stiffer.
#[test]
fn a_span_yields_as_a_string_does_and_tightens() {
    let v = m113();
    let t = &v.tracks[0];
    let length = t.course.spans()[2].length;
    let tension = t.spans[2].tension;
    let force = t.string_force(2, 0.5, 1e-4);
    assert!((force / (4.0 * tension / length * 1e-4) - 1.0).abs() < 1e-3, "{force}");
    assert!((t.string_force(2, 0.25, 1e-4) / force - 4.0 / 3.0).abs() < 1e-3);
    // T + k 2 δ²/L at 0.1 m.
    let deep = 4.0 * (tension + 250_000.0 * 2.0 * 0.01 / length) / length * 0.1;
    assert!((t.string_force(2, 0.5, 0.1) / deep - 1.0).abs() < 1e-9);
}

/// s = q L²/(8 T).
#[test]
fn under_an_even_pressure_a_span_bends_as_a_parabola_under_its_tension() {
    let mut v = m113();
    let t = &mut v.tracks[0];
    let length = t.course.spans()[2].length;
    let q = 5_000.0;
    let mut loads = [(0.0, 0.0); 6];
    loads[2].0 = 2.0 / 3.0 * q * length;
    for _ in 0..2_000 {
        t.bend(&loads, 1e-3);
    }
    let expected = q * length * length / (8.0 * t.spans[2].tension);
    assert!((t.spans[2].sag / expected - 1.0).abs() < 1e-6, "{} {expected}", t.spans[2].sag);
    assert_eq!(t.spans[1].sag, 0.0);
}

#[test]
fn the_sprockets_turn_all_that_turns_with_the_belt() {
    let text = include_str!("../../../../../tasks/vehicles/m113.yaml");
    let spec = VehicleSpec::parse(text, "m113.yaml").unwrap();
    let load = super::sprockets(&spec).unwrap();
    assert_eq!(load.mass, spec.total_mass());
    // Sheet: sprocket 1.283, five road wheels 2.16 at 0.305 m, idler 1.12 at 0.255 m, belt 1144.27 kg, all at 0.2492 m.
    let p: f64 = 0.2492;
    let expected =
        1.283 + 1144.27 * p * p + 5.0 * 2.16 * (p / 0.305) * (p / 0.305) + 1.12 * (p / 0.255) * (p / 0.255);
    assert!((load.pairs[0].inertia - expected).abs() < 1e-6, "{}", load.pairs[0].inertia);
}
