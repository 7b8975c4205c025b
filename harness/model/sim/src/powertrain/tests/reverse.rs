//! Reverse and neutral.

use super::*;
use vb_vehicle::powertrain::DirectionChange;

/// The HMMWV's reverse gear with the final drive: speed of the wheels over that of the engine.
const REVERSE: f64 = -0.2 * 0.2;

/// The vehicle with a reverse gear that is in at once.
fn at_once(mut v: VehicleSpec) -> VehicleSpec {
    v.powertrain.gearbox.direction_change = DirectionChange { speed: 1e3, latency: 0.0 };
    v
}

/// A powertrain in reverse, with a spin of all wheels.
fn backwards(v: VehicleSpec, spin: f64) -> Bench {
    let mut b = Bench::new(&at_once(v), spin);
    b.gear = Gear::Reverse;
    b
}

#[test]
fn full_throttle_in_reverse_gives_the_torque_of_the_map_through_the_reverse_ratio_backwards() {
    // 1300.2 N m at 150 rad/s / 0.2 / 0.2 = 32 505 N m at all wheels.
    let mut b = backwards(hmmwv(), 150.0 * REVERSE);
    b.step(1.0, DT);
    let s = b.drive.state();
    assert!((s.engine_speed - 150.0).abs() < 1e-9 && (s.engine_torque - 1300.2).abs() < 1e-9, "{s:?}");
    assert!((s.shaft_torque / 0.2 + 32_505.0).abs() < 0.1 && s.gear == -1, "{s:?}");
    assert!(b.spins[0] < 150.0 * REVERSE, "it gains speed backwards");
}

#[test]
fn in_reverse_the_engine_ends_at_its_greatest_speed_and_the_gearbox_does_not_shift() {
    // Zero torque on the line from (230.383, 1041.3) to (251.327, −271.2): 246.999 rad/s, above the shift up of 233.1.
    for dt in [0.25e-3, 1e-3, 4e-3] {
        let mut b = backwards(hmmwv(), 0.0);
        b.drive.shifter.spec.shift_time = 0.5;
        for _ in 0..(4.0 / dt) as usize {
            b.step(1.0, dt);
            assert!(!b.drive.shifter.interrupts());
        }
        assert!((b.spins[0] - 246.999 * REVERSE).abs() < 1e-3, "{dt}: {:?}", b.spins);
        assert_eq!(b.drive.state().gear, -1);
    }
}

#[test]
fn free_wheels_accelerate_backwards_by_torque_over_the_sum_of_reflected_inertias() {
    let mut v = hmmwv();
    v.powertrain.engine = constant(500.0, 0.7);
    let inertia = 4.0 * 8.7143 + 2.0 * 0.5 / 0.04 + 2.0 * 0.6 + 1.1 / 0.04 + 0.7 / (REVERSE * REVERSE);
    let mut b = backwards(v, -1.0);
    b.step(1.0, DT);
    for w in &b.spins {
        assert!(((w + 1.0) / DT - 500.0 / REVERSE / inertia).abs() < 1e-9, "{w}");
    }
}

#[test]
fn a_closed_throttle_in_reverse_opposes_the_motion_either_way_and_holds_at_rest() {
    let mut v = hmmwv();
    let drag = vec![[0.0, -2.0], [80.0, -20.0]];
    v.powertrain.engine =
        Engine::Map { full_throttle: vec![[0.0, 400.0]], closed_throttle: drag, inertia: 0.0 };
    // 2 N m / 0.04 = 50 N m at four wheels hold 4 · 12 and yield to 4 · 13, whichever way they are pushed.
    for (moment, holds) in [(12.0, true), (13.0, false), (-12.0, true), (-13.0, false)] {
        let mut b = backwards(v.clone(), 0.0);
        b.moments.fill(moment);
        (0..100).for_each(|_| b.step(0.0, DT));
        assert_eq!(b.spins[0].abs() < 1e-9, holds, "{moment} N m: {:?}", b.spins);
        assert!(holds || b.spins[0] * moment > 0.0, "{:?}", b.spins);
    }
    for spin in [3.2, -3.2] {
        let mut b = backwards(v.clone(), spin);
        b.step(0.0, DT);
        // 3.2 rad/s / 0.04 = 80 rad/s at the engine: 20 N m / 0.2.
        let torque = b.drive.state().shaft_torque;
        assert!((torque + 100.0 * spin.signum()).abs() < 1e-9, "{torque} N m at {spin} rad/s");
    }
}

#[test]
fn a_stalled_converter_pushes_backwards_with_its_torque_ratio_at_the_stall_speed() {
    // As forwards: at rest T_engine(ω) = (ω/15)², and the turbine gives twice that, here through the ratio −0.2.
    let mut b = backwards(dynamometer(), 0.0);
    for _ in 0..20_000 {
        b.hold(1.0, 0.0, DT);
    }
    let s = b.drive.state();
    let impeller = (s.engine_speed / 15.0) * (s.engine_speed / 15.0);
    assert!((s.engine_speed - 265.4).abs() < 0.1, "{s:?}");
    assert!((s.shaft_torque * -0.2 - 2.0 * impeller).abs() < 1e-5 * impeller, "{s:?}");
}

