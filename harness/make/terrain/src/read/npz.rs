//! NumPy's archives (.npz): ZIP files of arrays.

use std::io::{BufRead, Cursor, Read as _, Seek};

use zip::ZipArchive;

use super::finish::Found;
use super::npy::{self, Array};
use super::{Flaw, MAX_SAMPLES, line};

/// Most files in an archive that are looked at.
const MOST: usize = 1000;
/// Most bytes of an array.
const MAX_BYTES: u64 = 8 * MAX_SAMPLES + HEADER;
/// Bytes in which the header of an array ends.
const HEADER: u64 = 1 << 13;

/// Reads the one array of heights of an archive.
pub(super) fn read(source: impl BufRead + Seek) -> Result<Found, Flaw> {
    let damaged = |e: &dyn std::fmt::Display| Flaw::Damaged(line(e));
    let mut archive = ZipArchive::new(source).map_err(|e| damaged(&e))?;
    if archive.len() > MOST {
        return Err(Flaw::TooLarge {
            found: archive.len() as u64,
            limit: MOST as u64,
            unit: "files in the archive",
        });
    }
    let arrays: Vec<String> = archive
        .file_names()
        .flatten()
        .map(std::borrow::Cow::into_owned)
        .filter(|n| n.ends_with(".npy"))
        .collect();
    if arrays.is_empty() {
        return Err(Flaw::Format("is an archive (ZIP) without a NumPy array: unpack it".into()));
    }
    let mut unpacked = |name: &str, most: u64| -> Result<Vec<u8>, Flaw> {
        let file = archive.by_name(name).map_err(|e| damaged(&e))?;
        let mut bytes = Vec::new();
        file.take(most).read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
        Ok(bytes)
    };
    // One array is taken whatever it is, so that its flaw is told.
    let mut wanted = arrays.clone();
    if arrays.len() > 1 {
        wanted = Vec::new();
        for name in &arrays {
            let start = unpacked(name, HEADER)?;
            if Array::open(Cursor::new(start)).is_ok_and(|a| a.rows > 1 && a.cols > 1) {
                wanted.push(name.clone());
            }
        }
    }
    let [name] = wanted.as_slice() else {
        let mut names: Vec<&str> = arrays.iter().map(|n| n.trim_end_matches(".npy")).take(10).collect();
        names.sort_unstable();
        return Err(Flaw::Rank(format!(
            "{} arrays ({}), {} of them with two dimensions: save only the heights with numpy.save",
            arrays.len(),
            names.join(", "),
            wanted.len()
        )));
    };
    let bytes = unpacked(name, MAX_BYTES + 1)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Flaw::TooLarge {
            found: bytes.len() as u64,
            limit: MAX_BYTES,
            unit: "bytes (or more) of an array",
        });
    }
    let raster = npy::raster(Cursor::new(bytes))?;
    let mut found = Found::plain("NumPy archive", raster);
    if arrays.len() > 1 {
        found.notes.push(format!(
            "of {} arrays {} is read, the only one with two dimensions",
            arrays.len(),
            name.trim_end_matches(".npy")
        ));
    }
    Ok(found)
}
