//! GeoTIFF (OGC 19-008r4): one band of heights, with its place, units and masks, as GDAL reads it.

mod band;
mod keys;

use std::path::Path;

use tiff::decoder::Decoder;
use tiff::tags::Tag;
use tiff::{Directory, TiffError};

use super::finish::Found;
use super::{Flaw, MAX_SAMPLES, Options, Source, check_size, line, open};
use crate::ElevationImage;
use band::Layout;
use keys::{BandMetadata, Keys, decimal};

pub(super) use keys::decimal as number;

const GDAL_METADATA: Tag = Tag::Unknown(42112);
const GDAL_NO_DATA: Tag = Tag::Unknown(42113);
const NEW_SUBFILE_TYPE: Tag = Tag::Unknown(254);
const OLD_SUBFILE_TYPE: Tag = Tag::Unknown(255);

/// What converts a file to one that is read.
const CONVERT: &str = "convert it with gdal_translate -co COMPRESS=DEFLATE IN OUT.tif";
/// Pages that are looked at.
const MOST_PAGES: usize = 1000;

/// A page of the file.
struct Image {
    directory: Directory,
    rows: u64,
    cols: u64,
    bands: u16,
    /// An overview: the same at a lower resolution.
    reduced: bool,
    mask: bool,
    placed: bool,
}

impl Image {
    fn read(tiff: &mut Source, directory: Directory) -> Result<Self, Flaw> {
        let image =
            Self { directory, rows: 0, cols: 0, bands: 1, reduced: false, mask: false, placed: false };
        let mut one = |tag: Tag, default: u64| -> Result<u64, Flaw> {
            Ok(image.unsigned::<u64>(tiff, tag)?.and_then(|v| v.first().copied()).unwrap_or(default))
        };
        let (cols, rows) = (one(Tag::ImageWidth, 0)?, one(Tag::ImageLength, 0)?);
        let bands = one(Tag::SamplesPerPixel, 1)?.clamp(1, u64::from(u16::MAX)) as u16;
        let kind = one(NEW_SUBFILE_TYPE, 0)?;
        let old = one(OLD_SUBFILE_TYPE, 1)?;
        let mask = kind & 4 != 0 || one(Tag::PhotometricInterpretation, 1)? == 4;
        let placed = [33550, 34264, 34735].into_iter().any(|tag| image.directory.contains(Tag::Unknown(tag)));
        Ok(Self { rows, cols, bands, reduced: kind & 1 != 0 || old == 2, mask, placed, ..image })
    }

    /// The numbers of a tag.
    fn unsigned<T: TryFrom<u64>>(&self, tiff: &mut Source, tag: Tag) -> Result<Option<Vec<T>>, Flaw> {
        tiff.read_directory_tags(&self.directory).find_tag_unsigned_vec(tag).map_err(flaw)
    }

    /// The text of a tag, up to its first zero.
    fn text(&self, tiff: &mut Source, tag: Tag) -> Result<Option<String>, Flaw> {
        match tiff.read_directory_tags(&self.directory).find_tag(tag) {
            Ok(value) => Ok(value.and_then(|v| v.into_string().ok())),
            // Names in other alphabets than UTF-8's are of no use.
            Err(TiffError::FormatError(_)) => Ok(None),
            Err(e) => Err(flaw(e)),
        }
    }
}

fn doubles(tiff: &mut Source, image: &Image, tag: Tag) -> Result<Option<Vec<f64>>, Flaw> {
    let value = tiff.read_directory_tags(&image.directory).find_tag(tag).map_err(flaw)?;
    value.map(|v| v.into_f64_vec().map_err(flaw)).transpose()
}

