//! `vertibench._native`: what the Python package `vertibench` has in Rust. The package wraps it; users don't meet it.

mod arena;
mod arrays;
mod env;
mod errors;
mod gpu;
mod policy;
mod vector;

use pyo3::prelude::*;

/// What the Python package has in Rust.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::arena::Arena;
    #[pymodule_export]
    use crate::env::{Env, Snapshot};
    #[pymodule_export]
    use crate::gpu::{Array, Fleet};
    #[pymodule_export]
    use crate::policy::policy_actions;
    #[pymodule_export]
    use crate::vector::VectorEnv;

    /// What policies have in common with planners that drive by their weights: see the constants of the same names.
    #[pymodule_export]
    const FLAT_BOUND: f32 = vb_sdk::policy::Layout::FLAT_BOUND;
    #[pymodule_export]
    const LEAK: f32 = vb_sdk::nn::LEAK;
    #[pymodule_export]
    const STEERING_STEP: f64 = vb_sdk::policy::STEERING_STEP;

    /// The version of the package, which is that of the workspace.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }

    /// What stands in kernels for a GPU that were made of the same sources as this module.
    #[pyfunction]
    fn kernel_sources() -> &'static str {
        vb_gpu::SOURCES
    }

    /// The numbers that a fleet tells of each of its vehicles, as (name, unit).
    #[pyfunction]
    fn fleet_states() -> Vec<(&'static str, &'static str)> {
        vb_gpu::STATE.to_vec()
    }

    /// What can be wrong with a vehicle of a fleet, as (name, number).
    #[pyfunction]
    fn fleet_faults() -> Vec<(&'static str, u32)> {
        vb_gpu::FAULTS.to_vec()
    }

    /// All parts that an observation can have, as (name, what it is, the sensor that it takes or None).
    #[pyfunction]
    fn parts() -> Vec<(&'static str, &'static str, Option<&'static str>)> {
        vb_sdk::policy::PARTS.iter().map(|k| (k.name, k.about, k.sensor.map(|s| s.name()))).collect()
    }

    /// All terms of a reward, as (name, unit, what is measured).
    #[pyfunction]
    fn terms() -> Vec<(&'static str, &'static str, &'static str)> {
        vb_env::TERMS.iter().map(|t| (t.name, t.unit, t.about)).collect()
    }
}
