//! Momentum, energy and weight of a bed, and that it is a function of its inputs.

use vb_granular::rig::balance;
use vb_granular::{Bed, Bin, GRAVITY, MaterialFile, Motion, Packing, Settings, Shape, Tool};
use vb_world::GranularMaterial;

type V3 = nalgebra::Vector3<f64>;
type Quat = nalgebra::UnitQuaternion<f64>;

const BIN: Bin = Bin { length: 0.6, width: 0.6, depth: 0.3 };

fn material(name: &str) -> GranularMaterial {
    MaterialFile::resolve(name).expect("a material that comes with the crate").grains
}

fn sand() -> GranularMaterial {
    GranularMaterial { cohesion: 500.0, ..material("sand") }
}

fn wheel() -> Tool {
    let shape = Shape::Wheel { radius: 0.15, width: 0.12, shoulder: 0.03 };
    Tool { shape, friction: 0.7, stiffness: 2e5 }
}

/// A wheel that turns in its place.
fn turning(z: f64) -> Motion {
    Motion {
        position: V3::new(0.05, -0.03, z),
        rotation: Quat::from_axis_angle(&V3::x_axis(), 0.2),
        velocity: V3::zeros(),
        spin: V3::new(0.5, 4.0, -1.0),
    }
}

#[test]
fn a_bed_keeps_momentum_never_gains_energy_and_bears_its_weight() {
    for material in [material("gravel"), sand()] {
        let b = balance(&material, 3).unwrap();
        assert!(b.momentum < 1e-9 && b.angular_momentum < 1e-9, "{b:?}");
        // The integration's own error: symplectic Euler oscillates about the exact energy by a fraction of it.
        assert!(b.energy_gain < 1e-4 && b.energy_left < 0.98 && b.energy_kinetic < 1e-5, "{b:?}");
        assert!((b.floor_load - 1.0).abs() < 0.01, "{b:?}");
    }
}

#[test]
fn equal_inputs_give_equal_bits_and_a_clone_goes_on_as_its_original() {
    let run = || {
        let packing = Packing::poured(&sand(), BIN, 3).unwrap();
        let settings = Settings { reach: 0.2, ..Settings::default() };
        let mut bed = Bed::new(&packing, &sand(), vec![wheel()], settings);
        let mut end = Vec::new();
        for _ in 0..100 {
            end = bed.step(&[turning(0.42)]).to_vec();
        }
        (bed, end)
    };
    let bits = |bed: &Bed| -> Vec<u64> {
        bed.grains().flat_map(|g| [g.position.x, g.position.y, g.position.z]).map(f64::to_bits).collect()
    };
    let ((mut first, reaction), (second, again)) = (run(), run());
    assert_eq!(reaction, again);
    assert_eq!(bits(&first), bits(&second));
    let mut clone = first.clone();
    for bed in [&mut first, &mut clone] {
        for _ in 0..50 {
            bed.step(&[turning(0.38)]);
        }
    }
    assert_eq!(bits(&first), bits(&clone));
}

#[test]
fn grains_far_from_the_tools_lie_still_without_a_difference_to_the_tools() {
    let gravel = material("gravel");
    let bin = Bin { length: 2.4, width: 0.5, depth: 0.3 };
    let packing = Packing::poured(&gravel, bin, 1).unwrap();
    let drive = |reach: f64| {
        let mut bed = Bed::new(&packing, &gravel, vec![wheel()], Settings { reach, ..Settings::default() });
        let mut impulse = 0.0;
        for step in 0..600 {
            let x = 0.5e-3 * f64::from(step);
            let motion = Motion {
                position: V3::new(x, 0.0, 0.41),
                rotation: Quat::identity(),
                velocity: V3::new(0.5, 0.0, 0.0),
                spin: V3::new(0.0, 3.0, 0.0),
            };
            impulse += bed.step(&[motion])[0].impulse.z;
        }
        (impulse, bed.moving())
    };
    let ((all, moving), (near, few)) = (drive(f64::INFINITY), drive(0.4));
    assert_eq!(moving, packing.grains.len());
    assert!(2 * few < moving, "{few} of {moving} move");
    assert!((near / all - 1.0).abs() < 0.03, "{near} {all}");
}

#[test]
fn a_large_bin_of_tiles_has_no_seams() {
    let gravel = material("gravel");
    let bin = Bin { length: 3.3, width: 2.2, depth: 0.25 };
    let packing = Packing::tiled(&gravel, bin, 5, Settings::default()).unwrap();
    // No walls either within: as dense in strips about the seams (of three tiles along x) as everywhere.
    let volume = |low: f64, high: f64| -> f64 {
        let within = |g: &&vb_granular::Grain| g.position.x >= low && g.position.x < high;
        packing.grains.iter().filter(within).map(|g| g.radius * g.radius * g.radius).sum::<f64>()
            / (high - low)
    };
    let whole = volume(-1.5, 1.5);
    for seam in [-0.55, 0.55] {
        let there = volume(seam - 0.12, seam + 0.12) / whole;
        assert!((there - 1.0).abs() < 0.1, "{there}");
    }
    // Grains of neighbouring tiles neither overlap more than those of one nor leave a gap.
    let mut bed = Bed::new(&packing, &gravel, Vec::new(), Settings::default());
    bed.step(&[]);
    let first = bed.elastic_energy();
    let weight = bed.mass() * GRAVITY;
    for _ in 0..300 {
        bed.step(&[]);
    }
    let fallen = bed.potential_energy();
    let start: f64 = packing.grains.iter().map(|g| gravel.mass(g.radius) * GRAVITY * g.position.z).sum();
    assert!((start - fallen) / weight < 1e-3, "the bed sinks by {} m", (start - fallen) / weight);
    assert!(first < weight * 1e-3, "{first} J");
}

#[test]
fn a_bin_of_as_many_grains_as_a_world_may_have_is_filled() {
    let gravel = material("gravel");
    // 190 000 grains, of which the least that a bin is struck off at would be more than the maximum.
    let depth = 0.5;
    let area = 190_000.0 * gravel.mean_volume() / (0.64 * depth);
    let bin = Bin { length: area.sqrt(), width: area.sqrt(), depth };
    let packing = Packing::tiled(&gravel, bin, 5, Settings::default()).unwrap();
    assert!(packing.grains.len() > 150_000, "{}", packing.grains.len());
}
