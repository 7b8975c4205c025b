//! NumPy arrays of two dimensions.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};

use super::{Flaw, Found, check_size, line};
use crate::Raster;

const WANTED: &str = "f4, f8, u1, u2 or i2";

/// Reads an array of floats or small integers.
pub(super) fn read(path: &Path) -> Result<Found, Flaw> {
    let size = std::fs::metadata(path)?.len();
    let file = NpyFile::new(BufReader::new(File::open(path)?)).map_err(|e| match e.kind() {
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
    Ok(Found { raster: Raster::new(rows, cols, values), no_data: Vec::new() })
}

fn samples<T: Deserialize + Into<f64>>(file: NpyFile<BufReader<File>>) -> Result<Vec<f64>, Flaw> {
    let data = file.data::<T>().map_err(|e| Flaw::Damaged(line(&e)))?;
    data.map(|v| v.map(Into::into)).collect::<Result<_, _>>().map_err(|e| Flaw::Truncated(line(&e)))
}
