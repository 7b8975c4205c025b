//! Files of pictures and videos.

use std::path::Path;

use vb_render::Size;

use crate::film::error::cannot_write;
use crate::film::format::VideoFormat;
use crate::film::ordered::in_order;
use crate::film::{Film, FilmError, Schedule, ffmpeg, gif_file};

impl VideoFormat {
    /// Fails before anything is drawn if a video of this size and rate can't be made here.
    ///
    /// # Errors
    /// Returns an error if the rate or the size is not one of the format, or if there is no ffmpeg and the format needs it.
    pub fn check(self, size: Size, fps: f64) -> Result<(), FilmError> {
        if !(1.0..=self.fastest()).contains(&fps) {
            return Err(FilmError::Rate { fps, format: self.name(), most: self.fastest() });
        }
        if self == Self::Gif {
            return Ok(());
        }
        let Size { width, height } = size;
        if width % 2 == 1 || height % 2 == 1 {
            return Err(FilmError::Odd { format: self.name(), width, height });
        }
        ffmpeg::check(self)
    }
}

/// Writes the frame of a moment, s, as PNG.
///
/// # Errors
/// Returns an error if no run lasts so long, or if the picture can't be drawn or written.
pub fn write_picture(film: &Film, time: f64, path: &Path) -> Result<(), FilmError> {
    let end = film.end();
    if !(0.0..=end).contains(&time) {
        return Err(FilmError::Time { option: "--at", time, end });
    }
    let Size { width, height } = film.size();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(&film.frame(time).map_err(std::io::Error::other)?)?;
        writer.finish()
    });
    written.map_err(|e| cannot_write(path, &e))?;
    vb_files::write(path, &file).map_err(|e| cannot_write(path, &e))
}

/// Writes a video of the frames of a schedule, by so many threads. `told` hears how many frames are drawn.
///
/// # Errors
/// Returns an error if the format can't have the size or rate, if ffmpeg is needed and fails, or if a frame can't be drawn or the file
/// can't be written.
pub fn write_video(
    film: &Film,
    schedule: &Schedule,
    path: &Path,
    threads: usize,
    told: &mut dyn FnMut(usize),
) -> Result<(), FilmError> {
    let format = VideoFormat::of(path)?;
    format.check(film.size(), schedule.fps)?;
    if format == VideoFormat::Gif {
        return gif_file::write(film, schedule, path, threads, told);
    }
    let mut encoder = ffmpeg::Encoder::start(format, film.size(), schedule.fps, path)?;
    let drawn =
        in_order(&schedule.times, threads, told, |_, time| film.frame(time), |frame| encoder.take(&frame));
    encoder.finish(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_format_cannot_have_is_refused_before_it_is_drawn() {
        let size = Size { width: 641, height: 360 };
        assert!(VideoFormat::Gif.check(size, 20.0).is_ok());
        assert!(matches!(VideoFormat::Gif.check(size, 60.0), Err(FilmError::Rate { .. })));
        assert!(matches!(VideoFormat::Gif.check(size, f64::NAN), Err(FilmError::Rate { .. })));
        assert!(matches!(VideoFormat::Mp4.check(size, 30.0), Err(FilmError::Odd { .. })));
    }
}
