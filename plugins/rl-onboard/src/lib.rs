//! The RL planner without prior maps: its policy observes the local map of lidar and camera. It was trained with
//! `tasks/training/onboard.yaml` (docs/training.md); `policy.json` is the model card of its weights.

vb_sdk::export_policy! {
    name: "rl-onboard",
    about: "End-to-end policy (SAC), tasks sampled uniformly, on the local map of lidar and camera",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
