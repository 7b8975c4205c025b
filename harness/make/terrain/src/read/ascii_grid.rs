//! ESRI's ASCII grids (.asc): a header of keys and values, then rows of numbers from the north.

use std::io::{BufRead, BufReader};
use std::path::Path;

use super::finish::{Found, Lay};
use super::geotiff::number;
use super::{Flaw, check_size, open};
use crate::ElevationImage;
use crate::crs::{Crs, Length};

/// Keys of the header in lower case.
pub(super) const KEYS: [&str; 11] = [
    "ncols",
    "nrows",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "xllcentre",
    "yllcentre",
    "cellsize",
    "dx",
    "dy",
];
const NO_DATA: [&str; 2] = ["nodata_value", "nodata"];
/// The mark of grids that name none (ESRI's documentation).
const DEFAULT_NO_DATA: f64 = -9999.0;
/// Longest word, in bytes.
const WORD: usize = 64;
/// Longest file of a projection, in bytes.
const PRJ: u64 = 1 << 16;

/// Words of a text between blanks.
struct Words<R> {
    source: R,
    word: Vec<u8>,
}

impl<R: BufRead> Words<R> {
    /// The next word; `None` at the end.
    fn next(&mut self) -> Result<Option<&str>, Flaw> {
        self.word.clear();
        loop {
            let buffer = self.source.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let blank = |b: &u8| b.is_ascii_whitespace() || *b == 0 || *b == b';';
            if self.word.is_empty() {
                let blanks = buffer.iter().take_while(|b| blank(b)).count();
                if blanks > 0 {
                    self.source.consume(blanks);
                    continue;
                }
            }
            let end = buffer.iter().position(blank);
            let part = &buffer[..end.unwrap_or(buffer.len())];
            if self.word.len() + part.len() > WORD {
                return Err(Flaw::Damaged(format!("a word of it has more than {WORD} bytes")));
            }
            self.word.extend_from_slice(part);
            let used = part.len();
            self.source.consume(used);
            if end.is_some() {
                break;
            }
        }
        if self.word.is_empty() {
            return Ok(None);
        }
        let text = std::str::from_utf8(&self.word).map_err(|_| Flaw::Damaged("is not text".into()))?;
        Ok(Some(text.trim_start_matches('\u{feff}')))
    }
}

#[derive(Default)]
struct Header {
    cols: Option<u64>,
    rows: Option<u64>,
    /// Coordinate of the westernmost or southernmost sample, and whether it is that of its middle.
    corner: [Option<(f64, bool)>; 2],
    size: [Option<f64>; 2],
    no_data: Option<f64>,
}

