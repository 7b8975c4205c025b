//! Bare samples whose layout is said elsewhere: ESRI's .bil and .flt with a header (.hdr), tiles of SRTM (.hgt) by size and name.

use std::collections::BTreeMap;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use super::ascii_grid::projection;
use super::finish::{Found, Lay};
use super::format::Tile;
use super::geotiff::number;
use super::{Flaw, check_size, open};
use crate::ElevationImage;
use crate::crs::Crs;

/// Longest header, in bytes.
const HEADER: u64 = 1 << 16;
/// The void of SRTM.
const VOID: f64 = -32768.0;

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Unsigned,
    Signed,
    Float,
}

/// A header as words: keys in upper case with their values.
struct Header {
    name: String,
    fields: BTreeMap<String, String>,
}

impl Header {
    fn read(path: &Path) -> Result<Self, Flaw> {
        let name = path.display().to_string();
        let text = vb_files::read_text(path, HEADER)
            .map_err(|e| Flaw::Damaged(format!("its header {name} can't be read: {e}")))?;
        if text.trim_start().starts_with("ENVI") {
            return Err(Flaw::Format(
                "has an ENVI header, which is not supported: convert it with gdal_translate -of GTiff -co COMPRESS=DEFLATE IN OUT.tif".into(),
            ));
        }
        let mut fields = BTreeMap::new();
        for line in text.lines() {
            let mut words = line.split_whitespace();
            if let (Some(key), Some(value)) = (words.next(), words.next()) {
                fields.insert(key.to_ascii_uppercase(), value.to_owned());
            }
        }
        Ok(Self { name, fields })
    }

    fn text(&self, key: &str) -> Option<String> {
        self.fields.get(key).map(|v| v.to_ascii_uppercase())
    }

    fn float(&self, key: &str) -> Result<Option<f64>, Flaw> {
        let Some(text) = self.fields.get(key) else { return Ok(None) };
        number(text).map(Some).ok_or_else(|| {
            Flaw::Damaged(format!("{} in {} is {text:?}, which is not a number", key, self.name))
        })
    }

    fn count(&self, key: &str) -> Result<Option<u64>, Flaw> {
        let whole = |v: &f64| *v >= 0.0 && v.fract() == 0.0 && *v < 1e15;
        match self.float(key)? {
            None => Ok(None),
            Some(v) if whole(&v) => Ok(Some(v as u64)),
            Some(v) => Err(Flaw::Damaged(format!("{key} in {} is {v}: must be a whole number", self.name))),
        }
    }
}

/// Reads samples beside a header.
pub(super) fn read(path: &Path, header: &Path, size: u64) -> Result<Found, Flaw> {
    let header = Header::read(header)?;
    let need =
        |key: &str, v: Option<u64>| v.ok_or_else(|| Flaw::Damaged(format!("{} lacks {key}", header.name)));
    let (rows, cols) = (need("NROWS", header.count("NROWS")?)?, need("NCOLS", header.count("NCOLS")?)?);
    check_size(rows, cols)?;
    let bands = header.count("NBANDS")?.unwrap_or(1);
    if bands != 1 {
        return Err(Flaw::Rank(format!(
            "{bands} bands: select the height band with gdal_translate -b 1 IN OUT.tif"
        )));
    }
    let float_grid = header.text("CELLSIZE").is_some() && header.text("NBITS").is_none();
    let bits = header.count("NBITS")?.unwrap_or(if float_grid { 32 } else { 8 });
    let kind = match header.text("PIXELTYPE").as_deref() {
        Some(t) if t.starts_with("SIGNED") => Kind::Signed,
        Some(t) if t.starts_with("UNSIGNED") => Kind::Unsigned,
        Some(t) if t.starts_with("FLOAT") => Kind::Float,
        Some(t) => {
            return Err(Flaw::Damaged(format!(
                "PIXELTYPE in {} is {t}: must be SIGNEDINT, UNSIGNEDINT or FLOAT",
                header.name
            )));
        }
        None if float_grid => Kind::Float,
        // Heights may be below the sea; of 8 bits they are levels.
        None if bits == 8 => Kind::Unsigned,
        None => Kind::Signed,
    };
    if !matches!((kind, bits), (Kind::Float, 32 | 64) | (Kind::Signed | Kind::Unsigned, 8 | 16 | 32)) {
        return Err(Flaw::Unsupported(format!(
            "samples are {kind:?} of {bits} bits: convert them with gdal_translate -ot Float32 -co COMPRESS=DEFLATE IN OUT.tif"
        )));
    }
    let big = match header.text("BYTEORDER").as_deref() {
        None | Some("I" | "LSBFIRST" | "LSB" | "INTEL") => false,
        Some("M" | "MSBFIRST" | "MSB" | "MOTOROLA") => true,
        Some(other) => {
            return Err(Flaw::Damaged(format!("BYTEORDER in {} is {other}: must be I or M", header.name)));
        }
    };
    let bytes = bits / 8;
    let skipped = header.count("SKIPBYTES")?.unwrap_or(0);
    let row = header
        .count("BANDROWBYTES")?
        .max(header.count("TOTALROWBYTES")?)
        .unwrap_or(cols * bytes)
        .max(cols * bytes);
    let needed = row.checked_mul(rows - 1).and_then(|n| n.checked_add(skipped)?.checked_add(cols * bytes));
    if needed.is_none_or(|needed| size < needed) {
        let needed = needed.map_or("more than there can be".to_owned(), |n| n.to_string());
        return Err(Flaw::Truncated(format!(
            "{size} bytes, but {cols} x {rows} samples of {bits} bits need {needed}"
        )));
    }
    let layout =
        Samples { rows: rows as usize, cols: cols as usize, skipped, row, bytes: bytes as usize, kind, big };
    let values = layout.read(path)?;
    let mark = header.float("NODATA")?.or(header.float("NODATA_VALUE")?);
    let end = |v: f64, m: f64| m.abs() > 1e37 && v.abs() > 1e37 && v.signum() == m.signum();
    let no_data = mark.map(|m| {
        values
            .iter()
            .map(|v| *v == m || *v == f64::from(m as f32) || end(*v, m) || (v.is_nan() && m.is_nan()))
            .collect()
    });
    let side = |key: &str| Ok::<_, Flaw>(header.float(key)?.or(header.float("CELLSIZE")?));
    let lay = match (side("XDIM")?, side("YDIM")?) {
        (Some(x), Some(y)) => {
            let middle = |low: &str, high: f64| -> Result<Option<f64>, Flaw> {
                let corner = header.float(&format!("{low}CORNER"))?.map(|v| v + 0.5 * high);
                Ok(corner
                    .or(header.float(&format!("{low}CENTER"))?)
                    .or(header.float(&format!("{low}CENTRE"))?))
            };
            let west = header.float("ULXMAP")?.or(middle("XLL", x)?);
            let north = match header.float("ULYMAP")? {
                Some(north) => Some(north),
                None => middle("YLL", y)?.map(|south| south + (rows - 1) as f64 * y),
            };
            Some(Lay::north_up(west.zip(north).map(|(x, y)| [x, y]), [x, y]))
        }
        _ => None,
    };
    let (crs, unit) = projection(path)?;
    let raster = ElevationImage::new(layout.rows, layout.cols, values);
    Ok(Found { no_data: no_data.unwrap_or_default(), lay, crs, unit, ..Found::plain("binary grid", raster) })
}

