//! Grey pictures: BMP and PNG, 8 or 16 bits.

use std::io::BufReader;
use std::path::Path;

use image::{DynamicImage, ImageDecoder as _, ImageError, ImageReader};

use super::{Flaw, Found, MAX_SAMPLES, check_size, line};
use crate::ElevationImage;

/// Reads the grey levels of a picture.
pub(super) fn read(path: &Path) -> Result<Found, Flaw> {
    let reader = ImageReader::new(BufReader::new(vb_files::open(path)?)).with_guessed_format()?;
    let decoder = reader.into_decoder().map_err(flaw)?;
    let (cols, rows) = decoder.dimensions();
    check_size(rows.into(), cols.into())?;
    let found = decoder.original_color_type();
    let picture = DynamicImage::from_decoder(decoder).map_err(flaw)?;
    let values: Vec<f64> = match &picture {
        DynamicImage::ImageLuma8(p) => p.as_raw().iter().map(|v| f64::from(*v)).collect(),
        DynamicImage::ImageLuma16(p) => p.as_raw().iter().map(|v| f64::from(*v)).collect(),
        // A palette of greys, as many bitmaps have it, comes as colours.
        DynamicImage::ImageRgb8(p) if p.pixels().all(|p| p.0[0] == p.0[1] && p.0[1] == p.0[2]) => {
            p.pixels().map(|p| f64::from(p.0[0])).collect()
        }
        _ => {
            return Err(Flaw::Type {
                found: format!("colours ({found:?})"),
                wanted: "greys of 8 or 16 bits",
            });
        }
    };
    Ok(Found { raster: ElevationImage::new(rows as usize, cols as usize, values), no_data: Vec::new() })
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
