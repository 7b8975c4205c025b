//! The filters against ISO 2631-1 and the published constants of absorbed power, and the meter on motions with a known result.

use std::f64::consts::{SQRT_2, TAU};

use vb_math::{cos, sin};

use super::filter::Filter;
use super::weighting::{ABSORBED_POWER, PRADKO_LEE_GAIN, stages};
use super::{Ride, RideMeter, RideStep};

const STEP: f64 = 1e-3;

/// The weighting factors of ISO 2631-1:1997, table 3, as thousandths: one-third octave n (its centre is 10^(n/10) Hz), W_k, W_d.
const ISO: [(i32, f64, f64); 30] = [
    (-10, 31.2, 62.4),
    (-9, 48.6, 97.3),
    (-8, 79.0, 158.0),
    (-7, 121.0, 243.0),
    (-6, 182.0, 365.0),
    (-5, 263.0, 530.0),
    (-4, 352.0, 713.0),
    (-3, 418.0, 853.0),
    (-2, 459.0, 944.0),
    (-1, 477.0, 992.0),
    (0, 482.0, 1011.0),
    (1, 484.0, 1008.0),
    (2, 494.0, 968.0),
    (3, 531.0, 890.0),
    (4, 631.0, 776.0),
    (5, 804.0, 642.0),
    (6, 967.0, 512.0),
    (7, 1039.0, 409.0),
    (8, 1054.0, 323.0),
    (9, 1036.0, 253.0),
    (10, 988.0, 212.0),
    (11, 902.0, 161.0),
    (12, 768.0, 125.0),
    (13, 636.0, 100.0),
    (14, 513.0, 80.0),
    (15, 405.0, 63.2),
    (16, 314.0, 49.4),
    (17, 246.0, 38.8),
    (18, 186.0, 29.5),
    (19, 132.0, 21.1),
];

fn centre(n: i32) -> f64 {
    vb_math::exp(f64::from(n) / 10.0 * std::f64::consts::LN_10)
}

/// The gain of the four stages for a signal of this frequency (Hz), by the transfer function of the digital sections.
fn gain(lane: usize, frequency: f64, step: f64) -> f64 {
    let angle = TAU * frequency * step;
    let z = [(1.0, 0.0), (cos(angle), -sin(angle)), (cos(2.0 * angle), -sin(2.0 * angle))];
    let size = |c: [f64; 3]| {
        let (re, im) = c.iter().zip(z).fold((0.0, 0.0), |(re, im), (c, z)| (re + c * z.0, im + c * z.1));
        (re * re + im * im).sqrt()
    };
    let of = |filter: Filter| {
        let [b0, b1, b2, a1, a2] = filter.coefficients(lane);
        size([b0, b1, b2]) / size([1.0, a1, a2])
    };
    stages(step).map(|sections| of(Filter::new(sections, step))).iter().product()
}

#[test]
fn weightings_are_those_of_iso_2631_within_the_tolerance_of_iso_8041() {
    for step in [1e-4, STEP, 2e-3] {
        for (n, vertical, horizontal) in ISO {
            // ISO 8041: +12/-11 % within the range of frequencies, +26/-21 % at its edges, nothing below beyond it.
            let frequency = centre(n);
            let (low, high) = if (0.5..=50.2).contains(&frequency) { (0.89, 1.12) } else { (0.79, 1.26) };
            for (lane, factor) in [(0, horizontal), (1, horizontal), (2, vertical)] {
                let ratio = gain(lane, frequency, step) / (factor / 1000.0);
                assert!((low..=high).contains(&ratio), "{step} s, {frequency:.2} Hz, {lane}: {ratio}");
            }
        }
    }
    // At the step of runs they are nearer by far: all but the misprinted 212 at 10 Hz within 2 %.
    for (n, vertical, horizontal) in ISO.into_iter().filter(|(n, ..)| *n != 10 && *n < 18) {
        for (lane, factor) in [(0, horizontal), (2, vertical)] {
            let ratio = gain(lane, centre(n), STEP) / (factor / 1000.0);
            assert!((ratio - 1.0).abs() < 0.02, "{n}, {lane}: {ratio}");
        }
    }
}

