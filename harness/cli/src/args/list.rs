//! `vb-harness list`.

use clap::{Args, ValueEnum};

use super::FormatArgs;

/// What can be listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listed {
    /// Suites, for --suite
    Suites,
    /// Vehicles, for --vehicle
    Vehicles,
    /// Shipped and installed planners, which are found by their file names
    Planners,
    /// Rule profiles, for --rules
    Rules,
    /// Soil sets, for --soils
    Soils,
    /// Perception profiles, for --perception
    Profiles,
}

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// What to list
    #[arg(value_name = "WHAT", value_enum)]
    pub(crate) what: Listed,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
