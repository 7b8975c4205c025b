//! Videos made by ffmpeg, which reads the frames' pixels.

use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

use vb_files::NewFile;
use vb_render::Size;

use crate::film::FilmError;
use crate::film::error::cannot_write;
use crate::film::format::VideoFormat;

/// The program, which is looked for on the PATH.
const PROGRAM: &str = "ffmpeg";

/// Options for the encoder of a format: a quality that shows no blocks on rough ground, and colours that every player reads. Encoding by
/// the preset `medium` takes four times as long, longer than drawing the frames, and makes files two thirds as large. Without arithmetic
/// coding (`-coder 0`) encoding takes a third less time, and files of the same quality (SSIM 0.989) are an eighth larger.
fn options(format: VideoFormat) -> &'static [&'static str] {
    match format {
        VideoFormat::WebM => &["-c:v", "libvpx-vp9", "-crf", "33", "-b:v", "0", "-row-mt", "1", "-f", "webm"],
        VideoFormat::Gif | VideoFormat::Mp4 => &[
            "-c:v",
            "libx264",
            "-crf",
            "21",
            "-preset",
            "superfast",
            "-coder",
            "0",
            "-movflags",
            "+faststart",
            "-f",
            "mp4",
        ],
    }
}

/// Fails if there is no ffmpeg.
pub(crate) fn check(format: VideoFormat) -> Result<(), FilmError> {
    let mut command = Command::new(PROGRAM);
    command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match command.status() {
        Ok(_) => Ok(()),
        Err(_) => Err(FilmError::NoEncoder { format: format.name() }),
    }
}

/// A running ffmpeg.
pub(crate) struct Encoder {
    child: Child,
    input: Option<ChildStdin>,
    /// Reads what ffmpeg says, so that it never waits for a reader.
    said: Option<std::thread::JoinHandle<String>>,
    /// Where it writes, which becomes `path` at the end.
    new: NewFile,
    path: PathBuf,
}

impl Encoder {
    pub(crate) fn start(format: VideoFormat, size: Size, fps: f64, path: &Path) -> Result<Self, FilmError> {
        let new = NewFile::at(path).map_err(|e| cannot_write(path, &e))?;
        let mut command = Command::new(PROGRAM);
        command.args([
            "-hide_banner",
            "-loglevel",
            "error",
            "-y",
            "-f",
            "rawvideo",
            "-pixel_format",
            "rgb24",
        ]);
        command.args(["-video_size", &format!("{}x{}", size.width, size.height)]);
        command.args(["-framerate", &fps.to_string(), "-i", "pipe:0", "-an"]);
        // No version and no time in the file.
        command.args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        // The colours of films in high definition, said in the file, so that players don't guess.
        command.args(["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p"]);
        command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]);
        command.args(options(format)).arg(file_argument(new.path()));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| match e.kind() {
            ErrorKind::NotFound => FilmError::NoEncoder { format: format.name() },
            _ => FilmError::Encoder { path: path.to_owned(), reason: e.to_string() },
        })?;
        let input = child.stdin.take();
        let said = child.stderr.take().map(|mut from| {
            std::thread::spawn(move || {
                let mut text = Vec::new();
                // What can't be read is not said.
                let _ = from.read_to_end(&mut text);
                String::from_utf8_lossy(&text).into_owned()
            })
        });
        Ok(Self { child, input, said, new, path: path.to_owned() })
    }

    /// Hands a frame over.
    pub(crate) fn take(&mut self, frame: &[u8]) -> Result<(), FilmError> {
        let failed = |reason: String| FilmError::Encoder { path: self.path.clone(), reason };
        let Some(input) = &mut self.input else { return Err(failed("it accepts no frames".to_owned())) };
        input.write_all(frame).map_err(|e| failed(e.to_string()))
    }

    /// Ends the file. If ffmpeg failed, what it said is the reason, whatever `drawn` is: its pipe broke then.
    pub(crate) fn finish(mut self, drawn: Result<(), FilmError>) -> Result<(), FilmError> {
        self.input = None;
        let failed = |reason: String| FilmError::Encoder { path: self.path.clone(), reason };
        let status = self.child.wait().map_err(|e| failed(e.to_string()))?;
        let said = self.said.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        if !status.success() {
            let last = said.lines().rev().find(|l| !l.trim().is_empty());
            return Err(failed(last.map_or_else(|| status.to_string(), |l| l.trim().to_owned())));
        }
        drawn?;
        self.new.finish().map_err(|e| cannot_write(&self.path, &e))
    }
}

/// A file as an argument that ffmpeg takes for nothing else, such as an option or a protocol.
fn file_argument(path: &Path) -> std::ffi::OsString {
    let mut argument = std::ffi::OsString::from("file:");
    argument.push(path);
    argument
}
