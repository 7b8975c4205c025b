//! Grey pictures: BMP and PNG, 8 or 16 bits, also such whose greys are stored as colours.

use std::io::{BufRead, Read as _, Seek, SeekFrom};

use image::codecs::bmp::BmpDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::{Flaw, Found, MAX_SAMPLES, check_size, line};
use crate::ElevationImage;

/// A picture whose header was read and whose pixels were not, so that a caller can refuse it before memory is taken for
/// them.
pub struct Picture<'a> {
    pub rows: u64,
    pub cols: u64,
    /// How a bitmap stores its pixels; `None` for a PNG.
    pub bitmap: Option<Bitmap>,
    /// The bytes that the file has, and those that it would need, if it was cut short.
    cut_short: Option<(u64, u128)>,
    decoder: Box<dyn ImageDecoder + 'a>,
}

/// How a Windows bitmap stores its pixels, which a decoded picture doesn't show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bitmap {
    /// The number of bits of a pixel.
    pub bits: u16,
    /// The number of the compression, 0 for none.
    pub compression: u32,
    /// The colours (red, green, blue) of the pixels' values 0 to 255, black where the file has fewer; `None` if pixels
    /// are colours themselves.
    pub palette: Option<Vec<[u8; 3]>>,
}

impl<'a> Picture<'a> {
    /// Reads the header of a picture, whatever the name of its file is.
    ///
    /// # Errors
    /// [`Flaw`]: the source is no picture, or its header is damaged or cut short.
    pub fn open<R: BufRead + Seek + 'a>(mut source: R) -> Result<Self, Flaw> {
        let Layout { bits, compression, cut_short } = Layout::read(&mut source)?.unwrap_or_default();
        let reader = ImageReader::new(source).with_guessed_format()?;
        let (decoder, bitmap): (Box<dyn ImageDecoder + 'a>, _) = match reader.format() {
            Some(ImageFormat::Bmp) => {
                let decoder = BmpDecoder::new(reader.into_inner()).map_err(flaw)?;
                let palette = decoder.get_palette().map(<[_]>::to_vec);
                (Box::new(decoder), Some(Bitmap { bits, compression, palette }))
            }
            _ => (Box::new(reader.into_decoder().map_err(flaw)?), None),
        };
        let (cols, rows) = decoder.dimensions();
        Ok(Self { rows: rows.into(), cols: cols.into(), bitmap, cut_short, decoder })
    }

    /// Reads the grey levels as whole numbers, row by row from the top.
    ///
    /// # Errors
    /// [`Flaw`]: some pixels are no greys, or they are damaged or cut short; the latter is found before memory is taken
    /// for the pixels of a bitmap without compression.
    pub fn greys(self) -> Result<Vec<f64>, Flaw> {
        self.visible().map(|greys| greys.levels)
    }

    fn visible(self) -> Result<Greys, Flaw> {
        if let Some((size, needed)) = self.cut_short {
            return Err(Flaw::Truncated(format!("{size} bytes, but the image needs {needed}")));
        }
        let found = self.decoder.original_color_type();
        let picture = DynamicImage::from_decoder(self.decoder).map_err(flaw)?;
        // A palette of greys, as many bitmaps have it, comes as colours, and so do heights of programs that know no greys.
        let greys = match &picture {
            DynamicImage::ImageLuma8(p) => Some(Greys::plain(p.as_raw().iter().map(|v| f64::from(*v)))),
            DynamicImage::ImageLuma16(p) => Some(Greys::plain(p.as_raw().iter().map(|v| f64::from(*v)))),
            DynamicImage::ImageLumaA8(p) => Greys::of(p.as_raw(), 1, true),
            DynamicImage::ImageLumaA16(p) => Greys::of(p.as_raw(), 1, true),
            DynamicImage::ImageRgb8(p) => Greys::of(p.as_raw(), 3, false),
            DynamicImage::ImageRgb16(p) => Greys::of(p.as_raw(), 3, false),
            DynamicImage::ImageRgba8(p) => Greys::of(p.as_raw(), 3, true),
            DynamicImage::ImageRgba16(p) => Greys::of(p.as_raw(), 3, true),
            _ => None,
        };
        greys.ok_or_else(|| Flaw::Type {
            found: format!("colours ({found:?})"),
            wanted: "greys of 8 or 16 bits",
        })
    }
}

