//! The ACL planner of the Verti-Bench paper, re-trained: docs/training.md describes the training, `policy.json` is the
//! model card of its weights.

vb_sdk::export_policy! {
    name: "acl",
    about: "End-to-end policy (SAC) with an automatic curriculum, as the ACL planner of the Verti-Bench paper",
    weights: include_bytes!("../policy.vbnn"),
    model: include_str!("../policy.txt"),
}
