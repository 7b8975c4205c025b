//! The figures of docs/granular.md.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use vb_granular::rig::{Traction, Wheel, angle_of_repose, bekker, plate};
use vb_granular::{Bin, MaterialFile, Packing, PackingError, Settings};
use vb_world::GranularMaterial;

fn main() -> Result<(), PackingError> {
    for name in ["gravel", "sand"] {
        let material = MaterialFile::resolve(name).expect("a material that comes with the crate").grains;
        let r = material.mean_radius();
        let deep = Bin { length: 36.0 * r, width: 36.0 * r, depth: 16.0 * r };
        let packing = Packing::poured(&material, deep, 1)?;
        println!("{name}: {} grains fill {:.3}", packing.grains.len(), packing.fraction_below(12.0 * r));
        let mut angles = [0.0; 3];
        for (seed, angle) in (1..).zip(&mut angles) {
            *angle = angle_of_repose(&material, seed)?.to_degrees();
        }
        println!("  angle of repose {:.1}°, three heaps {angles:.1?}", angles.iter().sum::<f64>() / 3.0);
        let pressures = plate(&packing, &material, 8.0 * r, 0.2, 3.0 * r);
        let (k, n, r2) = bekker(&pressures[1..]);
        println!("  plate {:.2} m wide: k {k:.3e} Pa/m^n, n {n:.2}, R² {r2:.3}", 8.0 * r);

        let wheel = Wheel { radius: 0.47, width: 0.26, load: 6000.0, friction: 0.8, speed: 1.0 };
        let settings = Settings { reach: 0.3, ..Settings::default() };
        let show = |what: &str, [t, error]: [Traction; 2]| {
            println!(
                "  {what}: pull {:.2} ± {:.2}, gross {:.2} ± {:.2}, sinkage {:.3} ± {:.3} m",
                t.pull, error.pull, t.gross, error.gross, t.sinkage, error.sinkage
            );
        };
        for slip in [-0.05, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8] {
            show(&format!("slip {slip:5.2}"), wheel.mean(&material, slip, settings)?);
        }
        let finer = GranularMaterial { radius: material.radius.map(|r| 0.75 * r), ..material.clone() };
        for (what, material, settings) in [
            ("half the step", &material, Settings { step: 0.5 * settings.step, ..settings }),
            ("twice the stiffness", &material, Settings { stiffness: 2.0 * settings.stiffness, ..settings }),
            ("grains of 3/4 the size", &finer, settings),
        ] {
            show(&format!("slip 0.20, {what}"), wheel.mean(material, 0.2, settings)?);
        }
    }
    Ok(())
}
