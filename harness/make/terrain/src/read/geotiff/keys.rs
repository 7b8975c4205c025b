//! What the tags of a GeoTIFF say of places and units: the directory of geographic keys (OGC 19-008r4), tie points, scale and matrix,
//! and GDAL's metadata.

use tiff::tags::Tag;

use super::{Image, doubles};
use crate::crs::{Crs, Length, Vertical};
use crate::read::finish::Lay;
use crate::read::survey::short;
use crate::read::{Flaw, Source};

const PIXEL_SCALE: Tag = Tag::Unknown(33550);
const TIE_POINTS: Tag = Tag::Unknown(33922);
const TRANSFORMATION: Tag = Tag::Unknown(34264);
const KEY_DIRECTORY: Tag = Tag::Unknown(34735);
const DOUBLE_PARAMS: Tag = Tag::Unknown(34736);
const ASCII_PARAMS: Tag = Tag::Unknown(34737);

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const ANGULAR_UNITS: u16 = 2054;
const ANGULAR_UNIT_SIZE: u16 = 2055;
const PROJECTED_SYSTEM: u16 = 3072;
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_SYSTEM: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;
const CITATION: u16 = 1026;
const GEOGRAPHIC_CITATION: u16 = 2049;
const PROJECTED_CITATION: u16 = 3073;
const PROJECTION_METHOD: u16 = 3075;

/// A code that the user of the file defines.
const USER_DEFINED: u16 = 32767;

/// The file's directory of geographic keys.
pub(super) struct Keys {
    entries: Vec<[u16; 4]>,
    doubles: Vec<f64>,
    text: String,
}

impl Keys {
    pub(super) fn read(tiff: &mut Source, image: &Image) -> Result<Self, Flaw> {
        let directory: Vec<u16> = image.unsigned(tiff, KEY_DIRECTORY)?.unwrap_or_default();
        // The first four are versions and the number of keys; then four a key.
        let entries = directory.chunks_exact(4).skip(1).map(|k| [k[0], k[1], k[2], k[3]]).collect();
        let text = image.text(tiff, ASCII_PARAMS)?.unwrap_or_default();
        Ok(Self { entries, doubles: doubles(tiff, image, DOUBLE_PARAMS)?.unwrap_or_default(), text })
    }

    fn entry(&self, key: u16, location: u16) -> Option<[u16; 4]> {
        self.entries.iter().find(|e| e[0] == key && e[1] == location).copied()
    }

    /// A key whose value stands in the directory itself; 0 means undefined.
    fn short(&self, key: u16) -> Option<u16> {
        self.entry(key, 0).map(|e| e[3]).filter(|v| *v != 0)
    }

    fn double(&self, key: u16) -> Option<f64> {
        self.doubles.get(usize::from(self.entry(key, DOUBLE_PARAMS.to_u16())?[3])).copied()
    }

    fn text(&self, key: u16) -> Option<&str> {
        let [_, _, count, start] = self.entry(key, ASCII_PARAMS.to_u16())?;
        let text = self.text.get(usize::from(start)..usize::from(start) + usize::from(count))?;
        Some(text.trim_end_matches(['|', '\0']).trim())
    }

    /// Whether tie points belong to the middles of pixels and not to their north-western corners.
    fn is_point(&self) -> bool {
        self.short(RASTER_TYPE) == Some(2)
    }

    /// The coordinate reference system; `None` if the file names none.
    pub(super) fn crs(&self, notes: &mut Vec<String>) -> Result<Option<Crs>, Flaw> {
        let coded = |key| self.short(key).filter(|code| *code != USER_DEFINED);
        let model = self.short(MODEL_TYPE);
        if model == Some(3) {
            return Err(Flaw::Coordinates(
                "coordinates are geocentric: reproject it with gdalwarp -t_srs EPSG:CODE IN OUT.tif, with the code of its UTM zone".into(),
            ));
        }
        let projected = match model {
            Some(1) => true,
            Some(2) => false,
            _ if self.short(PROJECTED_SYSTEM).is_some() || self.short(LINEAR_UNITS).is_some() => true,
            _ if self.short(GEOGRAPHIC_SYSTEM).is_some() => false,
            _ => return Ok(None),
        };
        let own = if projected { PROJECTED_CITATION } else { GEOGRAPHIC_CITATION };
        let citation = [own, CITATION].into_iter().find_map(|key| self.text(key)).filter(|t| !t.is_empty());
        let code = coded(if projected { PROJECTED_SYSTEM } else { GEOGRAPHIC_SYSTEM });
        let known = code.and_then(Crs::epsg).filter(|crs| crs.geographic != projected);
        let unit = if projected { self.linear_unit()? } else { self.angular_unit()? };
        let name = match (code, citation) {
            (Some(code), _) => format!("EPSG:{code}"),
            (None, Some(text)) => text.split(['|', '\n']).next().unwrap_or(text).chars().take(80).collect(),
            (None, None) => "a system without a name".to_owned(),
        };
        if projected && known.is_none() {
            let mercator = if self.short(PROJECTION_METHOD) == Some(7) {
                "; it is a Mercator projection, whose metres are too long away from its standard parallel"
            } else {
                ""
            };
            let metres = if unit.is_none() { ", metres are assumed" } else { "" };
            notes.push(format!(
                "its projection ({name}) is unknown{metres}: its distances are used unchanged{mercator}; give another system \
                 with --crs"
            ));
        }
        Ok(Some(match known {
            Some(crs) => {
                if let Some(unit) = unit.filter(|unit| projected && (unit / crs.unit - 1.0).abs() > 1e-5) {
                    return Err(Flaw::Coordinates(format!(
                        "its key of linear units says {unit} m, but {name} has units of {} m: correct it with gdal_edit.py -a_srs",
                        crs.unit
                    )));
                }
                Crs { unit: unit.unwrap_or(crs.unit), ..crs }
            }
            None => {
                Crs { name, proj: None, geographic: !projected, unit: unit.unwrap_or(1.0), heights: None }
            }
        }))
    }

