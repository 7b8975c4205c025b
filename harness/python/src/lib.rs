//! `vertibench._native`: the compiled module of the Python package `vertibench`, which wraps it. Not for users.

mod arena;
mod arrays;
mod env;
mod errors;
mod gpu;
mod measures;
mod policy;
mod vector;

use pyo3::prelude::*;

/// Compiled module of the package `vertibench`, which wraps it. Not for users.
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
    use crate::measures::measures;
    #[pymodule_export]
    use crate::policy::policy_actions;
    #[pymodule_export]
    use crate::vector::VectorEnv;

    /// Constants that policies share with planners that run their weights.
    #[pymodule_export]
    const FLAT_BOUND: f32 = vb_sdk::policy::Layout::FLAT_BOUND;
    #[pymodule_export]
    const LEAK: f32 = vb_sdk::nn::LEAK;
    #[pymodule_export]
    const STEERING_STEP: f64 = vb_sdk::policy::STEERING_STEP;

    /// Returns the version of the workspace that this module was built from.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }

    /// Returns the source hash that GPU kernels compiled from the sources of this module contain.
    #[pyfunction]
    fn kernel_sources() -> &'static str {
        vb_gpu::SOURCES
    }

    /// Returns the columns of a fleet's states, as (name, unit).
    #[pyfunction]
    fn fleet_states() -> Vec<(&'static str, &'static str)> {
        vb_gpu::STATE.to_vec()
    }

    /// Returns the faults of vehicles in a fleet, as (name, number).
    #[pyfunction]
    fn fleet_faults() -> Vec<(&'static str, u32)> {
        vb_gpu::FAULTS.to_vec()
    }

    /// Returns all parts of observations, as (name, description, required sensor or None).
    #[pyfunction]
    fn parts() -> Vec<(&'static str, &'static str, Option<&'static str>)> {
        vb_sdk::policy::PARTS.iter().map(|k| (k.name, k.about, k.sensor.map(|s| s.name()))).collect()
    }

    /// Returns all terms of rewards, as (name, unit, description).
    #[pyfunction]
    fn terms() -> Vec<(&'static str, &'static str, &'static str)> {
        vb_env::TERMS.iter().map(|t| (t.name, t.unit, t.about)).collect()
    }
}
