//! What is said where there is no fleet to be had.

use std::path::Path;

use vb_gpu::{Fleet, GpuError, Options, Place, Setting, Start};
use vb_sim::{SimOptions, SoilSet};
use vb_vehicle::VehicleSpec;
use vb_world::{Heightfield, Pose2, TerrainClass, World};

fn fleet(kernel: &str, vehicles: usize) -> Result<Fleet, GpuError> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tasks/vehicles/hmmwv.yaml");
    let world = World::uniform("w", Heightfield::flat(9, 9, 1.0, 0.0), TerrainClass::Concrete, 0.6);
    let setting = Setting {
        vehicle: VehicleSpec::load(file.as_ref()).expect("it is valid"),
        soils: SoilSet::default(),
        options: SimOptions::default(),
        worlds: vec![Place::from(&world)],
    };
    let start = Start { world: 0, pose: Pose2 { x: 0.0, y: 0.0, yaw: 0.0 } };
    Fleet::new(Path::new(kernel), &setting, &[start], vehicles, Options::default())
}

fn message(fleet: Result<Fleet, GpuError>) -> String {
    fleet.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn a_fleet_of_nothing_is_none() {
    assert!(message(fleet("kernel.cubin", 0)).contains("at least one vehicle"));
}

#[test]
fn without_a_gpu_the_driver_is_asked_for() {
    if vb_gpu::is_there() {
        vb_testing::skip("there is a GPU's driver here");
        return;
    }
    assert!(message(fleet("kernel.cubin", 1)).contains("libcuda, is not installed"));
}

#[test]
fn with_a_gpu_a_missing_kernel_is_named_with_what_makes_it() {
    if !vb_gpu::is_there() {
        vb_testing::skip("there is no GPU here");
        return;
    }
    let message = message(fleet("no/kernel.cubin", 1));
    assert!(message.contains("no/kernel.cubin") && message.contains("cargo xtask kernel"), "{message}");
}
