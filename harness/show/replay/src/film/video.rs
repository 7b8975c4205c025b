//! Files of pictures and videos.

use std::path::Path;

use vb_render::Size;

use crate::film::{Film, FilmError, Schedule, ffmpeg, gif_file};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VideoFormat {
    /// GIF: every page and every slide shows it; 255 colours, and large files. It is made here.
    Gif,
    /// H.264 in MP4, made by ffmpeg.
    Mp4,
    /// VP9 in `WebM`, made by ffmpeg.
    WebM,
}

impl VideoFormat {
    const ALL: [Self; 3] = [Self::Gif, Self::Mp4, Self::WebM];

    /// The format that the end of a file's name says.
    pub fn of(path: &Path) -> Result<Self, FilmError> {
        let end = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let found = Self::ALL.into_iter().find(|f| end.as_deref() == Some(f.extension()));
        found.ok_or_else(|| FilmError::Format { path: path.to_owned() })
    }

    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Gif => "gif",
            Self::Mp4 => "mp4",
            Self::WebM => "webm",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gif => "GIF",
            Self::Mp4 => "MP4",
            Self::WebM => "WebM",
        }
    }

    /// The number of frames a second if nobody says it, and the size of a frame: a GIF is for pages, and each of its pixels costs. A
    /// repeated drive has 50 samples a second, so that each frame of a video at 25 is one of them.
    #[must_use]
    pub fn usual(self) -> (f64, Size) {
        match self {
            Self::Gif => (20.0, Size { width: 640, height: 360 }),
            Self::Mp4 | Self::WebM => (25.0, Size { width: 1280, height: 720 }),
        }
    }

    /// The highest number of frames a second. Viewers show those frames of a GIF slowly that are to stay for less than 0.02 s.
    fn fastest(self) -> f64 {
        match self {
            Self::Gif => 50.0,
            Self::Mp4 | Self::WebM => 120.0,
        }
    }

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

pub(crate) fn cannot_write(path: &Path, reason: &dyn std::fmt::Display) -> FilmError {
    FilmError::Write { path: path.to_owned(), reason: reason.to_string() }
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

/// Makes something of each moment by several threads, and hands it over in the order of the moments. No more than two of each
/// thread are held.
pub(crate) fn in_order<T: Send>(
    times: &[f64],
    threads: usize,
    told: &mut dyn FnMut(usize),
    make: impl Fn(usize, f64) -> Result<T, FilmError> + Sync,
    mut take: impl FnMut(T) -> Result<(), FilmError>,
) -> Result<(), FilmError> {
    let threads = threads.max(1);
    let batch = 2 * threads;
    for (b, times) in times.chunks(batch).enumerate() {
        let share = times.len().div_ceil(threads);
        let make = &make;
        let made: Vec<Result<T, FilmError>> = std::thread::scope(|scope| {
            let started: Vec<_> = times
                .chunks(share)
                .enumerate()
                .map(|(c, part)| {
                    let first = b * batch + c * share;
                    scope.spawn(move || -> Vec<_> {
                        part.iter().enumerate().map(|(k, time)| make(first + k, *time)).collect()
                    })
                })
                .collect();
            let join = |thread: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            started.into_iter().flat_map(join).collect()
        });
        for (k, item) in made.into_iter().enumerate() {
            take(item?)?;
            told(b * batch + k + 1);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_in_order_whatever_the_number_of_threads() {
        let times: Vec<f64> = (0..23).map(f64::from).collect();
        for threads in [1, 2, 3, 8] {
            let (mut taken, mut told) = (Vec::new(), Vec::new());
            let make = |k: usize, t: f64| Ok((k, t));
            in_order(&times, threads, &mut |n| told.push(n), make, |pair| {
                taken.push(pair);
                Ok(())
            })
            .unwrap();
            let wanted: Vec<(usize, f64)> = times.iter().copied().enumerate().collect();
            assert_eq!(taken, wanted, "{threads} threads");
            assert_eq!(told, (1..=23).collect::<Vec<usize>>());
        }
    }

    #[test]
    fn the_name_says_the_format() {
        let of = |name: &str| VideoFormat::of(Path::new(name)).ok();
        assert_eq!(of("a/b.GIF"), Some(VideoFormat::Gif));
        assert_eq!([of("b.mp4"), of("b.webm")], [Some(VideoFormat::Mp4), Some(VideoFormat::WebM)]);
        assert_eq!([of("gif"), of("b.avi"), of("b.mp4.part")], [None; 3]);
    }

    #[test]
    fn what_a_format_cannot_have_is_refused_before_it_is_drawn() {
        let size = Size { width: 641, height: 360 };
        assert!(VideoFormat::Gif.check(size, 20.0).is_ok());
        assert!(matches!(VideoFormat::Gif.check(size, 60.0), Err(FilmError::Rate { .. })));
        assert!(matches!(VideoFormat::Gif.check(size, f64::NAN), Err(FilmError::Rate { .. })));
        assert!(matches!(VideoFormat::Mp4.check(size, 30.0), Err(FilmError::Odd { .. })));
    }
}
