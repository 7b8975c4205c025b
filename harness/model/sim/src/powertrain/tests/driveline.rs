//! Inertias, differentials and brakes.

use super::*;

#[test]
fn full_throttle_at_peak_gives_the_torque_of_the_map_through_the_ratios() {
    // Reference sheet: 1300.2 N m / 0.1708 / 0.2 = 38 062 N m at all wheels in first gear.
    let mut b = Bench::new(&hmmwv(), 150.0 * 0.1708 * 0.2);
    b.step(1.0, DT);
    let s = b.drive.state();
    assert!((s.engine_speed - 150.0).abs() < 1e-9 && (s.engine_torque - 1300.2).abs() < 1e-9, "{s:?}");
    assert!((s.shaft_torque / 0.2 - 38_062.06).abs() < 0.1, "{s:?}");
}

#[test]
fn free_wheels_accelerate_by_torque_over_the_sum_of_reflected_inertias() {
    // Wheels 4 · 8.7143; axle shafts 2 · 0.5/0.2²; axle boxes 2 · 0.6; output shaft and centre box 1.1/0.2²;
    // engine 0.7/(0.1708 · 0.2)².
    let mut v = hmmwv();
    v.powertrain.engine = constant(500.0, 0.7);
    let g = 0.1708 * 0.2;
    let inertia = 4.0 * 8.7143 + 2.0 * 0.5 / 0.04 + 2.0 * 0.6 + 1.1 / 0.04 + 0.7 / (g * g);
    let mut b = Bench::new(&v, 1.0);
    b.step(1.0, DT);
    for w in &b.spins {
        assert!(((w - 1.0) / DT - 500.0 / g / inertia).abs() < 1e-9, "{w}");
    }
}

#[test]
fn one_driven_axle_takes_it_all_and_the_other_rolls_free() {
    let mut v = hmmwv();
    v.axles[0].driven = false;
    v.powertrain.engine = constant(500.0, 0.0);
    v.powertrain.driveline.axles.truncate(1);
    v.powertrain.driveline.axles[0].fraction = 1.0;
    let mut b = Bench::new(&v, 1.0);
    b.moments = vec![10.0, -10.0, 0.0, 0.0];
    b.step(1.0, DT);
    assert!(((b.spins[0] - 1.0) / DT - 10.0 / 8.7143).abs() < 1e-9 && b.torques[0] == 0.0);
    let inertia = 2.0 * 8.7143 + 0.5 / 0.04 + 0.6 + 1.1 / 0.04;
    let expected = 500.0 / 0.1708 / 0.2 / inertia;
    assert!(((b.spins[2] - 1.0) / DT - expected).abs() < 1e-9, "{:?}", b.spins);
}

#[test]
fn an_open_differential_gives_both_wheels_the_same_torque() {
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(300.0, 0.0);
    let mut b = Bench::new(&v, 0.0);
    b.spins = vec![9.0, 3.0, 4.0, 4.0];
    b.moments = vec![-2000.0, 0.0, -500.0, -100.0];
    b.step(1.0, DT);
    assert!((b.torques[0] - b.torques[1]).abs() < 1e-9 && (b.torques[2] - b.torques[3]).abs() < 1e-9);
}

#[test]
fn an_open_centre_differential_splits_by_its_shares() {
    // Massless shafts, so that torques can be compared as they are.
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(300.0, 0.0);
    v.powertrain.driveline.shaft_inertia = 0.0;
    for (a, fraction) in v.powertrain.driveline.axles.iter_mut().zip([0.35, 0.65]) {
        *a = DrivenAxle { fraction, shaft_inertia: 0.0, box_inertia: 0.0, ..*a };
    }
    let mut b = Bench::new(&v, 2.0);
    b.moments = vec![-700.0, 0.0, -500.0, -100.0];
    b.step(1.0, DT);
    let total = 300.0 / 0.1708 / 0.2;
    for (i, expected) in [(0, 0.35 * total), (1, 0.35 * total), (2, 0.65 * total), (3, 0.65 * total)] {
        assert!((b.torques[i] - 0.5 * expected).abs() < 1e-8, "{i}: {:?}", b.torques);
    }
}

#[test]
fn a_slipping_clutch_moves_its_torque_from_the_faster_to_the_slower_wheel() {
    let mut v = with(Differential::Open {});
    v.powertrain.driveline.axles[0].differential = Differential::Clutch { torque: 700.0 };
    let mut b = Bench::new(&v, 4.0);
    b.spins = vec![9.0, 3.0, 4.0, 4.0];
    b.step(0.5, DT);
    assert!((b.torques[1] - b.torques[0] - 1400.0).abs() < 1e-8, "{:?}", b.torques);
    assert!((b.torques[2] - b.torques[3]).abs() < 1e-8, "{:?}", b.torques);
}

