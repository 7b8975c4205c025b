//! The MCL planner of the Verti-Bench paper, trained here: docs/training.md tells how, and `policy.json` is the card of its weights.

vb_sdk::export_policy! {
    name: "mcl",
    about: "Trained end to end by stages from easy to hard ground, as the MCL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
