//! Nothing but dependencies, with the features that they have anywhere in the workspace (`Cargo.toml`).
//!
//! cargo builds a crate with the features that the packages to be built ask for. Where the harness is built first and the tests
//! after it, as `cargo xtask test` and everybody else does, a feature more in one crate below compiles all that stand on it again.
//! The pattern is known as a workspace-hack crate.
