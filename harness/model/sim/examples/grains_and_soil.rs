//! A rigid wheel on a bed of grains, and on deformable soil whose pressure is fitted to a plate on the same bed: docs/granular.md.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use vb_granular::rig::{Wheel, angle_of_repose, bekker, plate};
use vb_granular::{Bin, MaterialFile, Packing, PackingError, Settings};
use vb_sim::soil::{Bekker, PressureDirection, Shear, Sinkage, SlipSinkage, SoilLaw, WheelRig};

fn main() -> Result<(), PackingError> {
    for name in ["gravel", "sand"] {
        let material = MaterialFile::resolve(name).expect("a material that comes with the crate").grains;
        let r = material.mean_radius();
        let deep = Bin { length: 36.0 * r, width: 36.0 * r, depth: 16.0 * r };
        let pressures = plate(&Packing::poured(&material, deep, 1)?, &material, 8.0 * r, 0.2, 3.0 * r);
        let (k, n, _) = bekker(&pressures[1..]);
        let law = SoilLaw {
            sinkage: Sinkage::Bekker(Bekker { k_phi: k, k_c: 0.0, exponent: n }),
            slip_sinkage: SlipSinkage::None,
            cohesion: 0.0,
            friction_angle_deg: angle_of_repose(&material, 1)?.to_degrees(),
            shear: Shear::default(),
            // Loose sand: Wong, Theory of Ground Vehicles, 2008, chapter 2.
            shear_modulus: 0.025,
            elastic_stiffness: 1e8,
            damping: 3e3,
            pressure: PressureDirection::Radial,
            steel_friction: None,
            bulldozing: None,
        };
        let (radius, width, load, speed) = (0.47, 0.26, 6000.0, 0.5);
        let rig = WheelRig { radius, width, load, speed, step: 1e-3, resolution: 0.1 };
        let wheel = Wheel { radius, width, load, friction: 0.8, speed };
        let settings = Settings { reach: 0.4, ..Settings::default() };
        let bin = Bin { length: 2.6, width: 0.9, depth: 10.0 * r };
        let packing = Packing::poured(&material, bin, 1)?;
        println!("{name}: k {k:.3e} Pa/m^n, n {n:.2}, friction angle {:.0}°", law.friction_angle_deg);
        for slip in [0.05, 0.1, 0.2, 0.4] {
            let grains = wheel.drive(&packing, &material, slip, settings);
            let soil = rig.run(&law, slip, 1);
            println!(
                "  slip {slip:4.2}: pull / load {:.2} and {:.2}, sinkage {:.3} and {:.3} m",
                grains.pull,
                soil.drawbar / load,
                grains.sinkage,
                soil.sinkage
            );
        }
    }
    Ok(())
}
