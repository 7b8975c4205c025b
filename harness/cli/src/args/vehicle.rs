//! `vb-harness vehicle`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{FormatArgs, JobsArgs};

#[derive(Debug, Subcommand)]
pub(crate) enum VehicleCommand {
    /// List the shipped vehicles
    List(VehicleListArgs),
    /// Show a vehicle's data, and draw it
    Show(VehicleShowArgs),
    /// Validate all values of a vehicle file
    #[command(alias = "check")]
    Validate(VehicleArgs),
    /// Drive a vehicle through standard events, and compare it with theory, published figures and Project Chrono
    Test(VehicleTestArgs),
}

#[derive(Debug, Args)]
pub(crate) struct VehicleArgs {
    /// Vehicle: a name or a file
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
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub(crate) vehicle: String,
    /// File for a drawing of side and top view (SVG)
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Args)]
pub(crate) struct VehicleTestArgs {
    /// Vehicle: a name or a file
    #[arg(value_name = "NAME|FILE", required_unless_present = "list")]
    pub(crate) vehicle: Option<String>,
    /// Directory for report.html, results.json and the time series; default: runs/test-VEHICLE-N
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Tyre to fit, by its name in the vehicle file, e.g. rigid; drives in a reference's set-up don't depend on it
    #[arg(long, value_name = "NAME")]
    pub(crate) tyre: Option<String>,
    /// Event to run; may be repeated; default: all
    #[arg(long = "event", value_name = "NAME")]
    pub(crate) events: Vec<String>,
    /// List the events and exit
    #[arg(long)]
    pub(crate) list: bool,
    /// Reference figures in addition to theory; default: tasks/validation/VEHICLE.yaml, if it exists
    #[arg(long, value_name = "FILE")]
    pub(crate) references: Option<PathBuf>,
    /// Simulation step, ms
    // --step is what it was called before it had the name that it has in a run.
    #[arg(long, alias = "step", value_name = "MS", default_value_t = 1.0)]
    pub(crate) time_step: f64,
    #[command(flatten)]
    pub(crate) jobs: JobsArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
