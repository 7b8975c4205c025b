//! A video as a GIF file.

use std::path::Path;

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, Frame, Repeat};

use crate::film::error::cannot_write;
use crate::film::ordered::in_order;
use crate::film::{Film, FilmError, Schedule};

/// Colours of the file; the one after the last of them is clear, and stands for a pixel that stays as it is.
const COLOURS: usize = 255;
const CLEAR: u8 = 255;
/// Frames from which the colours are chosen.
const SAMPLES: usize = 12;
/// Bits of each of red, green and blue by which colours are looked up.
const BITS: u32 = 6;
/// How long the last frame stays, hundredths of a second.
const STAY: u16 = 150;

/// The colours of all frames.
struct Palette {
    rgb: Vec<u8>,
    /// The nearest colour for each cell of the cube of colours.
    nearest: Vec<u8>,
}

impl Palette {
    /// Chooses colours for pixels of red, green and blue.
    fn of(pixels: &[u8]) -> Self {
        let opaque: Vec<u8> = pixels.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        let quantised = NeuQuant::new(10, COLOURS, &opaque);
        let level = |v: usize| ((v << (8 - BITS)) + (1 << (7 - BITS))) as u8;
        let mask = (1 << BITS) - 1;
        let nearest = (0..1_usize << (3 * BITS))
            .map(|k| {
                let [r, g, b] = [k >> (2 * BITS), k >> BITS, k].map(|v| level(v & mask));
                quantised.index_of(&[r, g, b, 255]) as u8
            })
            .collect();
        Self { rgb: quantised.color_map_rgb(), nearest }
    }

    /// The number of the colour for each pixel.
    fn numbers(&self, pixels: &[u8]) -> Vec<u8> {
        let part = |v: u8| usize::from(v >> (8 - BITS));
        let cell = |p: &[u8]| part(p[0]) << (2 * BITS) | part(p[1]) << BITS | part(p[2]);
        pixels.chunks_exact(3).map(|p| self.nearest[cell(p)]).collect()
    }
}

/// The part of a picture that differs from what is shown: its left upper corner, its width and height, and its pixels, of which
/// those that stay are clear. Nothing differs in none.
fn changed(shown: &[u8], next: &[u8], columns: usize) -> Option<([usize; 4], Vec<u8>)> {
    let differs = |k: &usize| shown[*k] != next[*k];
    let top = (0..next.len()).find(differs)? / columns;
    let bottom = (0..next.len()).rev().find(differs)? / columns;
    let of_column = |x: &usize| (top..=bottom).any(|y| differs(&(y * columns + x)));
    let (left, right) = ((0..columns).find(of_column)?, (0..columns).rev().find(of_column)?);
    let pixels = (top..=bottom)
        .flat_map(|y| y * columns + left..=y * columns + right)
        .map(|k| if differs(&k) { next[k] } else { CLEAR })
        .collect();
    Some(([left, top, right - left + 1, bottom - top + 1], pixels))
}

pub(crate) fn write(
    film: &Film,
    schedule: &Schedule,
    path: &Path,
    threads: usize,
    told: &mut dyn FnMut(usize),
) -> Result<(), FilmError> {
    let size = film.size();
    let columns = size.width as usize;
    let failed = |e: &dyn std::fmt::Display| cannot_write(path, e);
    let [width, height] = [size.width, size.height].map(|n| n as u16);
    let n = schedule.times.len();
    let samples = SAMPLES.min(n);
    let sampled: Vec<f64> =
        (0..samples).map(|k| schedule.times[k * (n - 1) / (samples - 1).max(1)]).collect();
    let mut pixels = Vec::new();
    let draw = |_, time| film.frame(time);
    in_order(&sampled, threads, &mut |_| {}, draw, |frame| {
        // About as many of all frames as one has.
        pixels.extend(frame.chunks_exact(3).step_by(SAMPLES - 1).flatten());
        Ok(())
    })?;
    let palette = Palette::of(&pixels);
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height, &palette.rgb).map_err(|e| failed(&e))?;
    encoder.set_repeat(Repeat::Infinite).map_err(|e| failed(&e))?;
    let mut shown: Vec<u8> = Vec::new();
    let mut waiting: Option<Frame<'static>> = None;
    let delay = |k: usize| {
        // Times in a file are whole hundredths, so that they are right in the mean.
        let (a, b) = (100.0 * k as f64 / schedule.fps, 100.0 * (k + 1) as f64 / schedule.fps);
        (b.round() - a.round()) as u16
    };
    let take = |(k, numbers): (usize, Vec<u8>)| -> Result<(), FilmError> {
        let part = if shown.is_empty() {
            Some(([0, 0, columns, size.height as usize], numbers.clone()))
        } else {
            changed(&shown, &numbers, columns)
        };
        let delay = if k + 1 == n { STAY } else { delay(k) };
        match (part, &mut waiting) {
            // What is shown stays for longer, unless that is more than a file can say.
            (None, Some(last)) if last.delay.checked_add(delay).is_some() => last.delay += delay,
            (part, _) => {
                let ([left, top, width, height], buffer) = part.unwrap_or(([0, 0, 1, 1], vec![CLEAR]));
                let [left, top, width, height] = [left, top, width, height].map(|v| v as u16);
                let frame = Frame {
                    left,
                    top,
                    width,
                    height,
                    delay,
                    dispose: DisposalMethod::Keep,
                    transparent: Some(CLEAR),
                    buffer: buffer.into(),
                    ..Frame::default()
                };
                if let Some(last) = waiting.replace(frame) {
                    encoder.write_frame(&last).map_err(|e| failed(&e))?;
                }
            }
        }
        shown = numbers;
        Ok(())
    };
    let make = |k: usize, time: f64| Ok((k, palette.numbers(&film.frame(time)?)));
    in_order(&schedule.times, threads, told, make, take)?;
    if let Some(last) = waiting {
        encoder.write_frame(&last).map_err(|e| failed(&e))?;
    }
    drop(encoder);
    vb_files::write(path, &file).map_err(|e| failed(&e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_near_those_of_the_pixels() {
        // Few colours, each of which must be found again within a cell of the cube.
        let few: [[u8; 3]; 4] = [[250, 10, 10], [10, 200, 30], [20, 20, 220], [128, 128, 128]];
        let pixels: Vec<u8> = few.iter().cycle().take(4000).flatten().copied().collect();
        let palette = Palette::of(&pixels);
        assert_eq!(palette.rgb.len(), 3 * COLOURS);
        for colour in few {
            let number = usize::from(palette.numbers(&colour)[0]);
            let found = &palette.rgb[3 * number..3 * number + 3];
            let off = colour.iter().zip(found).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= 8, "{colour:?} {found:?}");
        }
    }

    #[test]
    fn only_what_changes_is_in_a_frame() {
        let shown = [1, 1, 1, 1, 2, 2, 1, 1, 3];
        assert_eq!(changed(&shown, &shown, 3), None);
        let next = [1, 1, 1, 1, 5, 2, 1, 1, 6];
        assert_eq!(changed(&shown, &next, 3), Some(([1, 1, 2, 2], vec![5, CLEAR, CLEAR, 6])));
    }
}
