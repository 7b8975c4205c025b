//! Rules, outcomes, metrics and summaries.
//!
//! [`Rules`] determine a trial's outcome; a [`Scorer`] applies them to the samples of one trial in order and computes
//! the metrics; a [`Summary`] aggregates the [`TaskRecord`]s of a run; [`rescore`] repeats this from the traces of a
//! finished run, optionally under other rules. All results are functions of the samples only, in one pass and a fixed
//! order, so they are bit-identical for the same samples; only shock and ride ([`Ride`]), which affect no outcome, are
//! measured at every simulation step.

#![deny(missing_docs)]

pub mod cause;
mod conditions;
mod flag;
mod measures;
mod metrics;
mod outcome;
mod record;
mod rescore;
mod ride;
mod rules;
mod scorer;
mod stats;
mod summary;
mod table;

pub use cause::Cause;
pub use conditions::Conditions;
pub use flag::{Flag, TILT_LIMIT_DEG};
pub use measures::{Distribution, Extent, Measured, Reader};
pub use metrics::{Metrics, Pooled};
pub use outcome::{Fault, Outcome, ThreeWay};
pub use record::{FuelUse, TaskRecord};
pub use rescore::{RescoreError, Rescored, rescore};
pub use ride::{POWER_LIMIT_W, Ride, RideMeter, RideStep, SHOCK_LIMIT_G};
pub use rules::{BoundsRule, RollTime, RolloverRule, Rules, StartRule, StuckRule, SuccessRule};
pub use scorer::{Scorer, TaskGeometry, TaskScore, Verdict};
pub use stats::{
    BOOTSTRAP_SEED, Interval, Ratio, bootstrap, bootstrap_ratio, normal_cdf, normal_quantile,
    success_interval, wilson,
};
pub use summary::{Group, SUMMARY_SCHEMA, Summary};
pub use table::{TableRow, table};