/// Reads a tile of SRTM: big-endian samples of 16 bits on whole fractions of a degree, its outermost ones on whole degrees.
pub(super) fn srtm(path: &Path, tile: &Tile) -> Result<Found, Flaw> {
    let Tile { corner, rows, cols } = *tile;
    let Some([west, south]) = corner else {
        return Err(Flaw::Coordinates(
            "its name has no position: name it after its south-western corner, e.g. N44W072.hgt".into(),
        ));
    };
    let layout =
        Samples { rows, cols, skipped: 0, row: 2 * cols as u64, bytes: 2, kind: Kind::Signed, big: true };
    let values = layout.read(path)?;
    let no_data = values.iter().map(|v| *v == VOID).collect();
    let step = [1.0 / (cols - 1) as f64, 1.0 / (rows - 1) as f64];
    let lay = Some(Lay::north_up(Some([f64::from(west), f64::from(south) + 1.0]), step));
    let crs = Some(Crs::wgs84());
    let unit = Some(crate::crs::Length::metre());
    Ok(Found {
        no_data,
        lay,
        crs,
        unit,
        ..Found::plain("SRTM tile", ElevationImage::new(rows, cols, values))
    })
}

/// Rows of numbers in a file.
struct Samples {
    rows: usize,
    cols: usize,
    skipped: u64,
    /// Bytes from row to row.
    row: u64,
    bytes: usize,
    kind: Kind,
    big: bool,
}

impl Samples {
    fn read(&self, path: &Path) -> Result<Vec<f64>, Flaw> {
        let mut source = open(path)?;
        source.seek(SeekFrom::Start(self.skipped))?;
        let mut values = Vec::with_capacity(self.rows * self.cols);
        let mut line = vec![0; self.cols * self.bytes];
        let gap = self.row - line.len() as u64;
        for r in 0..self.rows {
            if r > 0 && gap > 0 {
                source.seek_relative(i64::try_from(gap).unwrap_or(i64::MAX))?;
            }
            source.read_exact(&mut line).map_err(|e| match e.kind() {
                std::io::ErrorKind::UnexpectedEof => Flaw::Truncated(format!("it ends within row {r}")),
                _ => Flaw::Unreadable(e),
            })?;
            values.extend(line.chunks_exact(self.bytes).map(|b| self.number(b)));
        }
        Ok(values)
    }

    fn number(&self, bytes: &[u8]) -> f64 {
        let add = |n: u64, b: &u8| n << 8 | u64::from(*b);
        let n = if self.big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
        match (self.kind, self.bytes) {
            (Kind::Unsigned, _) => n as f64,
            (Kind::Signed, 1) => f64::from(n as u8 as i8),
            (Kind::Signed, 2) => f64::from(n as u16 as i16),
            (Kind::Signed, _) => f64::from(n as u32 as i32),
            (Kind::Float, 4) => f64::from(f32::from_bits(n as u32)),
            (Kind::Float, _) => f64::from_bits(n),
        }
    }
}
