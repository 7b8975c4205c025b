//! The original's two kinds of binary files. The readers are those of elevation files; beyond them, everything that
//! differs from the original's is refused, so that nothing of another meaning is taken for its data.

use std::io::Cursor;

use vb_terrain::read::Flaw;
use vb_terrain::read::npy::Array;
use vb_terrain::read::picture::Picture;

/// What is wrong with a file: (field, problem).
type Problem = (&'static str, String);

fn file(flaw: Flaw) -> Problem {
    ("file", flaw.to_string())
}

/// Reads labels: 32-bit integers in C order, of the given shape.
pub(crate) fn labels(bytes: &[u8], rows: usize, cols: usize) -> Result<Vec<i32>, Problem> {
    let array = Array::open(Cursor::new(bytes)).map_err(file)?;
    let order = if array.is_fortran() { "True" } else { "False" };
    let found = [
        ("descr", array.dtype(), "'<i4'".to_owned()),
        ("fortran_order", order.to_owned(), "False".to_owned()),
        ("shape", format!("({}, {})", array.rows, array.cols), format!("({rows}, {cols})")),
    ];
    for (key, value, wanted) in found {
        if value != wanted {
            return Err((key, format!("{value}: must be {wanted}")));
        }
    }
    let (found, wanted) = (array.data_bytes, rows * cols);
    if found != 4 * wanted as u64 {
        let text = format!("{} values, but the shape ({rows}, {cols}) needs {wanted}", found / 4);
        return Err(("data", text + ": restore the file"));
    }
    array.samples().map_err(file)
}

/// Reads an elevation of the given size: an 8-bit Windows bitmap without compression, with a linear grey palette. The
/// first row is on top.
pub(crate) fn elevation(bytes: &[u8], rows: usize, cols: usize) -> Result<Vec<u8>, Problem> {
    if !bytes.starts_with(b"BM") {
        return Err(("file", "is not a Windows bitmap (it does not begin with BM)".into()));
    }
    let picture = Picture::open(Cursor::new(bytes)).map_err(file)?;
    let Some(bitmap) = &picture.bitmap else {
        return Err(("file", "is not a Windows bitmap".into()));
    };
    let (bits, compression) = (bitmap.bits, bitmap.compression);
    let Some(palette) = bitmap.palette.as_ref().filter(|_| (bits, compression) == (8, 0)) else {
        let found = format!("{bits} bits a pixel, compression {compression}");
        return Err(("format", found + ": must be 8 bits, uncompressed"));
    };
    if (picture.rows, picture.cols) != (rows as u64, cols as u64) {
        let found = format!("{} x {} pixels", picture.cols, picture.rows);
        return Err(("size", format!("{found}: must be {cols} x {rows}, as the config states")));
    }
    for (k, colour) in palette.iter().enumerate() {
        if colour.iter().any(|v| usize::from(*v) != k) {
            let text = format!("entry {k} is {colour:?} (red, green, blue)");
            return Err(("palette", text + ": must be the grey of the same value"));
        }
    }
    // With this palette, greys are the bytes of the file.
    Ok(picture.greys().map_err(file)?.into_iter().map(|grey| grey as u8).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 3 × 2 image with rows [1, 2, 3] on top and [4, 5, 6] below.
    fn image() -> Vec<u8> {
        let mut b = b"BM".to_vec();
        for v in [1086u32, 0, 1078, 40, 3, 2, 8 << 16 | 1, 0, 8, 0, 0, 0, 0] {
            b.extend(v.to_le_bytes());
        }
        b.extend((0..=255u8).flat_map(|k| [k, k, k, 0]));
        b.extend([4, 5, 6, 0, 1, 2, 3, 0]);
        b
    }

    /// Six labels in two rows, with this entry of the header replaced.
    fn array(from: &str, to: &str) -> Vec<u8> {
        let header = "{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3), }\n".replace(from, to);
        let mut b = b"\x93NUMPY\x01\x00".to_vec();
        b.extend((header.len() as u16).to_le_bytes());
        b.extend(header.bytes());
        b.extend([1i32, -2, 3, 4, 5, 600_000].iter().flat_map(|v| v.to_le_bytes()));
        b
    }

    #[test]
    fn rows_come_top_first_whichever_way_they_are_stored() {
        assert_eq!(elevation(&image(), 2, 3).unwrap(), [1, 2, 3, 4, 5, 6]);
        let mut down = image();
        down[22..26].copy_from_slice(&(-2i32).to_le_bytes());
        assert_eq!(elevation(&down, 2, 3).unwrap(), [4, 5, 6, 1, 2, 3]);
    }

    #[test]
    fn pictures_that_are_not_as_the_originals_are_refused_by_field_and_value() {
        type Change = fn(&mut Vec<u8>);
        let cases: [(Change, &str, &str); 9] = [
            (|b| b[0] = b'P', "file", "is not a Windows bitmap"),
            (|b| b.truncate(20), "file", "is truncated (20 bytes, but its header needs 54)"),
            (|b| b.truncate(1080), "file", "is truncated (1080 bytes, but the image needs 1086)"),
            (|b| b[28] = 24, "format", "24 bits a pixel, compression 0"),
            (|b| b[30] = 1, "format", "8 bits a pixel, compression 1"),
            (|b| b[18] = 4, "size", "4 x 2 pixels: must be 3 x 2"),
            (|b| b[54 + 4 * 7] = 9, "palette", "entry 7 is [7, 7, 9]"),
            // Two colours: all further ones are none, and so no greys.
            (|b| b[46] = 2, "palette", "entry 2 is [0, 0, 0]"),
            (|b| b[10] = 0, "file", "pixels begin at byte 1024, inside the palette"),
        ];
        for (change, field, text) in cases {
            let mut bytes = image();
            change(&mut bytes);
            let (found, problem) = elevation(&bytes, 2, 3).unwrap_err();
            assert!(found == field && problem.contains(text), "{found}: {problem}\nnot {field}: {text}");
        }
    }

    #[test]
    fn arrays_that_are_not_as_the_originals_are_refused_by_field_and_value() {
        assert_eq!(labels(&array("", ""), 2, 3).unwrap(), [1, -2, 3, 4, 5, 600_000]);
        let cases = [
            ("<i4", "<u4", "descr", "'<u4': must be '<i4'"),
            ("<i4", ">i4", "descr", "'>i4': must be '<i4'"),
            ("False", "True", "fortran_order", "True: must be False"),
            ("(2, 3)", "(3, 2)", "shape", "(3, 2): must be (2, 3)"),
            ("(2, 3)", "(6,)", "file", "an array of 1 dimensions"),
            ("'shape': (2, 3), ", "", "file", "missing key 'shape'"),
        ];
        for (from, to, field, text) in cases {
            let (found, problem) = labels(&array(from, to), 2, 3).unwrap_err();
            assert!(found == field && problem.contains(text), "{found}: {problem}\nnot {field}: {text}");
        }
        for (change, text) in [(-4, "5 values"), (4, "7 values")] {
            let mut bytes = array("", "");
            bytes.resize(bytes.len().checked_add_signed(change).unwrap(), 0);
            let (found, problem) = labels(&bytes, 2, 3).unwrap_err();
            assert!(found == "data" && problem.contains(text), "{found}: {problem}");
        }
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let mut rng = vb_math::rng::Stream::new(1, &["bmp"]);
        for _ in 0..50_000 {
            let mut b = image();
            for _ in 0..1 + rng.below(3) {
                let at = rng.below(80) as usize;
                b[at] = [0, 1, 127, 128, 255, rng.next_u64() as u8][rng.below(6) as usize];
            }
            b.truncate(rng.below(2 * b.len() as u64) as usize);
            let _ = elevation(&b, 2, 3);
        }
    }
}
