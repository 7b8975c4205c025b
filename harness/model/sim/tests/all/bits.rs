//! The simulator computes the same bits in whatever profile it is built: this file is a part of two test programs, one with
//! overflow checks and little optimisation (`vb-sim`'s own), one in release (`vb-tests`).

use std::path::Path;
use std::sync::Arc;

use vb_sim::{Controls, SimOptions, Simulation, SoilSet};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::Suite;

/// A vehicle, a world of `tasks/smoke`, and what the drive left. A snapshot: it changes with the simulator, and with nothing else.
const DRIVES: [(&str, &str, u64); 12] = [
    ("hmmwv", "w001", 0xd746_46e1_b491_0cb6),
    ("hmmwv", "w003", 0x0ce1_d607_e0e3_fe3c),
    ("hmmwv-released", "w006", 0xda48_aee5_227e_3acf),
    ("gator", "w002", 0x958c_5ff1_1fa1_0b94),
    ("feda", "w005", 0x8251_7638_246a_0350),
    ("m113", "w003", 0x2910_4866_08da_9f81),
    ("m113", "w007", 0xdf27_b75a_a221_72ea),
    ("man5t", "w004", 0xf085_354a_68e7_3ed1),
    ("man7t", "w008", 0xb3ce_248a_04c6_6656),
    ("man10t", "w009", 0x0b7b_d02c_a902_c7bc),
    ("artcar", "w010", 0xb1e6_c22a_5c25_4625),
    ("verti4wheeler", "w003", 0xd583_f79c_1a7f_1a47),
];

#[test]
fn every_build_of_the_simulator_computes_the_same_bits() {
    let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|p| p.join("tasks/released.yaml"));
    let tasks = tasks.filter(|p| p.is_file()).map(|p| p.parent().unwrap().to_owned()).next().unwrap();
    let suite = Suite::open(tasks.join("smoke")).unwrap();
    let soils = SoilSet::load(&tasks.join("soils/default.yaml")).unwrap();
    let mut found = Vec::new();
    for (vehicle, id, _) in DRIVES {
        let spec = VehicleSpec::load(&tasks.join(format!("vehicles/{vehicle}.yaml"))).unwrap();
        let world = suite.load_world(id).unwrap().scaled(spec.scale);
        let start = world.tasks[0].start;
        let model = VehicleModel::new(spec).unwrap();
        let mut drive =
            Simulation::new(Arc::new(world), &model, &soils, start, SimOptions::default()).unwrap();
        // FNV-1a over 64-bit words, rotated since its prime leaves their upper bits poorly spread.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for step in 0..300 {
            let steering = f64::from(step % 100) / 100.0 - 0.5;
            let controls = if step < 250 {
                Controls { steering, throttle: 0.7, ..Controls::default() }
            } else {
                Controls { steering, brake: 0.6, ..Controls::default() }
            };
            drive.advance(controls, 10).unwrap();
            drive.visit_state(|x| {
                hash = (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
            });
        }
        found.push((vehicle, id, hash));
    }
    let text = |drives: &[(&str, &str, u64)]| -> Vec<String> {
        drives
            .iter()
            .map(|(vehicle, world, hash)| format!("(\"{vehicle}\", \"{world}\", {hash:#x}),"))
            .collect()
    };
    assert_eq!(text(&found), text(&DRIVES));
}
