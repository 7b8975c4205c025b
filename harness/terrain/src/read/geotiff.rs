//! GeoTIFF: one band of heights with the size of its pixels (OGC 19-008r4) and GDAL's mark for no data.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::{Flaw, Found, MAX_SAMPLES, check_size, line, open};
use crate::ElevationImage;

const PIXEL_SCALE: Tag = Tag::Unknown(33550);
const TRANSFORMATION: Tag = Tag::Unknown(34264);
const KEY_DIRECTORY: Tag = Tag::Unknown(34735);
const DOUBLE_PARAMS: Tag = Tag::Unknown(34736);
const GDAL_NO_DATA: Tag = Tag::Unknown(42113);

const MODEL_TYPE: u16 = 1024;
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_UNITS: u16 = 4099;

type Source = Decoder<BufReader<File>>;

/// Reads the first image of a file.
pub(super) fn read(path: &Path) -> Result<Found, Flaw> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 8 * MAX_SAMPLES as usize;
    let mut tiff = Decoder::new(open(path)?).map_err(flaw)?.with_limits(limits);
    let (cols, rows) = tiff.dimensions().map_err(flaw)?;
    check_size(rows.into(), cols.into())?;
    let bands: Option<u16> = tiff.find_tag_unsigned(Tag::SamplesPerPixel).map_err(flaw)?;
    if let Some(n) = bands.filter(|n| *n != 1) {
        return Err(Flaw::Rank(format!("{n} bands")));
    }
    let places = Places::read(&mut tiff)?;
    let mark =
        match tiff.find_tag(GDAL_NO_DATA).map_err(flaw)? {
            Some(value) => {
                let text = value.into_string().map_err(flaw)?;
                let text = text.trim().trim_end_matches('\0').trim();
                Some(text.parse::<f64>().map_err(|_| {
                    Flaw::Damaged(format!("the mark of no data is {text:?}, which is no number"))
                })?)
            }
            None => None,
        };
    let samples = tiff.read_image().map_err(flaw)?;
    // GDAL writes the mark in full precision whatever the samples are.
    let single = matches!(samples, DecodingResult::F32(_));
    let values: Vec<f64> = match samples {
        DecodingResult::U8(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::U16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::I16(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F32(v) => v.into_iter().map(f64::from).collect(),
        DecodingResult::F64(v) => v,
        other => {
            let found = match other {
                DecodingResult::U32(_) | DecodingResult::U64(_) => "unsigned integers of 32 bits or more",
                DecodingResult::I8(_) => "signed bytes",
                DecodingResult::I32(_) | DecodingResult::I64(_) => "integers of 32 bits or more",
                _ => "half-precision floats",
            };
            return Err(Flaw::Type { found: found.into(), wanted: "u8, u16, i16, f32 or f64" });
        }
    };
    if values.len() != rows as usize * cols as usize {
        return Err(Flaw::Truncated(format!("{} samples, but {rows} x {cols} are announced", values.len())));
    }
    let is_mark = |v: f64| {
        mark.is_some_and(|m| v == m || (single && v == f64::from(m as f32)) || (v.is_nan() && m.is_nan()))
    };
    let no_data: Vec<bool> = values.iter().map(|v| is_mark(*v)).collect();
    let values = values.into_iter().map(|v| v * places.vertical_unit).collect();
    let raster = ElevationImage::new(rows as usize, cols as usize, values).with_resolution(places.resolution);
    Ok(Found { raster, no_data })
}

/// What the file says of places.
struct Places {
    /// Side of a pixel, m.
    resolution: Option<f64>,
    /// Metres in a unit of height.
    vertical_unit: f64,
}

impl Places {
    fn read(tiff: &mut Source) -> Result<Self, Flaw> {
        let keys = Keys::read(tiff)?;
        match keys.short(MODEL_TYPE) {
            Some(2) => return Err(Flaw::Degrees),
            Some(3) => {
                return Err(Flaw::Coordinates(
                    "coordinates are geocentric: reproject it to a system in metres, such as its UTM zone"
                        .into(),
                ));
            }
            _ => {}
        }
        let unit = match keys.short(LINEAR_UNITS) {
            Some(32767) => keys.double(LINEAR_UNIT_SIZE).filter(|m| m.is_finite() && *m > 0.0),
            Some(code) => metres(code),
            None => Some(1.0),
        };
        let unit = unit.ok_or_else(|| {
            Flaw::Coordinates(
                "the unit of its coordinates is unknown: reproject it to a system in metres".into(),
            )
        })?;
        let vertical_unit = match keys.short(VERTICAL_UNITS) {
            Some(code) => metres(code).ok_or_else(|| {
                Flaw::Coordinates(format!(
                    "the unit of its heights (EPSG {code}) is unknown: convert them to metres"
                ))
            })?,
            None => 1.0,
        };
        let scale = doubles(tiff, PIXEL_SCALE)?;
        let matrix = doubles(tiff, TRANSFORMATION)?;
        let sides = match (scale.as_deref(), matrix.as_deref()) {
            (Some([x, y, ..]), _) => Some([*x, *y]),
            (None, Some([a, b, _, _, d, e, ..])) => Some([vb_math::hypot(*a, *d), vb_math::hypot(*b, *e)]),
            _ => None,
        };
        let resolution = match sides {
            None => None,
            Some([x, y]) => {
                if !(x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0) {
                    return Err(Flaw::Coordinates(format!(
                        "pixels of {x} x {y} are no size: restore the file"
                    )));
                }
                if (x - y).abs() > 1e-3 * x.max(y) {
                    return Err(Flaw::Coordinates(format!(
                        "pixels are {x} x {y}: resample it to square ones"
                    )));
                }
                Some(x * unit)
            }
        };
        Ok(Self { resolution, vertical_unit })
    }
}

/// Metres in a unit of length by its EPSG code: metre, foot, US survey foot.
fn metres(code: u16) -> Option<f64> {
    match code {
        9001 => Some(1.0),
        9002 => Some(0.3048),
        9003 => Some(1200.0 / 3937.0),
        _ => None,
    }
}

/// The file's directory of geographic keys.
struct Keys {
    entries: Vec<[u16; 4]>,
    doubles: Vec<f64>,
}

impl Keys {
    fn read(tiff: &mut Source) -> Result<Self, Flaw> {
        let directory: Vec<u16> =
            tiff.find_tag_unsigned_vec(KEY_DIRECTORY).map_err(flaw)?.unwrap_or_default();
        // The first four are versions and the number of keys; then four a key.
        let entries = directory.chunks_exact(4).skip(1).map(|k| [k[0], k[1], k[2], k[3]]).collect();
        Ok(Self { entries, doubles: doubles(tiff, DOUBLE_PARAMS)?.unwrap_or_default() })
    }

    fn entry(&self, key: u16, location: u16) -> Option<u16> {
        self.entries.iter().find(|e| e[0] == key && e[1] == location).map(|e| e[3])
    }

    /// A key whose value stands in the directory itself.
    fn short(&self, key: u16) -> Option<u16> {
        self.entry(key, 0)
    }

    fn double(&self, key: u16) -> Option<f64> {
        self.doubles.get(usize::from(self.entry(key, DOUBLE_PARAMS.to_u16())?)).copied()
    }
}

fn doubles(tiff: &mut Source, tag: Tag) -> Result<Option<Vec<f64>>, Flaw> {
    tiff.find_tag(tag).map_err(flaw)?.map(|v| v.into_f64_vec().map_err(flaw)).transpose()
}

fn flaw(e: TiffError) -> Flaw {
    match e {
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Flaw::Truncated("it ends within its data".into())
        }
        TiffError::IoError(e) => Flaw::Unreadable(e),
        TiffError::LimitsExceeded => {
            Flaw::TooLarge { found: 8 * MAX_SAMPLES + 1, limit: 8 * MAX_SAMPLES, unit: "bytes (or more)" }
        }
        other => Flaw::Damaged(line(&other)),
    }
}