#[test]
fn the_bias_ratio_of_a_limited_slip_differential_is_reached_and_not_exceeded() {
    // Gator, MAN: bias 2 (tyre-and-soil-models.md §12): the slower wheel gets 2/3, the faster 1/3.
    let slip = Differential::LimitedSlip { bias: 2.0, preload: 0.0 };
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(300.0, 0.0);
    v.powertrain.driveline.shaft_inertia = 0.0;
    for a in &mut v.powertrain.driveline.axles {
        *a = DrivenAxle { shaft_inertia: 0.0, box_inertia: 0.0, differential: slip, ..*a };
    }
    let mut b = Bench::new(&v, 0.0);
    b.spins = vec![9.0, 3.0, 4.0, 4.0];
    // On the rear axle a difference of moments that less bias than 2 can balance.
    b.moments = vec![0.0, 0.0, -1000.0, -1400.0];
    b.step(1.0, DT);
    let axle = 0.5 * 300.0 / 0.1708 / 0.2;
    assert!((b.torques[0] - axle / 3.0).abs() < 1e-8, "{:?} {axle}", b.torques);
    assert!((b.torques[1] - axle * 2.0 / 3.0).abs() < 1e-8, "{:?}", b.torques);
    assert!((b.spins[2] - b.spins[3]).abs() < 1e-9, "{:?}", b.spins);
    assert!((b.torques[3] - b.torques[2] - 400.0).abs() < 1e-8, "{:?}", b.torques);
}

/// Limited slip of bias 2 between the wheels, the axles locked together, shafts without inertia.
fn limited_slip(engine: Engine) -> VehicleSpec {
    let mut v = with(Differential::Locked {});
    v.powertrain.engine = engine;
    v.powertrain.driveline.shaft_inertia = 0.0;
    for a in &mut v.powertrain.driveline.axles {
        let differential = Differential::LimitedSlip { bias: 2.0, preload: 0.0 };
        *a = DrivenAxle { shaft_inertia: 0.0, box_inertia: 0.0, differential, ..*a };
    }
    v
}

#[test]
fn a_limited_slip_axle_biases_all_of_the_torque_that_the_centre_hands_it() {
    // Nothing but the right rear wheel meets resistance.
    let mut b = Bench::new(&limited_slip(constant(300.0, 0.0)), 0.0);
    for _ in 0..1000 {
        b.moments[3] = -4000.0 * b.spins[3];
        b.step(1.0, DT);
    }
    assert!(b.torques[3] > 0.49 * b.torques.iter().sum::<f64>(), "{:?}", b.torques);
    assert!((b.torques[3] / b.torques[2] - 2.0).abs() < 1e-6, "{:?}", b.torques);
}

#[test]
fn what_spins_up_shafts_and_engine_does_not_count_for_the_bias() {
    // Slower over faster output torque is the bias (SAE 2003-01-0664), with brakes or without, however much of the engine's
    // torque accelerates what lies before the differential.
    let slip = Differential::LimitedSlip { bias: 2.0, preload: 0.0 };
    for centre in [Differential::Open {}, Differential::Locked {}, slip] {
        for brakes in [[0.0; 4], [30.0, 0.0, 30.0, 0.0]] {
            let mut v = with(centre);
            v.powertrain.engine = constant(300.0, 1.6);
            for a in &mut v.powertrain.driveline.axles {
                a.differential = slip;
            }
            let mut b = Bench::new(&v, 0.0);
            b.spins = vec![9.0, 3.0, 9.0, 3.0];
            b.brakes = brakes.to_vec();
            b.step(1.0, DT);
            assert!(b.spins[0] > 9.001 || brakes[0] > 0.0, "{:?}", b.spins);
            for left in [0, 2] {
                // `torques` have the brakes in them.
                let (faster, slower) = (b.torques[left] + brakes[left], b.torques[left + 1]);
                assert!(faster > 1.0 && (slower / faster - 2.0).abs() < 1e-6, "{centre:?}: {:?}", b.torques);
            }
        }
    }
}

#[test]
fn a_centre_of_limited_slip_biases_what_is_left_of_the_engine_s_torque() {
    let slip = Differential::LimitedSlip { bias: 2.0, preload: 0.0 };
    let mut v = with(slip);
    v.powertrain.engine = constant(300.0, 1.6);
    for a in &mut v.powertrain.driveline.axles {
        *a = DrivenAxle { shaft_inertia: 0.0, box_inertia: 0.0, differential: Differential::Open {}, ..*a };
    }
    let mut b = Bench::new(&v, 0.0);
    b.spins = vec![9.0, 9.0, 3.0, 3.0];
    b.step(1.0, DT);
    let [faster, slower] = [0, 2].map(|left| b.torques[left] + b.torques[left + 1]);
    assert!(b.spins[0] > 9.0 && (slower / faster - 2.0).abs() < 1e-6, "{:?}", b.torques);
}

