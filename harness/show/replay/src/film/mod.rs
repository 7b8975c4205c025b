//! A recorded task as pictures and videos, drawn without a display.
//!
//! A [`Film`] shows the runs of a [`Replay`](crate::Replay) beside each other: [`Film::frame`] draws the picture of a moment with the
//! software rasteriser of `vb-render`, and [`write_picture`] and [`write_video`] put pictures into files. The same runs give the same
//! pixels on every machine. PNG and GIF files are made here and are the same everywhere, too; MP4 and WebM files are made of
//! these pixels by ffmpeg, if the machine has it.

mod camera;
mod caption;
mod error;
mod ffmpeg;
mod format;
mod frames;
mod gif_file;
mod layout;
mod ordered;
mod panel;
mod ruts;
mod schedule;
mod video;

pub use camera::Camera;
pub use error::FilmError;
pub use format::VideoFormat;
pub use frames::{Film, Style};
pub use schedule::{Course, Schedule};
pub use video::{write_picture, write_video};

type V3 = nalgebra::Vector3<f64>;
