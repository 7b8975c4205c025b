//! `vertibench._native`: what the Python package `vertibench` has in Rust.

use pyo3::prelude::*;

/// What the Python package has in Rust.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    /// The version of the package, which is that of the workspace.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