#[test]
fn a_limited_slip_axle_biases_the_drag_of_the_engine_too() {
    let mut b = Bench::new(&limited_slip(constant(-100.0, 0.0)), 0.0);
    b.spins = vec![12.0, 8.0, 10.0, 10.0];
    b.step(0.0, DT);
    assert!(b.torques[1] < -1.0 && (b.torques[0] / b.torques[1] - 2.0).abs() < 1e-6, "{:?}", b.torques);
}

#[test]
fn with_one_wheel_in_the_air_an_open_axle_can_push_no_more_than_the_air_but_a_locked_one_can() {
    // The left wheel is free, the right one held by the ground: the locked axle hands all of its torque to it.
    let ground = |v: &VehicleSpec, seconds: f64| {
        let mut b = Bench::new(v, 0.0);
        for _ in 0..(seconds / DT) as usize {
            // A stiff ground under the right wheels.
            let hold = |w: f64| -4000.0 * w;
            b.moments = vec![0.0, hold(b.spins[1]), 0.0, hold(b.spins[3])];
            b.step(1.0, DT);
        }
        b
    };
    let mut v = with(Differential::Locked {});
    v.powertrain.engine = constant(400.0, 0.0);
    let b = ground(&v, 1.0);
    let total = 400.0 / 0.1708 / 0.2;
    assert!((b.spins[0] - b.spins[1]).abs() < 1e-9, "{:?}", b.spins);
    assert!((b.torques[1] + b.torques[3] - total).abs() < 1e-3 * total, "{:?} {total}", b.torques);
    assert!(b.torques[0].abs() < 1.0);
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(400.0, 0.0);
    let b = ground(&v, 0.05);
    assert!(b.torques[1] < 0.26 * total, "{:?}", b.torques);
    assert!(b.spins[0] > 20.0 * b.spins[1], "{:?}", b.spins);
}

#[test]
fn locked_differentials_turn_all_wheels_alike_on_two_three_and_four_axles() {
    for n in 2..=4 {
        let v = multi_axle(n, Differential::Locked {});
        for dt in [0.25e-3, 1e-3, 4e-3] {
            let mut b = Bench::new(&v, 3.0);
            for k in 0..400 {
                for (i, m) in b.moments.iter_mut().enumerate() {
                    *m = 3000.0 * vb_math::sin(0.7 * f64::from(k) + 2.1 * i as f64);
                }
                b.step(0.7, dt);
                let spread = b.spins.iter().fold(0.0, |s: f64, w| s.max((w - b.spins[0]).abs()));
                assert!(spread < 1e-6, "{n} axles, {dt} s, step {k}: {:?}", b.spins);
            }
        }
    }
}

#[test]
fn the_driveline_never_creates_energy_and_locked_wheels_keep_what_momentum_leaves() {
    let mut engine = constant(0.0, 0.0);
    for differential in [
        Differential::Open {},
        Differential::Clutch { torque: 150.0 },
        Differential::LimitedSlip { bias: 3.0, preload: 50.0 },
        Differential::Locked {},
    ] {
        for braking in [0.0, 30.0] {
            let mut v = multi_axle(3, differential);
            std::mem::swap(&mut v.powertrain.engine, &mut engine);
            let mut b = Bench::new(&v, 0.0);
            b.spins = vec![30.0, 10.0, -4.0, 12.0, 25.0, 24.0];
            b.brakes = vec![braking, 0.0, braking, braking, 0.0, 0.0];
            let mut before = b.energy(&v);
            for k in 0..3000 {
                b.step(1.0, DT);
                let now = b.energy(&v);
                assert!(
                    now <= before * (1.0 + 1e-12) + 1e-9,
                    "{differential:?}, step {k}: {before} J to {now} J"
                );
                before = now;
            }
            std::mem::swap(&mut v.powertrain.engine, &mut engine);
        }
    }
}

