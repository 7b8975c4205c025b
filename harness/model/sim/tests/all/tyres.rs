//! The tyre models against their closed forms and sheets, and the whole vehicle on each of them.

use crate::common::{controls, flat, grade, hmmwv, hold_speed, world};
use std::sync::Arc;
use vb_math::{atan, hypot, tan};
use vb_sim::{SimOptions, Simulation, SoilSet, tyre::Tyre};
use vb_vehicle::{TyreSpec, VehicleSpec};
use vb_world::{Heightfield, Pose2, World};

const NAMES: [&str; 4] = ["brush", "fiala", "rigid", "tmeasy"];

fn on(name: &str) -> VehicleSpec {
    hmmwv().with_tyre(name).expect("the HMMWV has it")
}

fn tyre(name: &str) -> Tyre {
    Tyre::new(&on(name).tyre)
}

fn start(name: &str, world: &Arc<World>, x: f64, yaw: f64, step: f64) -> Simulation {
    let options = SimOptions { step, ..SimOptions::default() };
    Simulation::new(
        world.clone(),
        &crate::common::model(on(name)),
        &SoilSet::default(),
        Pose2 { x, y: 0.0, yaw },
        options,
    )
    .expect("it settles")
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-9)
}

#[test]
fn fiala_gives_the_closed_form_in_slip_and_in_slip_angle() {
    // Adams/Tire's Fiala (as in Chrono's ChFialaTire.cpp) with the sheet's c_slip, c_alpha, mu_min, mu_max; ground
    // friction 0.8 = mu_0.
    let (cs, ca, least, most) = (193_929.0, 50_000.0, 0.5568, 0.9835);
    let (t, width) = (tyre("fiala"), on("fiala").tyre.width());
    for load in [3000.0, 6000.0, 15_000.0] {
        let u = |s: f64| most - (most - least) * f64::min(s, 1.0);
        for slip in [-1.0, -0.3, -0.05, -0.004, 0.002, 0.01, 0.02, 0.1, 0.5, 1.5] {
            let limit = u(f64::abs(slip)) * load;
            let critical = limit / (2.0 * cs);
            let expected = if f64::abs(slip) < critical {
                cs * slip
            } else {
                slip.signum() * (limit - limit * limit / (4.0 * slip.abs() * cs))
            };
            let f = t.steady_force(load, slip, 0.0, 0.8);
            assert!(close(f.longitudinal, expected, 1e-6), "{slip}: {} {expected}", f.longitudinal);
            assert!(f.lateral.abs() < 1e-9 && f.aligning.abs() < 1e-9);
        }
        for degrees in [-30.0, -8.0, -1.0, 0.5, 3.0, 6.0, 12.0, 20.0, 45.0_f64] {
            let a = degrees.to_radians();
            let limit = u(tan(a).abs()) * load;
            // Sliding from the critical slip angle on, atan(3 U F_z/C_α).
            let h =
                if a.abs() < atan(3.0 * limit / ca) { 1.0 - ca * tan(a).abs() / (3.0 * limit) } else { 0.0 };
            let lateral = -limit * (1.0 - h * h * h) * a.signum();
            let aligning = limit * width * (1.0 - h) * h * h * h * a.signum();
            let f = t.steady_force(load, 0.0, a, 0.8);
            assert!(close(f.lateral, lateral, 1e-6), "{degrees}: {} {lateral}", f.lateral);
            assert!((f.aligning - aligning).abs() < 1e-6 * limit, "{degrees}: {} {aligning}", f.aligning);
        }
        // Both at once: each its own curve, with the friction that their common slip leaves.
        let (slip, a) = (0.01, 2.0_f64.to_radians());
        let limit = u(hypot(slip, tan(a))) * load;
        let x = if slip < limit / (2.0 * cs) { cs * slip } else { limit - limit * limit / (4.0 * slip * cs) };
        let h = 1.0 - ca * tan(a) / (3.0 * limit);
        let y = -limit * (1.0 - h * h * h);
        let f = t.steady_force(load, slip, a, 0.8);
        assert!(hypot(x, y) < limit, "the case lies within the circle");
        assert!(close(f.longitudinal, x, 1e-6) && close(f.lateral, y, 1e-6), "{f:?} {x} {y}");
        // Where the two curves leave the circle, it holds them.
        let f = t.steady_force(load, -0.9, 0.7, 0.8);
        assert!(hypot(f.longitudinal, f.lateral) < least * load * (1.0 + 1e-9));
    }
}

#[test]
fn fiala_scales_with_the_ground_without_a_step_at_the_critical_slip() {
    let t = tyre("fiala");
    for friction in [0.3, 0.5, 1.0] {
        let curve: Vec<f64> =
            (1..3000).map(|k| t.steady_force(6000.0, 0.0, 1e-4 * f64::from(k), friction).lateral).collect();
        let step = curve.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(step < 1.05 * 50_000.0 * 1e-4, "{friction}: {step} N in 0.1 mrad");
    }
}

