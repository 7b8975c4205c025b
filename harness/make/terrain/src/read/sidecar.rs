//! Files that GDAL writes next to an elevation file: metadata (`NAME.aux.xml`, GDAL's persistent auxiliary metadata) and an external mask
//! (`NAME.msk`). Without them scale, unit, holes or place of the heights would be lost without a message.

use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use super::ascii_grid::well_known;
use super::finish::{Found, Lay};
use super::geotiff::{self, is_mark, number};
use super::survey::{Options, short};
use super::{Flaw, line};
use crate::crs::Length;

/// Maximum length of a metadata file, bytes; histograms and attribute tables make some of them long.
const METADATA: u64 = 1 << 24;

/// Adds the statements of the files next to `path`. Scale, offset or unit that contradict those of the file itself are errors; the file's own
/// coordinate system and place take precedence.
pub(super) fn apply(path: &Path, found: &mut Found, options: &Options) -> Result<(), Flaw> {
    if let Some(file) = beside(path, "aux.xml") {
        let text = vb_files::read_text(&file, METADATA)
            .map_err(|e| Flaw::Damaged(format!("its metadata {} can't be read: {e}", file.display())))?;
        Metadata { name: file.display().to_string() }.apply(&text, found, options)?;
    }
    if let Some(file) = beside(path, "msk") {
        let shown = geotiff::mask(&file, [found.raster.rows(), found.raster.cols()])?;
        hide(found, shown.into_iter().map(|v| v == 0.0));
        found.notes.push(format!("samples outside its mask {} are holes", file.display()));
    }
    Ok(())
}

/// The file of this name with another extension after its own, if there is one.
fn beside(path: &Path, extension: &str) -> Option<PathBuf> {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    Some(PathBuf::from(name)).filter(|file| file.is_file())
}

fn hide(found: &mut Found, hidden: impl Iterator<Item = bool>) {
    found.no_data.resize(found.raster.values().len(), false);
    found.no_data.iter_mut().zip(hidden).for_each(|(hole, hidden)| *hole |= hidden);
}

struct Metadata {
    /// Its path, for messages.
    name: String,
}

impl Metadata {
    fn apply(&self, text: &str, found: &mut Found, options: &Options) -> Result<(), Flaw> {
        let document =
            Document::parse(text).map_err(|e| self.damaged(&format!("is not XML ({})", line(&e))))?;
        let root = document.root_element();
        if !root.has_tag_name("PAMDataset") {
            return Ok(());
        }
        if let Some(wkt) = child(root, "SRS").filter(|_| found.crs.is_none()) {
            let (crs, heights) = well_known(wkt);
            found.crs = crs;
            found.unit = found.unit.take().or(heights);
        }
        if let Some(transform) = child(root, "GeoTransform").filter(|_| found.lay.is_none()) {
            found.lay = Some(self.lay(transform)?);
        }
        let band = root.children().find(|n| n.has_tag_name("PAMRasterBand") && is_first(*n));
        let Some(band) = band.filter(|_| !options.labels) else { return Ok(()) };
        // As in the file itself, a mark that can't be read doesn't matter where the caller gives one.
        if options.no_data.is_none()
            && let Some(mark) = self.mark(band)?
        {
            let holes: Vec<bool> =
                found.raster.values().iter().map(|v| is_mark(*v, mark, *v == f64::from(*v as f32))).collect();
            hide(found, holes.into_iter());
        }
        self.scale(band, found)?;
        self.unit(band, found, options)
    }

    fn scale(&self, band: Node<'_, '_>, found: &mut Found) -> Result<(), Flaw> {
        let one = |tag: &str, default: f64| match child(band, tag) {
            None => Ok(default),
            Some(text) => self.finite(tag, text),
        };
        let scale = [one("Scale", 1.0)?, one("Offset", 0.0)?];
        if scale[0] == 0.0 {
            return Err(self.damaged("has Scale 0, which makes all heights equal"));
        }
        if scale == [1.0, 0.0] || scale == found.scale {
            return Ok(());
        }
        if found.scale != [1.0, 0.0] {
            return Err(Flaw::Unsupported(format!(
                "has scale {} and offset {}, but {} states {} and {}: remove the wrong one (gdal_edit.py -unsetscale, -unsetoffset, or delete the \
                 metadata file)",
                short(found.scale[0]),
                short(found.scale[1]),
                self.name,
                short(scale[0]),
                short(scale[1])
            )));
        }
        found.scale = scale;
        found.notes.push(format!(
            "heights are values times {} plus {}, as {} states",
            short(scale[0]),
            short(scale[1]),
            self.name
        ));
        Ok(())
    }

    fn unit(&self, band: Node<'_, '_>, found: &mut Found, options: &Options) -> Result<(), Flaw> {
        let Some(text) = child(band, "UnitType").filter(|_| options.unit.is_none()) else { return Ok(()) };
        let unit = Length::named(text)
            .ok_or_else(|| Flaw::HeightUnit(format!("{text:?} (UnitType in {})", self.name)))?;
        match &found.unit {
            Some(own) if (own.metres / unit.metres - 1.0).abs() > 1e-6 => Err(Flaw::Unsupported(format!(
                "states that heights are in {}, but {} states {}: give the metres of one unit with --unit",
                own.name, self.name, unit.name
            ))),
            _ => {
                found.unit = Some(unit);
                Ok(())
            }
        }
    }

    /// The value of samples without a height. Its bytes, where they are given, are exact, and its digits are not.
    fn mark(&self, band: Node<'_, '_>) -> Result<Option<f64>, Flaw> {
        let Some(node) = band.children().find(|n| n.has_tag_name("NoDataValue")) else { return Ok(None) };
        let bytes = node.attribute("le_hex_equiv").filter(|hex| hex.len() == 16);
        if let Some(bits) = bytes.and_then(|hex| u64::from_str_radix(hex, 16).ok()) {
            return Ok(Some(f64::from_bits(bits.swap_bytes())));
        }
        let text = node.text().unwrap_or_default().trim();
        number(text).map(Some).ok_or_else(|| Flaw::Mark(text.to_owned()))
    }

    /// GDAL's geotransform: x = a + b column + c row, y = d + e column + f row, of the corner of a pixel.
    fn lay(&self, text: &str) -> Result<Lay, Flaw> {
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|t| number(t).filter(|v| v.is_finite())).collect();
        match numbers.as_deref() {
            Some([a, b, c, d, e, f]) => Ok(Lay {
                origin: Some([a + 0.5 * (b + c), d + 0.5 * (e + f)]),
                right: [*b, *e],
                down: [*c, *f],
            }),
            _ => Err(self.damaged(&format!("has GeoTransform {text:?}, which is not six numbers"))),
        }
    }

    fn finite(&self, tag: &str, text: &str) -> Result<f64, Flaw> {
        let value = number(text).filter(|v| v.is_finite());
        value.ok_or_else(|| self.damaged(&format!("has {tag} {text:?}, which is not a number")))
    }

    fn damaged(&self, what: &str) -> Flaw {
        Flaw::Damaged(format!("its metadata {} {what}", self.name))
    }
}

/// The text of a child, if there is any.
fn child<'a>(node: Node<'a, '_>, tag: &str) -> Option<&'a str> {
    let text = node.children().find(|n| n.has_tag_name(tag))?.text()?.trim();
    Some(text).filter(|t| !t.is_empty())
}

fn is_first(band: Node<'_, '_>) -> bool {
    band.attribute("band").is_none_or(|n| n.trim() == "1")
}
