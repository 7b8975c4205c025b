//! Formats of video files.

use std::path::Path;

use vb_render::Size;

use crate::film::FilmError;

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
    pub(crate) fn fastest(self) -> f64 {
        match self {
            Self::Gif => 50.0,
            Self::Mp4 | Self::WebM => 120.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_says_the_format() {
        let of = |name: &str| VideoFormat::of(Path::new(name)).ok();
        assert_eq!(of("a/b.GIF"), Some(VideoFormat::Gif));
        assert_eq!([of("b.mp4"), of("b.webm")], [Some(VideoFormat::Mp4), Some(VideoFormat::WebM)]);
        assert_eq!([of("gif"), of("b.avi"), of("b.mp4.part")], [None; 3]);
    }
}