pub(super) fn read(path: &Path, size: u64) -> Result<Found, Flaw> {
    let mut words = Words { source: BufReader::with_capacity(1 << 16, open(path)?), word: Vec::new() };
    let mut header = Header::default();
    let first = loop {
        let Some(word) = words.next()? else {
            return Err(Flaw::Truncated("it ends within its header".into()));
        };
        let key = word.to_ascii_lowercase();
        if !KEYS.contains(&key.as_str()) && !NO_DATA.contains(&key.as_str()) {
            break value(word)?;
        }
        let Some(text) = words.next()? else { return Err(Flaw::Truncated(format!("it ends after {key}"))) };
        header.take(&key, text)?;
    };
    let missing = |what: &str| Flaw::Damaged(format!("its header lacks {what}"));
    let (cols, rows) =
        (header.cols.ok_or_else(|| missing("ncols"))?, header.rows.ok_or_else(|| missing("nrows"))?);
    check_size(rows, cols)?;
    let [Some(width), Some(height)] = header.size else { return Err(missing("cellsize")) };
    if !(width > 0.0 && height > 0.0 && width.is_finite() && height.is_finite()) {
        return Err(Flaw::Damaged(format!("cellsize is {width}: must be above 0")));
    }
    // A number and a blank take two bytes.
    let count = rows * cols;
    if size < 2 * count {
        return Err(Flaw::Truncated(format!("{size} bytes cannot contain {cols} x {rows} numbers")));
    }
    let mut values = Vec::with_capacity(count as usize);
    values.push(first);
    while (values.len() as u64) < count {
        let Some(word) = words.next()? else {
            return Err(Flaw::Truncated(format!(
                "{} numbers, but the header declares {cols} x {rows}",
                values.len()
            )));
        };
        values.push(value(word)?);
    }
    if let Some(word) = words.next()? {
        return Err(Flaw::Damaged(format!("{word:?} follows the {cols} x {rows} declared numbers")));
    }
    let mark = header.no_data.unwrap_or(DEFAULT_NO_DATA);
    let no_data: Vec<bool> =
        values.iter().map(|v| *v == mark || (v.is_nan() && mark.is_nan()) || same_end(*v, mark)).collect();
    let mut notes = Vec::new();
    if header.no_data.is_none() && no_data.contains(&true) {
        notes.push("it has no NODATA_value: -9999 is used, as defined by ESRI".into());
    }
    // The first row is the northernmost, its coordinate that of the southernmost and the others.
    let origin = match header.corner {
        [Some((x, x_is_middle)), Some((y, y_is_middle))] => {
            let half = |middle: bool, size: f64| if middle { 0.0 } else { 0.5 * size };
            Some([x + half(x_is_middle, width), y + half(y_is_middle, height) + (rows - 1) as f64 * height])
        }
        _ => None,
    };
    let (crs, unit) = projection(path)?;
    let raster = ElevationImage::new(rows as usize, cols as usize, values);
    let lay = Some(Lay::north_up(origin, [width, height]));
    Ok(Found { no_data, lay, crs, unit, notes, ..Found::plain("ESRI ASCII grid", raster) })
}

fn same_end(v: f64, mark: f64) -> bool {
    mark.abs() > 1e37 && v.abs() > 1e37 && v.signum() == mark.signum()
}

fn value(word: &str) -> Result<f64, Flaw> {
    number(word).ok_or_else(|| Flaw::Damaged(format!("{word:?} is not a number")))
}

impl Header {
    fn take(&mut self, key: &str, text: &str) -> Result<(), Flaw> {
        let bad = || Flaw::Damaged(format!("{key} is {text:?}, which is not a number"));
        let count = || {
            number(text)
                .filter(|v| *v >= 0.0 && v.fract() == 0.0 && *v < 1e15)
                .map(|v| v as u64)
                .ok_or_else(bad)
        };
        let float = || number(text).filter(|v| v.is_finite()).ok_or_else(bad);
        match key {
            "ncols" => self.cols = Some(count()?),
            "nrows" => self.rows = Some(count()?),
            "xllcorner" => self.corner[0] = Some((float()?, false)),
            "yllcorner" => self.corner[1] = Some((float()?, false)),
            "xllcenter" | "xllcentre" => self.corner[0] = Some((float()?, true)),
            "yllcenter" | "yllcentre" => self.corner[1] = Some((float()?, true)),
            "cellsize" => self.size = [Some(float()?); 2],
            "dx" => self.size[0] = Some(float()?),
            "dy" => self.size[1] = Some(float()?),
            _ => self.no_data = Some(number(text).ok_or_else(bad)?),
        }
        Ok(())
    }
}

/// The system in the file next to a grid whose name ends in .prj, and the unit of heights that it may name. Without such a file, none.
pub(super) fn projection(path: &Path) -> Result<(Option<Crs>, Option<Length>), Flaw> {
    let file = [path.with_extension("prj"), path.with_extension("PRJ")].into_iter().find(|p| p.is_file());
    let Some(file) = file else { return Ok((None, None)) };
    let text = vb_files::read_text(&file, PRJ)
        .map_err(|e| Flaw::Coordinates(format!("its projection ({}) can't be read: {e}", file.display())))?;
    Ok(well_known(&text))
}

