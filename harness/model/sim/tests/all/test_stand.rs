//! What test stands need: putting the vehicle in the air and tilting gravity.

use crate::common::{controls, flat, start};
use nalgebra::Vector3;

#[test]
fn a_lifted_vehicle_is_level_at_rest_at_its_height_and_falls_freely() {
    let mut sim = start(&flat(0.9), 3.0, -2.0, 0.7);
    let before = sim.state();
    sim.rig().lift(4.0);
    let s = sim.state();
    let (roll, pitch, yaw) = s.roll_pitch_yaw();
    assert!(roll.abs() < 1e-12 && pitch.abs() < 1e-12, "{roll} {pitch}");
    assert!((yaw - before.roll_pitch_yaw().2).abs() < 1e-9, "it keeps its heading");
    assert!((s.position.z - 4.0).abs() < 1e-12, "{}", s.position.z);
    assert!(s.velocity_body.norm() == 0.0 && s.wheels.iter().all(|w| w.deflection == 0.0 && w.load == 0.0));
    // ½ g t² after 0.5 s: 1.226 m, less what the wheels take up as their springs relax.
    sim.advance(controls(0.0, 0.0, 0.0), 500).unwrap();
    let fallen = 4.0 - sim.state().position.z;
    assert!((fallen - 0.5 * 9.81 * 0.25).abs() < 0.03, "{fallen} m");
}

#[test]
fn tilted_gravity_acts_as_a_slope_does() {
    // atan 0.5 = 26.57 deg: it holds at 25 and slides at 28.
    for (degrees, slides) in [(25.0_f64, false), (28.0, true)] {
        let mut sim = start(&flat(0.5), 0.0, 0.0, 0.0);
        let angle = degrees.to_radians();
        for k in 1..=2000 {
            let (s, c) = vb_math::sin_cos(angle * f64::from(k) / 2000.0);
            sim.rig().set_gravity([0.0, 9.81 * s, -9.81 * c]);
            sim.advance(controls(0.0, 0.0, 1.0), 1).unwrap();
        }
        sim.advance(controls(0.0, 0.0, 1.0), 2000).unwrap();
        let from: Vector3<f64> = sim.state().position;
        sim.advance(controls(0.0, 0.0, 1.0), 3000).unwrap();
        let moved = (sim.state().position - from).y;
        assert_eq!(moved > 0.5, slides, "{degrees} deg: {moved} m");
        // The body may still sway back by some millimetres.
        assert!(slides || moved.abs() < 0.02, "{degrees} deg: {moved} m");
    }
}
