//! Readers of elevation files: GeoTIFF, ESRI grids (ASCII and binary with a header), SRTM tiles, NumPy arrays and archives, PNG and BMP,
//! OpenCRG.
//!
//! The content decides on the format, not the name. Whatever is wrong with a file is one line: what, where, what to do. Sizes are
//! checked before memory is taken. [`survey()`] tells all that a file says about its heights; [`read`] returns the heights alone.
//! [`npy::Array`] and [`picture::Picture`] are the readers for callers that want more of a file than heights, such as the
//! import of the original's data.

mod ascii_grid;
mod binary_grid;
mod crg;
mod finish;
mod format;
mod geotiff;
pub mod npy;
mod npz;
pub mod picture;
mod sidecar;
mod survey;
mod suspect;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::ElevationImage;
use finish::{Found, finish};
use format::Format;

pub use crg::{CourseFile, course};
pub use survey::{Options, Place, Said, Survey, short};

/// What GeoTIFFs are read from.
type Source = tiff::decoder::Decoder<BufReader<File>>;

/// Most samples that a file may hold: 16 384 × 16 384.
pub const MAX_SAMPLES: u64 = 1 << 28;
/// The format of [`Survey`]s of pictures, whose values are grey levels and no heights.
pub const PICTURE: &str = "picture";
/// Longest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 32;

/// What to do with places that a file marks as not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Holes {
    /// They are an error: the surface must be whole.
    #[default]
    Refuse,
    /// They become NaN in the raster.
    Keep,
}

#[derive(Debug, Error)]
#[error("{}: {flaw}", path.display())]
pub struct ReadError {
    pub path: PathBuf,
    pub flaw: Flaw,
}

#[derive(Debug, Error)]
pub enum Flaw {
    #[error("can't be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The content is none that there is a reader for.
    #[error("{0}")]
    Format(String),
    #[error("{found} {unit} are more than {limit}: cut it into parts")]
    TooLarge { found: u64, limit: u64, unit: &'static str },
    #[error("is truncated ({0}): restore the file")]
    Truncated(String),
    #[error("{0}: it is damaged, restore it")]
    Damaged(String),
    /// It is sound, but stored in a way that is not read; the text says how to convert it.
    #[error("{0}")]
    Unsupported(String),
    /// A line of a text file, counted from 1, is at fault.
    #[error("line {line}: {problem}")]
    Line { line: usize, problem: String },
    /// It has another number of dimensions than two, or several bands.
    #[error("holds {0}")]
    Rank(String),
    #[error("samples are {found}: must be {wanted}")]
    Type { found: String, wanted: &'static str },
    #[error("has {rows} rows and {cols} columns: a surface needs at least 2 of each")]
    TooSmall { rows: u64, cols: u64 },
    #[error(
        "{count} samples are marked as no data (first at row {row}, column {col}): fill the holes or cut a part without"
    )]
    NoData {
        count: usize,
        /// Row of the first, from the north.
        row: usize,
        /// Column of the first, from the west.
        col: usize,
    },
    #[error(
        "{count} samples are NaN or infinite (first at row {row}, column {col}): fill the holes or mark them as no data"
    )]
    NotFinite {
        count: usize,
        /// Row of the first, from the north.
        row: usize,
        /// Column of the first, from the west.
        col: usize,
    },
    /// Some heights are values that programs use for places without one, far from all others, and not marked so.
    #[error(
        "{count} samples are {value}, far from all others, which looks like unmarked no data: mark it with gdal_edit.py -a_nodata {value}, and fill the holes"
    )]
    Unmarked { value: f64, count: usize },
    #[error("all samples are marked as no data: use another file or band")]
    NoHeights,
    #[error(
        "its no-data value is {0:?}, which is not a number: correct it with gdal_edit.py -a_nodata VALUE, or give the value with --no-data"
    )]
    Mark(String),
    #[error("heights are in {0}, which is an unknown unit: give its length in metres with --unit")]
    HeightUnit(String),
    /// Its coordinate system or pixel size can't be used.
    #[error("{0}")]
    Coordinates(String),
}

/// Reads an elevation file. Heights are in metres where the file says or implies their unit, grey levels of pictures as whole
/// numbers.
pub fn read(path: &Path, holes: Holes) -> Result<ElevationImage, ReadError> {
    survey(path, &Options { holes, ..Options::default() }).map(|survey| survey.heights)
}

/// Reads an elevation file with what it says of its heights and of their place.
///
/// # Errors
/// [`ReadError`]: whatever keeps the file from being a surface, and what can't be known without a choice of the user's.
pub fn survey(path: &Path, options: &Options) -> Result<Survey, ReadError> {
    let inner = || {
        let size = std::fs::metadata(path)?.len();
        if size > MAX_BYTES {
            return Err(Flaw::TooLarge { found: size, limit: MAX_BYTES, unit: "bytes" });
        }
        let mut found = match Format::of(path, size)? {
            Format::Picture => decoded(|| picture::read(open(path)?))?,
            Format::Array => decoded(|| npy::read(open(path)?))?,
            Format::Archive => decoded(|| npz::read(open(path)?))?,
            Format::Tiff => decoded(|| geotiff::read(path, options))?,
            Format::AsciiGrid => ascii_grid::read(path, size)?,
            Format::BinaryGrid(header) => binary_grid::read(path, &header, size)?,
            Format::Srtm(tile) => binary_grid::srtm(path, &tile)?,
            Format::Course => crg::found(path)?,
        };
        sidecar::apply(path, &mut found, options)?;
        finish(found, options)
    };
    inner().map_err(|flaw| ReadError { path: path.to_owned(), flaw })
}

/// Tells whether a file is a course of OpenCRG, by its content; also `false` for one that can't be read.
#[must_use]
pub fn is_course(path: &Path) -> bool {
    Format::of(path, 0).is_ok_and(|format| format == Format::Course)
}

/// Reads with a library that may panic on a damaged file.
fn decoded<T>(read: impl FnOnce() -> Result<T, Flaw>) -> Result<T, Flaw> {
    vb_files::decoding(read).unwrap_or_else(|problem| Err(Flaw::Damaged(problem)))
}

fn open(path: &Path) -> Result<BufReader<File>, Flaw> {
    Ok(BufReader::new(vb_files::open(path)?))
}

/// Refuses sizes that are no surface or too large, before memory is taken.
fn check_size(rows: u64, cols: u64) -> Result<(), Flaw> {
    if rows < 2 || cols < 2 {
        return Err(Flaw::TooSmall { rows, cols });
    }
    match rows.checked_mul(cols) {
        Some(n) if n <= MAX_SAMPLES => Ok(()),
        n => Err(Flaw::TooLarge { found: n.unwrap_or(u64::MAX), limit: MAX_SAMPLES, unit: "samples" }),
    }
}

/// One line of a library's error.
fn line(e: &dyn std::fmt::Display) -> String {
    vb_files::one_line(&e.to_string())
}
