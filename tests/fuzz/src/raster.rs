//! Elevation files of users.

use std::io::Write as _;
use std::path::Path;

use vb_terrain::read::{Holes, Options, read, survey};

use crate::site::{Site, select};

/// Names of the files; the first byte of a case chooses. The content decides on the format, but for the last two: bare samples have
/// their header beside them, and tiles of SRTM their place in their name.
const NAMES: [&str; 8] = [
    "raster.bmp",
    "raster.png",
    "raster.npy",
    "raster.tif",
    "raster.asc",
    "raster.npz",
    "raster.bil",
    "N44W072.hgt",
];
const BINARY: usize = 6;
const HEADER: &str = "raster.hdr";
/// Parts a header from samples.
const END: &[u8] = b"\n\n";

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = Site::new());
    let Some((&kind, content)) = data.split_first() else { return };
    SITE.with(|site| {
        let path = write(site, kind, content);
        if let Ok(raster) = read(&path, Holes::Keep) {
            assert_eq!(raster.values().len(), raster.rows() * raster.cols());
        }
        let labels = Options { holes: Holes::Keep, labels: true, ..Options::default() };
        if let Ok(found) = survey(&path, &labels) {
            assert!(!found.summary().contains('\n'));
        }
    });
}

/// Writes the files of a case, and returns the one of heights.
fn write(site: &Site, kind: u8, content: &[u8]) -> std::path::PathBuf {
    let kind = usize::from(kind) % NAMES.len();
    let mut samples = content;
    let _ = std::fs::remove_file(site.path().join(HEADER));
    if kind == BINARY {
        let end = content.windows(END.len()).position(|w| w == END).unwrap_or(content.len());
        site.write(Path::new(HEADER), &content[..end]);
        samples = content.get(end + END.len()..).unwrap_or_default();
    }
    site.write(Path::new(NAMES[kind]), samples);
    site.path().join(NAMES[kind])
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let png = include_bytes!("../../../examples/site/labels.png");
    let tif = include_bytes!("../../../examples/site/heights.tif");
    let asc =
        b"ncols 3\nnrows 2\nxllcorner 10,5\nyllcenter 20\ncellsize 1\nNODATA_value -9999\n1 2 3\n4 -9999 6\n";
    let mut binary =
        b"NROWS 2\nNCOLS 2\nNBITS 16\nBYTEORDER M\nULXMAP 500000.5\nULYMAP 5260000.5\nXDIM 1\nYDIM 1\n\n"
            .to_vec();
    binary.extend([0, 1, 0, 2, 0, 3, 0, 4]);
    vec![
        select(0, &bmp()),
        select(1, png),
        select(2, &npy()),
        select(3, tif),
        select(4, asc),
        select(5, &npz()),
        select(6, &binary),
        select(3, &degrees()),
    ]
}

/// The array in an archive (ZIP, stored).
fn npz() -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    archive.start_file("dem.npy", stored).expect("the archive is in memory");
    archive.write_all(&npy()).expect("the archive is in memory");
    archive.finish().expect("the archive is in memory").into_inner()
}

/// A TIFF of 4 × 4 samples of 16 bits in degrees, with differences and GDAL's metadata.
fn degrees() -> Vec<u8> {
    let metadata = b"<GDALMetadata><Item name=\"S\" sample=\"0\" role=\"scale\">0.01</Item></GDALMetadata>\0";
    // Size of a pixel, and the tie point of the first.
    let data = [0.001f64, 0.001, 0.0, 0.0, 0.0, 0.0, 9.0, 47.0, 0.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect::<Vec<u8>>();
    let keys: Vec<u8> =
        [1u16, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326].iter().flat_map(|v| v.to_le_bytes()).collect();
    let at = |start: usize| 8 + start as u32;
    let (scale, tie, geo) = (at(0), at(24), at(data.len()));
    let text = geo + keys.len() as u32;
    let strip = text + metadata.len() as u32;
    let samples = [100, 0, 1, 0, 2, 0, 255, 255].repeat(4);
    let first = strip + samples.len() as u32;
    let entries: [(u16, u16, u32, u32); 15] = [
        (256, 3, 1, 4),
        (257, 3, 1, 4),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, strip),
        (277, 3, 1, 1),
        (278, 3, 1, 4),
        (279, 4, 1, samples.len() as u32),
        (317, 3, 1, 2),
        (339, 3, 1, 2),
        (33550, 12, 3, scale),
        (33922, 12, 6, tie),
        (34735, 3, keys.len() as u32 / 2, geo),
        (42112, 2, metadata.len() as u32, text),
    ];
    let mut bytes = [b"II\x2a\0", &first.to_le_bytes()[..], &data, &keys, metadata, &samples].concat();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        bytes.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes
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
            let path = write(&site, seed[0], &seed[1..]);
            read(&path, Holes::Keep).unwrap_or_else(|e| panic!("{e}"));
        }
    }
}
