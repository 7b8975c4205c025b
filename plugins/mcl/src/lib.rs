//! The MCL planner of the Verti-Bench paper, re-trained: docs/training.md describes the training, `policy.json` is the
//! model card of its weights.

vb_sdk::export_policy! {
    name: "mcl",
    about: "End-to-end policy (SAC) with a manual curriculum, as the MCL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
