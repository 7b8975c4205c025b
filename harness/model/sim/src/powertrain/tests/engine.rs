//! Engines, converter and gearbox.

use super::*;

#[test]
fn a_closed_throttle_never_drives_and_its_drag_holds_at_rest() {
    // The source's own curve, 2.2 N m of drag at rest, which in the source drives the vehicle backwards
    // (chrono/README.md, gotcha 1).
    let mut v = hmmwv();
    v.powertrain.engine = Engine::Map {
        full_throttle: vec![[0.0, 400.0]],
        closed_throttle: vec![[-10.472, 0.0], [83.776, -20.0]],
        inertia: 0.0,
    };
    let mut b = Bench::new(&v, 0.0);
    b.step(0.0, DT);
    assert!(b.spins.iter().all(|w| *w == 0.0), "{:?}", b.spins);
    // 2.22 N m / 0.1708 / 0.2 = 65 N m at the wheels hold 60 and yield to 70.
    for (moment, holds) in [(15.0, true), (17.5, false)] {
        let mut b = Bench::new(&v, 0.0);
        b.moments.fill(moment);
        (0..100).for_each(|_| b.step(0.0, DT));
        assert_eq!(b.spins[0].abs() < 1e-9, holds, "{moment} N m: {:?}", b.spins);
    }
    for spin in [5.0, -5.0] {
        let mut b = Bench::new(&v, spin);
        b.step(0.0, DT);
        assert!(b.drive.state().shaft_torque * spin < 0.0);
    }
}

#[test]
fn the_gearbox_shifts_up_above_and_down_below_its_bands() {
    let v = hmmwv();
    let g = &v.powertrain.gearbox.ratios;
    let mut b = Bench::new(&v, 0.0);
    b.hold(1.0, 240.0 * g[0] * 0.2, DT);
    assert_eq!(b.drive.shifter.gear, 1);
    b.hold(1.0, 240.0 * g[0] * 0.2, DT);
    assert_eq!(b.drive.shifter.gear, 1, "147 rad/s in second lies within its band");
    b.hold(0.0, 100.0 * g[1] * 0.2, DT);
    assert_eq!(b.drive.shifter.gear, 0);
}

#[test]
fn a_shift_interrupts_the_torque_for_its_time_and_waits_for_its_latency() {
    let mut v = hmmwv();
    v.powertrain.gearbox.shift_time = 0.2;
    v.powertrain.gearbox.latency = 1.0;
    let mut b = Bench::new(&v, 0.0);
    // 300 rad/s in first: two gears too low.
    let spin = 300.0 * 0.2791 * 0.2;
    let (mut without, mut second) = (0.0, 0.0);
    for k in 0..3000 {
        b.hold(0.5, spin, DT);
        let s = b.drive.state();
        without += if k > 0 && s.shaft_torque == 0.0 { DT } else { 0.0 };
        second += if b.drive.shifter.gear == 1 { DT } else { 0.0 };
    }
    assert_eq!(b.drive.shifter.gear, 2);
    assert!((without - 0.4).abs() < 0.005 && (second - 1.0).abs() < 0.005, "{without} {second}");
}

#[test]
fn a_gearbox_whose_bands_overlap_does_not_hunt() {
    // FED-Alpha (vehicles/feda.yaml): 233 rad/s in first are 116.5 in second, below that gear's 125.7 to shift down.
    let mut v = hmmwv();
    v.powertrain.gearbox.ratios = vec![0.0935828877, 0.187165775];
    v.powertrain.gearbox.shift_down = vec![125.663706; 2];
    v.powertrain.gearbox.shift_up = vec![233.001455; 2];
    let mut b = Bench::new(&v, 0.0);
    let mut shifts = 0;
    for k in 0..2000 {
        let gear = b.drive.shifter.gear;
        b.hold(0.5, (233.0 + vb_math::sin(0.1 * f64::from(k))) * 0.0935828877 * 0.2, DT);
        shifts += usize::from(gear != b.drive.shifter.gear);
    }
    assert_eq!(shifts, 1);
}

/// Shifts in 60 s at full throttle against a constant moment a wheel, from 4.5 rad/s on, with a vehicle's inertia.
fn shifts_against(load: f64, load_sensing: bool) -> usize {
    let mut v = hmmwv();
    v.powertrain.gearbox.load_sensing = load_sensing;
    for a in &mut v.axles {
        // A quarter of the vehicle on the wheel's radius.
        a.spin_inertia += 0.25 * 2493.56 * 0.467 * 0.467;
    }
    let mut b = Bench::new(&v, 4.5);
    let (mut shifts, mut gear) = (0, 0);
    for k in 0..60_000 {
        b.moments.fill(-load);
        b.step(1.0, DT);
        // The first ten seconds are for getting there.
        shifts += usize::from(k > 10_000 && gear != b.drive.shifter.gear);
        gear = b.drive.shifter.gear;
    }
    assert!(b.spins[0] > 4.5, "it drives on: {:?}", b.spins);
    shifts
}

