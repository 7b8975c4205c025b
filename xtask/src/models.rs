//! The models of the hybrid planners, made again: exploration of training worlds, and training on it.

use std::process::Command;

use crate::run::{Failure, cargo, run, step};
use crate::{build_harness, built, root, target_dir};

/// A model: the vehicle, the hours of exploration, its seed, the seed of its worlds, and the steps of training.
struct Model {
    vehicle: &'static str,
    hours: &'static str,
    seed: &'static str,
    world_seed: &'static str,
    steps: &'static str,
}

/// All models that planners have.
const MODELS: [Model; 1] =
    [Model { vehicle: "hmmwv", hours: "10", seed: "11", world_seed: "7200", steps: "5000" }];

/// Makes all models again, and writes them with their cards where the planners have them. Exploration that is there is not
/// repeated.
pub(crate) fn models() -> Result<(), Failure> {
    build_harness()?;
    cargo(&["build", "--release", "--package", "vb-model-train"])?;
    for m in MODELS {
        let data = target_dir().join("models").join(m.vehicle);
        if !data.join("SHA256SUMS").is_file() {
            step(&format!("exploring with the {} for {} h", m.vehicle, m.hours));
            let mut explore = Command::new(built("vb-harness"));
            explore.args(["dataset", "explore", "--vehicle", m.vehicle, "--hours", m.hours]);
            explore.args(["--seed", m.seed, "--world-seed", m.world_seed, "--resume", "--out"]).arg(&data);
            run(&mut explore)?;
        }
        step(&format!("training the model of the {}", m.vehicle));
        let mut train = Command::new(built("vb-model-train"));
        train.arg("--data").arg(&data).args(["--steps", m.steps, "--vehicle"]);
        train.arg(root().join(format!("tasks/vehicles/{}.yaml", m.vehicle)));
        train.arg("--out").arg(root().join(format!("plugins/hybrid/weights/{}.vbnn", m.vehicle)));
        run(&mut train)?;
    }
    Ok(())
}
