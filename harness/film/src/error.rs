//! Why there is no film.

use std::path::PathBuf;

use vb_figure::FigureError;
use vb_render::RenderError;

/// An error of a film. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// More runs than can be shown beside each other.
    #[error("{runs} runs can't be shown beside each other (name {most} at most)")]
    Runs {
        /// The number of runs.
        runs: usize,
        /// The greatest number.
        most: usize,
    },
    /// The frame is too small for so many panels.
    #[error(
        "a frame of {width}x{height} pixels is too small for {runs} runs (each needs {least} pixels across and down; choose a larger --size)"
    )]
    Small {
        /// The number of columns of pixels.
        width: u32,
        /// The number of rows of pixels.
        height: u32,
        /// The number of runs.
        runs: usize,
        /// The least width and height of a panel.
        least: u32,
    },
    /// A moment that no run has.
    #[error("{option} {time}: the runs have 0 to {end:.2} s (choose a time within)")]
    Time {
        /// The option that asks for it.
        option: &'static str,
        /// The time, s.
        time: f64,
        /// When the last of the runs ended, s.
        end: f64,
    },
    /// A last moment that is before the first.
    #[error("--to {to}: it is before --from, {from} s (choose a later moment)")]
    Backwards {
        /// The first moment, s.
        from: f64,
        /// The last moment, s.
        to: f64,
    },
    /// A rate of frames that a film can't have.
    #[error("--fps {fps}: {format} files have 1 to {most} frames a second (choose one of these)")]
    Rate {
        /// What was asked for, 1/s.
        fps: f64,
        /// The name of the format.
        format: &'static str,
        /// The highest rate, 1/s.
        most: f64,
    },
    /// A video of so many frames that something was surely mistaken.
    #[error(
        "a video of {frames} frames is too long (most are {most}: choose fewer --fps, a higher --speed, or --from and --to)"
    )]
    Long {
        /// The number of frames.
        frames: u64,
        /// The greatest number.
        most: u64,
    },
    /// The file's name ends in none of the known ways.
    #[error("{}: can't tell the format of the video (end the name in .gif, .mp4 or .webm)", .path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// Sides that the encoder can't take.
    #[error(
        "{format} files have an even number of columns and rows, and {width}x{height} is not (choose another --size, or .gif)"
    )]
    Odd {
        /// The name of the format.
        format: &'static str,
        /// The number of columns of pixels.
        width: u32,
        /// The number of rows of pixels.
        height: u32,
    },
    /// There is no ffmpeg.
    #[error(
        "{format} files are made by ffmpeg, which is not on the PATH (install it, e.g. `apt-get install ffmpeg`, or write a .gif)"
    )]
    NoEncoder {
        /// The name of the format.
        format: &'static str,
    },
    /// ffmpeg failed.
    #[error("{}: ffmpeg failed: {reason} (write a .gif if this ffmpeg lacks the encoder)", .path.display())]
    Encoder {
        /// The file.
        path: PathBuf,
        /// What ffmpeg said last.
        reason: String,
    },
    /// The file can't be written.
    #[error("cannot write {}: {reason}", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The picture can't be drawn.
    #[error("task {task}: {source}")]
    Picture {
        /// The task.
        task: String,
        /// Why not.
        source: RenderError,
    },
    /// A run without a single frame, or with another vehicle than its trace.
    #[error("run {run}: task {task} can't be drawn: {reason}")]
    Run {
        /// The run.
        run: String,
        /// The task.
        task: String,
        /// Why not, and what to do.
        reason: &'static str,
    },
    /// The caption can't be drawn.
    #[error(transparent)]
    Caption(#[from] FigureError),
}
