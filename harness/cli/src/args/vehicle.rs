//! `vb-harness vehicle`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{FormatArgs, JobsArgs};

#[derive(Debug, Subcommand)]
pub(crate) enum VehicleCommand {
    /// List the vehicles that come with the harness
    List(VehicleListArgs),
    /// Show what a vehicle is made of, and draw it
    Show(VehicleShowArgs),
    /// Read a vehicle file and check every value
    #[command(alias = "check")]
    Validate(VehicleArgs),
    /// Drive a vehicle through standard events and hold it against theory, published figures and Project Chrono
    Test(VehicleTestArgs),
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleListArgs {
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleShowArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// Draw its side and top view into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name, or a file
    #[arg(value_name = "NAME|FILE", required_unless_present = "list")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Tyre to put on: the name of one of the vehicle's, e.g. rigid. References with a set-up of their own are held against
    /// the vehicle in that set-up, whatever this says
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// List the events and do nothing else
    #[arg(long)]
    pub(crate) list: bool,
    /// Figures to hold the vehicle against beside theory; default: tasks/validation/VEHICLE.yaml, if it is there
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Step of the simulation in milliseconds
    // --step is what it was called before it had the name that it has in a run.
    #[arg(long, alias = "step", value_name = "MS", default_value_t = 1.0)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
