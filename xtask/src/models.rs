//! The models of the hybrid planners, made again: exploration of training worlds, and training on it.

use std::process::Command;

use crate::run::{Failure, cargo, run, step};
use crate::{built, root, target_dir};

/// What is learned of a vehicle.
struct Models {
    vehicle: &'static str,
    explorations: &'static [Exploration],
    trainings: &'static [Training],
}

/// A dataset of exploration: its frames a second, hours and seed, and the seed and number of its worlds.
struct Exploration {
    hz: &'static str,
    hours: &'static str,
    seed: &'static str,
    world_seed: &'static str,
    worlds: &'static str,
}

/// A model: what of the ground it sees, with which other it begins (the name of its file), for how many steps it is trained, and what
/// its own file has after the vehicle's name.
struct Training {
    sight: &'static str,
    from: Option<&'static str>,
    steps: &'static str,
    file: &'static str,
}

/// All models that planners have. Those of other vehicles begin with the HMMWV's, since lengths and times are in its measure.
const MODELS: [Models; 3] = [
    Models {
        vehicle: "hmmwv",
        explorations: &[
            Exploration { hz: "10", hours: "10", seed: "11", world_seed: "7200", worlds: "90" },
            Exploration { hz: "10", hours: "30", seed: "12", world_seed: "7210", worlds: "180" },
        ],
        trainings: &[
            Training { sight: "patch", from: None, steps: "10000", file: "" },
            Training { sight: "attention", from: Some("hmmwv"), steps: "2000", file: "-attention" },
        ],
    },
    Models {
        vehicle: "man5t",
        explorations: &[Exploration { hz: "10", hours: "10", seed: "13", world_seed: "7220", worlds: "90" }],
        trainings: &[
            Training { sight: "patch", from: Some("hmmwv"), steps: "8000", file: "" },
            Training { sight: "attention", from: Some("man5t"), steps: "2000", file: "-attention" },
        ],
    },
    Models {
        vehicle: "verti4wheeler",
        // As much as 20 h at full scale; three frames make a step.
        explorations: &[Exploration { hz: "50", hours: "6", seed: "14", world_seed: "7230", worlds: "135" }],
        trainings: &[
            Training { sight: "patch", from: Some("hmmwv"), steps: "8000", file: "" },
            Training { sight: "attention", from: Some("verti4wheeler"), steps: "2000", file: "-attention" },
        ],
    },
];

/// Makes all models again, and writes them with their cards where the planners have them. Exploration that is there is not
/// repeated.
pub(crate) fn models() -> Result<(), Failure> {
    step("building the harness and what trains");
    // Together, so that both have the same dependencies.
    cargo(&["build", "--release", "--package", "vb-harness", "--package", "vb-model-train"])?;
    for m in MODELS {
        let explored =
            |e: &Exploration| target_dir().join("models").join(format!("{}-{}", m.vehicle, e.seed));
        for e in m.explorations {
            let data = explored(e);
            if data.join("SHA256SUMS").is_file() {
                continue;
            }
            step(&format!("exploring with the {} for {} h", m.vehicle, e.hours));
            let mut explore = Command::new(built("vb-harness"));
            explore.args([
                "dataset",
                "explore",
                "--vehicle",
                m.vehicle,
                "--hz",
                e.hz,
                "--duration",
                &format!("{}h", e.hours),
                "--seed",
                e.seed,
            ]);
            explore
                .args(["--world-seed", e.world_seed, "--worlds", e.worlds, "--resume", "--out"])
                .arg(&data);
            run(&mut explore)?;
        }
        for t in m.trainings {
            let weights = |name: &str| root().join(format!("plugins/hybrid/weights/{name}.vbnn"));
            step(&format!("training the model of the {} that sees by {}", m.vehicle, t.sight));
            let mut train = Command::new(built("vb-model-train"));
            train.arg("--data").args(m.explorations.iter().map(explored));
            train.args(["--sight", t.sight, "--steps", t.steps, "--vehicle"]);
            train.arg(root().join(format!("tasks/vehicles/{}.yaml", m.vehicle)));
            if let Some(from) = t.from {
                train.arg("--from").arg(weights(from));
            }
            train.arg("--out").arg(weights(&format!("{}{}", m.vehicle, t.file)));
            run(&mut train)?;
        }
    }
    Ok(())
}
