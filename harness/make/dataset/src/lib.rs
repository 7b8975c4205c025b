//! Datasets of driving, for those who learn from data: exploration, demonstrations and failures.
//!
//! A dataset is a folder in one of the [formats](Format), with the worlds in a suite beside it, so that
//! a frame names its place instead of copying the map. [`Making`] drives and [`DatasetWriter`] writes; [`Dataset`] reads.
//! [`Layout::features`] is the one list of columns. Everything follows from the [`Header`]: the same header gives the same
//! bytes.

mod combine;
mod episode;
mod error;
pub mod explore;
mod failure;
mod feature;
mod format;
mod formats;
mod header;
mod make;
mod ordered;
mod part;
mod playback;
mod reader;
mod stats;
mod sums;
mod validate;
mod values;
mod worlds;
mod writer;

pub use combine::{merge, repeated, split};
pub use episode::{Ending, Episode, EpisodeInfo, View};
pub use error::DatasetError;
pub use explore::Exploration;
pub use failure::{SECONDS, failures};
pub use feature::{CROP_SIDE, Dtype, Feature, Layout, Values};
pub use format::Summary;
pub use formats::Format;
pub use header::{DATASET_SCHEMA, Header, Kind, LICENCE, PlannerHeader};
pub use make::{Amount, Kept, Making, Planner, Progress, keep_apart};
pub use part::Part;
pub use reader::Dataset;
pub use validate::{Findings, validate};
pub use writer::{DatasetWriter, Finished};
