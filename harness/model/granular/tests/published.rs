//! Beds against published figures, on small beds; `cargo run --release -p vb-granular --example published` has larger ones.

use vb_granular::rig::{Wheel, angle_of_repose, bekker, plate};
use vb_granular::{Bin, MaterialFile, Packing, Settings};
use vb_world::GranularMaterial;

fn material(name: &str) -> GranularMaterial {
    MaterialFile::resolve(name).expect("a material that comes with the crate").grains
}

/// Random packings of spheres: loose 0.55 (Jerkins et al., Phys. Rev. Lett. 101, 018301, 2008), close 0.64 (Scott and Kilgour,
/// J. Phys. D 2, 863, 1969). Walls make them looser, here by about 0.02.
#[test]
fn poured_grains_fill_as_much_as_random_packings() {
    for (name, side) in [("gravel", 1.0), ("sand", 0.7)] {
        let bin = Bin { length: side, width: side, depth: 0.4 * side };
        let packing = Packing::poured(&material(name), bin, 1).unwrap();
        let fraction = packing.fraction_below(0.3 * side);
        assert!((0.53..0.64).contains(&fraction), "{name}: {} grains fill {fraction}", packing.grains.len());
    }
}

/// Dry sand 34° (Glover, Pocket Ref, 1995); heaps of so few grains vary by 3°.
#[test]
fn a_heap_of_sand_has_the_slope_of_sand() {
    let angle = angle_of_repose(&material("sand"), 1).unwrap().to_degrees();
    assert!((30.0..38.0).contains(&angle), "{angle}°");
}

/// Bekker's p = k zⁿ, as measured under plates on sand and gravel.
#[test]
fn pressure_over_sinkage_follows_a_power_law() {
    let gravel = material("gravel");
    let packing = Packing::poured(&gravel, Bin { length: 0.9, width: 0.9, depth: 0.36 }, 1).unwrap();
    let (_, exponent, r2) = bekker(&plate(&packing, &gravel, 0.3, 0.4, 0.12)[1..]);
    assert!(r2 > 0.95 && (0.7..2.0).contains(&exponent), "n {exponent}, R² {r2}");
}

/// A driven wheel pulls most between 15 and 40 % of slip, a towed one is a resistance, and slip makes it sink (Wong, Theory of Ground
/// Vehicles, 4th ed. 2008, ch. 4). Gross traction is at most the 0.6 of tyres on gravel (ibid., table 1.3).
#[test]
fn a_wheel_pulls_most_at_the_slip_at_which_wheels_do() {
    let gravel = material("gravel");
    let packing = Packing::poured(&gravel, Bin { length: 2.0, width: 0.7, depth: 0.3 }, 1).unwrap();
    let wheel = Wheel { radius: 0.47, width: 0.26, load: 6000.0, friction: 0.8, speed: 1.0 };
    let settings = Settings { reach: 0.3, ..Settings::default() };
    let [towed, slow, most, fast] =
        [-0.1, 0.05, 0.3, 0.7].map(|slip| wheel.drive(&packing, &gravel, slip, settings));
    assert!(towed.pull < 0.0, "{towed:?}");
    assert!(most.pull > slow.pull && most.pull > fast.pull, "{slow:?} {most:?} {fast:?}");
    assert!(fast.sinkage > slow.sinkage, "{slow:?} {fast:?}");
    assert!((0.3..0.6).contains(&most.gross), "{most:?}");
}
