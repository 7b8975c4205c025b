//! 8-bit grey Windows bitmaps, as the original stores elevation: BITMAPINFOHEADER, uncompressed, as its released worlds
//! are, with a linear grey palette. Anything else is refused.

/// A grey image, row 0 on top.
pub(crate) struct Grey {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    pub(crate) pixels: Vec<u8>,
}

/// Reads an image that must have the given size. An error is (field, problem).
pub(crate) fn read(bytes: &[u8], rows: usize, cols: usize) -> Result<Grey, (&'static str, String)> {
    let short = |needed: usize| {
        let found = bytes.len();
        ("file", format!("{found} bytes, but the image needs {needed}: it was cut short, restore it"))
    };
    let u16_at = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
    let u32_at = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
    if !bytes.starts_with(b"BM") {
        return Err(("file", "is not a Windows bitmap (it does not begin with BM)".into()));
    }
    if bytes.len() < 54 {
        return Err(short(54));
    }
    let (offset, header) = (u32_at(10) as usize, u32_at(14) as usize);
    let (width, height) = (i64::from(u32_at(18) as i32), i64::from(u32_at(22) as i32));
    let (bits, compression) = (u16_at(28), u32_at(30));
    if header < 40 {
        return Err(("header", format!("{header} bytes long: must be a BITMAPINFOHEADER of 40 bytes")));
    }
    if bits != 8 || compression != 0 {
        return Err((
            "format",
            format!("{bits} bits a pixel, compression {compression}: must be 8 bits, uncompressed"),
        ));
    }
    if (height.unsigned_abs() as usize, width.unsigned_abs() as usize) != (rows, cols) || width < 0 {
        return Err((
            "size",
            format!("{width} x {height} pixels: must be {cols} x {rows}, as the config states"),
        ));
    }
    let stride = cols.div_ceil(4) * 4;
    let needed = offset + stride * rows;
    if bytes.len() < needed {
        return Err(short(needed));
    }
    let colours = match u32_at(46) {
        0 => 256,
        n => (n as usize).min(256),
    };
    let palette = 14 + header;
    if offset < palette + 4 * colours {
        return Err((
            "palette",
            format!("pixels begin at byte {offset}, inside the palette of {colours} colours"),
        ));
    }
    for k in 0..colours {
        let entry = &bytes[palette + 4 * k..palette + 4 * k + 3];
        if entry.iter().any(|&v| usize::from(v) != k) {
            return Err(("palette", format!("entry {k} is {entry:?}: must be the grey of the same value")));
        }
    }
    // Positive height: the bottom row comes first.
    let row_at = |r: usize| offset + stride * if height > 0 { rows - 1 - r } else { r };
    let pixels: Vec<u8> =
        (0..rows).flat_map(|r| bytes[row_at(r)..row_at(r) + cols].iter().copied()).collect();
    if let Some(i) = pixels.iter().position(|&v| usize::from(v) >= colours) {
        return Err((
            "pixels",
            format!("value {} at row {}, column {} has no colour", pixels[i], i / cols, i % cols),
        ));
    }
    Ok(Grey { rows, cols, pixels })
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

    #[test]
    fn rows_come_top_first_whichever_way_they_are_stored() {
        assert_eq!(read(&image(), 2, 3).unwrap().pixels, [1, 2, 3, 4, 5, 6]);
        let mut down = image();
        down[22..26].copy_from_slice(&(-2i32).to_le_bytes());
        assert_eq!(read(&down, 2, 3).unwrap().pixels, [4, 5, 6, 1, 2, 3]);
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
            let _ = read(&b, 2, 3);
        }
    }
}
