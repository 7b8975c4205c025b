//! The samples of one band as the file has them: strips or tiles, packed or not, neither inverted nor scaled.
//!
//! The library `tiff` inverts bands of which 0 is white, and the mark of no data with them; its decoder of Zstandard is a
//! library in C. So it reads directories here, and its kin unpack.

use std::io::{Read, Seek as _, SeekFrom};

use tiff::tags::Tag;

use super::{CONVERT, Image};
use crate::read::{Flaw, MAX_SAMPLES, Source, line};

/// Most bytes of an unpacked strip or tile: 2 GiB.
const MAX_CHUNK: u64 = 8 * MAX_SAMPLES;

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Unsigned,
    Signed,
    Float,
}

/// Strips or tiles, how they are packed, and what a sample is.
pub(super) struct Layout {
    /// Rows and columns of the image.
    pub(super) rows: usize,
    pub(super) cols: usize,
    /// Bits of a sample: 1, 8, 16, 32 or 64.
    bits: usize,
    kind: Kind,
    bands: usize,
    planar: bool,
    tile: Option<[usize; 2]>,
    rows_per_strip: usize,
    compression: u16,
    predictor: u16,
    /// Bits of a byte lie in reverse order.
    reversed: bool,
    big_endian: bool,
    offsets: Vec<u64>,
    lengths: Vec<u64>,
}

impl Layout {
    /// Reads how the samples of an image lie, and refuses what can't be unpacked.
    pub(super) fn read(tiff: &mut Source, image: &Image) -> Result<Self, Flaw> {
        let mut one = |tag: Tag, default: u64| -> Result<u64, Flaw> {
            Ok(image.unsigned::<u64>(tiff, tag)?.and_then(|v| v.first().copied()).unwrap_or(default))
        };
        let bits = one(Tag::BitsPerSample, 1)?;
        let format = one(Tag::SampleFormat, 1)?;
        let compression = one(Tag::Compression, 1)?;
        let predictor = one(Tag::Predictor, 1)?;
        let planar = one(Tag::PlanarConfiguration, 1)? == 2;
        let rows_per_strip = one(Tag::RowsPerStrip, u64::MAX)?.clamp(1, image.rows.max(1));
        let tile = [one(Tag::TileLength, 0)?, one(Tag::TileWidth, 0)?];
        let reversed = one(Tag::FillOrder, 1)? == 2;
        let kind = match format {
            // Undefined samples are taken for whole numbers, as GDAL does.
            1 | 4 => Kind::Unsigned,
            2 => Kind::Signed,
            3 => Kind::Float,
            5 | 6 => return Err(unusual("complex numbers")),
            other => return Err(unusual(&format!("of the unknown format {other}"))),
        };
        if !matches!(
            (kind, bits),
            (Kind::Unsigned, 1 | 8 | 16 | 32 | 64)
                | (Kind::Signed, 8 | 16 | 32 | 64)
                | (Kind::Float, 16 | 32 | 64)
        ) {
            let what = if kind == Kind::Float { "floats" } else { "whole numbers" };
            return Err(unusual(&format!("{what} of {bits} bits")));
        }
        packed_as(compression)?;
        match (predictor, kind) {
            (1, _) => {}
            (2, _) if bits >= 8 => {}
            (3, Kind::Float) => {}
            _ => {
                return Err(Flaw::Unsupported(format!(
                    "predictor {predictor} of samples of {bits} bits is not supported: {CONVERT}"
                )));
            }
        }
        let many = |v: Option<Vec<u64>>| v.unwrap_or_default();
        let tiled = image.directory.contains(Tag::TileOffsets);
        let (offsets, lengths) = if tiled {
            (many(image.unsigned(tiff, Tag::TileOffsets)?), many(image.unsigned(tiff, Tag::TileByteCounts)?))
        } else {
            (
                many(image.unsigned(tiff, Tag::StripOffsets)?),
                many(image.unsigned(tiff, Tag::StripByteCounts)?),
            )
        };
        let big_endian = tiff.byte_order() == tiff::tags::ByteOrder::BigEndian;
        let layout = Self {
            rows: image.rows as usize,
            cols: image.cols as usize,
            bits: bits as usize,
            kind,
            bands: usize::from(image.bands),
            planar,
            tile: tiled.then_some(tile.map(|n| usize::try_from(n).unwrap_or(usize::MAX))),
            rows_per_strip: rows_per_strip as usize,
            compression: compression as u16,
            predictor: predictor as u16,
            reversed,
            big_endian,
            offsets,
            lengths,
        };
        layout.check()?;
        Ok(layout)
    }

