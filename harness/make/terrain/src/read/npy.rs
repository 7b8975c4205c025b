//! NumPy arrays of two dimensions (versions 1 to 3 of the format, NEP 1), or of three of which one is 1.
//!
//! The library that reads the header takes memory for whatever length the file states, twice the time for every
//! bracket within another, and multiplies the sides of the shape without a bound. So the start of a file is looked at
//! before the library sees it.

use std::io::{BufRead, Read as _, Seek, SeekFrom};

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::{Flaw, Found, check_size, line};
use crate::ElevationImage;

const WANTED: &str = "floats or whole numbers of up to 8 bytes (f2 to f8, i1 to i8, u1 to u8)";

/// The first bytes of every array.
const MAGIC: &[u8] = b"\x93NUMPY";
/// Longest header of an array that is no record, in bytes: NumPy's take 118.
const HEADER: usize = 4096;
/// Brackets that open in it at most: those of the shape, of order and kind.
const BRACKETS: usize = 16;
/// Digits in it at most: the product of numbers that have so many digits together is less than 2⁶⁴.
const DIGITS: usize = 19;

/// A two-dimensional array, or one of three dimensions of which the first or the last is 1, whose header was read and whose samples were not, so that a caller can refuse it before
/// memory is taken for them.
pub struct Array<R: BufRead> {
    /// The number of rows, the first number of the shape.
    pub rows: u64,
    /// The number of columns, the second number of the shape.
    pub cols: u64,
    /// The number of bytes behind the header, as long as the source is.
    pub data_bytes: u64,
    file: NpyFile<R>,
}

impl<R: BufRead + Seek> Array<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`Flaw`]: the source is no array, is cut short in its header, or has other dimensions.
    pub fn open(mut source: R) -> Result<Self, Flaw> {
        let size = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(0))?;
        check_header(&mut source)?;
        source.seek(SeekFrom::Start(0))?;
        let mut file = NpyFile::new(source).map_err(|e| match e.kind() {
            std::io::ErrorKind::UnexpectedEof => Flaw::Truncated(format!("{size} bytes, within its header")),
            _ => Flaw::Damaged(line(&e)),
        })?;
        let (rows, cols) = match *file.shape() {
            [rows, cols] | [1, rows, cols] | [rows, cols, 1] => (rows, cols),
            ref shape => {
                let sides: Vec<_> = shape.iter().map(u64::to_string).collect();
                return Err(Flaw::Rank(format!(
                    "an array of {} dimensions ({}): must have two",
                    shape.len(),
                    sides.join(" x ")
                )));
            }
        };
        let header = file.header().clone();
        let mut source = file.into_inner();
        let data_bytes = size - source.stream_position()?;
        file = NpyFile::with_header(header, source);
        Ok(Self { rows, cols, data_bytes, file })
    }

    /// The type of the samples as the header states it, in quotes as there, such as `'<i4'`.
    #[must_use]
    pub fn dtype(&self) -> String {
        self.file.dtype().descr()
    }

    /// Whether the samples lie column by column (Fortran's order) and not row by row (C's order).
    #[must_use]
    pub fn is_fortran(&self) -> bool {
        self.file.order() == Order::Fortran
    }

    /// Reads the samples, in the order in which they lie.
    ///
    /// # Errors
    /// [`Flaw`]: the samples are of another type than `T`, or there are too few of them; the latter is found before
    /// memory is taken for them.
    pub fn samples<T: Deserialize>(self) -> Result<Vec<T>, Flaw> {
        let bytes = self.file.dtype().num_bytes().unwrap_or(0) as u64;
        let needed = self.rows.checked_mul(self.cols).and_then(|n| n.checked_mul(bytes));
        let (found, rows, cols) = (self.data_bytes, self.rows, self.cols);
        if needed.is_none_or(|needed| found < needed) {
            let needed = needed.map_or("more than there can be".to_owned(), |n| n.to_string());
            return Err(Flaw::Truncated(format!(
                "{found} bytes of samples, but {rows} x {cols} of them need {needed}"
            )));
        }
        let data = self.file.data::<T>().map_err(|e| Flaw::Damaged(line(&e)))?;
        data.collect::<Result<_, _>>().map_err(|e| Flaw::Truncated(line(&e)))
    }
}

