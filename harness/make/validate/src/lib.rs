//! Standard events for a vehicle: what it does, beside what theory, published figures and Project Chrono say.
//!
//! An [`Event`] drives the vehicle over ground made for it and measures [`Figure`]s and time series. An
//! [`Expectation`] says what a figure should be, by which source and how closely; together they make a [`Check`].
//! Theory is computed from the vehicle's own data, so it holds for every vehicle; figures of one vehicle come from a
//! file ([`References`], `tasks/validation/*.yaml`), held against the vehicle in the set-up of their runs where the file states
//! one ([`Setup`]). [`run`] runs events side by side and gives a [`Report`], which
//! writes itself as a page, as JSON and as CSV. [`replay`] makes such a report of a [`Recording`] of a real vehicle.
//!
//! Units in figures, series and files are those named beside them: SI, angles in degrees, as people read them.

mod bench;
mod characteristics;
mod check;
mod course;
mod error;
mod event;
mod events;
mod geometry;
mod grounds;
mod mobility_index;
mod pace;
mod recording;
mod reference;
mod report;
mod result;
mod rig;
mod rigid_wheel;
mod run;
mod setup;
mod statics;
mod theory;
mod traction;

pub use bench::Bench;
pub use characteristics::{AxleCharacteristics, Characteristics, Ride};
pub use check::{Check, Expectation, Expected, Kind, Verdict};
pub use course::NamedCourse;
pub use error::ValidateError;
pub use event::{Event, Figure, Line, LineKind, Outcome, Place, Plot, Series, Vehicles};
pub use events::{event, events};
pub use recording::{Recording, replay};
pub use reference::{Curve, References};
pub use report::{Counts, Report, expected};
pub use result::{EventResult, InSetup};
pub use run::{RunOptions, run};
pub use setup::Setup;
