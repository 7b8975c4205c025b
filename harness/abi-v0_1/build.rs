//! Gives the crate the name that its types had.
//!
//! `abi_stable` compares the package of every type, by name and version, when it opens a native planner. Planners for
//! version 0.1 of the interface were built with `vb-sdk` 0.1.0, so the macros must see that name here.

fn main() {
    println!("cargo::rustc-env=CARGO_PKG_NAME=vb-sdk");
    println!("cargo::rustc-env=CARGO_PKG_VERSION=0.1.0");
    println!("cargo::rerun-if-changed=build.rs");
}
