//! NumPy arrays of two dimensions.

use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::{Flaw, Found, check_size, line};
use crate::ElevationImage;

const WANTED: &str = "f4, f8, u1, u2 or i2";

/// Longest header of an array that is no record, in bytes: NumPy's take 118.
const HEADER: usize = 4096;
/// Brackets that open in it at most: those of the shape, of order and kind.
const BRACKETS: usize = 16;

/// Refuses headers on which the reader of arrays would spend all memory or time there is: it takes memory for whatever length they
/// state, and twice the time for every bracket within another.
fn check_header(path: &Path) -> Result<(), Flaw> {
    let mut start = Vec::new();
    vb_files::open(path)?.take(HEADER as u64).read_to_end(&mut start)?;
    let length = match start.get(6..12) {
        Some(&[1, _, a, b, ..]) => usize::from(u16::from_le_bytes([a, b])),
        Some(&[_, _, a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as usize,
        _ => 0,
    };
    if length > HEADER {
        return Err(Flaw::Damaged(format!("its header states {length} bytes, more than {HEADER}")));
    }
    let header = &start[..start.len().min(length + 12)];
    if header.iter().filter(|b| b"([{".contains(b)).count() > BRACKETS {
        return Err(Flaw::Damaged("its header has brackets within brackets".into()));
    }
    Ok(())
}

/// Reads an array of floats or small integers.
pub(super) fn read(path: &Path) -> Result<Found, Flaw> {
    let size = std::fs::metadata(path)?.len();
    check_header(path)?;
    let file = NpyFile::new(BufReader::new(vb_files::open(path)?)).map_err(|e| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => Flaw::Truncated("it ends in the header".into()),
        _ => Flaw::Damaged(line(&e)),
    })?;
    let &[rows, cols] = file.shape() else {
        return Err(Flaw::Rank(format!("an array of {} dimensions", file.shape().len())));
    };
    check_size(rows, cols)?;
    let DType::Plain(kind) = file.dtype() else {
        return Err(Flaw::Type { found: "records".into(), wanted: WANTED });
    };
    // Before memory is taken for them: the file is at least as long as its samples.
    let needed = rows * cols * kind.size_field();
    if size < needed {
        return Err(Flaw::Truncated(format!("{size} bytes, but {rows} x {cols} samples need {needed}")));
    }
    let order = file.order();
    let values = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Float, 4) => samples::<f32>(file)?,
        (TypeChar::Float, 8) => samples::<f64>(file)?,
        (TypeChar::Uint, 1) => samples::<u8>(file)?,
        (TypeChar::Uint, 2) => samples::<u16>(file)?,
        (TypeChar::Int, 2) => samples::<i16>(file)?,
        _ => return Err(Flaw::Type { found: kind.to_string(), wanted: WANTED }),
    };
    let (rows, cols) = (rows as usize, cols as usize);
    let values = match order {
        Order::C => values,
        Order::Fortran => (0..rows * cols).map(|i| values[i % cols * rows + i / cols]).collect(),
    };
    Ok(Found { raster: ElevationImage::new(rows, cols, values), no_data: Vec::new() })
}

fn samples<T: Deserialize + Into<f64>>(file: NpyFile<BufReader<File>>) -> Result<Vec<f64>, Flaw> {
    let data = file.data::<T>().map_err(|e| Flaw::Damaged(line(&e)))?;
    data.map(|v| v.map(Into::into)).collect::<Result<_, _>>().map_err(|e| Flaw::Truncated(line(&e)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both were found by libFuzzer.
    #[test]
    fn headers_that_would_take_all_memory_or_time_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.npy");
        let nested = format!("{{'descr': '<f4', 'shape': ({}2, 3), }}", "[".repeat(60));
        let length = (nested.len() as u16).to_le_bytes();
        let nested = [b"\x93NUMPY\x01\x00", &length[..], nested.as_bytes()].concat();
        let endless = [&b"\x93NUMPY\x02\x00\x00\x00\xfb\xff"[..], &[b' '; 200]].concat();
        for bytes in [nested, endless] {
            std::fs::write(&path, bytes).unwrap();
            assert!(matches!(read(&path), Err(Flaw::Damaged(_))));
        }
    }
}
