//! The pictures and videos of `vb-harness replay`.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressStyle};
use vb_render::Size;
use vb_replay::Replay;
use vb_replay::film::{Camera, Course, Film, Schedule, Style, VideoFormat, write_picture, write_video};

use crate::args::{CameraName, FilmArgs, JobsArgs, MessageFormat};
use crate::error::CliError;
use crate::output;

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

    #[test]
    fn a_long_work_is_told_ten_times() {
        let mut tenths = Tenths::default();
        let told: Vec<usize> = (1..=733).filter(|done| tenths.reached(*done, 733)).collect();
        assert_eq!((told.len(), told[0], told[9]), (10, 74, 733));
        assert!(Tenths::default().reached(1, 1) && !Tenths::default().reached(0, 0));
    }
}
