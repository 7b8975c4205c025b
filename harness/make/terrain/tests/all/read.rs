//! Elevation files: each kind is read, and whatever is wrong with one is told in one line.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use npyz::WriterBuilder as _;
use tempfile::TempDir;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;
use vb_terrain::ElevationImage;
use vb_terrain::read::{Flaw, Holes, read};

/// A folder for files of one test.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// What is wrong with a file; the message must be one line that begins with the file.
fn flaw(path: &std::path::Path) -> Flaw {
    let e = read(path, Holes::Refuse).unwrap_err();
    let text = e.to_string();
    assert!(text.starts_with(&path.display().to_string()) && !text.contains('\n'), "{text}");
    e.flaw
}

/// An 8-bit bitmap with a palette of greys, as the original's are; rows from the bottom.
fn bitmap(rows: &[[u8; 3]]) -> Vec<u8> {
    let mut b = b"BM".to_vec();
    let height = rows.len() as u32;
    for v in [1078 + 4 * height, 0, 1078, 40, 3, height, 8 << 16 | 1, 0, 4 * height, 3780, 3780, 256, 0] {
        b.extend(v.to_le_bytes());
    }
    b.extend((0..=255u8).flat_map(|k| [k, k, k, 0]));
    for row in rows.iter().rev() {
        b.extend(row);
        b.push(0);
    }
    b
}

fn grey_png(depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut e = png::Encoder::new(&mut out, 3, 2);
    e.set_color(png::ColorType::Grayscale);
    e.set_depth(depth);
    e.write_header().unwrap().write_image_data(data).unwrap();
    out
}

fn array<T: npyz::AutoSerialize + Copy>(shape: &[u64], order: npyz::Order, values: &[T]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut w = npyz::WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .order(order)
        .writer(&mut out)
        .begin_nd()
        .unwrap();
    w.extend(values.iter().copied()).unwrap();
    w.finish().unwrap();
    out
}

/// A GeoTIFF of 2 × 3 floats, with further tags.
fn geotiff(values: &[f32; 6], scale: Option<[f64; 3]>, keys: &[u16], no_data: Option<&str>) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    let mut tiff = TiffEncoder::new(&mut out).unwrap();
    let mut image = tiff.new_image::<colortype::Gray32Float>(3, 2).unwrap();
    let tags = image.encoder();
    if let Some(scale) = scale {
        tags.write_tag(Tag::Unknown(33550), &scale[..]).unwrap();
    }
    if !keys.is_empty() {
        tags.write_tag(Tag::Unknown(34735), keys).unwrap();
    }
    if let Some(text) = no_data {
        tags.write_tag(Tag::Unknown(42113), text).unwrap();
    }
    image.write_data(values).unwrap();
    out.into_inner()
}

/// A directory of geographic keys whose values stand in it.
fn keys(entries: &[[u16; 2]]) -> Vec<u16> {
    let mut all = vec![1, 1, 0, entries.len() as u16];
    for [key, value] in entries {
        all.extend([*key, 0, 1, *value]);
    }
    all
}

