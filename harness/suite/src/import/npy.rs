//! NumPy arrays of 32-bit integers in C order, as the original stores its labels (format versions 1 and 2 of the
//! NEP 1 description). Anything else is refused.

/// Reads an array that must have the given shape. An error is (field, problem).
pub(crate) fn read_i32(bytes: &[u8], rows: usize, cols: usize) -> Result<Vec<i32>, (&'static str, String)> {
    let cut = || ("file", format!("{} bytes: it was cut short in its header, restore it", bytes.len()));
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(("file", "is not a NumPy array (it does not begin with \\x93NUMPY)".into()));
    }
    let (length, start) = match bytes.get(6..12) {
        Some([1, _, a, b, ..]) => (usize::from(u16::from_le_bytes([*a, *b])), 10),
        Some([2, _, a, b, c, d]) => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 12),
        Some([version, ..]) => {
            return Err(("version", format!("{version} is not supported: must be 1 or 2")));
        }
        _ => return Err(cut()),
    };
    let end = start + length;
    let header = std::str::from_utf8(bytes.get(start..end).ok_or_else(cut)?)
        .map_err(|_| ("header", "is not text: restore the file".to_owned()))?;
    let wanted = [
        ("descr", "'<i4'".to_owned()),
        ("fortran_order", "False".into()),
        ("shape", format!("({rows}, {cols})")),
    ];
    for (key, value) in wanted {
        let found = entry(header, key).ok_or_else(|| (key, "is missing from the header".to_owned()))?;
        if found != value {
            return Err((key, format!("{found}: must be {value}")));
        }
    }
    let (data, needed) = (&bytes[end..], 4 * rows * cols);
    if data.len() != needed {
        let (found, wanted) = (data.len() / 4, rows * cols);
        return Err((
            "data",
            format!("{found} values, but the shape ({rows}, {cols}) needs {wanted}: restore the file"),
        ));
    }
    Ok(data.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// The value of a key in the header, a Python dictionary such as `{'descr': '<i4', 'shape': (129, 129), }`.
fn entry<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let at = header.find(&format!("'{key}'"))? + key.len() + 2;
    let rest = header[at..].trim_start().strip_prefix(':')?.trim_start();
    let end = if rest.starts_with('(') { rest.find(')')? + 1 } else { rest.find([',', '}'])? };
    Some(rest[..end].trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(version: u8) -> Vec<u8> {
        let header = "{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3), }\n";
        let mut b = b"\x93NUMPY".to_vec();
        b.extend([version, 0]);
        let length = header.len() as u32;
        b.extend(&length.to_le_bytes()[..if version == 1 { 2 } else { 4 }]);
        b.extend(header.bytes());
        b.extend([1i32, -2, 3, 4, 5, 600_000].iter().flat_map(|v| v.to_le_bytes()));
        b
    }

    #[test]
    fn both_header_versions_are_read() {
        for version in [1, 2] {
            assert_eq!(read_i32(&array(version), 2, 3).unwrap(), [1, -2, 3, 4, 5, 600_000]);
        }
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let mut rng = vb_math::rng::Stream::new(1, &["npy"]);
        for round in 0..50_000u32 {
            let mut b = array(1 + (round % 2) as u8);
            for _ in 0..1 + rng.below(4) {
                let at = rng.below(b.len() as u64) as usize;
                b[at] = b"'():,{} \xff\x00"[rng.below(10) as usize];
            }
            b.truncate(rng.below(2 * b.len() as u64) as usize);
            let _ = read_i32(&b, 2, 3);
        }
    }
}
