//! The ACL planner of the Verti-Bench paper, trained here: docs/training.md tells how, and `policy.json` is the card of its weights.

vb_sdk::export_policy! {
    name: "acl",
    about: "Trained end to end on what it does now and then, as the ACL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
