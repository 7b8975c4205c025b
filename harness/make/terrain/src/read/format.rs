//! The format of an elevation file, by its content.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::Flaw;

/// The south-western corner of a tile of SRTM and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    /// Degrees, negative in the west; `None` if the file's name doesn't say.
    pub(super) corner: Option<[i32; 2]>,
    pub(super) rows: usize,
    pub(super) cols: usize,
}

/// A format that there is a reader for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Picture,
    Array,
    Archive,
    Tiff,
    AsciiGrid,
    /// Samples beside a header of this name.
    BinaryGrid(PathBuf),
    Srtm(Tile),
    /// A course of OpenCRG.
    Course,
}

/// Bytes that are looked at.
const START: u64 = 4096;
const CONVERT: &str = "convert it with gdal_translate -of GTiff -co COMPRESS=DEFLATE";

impl Format {
    /// The format of a file of this many bytes.
    pub(super) fn of(path: &Path, size: u64) -> Result<Self, Flaw> {
        let mut start = Vec::new();
        let file: File = vb_files::open(path)?;
        file.take(START).read_to_end(&mut start)?;
        Ok(match start.as_slice() {
            [] => return Err(Flaw::Truncated("0 bytes".into())),
            [0x89, b'P', b'N', b'G', ..] | [b'B', b'M', ..] => Self::Picture,
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::Array,
            [b'P', b'K', 3 | 5, 4 | 6, ..] => Self::Archive,
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Self::Tiff,
            _ if is_ascii_grid(&start) => Self::AsciiGrid,
            _ if is_course(&start) => Self::Course,
            _ => {
                if let Some(name) = known(&start) {
                    return Err(Flaw::Format(name));
                }
                if let Some(header) = header(path) {
                    return Ok(Self::BinaryGrid(header));
                }
                let tile = srtm(path, size).ok_or_else(|| unknown(path))?;
                Self::Srtm(tile)
            }
        })
    }
}

/// Whether a file begins with a line of an ESRI grid's header, in any case.
fn is_ascii_grid(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let text = String::from_utf8_lossy(start);
    let first = text.split_whitespace().next().unwrap_or_default().to_ascii_lowercase();
    super::ascii_grid::KEYS.contains(&first.as_str()) && text.split_whitespace().nth(1).is_some()
}

/// Whether a file has a line that begins one of OpenCRG's sections, behind comments at most.
fn is_course(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start).to_ascii_uppercase();
    let mut lines =
        text.trim_start_matches('\u{feff}').lines().filter(|l| !l.is_empty() && !l.starts_with('*'));
    let first = lines.next().unwrap_or_default();
    ["$CT", "$ROAD_CRG"].iter().any(|name| first.starts_with(name))
}

