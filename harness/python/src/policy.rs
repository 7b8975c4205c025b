//! Policies, executed as in planners.

use numpy::{PyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use vb_sdk::PlannerError;
use vb_sdk::nn::Weights;
use vb_sdk::policy::{Numbers, PolicyNetwork, PolicySpec};

use crate::arena::Arena;
use crate::errors::named;

/// Entries of one part of several observations, with a row per observation.
#[derive(FromPyObject)]
pub(crate) enum Part<'py> {
    F32(PyReadonlyArrayDyn<'py, f32>),
    U8(PyReadonlyArrayDyn<'py, u8>),
}

impl Part<'_> {
    fn rows(&self) -> usize {
        match self {
            Self::F32(array) => array.shape().first().copied().unwrap_or(0),
            Self::U8(array) => array.shape().first().copied().unwrap_or(0),
        }
    }

    /// Returns a row; None if the array isn't contiguous.
    fn row(&self, k: usize, rows: usize) -> Option<Numbers<'_>> {
        fn part<T>(all: &[T], k: usize, rows: usize) -> &[T] {
            let width = all.len() / rows;
            &all[k * width..][..width]
        }
        match self {
            Self::F32(array) => array.as_slice().ok().map(|all| Numbers::F32(part(all, k, rows))),
            Self::U8(array) => array.as_slice().ok().map(|all| Numbers::U8(part(all, k, rows))),
        }
    }
}

/// Returns the actions of a planner with these weights, a row per observation. `parts` has an array per part, in the arena's
/// order, with a row per observation. Raises `OptionError` if weights or arrays don't fit the arena.
#[pyfunction]
pub(crate) fn policy_actions<'py>(
    py: Python<'py>,
    arena: &Arena,
    weights: &[u8],
    parts: Vec<Part<'py>>,
) -> PyResult<Bound<'py, PyAny>> {
    let wrong = |e: PlannerError| named(py, "OptionError", &e.to_string());
    let weights = Weights::parse(weights).map_err(|e| wrong(e.into()))?;
    let layout = arena.inner.layout();
    let spec = PolicySpec::of(&weights).map_err(wrong)?;
    let mut network = PolicyNetwork::new(&weights, &spec, layout).map_err(wrong)?;
    let rows = parts.first().map_or(0, Part::rows);
    if parts.len() != layout.parts().len() || parts.iter().any(|p| p.rows() != rows) {
        return Err(named(
            py,
            "OptionError",
            "there must be an array for each part, with a row for each observation",
        ));
    }
    let mut actions = Vec::with_capacity(rows);
    for k in 0..rows {
        let numbers: Option<Vec<Numbers<'_>>> = parts.iter().map(|p| p.row(k, rows)).collect();
        let Some(numbers) = numbers else {
            return Err(named(py, "OptionError", "the arrays must be contiguous"));
        };
        actions.push(network.act(&numbers));
    }
    Ok(PyArray2::from_vec2(py, &actions)?.into_any())
}