#[test]
fn tmeasy_has_the_slopes_peaks_and_sliding_forces_of_its_sheet() {
    // HMMWV_TMeasyTire, expanded: (load, [dF_0, F_M, s_M, F_S, s_S] longitudinal, lateral) at pn and 2 pn; ground
    // friction 0.8 = mu_0.
    let t = tyre("tmeasy");
    let pn = 8562.82661;
    let sheet = [
        (
            pn,
            [152216.231, 7703.54696, 0.10811, 3954.57021, 0.66667],
            [63376.0486, 6497.13032, 0.33167, 5846.3555, 1.0296],
        ),
        (
            2.0 * pn,
            [248837.454, 13315.3666, 0.12389, 7252.54288, 0.66667],
            [117319.287, 12438.0194, 0.33216, 11186.3054, 1.0296],
        ),
    ];
    // TMeasy's slips are over the rolling speed ω R_e = (1 + κ) v_x: braking with κ, s = −κ/(1 + κ).
    let braked = |load: f64, s: f64, mu: f64| t.steady_force(load, -s / (1.0 + s), 0.0, mu).longitudinal;
    let cornered = |load: f64, s: f64, mu: f64| t.steady_force(load, 0.0, atan(s), mu).lateral;
    for (load, x, y) in sheet {
        for (f, [slope, peak, s_peak, slide, s_slide]) in
            [(&braked as &dyn Fn(f64, f64, f64) -> f64, x), (&cornered, y)]
        {
            assert!(close(-f(load, 1e-6, 0.8) / 1e-6, slope, 1e-3), "{}", f(load, 1e-6, 0.8));
            assert!(close(-f(load, s_peak, 0.8), peak, 1e-6), "{} {peak}", f(load, s_peak, 0.8));
            for s in [0.97 * s_peak, 1.03 * s_peak] {
                assert!(-f(load, s, 0.8) < peak && -f(load, s, 0.8) > 0.99 * peak, "a maximum at {s}");
            }
            assert!(close(-f(load, s_slide, 0.8), slide, 1e-6) && close(-f(load, 3.0, 0.8), slide, 1e-6));
            // Half the friction: the same slope, half the forces at half the slips.
            assert!(close(-f(load, 1e-6, 0.4) / 1e-6, slope, 1e-3));
            assert!(close(-f(load, 0.5 * s_peak, 0.4), 0.5 * peak, 1e-6));
        }
    }
}

#[test]
fn tmeasy_in_combined_slip_stays_within_its_combined_peak() {
    let t = tyre("tmeasy");
    // At pn: hypot(F_xM cos φ, F_yM sin φ) for a force in direction φ.
    let (fx, fy) = (7703.54696, 6497.13032);
    for i in 0..40 {
        for k in 0..40 {
            let f = t.steady_force(8562.82661, -0.9 + 0.08 * f64::from(i), -1.2 + 0.06 * f64::from(k), 0.8);
            let size = hypot(f.longitudinal, f.lateral);
            if size > 0.0 {
                let bound = hypot(fx * f.longitudinal / size, fy * f.lateral / size);
                assert!(size < bound * (1.0 + 1e-9), "{f:?} {bound}");
            }
        }
    }
    // A locked wheel slides against its velocity: F_xS and F_yS in that direction, of which little is lateral.
    let angle = 0.1_f64;
    let f = t.steady_force(8562.82661, -1.0, angle, 0.8);
    let (sin, cos) = vb_math::sin_cos(angle);
    let sliding = hypot(3954.57021 * cos, 5846.3555 * sin);
    assert!(close(f.longitudinal, -sliding * cos, 1e-6) && close(f.lateral, -sliding * sin, 1e-6), "{f:?}");
}

#[test]
fn tmeasy_aligns_with_the_trail_of_its_sheet_which_vanishes_in_sliding() {
    let t = tyre("tmeasy");
    // At pn and a small slip angle: nL0 · 2 √(R_0 d) with nL0 = 0.178 and d = pn/C_z.
    let load: f64 = 8562.82661;
    let length = 2.0 * (0.4699 * load / 411120.924).sqrt();
    let f = t.steady_force(load, 0.0, 1e-5, 0.8);
    assert!(close(-f.aligning / f.lateral, 0.178 * length, 1e-3), "{f:?}");
    // Against the slip angle: it turns the wheel back (ISO: M_z > 0 for v_y > 0).
    assert!(f.aligning > 0.0);
    // Beyond sq0 = 0.36484 the trail is negative, beyond sqe = 1.0296 there is none.
    assert!(t.steady_force(load, 0.0, atan(0.6), 0.8).aligning < 0.0);
    assert!(t.steady_force(load, 0.0, atan(1.1), 0.8).aligning.abs() < 1e-9);
}

