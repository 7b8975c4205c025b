//! The RL planner of the Verti-Bench paper, re-trained: docs/training.md describes the training, `policy.json` is the
//! model card of its weights.

vb_sdk::export_policy! {
    name: "rl",
    about: "End-to-end policy (SAC), tasks sampled uniformly, as the RL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