    /// Metres in a unit of the coordinates, if a key says so.
    fn linear_unit(&self) -> Result<Option<f64>, Flaw> {
        let size = match self.short(LINEAR_UNITS) {
            None => return Ok(None),
            Some(USER_DEFINED) => self.double(LINEAR_UNIT_SIZE).filter(|m| m.is_finite() && *m > 0.0),
            Some(code) => Length::epsg(code).map(|u| u.metres),
        };
        let unknown = || {
            Flaw::Coordinates("the unit of its coordinates is unknown: reproject it to a system in metres (gdalwarp -t_srs EPSG:CODE IN OUT.tif)".into())
        };
        size.map(Some).ok_or_else(unknown)
    }

    /// Degrees in a unit of longitudes and latitudes, if a key says so.
    fn angular_unit(&self) -> Result<Option<f64>, Flaw> {
        let radian = 180.0 / std::f64::consts::PI;
        let degrees = match self.short(ANGULAR_UNITS) {
            None => return Ok(None),
            Some(9102 | 9122 | 9107 | 9108 | 9110) => Some(1.0),
            Some(9101) => Some(radian),
            Some(9103) => Some(1.0 / 60.0),
            Some(9104) => Some(1.0 / 3600.0),
            Some(9105 | 9106) => Some(0.9),
            Some(9109) => Some(1e-6 * radian),
            Some(USER_DEFINED) => self.double(ANGULAR_UNIT_SIZE).map(|size| size * radian),
            Some(_) => None,
        };
        let known = degrees.filter(|d| d.is_finite() && *d > 0.0);
        known.map(Some).ok_or_else(|| Flaw::Coordinates("the unit of its longitudes and latitudes is unknown: reproject it with gdalwarp -t_srs EPSG:4326 IN OUT.tif".into()))
    }

    /// The unit of heights, if a key or GDAL's metadata say so.
    pub(super) fn heights(&self, named: Option<&str>) -> Result<Option<Length>, Flaw> {
        let unknown = |what: String| Flaw::HeightUnit(what);
        if let Some(name) = named.map(str::trim).filter(|n| !n.is_empty()) {
            return Length::named(name).map(Some).ok_or_else(|| unknown(format!("{name:?} (UNITTYPE)")));
        }
        let system = self.short(VERTICAL_SYSTEM).filter(|code| *code != USER_DEFINED);
        let vertical = system.and_then(Vertical::epsg);
        if vertical == Some(Vertical::Depth) {
            return Err(Flaw::Coordinates(format!(
                "its vertical system (EPSG:{}) measures depths (positive down): convert them to heights (gdal_calc.py --calc=-A)",
                system.unwrap_or_default()
            )));
        }
        if let Some(code) = self.short(VERTICAL_UNITS) {
            return Length::epsg(code).map(Some).ok_or_else(|| unknown(format!("EPSG:{code}")));
        }
        match (system, vertical) {
            (_, Some(Vertical::Height(unit))) => Ok(Some(unit)),
            _ => Ok(None),
        }
    }
}