#[test]
fn a_turbine_that_the_vehicle_turns_backwards_is_stalled_and_takes_energy_from_it() {
    // Reverse is in and the vehicle still rolls forward: the fluid brakes with the torque of the stall.
    let mut b = backwards(dynamometer(), 0.0);
    for _ in 0..20_000 {
        b.hold(1.0, 50.0 * 0.04, DT);
    }
    let s = b.drive.state();
    let impeller = (s.engine_speed / 15.0) * (s.engine_speed / 15.0);
    assert!((s.shaft_torque * -0.2 - 2.0 * impeller).abs() < 1e-5 * impeller && s.shaft_speed > 0.0, "{s:?}");
    let before = b.drive.work();
    b.hold(1.0, 50.0 * 0.04, DT);
    // 50 rad/s · 0.2 at the output shaft.
    let expected = s.shaft_torque * 10.0 * DT;
    assert!(
        (b.drive.work() - before - expected).abs() < 1e-6 * expected.abs(),
        "{}",
        b.drive.work() - before
    );
}

#[test]
fn in_reverse_power_in_is_power_to_the_ground_and_what_spins_up() {
    // Engine power = power at the wheels + change of kinetic energy, with open differentials, which lose nothing; from
    // rolling forward through rest to backwards.
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(250.0, 0.0);
    let mut b = backwards(v.clone(), 2.0);
    b.moments = vec![900.0, 800.0, 700.0, 950.0];
    let before = b.energy(&v);
    let (mut put_in, mut out) = (0.0, 0.0);
    for _ in 0..500 {
        let s = b.spins.clone();
        let shaft = b.drive.driveline.shaft_speed(&s);
        b.step(1.0, DT);
        // 250 N m / −0.2 at the shaft; midpoint speeds give the work of a constant torque over a step exactly.
        put_in += -1250.0 * 0.5 * (shaft + b.drive.state().shaft_speed) * DT;
        out -= (0..4).map(|i| b.moments[i] * 0.5 * (s[i] + b.spins[i]) * DT).sum::<f64>();
    }
    let stored = b.energy(&v) - before;
    assert!(b.spins[0] < -2.0, "{:?}", b.spins);
    assert!(
        (put_in - out - stored).abs() < 1e-6 && (b.drive.work() - put_in).abs() < 1e-6,
        "{put_in} {out} {stored}"
    );
}

#[test]
fn a_command_for_reverse_waits_above_the_speed_with_the_throttle_closed_and_then_takes_its_latency() {
    let mut v = hmmwv();
    v.powertrain.gearbox.direction_change = DirectionChange { speed: 0.5, latency: 0.6 };
    let mut b = Bench::new(&v, 0.0);
    b.gear = Gear::Reverse;
    for _ in 0..2000 {
        b.hold(1.0, 0.51 / RADIUS, DT);
        let s = b.drive.state();
        // The maps' drag at 32 rad/s, between 2.2 and 20 N m, and no push.
        assert!(s.gear == 1 && s.shaft_torque <= 0.0 && s.engine_torque < 0.0, "{s:?}");
    }
    let mut interrupted = 0;
    while b.drive.gear() != Gear::Reverse {
        b.hold(1.0, 0.49 / RADIUS, DT);
        let s = b.drive.state();
        if b.drive.gear() == Gear::Neutral {
            assert!(s.gear == 0 && s.shaft_torque == 0.0, "{s:?}");
            interrupted += 1;
        }
    }
    assert_eq!(interrupted, 600, "steps of 1 ms");
    assert!(b.drive.state().shaft_torque < -400.0 / 0.2, "{:?}", b.drive.state());
}

#[test]
fn a_change_that_has_begun_is_completed_or_begins_anew_the_other_way() {
    let mut v = hmmwv();
    v.powertrain.gearbox.direction_change = DirectionChange { speed: 0.5, latency: 0.1 };
    let mut b = Bench::new(&v, 0.0);
    let drive = |b: &mut Bench, gear: Gear, steps: usize, spin: f64| {
        b.gear = gear;
        (0..steps).for_each(|_| b.hold(0.0, spin, DT));
        b.drive.gear()
    };
    // Rolling off forward while the change to reverse goes on.
    assert_eq!(drive(&mut b, Gear::Reverse, 50, 0.0), Gear::Neutral);
    assert_eq!(drive(&mut b, Gear::Reverse, 51, 3.0), Gear::Reverse);
    // Back to forward and, half way, to reverse again: each takes its whole latency.
    assert_eq!(drive(&mut b, Gear::Forward, 50, 0.0), Gear::Neutral);
    assert_eq!(drive(&mut b, Gear::Reverse, 100, 0.0), Gear::Neutral);
    assert_eq!(drive(&mut b, Gear::Reverse, 1, 0.0), Gear::Reverse);
}