/// Reads the page of heights with its mask.
pub(super) fn read(path: &Path, options: &Options) -> Result<Found, Flaw> {
    let mut tiff = decoder(path)?;
    let pages = pages(&mut tiff)?;
    let mut notes = Vec::new();
    let image = chosen(&pages, &mut notes)?;
    check_size(image.rows, image.cols)?;
    let alpha = alpha(&mut tiff, image)?;
    let photometric = image.unsigned::<u16>(&mut tiff, Tag::PhotometricInterpretation)?;
    if photometric.and_then(|v| v.first().copied()) == Some(3) {
        return Err(Flaw::Unsupported(
            "samples are numbers of colours in a palette: convert it with gdal_translate -expand gray IN OUT.tif, if they are greys".into(),
        ));
    }
    let layout = Layout::read(&mut tiff, image)?;
    let keys = Keys::read(&mut tiff, image)?;
    let crs = keys.crs(&mut notes)?;
    let lay = keys::lay(&mut tiff, image, &keys, &mut notes)?;
    let metadata = BandMetadata::parse(&image.text(&mut tiff, GDAL_METADATA)?.unwrap_or_default())?;
    let unit = match options.unit {
        // What the caller says needs no other source.
        Some(_) => keys.heights(metadata.unit.as_deref()).ok().flatten(),
        None if options.labels => None,
        None => keys.heights(metadata.unit.as_deref())?,
    };
    let mark = match (options.no_data, image.text(&mut tiff, GDAL_NO_DATA)?) {
        (None, Some(text)) => mark(&text)?,
        _ => None,
    };
    let mut no_data = Vec::new();
    let values = layout.band(&mut tiff, 0, &mut no_data)?;
    if let Some(mark) = mark {
        no_data.resize(values.len(), false);
        let single = layout.is_float32();
        no_data.iter_mut().zip(&values).for_each(|(hole, v)| *hole |= is_mark(*v, mark, single));
    }
    let mut hide = |shown: Vec<f64>| {
        no_data.resize(shown.len(), false);
        no_data.iter_mut().zip(shown).for_each(|(hole, shown)| *hole |= shown == 0.0);
    };
    if let Some(band) = alpha {
        hide(layout.band(&mut tiff, band, &mut Vec::new())?);
        notes.push("samples masked by its alpha band are holes".into());
    }
    let size = (image.rows, image.cols);
    if let Some(page) = pages.iter().find(|p| p.mask && !p.reduced && (p.rows, p.cols) == size) {
        hide(Layout::read(&mut tiff, page)?.band(&mut tiff, 0, &mut Vec::new())?);
        notes.push("samples outside its mask are holes".into());
    }
    if !no_data.is_empty() && no_data.iter().all(|hole| *hole) {
        return Err(Flaw::NoHeights);
    }
    let raster = ElevationImage::new(image.rows as usize, image.cols as usize, values);
    let scale = [metadata.scale, metadata.offset];
    Ok(Found { no_data, scale, unit, lay, crs, notes, ..Found::plain("GeoTIFF", raster) })
}

/// Reads an external mask (GDAL's `.msk`): one value per sample of the heights, 0 where there is none.
pub(super) fn mask(path: &Path, [rows, cols]: [usize; 2]) -> Result<Vec<f64>, Flaw> {
    let inner = || {
        let mut tiff = decoder(path)?;
        let pages = pages(&mut tiff)?;
        let page =
            pages.iter().find(|p| !p.reduced).ok_or(Flaw::Damaged("it has no page of samples".into()))?;
        if (page.rows, page.cols) != (rows as u64, cols as u64) {
            return Err(Flaw::Damaged(format!(
                "has {} x {} samples, but the heights have {cols} x {rows}",
                page.cols, page.rows
            )));
        }
        Layout::read(&mut tiff, page)?.band(&mut tiff, 0, &mut Vec::new())
    };
    inner().map_err(|flaw| Flaw::Unsupported(format!("its mask {}: {flaw}", path.display())))
}

fn decoder(path: &Path) -> Result<Source, Flaw> {
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = 8 * MAX_SAMPLES as usize;
    Ok(Decoder::new(open(path)?).map_err(flaw)?.with_limits(limits))
}

