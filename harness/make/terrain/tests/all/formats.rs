//! Elevation files of every format but GeoTIFF.

use std::io::Write as _;

use vb_terrain::crs::US_FOOT;
use vb_terrain::read::{Flaw, survey};

use crate::survey::{Folder, keep, near, read};

#[test]
fn ascii_grids_are_read_in_every_dialect() {
    let f = Folder::new();
    let rows = "1 2 3\n4 5 6\n";
    let cases = [
        format!("ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9999\n{rows}"),
        format!(
            "NCOLS 3\r\nNROWS 2\r\nXLLCENTER 11\r\nYLLCENTER 21\r\nCELLSIZE 2.0\r\nnodata_value -9999\r\n{}",
            rows.replace('\n', "\r\n")
        ),
        format!(
            "ncols 3\nnrows 2\nxllcorner 10,0\nyllcorner 20,0\ncellsize 2,0\n{}",
            rows.replace(" 2 ", " 2,0 ")
        ),
        format!("  ncols\t3\n nrows\t2\ndx 2\ndy 2\nyllcorner 20\nxllcorner 10\n{}", rows.replace(' ', "\t")),
    ];
    for text in cases {
        let found = read(&f.file("a.txt", &text));
        assert_eq!((found.format, found.heights.resolution()), ("ESRI ASCII grid", Some(2.0)), "{text}");
        near(found.heights.values(), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        near(&found.place.unwrap().middle, &[13.0, 22.0]);
    }
    let header = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
    // ESRI's default mark.
    near(
        read(&f.file("a.asc", format!("{header}1 2 -9999\n4 5 6\n"))).heights.values(),
        &[1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0],
    );
    near(
        read(&f.file("a.asc", format!("{header}NODATA_value 6\n{rows}"))).heights.values(),
        &[1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN],
    );
    for (text, word) in [("1 2 3 4 5", "5 numbers"), ("1 2 3 4 5 6 7", "\"7\""), ("1 2 3 4 5 x", "\"x\"")] {
        let e = survey(&f.file("a.asc", format!("{header}{text}\n")), &keep()).unwrap_err().to_string();
        assert!(e.contains(word), "{e}");
    }
    let huge = "ncols 99999999\nnrows 99999999\nxllcorner 0\nyllcorner 0\ncellsize 1\n1\n";
    assert!(matches!(survey(&f.file("a.asc", huge), &keep()).unwrap_err().flaw, Flaw::TooLarge { .. }));
    // Degrees without a word on it: pixels and places that nothing else has.
    let degrees = "ncols 30\nnrows 20\nxllcorner -105.5\nyllcorner 40.0\ncellsize 0.0008333333333333\n";
    let found = read(&f.file("a.asc", format!("{degrees}{}", "7 ".repeat(600))));
    assert!(found.notes.iter().any(|n| n.contains("UTM zone 13N")), "{:?}", found.notes);
    // The projection lies beside it.
    f.file(
        "b.prj",
        "PROJCS[\"x\",GEOGCS[\"y\",UNIT[\"Degree\",0.017]],UNIT[\"Foot_US\",0.3048006096012192]]",
    );
    let feet = read(&f.file("b.asc", format!("{header}{rows}")));
    assert!((feet.heights.resolution().unwrap() - US_FOOT).abs() < 1e-9);
    near(&feet.heights.values()[..1], &[0.304_800_609_601_219_2]);
}

#[test]
fn binary_grids_are_read_by_their_headers_and_tiles_of_srtm_by_size_and_name() {
    let f = Folder::new();
    let header =
        |more: &str| format!("NROWS 2\nNCOLS 3\nULXMAP 500000.5\nULYMAP 5700001.5\nXDIM 1\nYDIM 1\n{more}");
    let want = [1.0, 2.0, f64::NAN, 4.0, 5.0, -6.0];
    let raw = [1i16, 2, -9999, 4, 5, -6];
    f.file("a.hdr", header("BYTEORDER I\nLAYOUT BIL\nNBITS 16\nPIXELTYPE SIGNEDINT\nNODATA -9999\n"));
    let found = read(&f.file("a.bil", raw.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()));
    near(found.heights.values(), &want);
    near(&found.place.unwrap().middle, &[500_001.5, 5_700_001.0]);
    // Big-endian, with bytes before and behind each row.
    f.file("b.hdr", header("BYTEORDER M\nNBITS 16\nNODATA -9999\nSKIPBYTES 3\nTOTALROWBYTES 8\n"));
    let bytes: Vec<u8> = raw
        .chunks(3)
        .flat_map(|row| row.iter().flat_map(|v| v.to_be_bytes()).chain([7, 7]).collect::<Vec<_>>())
        .collect();
    near(read(&f.file("b.dem", [vec![9; 3], bytes].concat())).heights.values(), &want);
    f.file(
        "c.hdr",
        "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\nbyteorder LSBFIRST\n",
    );
    let floats: Vec<u8> = raw.iter().flat_map(|v| f32::from(*v).to_le_bytes()).collect();
    let found = read(&f.file("c.flt", &floats));
    near(found.heights.values(), &want);
    assert_eq!(found.heights.resolution(), Some(5.0));
    let cut = survey(&f.file("c.flt", &floats[..20]), &keep()).unwrap_err();
    assert!(matches!(cut.flaw, Flaw::Truncated(_)), "{cut}");
    // 1201 x 1201 samples of a plane, one of them void.
    let mut tile = vec![0u8; 1201 * 1201 * 2];
    for i in 0..1201 * 1201usize {
        tile[2 * i..2 * i + 2]
            .copy_from_slice(&(500 + (i % 1201) as i16 - (i / 1201) as i16 / 2).to_be_bytes());
    }
    tile[..2].copy_from_slice(&i16::MIN.to_be_bytes());
    let found = read(&f.file("N44W072.hgt", &tile));
    let r = &found.heights;
    assert!(found.notes.iter().any(|n| n.contains("UTM zone 19N (EPSG:32619)")), "{:?}", found.notes);
    // 3 seconds at 44.5 degrees: 66.2 m east, 92.6 m north.
    assert!((66.0..66.4).contains(&r.resolution().unwrap()), "{:?}", r.resolution());
    assert!((r.at(r.rows() / 2, r.cols() / 2) - 800.0).abs() < 0.5);
    let nameless = survey(&f.file("tile.hgt", &tile), &keep()).unwrap_err().to_string();
    assert!(nameless.contains("N44W072.hgt"), "{nameless}");
}

/// A NumPy array of version 1.
fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

#[test]
fn arrays_of_all_numbers_and_archives_of_one_are_read() {
    let f = Folder::new();
    let want = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let ints = |size: usize| (1..=6u64).flat_map(|v| v.to_le_bytes()[..size].to_vec()).collect::<Vec<u8>>();
    for (kind, size) in [("<i4", 4), ("<i8", 8), ("<u4", 4), ("<u8", 8), ("|i1", 1), ("<i2", 2)] {
        near(read(&f.file("a.npy", npy(kind, "(2, 3)", &ints(size)))).heights.values(), &want);
    }
    let halves: Vec<u8> =
        [0x3c00u16, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600].iter().flat_map(|v| v.to_le_bytes()).collect();
    near(read(&f.file("a.npy", npy("<f2", "(2, 3)", &halves))).heights.values(), &want);
    for shape in ["(1, 2, 3)", "(2, 3, 1)"] {
        near(read(&f.file("a.dat", npy("<i4", shape, &ints(4)))).heights.values(), &want);
    }
    let archive = |arrays: &[(&str, Vec<u8>)], method| {
        let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, bytes) in arrays {
            zip.start_file(*name, zip::write::SimpleFileOptions::default().compression_method(method))
                .unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    };
    let dem = npy("<i4", "(2, 3)", &ints(4));
    let line = npy("<i4", "(6,)", &ints(4));
    for method in [zip::CompressionMethod::Stored, zip::CompressionMethod::Deflated] {
        near(read(&f.file("a.npz", archive(&[("dem.npy", dem.clone())], method))).heights.values(), &want);
        let two = archive(&[("x.npy", line.clone()), ("dem.npy", dem.clone())], method);
        near(read(&f.file("a.npz", two)).heights.values(), &want);
        let both = archive(&[("a.npy", dem.clone()), ("b.npy", dem.clone())], method);
        let e = survey(&f.file("a.npz", both), &keep()).unwrap_err().to_string();
        assert!(e.contains("2 arrays (a, b)"), "{e}");
    }
    let other = archive(&[("readme.txt", b"no heights".to_vec())], zip::CompressionMethod::Stored);
    assert!(matches!(survey(&f.file("a.npz", other), &keep()).unwrap_err().flaw, Flaw::Format(_)));
}

#[test]
fn greys_in_colours_are_read_and_invisible_pixels_are_holes() {
    let f = Folder::new();
    let png = |colour: png::ColorType, depth: png::BitDepth, data: &[u8]| {
        let mut out = Vec::new();
        let mut e = png::Encoder::new(&mut out, 2, 2);
        e.set_color(colour);
        e.set_depth(depth);
        e.write_header().unwrap().write_image_data(data).unwrap();
        out
    };
    let grey = |channels: usize, alpha: bool, wide: bool| -> Vec<u8> {
        let level = |v: u16| if wide { v.to_be_bytes().to_vec() } else { vec![v as u8] };
        let pixel = |v: u16| {
            [vec![level(v); channels].concat(), if alpha { level(255) } else { Vec::new() }].concat()
        };
        [10, 20, 30, 40].into_iter().flat_map(pixel).collect()
    };
    for (colour, channels, alpha) in [
        (png::ColorType::Rgb, 3, false),
        (png::ColorType::Rgba, 3, true),
        (png::ColorType::GrayscaleAlpha, 1, true),
        (png::ColorType::Grayscale, 1, false),
    ] {
        for (depth, wide) in [(png::BitDepth::Eight, false), (png::BitDepth::Sixteen, true)] {
            let file = f.file("a.tif", png(colour, depth, &grey(channels, alpha, wide)));
            near(read(&file).heights.values(), &[10.0, 20.0, 30.0, 40.0]);
        }
    }
    let hidden = png(png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, &[10, 255, 20, 0, 30, 255, 40, 1]);
    near(read(&f.file("a.png", hidden)).heights.values(), &[10.0, f64::NAN, 30.0, 40.0]);
}

#[test]
fn other_files_are_called_by_their_names() {
    let f = Folder::new();
    for (bytes, word) in [
        (&b"\xff\xd8\xff\xe0\0\x10JFIF"[..], "JPEG"),
        (b"RIFF\0\0\0\0WEBPVP8 ", "WebP"),
        (b"\x1f\x8b\x08\0", "gunzip"),
        (b"{\"Terrain\": 1}", "JSON"),
        (b"solid mesh", "mesh"),
        (b"elevation of a mountain", "gdal_translate"),
    ] {
        let e = survey(&f.file("a.tif", bytes), &keep()).unwrap_err().to_string();
        assert!(e.contains(word), "{e}");
    }
}
