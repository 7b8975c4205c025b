//! The pictures and videos of `vb-harness replay`.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use vb_render::Size;
use vb_replay::Replay;
use vb_replay::film::{Camera, Course, Film, Schedule, Style, VideoFormat, write_picture, write_video};

use crate::args::values::{frame_size, moment, positive};
use crate::args::{JobsArgs, MessageFormat};
use crate::error::CliError;
use crate::output;

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

impl From<CameraName> for Camera {
    fn from(name: CameraName) -> Self {
        match name {
            CameraName::Chase => Self::Chase,
            CameraName::Top => Self::Top,
            CameraName::Map => Self::Map,
        }
    }
}

/// The size of frames, and how many there are in a second of a video in a format.
fn sizes(args: &FilmArgs, format: VideoFormat) -> (Size, f64) {
    let (fps, size) = format.usual();
    let size = args.size.map_or(size, |[width, height]| Size { width, height });
    (size, args.fps.unwrap_or(fps))
}

/// Fails before anything is read if what is asked for can't be had.
pub(crate) fn check(args: &FilmArgs) -> Result<(), CliError> {
    if let Some(path) = &args.video {
        let format = VideoFormat::of(path)?;
        let (size, fps) = sizes(args, format);
        format.check(size, fps)?;
    }
    Ok(())
}

/// Progress of a long task in tenths: the number that has been printed.
#[derive(Default)]
struct Tenths(usize);

impl Tenths {
    /// Whether another tenth is reached after so many of all parts.
    fn reached(&mut self, done: usize, all: usize) -> bool {
        let tenths = 10 * done / all.max(1);
        let further = tenths > self.0;
        self.0 = tenths;
        further
    }
}

/// Writes the video, the picture or both.
pub(crate) fn write(replay: &Replay, args: &FilmArgs, format: MessageFormat) -> Result<(), CliError> {
    let style = |size| Style { camera: args.camera.into(), size, captions: !args.no_captions };
    if let Some(path) = &args.video {
        let (size, fps) = sizes(args, VideoFormat::of(path)?);
        let film = Film::new(replay, style(size))?;
        let course = Course { from: args.from, to: args.to, speed: args.speed, fps };
        let schedule = Schedule::new(course, film.end())?;
        let frames = schedule.times.len();
        let (human, terminal) =
            (format == MessageFormat::Human, std::io::stderr().is_terminal() && !output::is_quiet());
        let bar = if human && terminal { ProgressBar::new(frames as u64) } else { ProgressBar::hidden() };
        let mut tenths = Tenths::default();
        if let Ok(look) = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {eta} left") {
            bar.set_style(look);
        }
        let threads = JobsArgs::default().get();
        let written = write_video(&film, &schedule, path, threads, &mut |drawn| {
            bar.set_position(drawn as u64);
            if human && !terminal && tenths.reached(drawn, frames) {
                output::note(&format!("{}: {drawn} of {frames} frames", path.display()));
            }
        });
        bar.finish_and_clear();
        written?;
    }
    if let Some(path) = &args.png {
        let size = args.size.map_or(VideoFormat::Mp4.usual().1, |[width, height]| Size { width, height });
        let film = Film::new(replay, style(size))?;
        write_picture(&film, args.at.unwrap_or(film.end()), path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::parse;

    #[test]
    fn a_long_work_is_told_ten_times() {
        let mut tenths = Tenths::default();
        let told: Vec<usize> = (1..=733).filter(|done| tenths.reached(*done, 733)).collect();
        assert_eq!((told.len(), told[0], told[9]), (10, 74, 733));
        assert!(Tenths::default().reached(1, 1) && !Tenths::default().reached(0, 0));
    }

    #[test]
    fn a_task_can_be_filmed_and_pictured_at_once_and_each_option_needs_its_output() {
        let replay = |more: &[&str]| parse(&[&["replay", "r", "--task", "w001/t00"], more].concat());
        assert!(replay(&["--video", "v.gif", "--png", "p.png", "--fps", "5", "--camera", "top"]).is_ok());
        assert!(replay(&["--png", "p.png", "--camera", "top", "--at", "500ms"]).is_ok());
        for lacking in [&["--png", "p.png", "--fps", "5"][..], &["--camera", "top"], &["--no-captions"]] {
            assert!(replay(lacking).is_err(), "{lacking:?}");
        }
    }
}