#[test]
fn a_load_sensing_gearbox_does_not_hunt_on_a_constant_load() {
    // 5500 N m a wheel is 4400 N m at the output shaft: second gear gives 1300/0.2791 = 4660 at best and 3318 at the
    // speed of its shift down, first gear 5060 where it shifts up.
    for load in [5500.0, 5900.0] {
        assert_eq!(shifts_against(load, true), 0, "{load} N m");
    }
    assert!(shifts_against(5900.0, false) > 10, "the load is one at which the bands alone hunt");
}

#[test]
fn an_electric_vehicle_tops_out_at_the_no_load_speed() {
    // ARTcar: 503.702 rad/s · 1/3 · 0.5 (vehicles/artcar.yaml).
    let mut v = hmmwv();
    v.powertrain.engine = Engine::Electric {
        torque: vec![[0.0, 1600.0], [503.702, 0.0]],
        regeneration: 0.0,
        friction: 0.0,
        voltage: Vec::new(),
        inertia: 0.0,
    };
    v.powertrain.gearbox.ratios = vec![1.0 / 3.0];
    v.powertrain.gearbox.shift_down = vec![-1.0];
    v.powertrain.gearbox.shift_up = vec![1e4];
    for a in &mut v.powertrain.driveline.axles {
        a.final_drive = 0.5;
    }
    let mut b = Bench::new(&v, 0.0);
    for _ in 0..20_000 {
        b.step(1.0, DT);
    }
    assert!((b.spins[0] - 503.702 / 6.0).abs() < 1e-3, "{:?}", b.spins);
}

#[test]
fn a_stalled_converter_gives_its_torque_ratio_at_the_stall_speed() {
    // At rest T_engine(ω) = (ω/15)² and the turbine gives twice that (table: R(0) = 2).
    let v = dynamometer();
    let mut b = Bench::new(&v, 0.0);
    for _ in 0..20_000 {
        b.hold(1.0, 0.0, DT);
    }
    let s = b.drive.state();
    let impeller = (s.engine_speed / 15.0) * (s.engine_speed / 15.0);
    assert!((s.engine_torque - impeller).abs() < 1e-6 * impeller, "{s:?} {impeller}");
    assert!((s.shaft_torque * 0.1708 - 2.0 * impeller).abs() < 1e-5 * impeller, "{s:?}");
    // At 261.8 rad/s the impeller takes 304.6 N m, less than the engine's 478, which fall by 962 in 20.944 rad/s:
    // 478 − 45.93 (ω − 261.8) = ω²/225 gives 265.4 rad/s.
    assert!((s.engine_speed - 265.4).abs() < 0.1, "{s:?}");
}

#[test]
fn a_converter_in_steady_drive_balances_at_its_speed_ratio() {
    // Turbine held at 150 rad/s, half throttle: the engine finds the speed at which its torque is (ω/K(r))².
    let v = dynamometer();
    let mut b = Bench::new(&v, 0.0);
    for _ in 0..20_000 {
        b.hold(0.5, 150.0 * 0.1708 * 0.2, DT);
    }
    let s = b.drive.state();
    let r = 150.0 / s.engine_speed;
    let k = vb_vehicle::table::interpolate(&converter().capacity, r).0;
    let impeller = (s.engine_speed / k) * (s.engine_speed / k);
    assert!(r > 0.5 && r < 0.98, "{r}");
    assert!((s.engine_torque - impeller).abs() < 1e-6 * impeller, "{s:?} {impeller}");
    let ratio = vb_vehicle::table::interpolate(&converter().torque_ratio, r).0;
    assert!((s.shaft_torque * 0.1708 - ratio * impeller).abs() < 1e-5 * impeller);
}

#[test]
fn an_overrun_converter_brakes_and_loses_energy() {
    let v = dynamometer();
    let mut b = Bench::new(&v, 0.0);
    for _ in 0..20_000 {
        b.hold(0.0, 200.0 * 0.1708 * 0.2, DT);
    }
    let s = b.drive.state();
    assert!(s.engine_speed < 200.0 && s.engine_speed > 100.0, "{s:?}");
    // The engine's drag, and no more, comes through in steady state.
    assert!(s.engine_torque < 0.0 && (s.shaft_torque * 0.1708 - s.engine_torque).abs() < 1e-3, "{s:?}");
}

