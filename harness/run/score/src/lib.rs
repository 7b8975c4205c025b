//! Rules, outcomes, metrics and summaries.
//!
//! [`Rules`] say what a trial's outcome is; a [`Scorer`] applies them to the samples of one trial as they come, and
//! measures; a [`Summary`] counts and averages over the [`TaskRecord`]s of a run; [`rescore`] does all of it again
//! from the traces of a finished run, under other rules if wanted. Everything is a function of the samples alone, in
//! one pass and a fixed order, so that the same samples give the same bits; only shock and ride ([`Ride`]), which decide
//! no outcome, are measured at every step of the simulation.

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
