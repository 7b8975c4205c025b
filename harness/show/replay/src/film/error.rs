//! Why there is no film.

use std::path::{Path, PathBuf};

use vb_figure::FigureError;
use vb_render::RenderError;
use vb_world::TaskId;

/// An error of a film. Each message is one line: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    #[error("{runs} runs are too many for one picture (give at most {most})")]
    Runs { runs: usize, most: usize },
    #[error(
        "a frame of {width}x{height} pixels is too small for {runs} runs (each needs {least} pixels across and down; choose a larger --size)"
    )]
    Small { width: u32, height: u32, runs: usize, least: u32 },
    #[error("{option} {time}: the runs cover 0 to {end:.2} s (choose a time in this range)")]
    Time {
        option: &'static str,
        /// The time, s.
        time: f64,
        /// When the last of the runs ended, s.
        end: f64,
    },
    #[error("--to {to} is before --from, {from} s (choose a later time)")]
    Backwards {
        /// The first moment, s.
        from: f64,
        /// The last moment, s.
        to: f64,
    },
    #[error(
        "--fps {fps}: {format} files support 1 to {most} frames per second (choose a value in this range)"
    )]
    Rate {
        /// What was asked for, 1/s.
        fps: f64,
        format: &'static str,
        /// The highest rate, 1/s.
        most: f64,
    },
    /// A video of so many frames that something was surely mistaken.
    #[error(
        "a video of {frames} frames is too long (at most {most}: choose fewer --fps, a higher --speed, or --from and --to)"
    )]
    Long { frames: u64, most: u64 },
    #[error("{}: unknown video format (use the extension .gif, .mp4 or .webm)", .path.display())]
    Format { path: PathBuf },
    #[error(
        "{format} files need an even width and height, not {width}x{height} (choose another --size, or .gif)"
    )]
    Odd { format: &'static str, width: u32, height: u32 },
    #[error(
        "{format} files need ffmpeg, which is not on the PATH (install it, e.g. `apt-get install ffmpeg`, or write a .gif)"
    )]
    NoEncoder { format: &'static str },
    #[error("{}: ffmpeg failed: {reason} (write a .gif if this ffmpeg lacks the encoder)", .path.display())]
    Encoder { path: PathBuf, reason: String },
    #[error("cannot write {}: {reason}", .path.display())]
    Write { path: PathBuf, reason: String },
    #[error("task {task}: {source}")]
    Picture { task: TaskId, source: RenderError },
    /// A run without a single frame, or with another vehicle than its trace.
    #[error("run {run}: task {task} cannot be rendered: {reason}")]
    Run { run: String, task: TaskId, reason: &'static str },
    #[error(transparent)]
    Caption(#[from] FigureError),
}

pub(crate) fn cannot_write(path: &Path, reason: &dyn std::fmt::Display) -> FilmError {
    FilmError::Write { path: path.to_owned(), reason: reason.to_string() }
}