    /// Rows and columns of a strip or tile.
    fn chunk(&self) -> [usize; 2] {
        self.tile.unwrap_or([self.rows_per_strip, self.cols])
    }

    /// Bands in a strip or tile.
    fn woven(&self) -> usize {
        if self.planar { 1 } else { self.bands }
    }

    fn check(&self) -> Result<(), Flaw> {
        let [rows, cols] = self.chunk();
        if rows == 0 || cols == 0 {
            return Err(Flaw::Damaged("its tiles have no size".into()));
        }
        // A strip is cut to the image; a tile may be as wide as it likes, but not without a bound.
        let row =
            (cols as u64).saturating_mul(self.woven() as u64).saturating_mul(self.bits as u64).div_ceil(8);
        let bytes = row.saturating_mul(rows.min(self.rows) as u64);
        if bytes > MAX_CHUNK {
            return Err(Flaw::TooLarge { found: bytes, limit: MAX_CHUNK, unit: "bytes of a strip or tile" });
        }
        let planes = if self.planar { self.bands } else { 1 };
        let needed = self.rows.div_ceil(rows).saturating_mul(self.cols.div_ceil(cols)).saturating_mul(planes);
        if self.offsets.len() < needed || self.lengths.len() < needed {
            return Err(Flaw::Truncated(format!(
                "{} places and {} lengths of strips or tiles, but {needed} are needed",
                self.offsets.len(),
                self.lengths.len()
            )));
        }
        Ok(())
    }

    /// Whether a value that isn't finite can be among the samples.
    pub(super) fn is_float32(&self) -> bool {
        self.kind == Kind::Float && self.bits <= 32
    }

    /// The samples of a band, row-major, with those of chunks that the file leaves out marked in `absent`.
    pub(super) fn band(
        &self,
        tiff: &mut Source,
        band: usize,
        absent: &mut Vec<bool>,
    ) -> Result<Vec<f64>, Flaw> {
        let [rows, cols] = self.chunk();
        let (across, down) = (self.cols.div_ceil(cols), self.rows.div_ceil(rows));
        let all = self.rows * self.cols;
        if self.lengths.iter().all(|length| *length == 0) {
            return Err(Flaw::NoHeights);
        }
        // Memory is taken once there is something to put into it.
        let mut values = Vec::new();
        let (first, step) = if self.planar { (0, 1) } else { (band, self.bands) };
        for k in 0..across * down {
            let (row, col) = (k / across * rows, k % across * cols);
            let (height, width) = (rows.min(self.rows - row), cols.min(self.cols - col));
            let chunk = if self.planar { band * across * down + k } else { k };
            if self.lengths[chunk] == 0 {
                absent.resize(all, false);
                for r in row..row + height {
                    absent[r * self.cols + col..][..width].fill(true);
                }
                continue;
            }
            let bytes = self.unpack(tiff, chunk, height)?;
            values.resize(all, 0.0);
            let stride = self.stride();
            for r in 0..height {
                let line = &bytes[r * stride..(r + 1) * stride];
                let out = &mut values[(row + r) * self.cols + col..][..width];
                for (c, v) in out.iter_mut().enumerate() {
                    *v = self.sample(line, first + c * step);
                }
            }
        }
        values.resize(all, 0.0);
        Ok(values)
    }

