//! Closed forms of the driveline. Wheels turn freely here: the tyres' moments are what a test says.

use super::*;
use crate::spec::{Converter, Differential, DrivenAxle, Engine, LockUp};

const DT: f64 = 1e-3;

fn hmmwv() -> VehicleSpec {
    VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap()
}

/// The HMMWV with all differentials alike.
fn with(differential: Differential) -> VehicleSpec {
    let mut v = hmmwv();
    v.powertrain.driveline.centre = differential;
    for a in &mut v.powertrain.driveline.axles {
        a.differential = differential;
    }
    v
}

/// The HMMWV on `n` driven axles, all differentials alike.
fn multi_axle(n: usize, differential: Differential) -> VehicleSpec {
    let mut v = with(differential);
    v.axles = (0..n).map(|_| v.axles[0].clone()).collect();
    let axle = DrivenAxle { share: 1.0 / n as f64, ..v.powertrain.driveline.axles[0] };
    v.powertrain.driveline.axles = vec![axle; n];
    v
}

/// An engine that always gives the same torque, N m, whatever its speed.
fn constant(torque: f64, inertia: f64) -> Engine {
    let map = vec![[0.0, torque]];
    Engine::Map { full_throttle: map.clone(), closed_throttle: map, inertia }
}

/// The HMMWV's other engine: map with its losses added (vehicles/hmmwv.yaml, engine_shafts), inertia 1.1 with the
/// gearbox' motor shaft 0.5.
fn shafts_engine() -> Engine {
    Engine::Map {
        full_throttle: vec![[0.0, 313.0], [83.775804, 339.0], [125.663706, 652.0], [167.551608, 731.0]]
            .into_iter()
            .chain([[209.43951, 658.0], [261.799388, 480.0], [282.743339, -482.0]])
            .collect(),
        closed_throttle: vec![[0.0, 0.0], [5.236, -30.0], [104.72, -50.0], [209.44, -70.0], [314.16, -90.0]],
        inertia: 1.6,
    }
}

/// Of the same vehicle (transmission_shafts_with_torque_converter).
fn converter() -> Converter {
    Converter {
        idle_speed: 80.0,
        capacity: vec![[0.0, 15.0], [0.25, 15.0], [0.5, 15.0], [0.75, 16.0], [0.9, 18.0], [1.0, 35.0]],
        torque_ratio: vec![[0.0, 2.0], [0.25, 1.8], [0.5, 1.5], [0.75, 1.15], [1.0, 1.0]],
        lock_up: None,
    }
}

fn with_converter() -> VehicleSpec {
    let mut v = with(Differential::Open {});
    v.powertrain.engine = shafts_engine();
    v.powertrain.converter = Some(converter());
    v
}

/// The same on a dynamometer, which keeps the wheels' speed.
fn dynamometer() -> VehicleSpec {
    let mut v = with_converter();
    for a in &mut v.axles {
        a.spin_inertia = 1e12;
    }
    v
}

/// A powertrain on a bench.
struct Bench {
    drive: Drive,
    spins: Vec<f64>,
    moments: Vec<f64>,
    brakes: Vec<f64>,
    torques: Vec<f64>,
}

impl Bench {
    fn new(v: &VehicleSpec, spin: f64) -> Self {
        let n = 2 * v.axles.len();
        Self {
            drive: Drive::new(v),
            spins: vec![spin; n],
            moments: vec![0.0; n],
            brakes: vec![0.0; n],
            torques: vec![0.0; n],
        }
    }

    fn step(&mut self, throttle: f64, dt: f64) {
        let mut wheels = Wheels {
            spins: &mut self.spins,
            moments: &self.moments,
            brakes: &self.brakes,
            torques: &mut self.torques,
        };
        self.drive.advance(throttle, &mut wheels, dt);
    }

    /// A step from a speed that all wheels are given.
    fn hold(&mut self, throttle: f64, spin: f64, dt: f64) {
        self.spins.fill(spin);
        self.step(throttle, dt);
    }

    /// Kinetic energy of wheels, shafts and boxes, J.
    fn energy(&self, v: &VehicleSpec) -> f64 {
        let d = &v.powertrain.driveline;
        let mut e = 0.0;
        let mut shaft = 0.0;
        for (k, a) in d.axles.iter().enumerate() {
            let (l, r) = (self.spins[2 * k], self.spins[2 * k + 1]);
            let mean = 0.5 * (l + r);
            e += 0.5 * v.axles[k].spin_inertia * (l * l + r * r)
                + 0.5 * (a.box_inertia + a.shaft_inertia / a.final_drive / a.final_drive) * mean * mean;
            shaft += a.share * mean / a.final_drive;
        }
        e + 0.5 * d.shaft_inertia * shaft * shaft
    }
}

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
    v.powertrain.driveline.axles[0].share = 1.0;
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
    for (a, share) in v.powertrain.driveline.axles.iter_mut().zip([0.35, 0.65]) {
        *a = DrivenAxle { share, shaft_inertia: 0.0, box_inertia: 0.0, ..*a };
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
    v.powertrain.engine =
        Engine::Electric { torque: vec![[0.0, 1600.0], [503.702, 0.0]], regeneration: 0.0, inertia: 0.0 };
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
    // At 261.8 rad/s the impeller takes 304.6 N m, less than the engine's 480, which fall by 962 in 20.944 rad/s:
    // 480 − 45.93 (ω − 261.8) = ω²/225 gives 265.4 rad/s.
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
    let k = interpolate(&converter().capacity, r).0;
    let impeller = (s.engine_speed / k) * (s.engine_speed / k);
    assert!(r > 0.5 && r < 0.98, "{r}");
    assert!((s.engine_torque - impeller).abs() < 1e-6 * impeller, "{s:?} {impeller}");
    let ratio = interpolate(&converter().torque_ratio, r).0;
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