#[test]
fn power_in_is_power_to_the_ground_and_what_spins_up() {
    // Engine power = power at the wheels + change of kinetic energy, with open differentials, which lose nothing.
    let mut v = with(Differential::Open {});
    v.powertrain.engine = constant(250.0, 0.0);
    let mut b = Bench::new(&v, 2.0);
    b.moments = vec![-900.0, -800.0, -700.0, -950.0];
    let (mut put_in, mut out) = (0.0, 0.0);
    let before = b.energy(&v);
    for _ in 0..500 {
        let s = b.spins.clone();
        let shaft = b.drive.driveline.shaft_speed(&s);
        b.step(1.0, DT);
        let after = b.drive.state().shaft_speed;
        // Midpoint speeds: the work of a constant torque over a step, exactly.
        put_in += b.drive.state().shaft_torque * 0.5 * (shaft + after) * DT;
        out -= (0..4).map(|i| b.moments[i] * 0.5 * (s[i] + b.spins[i]) * DT).sum::<f64>();
    }
    let stored = b.energy(&v) - before;
    assert!(put_in > 1000.0 && (put_in - out - stored).abs() < 1e-9 * put_in, "{put_in} {out} {stored}");
}

#[test]
fn brakes_stop_a_wheel_and_hold_it_up_to_their_torque_whatever_the_differentials() {
    for differential in
        [Differential::Open {}, Differential::Clutch { torque: 100.0 }, Differential::Locked {}]
    {
        let v = with(differential);
        let mut b = Bench::new(&v, 8.0);
        b.brakes.fill(1000.0);
        b.moments = vec![950.0, -300.0, 500.0, 0.0];
        for _ in 0..2000 {
            b.step(0.0, DT);
        }
        assert!(b.spins.iter().all(|w| w.abs() < 1e-8), "{differential:?}: {:?}", b.spins);
        for (m, t) in b.moments.iter().zip(&b.torques) {
            assert!((m + t).abs() < 1e-3, "{differential:?}: {:?}", b.torques);
        }
        b.moments.fill(1100.0);
        for _ in 0..100 {
            b.step(0.0, DT);
        }
        assert!(b.spins.iter().all(|w| *w > 0.01), "{differential:?}: {:?}", b.spins);
    }
}

#[test]
fn a_wheel_that_nothing_drives_is_braked_and_held_too() {
    let mut v = with(Differential::Locked {});
    v.axles[0].driven = false;
    v.powertrain.driveline.axles.truncate(1);
    v.powertrain.driveline.axles[0].fraction = 1.0;
    let mut b = Bench::new(&v, 0.0);
    b.spins = vec![10.0, 0.001, 0.0, 0.0];
    b.brakes.fill(100.0);
    b.moments = vec![0.0, 80.0, 0.0, 0.0];
    b.step(0.0, DT);
    assert!(((10.0 - b.spins[0]) / DT - 100.0 / 8.7143).abs() < 1e-9, "{:?}", b.spins);
    assert!(b.spins[1].abs() < 1e-12 && (b.torques[1] + 80.0 + 8.7143).abs() < 1e-9, "{:?}", b.torques);
}

#[test]
fn a_locked_axle_brakes_a_wheel_without_brake() {
    // Gator: brakes at the rear only. One brake of 1000 N m slows all four wheels of a locked driveline alike.
    let mut v = with(Differential::Locked {});
    v.powertrain.engine = constant(0.0, 0.0);
    let mut b = Bench::new(&v, 20.0);
    b.brakes[2] = 1000.0;
    b.step(0.0, DT);
    let inertia = 4.0 * 8.7143 + 2.0 * (0.5 / 0.04 + 0.6) + 1.1 / 0.04;
    for w in &b.spins {
        assert!(((20.0 - w) / DT - 1000.0 / inertia).abs() < 1e-6, "{:?}", b.spins);
    }
}

#[test]
fn brakes_meet_a_heavy_engine_without_losing_torque() {
    // 4 · 500 N m on wheels, shafts and an engine of 1.6 kg m² in first gear, which outweighs them thirteenfold.
    let mut v = with(Differential::Locked {});
    v.powertrain.engine = constant(0.0, 1.6);
    let mut b = Bench::new(&v, 20.0);
    b.brakes.fill(500.0);
    b.step(0.0, DT);
    let g = 0.1708 * 0.2;
    let inertia = 4.0 * 8.7143 + 2.0 * (0.5 / 0.04 + 0.6) + 1.1 / 0.04 + 1.6 / (g * g);
    for w in &b.spins {
        assert!(((20.0 - w) / DT - 2000.0 / inertia).abs() < 1e-6, "{:?}", b.spins);
    }
}

#[test]
fn a_state_that_has_diverged_stays_so_without_a_panic() {
    for differential in [Differential::LimitedSlip { bias: 2.0, preload: 0.0 }, Differential::Locked {}] {
        let mut b = Bench::new(&with(differential), 1.0);
        b.spins[0] = f64::NAN;
        b.brakes.fill(10.0);
        b.step(0.5, DT);
        b.step(0.0, DT);
        assert!(b.spins[0].is_nan());
    }
}
