//! Whole vehicles on other suspensions than the shipped one's.

use vb_sim::{SimOptions, Simulation, SoilSet};
use vb_vehicle::{
    VehicleSpec,
    kinematics::{AxleKinematics, Motion, Side},
    suspension::{
        Beam, Damper, KnuckleDrive, Knuckles, Linkage, Part, Rod, SolidAxle, Spring, SteeringGear, Strut,
    },
};
use vb_world::{Heightfield, Pose2};

/// The HMMWV on two solid axles, the front one steered by drag link and toe bar. The drag link pulls ahead of the axle:
/// to the left for a left turn.
fn on_beams() -> VehicleSpec {
    let mut spec = crate::common::hmmwv();
    for (i, axle) in spec.axles.iter_mut().enumerate() {
        axle.steering = (i == 0).then_some(SteeringGear::RackAndPinion { travel: -0.08 });
        axle.unsprung_mass = 80.0;
        axle.suspension.linkage = Linkage::SolidAxle(SolidAxle {
            spindle: [0.0, 0.909_701, 0.0],
            beam: Beam { mass: 120.0, inertia: 40.0 },
            links: vec![
                Rod { chassis: [-0.8, 0.4, -0.05], carrier: [0.0, 0.45, -0.1] },
                Rod { chassis: [-0.8, 0.4, 0.2], carrier: [0.0, 0.0, 0.2] },
            ],
            single_links: vec![],
            knuckles: (i == 0).then_some(Knuckles {
                kingpin_lower: [0.02, 0.75, -0.1],
                kingpin_upper: [-0.02, 0.73, 0.1],
                tie_rod: [-0.2, 0.68, 0.0],
                drag_link_inner: [0.2, -0.2, 0.05],
                by: KnuckleDrive::Toebar { drag_link_outer: [0.2, 0.68, 0.05] },
            }),
        });
        axle.suspension.range = [-0.15, 0.15];
        axle.suspension.struts = vec![Strut {
            chassis: [0.0, 0.6, 0.5],
            end: [0.0, 0.7, 0.0],
            part: Part::Beam,
            spring: Some(Spring::Progressive {
                stiffness: 70000.0,
                progression: 100_000.0,
                free_length: 0.58,
            }),
            damper: Some(Damper::Degressive {
                compression: 6000.0,
                compression_degression: 2.0,
                rebound: 10000.0,
                rebound_degression: 3.0,
            }),
            stops: None,
        }];
    }
    spec
}

#[test]
fn a_vehicle_on_solid_axles_drives_over_rough_ground_and_around_a_bend() {
    let n = 129;
    let mut stream = vb_math::rng::Stream::new(5, &["linkages"]);
    let heights = (0..n * n).map(|_| stream.normal(0.0, 0.12)).collect();
    let world = crate::common::world(Heightfield::new(n, n, 1.0, heights), 0.8, vec![]);
    let start = Pose2 { x: -40.0, y: 0.0, yaw: 0.0 };
    let mut sim = Simulation::new(
        world,
        &crate::common::model(on_beams()),
        &SoilSet::default(),
        start,
        SimOptions::default(),
    )
    .expect("it settles");
    for _ in 0..600 {
        let controls = crate::common::hold_speed(&sim, 5.0, 0.3);
        sim.advance(controls, 10).expect("finite");
    }
    let state = sim.state();
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    assert!(roll.abs() < 0.4 && pitch.abs() < 0.4, "on its wheels: {roll} {pitch}");
    assert!(state.velocity_body.x > 3.0, "it drives: {}", state.velocity_body.x);
    assert!(yaw.abs() > 0.3, "it turns: {yaw}");
    // Command positive: to the left, as long as it hasn't come round.
    assert!(state.position.y > 1.0, "to the left: {}", state.position);
}

#[test]
fn samples_for_plots_cover_the_range_and_carry_the_static_load() {
    let mut spec = crate::common::reference_hmmwv();
    spec.axles[1].suspension.range = [-0.16, 0.16];
    let axle = &spec.axles[1];
    let k = AxleKinematics::solve(axle).expect("it closes");
    let samples = k.sample(&axle.suspension, Motion::Parallel, 9, 1);
    assert_eq!(samples.len(), 18);
    assert!(samples.iter().take(9).all(|s| s.side == Side::Left));
    assert!((samples[0].travel + 0.16).abs() < 1e-12 && (samples[8].travel - 0.16).abs() < 1e-12);
    for (l, r) in samples.iter().zip(&samples[9..]) {
        assert!((l.toe + r.toe).abs() < 1e-12 && (l.camber - r.camber).abs() < 1e-12);
        assert!((l.force - r.force).abs() < 1e-6);
    }
    // Linear spring, motion ratio m: force k (L0 − L) m; its rate over travel is k m² but for the change of m.
    let s = &samples[4];
    let ratio = s.motion_ratios[0];
    let force = 369_167.231 * (0.381_762 - s.struts[0]) * ratio;
    assert!((s.force / force - 1.0).abs() < 1e-4, "{} {force}", s.force);
    assert!((s.wheel_rate / (369_167.231 * ratio * ratio) - 1.0).abs() < 0.1, "{}", s.wheel_rate);
    // Roll meets the springs of both wheels alike, and the mean of the preload cancels.
    let roll = k.sample(&axle.suspension, Motion::Opposite, 9, 1);
    assert!(roll[4].force.abs() < 1.0 && (roll[4].wheel_rate / s.wheel_rate - 1.0).abs() < 1e-3);
    // Caster and inclination of the front, from its ball joints.
    let axis = spec.axles[0].suspension.steering_axis().expect("ball joints");
    let (dx, dy, dz) = (-0.053_086 + 0.03556, 0.715_264 - 0.786_384, 0.215_392 + 0.11811);
    assert!((vb_math::tan(axis.caster) + dx / dz).abs() < 1e-9);
    assert!((vb_math::tan(axis.inclination) + dy / dz).abs() < 1e-9);
}