const SIX: [f32; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

/// Projected coordinates (model type 1) in metres (9001).
fn metric() -> Vec<u16> {
    keys(&[[1024, 1], [3076, 9001]])
}

fn values(path: &std::path::Path) -> ElevationImage {
    read(path, Holes::Refuse).unwrap()
}

#[test]
fn pictures_of_8_and_16_bits_are_read_with_the_first_row_in_the_north() {
    let f = Folder::new();
    let want = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
    let bmp = values(&f.file("a.bmp", bitmap(&[[10, 20, 30], [40, 50, 60]])));
    assert_eq!((bmp.rows(), bmp.cols(), bmp.values()), (2, 3, &want[..]));
    let png = values(&f.file("a.png", grey_png(png::BitDepth::Eight, &[10, 20, 30, 40, 50, 60])));
    assert_eq!((png.rows(), png.cols(), png.values()), (2, 3, &want[..]));
    let deep: Vec<u8> = [10u16, 20, 30, 40, 50, 60_000].iter().flat_map(|v| v.to_be_bytes()).collect();
    let png = values(&f.file("b.PNG", grey_png(png::BitDepth::Sixteen, &deep)));
    assert_eq!(png.values(), [10.0, 20.0, 30.0, 40.0, 50.0, 60_000.0]);
}

#[test]
fn arrays_of_every_kind_of_number_and_order_are_read() {
    let f = Folder::new();
    let want = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let shape = [2, 3];
    let c = npyz::Order::C;
    let files = [
        f.file("f4.npy", array::<f32>(&shape, c, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
        f.file("f8.npy", array::<f64>(&shape, c, &want)),
        f.file("u1.npy", array::<u8>(&shape, c, &[1, 2, 3, 4, 5, 6])),
        f.file("u2.npy", array::<u16>(&shape, c, &[1, 2, 3, 4, 5, 6])),
        f.file("i2.npy", array::<i16>(&shape, c, &[1, 2, 3, 4, 5, 6])),
        // Column by column.
        f.file("fortran.npy", array::<f64>(&shape, npyz::Order::Fortran, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0])),
    ];
    for file in files {
        let r = values(&file);
        assert_eq!(
            (r.rows(), r.cols(), r.values(), r.resolution()),
            (2, 3, &want[..], None),
            "{}",
            file.display()
        );
    }
}

#[test]
fn a_geotiff_says_its_resolution_and_feet_become_metres() {
    let f = Folder::new();
    let scale = Some([0.5, 0.5, 0.0]);
    let r = values(&f.file("a.tif", geotiff(&SIX, scale, &metric(), Some("-9999"))));
    assert_eq!((r.rows(), r.cols(), r.resolution()), (2, 3, Some(0.5)));
    assert_eq!(r.values(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // Places in US survey feet (1200/3937 m), heights in international feet (0.3048 m).
    let feet = keys(&[[1024, 1], [3076, 9003], [4099, 9002]]);
    let r = values(&f.file("feet.tiff", geotiff(&SIX, scale, &feet, None)));
    assert!((r.resolution().unwrap() - 0.5 * 1200.0 / 3937.0).abs() < 1e-12);
    assert!((r.values()[5] - 6.0 * 0.3048).abs() < 1e-12);
    // Other kinds of samples, without a word on places.
    for name in ["i16", "u16", "f64"] {
        let mut out = std::io::Cursor::new(Vec::new());
        let mut tiff = TiffEncoder::new(&mut out).unwrap();
        match name {
            "i16" => tiff.write_image::<colortype::GrayI16>(2, 2, &[-1, 2, 3, 4]).unwrap(),
            "u16" => tiff.write_image::<colortype::Gray16>(2, 2, &[1, 2, 3, 4]).unwrap(),
            _ => tiff.write_image::<colortype::Gray64Float>(2, 2, &[1.0, 2.0, 3.0, 4.0]).unwrap(),
        }
        let r = values(&f.file(&format!("{name}.tif"), out.into_inner()));
        assert_eq!((r.values()[1..].to_vec(), r.resolution()), (vec![2.0, 3.0, 4.0], None));
    }
}

#[test]
fn holes_and_nan_are_told_with_their_place_or_kept_as_nan() {
    let f = Folder::new();
    let mut holed = SIX;
    (holed[4], holed[5]) = (-9999.0, -9999.0);
    let tif = f.file("holes.tif", geotiff(&holed, None, &metric(), Some("-9999")));
    assert!(matches!(flaw(&tif), Flaw::NoData { count: 2, row: 1, col: 1 }));
    let kept = read(&tif, Holes::Keep).unwrap();
    assert_eq!(kept.holes(), 2);
    assert_eq!(kept.values()[..4], [1.0, 2.0, 3.0, 4.0]);
    // GDAL writes the mark of a single-precision file in double precision.
    let mut lowest = SIX;
    lowest[0] = f32::MIN;
    let tif = f.file("lowest.tif", geotiff(&lowest, None, &metric(), Some("-3.4028234663852886e+38")));
    assert!(matches!(flaw(&tif), Flaw::NoData { count: 1, row: 0, col: 0 }));
    let npy =
        f.file("nan.npy", array(&[2, 3], npyz::Order::C, &[1.0, 2.0, f64::NAN, 4.0, f64::INFINITY, 6.0]));
    assert!(matches!(flaw(&npy), Flaw::NotFinite { count: 2, row: 0, col: 2 }));
    assert_eq!(read(&npy, Holes::Keep).unwrap().holes(), 2);
}

#[test]
fn what_is_no_surface_in_metres_is_refused_by_its_reason() {
    let f = Folder::new();
    let c = npyz::Order::C;
    assert!(matches!(
        flaw(&f.file("row.npy", array(&[1, 6], c, &[1.0f64; 6]))),
        Flaw::TooSmall { rows: 1, cols: 6 }
    ));
    assert!(matches!(
        flaw(&f.file("column.npy", array(&[6, 1], c, &[1.0f64; 6]))),
        Flaw::TooSmall { rows: 6, cols: 1 }
    ));
    assert!(matches!(flaw(&f.file("cube.npy", array(&[2, 3, 2], c, &[1.0f64; 12]))), Flaw::Rank(_)));
    // Model type 2: longitude and latitude; this one says no place.
    let degrees = geotiff(&SIX, Some([1e-5, 1e-5, 0.0]), &keys(&[[1024, 2]]), None);
    assert!(matches!(flaw(&f.file("degrees.tif", degrees)), Flaw::Coordinates(_)));
    let unknown = geotiff(&SIX, Some([1.0, 1.0, 0.0]), &keys(&[[1024, 1], [3076, 9999]]), None);
    assert!(matches!(flaw(&f.file("unknown.tif", unknown)), Flaw::Coordinates(_)));
    let mut out = std::io::Cursor::new(Vec::new());
    TiffEncoder::new(&mut out).unwrap().write_image::<colortype::RGB8>(2, 2, &[0; 12]).unwrap();
    assert!(matches!(flaw(&f.file("colour.tif", out.into_inner())), Flaw::Rank(_)));
    let mut colours = Vec::new();
    let mut e = png::Encoder::new(&mut colours, 2, 2);
    e.set_color(png::ColorType::Rgb);
    e.write_header().unwrap().write_image_data(&[1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3]).unwrap();
    assert!(matches!(flaw(&f.file("colour.png", colours)), Flaw::Type { .. }));
    assert!(matches!(flaw(&f.file("a.txt", "1 2 3")), Flaw::Format(_)));
    assert!(matches!(flaw(&f.0.path().join("none.png")), Flaw::Unreadable(_)));
}

#[test]
fn files_that_were_cut_short_or_are_something_else_are_told_apart() {
    let f = Folder::new();
    let whole = [
        ("a.bmp", bitmap(&[[10, 20, 30], [40, 50, 60]])),
        ("a.png", grey_png(png::BitDepth::Eight, &[1, 2, 3, 4, 5, 6])),
        ("a.npy", array(&[2, 3], npyz::Order::C, &[1.0f64; 6])),
        ("a.tif", geotiff(&SIX, None, &metric(), None)),
    ];
    for (name, bytes) in whole {
        for fraction in [0.3, 0.6, 0.9] {
            let cut = f.file(name, &bytes[..(fraction * bytes.len() as f64) as usize]);
            let flaw = flaw(&cut);
            assert!(matches!(flaw, Flaw::Truncated(_) | Flaw::Damaged(_)), "{name} at {fraction}: {flaw:?}");
        }
        assert!(matches!(flaw(&f.file(name, b"elevation of a mountain")), Flaw::Format(_)));
    }
    assert!(matches!(
        flaw(&f.file("b.npy", &array(&[2, 3], npyz::Order::C, &[1.0f64; 6])[..150])),
        Flaw::Truncated(_)
    ));
}

#[test]
fn a_file_that_announces_more_than_memory_should_hold_is_refused_before_it_is_read() {
    let f = Folder::new();
    // A header of 10⁵ × 10⁵ samples, 75 GiB, and no data.
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (100000, 100000), }";
    let mut npy = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    npy.extend(format!("{header:<117}\n").bytes());
    assert!(matches!(flaw(&f.file("huge.npy", npy)), Flaw::TooLarge { .. }));
    let mut bmp = bitmap(&[[1, 2, 3], [4, 5, 6]]);
    bmp[18..22].copy_from_slice(&60_000u32.to_le_bytes());
    bmp[22..26].copy_from_slice(&60_000u32.to_le_bytes());
    let huge = flaw(&f.file("huge.bmp", bmp));
    assert!(matches!(huge, Flaw::TooLarge { .. }), "{huge}");
    let mut png = grey_png(png::BitDepth::Eight, &[1, 2, 3, 4, 5, 6]);
    png[16..20].copy_from_slice(&100_000u32.to_be_bytes());
    png[20..24].copy_from_slice(&100_000u32.to_be_bytes());
    let crc = crc(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(matches!(flaw(&f.file("huge.png", png)), Flaw::TooLarge { .. }));
}

/// CRC-32 as PNG has it (RFC 2083, §15).
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |mut c, b| {
        c ^= u32::from(*b);
        (0..8).for_each(|_| c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 });
        c
    })
}

#[test]
fn no_bytes_make_a_reader_panic() {
    let f = Folder::new();
    let whole = [
        ("a.bmp", bitmap(&[[10, 20, 30], [40, 50, 60]])),
        ("a.png", grey_png(png::BitDepth::Sixteen, &[1; 12])),
        ("a.npy", array(&[2, 3], npyz::Order::C, &[1.0f32; 6])),
        ("a.tif", geotiff(&SIX, Some([1.0, 1.0, 0.0]), &metric(), Some("-9999"))),
    ];
    let mut rng = vb_math::rng::Stream::new(1, &["readers"]);
    for (name, bytes) in whole {
        for _ in 0..1500 {
            let mut b = bytes.clone();
            for _ in 0..1 + rng.below(3) {
                let at = rng.below(b.len() as u64) as usize;
                b[at] = [0, 1, 127, 255, b'(', b',', rng.next_u64() as u8][rng.below(7) as usize];
            }
            b.truncate(1 + rng.below(2 * b.len() as u64) as usize);
            let _ = read(&f.file(name, &b), Holes::Keep);
        }
    }
}