/// All pages of the file, in order.
fn pages(tiff: &mut Source) -> Result<Vec<Image>, Flaw> {
    let mut next = tiff.ifd_pointer();
    let (mut pages, mut seen) = (Vec::new(), std::collections::BTreeSet::new());
    while let Some(pointer) = next {
        if pages.len() == MOST_PAGES || !seen.insert(pointer.0) {
            break;
        }
        // What lies behind the first page may be damaged without a loss.
        let directory = match tiff.read_directory(pointer) {
            Ok(directory) => directory,
            Err(_) if !pages.is_empty() => break,
            Err(e) => return Err(flaw(e)),
        };
        next = directory.next().filter(|p| p.0 != 0);
        pages.push(Image::read(tiff, directory)?);
    }
    Ok(pages)
}

/// The page at full resolution: neither an overview nor a mask, of several one with a place, of those the largest, of those the first.
fn chosen<'a>(pages: &'a [Image], notes: &mut Vec<String>) -> Result<&'a Image, Flaw> {
    let full = |p: &&Image| !p.mask && !p.reduced;
    let candidates: Vec<&Image> = pages.iter().filter(full).collect();
    let rank = |p: &Image| (p.placed, p.rows.saturating_mul(p.cols));
    let best = candidates.iter().copied().reduce(|best, p| if rank(p) > rank(best) { p } else { best });
    // A file of nothing but overviews is one that was cut off.
    let best = best
        .or_else(|| pages.iter().find(|p| !p.mask))
        .ok_or(Flaw::Damaged("it has no page of samples".into()))?;
    let number = |p: &Image| pages.iter().position(|q| std::ptr::eq(p, q)).map_or(1, |k| k + 1);
    if candidates.len() > 1 {
        notes.push(format!(
            "page {} of {} is read ({} x {}); another one: gdal_translate GTIFF_DIR:NUMBER:IN OUT.tif",
            number(best),
            pages.len(),
            best.cols,
            best.rows
        ));
    } else if best.reduced {
        notes.push(format!("it contains only an overview of {} x {} samples", best.cols, best.rows));
    } else if number(best) > 1 {
        notes.push(format!("page {} of {} is the one at full resolution", number(best), pages.len()));
    }
    Ok(best)
}

/// The band of opacity beside that of heights; other bands are refused.
fn alpha(tiff: &mut Source, image: &Image) -> Result<Option<usize>, Flaw> {
    if image.bands == 1 {
        return Ok(None);
    }
    let extra: Vec<u16> = image.unsigned(tiff, Tag::ExtraSamples)?.unwrap_or_default();
    if image.bands == 2 && matches!(extra.last(), Some(1 | 2)) {
        return Ok(Some(1));
    }
    Err(Flaw::Rank(format!(
        "{} bands: select the height band with gdal_translate -b 1 IN OUT.tif",
        image.bands
    )))
}

/// The mark of no data; `None` of blanks and words for nothing.
fn mark(text: &str) -> Result<Option<f64>, Flaw> {
    let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0' || c == '"');
    if matches!(text.to_ascii_lowercase().as_str(), "" | "none" | "null" | "n/a" | "na") {
        return Ok(None);
    }
    // Some programs write it once for each band.
    let mut words = text.split_whitespace();
    let first = words.next().unwrap_or(text);
    let all = if words.all(|w| w == first) { first } else { text };
    decimal(all).map(Some).ok_or_else(|| Flaw::Mark(text.into()))
}

/// Whether a sample is the mark of no data: GDAL writes it in full precision whatever the samples are, others in a few digits.
pub(super) fn is_mark(v: f64, mark: f64, single: bool) -> bool {
    // Nothing else is as large as the ends of the floats.
    let end = mark.abs() > 1e37 && v.abs() > 1e37 && v.signum() == mark.signum();
    v == mark || (single && v == f64::from(mark as f32)) || (v.is_nan() && mark.is_nan()) || end
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
        TiffError::UnsupportedError(e) => Flaw::Unsupported(format!("{}: {CONVERT}", line(&e))),
        other => Flaw::Damaged(line(&other)),
    }
}
