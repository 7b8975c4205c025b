//! Readers of elevation files: BMP, PNG, NumPy arrays and GeoTIFF.
//!
//! Whatever is wrong with a file is one line: what, where, what to do. Sizes are checked before memory is taken.
//! [`npy::Array`] and [`picture::Picture`] are the readers for callers that want more of a file than heights, such as the
//! import of the original's data.

mod geotiff;
pub mod npy;
pub mod picture;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::ElevationImage;

/// Most samples that a file may hold: 16 384 × 16 384.
pub const MAX_SAMPLES: u64 = 1 << 28;
/// Longest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 32;

/// What to do with places that a file marks as not measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holes {
    /// They are an error: the surface must be whole.
    Refuse,
    /// They become NaN in the raster.
    Keep,
}

/// Why an elevation file can't be used.
#[derive(Debug, Error)]
#[error("{}: {flaw}", path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub flaw: Flaw,
}

/// What is wrong with an elevation file.
#[derive(Debug, Error)]
pub enum Flaw {
    /// The file can't be opened or read.
    #[error("can't be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The name's ending is none that there is a reader for.
    #[error("ending {0:?} is not known: must be .bmp, .png, .npy, .tif or .tiff")]
    Ending(String),
    /// It holds more than a reader takes.
    #[error("{found} {unit} are more than {limit}: cut it into parts")]
    TooLarge {
        /// How many there are.
        found: u64,
        /// How many may be.
        limit: u64,
        /// Of what.
        unit: &'static str,
    },
    /// It ends before its data do.
    #[error("was cut short ({0}): restore the file")]
    Truncated(String),
    /// It is not what its ending says, or damaged.
    #[error("{0}: it is damaged or another format, restore it or give it its own ending")]
    Damaged(String),
    /// It has another number of dimensions than two, or several bands.
    #[error("holds {0}: must be one two-dimensional band")]
    Rank(String),
    /// Its samples are of a type that heights are not stored in.
    #[error("samples are {found}: must be {wanted}")]
    Type {
        /// The type in the file.
        found: String,
        /// Those that are read.
        wanted: &'static str,
    },
    /// It is no surface.
    #[error("has {rows} rows and {cols} columns: a surface needs at least 2 of each")]
    TooSmall {
        /// Number of rows.
        rows: u64,
        /// Number of columns.
        cols: u64,
    },
    /// Some places are marked as not measured.
    #[error(
        "{count} samples are marked as no data (first at row {row}, column {col}): fill the holes or cut a part without"
    )]
    NoData {
        /// How many.
        count: usize,
        /// Row of the first, from the north.
        row: usize,
        /// Column of the first, from the west.
        col: usize,
    },
    /// Some heights are no numbers.
    #[error(
        "{count} samples are NaN or infinite (first at row {row}, column {col}): fill the holes or mark them as no data"
    )]
    NotFinite {
        /// How many.
        count: usize,
        /// Row of the first, from the north.
        row: usize,
        /// Column of the first, from the west.
        col: usize,
    },
    /// Its places are longitudes and latitudes.
    #[error(
        "coordinates are degrees (geographic coordinate system): reproject it to one in metres, such as its UTM zone"
    )]
    Degrees,
    /// Its coordinate system or pixel size can't be used.
    #[error("{0}")]
    Coordinates(String),
}

/// Reads an elevation file by the ending of its name. Heights are as the file has them, grey levels of pictures as whole
/// numbers; lengths of a GeoTIFF in feet become metres.
///
/// # Errors
/// [`ReadError`]: whatever keeps the file from being a surface.
pub fn read(path: &Path, holes: Holes) -> Result<ElevationImage, ReadError> {
    let inner = || {
        let size = std::fs::metadata(path)?.len();
        if size > MAX_BYTES {
            return Err(Flaw::TooLarge { found: size, limit: MAX_BYTES, unit: "bytes" });
        }
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let raster = match ending.as_str() {
            "bmp" | "png" => picture::read(open(path)?)?,
            "npy" => npy::read(open(path)?)?,
            "tif" | "tiff" => geotiff::read(path)?,
            _ => return Err(Flaw::Ending(ending)),
        };
        checked(raster, holes)
    };
    inner().map_err(|flaw| ReadError { path: path.to_owned(), flaw })
}

fn open(path: &Path) -> Result<BufReader<File>, Flaw> {
    Ok(BufReader::new(vb_files::open(path)?))
}

/// What a reader found: samples, and those that the file marks as not measured.
struct Found {
    raster: ElevationImage,
    /// Row-major; empty where the format knows no such mark.
    no_data: Vec<bool>,
}

/// Refuses or keeps what is no height.
fn checked(found: Found, holes: Holes) -> Result<ElevationImage, Flaw> {
    let Found { mut raster, no_data } = found;
    let cols = raster.cols();
    if holes == Holes::Refuse {
        let count = no_data.iter().filter(|hole| **hole).count();
        if let Some(i) = no_data.iter().position(|hole| *hole) {
            return Err(Flaw::NoData { count, row: i / cols, col: i % cols });
        }
        let odd = |v: &f64| !v.is_finite();
        if let Some(i) = raster.values().iter().position(odd) {
            let count = raster.values().iter().filter(|v| odd(v)).count();
            return Err(Flaw::NotFinite { count, row: i / cols, col: i % cols });
        }
    }
    for (i, v) in raster.values_mut().iter_mut().enumerate() {
        if !v.is_finite() || no_data.get(i) == Some(&true) {
            *v = f64::NAN;
        }
    }
    Ok(raster)
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
    e.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
