//! A rigid wheel and the HMMWV on a bed of grains, and on deformable soil whose pressure is fitted to a plate on the same bed:
//! docs/granular.md.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::sync::Arc;
use vb_granular::rig::{Wheel, angle_of_repose, bekker, plate};
use vb_granular::{Bin, MaterialFile, Packing, Settings};
use vb_sim::soil::{Bekker, PressureDirection, Shear, Sinkage, SlipSinkage, SoilLaw, WheelRig};
use vb_sim::{Controls, Gear, SimError, SimOptions, Simulation, SoilSet};
use vb_vehicle::{GRAVITY, VehicleModel, VehicleSpec};
use vb_world::{
    GranularBed, GranularMaterial, Heightfield, Pose2, Semantics, SoilLevels, TerrainClass, World,
};

type Failure = Box<dyn std::error::Error>;

/// Length, width and depth of the bed that the vehicle crosses, m.
const CROSSED: [f64; 3] = [12.0, 4.0, 0.3];
/// Pulls on the vehicle against its way, over its weight.
const PULLS: [f64; 7] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6];

/// Level ground of `class` with a bed where there is a material, m.
fn ground(class: TerrainClass, material: Option<&GranularMaterial>) -> World {
    let [length, width, depth] = CROSSED;
    let (rows, cols) = (32, 64);
    let flat = World::uniform("level", Heightfield::flat(17, 33, 1.0, 0.0), class, 0.9);
    let Some(material) = material else { return flat };
    let bed = GranularBed {
        name: "bed".into(),
        material: material.clone(),
        x: 0.0,
        y: 0.0,
        length,
        width,
        depth,
        seed: 1,
    };
    let within = |k: usize| bed.contains((k % cols) as f64 * 0.5 - 15.75, (k / cols) as f64 * 0.5 - 7.75);
    let classes: Vec<_> = (0..rows * cols).map(|k| if within(k) { material.class } else { class }).collect();
    let friction = classes.iter().map(|c| if c.is_deformable() { 0.0 } else { 0.9 }).collect();
    let semantics = Semantics { rows, cols, patch: 0.5, classes, friction, soil: SoilLevels::default() };
    World { semantics, beds: vec![bed], ..flat }
}

/// Distance (m) that the HMMWV covers in 6 s or up to 3 m, at full throttle from rest, against a constant force on its centre of mass
/// (`pull`, relative to its weight), and the mean over time of its maximum wheel sinkage (m).
fn pull(world: &Arc<World>, soils: &SoilSet, pull: f64) -> Result<[f64; 2], SimError> {
    let file = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
    let model = VehicleModel::new(VehicleSpec::parse(file, "hmmwv.yaml").expect("a shipped vehicle"))?;
    let start = Pose2 { x: -2.5, y: 0.0, yaw: 0.0 };
    let mut sim = Simulation::new(world.clone(), &model, soils, start, SimOptions::default())?;
    // Gravity acts on the vehicle only: its part along x is a force on its centre of mass.
    sim.rig().set_gravity([-pull * GRAVITY, 0.0, -GRAVITY]);
    let controls = Controls { throttle: 1.0, steering: 0.0, brake: 0.0, gear: Gear::Forward };
    let from = sim.state().position.x;
    let (mut sinkage, mut steps) = (0.0, 0.0);
    while sim.time() < 6.0 && sim.state().position.x < from + 3.0 && sim.state().position.x > from - 2.0 {
        sim.advance(controls, 1)?;
        sinkage += sim.state().wheels.iter().map(|w| w.sinkage).fold(0.0, f64::max);
        steps += 1.0;
    }
    Ok([sim.state().position.x - from, sinkage / steps])
}

fn main() -> Result<(), Failure> {
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
        let (radius, width, load, speed) = (0.47, 0.26, 6000.0, 1.0);
        let rig = WheelRig { radius, width, load, speed, step: 1e-3, resolution: 0.1 };
        let wheel = Wheel { radius, width, load, friction: 0.8, speed };
        let settings = Settings { reach: 0.3, ..Settings::default() };
        println!("{name}: k {k:.3e} Pa/m^n, n {n:.2}, friction angle {:.0}°", law.friction_angle_deg);
        for slip in [0.05, 0.1, 0.2, 0.4] {
            let [grains, _] = wheel.mean(&material, slip, settings)?;
            let soil = rig.run(&law, slip, 1);
            println!(
                "  slip {slip:4.2}: pull / load {:.2} and {:.2}, sinkage {:.3} and {:.3} m",
                grains.pull,
                soil.drawbar / load,
                grains.sinkage,
                soil.sinkage
            );
        }

        let mut soils = SoilSet::parse(include_str!("../../../../tasks/soils/default.yaml"), "default.yaml")?;
        soils.soils.values_mut().for_each(|soil| *soil = law);
        let beds = Arc::new(ground(TerrainClass::Concrete, Some(&material)));
        let soft = Arc::new(ground(TerrainClass::Sand, None));
        for force in PULLS {
            let [grains, soil] = [pull(&beds, &soils, force)?, pull(&soft, &soils, force)?];
            println!(
                "  pulled back by {force:3.1} of its weight: {:5.2} and {:5.2} m, sinkage {:.3} and {:.3} m",
                grains[0], soil[0], grains[1], soil[1]
            );
        }
    }
    Ok(())
}
