//! Elevation files of users.

use std::path::Path;

use vb_terrain::read::{Holes, read};

use crate::site::{Site, select};

/// Endings of the formats that are read; the first byte chooses.
const ENDINGS: [&str; 4] = ["bmp", "png", "npy", "tif"];

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = Site::new());
    let Some((&kind, content)) = data.split_first() else { return };
    let name = format!("raster.{}", ENDINGS[usize::from(kind) % ENDINGS.len()]);
    SITE.with(|site| {
        site.write(Path::new(&name), content);
        if let Ok(raster) = read(&site.path().join(name), Holes::Keep) {
            assert_eq!(raster.values().len(), raster.rows() * raster.cols());
        }
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let png = include_bytes!("../../../examples/site/labels.png");
    let tif = include_bytes!("../../../examples/site/heights.tif");
    vec![select(0, &bmp()), select(1, png), select(2, &npy()), select(3, tif)]
}

/// 2 × 2 grey pixels (BITMAPINFOHEADER, 8 bits a pixel, palette of 256 greys).
fn bmp() -> Vec<u8> {
    let mut bytes = b"BM".to_vec();
    let number = |bytes: &mut Vec<u8>, n: u32| bytes.extend(n.to_le_bytes());
    for n in [1086, 0, 1078, 40, 2, 2, 1 | (8 << 16), 0, 8, 3780, 3780, 256, 0] {
        number(&mut bytes, n);
    }
    for grey in 0..=255u8 {
        bytes.extend([grey, grey, grey, 0]);
    }
    // Rows are padded to four bytes.
    bytes.extend([10, 20, 0, 0, 30, 40, 0, 0]);
    bytes
}

/// A 2 × 3 array of 32-bit floats (NumPy's format, version 1.0).
fn npy() -> Vec<u8> {
    let mut header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }".to_owned();
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend([0.0_f32, 0.5, 1.0, 1.5, 2.0, 2.5].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed that is refused at the door tests nothing behind it.
    #[test]
    fn the_seeds_are_rasters() {
        for seed in seeds() {
            let site = Site::new();
            let name = format!("raster.{}", ENDINGS[usize::from(seed[0])]);
            site.write(Path::new(&name), &seed[1..]);
            read(&site.path().join(&name), Holes::Refuse).expect(&name);
        }
    }
}