/// The power that a driver absorbs from a vertical sine of effective value 1 m/s² (Pradko and Lee 1966), W.
fn published_power(frequency: f64) -> f64 {
    let w = TAU * frequency;
    let x = w * w;
    let f1 = 1.0 + x * (-0.446_01e-2 + x * (0.175_83e-5 - x * 0.102_45e-9));
    let f2 = w * (0.105_43 + x * (-0.933_94e-4 + x * 0.128_82e-7));
    let f3 = 1.0 + x * (-0.561_04e-2 + x * (0.376_67e-5 - x * 0.454_16e-9));
    let f4 = w * (0.115_43 + x * (-0.179_47e-3 + x * (0.517_28e-7 - x * 0.211_79e-11)));
    let feet = 0.3048;
    1.356 * 4.353_70 * (f1 * f4 - f2 * f3) / (w * (f3 * f3 + f4 * f4)) / (feet * feet)
}

#[test]
fn absorbed_power_is_that_of_the_published_constants() {
    for frequency in [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 30.0] {
        let own = gain(3, frequency, STEP) * PRADKO_LEE_GAIN;
        let ratio = ABSORBED_POWER * own * own / published_power(frequency);
        assert!((ratio - 1.0).abs() < 0.02, "{frequency} Hz: {ratio}");
    }
    // The body takes most in at 4 to 6 Hz.
    assert!(published_power(5.0) > 3.0 * published_power(2.0));
}

/// A ride of a vehicle on its wheels whose seat is accelerated like this, over so many seconds.
fn ride(seconds: f64, step: f64, scale: f64, acceleration: impl Fn(f64) -> [f64; 3]) -> Ride {
    let mut meter = RideMeter::new(step, scale);
    for k in 0..(seconds / step).round() as u64 {
        let acceleration = acceleration(k as f64 * step);
        meter.push(&RideStep { acceleration, upward: 1.0, loaded_wheels: 4, hull_is_free: true });
    }
    meter.ride().unwrap()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a}, not {b}");
}

#[test]
fn a_sine_has_its_weighted_effective_value_power_and_peak() {
    // An amplitude of 2 m/s² has an effective value of √2.
    let vertical = ride(200.0, STEP, 1.0, |t| [0.0, 0.0, 2.0 * sin(TAU * centre(7) * t)]);
    close(vertical.seat_rms_z_m_per_s2, 1.039 * SQRT_2, 0.01);
    close(vertical.seat_rms_m_per_s2, 1.039 * SQRT_2, 0.01);
    close(vertical.absorbed_power_w, 2.0 * published_power(centre(7)), 0.01);
    // 5 Hz pass the filter of the peak; the first half-wave of a filter at rest is no higher.
    close(vertical.seat_peak_g, 2.0 / 9.806_65, 0.02);
    assert_eq!(vertical.seat_peak_g, vertical.seat_peak_z_g);

    let ahead = ride(200.0, STEP, 1.0, |t| [2.0 * sin(TAU * t), 0.0, 0.0]);
    close(ahead.seat_rms_m_per_s2, 1.4 * 1.011 * SQRT_2, 0.01);
    assert_eq!((ahead.seat_rms_z_m_per_s2, ahead.absorbed_power_w, ahead.seat_peak_z_g), (0.0, 0.0, 0.0));
    let aside = ride(200.0, STEP, 1.0, |t| [0.0, 2.0 * sin(TAU * t), 0.0]);
    assert_eq!(aside.seat_rms_m_per_s2, ahead.seat_rms_m_per_s2);
}

#[test]
fn six_watts_at_five_hertz_are_0_18_g() {
    // By the published constants: the limit of ride is 0.18 g, effective, where the body is most sensitive.
    let amplitude = 0.18 * 9.806_65 * SQRT_2;
    let limit = ride(100.0, STEP, 1.0, |t| [0.0, 0.0, amplitude * sin(TAU * 5.0 * t)]);
    close(limit.absorbed_power_w, 6.0, 0.03);
}

