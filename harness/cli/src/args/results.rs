//! The command line of what shows results.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::FormatArgs;
use super::values::{figure_width, frame_size, not_negative, positive};

#[derive(Debug, Default, Args)]
pub(crate) struct ReportArgs {
    /// Directories of runs of one suite; several are compared task by task
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Directory for the page, index.html; default, if no other output is asked for: RUN/report of a single run, else report
    #[arg(long, value_name = "DIR")]
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
    /// Write the trajectories of runs over a real place (suite site) as GeoJSON, for a map
    #[arg(long, value_name = "FILE")]
    pub(crate) geojson: Option<PathBuf>,
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
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Make maps of the worlds of these tasks, e.g. w001 or elevation=high, with all ways and where and why they ended: as pages
    /// for --out, as figures for --figures
    #[arg(long, value_name = "SELECTOR")]
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

/// From where a film is shot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum CameraName {
    /// From behind the vehicle.
    #[default]
    Chase,
    /// From above the vehicle, north up.
    Top,
    /// The whole world from above, north up.
    Map,
}

/// Pictures and videos of a task, several runs beside each other.
#[derive(Debug, Args)]
#[command(next_help_heading = "Video and picture")]
pub(crate) struct FilmArgs {
    /// Write a video, and no page unless --out is given: a .gif, or by ffmpeg a .mp4 or .webm
    #[arg(long, value_name = "FILE")]
    pub(crate) video: Option<PathBuf>,
    /// Write a picture of one moment (--at), and no page unless --out is given
    #[arg(long, value_name = "FILE")]
    pub(crate) png: Option<PathBuf>,
    /// From where it is seen; default: chase
    #[arg(long, value_enum)]
    pub(crate) camera: Option<CameraName>,
    /// Columns and rows of pixels, e.g. 1920x1080; default: 640x360 for .gif, else 1280x720
    #[arg(long, value_name = "WxH", value_parser = frame_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// For --png: the moment, s; default: the end of the longest run
    #[arg(long, value_name = "S", value_parser = not_negative, requires = "png")]
    pub(crate) at: Option<f64>,
    /// For --video: the first moment, s; default: the start
    #[arg(long, value_name = "S", value_parser = not_negative, requires = "video")]
    pub(crate) from: Option<f64>,
    /// For --video: the last moment, s; default: the end of the longest run
    #[arg(long, value_name = "S", value_parser = not_negative, requires = "video")]
    pub(crate) to: Option<f64>,
    /// For --video: how fast it plays, e.g. 4 for four times as fast as it was driven; default: 1
    #[arg(long, value_name = "FACTOR", value_parser = positive, requires = "video")]
    pub(crate) speed: Option<f64>,
    /// For --video: frames a second; default: 20 for .gif, else 25
    #[arg(long, value_name = "N", value_parser = positive, requires = "video")]
    pub(crate) fps: Option<f64>,
    /// Leave out what is written over the pictures: planner, time, speed, outcome
    #[arg(long)]
    pub(crate) no_captions: bool,
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
    // The last, since its heading is over all that follows.
    #[command(flatten)]
    pub(crate) film: FilmArgs,
}