/// The system of a well-known text (OGC 01-009), as far as its name and units go.
pub(super) fn well_known(text: &str) -> (Option<Crs>, Option<Length>) {
    let upper = text.to_ascii_uppercase();
    let start = ["PROJCS[", "PROJCRS[", "GEOGCS[", "GEOGCRS[", "GEODCRS["]
        .into_iter()
        .filter_map(|w| Some((upper.find(w)?, w)));
    let Some((at, word)) = start.min() else { return (None, None) };
    let vertical = upper.find("VERT_CS[").or(upper.find("VERTCS["));
    let end = vertical.unwrap_or(text.len()).max(at);
    let (horizontal, heights) = (&text[at..end], vertical.map(|v| &text[v..]));
    let name = horizontal.split('"').nth(1).unwrap_or("an unnamed system").to_owned();
    let unit = |part: &str| {
        let unit = part.to_ascii_uppercase().rfind("UNIT[")?;
        let mut fields = part[unit + 5..].splitn(3, ',');
        let name = fields.next()?.trim().trim_matches('"').to_owned();
        let size = fields.next()?.trim_end_matches([']', ' ', '\n', '\r']).parse::<f64>().ok();
        size.filter(|s| s.is_finite() && *s > 0.0).map(|size| (name, size))
    };
    let geographic = word.starts_with("GEO");
    let size = unit(horizontal).map_or(1.0, |(_, size)| size);
    let size = if geographic { 1.0 } else { size };
    let known = utm(&name).and_then(Crs::epsg);
    let heights = heights.and_then(unit).map(|(_, size)| Length::of(size));
    let crs = match known {
        Some(crs) => crs,
        None if geographic => Crs { name, ..Crs::wgs84() },
        None => Crs { name, proj: None, geographic, unit: size, heights: None },
    };
    (Some(crs), heights)
}

/// The code of a zone of UTM by ESRI's or EPSG's name of it.
fn utm(name: &str) -> Option<u16> {
    let plain = name.replace(['_', '/'], " ").to_ascii_uppercase();
    let words: Vec<&str> = plain.split_whitespace().collect();
    let at = words.iter().position(|w| *w == "ZONE").filter(|k| *k > 0 && words[k - 1] == "UTM")?;
    let zone = words.get(at + 1)?;
    let (number, south) = (zone.trim_end_matches(['N', 'S']).parse::<u16>().ok()?, zone.ends_with('S'));
    let datum = words[..at - 1].concat();
    match (datum.as_str(), south, number) {
        ("WGS1984" | "WGS84", false, 1..=60) => Some(32600 + number),
        ("WGS1984" | "WGS84", true, 1..=60) => Some(32700 + number),
        ("NAD1983" | "NAD83", false, 1..=23) => Some(26900 + number),
        ("ETRS1989" | "ETRS89", false, 28..=38) => Some(25800 + number),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_known_by_the_texts_next_to_grids() {
        let utm = "PROJCS[\"WGS_1984_UTM_Zone_32N\",GEOGCS[\"GCS_WGS_1984\",UNIT[\"Degree\",0.0174]],UNIT[\"Meter\",1.0]]";
        let (crs, heights) = well_known(utm);
        assert_eq!((crs.map(|c| (c.name, c.unit)), heights), (Some(("EPSG:32632".into(), 1.0)), None));
        let feet = "PROJCS[\"NAD_1983_StatePlane_Ohio_North_FIPS_3401_Feet\",GEOGCS[\"x\",UNIT[\"Degree\",0.0174]],UNIT[\"Foot_US\",0.3048006096012192]],\
                    VERTCS[\"NAVD88\",UNIT[\"Foot_US\",0.3048006096012192]]";
        let (crs, heights) = well_known(feet);
        assert!(crs.is_some_and(|c| (c.unit - 0.304_800_609_6).abs() < 1e-9 && !c.geographic));
        assert_eq!(heights.map(|u| u.name), Some("US survey ft".into()));
        let (crs, _) = well_known("GEOGCS[\"GCS_North_American_1983\",UNIT[\"Degree\",0.0174532925199433]]");
        assert!(crs.is_some_and(|c| c.geographic && c.unit == 1.0));
    }
}