#[test]
fn the_hard_tyre_reaches_the_friction_circle_at_small_slip_and_never_leaves_it() {
    let t = tyre("rigid");
    let load = 6115.0;
    for (slip, angle) in
        [(-0.02, 0.0), (0.03, 0.0), (-1.0, 0.0), (0.0, 0.02), (0.0, 1.0), (-0.02, -0.02), (2.0, 0.3)]
    {
        let f = t.steady_force(load, slip, angle, 0.6);
        let size = hypot(f.longitudinal, f.lateral);
        assert!(close(size, 0.6 * load, 1e-9), "{slip} {angle}: {size}");
        // Against the sliding velocity.
        assert!((f.longitudinal * tan(angle) - f.lateral * -slip).abs() < 1e-6 * size);
    }
    // Its own friction, 0.9, where the ground has more.
    assert!(close(t.steady_force(load, -1.0, 0.0, 1.2).longitudinal, -0.9 * load, 1e-9));
    // Millimetres of penetration at the static load.
    assert!(t.deflection(load) < 0.003);
}

#[test]
fn at_any_load_a_tyre_is_stiff_and_its_forces_are_sane() {
    for name in NAMES {
        let t = tyre(name);
        let radius = on(name).tyre.radius();
        let forces: Vec<f64> = (0..=200).map(|k| t.vertical_force(radius * f64::from(k) / 200.0)).collect();
        assert!(forces.windows(2).all(|w| w[1] > w[0]), "{name}: the radial force grows with deflection");
        let mut before = [0.0; 2];
        for k in 1..400 {
            let load = 250.0 * f64::from(k);
            let f = t.steady_force(load, -0.05, 0.0, 0.8).longitudinal;
            let g = t.steady_force(load, 0.0, 0.05, 0.8).lateral;
            assert!(f < 0.0 && g < 0.0 && f >= -load && g >= -load, "{name} at {load} N: {f} {g}");
            // More load, more force, until it grows no further.
            assert!(
                f <= before[0] + 1e-6 * load && g <= before[1] + 1e-6 * load,
                "{name} at {load} N: {f} {g}"
            );
            before = [f, g];
        }
    }
    // TMeasy's rim: from R_0 − R_rim − 0.01 m on, five times the stiffness more.
    let t = tyre("tmeasy");
    let slope = (t.vertical_force(0.3) - t.vertical_force(0.29)) / 0.01;
    assert!(close(slope, 6.0 * 411120.924, 1e-6), "{slope}");
}

/// The numbers of a flow sequence or a scalar that stands after `key:` below the line `section:` of a sheet.
fn sheet_numbers(sheet: &str, section: &str, key: &str) -> Vec<f64> {
    let from = sheet.find(&format!("\n  {section}:\n")).expect("the sheet has the section");
    let line =
        sheet[from..].lines().find_map(|l| l.strip_prefix(&format!("    {key}: "))).expect("it has the key");
    line.split(['[', ']', ',']).filter_map(|n| n.trim().parse().ok()).collect()
}

#[test]
fn the_shipped_tyres_are_those_of_the_reference_sheet() {
    let Some(path) = vb_testing::shared("reference/vehicles/hmmwv.yaml") else { return };
    let sheet = std::fs::read_to_string(path).unwrap();
    let TyreSpec::Tmeasy(t) = on("tmeasy").tyre else { panic!("tmeasy") };
    for (key, ours) in [
        ("unloaded_radius", &[t.radius][..]),
        ("width", &[t.width]),
        ("rim_radius", &[t.rim_radius]),
        ("rolling_resistance", &[t.rolling_resistance]),
        ("mu_0", &[t.mu_0]),
        ("pn", &[t.pn]),
        ("pn_max", &[t.pn_max]),
        ("vertical_stiffness", &[t.vertical_stiffness]),
        ("vertical_damping", &[t.vertical_damping]),
        ("dfx0", &t.dfx0),
        ("fxm", &t.fxm),
        ("fxs", &t.fxs),
        ("dfy0", &t.dfy0),
        ("fym", &t.fym),
        ("fys", &t.fys),
        ("sxm", &t.sxm),
        ("sxs", &t.sxs),
        ("sym", &t.sym),
        ("sys", &t.sys),
        ("nL0", &t.nl0),
        ("sq0", &t.sq0),
        ("sqe", &t.sqe),
    ] {
        assert_eq!(sheet_numbers(&sheet, "tmeasy", key), ours, "tmeasy.{key}");
    }
    let TyreSpec::Fiala(t) = on("fiala").tyre else { panic!("fiala") };
    for (key, ours) in [
        ("unloaded_radius", t.radius),
        ("width", t.width),
        ("rolling_resistance", t.rolling_resistance),
        ("c_slip", t.c_slip),
        ("c_alpha", t.c_alpha),
        ("mu_min", t.mu_min),
        ("mu_max", t.mu_max),
        ("vertical_damping", t.vertical_damping),
    ] {
        assert_eq!(sheet_numbers(&sheet, "fiala", key), [ours], "fiala.{key}");
    }
    assert_eq!(sheet_numbers(&sheet, "fiala", "vertical_map"), t.vertical_map.concat());
    let TyreSpec::Rigid(t) = on("rigid").tyre else { panic!("rigid") };
    assert_eq!(sheet_numbers(&sheet, "rigid", "radius"), [t.radius]);
    assert_eq!(sheet_numbers(&sheet, "rigid", "width"), [t.width]);
}

