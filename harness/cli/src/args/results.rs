//! The command line of what shows results.

use std::ffi::OsString;
use std::path::PathBuf;

#[cfg(feature = "replay")]
use clap::{ArgGroup, ValueEnum};
use clap::{Args, Parser};
#[cfg(feature = "replay")]
use vb_world::TaskId;

use super::values::{figure_width, positive};
#[cfg(feature = "replay")]
use super::values::{frame_size, moment};
use super::{ForceArgs, FormatArgs};

// A parser of its own for ReportArgs::new.
#[derive(Debug, Parser)]
pub(crate) struct ReportArgs {
    /// Run directories of one suite; several runs are compared task by task
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Directory for the HTML report, index.html; default without another output: RUN/report for a single run, else report
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Write the results as Markdown tables; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) markdown: Option<PathBuf>,
    /// Write all tasks of all runs as CSV
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write all tasks of all runs as Parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) parquet: Option<PathBuf>,
    /// Write the trajectories of runs over a real place (suite site) as GeoJSON
    #[arg(long, value_name = "FILE")]
    pub(crate) geojson: Option<PathBuf>,
    /// Directory for paper figures (SVG, PDF, PNG) and tables (LaTeX)
    #[arg(long, value_name = "DIR")]
    pub(crate) figures: Option<PathBuf>,
    /// Title of the HTML report, and above each figure; default: no title above figures
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Name of a run in all outputs; RUN is its directory or the last part of it; may be repeated
    #[arg(long = "label", value_name = "RUN=TEXT")]
    pub(crate) labels: Vec<String>,
    /// Widths of figures, inches: of a column and of a page, or one number for both
    #[arg(long, value_name = "IN,IN", default_value = "3.5,7.16", value_parser = figure_width)]
    pub(crate) figure_width: [f64; 2],
    /// Text size in figures, points
    #[arg(long, value_name = "PT", default_value_t = 8.0, value_parser = positive)]
    pub(crate) figure_font: f64,
    /// Write replays of these tasks, linked from the HTML report, e.g. w001/t03 or elevation=high
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) replays: Option<String>,
    /// Write maps of the worlds of these tasks, with all trajectories and failures, e.g. w001 or elevation=high: as HTML with
    /// --out, as figures with --figures
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) maps: Option<String>,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

impl ReportArgs {
    /// A report of runs with the default of each option.
    pub(crate) fn new(runs: &[PathBuf]) -> Self {
        let words = ["report", "--"].map(OsString::from);
        Self::parse_from(words.into_iter().chain(runs.iter().map(OsString::from)))
    }
}

/// Where the data of a run lie now, if not where they lay.
#[derive(Debug, Default, Args)]
pub(crate) struct ReplayData {
    /// Suite of the runs; default: its recorded path, or the shipped suite of its name
    #[arg(long, value_name = "DIR")]
    pub(crate) suite: Option<PathBuf>,
    /// Vehicle of the runs, for replays: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) vehicle: Option<String>,
    /// Soil set of the runs, for replays: a name or a file; default: by its recorded name
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) soils: Option<String>,
}

#[cfg(feature = "replay")]
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

#[cfg(feature = "replay")]
/// Pictures and videos of a task, several runs beside each other.
#[derive(Debug, Args)]
#[command(next_help_heading = "Video and picture", group(ArgGroup::new("film").multiple(true)))]
pub(crate) struct FilmArgs {
    /// Write a video: .gif, or with ffmpeg .mp4 or .webm; no HTML replay without --out
    #[arg(long, value_name = "FILE", group = "film")]
    pub(crate) video: Option<PathBuf>,
    /// Write a picture at one time (--at); no HTML replay without --out
    #[arg(long, value_name = "FILE", group = "film")]
    pub(crate) png: Option<PathBuf>,
    /// Camera
    #[arg(long, value_enum, default_value_t, requires = "film")]
    pub(crate) camera: CameraName,
    /// Width and height, pixels, e.g. 1920x1080; default: 640x360 for .gif, else 1280x720
    #[arg(long, value_name = "WxH", value_parser = frame_size, requires = "film")]
    pub(crate) size: Option<[u32; 2]>,
    /// For --png: simulated time, s or with a unit; default: the end of the longest run
    #[arg(long, value_name = "TIME", value_parser = moment, requires = "png")]
    pub(crate) at: Option<f64>,
    /// For --video: simulated time of the first frame, s or with a unit; default: the start
    #[arg(long, value_name = "TIME", value_parser = moment, requires = "video")]
    pub(crate) from: Option<f64>,
    /// For --video: simulated time of the last frame, s or with a unit; default: the end of the longest run
    #[arg(long, value_name = "TIME", value_parser = moment, requires = "video")]
    pub(crate) to: Option<f64>,
    /// For --video: playback speed as a multiple of real time, e.g. 4
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive, requires = "video")]
    pub(crate) speed: f64,
    /// For --video: frames per second; default: 20 for .gif, else 25
    #[arg(long, value_name = "N", value_parser = positive, requires = "video")]
    pub(crate) fps: Option<f64>,
    /// Omit the captions: planner, time, speed, outcome
    #[arg(long, requires = "film")]
    pub(crate) no_captions: bool,
}

/// The messages of MCAP files.
#[cfg(feature = "replay")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum McapProfile {
    /// Foxglove's schemas, with the world and the vehicle as solids.
    #[default]
    Foxglove,
    /// Messages of ROS 2, as in bags of rosbag2.
    Ros2,
}

/// Which messages MCAP files have.
#[cfg(feature = "replay")]
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct McapArgs {
    /// Messages of MCAP files: Foxglove's schemas, or those of ROS 2
    #[arg(long = "profile", value_name = "PROFILE", value_enum, default_value_t)]
    pub(crate) mcap_profile: McapProfile,
}

#[cfg(feature = "replay")]
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Run directories of one suite; the camera follows the first run, the others are ghosts
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Sensors to show, including sensors that the planner didn't request, e.g. lidar,depth,local-map, or none; default: the
    /// planner's sensors
    #[arg(long, value_name = "SENSOR,…", value_delimiter = ',')]
    pub(crate) sensors: Option<Vec<String>>,
    /// Perception profile of the sensors: a name from list profiles, or a file; default: the run's profile
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) perception: Option<String>,
    /// Task to show, e.g. w012/t03
    #[arg(long, value_name = "WORLD/TASK")]
    pub(crate) task: TaskId,
    /// HTML file for the replay; default: a temporary file, opened in the browser
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Write an MCAP file; no HTML replay without --out
    #[arg(long, value_name = "FILE")]
    pub(crate) mcap: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) profile: McapArgs,
    #[command(flatten)]
    pub(crate) data: ReplayData,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
    // The last, since its heading is over all that follows.
    #[command(flatten)]
    pub(crate) film: FilmArgs,
}