/// How the pixels lie, from tie points with scale or from the matrix.
pub(super) fn lay(
    tiff: &mut Source,
    image: &Image,
    keys: &Keys,
    notes: &mut Vec<String>,
) -> Result<Option<Lay>, Flaw> {
    let scale = doubles(tiff, image, PIXEL_SCALE)?;
    let ties = doubles(tiff, image, TIE_POINTS)?.unwrap_or_default();
    let matrix = doubles(tiff, image, TRANSFORMATION)?;
    // From the corner of a pixel to its middle.
    let shift = if keys.is_point() { 0.0 } else { 0.5 };
    let bad = |what: String| Err(Flaw::Coordinates(what));
    let lay = match (scale.as_deref(), matrix.as_deref()) {
        (Some([x, y, ..]), _) => {
            if !(x.is_finite() && y.is_finite() && *x > 0.0 && *y > 0.0) {
                return bad(format!("the pixel size {x} x {y} is invalid: restore the file"));
            }
            let origin = match ties.as_slice() {
                [col, row, _, east, north, ..] => Some([east + (shift - col) * x, north - (shift - row) * y]),
                _ => None,
            };
            Lay::north_up(origin, [*x, *y])
        }
        (None, Some([a, b, _, east, d, e, _, north, ..])) => Lay {
            origin: Some([east + shift * (a + b), north + shift * (d + e)]),
            right: [*a, *d],
            down: [*b, *e],
        },
        _ => {
            if ties.len() > 6 {
                notes.push(format!(
                    "it is placed by {} control points, which are not used: gdalwarp -r bilinear IN OUT.tif makes a grid of them",
                    ties.len() / 6
                ));
            }
            return Ok(None);
        }
    };
    if lay.origin.is_some_and(|o| !o.iter().all(|v| v.is_finite())) {
        return bad("its position is not a number: restore the file".into());
    }
    Ok(Some(lay))
}

/// GDAL's metadata of one band: scale, offset and unit of the values.
#[derive(Debug, Default, PartialEq)]
pub(super) struct BandMetadata {
    pub(super) scale: f64,
    pub(super) offset: f64,
    pub(super) unit: Option<String>,
}

impl BandMetadata {
    /// Reads the XML of GDAL's tag 42112 for the first band.
    pub(super) fn parse(xml: &str) -> Result<Self, Flaw> {
        let mut found = Self { scale: 1.0, offset: 0.0, unit: None };
        let xml = xml.trim_matches(|c: char| c.is_whitespace() || c == '\0');
        if xml.is_empty() {
            return Ok(found);
        }
        let damaged = |what: String| Flaw::Damaged(format!("GDAL's metadata (tag 42112) {what}"));
        let document = roxmltree::Document::parse(xml).map_err(|e| damaged(format!("is not XML ({e})")))?;
        for item in document.descendants().filter(|n| n.has_tag_name("Item")) {
            if item.attribute("sample").is_some_and(|s| s.trim() != "0") {
                continue;
            }
            let (role, text) =
                (item.attribute("role").unwrap_or_default(), item.text().unwrap_or_default().trim());
            let number = || {
                let number = decimal(text).filter(|v| v.is_finite());
                number.ok_or_else(|| damaged(format!("has {role} {text:?}, which is not a number")))
            };
            match role {
                "scale" => found.scale = number()?,
                "offset" => found.offset = number()?,
                "unittype" => found.unit = Some(text.to_owned()),
                _ => {}
            }
        }
        if found.scale == 0.0 {
            return Err(damaged(format!("has scale {}, which makes all heights equal", short(found.scale))));
        }
        Ok(found)
    }
}

/// A number with a decimal point or comma.
pub(in crate::read) fn decimal(text: &str) -> Option<f64> {
    let text = text.trim();
    let plain = text.strip_prefix('\u{2212}').map(|rest| format!("-{rest}"));
    let text = plain.as_deref().unwrap_or(text);
    let point = if text.contains('.') || text.matches(',').count() != 1 {
        text.to_owned()
    } else {
        text.replace(',', ".")
    };
    if let Ok(v) = point.parse::<f64>() {
        return Some(v);
    }
    // Microsoft's spellings, and signs before nan.
    let lower = point.to_ascii_lowercase();
    let odd = lower.trim_start_matches(['+', '-']);
    (odd == "nan" || odd.starts_with("nan(") || odd.starts_with("1.#") && !odd.starts_with("1.#inf"))
        .then_some(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_the_spellings_of_programs() {
        assert_eq!(decimal("-9999,0"), Some(-9999.0));
        assert_eq!(decimal(" -3.40282e+38 "), Some(-3.40282e38));
        assert_eq!(decimal("\u{2212}9999"), Some(-9999.0));
        for text in ["nan", "NaN", "-nan", "1.#QNAN", "-1.#IND", "nan(ind)"] {
            assert!(decimal(text).is_some_and(f64::is_nan), "{text}");
        }
        assert_eq!(decimal("1,234,5"), None);
        assert_eq!(decimal("none"), None);
    }

    #[test]
    fn metadata_of_the_first_band_count() {
        let xml = "<GDALMetadata>\n <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item><Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.01</Item>\
                   <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">100</Item><Item name=\"x\">y</Item></GDALMetadata>\n\0";
        let found = BandMetadata::parse(xml).unwrap();
        assert_eq!((found.scale, found.offset, found.unit), (0.01, 100.0, None));
        assert!(BandMetadata::parse("<GDALMetadata><Item role=\"scale\">x</Item></GDALMetadata>").is_err());
    }
}
