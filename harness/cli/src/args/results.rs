//! The command line of what shows results.

use std::path::PathBuf;

use clap::Args;

use super::FormatArgs;
use super::values::{figure_width, positive};

#[derive(Debug, Default, Args)]
pub(crate) struct ReportArgs {
    /// Directories of runs of one suite; several are compared task by task
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Directory for the page, index.html
    #[arg(long, value_name = "DIR", required_unless_present_any = ["figures", "markdown", "csv", "parquet"])]
    pub(crate) out: Option<PathBuf>,
    /// Write the results as Markdown, for a paper or a pull request; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) markdown: Option<PathBuf>,
    /// Write every task of every run as CSV
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write every task of every run as Parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) parquet: Option<PathBuf>,
    /// Directory for figures of a paper as SVG, PDF and PNG, and for tables as LaTeX
    #[arg(long, value_name = "DIR")]
    pub(crate) figures: Option<PathBuf>,
    /// What the page is called, and what stands above each figure; default: no title above figures
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// What a run is called everywhere; RUN is its directory, or the last part of it [may be repeated]
    #[arg(long = "label", value_name = "RUN=TEXT")]
    pub(crate) labels: Vec<String>,
    /// Widths of figures in inches, in a column and across the page; or one for both
    #[arg(long, value_name = "IN,IN", default_value = "3.5,7.16", value_parser = figure_width)]
    pub(crate) figure_width: [f64; 2],
    /// Size of texts in figures, points
    #[arg(long, value_name = "PT", default_value_t = 8.0, value_parser = positive)]
    pub(crate) figure_font: f64,
    /// Make replays of these tasks, e.g. w001/t03 or elevation=high, and link them from the page
    #[arg(long, value_name = "SELECTOR", requires = "out")]
    pub(crate) replays: Option<String>,
    /// Make maps of the worlds of these tasks, e.g. w001 or elevation=high, with all ways and where and why they ended
    #[arg(long, value_name = "SELECTOR", requires = "out")]
    pub(crate) maps: Option<String>,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// Where the data of a run lie now, if not where they lay.
#[derive(Debug, Default, Args)]
pub(crate) struct ReplayData {
    /// For replays: the suite of the runs; default: where it was, or the one of its name that comes with the harness
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// For replays: the vehicle of the runs, a name or a file; default: by its name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// For replays: the soils of the runs, a name or a file; default: by their name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Directories of runs of one suite; the first is followed, others are ghosts
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Sensors whose measurements are shown, e.g. lidar,depth,local-map: of any run, as they would have measured, or none;
    /// default: those that the planner had
    #[arg(long, value_name = "SENSOR,…", value_delimiter = ',')]
    pub(crate) sensors: Option<Vec<String>>,
    /// How wrong the sensors are: oracle, onboard, degraded, or a file; default: as in the run
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// The task, e.g. w012/t03
    #[arg(long, value_name = "WORLD/TASK")]
    pub(crate) task: String,
    /// Write the page here; default: a temporary file, which is opened in the browser
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write an MCAP file with Foxglove's schemas, and no page unless --out is given
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}