/// What a file is that is no elevation file of those that are read, with the way to make one of it.
fn known(start: &[u8]) -> Option<String> {
    let has = |at: usize, bytes: &[u8]| start.get(at..at + bytes.len()) == Some(bytes);
    let translate = |name: &str| Some(format!("is {name}, which is not supported: {CONVERT} IN OUT.tif"));
    if has(0, b"\xff\xd8\xff") {
        return Some(format!(
            "is a JPEG picture, whose samples are lossy: use the original, or {CONVERT} IN OUT.tif"
        ));
    }
    if has(0, b"RIFF") && has(8, b"WEBP") {
        return translate("a WebP picture");
    }
    if has(0, b"\x1f\x8b") {
        return Some("is compressed with gzip: unpack it with gunzip".into());
    }
    if has(0, b"\xfd7zXZ") || has(0, b"\x28\xb5\x2f\xfd") || has(0, b"BZh") || has(0, b"7z\xbc\xaf") {
        return Some("is a compressed file: unpack it".into());
    }
    if has(0, b"GIF8") {
        return translate("a GIF picture");
    }
    if has(0, b"\x89HDF") || has(0, b"CDF\x01") || has(0, b"CDF\x02") || has(0, b"CDF\x05") {
        return translate("a NetCDF or HDF5 file");
    }
    if has(0, b"EHFA_HEADER_TAG") {
        return translate("an Erdas Imagine file");
    }
    if has(4, b"jP  \r\n\x87\n") || has(0, b"\xff\x4f\xff\x51") {
        return translate("a JPEG 2000 file");
    }
    if has(0, b"DSAA") || has(0, b"DSBB") || has(0, b"DSRB") {
        return translate("a grid of Surfer");
    }
    if has(0, b"LASF") {
        return Some(
            "is a cloud of points (LAS): rasterise it first, e.g. with pdal and writers.gdal".into(),
        );
    }
    if has(0, b"\xd0\xcf\x11\xe0") {
        return Some("is an Office document, not an elevation file".into());
    }
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let lower = text.to_ascii_lowercase();
    if lower.starts_with("<vrtdataset") {
        return translate("a virtual raster of GDAL");
    }
    if lower.starts_with("north:") {
        return translate("an ASCII grid of GRASS");
    }
    if lower.starts_with("solid ")
        || lower.starts_with("ply")
        || lower.starts_with("# blender")
        || lower.starts_with("v ")
        || lower.starts_with("mtllib")
    {
        return Some("is a mesh: rasterise its heights first".into());
    }
    if lower.starts_with('{') || lower.starts_with('[') {
        return Some("is JSON, not an elevation file: give the height file that it may refer to".into());
    }
    if lower.starts_with("nrows") && lower.contains("layout") || lower.starts_with("byteorder") {
        return Some("is the header of a binary grid: give the file of samples next to it".into());
    }
    if lower.starts_with('<') {
        return Some("is XML or HTML, not an elevation file".into());
    }
    None
}

/// The header next to a file of bare samples.
fn header(path: &Path) -> Option<PathBuf> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ending == "hdr" {
        return None;
    }
    let names = [
        path.with_extension("hdr"),
        path.with_extension("HDR"),
        PathBuf::from(format!("{}.hdr", path.display())),
    ];
    names.into_iter().find(|p| p.is_file())
}

/// The tile of SRTM that a file without a header is: by its size, and its place by its name, such as N44W072.hgt.
fn srtm(path: &Path, size: u64) -> Option<Tile> {
    let (rows, cols) = match size {
        25_934_402 => (3601, 3601),
        12_967_202 => (3601, 1801),
        2_884_802 => (1201, 1201),
        _ => return None,
    };
    let name = path.file_name()?.to_string_lossy().to_ascii_uppercase();
    let bytes = name.as_bytes();
    let digits =
        |range: std::ops::Range<usize>| std::str::from_utf8(bytes.get(range)?).ok()?.parse::<i32>().ok();
    let sign = |at: usize, minus: u8, plus: u8| match bytes.get(at) {
        Some(b) if *b == minus => Some(-1),
        Some(b) if *b == plus => Some(1),
        _ => None,
    };
    let corner = || {
        let (south, west) = (sign(0, b'S', b'N')?, sign(3, b'W', b'E')?);
        let (lat, lon) = (digits(1..3)?, digits(4..7)?);
        ((0..=90).contains(&lat) && (0..=180).contains(&lon)).then_some([west * lon, south * lat])
    };
    let corner = corner();
    (corner.is_some() || name.ends_with(".HGT")).then_some(Tile { corner, rows, cols })
}

fn unknown(path: &Path) -> Flaw {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let binary = match ending.as_str() {
        "bil" | "bip" | "bsq" | "flt" | "dem" => {
            "; a file of bare samples needs its header (.hdr) next to it"
        }
        "hgt" => "; a tile of SRTM has 1201 x 1201 or 3601 x 3601 samples of 2 bytes",
        _ => "",
    };
    Flaw::Format(format!(
        "its content is not a supported elevation file (GeoTIFF, ESRI grid .asc or .bil, SRTM .hgt, NumPy .npy or .npz, PNG, BMP, OpenCRG .crg){binary}: {CONVERT} IN OUT.tif, \
         if GDAL reads it"
    ))
}
