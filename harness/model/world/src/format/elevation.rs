//! Heights as a 16-bit grey PNG, row 0 in the north.

use crate::check::{MAX_SIDE, Part};
use crate::{Flaw, Heightfield};

/// The PNG of a surface, compressed. The content hash covers the levels and not these bytes, which depend on the version of the
/// compressor.
pub(crate) fn encode(rows: usize, cols: usize, levels: &[u16]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, cols as u32, rows as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::High);
    // Of a rough surface the difference to the gradient's prediction is smallest.
    encoder.set_filter(png::Filter::Paeth);
    let data: Vec<u8> = levels.chunks(cols).rev().flatten().flat_map(|v| v.to_be_bytes()).collect();
    let written = encoder.write_header().and_then(|mut w| {
        w.write_image_data(&data)?;
        w.finish()
    });
    written.expect("writing a checked image into memory does not fail");
    out
}

/// The part of a PNG that a content hash covers, whatever compressed it: rows and columns (32 bits each) and the levels row by row from
/// the north (16 bits each), all big-endian. `None` if it is no whole 16-bit grey image of a size that a world may have.
pub(crate) fn content(bytes: &[u8]) -> Option<Vec<u8>> {
    let limits = png::Limits { bytes: 4 * MAX_SIDE * MAX_SIDE };
    let mut reader = png::Decoder::new_with_limits(std::io::Cursor::new(bytes), limits).read_info().ok()?;
    let info = reader.info();
    let (rows, cols) = (info.height, info.width);
    let grey = (info.color_type, info.bit_depth) == (png::ColorType::Grayscale, png::BitDepth::Sixteen);
    if !grey || rows as usize > MAX_SIDE || cols as usize > MAX_SIDE {
        return None;
    }
    let mut out = [rows.to_be_bytes(), cols.to_be_bytes()].concat();
    out.resize(8 + 2 * rows as usize * cols as usize, 0);
    reader.next_frame(&mut out[8..]).ok()?;
    reader.finish().ok()?;
    Some(out)
}

/// Reads a PNG that must have the given size.
pub(crate) fn decode(
    bytes: &[u8],
    rows: usize,
    cols: usize,
    resolution: f64,
    range: [f64; 2],
) -> Result<Heightfield, Flaw> {
    let flaw = |field: &str, problem: String| Flaw::new(Part::Elevation, field, problem);
    let unreadable = |e: png::DecodingError| {
        flaw(
            "image",
            format!("not a whole PNG image ({e}); it was cut short or is another format: restore it"),
        )
    };
    let limits = png::Limits { bytes: 4 * rows * cols + (1 << 20) };
    let mut reader =
        png::Decoder::new_with_limits(std::io::Cursor::new(bytes), limits).read_info().map_err(unreadable)?;
    let info = reader.info();
    if (info.height as usize, info.width as usize) != (rows, cols) {
        return Err(flaw(
            "size",
            format!(
                "{} x {} pixels (rows x columns), but world.yaml states grid.rows {rows} and grid.cols {cols}: they must agree",
                info.height, info.width
            ),
        ));
    }
    if (info.color_type, info.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(flaw(
            "format",
            format!("{:?}, {:?} bits a channel: must be 16-bit greyscale", info.color_type, info.bit_depth),
        ));
    }
    let mut data = vec![0; 2 * rows * cols];
    reader.next_frame(&mut data).map_err(unreadable)?;
    reader.finish().map_err(unreadable)?;
    let levels: Vec<u16> = data
        .chunks_exact(2 * cols)
        .rev()
        .flat_map(|row| row.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])))
        .collect();
    Ok(Heightfield::from_levels(rows, cols, resolution, range, &levels))
}
