//! Motors of the sides: their torques, speeds and limits against closed forms.

use super::*;

fn husky() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../../../tasks/vehicles/husky.yaml"), "husky").unwrap()
}

/// The Husky without friction in motors and gears, with this control.
fn free(skid: Skid) -> VehicleSpec {
    let mut v = husky();
    v.skid = Some(skid);
    if let Engine::Electric { friction, regeneration, .. } = &mut v.powertrain.engine {
        (*friction, *regeneration) = (0.0, 0.0);
    }
    v
}

/// Speed of the motors over the spin of the wheels.
fn gearing(v: &VehicleSpec) -> f64 {
    1.0 / (v.powertrain.driveline.axles[0].final_drive * v.powertrain.gearbox.ratios[0])
}

/// Stall torque of the motors of a side at its wheels, N m.
fn stall(v: &VehicleSpec) -> f64 {
    let Engine::Electric { torque, .. } = &v.powertrain.engine else { panic!("it has motors") };
    0.5 * torque[0][1] * gearing(v)
}

/// Spins of the left and the right side.
fn sides(b: &Bench) -> [f64; 2] {
    [b.spins[0], b.spins[1]]
}

#[test]
fn straight_ahead_the_motors_push_as_one_engine_would() {
    let v = free(Skid::Speed { relative: 2.0, at_rest: 0.5, gain: 20.0 });
    let mut b = Bench::new(&v, 0.0);
    b.step(0.5, DT);
    // Half of the stall torque of a side on its wheels and rotors; both sides at 1 rad/s have the energy of one inertia.
    let energy = b.drive.energy(|_| 1.0);
    let expected = stall(&v) * DT / energy;
    let [left, right] = sides(&b);
    assert_eq!(left, right);
    // The torque falls a little as the motors turn faster within the step.
    assert!((left / (0.5 * expected) - 1.0).abs() < 0.02, "{left} {expected}");
    assert!((b.drive.state().engine_torque * gearing(&v) / stall(&v) - 1.0).abs() < 0.02);
}

#[test]
fn the_difference_of_the_speeds_is_that_of_the_command_where_nothing_resists() {
    let radius = husky().tyre.radius();
    for (spin, steering, gear) in [
        (4.0, 0.5, Gear::Forward),
        (4.0, -1.0, Gear::Forward),
        (-4.0, 0.5, Gear::Reverse),
        (0.0, 1.0, Gear::Forward),
    ] {
        let v = free(Skid::Speed { relative: 1.2, at_rest: 0.3, gain: 5.0 });
        let mut b = Bench::new(&v, spin);
        (b.gear, b.steering) = (gear, steering);
        b.drive.shifter.engage(gear, 1);
        for _ in 0..2000 {
            b.step(0.0, DT);
        }
        let [left, right] = sides(&b);
        let sign = if gear == Gear::Reverse { -1.0 } else { 1.0 };
        let mean = 0.5 * (left + right);
        let expected = sign * steering * (1.2 * mean.abs()).max(0.3 / radius);
        assert!((mean - spin).abs() < 1e-6, "what steers doesn't push: {mean}");
        assert!((right - left - expected).abs() < 0.01 * expected.abs(), "{left} {right} {expected}");
    }
}

#[test]
fn a_torque_of_the_command_moves_from_side_to_side() {
    let v = free(Skid::Torque { torque: 5.0 });
    let mut b = Bench::new(&v, 0.0);
    b.steering = 0.4;
    b.step(0.0, DT);
    let [left, right] = sides(&b);
    let inertia = b.drive.energy(|_| 1.0);
    assert!((right * inertia / (2.0 * DT) - 1.0).abs() < 1e-9, "0.4 · 5 N m: {}", right * inertia / DT);
    assert!((left + right).abs() < 1e-12);
}

#[test]
fn within_the_limits_of_the_motors_steering_comes_before_pushing() {
    // The stall torque holds either side against the ground, at full throttle and full command.
    let v = free(Skid::Torque { torque: 0.5 * stall(&husky()) });
    let mut b = Bench::new(&v, 0.0);
    b.steering = 1.0;
    b.step(1.0, DT);
    let inertia = b.drive.energy(|_| 1.0);
    let [left, right] = sides(&b).map(|spin| spin * inertia / DT / stall(&v));
    assert!((right - 1.0).abs() < 0.03 && left.abs() < 1e-9, "{left} {right}");
}

#[test]
fn brakes_hold_the_sides_against_what_steers() {
    let v = free(Skid::Torque { torque: 5.0 });
    let mut b = Bench::new(&v, 0.0);
    b.steering = 1.0;
    b.brakes.fill(3.0);
    b.step(0.0, DT);
    assert_eq!(sides(&b), [0.0; 2], "5 N m against two brakes of 3 N m at each side");
    b.brakes.fill(2.0);
    b.step(0.0, DT);
    let inertia = b.drive.energy(|_| 1.0);
    assert!((b.spins[1] * inertia / DT - 1.0).abs() < 1e-9, "{}", b.spins[1] * inertia / DT);
}

#[test]
fn wheels_of_a_side_turn_together_or_alone() {
    let together = free(Skid::Speed { relative: 2.0, at_rest: 0.0, gain: 20.0 });
    let mut alone = together.clone();
    alone.powertrain.driveline.centre = Differential::Open {};
    for (v, same) in [(together, true), (alone, false)] {
        let mut b = Bench::new(&v, 3.0);
        b.moments = vec![-2.0, -2.0, 1.0, 1.0];
        b.step(0.3, DT);
        assert_eq!(b.spins[0] == b.spins[2], same);
        // Energy: what the motors and the ground have done.
        let before = 9.0 * b.drive.energy(|_| 1.0);
        let ground: f64 = b.moments.iter().zip(&b.spins).map(|(m, s)| m * 0.5 * (3.0 + s) * DT).sum();
        let gained = b.drive.energy(|i| b.spins[i]) - before;
        assert!((gained - ground - b.drive.work()).abs() < 1e-9 * before, "{gained}");
    }
}

#[test]
fn the_spins_of_a_record_are_those_of_the_wheels() {
    let v = husky();
    let mut b = Bench::new(&v, 1.0);
    assert!(b.drive.prescribe(Some([2.0, -1.0])));
    b.moments = vec![-2.0, -2.0, 1.0, 1.0];
    b.step(0.0, DT);
    assert_eq!(b.spins, [2.0, -1.0, 2.0, -1.0]);
    assert!(!Bench::new(&hmmwv(), 1.0).drive.prescribe(None));
}