/// Refuses what is no array, and headers on which the library would spend all memory or time there is, or overflow.
fn check_header(source: &mut impl std::io::Read) -> Result<(), Flaw> {
    let mut start = Vec::new();
    source.take(HEADER as u64 + 12).read_to_end(&mut start)?;
    if !start.starts_with(MAGIC) {
        return Err(Flaw::Damaged("is not a NumPy array (it does not begin with \\x93NUMPY)".into()));
    }
    let (length, text) = match start.get(6..12) {
        Some(&[1, _, a, b, ..]) => (usize::from(u16::from_le_bytes([a, b])), 10),
        Some(&[2 | 3, _, a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as usize, 12),
        Some(&[version, ..]) => {
            return Err(Flaw::Damaged(format!("version {version} of the array's format is not supported")));
        }
        _ => return Err(Flaw::Truncated(format!("{} bytes, within its header", start.len()))),
    };
    if length > HEADER {
        return Err(Flaw::Damaged(format!("its header states {length} bytes, more than {HEADER}")));
    }
    let header = &start[text..start.len().min(text + length)];
    let count = |of: &[u8]| header.iter().filter(|b| of.contains(b)).count();
    if count(b"([{") > BRACKETS {
        return Err(Flaw::Damaged("its header has nested brackets".into()));
    }
    if count(b"0123456789") > DIGITS {
        return Err(Flaw::Damaged(format!("its header has numbers of more than {DIGITS} digits together")));
    }
    Ok(())
}

/// Reads an array of floats or small integers as heights.
pub(super) fn read(source: impl BufRead + Seek) -> Result<Found, Flaw> {
    let raster = raster(source)?;
    Ok(Found::plain("NumPy array", raster))
}

/// The numbers of an array as they are, first row first.
pub(super) fn raster(source: impl BufRead + Seek) -> Result<ElevationImage, Flaw> {
    let array = Array::open(source)?;
    check_size(array.rows, array.cols)?;
    let DType::Plain(kind) = array.file.dtype() else {
        return Err(Flaw::Type { found: "records".into(), wanted: WANTED });
    };
    let (rows, cols, fortran) = (array.rows as usize, array.cols as usize, array.is_fortran());
    let values = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 2) => wide::<half::f16, _>(array)?,
        (TypeChar::Float, 4) => wide::<f32, _>(array)?,
        (TypeChar::Float, 8) => array.samples()?,
        (TypeChar::Uint, 1) => wide::<u8, _>(array)?,
        (TypeChar::Uint, 2) => wide::<u16, _>(array)?,
        (TypeChar::Uint, 4) => wide::<u32, _>(array)?,
        (TypeChar::Uint, 8) => array.samples::<u64>()?.into_iter().map(|v| v as f64).collect(),
        (TypeChar::Int, 1) => wide::<i8, _>(array)?,
        (TypeChar::Int, 2) => wide::<i16, _>(array)?,
        (TypeChar::Int, 4) => wide::<i32, _>(array)?,
        (TypeChar::Int, 8) => array.samples::<i64>()?.into_iter().map(|v| v as f64).collect(),
        (TypeChar::Object, _) => {
            return Err(Flaw::Type {
                found: "Python objects".into(),
                wanted: "numbers: save it with numpy.save(FILE, numpy.asarray(heights, float))",
            });
        }
        _ => return Err(Flaw::Type { found: kind.to_string(), wanted: WANTED }),
    };
    let values =
        if fortran { (0..rows * cols).map(|i| values[i % cols * rows + i / cols]).collect() } else { values };
    Ok(ElevationImage::new(rows, cols, values))
}

fn wide<T: Deserialize + Into<f64>, R: BufRead + Seek>(array: Array<R>) -> Result<Vec<f64>, Flaw> {
    Ok(array.samples::<T>()?.into_iter().map(Into::into).collect())
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// An array of the given version of the format, with this header.
    fn array(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let length = (header.len() as u32).to_le_bytes();
        let length = &length[..if version == 1 { 2 } else { 4 }];
        [b"\x93NUMPY", &[version, 0][..], length, header.as_bytes(), data].concat()
    }

    fn open(bytes: Vec<u8>) -> Result<Array<Cursor<Vec<u8>>>, Flaw> {
        Array::open(Cursor::new(bytes))
    }

    /// Six 32-bit integers in two rows.
    fn labels(version: u8) -> Vec<u8> {
        let header = "{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3), }\n";
        let data: Vec<u8> = [1i32, -2, 3, 4, 5, 600_000].iter().flat_map(|v| v.to_le_bytes()).collect();
        array(version, header, &data)
    }

    #[test]
    fn every_version_of_the_header_is_read() {
        for version in [1, 2, 3] {
            let array = open(labels(version)).unwrap();
            assert_eq!((array.rows, array.cols, array.data_bytes), (2, 3, 24));
            assert_eq!((array.dtype().as_str(), array.is_fortran()), ("'<i4'", false));
            assert_eq!(array.samples::<i32>().unwrap(), [1, -2, 3, 4, 5, 600_000]);
        }
    }

    /// The first two were found by libFuzzer; the sides of the third multiply to more than 64 bits hold.
    #[test]
    fn headers_that_would_take_all_memory_or_time_or_overflow_are_refused() {
        let nested = format!("{{'descr': '<f4', 'shape': ({}2, 3), }}", "[".repeat(60));
        let endless = [&b"\x93NUMPY\x02\x00\x00\x00\xfb\xff"[..], &[b' '; 200]].concat();
        let huge = "{'descr': '<f4', 'fortran_order': False, 'shape': (9999999999, 9999999999), }";
        for bytes in [array(1, &nested, &[]), endless, array(1, huge, &[])] {
            assert!(matches!(open(bytes), Err(Flaw::Damaged(_))));
        }
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let mut rng = vb_math::rng::Stream::new(1, &["npy"]);
        for round in 0..50_000u32 {
            let mut b = labels(1 + (round % 3) as u8);
            for _ in 0..1 + rng.below(4) {
                let at = rng.below(b.len() as u64) as usize;
                b[at] = b"'():,{} \xff\x009"[rng.below(11) as usize];
            }
            b.truncate(rng.below(2 * b.len() as u64) as usize);
            let _ = open(b).and_then(Array::samples::<i32>);
        }
    }
}
