//! Tests of the characteristics: of a vehicle whose figures follow by hand, and of one with known defects.

use super::*;
use vb_math::tan;

/// Trailing arms of 0.5 m that lie level at rest, with upright struts at half their length: the motion ratio is a half at any travel,
/// and no wheel moves sideways. Sprung mass 2000 kg in the middle, 500 kg on a wheel.
const SIMPLE: &str = r"
schema: 1
name: simple
description: a vehicle of closed forms
length: 4.0
width: 1.7
height: 1.2
max_speed: 10.0
chassis:
  mass: 2000.0
  com: [0.0, 0.0, 0.5]
  inertia: [500.0, 2000.0, 2200.0]
  friction: 0.4
  hull:
    - [[2.0, 0.6, 0.0], [2.0, -0.6, 0.0], [-2.0, 0.6, 0.0], [-2.0, -0.6, 0.0], [2.0, 0.6, 0.6], [2.0, -0.6, 0.6], [-2.0, 0.6, 0.6], [-2.0, -0.6, 0.6]]
axles:
  - name: front
    position: [1.5, 0.0, 0.0]
    driven: true
    unsprung_mass: 50.0
    spin_inertia: 2.0
    brake_torque: 3000.0
    suspension:
      linkage: {type: torsion_arm, spindle: [0.0, 0.7, 0.0], pivot: [0.5, 0.7, 0.0], axis: [0.0, 1.0, 0.0]}
      struts:
        - chassis: [0.25, 0.7, 0.6]
          end: [0.25, 0.7, 0.0]
          part: arm
          spring: {type: linear, stiffness: 320000.0, free_length: 0.63065625}
          damper: {type: bilinear, compression: 12000.0, rebound: 24000.0}
      range: [-0.2, 0.2]
  - name: rear
    position: [-1.5, 0.0, 0.0]
    driven: true
    unsprung_mass: 50.0
    spin_inertia: 2.0
    brake_torque: 3000.0
    suspension:
      linkage: {type: torsion_arm, spindle: [0.0, 0.7, 0.0], pivot: [0.5, 0.7, 0.0], axis: [0.0, 1.0, 0.0]}
      struts:
        - chassis: [0.25, 0.7, 0.6]
          end: [0.25, 0.7, 0.0]
          part: arm
          spring: {type: linear, stiffness: 320000.0, free_length: 0.63065625}
          damper: {type: bilinear, compression: 12000.0, rebound: 24000.0}
      range: [-0.2, 0.2]
steering: {rate: 1.0}
tyre:
  model: brush
  radius: 0.4
  width: 0.2
  friction: 0.9
  vertical_stiffness: 200000.0
  vertical_damping: 1000.0
  slip_stiffness: [10.0, 8.0]
  relaxation_length: [0.2, 0.4]
  damping_ratio: 0.25
  rolling_resistance: 0.015
powertrain:
  engine: {type: simple, torque: 200.0, power: 50000.0, max_speed: 400.0}
  gearbox: {ratios: [0.2], shift_down: [0.0], shift_up: [1000.0]}
  driveline:
    shaft_inertia: 0.5
    centre: {type: open}
    axles:
      - {share: 0.5, final_drive: 0.25, shaft_inertia: 0.1, box_inertia: 0.1, differential: {type: open}}
      - {share: 0.5, final_drive: 0.25, shaft_inertia: 0.1, box_inertia: 0.1, differential: {type: open}}
";

fn simple(changes: &[(&str, &str)]) -> VehicleSpec {
    let mut text = SIMPLE.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    // Without the checks of files: nothing steers it.
    vb_files::yaml::parse(&text).unwrap()
}

fn of(spec: &VehicleSpec) -> Characteristics {
    Bench::new(spec, &[], 1e-3).unwrap().characteristics()
}

fn close(value: f64, expected: f64, fraction: f64) {
    assert!((value / expected - 1.0).abs() < fraction, "{value} is not {expected}");
}

/// Load of a wheel (550 kg) over the tyre's stiffness below the radius: the height of hubs and belly.
const HUB: f64 = 0.4 - 550.0 * GRAVITY / 200_000.0;
/// A quarter of 320 kN/m, by the square of the motion ratio.
const WHEEL_RATE: f64 = 80_000.0;
const SERIES: f64 = WHEEL_RATE * 200_000.0 / (WHEEL_RATE + 200_000.0);

#[test]
fn rates_frequencies_and_damping_are_those_of_a_mass_on_a_lever() {
    for axle in of(&simple(&[])).axles {
        let ride = axle.ride.unwrap();
        close(ride.motion_ratio.unwrap(), 0.5, 1e-3);
        close(ride.sprung_mass_kg, 500.0, 2e-3);
        close(ride.wheel_rate_n_per_m, WHEEL_RATE, 2e-3);
        close(ride.ride_frequency_hz, (WHEEL_RATE / 500.0).sqrt() / (2.0 * PI), 2e-3);
        close(ride.frequency_with_tyre_hz, (SERIES / 500.0).sqrt() / (2.0 * PI), 2e-3);
        let critical = 2.0 * (WHEEL_RATE * 500.0).sqrt();
        close(ride.damping_ratio[0], 0.25 * 12_000.0 / critical, 3e-3);
        close(ride.damping_ratio[1], 0.25 * 24_000.0 / critical, 3e-3);
        assert!(axle.roll_centre_height_m.abs() < 1e-3, "trailing arms roll about the ground");
    }
}

