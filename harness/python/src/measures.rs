//! Measures of tasks.

use pyo3::prelude::*;
use vb_score::{Flag, FuelUse, Measured, Metrics, Reader, Ride};

/// Group, name, type and description of a measure.
type Measure = (&'static str, &'static str, &'static str, &'static str);

/// Returns all measures of a task's record, in the order of tables, as (group, name, type, description). A group is an object of
/// the record: `flags`, `metrics`, `ride` or `fuel`. A type is `count` (whole number), `number` or `flag`.
#[pyfunction]
pub(crate) fn measures() -> Vec<Measure> {
    let flags = Flag::ALL.into_iter().map(|flag| ("flags", flag.name(), "flag", flag.about()));
    flags
        .chain(of("metrics", Metrics::MEASURES))
        .chain(of("ride", Ride::MEASURES))
        .chain(of("fuel", FuelUse::MEASURES))
        .collect()
}

fn of<T>(group: &'static str, measures: &'static [Measured<T>]) -> impl Iterator<Item = Measure> {
    measures.iter().map(move |m| {
        let kind = match m.value {
            Reader::Count(_) => "count",
            Reader::Number(_) | Reader::Optional(_) => "number",
            Reader::Flag(_) => "flag",
        };
        (group, m.name, kind, m.about)
    })
}