    /// The first rows of a strip or tile, unpacked, with the numbers of a row in the order of bytes of the file or, of those whose
    /// differences were stored, of big-endian machines.
    fn unpack(&self, tiff: &mut Source, chunk: usize, height: usize) -> Result<Vec<u8>, Flaw> {
        let stride = self.stride();
        let wanted = stride * height;
        // Nothing that any program packs grows by more than half.
        let whole = stride as u64 * self.chunk()[0].min(self.rows) as u64;
        let length = self.lengths[chunk].min(2 * whole + 4096);
        let source = tiff.inner();
        source.seek(SeekFrom::Start(self.offsets[chunk]))?;
        let mut packed = Turned { inner: source.take(length), reversed: self.reversed };
        let mut bytes = Vec::new();
        let short_of = |found: usize| {
            Flaw::Truncated(format!("strip or tile {chunk} has {found} bytes, but {wanted} are needed"))
        };
        let damaged =
            |e: &dyn std::fmt::Display| Flaw::Damaged(format!("strip or tile {chunk}: {}", line(e)));
        match self.compression {
            NONE => {
                packed.take(wanted as u64).read_to_end(&mut bytes)?;
            }
            LZW => {
                let mut input = Vec::new();
                packed.read_to_end(&mut input)?;
                // A code of nine bits or more stands for 4096 bytes at most.
                if wanted > 4096 * (input.len() + 1) {
                    return Err(short_of(input.len()));
                }
                bytes = vec![0; wanted];
                let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
                let (mut used, mut made) = (0, 0);
                while made < wanted {
                    let step = decoder.decode_bytes(&input[used..], &mut bytes[made..]);
                    used += step.consumed_in;
                    made += step.consumed_out;
                    match step.status {
                        Ok(weezl::LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => {}
                        Ok(_) => break,
                        Err(e) => return Err(damaged(&e)),
                    }
                }
                bytes.truncate(made);
            }
            DEFLATE | OLD_DEFLATE => {
                let mut decoder = flate2::read::ZlibDecoder::new(packed).take(wanted as u64);
                decoder.read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
            }
            PACK_BITS => {
                let mut input = Vec::new();
                packed.read_to_end(&mut input)?;
                bytes = pack_bits(&input, wanted);
            }
            _ => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| damaged(&e))?;
                decoder.take(wanted as u64).read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
            }
        }
        if bytes.len() < wanted {
            return Err(short_of(bytes.len()));
        }
        match self.predictor {
            2 => bytes.chunks_exact_mut(stride).for_each(|row| self.add_up(row)),
            3 => {
                let mut planes = vec![0; stride];
                bytes.chunks_exact_mut(stride).for_each(|row| self.join_planes(row, &mut planes));
            }
            _ => {}
        }
        Ok(bytes)
    }

    /// Bytes of a row of a strip or tile.
    fn stride(&self) -> usize {
        (self.chunk()[1] * self.woven() * self.bits).div_ceil(8)
    }

    /// Whether numbers are big-endian once they are unpacked: the planes of predictor 3 always are.
    fn is_big(&self) -> bool {
        self.big_endian || self.predictor == 3
    }

    /// Undoes horizontal differencing: each sample is stored as its difference from that of its band before.
    fn add_up(&self, row: &mut [u8]) {
        let (size, big) = (self.bits / 8, self.big_endian);
        let step = size * self.woven();
        for i in (step..row.len()).step_by(size) {
            if i + size > row.len() {
                break;
            }
            let sum =
                number(&row[i - step..i - step + size], big).wrapping_add(number(&row[i..i + size], big));
            let bytes = sum.to_le_bytes();
            for k in 0..size {
                row[i + if big { size - 1 - k } else { k }] = bytes[k];
            }
        }
    }

    /// Undoes the differencing of floats: differences of bytes, the first bytes of all numbers first.
    fn join_planes(&self, row: &mut [u8], planes: &mut [u8]) {
        let size = self.bits / 8;
        let step = self.woven();
        for i in step..row.len() {
            row[i] = row[i].wrapping_add(row[i - step]);
        }
        planes.copy_from_slice(row);
        let count = row.len() / size;
        for (k, number) in row.chunks_exact_mut(size).enumerate() {
            for (b, byte) in number.iter_mut().enumerate() {
                *byte = planes[b * count + k];
            }
        }
    }

    /// A sample of an unpacked row.
    fn sample(&self, row: &[u8], index: usize) -> f64 {
        if self.bits == 1 {
            return f64::from(row[index / 8] >> (7 - index % 8) & 1);
        }
        let size = self.bits / 8;
        let n = number(&row[index * size..(index + 1) * size], self.is_big());
        match (self.kind, self.bits) {
            (Kind::Unsigned, _) => n as f64,
            (Kind::Signed, 8) => f64::from(n as u8 as i8),
            (Kind::Signed, 16) => f64::from(n as u16 as i16),
            (Kind::Signed, 32) => f64::from(n as u32 as i32),
            (Kind::Signed, _) => n as i64 as f64,
            (Kind::Float, 16) => half::f16::from_bits(n as u16).to_f64(),
            (Kind::Float, 32) => f64::from(f32::from_bits(n as u32)),
            (Kind::Float, _) => f64::from_bits(n),
        }
    }
}

