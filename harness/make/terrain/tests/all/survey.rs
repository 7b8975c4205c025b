//! What GeoTIFFs say of units, places, masks and marks, and how their samples are packed; expected values follow from what the files say.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use vb_terrain::crs::{Crs, FOOT, US_FOOT};
use vb_terrain::read::{Flaw, Holes, Options, Said, Survey, survey};

use crate::tif::{Page, Tif};

const SIX: [f32; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

pub(crate) fn keep() -> Options {
    Options { holes: Holes::Keep, ..Options::default() }
}

pub(crate) fn read(path: &Path) -> Survey {
    survey(path, &keep()).unwrap()
}

fn made(page: Page) -> Survey {
    read(&Folder::new().file("a.tif", page.file()))
}

fn flaw(bytes: Vec<u8>) -> Flaw {
    let e = survey(&Folder::new().file("a.tif", bytes), &keep()).unwrap_err();
    assert!(!e.to_string().contains('\n'), "{e}");
    e.flaw
}

pub(crate) fn near(got: &[f64], want: &[f64]) {
    let close = |(a, b): (&f64, &f64)| (a.is_nan() && b.is_nan()) || (a - b).abs() < 1e-9;
    assert!(got.len() == want.len() && got.iter().zip(want).all(close), "{got:?} is not {want:?}");
}

fn six() -> Page {
    Page::floats(3, &SIX).at([500_000.0, 5_700_000.0], [1.0, 1.0])
}

fn metric() -> Page {
    six().keys(&[[1024, 1], [3072, 32632], [3076, 9001]])
}

fn metadata(items: &[(&str, &str)]) -> String {
    let items: String = items
        .iter()
        .map(|(role, v)| format!("<Item name=\"X\" sample=\"0\" role=\"{role}\">{v}</Item>"))
        .collect();
    format!("<GDALMetadata>{items}</GDALMetadata>")
}

#[test]
fn scale_and_offset_make_heights_of_values() {
    let raw: Vec<u8> = [-4i16, 0, 100, 2451].iter().flat_map(|v| v.to_le_bytes()).collect();
    let page = Page::new(2, 2, 16, 2, raw)
        .at([0.0, 2.0], [1.0; 2])
        .text(42112, &metadata(&[("scale", "0.01"), ("offset", "100")]));
    near(made(page.clone()).heights.values(), &[99.96, 100.0, 101.0, 124.51]);
    // The mark is one of values, not of heights.
    near(made(page.text(42113, "100")).heights.values(), &[99.96, 100.0, f64::NAN, 124.51]);
}

#[test]
fn units_of_heights_and_places_come_from_wherever_the_file_says_them() {
    // Keys, GDAL's unit, metres of a height, metres of a pixel.
    let cases: [(&[[u16; 2]], &str, f64, f64); 15] = [
        (&[[1024, 1], [3072, 32632]], "", 1.0, 1.0),
        (&[[1024, 1], [3072, 32632], [3076, 9001], [4099, 9001]], "", 1.0, 1.0),
        (&[[1024, 1], [3072, 32632], [4099, 9003]], "", US_FOOT, 1.0),
        (&[[1024, 1], [3072, 32632], [4099, 9002]], "", FOOT, 1.0),
        (&[[1024, 1], [3072, 32632], [4096, 6360]], "", US_FOOT, 1.0),
        (&[[1024, 1], [3072, 32632], [4096, 8228]], "", FOOT, 1.0),
        (&[[1024, 1], [3072, 32632], [4096, 5702]], "", US_FOOT, 1.0),
        (&[[1024, 1], [3072, 2225], [4096, 5703]], "", 1.0, US_FOOT),
        (&[[1024, 1], [3072, 2225]], "", US_FOOT, US_FOOT),
        (&[[1024, 1], [3072, 2225], [3076, 9003]], "", US_FOOT, US_FOOT),
        (&[[1024, 1], [3072, 2992]], "", FOOT, FOOT),
        (&[[1024, 1], [3072, 2225]], "m", 1.0, US_FOOT),
        (&[[1024, 1], [3072, 32632]], "ft", FOOT, 1.0),
        (&[[1024, 1], [3072, 32632]], "US survey foot", US_FOOT, 1.0),
        (&[[1024, 1], [3076, 9097]], "cm", 0.01, 20.1168),
    ];
    for (keys, unit, height, pixel) in cases {
        let mut page = six().keys(keys);
        if !unit.is_empty() {
            page = page.text(42112, &metadata(&[("unittype", unit)]));
        }
        let found = made(page);
        let want: Vec<f64> = SIX.iter().map(|v| f64::from(*v) * height).collect();
        near(found.heights.values(), &want);
        // Surveys are taken at their word, even where the place is none of their system.
        let resolution = found.heights.resolution().unwrap();
        assert!((resolution / pixel - 1.0).abs() < 1e-6, "{keys:?} {unit}: {resolution} {pixel}");
    }
    // A unit of one's own: key 3077 in the table of doubles.
    let own = six()
        .short(34735, &[1, 1, 0, 3, 1024, 0, 1, 1, 3076, 0, 1, 32767, 3077, 34736, 1, 0])
        .double(34736, &[0.5]);
    assert_eq!(made(own).heights.resolution(), Some(0.5));
    assert!(matches!(
        flaw(six().keys(&[[1024, 1], [3072, 32632], [4099, 9999]]).file()),
        Flaw::HeightUnit(_)
    ));
    assert!(matches!(
        flaw(metric().text(42112, &metadata(&[("unittype", "dB")])).file()),
        Flaw::HeightUnit(_)
    ));
    // Depths grow downwards.
    assert!(
        flaw(six().keys(&[[1024, 1], [3072, 32632], [4096, 5715]]).file()).to_string().contains("depths")
    );
    // What the caller says counts instead, not in addition.
    let f = Folder::new();
    let feet = f.file("feet.tif", six().keys(&[[1024, 1], [3072, 32632], [4099, 9002]]).file());
    let given = survey(&feet, &Options { unit: Some(FOOT), ..keep() }).unwrap();
    near(&given.heights.values()[..1], &[FOOT]);
    assert_eq!(given.unit_said, Said::Caller);
}

#[test]
fn rows_and_columns_are_turned_to_north_up_and_rotations_refused() {
    let matrix = |m: [f64; 6]| {
        Page::floats(3, &SIX).double(
            34264,
            &[m[0], m[1], 0.0, m[2], m[3], m[4], 0.0, m[5], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        )
    };
    let north_up = made(matrix([2.0, 0.0, 100.0, 0.0, -2.0, 50.0]));
    near(north_up.heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!((north_up.heights.resolution(), north_up.orientation), (Some(2.0), "north-up"));
    let south_up = made(matrix([2.0, 0.0, 100.0, 0.0, 2.0, 46.0]));
    near(south_up.heights.values(), &[4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    assert!(south_up.summary().contains("south-up"), "{}", south_up.summary());
    let mirrored = made(matrix([-2.0, 0.0, 106.0, 0.0, -2.0, 50.0]));
    near(mirrored.heights.values(), &[3.0, 2.0, 1.0, 6.0, 5.0, 4.0]);
    // All three cover the same rectangle.
    for found in [north_up, south_up, mirrored] {
        near(&found.place.unwrap().middle, &[103.0, 48.0]);
    }
    let (cos, sin) = (vb_math::cos(0.5), vb_math::sin(0.5));
    for turned in [[cos, sin, 0.0, sin, -cos, 0.0], [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]] {
        let text = flaw(matrix(turned).file()).to_string();
        assert!(text.contains("rotated") && text.contains("gdalwarp"), "{text}");
    }
}

#[test]
fn a_tie_point_is_that_of_a_corner_or_of_the_middle_of_a_pixel() {
    // Three columns and two rows of 1 m from (500000, 5700000).
    near(&made(metric()).place.unwrap().middle, &[500_001.5, 5_699_999.0]);
    let point = six().keys(&[[1024, 1], [1025, 2], [3072, 32632]]);
    near(&made(point).place.unwrap().middle, &[500_001.0, 5_699_999.5]);
    // Tied at another pixel.
    let tied = metric().double(33922, &[3.0, 2.0, 0.0, 500_000.0, 5_700_000.0, 0.0]);
    near(&made(tied).place.unwrap().middle, &[499_998.5, 5_700_001.0]);
    // Places in a world, m east and north of the middle; here a unit is a US survey foot.
    let feet = made(six().keys(&[[1024, 1], [3072, 2225]])).place.unwrap();
    let [x, y] = feet.at([1200.0, -120.0]);
    near(&[x, y], &[500_001.5 + 3937.0, 5_699_999.0 - 393.7]);
    // A tie point without a size says no distance.
    let loose = Page::floats(3, &SIX).double(33922, &[0.0, 0.0, 0.0, 5.0, 5.0, 0.0]);
    assert_eq!(made(loose).heights.resolution(), None);
}

#[test]
fn white_zeros_are_values_as_others() {
    let page = Page::new(2, 2, 8, 1, vec![100, 101, 255, 125]).short(262, &[0]).text(42113, "255");
    near(made(page).heights.values(), &[100.0, 101.0, f64::NAN, 125.0]);
    let floats = Page::floats(3, &SIX).short(262, &[0]);
    near(made(floats).heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
}

#[test]
fn masks_and_invisible_places_are_holes() {
    // Rows of bits begin with a byte: 101, 011.
    let mask = |bits: u16, bytes: Vec<u8>| Page::new(3, 2, bits, 1, bytes).short(262, &[4]).long(254, 4);
    for mask in [mask(1, vec![0b1010_0000, 0b0110_0000]), mask(8, vec![255, 0, 255, 0, 255, 255])] {
        let tif = Tif { pages: vec![metric(), mask], ..Tif::default() };
        near(
            read(&Folder::new().file("a.tif", tif.bytes())).heights.values(),
            &[1.0, f64::NAN, 3.0, f64::NAN, 5.0, 6.0],
        );
    }
    // Height and opacity, woven and in planes.
    let woven: Vec<u8> = [10u8, 255, 20, 0, 30, 1, 40, 255].to_vec();
    let two =
        |strip: Vec<u8>| Page::new(2, 2, 8, 1, strip).short(277, &[2]).short(258, &[8, 8]).short(338, &[2]);
    near(made(two(woven)).heights.values(), &[10.0, f64::NAN, 30.0, 40.0]);
    let planes =
        two(Vec::new()).short(284, &[2]).chunks(vec![vec![10, 20, 30, 40], vec![255, 0, 1, 255]], None, 2);
    near(made(planes).heights.values(), &[10.0, f64::NAN, 30.0, 40.0]);
    let bands = two(vec![0; 8]).short(338, &[0]);
    assert!(flaw(bands.file()).to_string().contains("gdal_translate -b 1"));
}

#[test]
fn every_spelling_of_the_mark_of_no_data_is_understood() {
    let lowest = f32::MIN;
    let f64_lowest = f64::from(lowest);
    let cases: [(&str, f32); 14] = [
        ("-9999", -9999.0),
        ("-9999.0", -9999.0),
        ("-9999,0", -9999.0),
        (" -9999 ", -9999.0),
        ("-9.999e+03", -9999.0),
        ("-3.40282e+38", lowest),
        ("-3.40282e+38", -3.402_823e38),
        ("-3.4028234663852886e+38", lowest),
        ("-3.4e+38", lowest),
        ("-1.79769e+308", lowest),
        ("nan", f32::NAN),
        ("NaN", f32::NAN),
        ("-1.#IND", f32::NAN),
        ("0.1", 0.1),
    ];
    assert!(f64_lowest < -1e38);
    for (text, value) in cases {
        let mut values = SIX;
        values[4] = value;
        let page = Page::floats(3, &values).text(42113, text);
        near(made(page).heights.values(), &[1.0, 2.0, 3.0, 4.0, f64::NAN, 6.0]);
    }
    for text in ["", " ", "none", "NULL"] {
        near(made(Page::floats(3, &SIX).text(42113, text)).heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }
    assert!(matches!(flaw(Page::floats(3, &SIX).text(42113, "sea").file()), Flaw::Mark(_)));
    // What the caller says counts.
    let f = Folder::new();
    let file = f.file("a.tif", Page::floats(3, &SIX).text(42113, "sea").file());
    let given = survey(&file, &Options { no_data: Some(6.0), ..keep() }).unwrap();
    near(given.heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN]);
    assert!(matches!(flaw(Page::floats(3, &[-9999.0; 6]).text(42113, "-9999").file()), Flaw::NoHeights));
}

#[test]
fn values_that_can_only_be_marks_are_holes_unless_they_are_to_be_kept() {
    for mark in [-9999.0, -32768.0, f32::MIN, 1e20, -99999.0] {
        let mut values = SIX;
        values[4] = mark;
        let f = Folder::new();
        let file = f.file("a.tif", Page::floats(3, &values).at([0.0; 2], [1.0; 2]).file());
        let found = read(&file);
        near(found.heights.values(), &[1.0, 2.0, 3.0, 4.0, f64::NAN, 6.0]);
        assert!(
            found.notes.iter().any(|n| n.contains("--no-data") && n.contains("--keep-values")),
            "{:?}",
            found.notes
        );
        let kept = survey(&file, &Options { keep: true, ..keep() }).unwrap();
        assert_eq!(kept.heights.values()[4], f64::from(mark));
        let refused = survey(&file, &Options::default()).unwrap_err();
        assert!(matches!(refused.flaw, Flaw::Unmarked { count: 1, .. }), "{refused}");
    }
}

#[test]
fn the_page_at_full_resolution_is_read_and_others_are_told() {
    let full = metric();
    let overview =
        Page::new(2, 2, 32, 3, [9f32; 4].iter().flat_map(|v| v.to_le_bytes()).collect()).long(254, 1);
    let f = Folder::new();
    for pages in [vec![full.clone(), overview.clone()], vec![overview.clone(), full.clone()]] {
        let found = read(&f.file("a.tif", Tif { pages, ..Tif::default() }.bytes()));
        near(found.heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }
    let second = Page::floats(3, &SIX.map(|v| v + 50.0)).at([0.0; 2], [1.0; 2]);
    let found = read(&f.file("b.tif", Tif { pages: vec![full, second], ..Tif::default() }.bytes()));
    near(&found.heights.values()[..1], &[1.0]);
    assert!(found.notes.iter().any(|n| n.contains("page 1 of 2")), "{:?}", found.notes);
}

#[test]
fn samples_of_every_type_and_order_are_read() {
    let bytes = |size: usize, big: bool, bits: [u64; 4]| -> Vec<u8> {
        bits.iter()
            .flat_map(|v| {
                if big { v.to_be_bytes()[8 - size..].to_vec() } else { v.to_le_bytes()[..size].to_vec() }
            })
            .collect()
    };
    let cases: [(u16, u16, [u64; 4], [f64; 4]); 10] = [
        (8, 1, [1, 2, 3, 255], [1.0, 2.0, 3.0, 255.0]),
        (8, 2, [1, 2, 3, 255], [1.0, 2.0, 3.0, -1.0]),
        (16, 1, [1, 2, 3, 65_000], [1.0, 2.0, 3.0, 65_000.0]),
        (16, 2, [1, 2, 3, 65_535], [1.0, 2.0, 3.0, -1.0]),
        (32, 1, [1, 2, 3, 124_510], [1.0, 2.0, 3.0, 124_510.0]),
        (32, 2, [1, 2, 3, 0xffff_ffff], [1.0, 2.0, 3.0, -1.0]),
        (64, 1, [1, 2, 3, 4], [1.0, 2.0, 3.0, 4.0]),
        (64, 2, [1, 2, 3, u64::MAX], [1.0, 2.0, 3.0, -1.0]),
        // Half: 1, 2, 100.5, -0.25.
        (16, 3, [0x3c00, 0x4000, 0x5648, 0xb400], [1.0, 2.0, 100.5, -0.25]),
        (64, 3, [1f64.to_bits(), 2f64.to_bits(), 0.1f64.to_bits(), (-4f64).to_bits()], [1.0, 2.0, 0.1, -4.0]),
    ];
    let f = Folder::new();
    for (bits, format, raw, want) in cases {
        for (big_endian, long) in [(false, false), (true, false), (false, true), (true, true)] {
            let page = Page::new(2, 2, bits, format, bytes(usize::from(bits) / 8, big_endian, raw));
            let file = f.file("a.tif", Tif { pages: vec![page], big_endian, long }.bytes());
            near(read(&file).heights.values(), &want);
        }
    }
}

#[test]
fn strips_and_tiles_are_put_together_and_unpacked() {
    let f = Folder::new();
    // 3 x 3 samples in tiles of 2 x 2, which reach over the edges.
    let tile = |v: [u8; 4]| v.to_vec();
    let tiles = vec![tile([1, 2, 4, 5]), tile([3, 99, 6, 99]), tile([7, 8, 99, 99]), tile([9, 99, 99, 99])];
    let nine: Vec<f64> = (1..=9).map(f64::from).collect();
    let page = Page::new(3, 3, 8, 1, Vec::new()).chunks(tiles, Some([2, 2]), 0);
    near(made(page).heights.values(), &nine);
    let plain = Page::new(3, 3, 8, 1, Vec::new());
    let strips = plain.clone().chunks(vec![vec![1, 2, 3, 4, 5, 6], vec![7, 8, 9]], None, 2);
    near(made(strips.clone()).heights.values(), &nine);
    // A strip that isn't there has no heights.
    let sparse = plain.clone().chunks(vec![vec![1, 2, 3, 4, 5, 6], vec![]], None, 2);
    near(&made(sparse).heights.values()[5..], &[6.0, f64::NAN, f64::NAN, f64::NAN]);
    let raw: Vec<u8> = (1..=9).collect();
    let packed = |compression: u16, bytes: Vec<u8>| {
        plain.clone().short(259, &[compression]).chunks(vec![bytes], None, 3)
    };
    let zlib = || {
        let mut e = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        e.write_all(&raw).unwrap();
        e.finish().unwrap()
    };
    let lzw = weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8).encode(&raw).unwrap();
    // A Zstandard frame (RFC 8878): magic, descriptor for a single segment, content size, a last raw block.
    let zstd = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 9, 9 << 3 | 1, 0, 0][..], &raw].concat();
    let packings =
        [(8, zlib()), (32946, zlib()), (5, lzw), (32773, [&[8][..], &raw].concat()), (50000, zstd)];
    for (compression, bytes) in packings {
        near(made(packed(compression, bytes.clone())).heights.values(), &nine);
        // Bits from the right.
        let turned = bytes.iter().map(|b| b.reverse_bits()).collect();
        near(made(packed(compression, turned).short(266, &[2])).heights.values(), &nine);
        // Cut short.
        let file = f.file("cut.tif", packed(compression, bytes[..bytes.len() / 2].to_vec()).file());
        let flaw = survey(&file, &keep()).unwrap_err().flaw;
        assert!(matches!(flaw, Flaw::Truncated(_) | Flaw::Damaged(_)), "{compression}: {flaw}");
    }
}

#[test]
fn differences_are_added_up() {
    let rows = [[100i16, 103, 101], [-5, 300, 299]];
    for big_endian in [false, true] {
        let mut strip = Vec::new();
        for row in rows {
            let steps = [row[0], row[1] - row[0], row[2] - row[1]];
            strip.extend(
                steps.iter().flat_map(|v| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() }),
            );
        }
        let page = Page::new(3, 2, 16, 2, strip).short(317, &[2]);
        let file = Folder::new();
        let file = file.file("a.tif", Tif { pages: vec![page], big_endian, long: false }.bytes());
        near(read(&file).heights.values(), &[100.0, 103.0, 101.0, -5.0, 300.0, 299.0]);
    }
    // Floats: planes of bytes, the first bytes of all numbers first, then differences (Adobe, TIFF technical note 3).
    let mut strip = Vec::new();
    for row in [[1.5f32, -2.25, 1000.0], [0.1, 0.2, 0.3]] {
        let planes: Vec<u8> = (0..4).flat_map(|b| row.map(|v| v.to_be_bytes()[b])).collect();
        strip.push(planes[0]);
        strip.extend(planes.windows(2).map(|w| w[1].wrapping_sub(w[0])));
    }
    let want = [1.5f32, -2.25, 1000.0, 0.1, 0.2, 0.3].map(f64::from);
    for big_endian in [false, true] {
        let page = Page::new(3, 2, 32, 3, strip.clone()).short(317, &[3]);
        let folder = Folder::new();
        let file = folder.file("a.tif", Tif { pages: vec![page], big_endian, long: false }.bytes());
        near(read(&file).heights.values(), &want);
    }
}

#[test]
fn what_is_stored_in_other_ways_is_refused_with_its_conversion() {
    let plain = Page::floats(3, &SIX);
    let cases = [
        (plain.clone().short(259, &[7]), "JPEG"),
        (plain.clone().short(259, &[34887]), "LERC"),
        (plain.clone().short(259, &[34925]), "LZMA"),
        (plain.clone().short(259, &[50001]), "WebP"),
        (plain.clone().short(339, &[6]), "complex"),
        (plain.clone().short(258, &[12]).short(339, &[1]), "12 bits"),
        (Page::new(2, 2, 8, 1, vec![0; 4]).short(262, &[3]).short(320, &[0; 768]), "palette"),
    ];
    for (page, word) in cases {
        let text = flaw(page.file()).to_string();
        assert!(
            text.contains(word) && text.contains("gdal_translate") && !text.contains("damaged"),
            "{text}"
        );
    }
}

#[test]
fn degrees_are_projected_to_the_zone_of_utm() {
    // 0.0002 degrees about (9, 0), where the central meridian of zone 32 meets the equator: 22.264 m and 22.115 m, times 0.9996.
    let (n, step) = (101u32, 0.0002);
    let low = [9.0 - 0.5 * f64::from(n) * step, 0.5 * f64::from(n) * step];
    let height = |r: u32, c: u32| 100.0 + 2.0 * c as f32 - r as f32;
    let values: Vec<f32> = (0..n * n).map(|i| height(i / n, i % n)).collect();
    for keys in [&[[1024, 2], [2048, 4326]][..], &[]] {
        let page = Page::floats(n, &values).at(low, [step; 2]);
        let page = if keys.is_empty() { page } else { page.keys(keys) };
        let found = made(page);
        assert!(found.notes.iter().any(|n| n.contains("UTM zone 32")), "{:?}", found.notes);
        let place = found.place.as_ref().unwrap();
        assert_eq!(
            place.crs.as_ref().unwrap().name,
            if place.middle[1] < 0.0 { "EPSG:32732" } else { "EPSG:32632" }
        );
        near(&[place.middle[0]], &[500_000.0]);
        let r = &found.heights;
        let side = r.resolution().unwrap();
        assert!((22.0..22.2).contains(&side), "{side}");
        // A plane stays a plane: slopes are those of the pixel's sides.
        let (row, col) = (r.rows() / 2, r.cols() / 2);
        assert!((r.at(row, col) - 150.0).abs() < 0.01, "{}", r.at(row, col));
        let east = (r.at(row, col + 20) - r.at(row, col)) / (20.0 * side);
        let south = (r.at(row + 20, col) - r.at(row, col)) / (20.0 * side);
        let radius = 6_378_137.0;
        let e2 = 0.006_694_379_990_14;
        let sides = [radius * step.to_radians() * 0.9996, radius * (1.0 - e2) * step.to_radians() * 0.9996];
        assert!(
            (east * sides[0] - 2.0).abs() < 1e-3 && (south * sides[1] + 1.0).abs() < 1e-3,
            "{east} {south}"
        );
    }
    let polar = Page::floats(3, &SIX).at([9.0, 89.0], [step; 2]).keys(&[[1024, 2], [2048, 4326]]);
    assert!(flaw(polar.file()).to_string().contains("gdalwarp"));
    let wide = Page::floats(3, &SIX).at([0.0, 40.0], [20.0, 1.0]).keys(&[[1024, 2], [2048, 4326]]);
    assert!(flaw(wide.file()).to_string().contains("gdal_translate -projwin"));
}

#[test]
fn metres_that_are_none_on_the_ground_are_corrected_and_oblong_pixels_made_square() {
    // Web Mercator at 60 degrees: a unit is half a metre.
    let page =
        Page::floats(3, &SIX).at([1_000_000.0, 8_399_737.89], [2.0; 2]).keys(&[[1024, 1], [3072, 3857]]);
    let found = made(page);
    assert!((found.heights.resolution().unwrap() - 1.0).abs() < 0.005, "{:?}", found.heights.resolution());
    assert!(found.notes.iter().any(|n| n.contains("on the ground")), "{:?}", found.notes);
    // 3 columns of 1 m, 2 rows of 2 m: 3 x 3 squares, the middle row half way.
    let oblong = made(Page::floats(3, &SIX).at([0.0, 4.0], [1.0, 2.0]).keys(&[[1024, 1], [3072, 32632]]));
    assert_eq!(
        (oblong.heights.rows(), oblong.heights.cols(), oblong.heights.resolution()),
        (3, 3, Some(1.0))
    );
    near(oblong.heights.values(), &[1.0, 2.0, 3.0, 2.5, 3.5, 4.5, 4.0, 5.0, 6.0]);
}

#[test]
fn a_survey_is_told_in_a_line() {
    let found = made(metric());
    let line = "heights 1.0 to 6.0 m, 3 x 2 samples at 1 m, north-up, unit m (assumed), EPSG:32632";
    assert_eq!(found.summary(), line);
    let feet = made(six().keys(&[[1024, 1], [3072, 2225], [4096, 6360]]));
    assert!(feet.summary().ends_with("north-up, unit US survey ft, EPSG:2225"), "{}", feet.summary());
    let given = Crs::parse("EPSG:25832").unwrap();
    let f = Folder::new();
    let file = f.file("a.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4\n");
    let found = survey(&file, &Options { crs: Some(given), ..keep() }).unwrap();
    assert!(found.summary().ends_with("EPSG:25832"), "{}", found.summary());
}

/// The files of the reference data that were written with one known surface: 300 x 300 at 1 m,
/// z = 100 + 2 sin(x/17) + 3 cos(y/23) + 0.02 x + 0.05 y.
#[test]
fn reference_surveys_have_the_heights_that_were_written() {
    let Some(folder) = vb_testing::shared("cases/geotiff/made-by-us") else { return };
    let z = |r: usize, c: usize| {
        let (x, y) = (c as f64, r as f64);
        100.0 + 2.0 * vb_math::sin(x / 17.0) + 3.0 * vb_math::cos(y / 23.0) + 0.02 * x + 0.05 * y
    };
    // Name, tolerance, holes.
    let cases = [
        ("scale_offset_int16_cm", 0.0051, 0),
        ("us_feet_projected_no_vertical_unit", 1e-3, 0),
        ("us_feet_by_epsg_code_only", 1e-3, 0),
        ("vertical_cs_6360_us_feet_no_units_key", 1e-3, 0),
        ("vertical_unit_9001_compound_7837", 1e-4, 0),
        ("nodata_text_of_6_digits", 1e-4, 2000),
        ("nodata_-9999_unmarked", 1e-4, 2000),
        ("nodata_nan_hole_in_middle", 1e-4, 2000),
        ("nodata_empty_text", 1e-4, 0),
        ("nodata_comma_decimal", 1e-4, 0),
        ("internal_mask_ifd", 1e-4, 900),
        ("miniswhite_u8", 0.51, 0),
        ("float16", 0.04, 0),
        ("uint32", 0.51, 0),
        ("packbits_int16", 0.51, 0),
        ("zstd_predictor3_tiled", 1e-4, 0),
        ("bigtiff_tiled_deflate_pred3_f64", 1e-4, 0),
        ("bigendian_f32_strips7", 1e-4, 0),
        ("overviews_full_first", 1e-4, 0),
        ("overview_first_then_full", 1e-4, 0),
        ("multipage_two_dems", 1e-4, 0),
    ];
    for (name, tolerance, holes) in cases {
        let found = read(&folder.join(format!("{name}.tif")));
        let r = &found.heights;
        assert_eq!((r.rows(), r.cols(), r.holes()), (300, 300, holes), "{name}");
        assert!((r.resolution().unwrap() - 1.0).abs() < 1e-6, "{name}: {:?}", r.resolution());
        let off = (0..90_000).map(|i| (r.values()[i] - z(i / 300, i % 300)).abs()).fold(0.0, f64::max);
        assert!(off < tolerance, "{name}: {off}");
    }
    let mm = survey(&folder.join("int32_mm.tif"), &Options { unit: Some(1e-3), ..keep() }).unwrap();
    assert!((mm.heights.at(40, 70) - z(40, 70)).abs() < 6e-4);
    let turned = read(&folder.join("south_up_matrix.tif"));
    assert!(
        (turned.heights.at(299, 7) - z(0, 7)).abs() < 1e-4
            && (turned.heights.at(0, 7) - z(299, 7)).abs() < 1e-4
    );
    let feet = read(&folder.join("unittype_ft_in_gdal_metadata.tif"));
    assert!((feet.heights.at(9, 11) - FOOT * z(9, 11)).abs() < 1e-4);
    for (name, word) in [
        ("rotated_30deg_matrix", "rotated"),
        ("lerc", "LERC"),
        ("lzma", "LZMA"),
        ("two_bands_height_and_mask", "2 bands"),
    ] {
        let e = survey(&folder.join(format!("{name}.tif")), &keep()).unwrap_err().to_string();
        assert!(e.contains(word), "{e}");
    }
}
