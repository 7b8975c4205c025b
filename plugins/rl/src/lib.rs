//! The RL planner of the Verti-Bench paper, trained here: docs/training.md tells how, and `policy.json` is the card of its weights.

vb_sdk::export_policy! {
    name: "rl",
    about: "Trained end to end with all tasks alike, as the RL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