#[test]
fn an_engine_behind_a_converter_idles_and_creeps() {
    let v = dynamometer();
    let mut b = Bench::new(&v, 0.0);
    for _ in 0..5000 {
        b.hold(0.0, 0.0, DT);
    }
    let s = b.drive.state();
    // The governor's band is a tenth of the idle speed.
    assert!(s.engine_speed > 72.0 && s.engine_speed < 80.0, "{s:?}");
    assert!(s.shaft_torque > 0.0, "it creeps");
}

#[test]
fn steps_from_a_quarter_to_four_milliseconds_give_the_same_start_with_a_converter() {
    let run = |dt: f64| {
        let mut v = with_converter();
        for a in &mut v.axles {
            a.spin_inertia += 0.25 * 2493.56 * 0.467 * 0.467;
        }
        let mut b = Bench::new(&v, 0.0);
        b.moments.fill(-100.0);
        for _ in 0..(3.0 / dt).round() as usize {
            b.step(0.6, dt);
        }
        (b.spins[0], b.drive.state().engine_speed)
    };
    let (spin, engine) = run(0.25e-3);
    assert!(spin > 10.0, "{spin}");
    for dt in [0.5e-3, 1e-3, 2e-3, 4e-3] {
        let (s, e) = run(dt);
        assert!(
            (s / spin - 1.0).abs() < 5e-3 && (e / engine - 1.0).abs() < 5e-3,
            "{dt}: {s} {spin} {e} {engine}"
        );
    }
}

#[test]
fn a_lock_up_clutch_turns_engine_and_gearbox_together_until_it_is_released() {
    let mut v = dynamometer();
    v.powertrain.converter.as_mut().unwrap().lock_up =
        Some(LockUp { speed_ratio: 0.85, release_speed: 120.0, torque: 1500.0 });
    for dt in [0.25e-3, 4e-3] {
        let mut b = Bench::new(&v, 0.0);
        for k in 0..4000 {
            let turbine = if k < 3000 { 200.0 } else { 110.0 };
            b.hold(0.3, turbine * 0.1708 * 0.2, dt);
            let s = b.drive.state();
            match k {
                // It transmits all of the engine's torque within half a radian per second of slip.
                2999 => {
                    assert!((s.engine_speed - 200.0).abs() < 0.5, "{s:?}");
                    assert!(
                        (s.shaft_torque * 0.1708 - s.engine_torque).abs() < 0.01 * s.engine_torque,
                        "{s:?}"
                    );
                }
                3999 => assert!(s.engine_speed > 120.0, "{s:?}"),
                _ => {}
            }
        }
    }
}

#[test]
fn a_governed_engine_is_steady_at_any_step() {
    // The map falls by 62.7 N m a rad/s above 230 rad/s: an explicit step of 4 ms would swing.
    for dt in [0.25e-3, 1e-3, 4e-3] {
        let mut v = hmmwv();
        v.powertrain.gearbox.shift_up[0] = 400.0;
        let mut b = Bench::new(&v, 5.0);
        for _ in 0..(4.0 / dt) as usize {
            b.step(1.0, dt);
        }
        // Zero torque on the line from (230.383, 1041.3) to (251.327, −271.2): 246.999 rad/s.
        assert!((b.drive.state().engine_speed - 246.999).abs() < 1e-2, "{dt}: {:?}", b.drive.state());
    }
}

#[test]
fn what_the_engine_loses_the_turbine_gains_when_the_fluid_does_not_multiply() {
    // In overrun the torques of impeller and turbine are equal, at any step and however light the wheels are.
    for dt in [1e-3, 4e-3] {
        let mut v = with_converter();
        v.powertrain.engine = constant(30.0, 1.6);
        v.powertrain.gearbox.shift_up[0] = 1000.0;
        let mut b = Bench::new(&v, 250.0 * 0.1708 * 0.2);
        for _ in 0..20 {
            let before = b.drive.state().engine_speed.max(80.0);
            b.step(0.0, dt);
            let s = b.drive.state();
            assert!(s.shaft_speed / 0.1708 > s.engine_speed, "{s:?}");
            let gained = 1.6 * (s.engine_speed - before) / dt;
            assert!((gained + s.shaft_torque * 0.1708 - 30.0).abs() < 1e-6, "{dt} s: {gained} {s:?}");
        }
    }
}

#[test]
fn the_engine_does_not_race_while_a_shift_interrupts_the_torque() {
    let mut v = dynamometer();
    v.powertrain.gearbox.shift_time = 0.3;
    let mut b = Bench::new(&v, 0.0);
    let spin = 235.0 * 0.1708 * 0.2;
    b.hold(1.0, spin, DT);
    assert!(b.drive.shifter.interrupts());
    for _ in 0..250 {
        b.hold(1.0, spin, DT);
        let s = b.drive.state();
        assert!(s.shaft_torque == 0.0 && s.engine_torque < 20.0, "{s:?}");
    }
}