#[test]
fn an_unknown_tyre_is_refused_with_the_names_that_there_are() {
    let e = hmmwv().with_tyre("slick").unwrap_err().to_string();
    assert_eq!(e, "hmmwv: tyres: \"slick\" is not among them; choose one of brush, fiala, rigid, tmeasy");
}

#[test]
fn on_every_tyre_it_rests_on_its_springs_and_does_not_creep_on_a_slope() {
    for name in NAMES {
        for (slope, yaw) in [(15.0, 0.0), (12.0, std::f64::consts::FRAC_PI_2)] {
            let mut sim = start(name, &grade(slope, 0.6), 20.0, yaw, 1e-3);
            sim.advance(controls(0.0, 0.0, 1.0), 3000).unwrap();
            let a = sim.state().position;
            sim.advance(controls(0.0, 0.0, 1.0), 60_000).unwrap();
            let moved = (sim.state().position - a).norm();
            assert!(moved < 1e-3, "{name}, {slope} deg: {moved} m in 60 s");
        }
    }
}

#[test]
fn on_every_tyre_the_edges_of_facets_are_felt_without_a_jump_of_force() {
    // A wavy road of 1 m facets, ±3 % of slope, at 2 m/s: 2 mm a step. A wheel's load may rise and fall but, with 6 kN
    // on a footprint of at least 9 cm, never by more than a tenth in a millisecond.
    let (rows, cols) = (31, 101);
    let heights = (0..rows * cols).map(|i| if (i % cols) % 2 == 0 { 0.015 } else { -0.015 }).collect();
    let w = world(Heightfield::new(rows, cols, 1.0, heights), 0.8, vec![]);
    for name in NAMES {
        let mut sim = start(name, &w, -40.0, 0.0, 1e-3);
        let mut loads: Vec<f64> = Vec::new();
        let (mut jump, mut low, mut high): (f64, f64, f64) = (0.0, f64::INFINITY, 0.0);
        for _ in 0..20_000 {
            let c = hold_speed(&sim, 2.0, 0.0);
            sim.advance(c, 1).unwrap();
            let now: Vec<f64> = sim.state().wheels.iter().map(|w| w.load).collect();
            for (a, b) in now.iter().zip(&loads) {
                jump = jump.max((a - b).abs());
            }
            low = low.min(now[0]);
            high = high.max(now[0]);
            loads = now;
        }
        assert!(sim.state().position.x > -10.0, "{name}: it drives");
        assert!(high - low > 500.0, "{name}: it feels the facets");
        assert!(jump < 620.0, "{name}: {jump} N in a millisecond");
    }
}

/// 10 m/s, then half brake and half lock together, on friction 0.7: where and how fast after two seconds.
fn braked_in_a_turn(name: &str, step: f64) -> (f64, f64, f64) {
    let mut sim = start(name, &flat(0.7), -60.0, 0.0, step);
    let per = (1e-3 / step).round() as u64;
    while sim.state().velocity_body.x < 10.0 {
        let c = hold_speed(&sim, 10.5, 0.0);
        sim.advance(c, per).expect("finite");
    }
    let from = sim.state().position;
    sim.advance(controls(0.4, 0.0, 0.3), 1200 * per).expect("finite");
    let s = sim.state();
    ((s.position - from).norm(), s.roll_pitch_yaw().2, s.velocity_body.norm())
}

#[test]
fn on_every_tyre_braking_in_a_turn_has_converged_at_a_millisecond() {
    for name in NAMES {
        let a = braked_in_a_turn(name, 1e-3);
        let b = braked_in_a_turn(name, 0.5e-3);
        assert!(close(a.0, b.0, 0.02), "{name}: way {} {}", a.0, b.0);
        assert!(close(a.1, b.1, 0.02), "{name}: yaw {} {}", a.1, b.1);
        assert!((a.2 - b.2).abs() < 0.02 * 10.0, "{name}: speed {} {}", a.2, b.2);
    }
}