/// A number of up to 8 bytes.
fn number(bytes: &[u8], big: bool) -> u64 {
    let add = |n: u64, b: &u8| n << 8 | u64::from(*b);
    if big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
}

/// Unpacks PackBits (TIFF 6.0, section 9) up to a length.
fn pack_bits(input: &[u8], wanted: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = input;
    while let [head, tail @ ..] = rest
        && bytes.len() < wanted
    {
        let (count, tail) = match head.cast_signed() {
            n @ 0.. => {
                let count = (n as usize + 1).min(tail.len());
                bytes.extend_from_slice(&tail[..count]);
                (count, tail)
            }
            -128 => (0, tail),
            n => {
                let Some(byte) = tail.first() else { break };
                bytes.resize(bytes.len() + 1 + usize::from(n.unsigned_abs()), *byte);
                (1, tail)
            }
        };
        rest = &tail[count..];
    }
    bytes.truncate(wanted);
    bytes
}

/// Bytes whose bits are turned, if the file's are.
struct Turned<R> {
    inner: R,
    reversed: bool,
}

impl<R: Read> Read for Turned<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        if self.reversed {
            buffer[..n].iter_mut().for_each(|b| *b = b.reverse_bits());
        }
        Ok(n)
    }
}

const NONE: u16 = 1;
const LZW: u16 = 5;
const DEFLATE: u16 = 8;
const OLD_DEFLATE: u16 = 32946;
const PACK_BITS: u16 = 32773;
const ZSTD: u16 = 50000;

/// Refuses what can't be unpacked, by its name.
fn packed_as(compression: u64) -> Result<(), Flaw> {
    let known = [NONE, LZW, DEFLATE, OLD_DEFLATE, PACK_BITS, ZSTD].map(u64::from);
    if known.contains(&compression) {
        return Ok(());
    }
    let name = match compression {
        2..=4 => "CCITT fax",
        6 | 7 => "JPEG",
        34661 => "JBIG",
        34712 => "JPEG 2000",
        34887 => "LERC",
        34925 => "LZMA",
        50001 => "WebP",
        50002 | 52546 => "JPEG XL",
        other => {
            return Err(Flaw::Unsupported(format!(
                "samples are compressed with the unknown method {other}: {CONVERT}"
            )));
        }
    };
    Err(Flaw::Unsupported(format!("samples are compressed with {name}, which is not supported: {CONVERT}")))
}

fn unusual(what: &str) -> Flaw {
    Flaw::Unsupported(format!(
        "samples are {what}: convert them with gdal_translate -ot Float32 -co COMPRESS=DEFLATE IN OUT.tif"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of Apple's technical note 1023.
    #[test]
    fn pack_bits_are_unpacked_as_their_inventor_says() {
        let packed =
            [0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22, 0xf7, 0xaa];
        let plain = [
            0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0x22, 0xaa, 0xaa,
            0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa,
        ];
        assert_eq!(pack_bits(&packed, 24), plain);
        assert_eq!(pack_bits(&packed, 7), plain[..7]);
        assert!(pack_bits(&[0xfe], 7).is_empty());
        assert_eq!(pack_bits(&[5, 1], 7), [1]);
    }
}
