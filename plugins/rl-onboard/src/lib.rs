//! The RL planner without prior maps, which sees the local map of lidar and camera: docs/training.md tells how it was trained
//! (`tasks/training/onboard.yaml`), and `policy.json` is the card of its weights.

vb_sdk::export_policy! {
    name: "rl-onboard",
    about: "Trained end to end with all tasks alike, on the local map of lidar and camera instead of prior maps",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