#[test]
fn neutral_comes_at_once_and_leaves_only_the_drivelines_own_inertia() {
    for v in [hmmwv(), with_converter()] {
        let mut b = Bench::new(&v, 20.0);
        b.step(1.0, DT);
        b.gear = Gear::Neutral;
        let spin = b.spins[0];
        b.moments.fill(-10.0);
        b.step(1.0, DT);
        let s = b.drive.state();
        assert!(s.gear == 0 && s.shaft_torque == 0.0, "{s:?}");
        // Wheels 4 · 8.7143; axle shafts 2 · 0.5/0.2²; axle boxes 2 · 0.6; output shaft and centre box 1.1/0.2².
        let inertia = 4.0 * 8.7143 + 2.0 * 0.5 / 0.04 + 2.0 * 0.6 + 1.1 / 0.04;
        assert!(((b.spins[0] - spin) / DT + 40.0 / inertia).abs() < 1e-9, "{:?}", b.spins);
    }
}

#[test]
fn out_of_neutral_the_direction_of_the_motion_comes_at_any_speed_and_the_other_one_waits() {
    let mut v = hmmwv();
    v.powertrain.gearbox.direction_change = DirectionChange { speed: 0.5, latency: 0.1 };
    for (spin, ahead, back) in [(10.0, Gear::Forward, Gear::Reverse), (-10.0, Gear::Reverse, Gear::Forward)] {
        let mut b = Bench::new(&v, spin);
        b.gear = Gear::Neutral;
        b.hold(0.0, spin, DT);
        b.gear = back;
        (0..500).for_each(|_| b.hold(0.0, spin, DT));
        assert_eq!(b.drive.gear(), Gear::Neutral, "{back:?} at {spin} rad/s");
        b.gear = ahead;
        (0..101).for_each(|_| b.hold(0.0, spin, DT));
        assert_eq!(b.drive.gear(), ahead, "at {spin} rad/s");
    }
}

#[test]
fn neutral_keeps_the_forward_gear_ready_that_the_speed_asks_for() {
    // 40 rad/s at the wheels are 200 rad/s / 1.0173 = 196.6 rad/s at the engine in fifth gear, within its band; fourth
    // gear would be beyond its shift up at 321.4.
    let mut b = Bench::new(&hmmwv(), 0.0);
    b.gear = Gear::Neutral;
    (0..100).for_each(|_| b.hold(0.0, 40.0, DT));
    b.gear = Gear::Forward;
    (0..1000).for_each(|_| b.hold(0.0, 40.0, DT));
    let s = b.drive.state();
    assert!(s.gear == 5 && (s.engine_speed - 200.0 / 1.0173).abs() < 1e-9, "{s:?}");
}

#[test]
fn in_neutral_an_engine_behind_a_converter_idles_or_races_and_no_torque_passes() {
    let mut b = Bench::new(&with_converter(), 0.0);
    b.gear = Gear::Neutral;
    (0..5000).for_each(|_| b.hold(0.0, 30.0, DT));
    let s = b.drive.state();
    // The governor's band is a tenth of the idle speed; no fluid drags, so that it idles higher than in gear.
    assert!(s.engine_speed > 75.0 && s.engine_speed < 80.0 && s.shaft_torque == 0.0, "{s:?}");
    (0..5000).for_each(|_| b.hold(1.0, 30.0, DT));
    // Zero torque on the line from (261.799, 478) to (282.743, −484): 272.206 rad/s.
    assert!((b.drive.state().engine_speed - 272.206).abs() < 1e-2, "{:?}", b.drive.state());
}

#[test]
fn without_a_reverse_gear_the_command_for_reverse_is_neutral() {
    let mut v = hmmwv();
    v.powertrain.gearbox.reverse = None;
    let mut b = Bench::new(&v, 5.0);
    b.gear = Gear::Reverse;
    b.step(1.0, DT);
    assert!(b.drive.gear() == Gear::Neutral && b.drive.state().shaft_torque == 0.0);
    (0..5000).for_each(|_| b.hold(1.0, 0.0, DT));
    assert!(b.drive.gear() == Gear::Neutral && b.drive.state().shaft_torque == 0.0);
}

#[test]
fn only_another_direction_than_forward_adds_numbers_to_the_state() {
    let mut v = hmmwv();
    v.powertrain.gearbox.direction_change = DirectionChange { speed: 0.5, latency: 0.1 };
    let mut b = Bench::new(&v, 0.0);
    let mut after = |gear: Gear, steps: usize| -> Vec<f64> {
        b.gear = gear;
        (0..steps).for_each(|_| b.hold(0.0, 0.0, DT));
        let all: Vec<f64> = b.drive.inner_state().collect();
        [&all[..1], &all[4..]].concat()
    };
    assert_eq!(after(Gear::Forward, 10), [0.0]);
    let left = after(Gear::Reverse, 40);
    assert!(left[..3] == [-2.0, 0.0, -1.0] && (left[3] - 0.06).abs() < 1e-9, "{left:?}");
    assert_eq!(after(Gear::Reverse, 100), [-1.0]);
    assert_eq!(after(Gear::Neutral, 1), [-2.0, 0.0]);
    assert_eq!(after(Gear::Forward, 200), [0.0]);
}