/// The grey levels of a picture.
struct Greys {
    levels: Vec<f64>,
    /// Pixels that can't be seen at all; empty where all can.
    hidden: Vec<bool>,
}

impl Greys {
    fn plain(levels: impl Iterator<Item = f64>) -> Self {
        Self { levels: levels.collect(), hidden: Vec::new() }
    }

    /// Greys of pixels of so many colours, which must be equal, and opacity perhaps; `None` if some are not equal.
    fn of<T: Copy + PartialEq + Into<f64>>(raw: &[T], colours: usize, opacity: bool) -> Option<Self> {
        let pixels = raw.chunks_exact(colours + usize::from(opacity));
        if !pixels.clone().all(|p| p[..colours].iter().all(|c| *c == p[0])) {
            return None;
        }
        let levels = pixels.clone().map(|p| p[0].into()).collect();
        let invisible = |p: &[T]| opacity && p[colours].into() == 0.0;
        let hidden = if pixels.clone().any(invisible) { pixels.map(invisible).collect() } else { Vec::new() };
        Some(Self { levels, hidden })
    }
}

/// What the header of a bitmap says of the places of its pixels. The decoder believes it, and would take the palette
/// for pixels or memory for pixels that are not there.
#[derive(Default)]
struct Layout {
    bits: u16,
    compression: u32,
    /// As in [`Picture`].
    cut_short: Option<(u64, u128)>,
}

impl Layout {
    /// Reads the file header and the BITMAPINFOHEADER (or one of its successors, which begin alike), and leaves the
    /// source at its start. None for everything else, which is left to the decoder.
    fn read<R: BufRead + Seek>(source: &mut R) -> Result<Option<Self>, Flaw> {
        let size = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(0))?;
        let mut start = Vec::new();
        source.by_ref().take(54).read_to_end(&mut start)?;
        source.seek(SeekFrom::Start(0))?;
        let number = |at: usize, bytes: usize| {
            start.get(at..at + bytes).map(|b| b.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
        };
        let Some(header) = number(14, 4).filter(|header| start.starts_with(b"BM") && *header >= 40) else {
            return Ok(None);
        };
        let fields =
            (number(10, 4), number(18, 4), number(22, 4), number(28, 2), number(30, 4), number(46, 4));
        let (Some(offset), Some(cols), Some(rows), Some(bits), Some(compression), Some(colours)) = fields
        else {
            return Err(Flaw::Truncated(format!("{size} bytes, but its header needs 54")));
        };
        if bits <= 8 {
            let colours = if colours == 0 { 1 << bits } else { colours };
            let palette = 14 + header + 4 * colours;
            if offset < palette {
                return Err(Flaw::Damaged(format!(
                    "its pixels begin at byte {offset}, inside the palette, which ends at byte {palette}"
                )));
            }
        }
        // Rows are padded to four bytes; a negative number of them says that the first is on top.
        let rows = u64::from((rows as u32).cast_signed().unsigned_abs());
        let needed = u128::from(offset) + u128::from((cols * bits).div_ceil(32) * 4) * u128::from(rows);
        let cut_short = (compression == 0 && u128::from(size) < needed).then_some((size, needed));
        Ok(Some(Self { bits: bits as u16, compression: compression as u32, cut_short }))
    }
}

/// Reads the grey levels of a picture as heights.
pub(super) fn read(source: impl BufRead + Seek) -> Result<Found, Flaw> {
    let picture = Picture::open(source)?;
    let (rows, cols) = (picture.rows, picture.cols);
    check_size(rows, cols)?;
    let Greys { levels, hidden } = picture.visible()?;
    let raster = ElevationImage::new(rows as usize, cols as usize, levels);
    Ok(Found { no_data: hidden, suspects: false, ..Found::plain(super::PICTURE, raster) })
}

fn flaw(e: ImageError) -> Flaw {
    match e {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Flaw::Truncated(line(&e)),
        ImageError::IoError(e) => Flaw::Unreadable(e),
        ImageError::Limits(_) => {
            Flaw::TooLarge { found: MAX_SAMPLES + 1, limit: MAX_SAMPLES, unit: "samples (or more)" }
        }
        other => {
            let text = line(&other);
            // The PNG decoder tells the end of a file as a format error.
            if text.contains("unexpected end") || text.contains("UnexpectedEof") || text.contains("too short")
            {
                Flaw::Truncated(text)
            } else {
                Flaw::Damaged(text)
            }
        }
    }
}