#[test]
fn the_body_rolls_as_a_pendulum_on_springs_and_tyres_in_series() {
    let (weight, height) = (2000.0 * GRAVITY, 0.5 + HUB);
    let stiffness = 2.0 * 0.5 * SERIES * 1.4 * 1.4;
    // Of the moment of the wheels, the tyres' roll hands on the series' part.
    let wheels = 200.0 * GRAVITY * HUB * SERIES / 200_000.0;
    let expected = degrees((weight * height + wheels) / (stiffness - weight * height));
    close(of(&simple(&[])).roll_gradient_deg_per_g.unwrap(), expected, 5e-3);
}

#[test]
fn a_wheel_lifts_when_twist_has_taken_its_load() {
    let c = of(&simple(&[]));
    // Blocks of height h under two wheels twist the ground by h/2 at each wheel.
    let diagonal = 2.0 * 0.99 * 550.0 * GRAVITY / SERIES;
    close(c.diagonal_articulation_m.unwrap(), diagonal, 0.02);
    // Under one wheel alone the body leans as well, and its weight with it.
    let one = c.articulation_m.unwrap();
    assert!(one > 1.3 * diagonal && one < 2.0 * diagonal, "{one} {diagonal}");
}

#[test]
fn ramps_touch_tyres_and_the_corners_of_the_hull_and_crests_the_middle_of_its_belly() {
    let c = of(&simple(&[]));
    close(c.ground_clearance_m.unwrap(), HUB, 5e-3);
    // The lower corners are as high as the hubs, 0.5 m in front of them: sin of the angle is the loaded radius over that.
    let corner = degrees(asin(HUB / 0.5));
    close(c.approach_angle_deg, corner, 5e-3);
    close(c.departure_angle_deg, corner, 5e-3);
    close(c.break_over_angle_deg.unwrap(), 2.0 * degrees(asin(HUB / 1.5)), 5e-3);
    assert_eq!(c.outer_front_wheel_radius_m, None, "nothing steers it");
    let high = simple(&[("[2.0, 0.6, 0.0], [2.0, -0.6, 0.0]", "[1.2, 0.6, 0.0], [1.2, -0.6, 0.0]")]);
    assert!(of(&high).approach_angle_deg > corner + 20.0);
}

#[test]
fn each_defect_of_a_heavy_vehicle_has_its_warning_and_a_sound_or_light_one_has_none() {
    let warned = |changes: &[(&str, &str)]| of(&simple(changes)).warnings().join("\n");
    assert_eq!(warned(&[]), "");
    let stiff =
        ("stiffness: 320000.0, free_length: 0.63065625", "stiffness: 640000.0, free_length: 0.615328125");
    let e = warned(&[stiff]);
    assert!(e.contains("axles[0].suspension: axle front has a ride frequency of 2.85 Hz"), "{e}");
    assert!(e.contains("axles[1]") && !e.contains("damping") && !e.contains("roll gradient"), "{e}");
    let e = warned(&[("compression: 12000.0, rebound: 24000.0", "compression: 40000.0, rebound: 48000.0")]);
    assert!(
        e.contains("damping ratio of 0.87 (0.79 in jounce, 0.95 in rebound)") && !e.contains("frequency"),
        "{e}"
    );
    let e = warned(&[("com: [0.0, 0.0, 0.5]", "com: [0.0, 0.0, -0.2]")]);
    assert!(e.starts_with("axles: the roll gradient is 1.") && !e.contains('\n'), "{e}");
    let bar = (
        "      range: [-0.2, 0.2]",
        "      range: [-0.2, 0.2]\n      anti_roll: {type: travel, stiffness: 60000.0}",
    );
    let e = warned(&[bar]);
    assert!(e.contains("a wheel lifts when the terrain under one front wheel is 0."), "{e}");
    let light = [
        ("mass: 2000.0", "mass: 200.0"),
        ("inertia: [500.0, 2000.0, 2200.0]", "inertia: [50.0, 200.0, 220.0]"),
        stiff,
    ];
    assert_eq!(warned(&light), "", "480 kg");
}

#[test]
fn the_released_vehicle_has_the_defects_of_its_reduced_suspension() {
    let text = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");
    let released = VehicleSpec::parse(text, "hmmwv-released.yaml").unwrap();
    let c = of(&released);
    // Chrono's HMMWV_DoubleWishboneReduced: struts at the uprights with the rates of the real coils.
    let warnings = c.warnings().join("\n");
    for words in [
        "axle front has a ride frequency",
        "axle rear has a ride frequency",
        "axle front has a damping ratio",
        "roll gradient",
    ] {
        assert!(warnings.contains(words), "{words}: {warnings}");
    }
    let front = c.axles[0].ride.unwrap();
    close(front.motion_ratio.unwrap(), 0.96, 0.02);
    // The outer wheel of a rack without Ackermann turns by 22.2°; no slip, the inner by 21.2°.
    let rear = 3.302 / tan(0.5 * (21.2_f64 + 22.2).to_radians());
    close(c.outer_front_wheel_radius_m.unwrap(), hypot(rear + 0.91, 3.302), 0.02);
}