#[test]
fn the_step_hardly_changes_what_is_measured() {
    let motion = |t: f64| [sin(9.0 * t), 0.5 * sin(14.0 * t), 2.0 * sin(25.0 * t) + sin(60.0 * t)];
    let fine = ride(20.0, 1e-4, 1.0, motion);
    for step in [1e-3, 2e-3, 5e-3] {
        let coarse = ride(20.0, step, 1.0, motion);
        close(coarse.seat_peak_g, fine.seat_peak_g, 0.03);
        close(coarse.seat_rms_m_per_s2, fine.seat_rms_m_per_s2, 0.03);
        close(coarse.absorbed_power_w, fine.absorbed_power_w, 0.05);
    }
}

#[test]
fn a_velocity_that_ends_in_one_step_has_a_peak_that_does_not_depend_on_the_step() {
    // 1 m/s within a step: a Butterworth filter's response to an impulse peaks at √2 e^(-π/4) sin(π/4) ω = 0.456 ω.
    let expected = 0.455_938 * TAU * 30.0 / 9.806_65;
    for step in [1e-4, 5e-4, 1e-3, 2e-3] {
        let hit = ride(1.0, step, 1.0, |t| if t == 0.0 { [0.0, 0.0, 1.0 / step] } else { [0.0; 3] });
        close(hit.seat_peak_g, expected, 0.04);
    }
}

#[test]
fn a_small_vehicle_that_does_what_a_large_one_does_is_measured_alike() {
    let large = ride(20.0, STEP, 1.0, |t| [0.0, 0.0, 3.0 * sin(25.0 * t)]);
    let pace = 0.1f64.sqrt();
    let small = ride(20.0 * pace, STEP * pace, 0.1, |t| [0.0, 0.0, 3.0 * sin(25.0 * t / pace)]);
    close(small.seat_peak_g, large.seat_peak_g, 1e-9);
    close(small.seat_rms_m_per_s2, large.seat_rms_m_per_s2, 1e-9);
    close(small.absorbed_power_w, large.absorbed_power_w, 1e-9);
}

#[test]
fn airborne_is_without_load_on_wheels_and_hull_and_landed_is_upright_on_two_wheels_for_0_2_s() {
    let mut meter = RideMeter::new(STEP, 1.0);
    assert_eq!(meter.ride(), None);
    let mut drive = |steps: u64, upward: f64, loaded_wheels: usize, hull_is_free: bool| {
        for _ in 0..steps {
            meter.push(&RideStep { acceleration: [0.0; 3], upward, loaded_wheels, hull_is_free });
        }
        let ride = meter.ride().unwrap();
        ((ride.airborne_fraction * 1000.0).round() / 1000.0, ride.landed)
    };
    assert_eq!(drive(200, 1.0, 2, true), (0.0, true));
    assert_eq!(drive(200, 1.0, 0, true), (0.5, false));
    assert_eq!(drive(400, 1.0, 0, false), (0.25, false), "on its belly");
    assert!(!drive(199, 1.0, 3, true).1);
    assert!(drive(1, 1.0, 2, true).1);
    assert!(!drive(1, 1.0, 1, true).1);
    assert!(!drive(300, 0.49, 4, true).1, "on its side: more than 60°");
}

#[test]
fn what_no_simulation_measures_is_refused_with_field_and_value() {
    let good = ride(1.0, STEP, 1.0, |_| [0.0; 3]);
    assert_eq!(good.flaw(), None);
    let flaw = |ride: Ride| ride.flaw().unwrap();
    assert_eq!(flaw(Ride { seat_peak_g: -1.0, ..good }), "seat_peak_g: -1 must lie in 0 to 1e9");
    assert_eq!(flaw(Ride { airborne_fraction: 1.5, ..good }), "airborne_fraction: 1.5 must lie in 0 to 1");
    assert_eq!(flaw(Ride { held_fraction: Some(-0.5), ..good }), "held_fraction: -0.5 must lie in 0 to 1");
    assert!(flaw(Ride { absorbed_power_w: f64::NAN, ..good }).starts_with("absorbed_power_w: NaN"));
    // A simulation that failed has no measures.
    let mut meter = RideMeter::new(STEP, 1.0);
    let step = RideStep { acceleration: [f64::NAN; 3], upward: 1.0, loaded_wheels: 4, hull_is_free: true };
    meter.push(&step);
    assert_eq!(meter.ride(), None);
}
