//! Surfaces as files: NumPy arrays, 16-bit PNG, and hill-shaded pictures. First row in the north, as in all files.

use std::path::Path;

use npyz::WriterBuilder as _;
use vb_world::Heightfield;

/// A surface as a NumPy array of f64 metres, shape (rows, columns).
///
/// # Errors
/// A fault of the library that encodes it.
pub fn npy(surface: &Heightfield) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    let shape = [surface.rows() as u64, surface.cols() as u64];
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut out).begin_nd()?;
    writer.extend(north_first(surface.heights(), surface.cols()))?;
    writer.finish()?;
    Ok(out)
}

/// A surface as a 16-bit grey PNG over its own relief; the heights in metres that levels 0 and 65535 stand for, and the resolution,
/// are in it as the texts `low_m`, `high_m` and `resolution_m`.
///
/// # Errors
/// A fault of the library that encodes it.
pub fn png(surface: &Heightfield) -> std::io::Result<Vec<u8>> {
    let ([low, high], levels) = surface.to_levels();
    let data: Vec<u8> = north_first(&levels, surface.cols()).flat_map(u16::to_be_bytes).collect();
    let texts = [("low_m", low), ("high_m", high), ("resolution_m", surface.resolution())];
    encode(surface, png::BitDepth::Sixteen, &data, &texts)
}

/// A surface as it looks in the light of a sun in the north-west, 45° high: an 8-bit grey PNG, of a pixel a node.
///
/// # Errors
/// A fault of the library that encodes it.
pub fn shaded(surface: &Heightfield) -> std::io::Result<Vec<u8>> {
    let grey = shades(surface);
    let data: Vec<u8> = north_first(&grey, surface.cols()).collect();
    encode(surface, png::BitDepth::Eight, &data, &[])
}

/// The light on each node, row-major, row 0 in the south.
fn shades(surface: &Heightfield) -> Vec<u8> {
    let (rows, cols) = (surface.rows(), surface.cols());
    // Towards the sun: west, north, up.
    let s = 0.5f64.sqrt();
    let sun = [-0.5, 0.5, s];
    (0..rows * cols)
        .map(|i| {
            let (r, c) = (i / cols, i % cols);
            let (south, north) = (r.saturating_sub(1), (r + 1).min(rows - 1));
            let (west, east) = (c.saturating_sub(1), (c + 1).min(cols - 1));
            let dx = (surface.node(r, east) - surface.node(r, west))
                / ((east - west) as f64 * surface.resolution());
            let dy = (surface.node(north, c) - surface.node(south, c))
                / ((north - south) as f64 * surface.resolution());
            let length = (dx * dx + dy * dy + 1.0).sqrt();
            let light = (-dx * sun[0] - dy * sun[1] + sun[2]) / length;
            (255.0 * light.max(0.0)).round() as u8
        })
        .collect()
}

/// Row-major values that begin in the south, from the north.
fn north_first<T: Copy>(values: &[T], cols: usize) -> impl Iterator<Item = T> {
    values.chunks_exact(cols).rev().flatten().copied()
}

/// Stored without compression: the bytes depend on no compressor's version.
fn encode(
    surface: &Heightfield,
    depth: png::BitDepth,
    data: &[u8],
    texts: &[(&str, f64)],
) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, surface.cols() as u32, surface.rows() as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::NoCompression);
    encoder.set_filter(png::Filter::NoFilter);
    for (key, value) in texts {
        encoder.add_text_chunk((*key).to_owned(), value.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    writer.finish()?;
    Ok(out)
}

/// What a file for a surface is, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As [`npy()`] writes it.
    Npy,
    /// As [`png()`] writes it.
    Png,
}

impl Kind {
    /// By the ending, `.npy` or `.png`.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_ascii_lowercase().as_str() {
            "npy" => Some(Self::Npy),
            "png" => Some(Self::Png),
            _ => None,
        }
    }

    /// The surface as a file's bytes.
    pub fn encode(self, surface: &Heightfield) -> std::io::Result<Vec<u8>> {
        match self {
            Self::Npy => npy(surface),
            Self::Png => png(surface),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::{Holes, read};

    /// Rises by 1 m to the east and 10 m to the north.
    fn slope() -> Heightfield {
        Heightfield::new(2, 3, 0.5, vec![0.0, 1.0, 2.0, 10.0, 11.0, 12.0])
    }

    #[test]
    fn what_is_written_reads_back_with_the_north_on_top() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.npy", "a.png"] {
            let path = dir.path().join(name);
            std::fs::write(&path, Kind::of(&path).unwrap().encode(&slope()).unwrap()).unwrap();
            let raster = read(&path, Holes::Refuse).unwrap();
            assert_eq!((raster.rows(), raster.cols()), (2, 3));
            let metres = |v: &f64| if name == "a.png" { v / 65535.0 * 12.0 } else { *v };
            let got: Vec<f64> = raster.values().iter().map(metres).collect();
            for (got, want) in got.iter().zip([10.0, 11.0, 12.0, 0.0, 1.0, 2.0]) {
                assert!((got - want).abs() < 12.0 / 65535.0, "{name}: {got} {want}");
            }
        }
        assert_eq!(Kind::of(Path::new("a.txt")), None);
    }

    #[test]
    fn light_comes_from_the_north_west() {
        let plane = |dx: f64, dy: f64| {
            let z = (0..9).map(|i| dx * f64::from(i % 3) + dy * f64::from(i / 3)).collect();
            shades(&Heightfield::new(3, 3, 1.0, z))[4]
        };
        // Level ground lies at 45° to the sun: 255 / √2.
        assert_eq!(plane(0.0, 0.0), 180);
        // A slope of 45° that falls to the north-west faces it.
        let s = 0.5f64.sqrt();
        assert_eq!(plane(s, -s), 255);
        assert_eq!(plane(-s, s), 0);
    }
}
