//! OpenCRG files, written here number by number, and those of Project Chrono against an independent reading.

use vb_terrain::Course;
use vb_terrain::read::{Holes, course, is_course, read, survey};

use crate::survey::{Folder, keep};

/// A road of three cuts and three sections whose heights are 1 to 9 mm, with these parameters, channels and data behind them.
fn file(parameters: &str, channels: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = format!("* a comment\n$CT  ! text\na road = of 3 cuts\n$ROAD_CRG ! parameters\n{parameters}$\n$KD_Definition\n{channels}$$$$\n")
        .into_bytes();
    bytes.extend_from_slice(data);
    bytes
}

const PARAMETERS: &str = "REFERENCE_LINE_INCREMENT = 0.5 ! m\nlong_section_v_increment = 2.0\n";
const SECTIONS: &str =
    "#:LRFI\nU:reference line u,m,0,0.5\nD:long section 1,m\nD:long section 2,m\nD:long section 3,m\n";
const TEXT: &str =
    " 0.0010000 0.0020000 0.0030000\r\n 0.0040000 5.0000E-3 0.0060000\r\n 0.0070000 8.0000D-3 0.0090000\r\n";

/// The heights of a road's grid, cut by cut from right to left.
fn grid(road: &Course) -> Vec<f64> {
    let [from, _] = road.span();
    let at = |cut: usize| from + cut as f64 * road.increment();
    (0..road.cuts()).flat_map(|cut| road.sections().iter().map(move |v| road.height(at(cut), *v))).collect()
}

fn millimetres(road: &Course) -> Vec<i64> {
    grid(road).iter().map(|z| (z * 1e3).round() as i64).collect()
}

fn binary(values: impl Iterator<Item = f64>, double: bool) -> Vec<u8> {
    let size = if double { 8 } else { 4 };
    let mut bytes: Vec<u8> = values
        .flat_map(|v| if double { v.to_be_bytes().to_vec() } else { (v as f32).to_be_bytes().to_vec() })
        .collect();
    // Records of 80 bytes are filled with NaN.
    while !bytes.len().is_multiple_of(80) {
        bytes.extend_from_slice(if size == 8 {
            &[0x7f, 0xf8, 0, 0, 0, 0, 0, 0]
        } else {
            &[0x7f, 0xc0, 0, 0]
        });
    }
    bytes
}

#[test]
fn heights_are_read_in_all_four_data_formats() {
    let f = Folder::new();
    // One row a line, in numbers of twenty characters.
    let row = |k: u32| {
        (3 * k + 1..=3 * k + 3).map(|n| format!("{:>20}", format!("{n}.0E-03"))).collect::<String>() + "\n"
    };
    let wide: String = (0..3).map(row).collect();
    let values = || (1..=9).map(|k| 1e-3 * f64::from(k));
    for (format, data) in [
        ("LRFI", TEXT.as_bytes().to_vec()),
        ("LDFI", wide.into_bytes()),
        ("KRBI", binary(values(), false)),
        ("KDBI", binary(values(), true)),
    ] {
        let path = f.file("a.crg", file(PARAMETERS, &SECTIONS.replace("LRFI", format), &data));
        assert!(is_course(&path));
        let road = course(&path).unwrap().course;
        assert_eq!(millimetres(&road), (1..=9).collect::<Vec<i64>>(), "{format}");
        assert_eq!((road.length(), road.borders()), (1.0, [-2.0, 2.0]), "{format}");
    }
}

#[test]
fn sections_lie_where_the_parameters_or_their_own_names_say() {
    let f = Folder::new();
    let sections = |parameters: &str, channels: &str| {
        course(&f.file("a.crg", file(parameters, channels, TEXT.as_bytes())))
            .unwrap()
            .course
            .sections()
            .to_vec()
    };
    let own =
        "#:LRFI\nD:long section at v = -1.5,m\nD:long section at v = 0.25,m\nD:Long Section at v =  3.,m\n";
    let increment = "reference_line_increment = 0.5\n";
    assert_eq!(sections(increment, own), [-1.5, 0.25, 3.0]);
    assert_eq!(
        sections(&format!("{increment}LONG_SECTION_V_RIGHT=-1\nLONG_SECTION_V_LEFT=2\n"), SECTIONS),
        [-1.0, 0.5, 2.0]
    );
    assert_eq!(sections(&format!("{PARAMETERS}LONG_SECTION_V_RIGHT=-1\n"), SECTIONS), [-1.0, 1.0, 3.0]);
    assert_eq!(sections(&format!("{PARAMETERS}LONG_SECTION_V_LEFT=5\n"), SECTIONS), [1.0, 3.0, 5.0]);
}

#[test]
fn slope_banking_options_and_modifiers_act_on_heights() {
    let f = Folder::new();
    let heights = |parameters: &str, more: &str| {
        let text =
            String::from_utf8(file(&format!("{PARAMETERS}{parameters}"), SECTIONS, TEXT.as_bytes())).unwrap();
        let text = text.replace("$KD_Definition", &format!("{more}$KD_Definition"));
        millimetres(&course(&f.file("a.crg", text)).unwrap().course)
    };
    // 0.1 m over each 0.5 m; 0.02 m at 2 m to the left.
    assert_eq!(heights("REFERENCE_LINE_START_S=0.2\n", ""), [1, 2, 3, 104, 105, 106, 207, 208, 209]);
    assert_eq!(heights("REFERENCE_LINE_START_Z=1\nREFERENCE_LINE_END_Z=1.2\n", "")[3], 1104);
    assert_eq!(heights("REFERENCE_LINE_START_B=0.01\n", ""), [-19, 2, 23, -16, 5, 26, -13, 8, 29]);
    assert_eq!(heights("", "$ROAD_CRG_OPTS\nBORDER_SMOOTH_UBEG = 1.0\n$\n"), [0, 0, 0, 2, 3, 3, 7, 8, 9]);
    assert_eq!(
        heights("", "$ROAD_CRG_MODS\nSCALE_Z_GRID = 10\nREFPOINT_X = 7\n$\n"),
        [10, 20, 30, 40, 50, 60, 70, 80, 90]
    );
}

#[test]
fn missing_borders_take_the_last_height_or_zero() {
    let f = Folder::new();
    let holes = TEXT.replacen(" 0.0010000", " *missing*", 1).replacen(" 0.0060000", "**unused**", 1);
    let read = |more: &str| {
        let text = String::from_utf8(file(PARAMETERS, SECTIONS, holes.as_bytes())).unwrap();
        course(&f.file("a.crg", text.replace("$KD_Definition", &format!("{more}$KD_Definition")))).unwrap()
    };
    let plain = read("");
    assert_eq!(millimetres(&plain.course), [2, 2, 3, 4, 5, 5, 7, 8, 9]);
    assert!(plain.notes[0].starts_with("2 heights"), "{:?}", plain.notes);
    let level = read("$ROAD_CRG_MODS\nGRID_NAN_MODE = 1\nGRID_NAN_OFFSET = 0.1\n$\n");
    assert_eq!(millimetres(&level.course), [100, 2, 3, 4, 5, 100, 7, 8, 9]);
}

#[test]
fn a_survey_of_a_road_has_its_heights_and_holes_beyond_its_borders() {
    let f = Folder::new();
    // At 45 degrees: the extents are wider than the road.
    let turned =
        file(&format!("{PARAMETERS}REFERENCE_LINE_START_PHI = 0.785398163\n"), SECTIONS, TEXT.as_bytes());
    let path = f.file("a.crg", turned);
    let found = survey(&path, &keep()).unwrap();
    assert_eq!((found.format, found.heights.resolution()), ("OpenCRG", Some(0.5)));
    assert!(
        found.heights.holes() > 0
            && found.range().is_some_and(|[low, high]| low >= 1e-3 && high <= 9e-3 + 1e-12)
    );
    assert!(found.summary().contains("unit m,"), "{}", found.summary());
    // Straight along x there are none, and the first row is the left border.
    let straight =
        read(&f.file("b.crg", file(PARAMETERS, SECTIONS, TEXT.as_bytes())), Holes::Refuse).unwrap();
    assert_eq!((straight.rows(), straight.cols()), (9, 3));
    assert_eq!(
        [straight.at(0, 0), straight.at(8, 2), straight.at(4, 1)].map(|z| (z * 1e3).round()),
        [3.0, 7.0, 5.0]
    );
}

#[test]
fn what_is_not_read_is_refused_with_line_and_remedy() {
    let f = Folder::new();
    let good = String::from_utf8(file(PARAMETERS, SECTIONS, TEXT.as_bytes())).unwrap();
    for (from, to, says) in [
        (
            "REFERENCE_LINE_INCREMENT = 0.5",
            "REFERENCE_LINE_INCREMENT = 0",
            "line 5: REFERENCE_LINE_INCREMENT is 0: must be above 0",
        ),
        (
            "REFERENCE_LINE_INCREMENT = 0.5",
            "REFERENCE_LINE_INCREMENT 0.5",
            "line 5: \"REFERENCE_LINE_INCREMENT 0.5\" is not NAME = NUMBER",
        ),
        ("REFERENCE_LINE_INCREMENT = 0.5 ! m\n", "", "ends without REFERENCE_LINE_INCREMENT: add it"),
        ("long_section_v_increment = 2.0\n", "", "LONG_SECTION_V_INCREMENT is missing"),
        (
            "= 2.0\n",
            "= 2.0\nLONG_SECTION_V_RIGHT=-1\nLONG_SECTION_V_LEFT=9\n",
            "not at LONG_SECTION_V_LEFT, 9",
        ),
        ("= 2.0\n", "= two\n", "line 6: LONG_SECTION_V_INCREMENT: \"two\" is not a number"),
        ("= 2.0\n", "= 2.0\nREFERENCE_LINE_END_PHI = 1\n", "no channel \"reference line phi\": add it"),
        ("= 2.0\n", "= 2.0\nREFERENCE_LINE_END_B = 0.1\n", "no channel \"reference line banking\": add it"),
        ("= 2.0\n", "= 2.0\nREFERENCE_LINE_END_U = 2\n", "3 rows of data, but its header declares 5"),
        ("= 2.0\n", "= 2.0\nREFERENCE_LINE_END_U = 0.5\n", "3 rows of data, but its header declares 2"),
        ("= 2.0\n", "= 2.0\nREFERENCE_LINE_END_U = 0.7\n", "not a multiple of the increment"),
        ("$ROAD_CRG ", "$ROAD_CRG_FILE\nb.crg\n$ROAD_CRG ", "give that file"),
        ("$KD_Def", "$ROAD_CRG_MODS\nSCALE_LENGTH = 2\n$KD_Def", "SCALE_LENGTH = 2 is not supported"),
        (
            "$KD_Def",
            "$ROAD_CRG_OPTS\nBORDER_MODE_U = 3\n$KD_Def",
            "BORDER_MODE_U = 3 is not supported: use 0 or 2",
        ),
        ("$KD_Def", "$PAINT\n$KD_Def", "line 8: unknown section $PAINT"),
        ("#:LRFI", "#:LHFI", "data format LHFI is not supported"),
        ("D:long section 2,m", "D:long section 2,mm", "is in \"mm\": convert it to m"),
        ("D:long section 2,m", "D:friction,-", "\"friction\" is not a supported channel"),
        ("D:long section 2,m", "D:long section 4,m", "long section 2 is expected here"),
        ("D:long section 2,m", "D:long section 1,m", "duplicate channel"),
        (
            "D:long section 2,m\nD:long section 3,m\n",
            "",
            "1 longitudinal sections are defined: a surface needs at least 2",
        ),
        (" 0.0040000", "0.00400000", "no error"),
        ("5.0000E-3", "5,0000x-3", "is not a number: each takes 10 characters"),
        (" 0.0060000", "", "line 16: ends before number 3 of 3"),
        (" 0.0060000", " 0.0060000 0.0060000", "line 16: has more than 3 numbers"),
        (" 0.0020000", " *missing*", "u = 0 m (row 1 of the data) lacks a height within the course"),
        (" 0.0010000 0.0020000 0.0030000", " *missing* *missing* *missing*", "has no height at all"),
        ("$$$$", "$", "its header has no end"),
    ] {
        assert!(good.contains(from), "{from}");
        let path = f.file("road.crg", good.replacen(from, to, 1));
        match course(&path) {
            Ok(_) => assert_eq!(says, "no error", "{to}"),
            Err(e) => {
                let e = e.to_string();
                assert!(e.contains("road.crg: ") && e.contains(says) && !e.contains('\n'), "{to}: {e}");
            }
        }
    }
    let short = binary((0..8).map(f64::from), false);
    let channels = SECTIONS.replace("LRFI", "KRBI");
    let e = course(
        &f.file("a.crg", file(&format!("{PARAMETERS}REFERENCE_LINE_END_U = 5.0\n"), &channels, &short)),
    )
    .unwrap_err();
    assert!(e.to_string().contains("6 rows of data, but its header declares 11"), "{e}");
}

#[test]
fn no_bytes_make_the_reader_panic() {
    let f = Folder::new();
    let mut rng = vb_math::rng::Stream::new(1, &["courses"]);
    let channels = "#:KRBI\nD:reference line phi,rad\nD:reference line slope,m/m\nD:long section 1,m\nD:long section 2,m\n";
    let values = binary((0..40).map(|k| 0.01 * f64::from(k)), false);
    for whole in [file(PARAMETERS, SECTIONS, TEXT.as_bytes()), file(PARAMETERS, channels, &values)] {
        for _ in 0..400 {
            let mut b = whole.clone();
            for _ in 0..1 + rng.below(3) {
                let at = rng.below(b.len() as u64) as usize;
                b[at] = [0, b'9', b'\n', b'$', b'-', b'*', b'e', rng.next_u64() as u8][rng.below(8) as usize];
            }
            b.truncate(1 + rng.below(2 * b.len() as u64) as usize);
            let path = f.file("a.crg", &b);
            let _ = (course(&path), read(&path, Holes::Keep));
        }
    }
}

#[test]
fn the_curved_banked_and_sloped_road_of_chrono_has_the_heights_of_an_independent_reading() {
    let Some(path) = vb_testing::shared("cases/chrono/crg_roads/handmade_curved_banked_sloped.crg") else {
        return;
    };
    let road = course(&path).unwrap().course;
    assert_eq!((road.cuts(), road.length(), road.borders()), (23, 22.0, [-1.5, 1.5]));
    // The slopes of the file's 22 segments add up to 1.21 m, and its headings end at 0 after 0.11 rad to the left.
    let [_, end] = road.span();
    assert!((road.height(end, 0.0) - 1.21).abs() < 1e-9 && (road.turn() - 0.11).abs() < 1e-9);
    // Points (x, y), coordinates (u, v) and heights by a reading of the fields of ten characters and a construction of the
    // lateral cuts, in another language and the other direction, from (u, v) to (x, y).
    for (at, [u, v], z) in [
        ([0.000000000, 0.000000000], [0.0, 0.0], 0.000000000),
        ([3.482928280, 0.549222784], [3.5, 0.5], 0.074361100),
        ([7.347610005, -1.146014739], [7.25, -1.4], 0.165111100),
        ([10.812055498, 2.095263397], [11.0, 1.5], 0.770000000),
        ([11.141390401, -0.886604896], [11.0, -1.5], 0.451111100),
        ([12.460223036, 1.868144016], [12.6, 1.1], 0.890806664),
        ([15.066110274, -0.518433762], [15.0, -1.5], 0.874611100),
        ([20.854771949, 1.007560943], [20.9, -0.2], 1.216479990),
        ([21.953445899, 2.708658501], [22.0, 1.5], 1.210000000),
    ] {
        let [own_u, own_v] = road.coordinates(at);
        assert!((own_u - u).abs() < 1e-6 && (own_v - v).abs() < 1e-6, "{own_u} {own_v}, not {u} {v}");
        assert!((road.height_at(at) - z).abs() < 1e-6, "at {u} {v}: {}, not {z}", road.height_at(at));
    }
}

#[test]
fn the_courses_of_chrono_have_the_sizes_that_their_texts_state() {
    let Some(dir) = vb_testing::shared("cases/chrono/crg_roads") else { return };
    let road = |name: &str| course(&dir.join(name)).unwrap().course;
    // "Detrended RMS = 0.96944 in", "Length of undulated surface = 304.8 m", "starts at = 100 m".
    for (name, inches) in [("1in", 0.969_44), ("4in", 3.300_5)] {
        let course = road(&format!("detrended_rms_course_{name}.crg"));
        assert_eq!((course.cuts(), course.borders(), course.turn()), (10_096, [-3.0, 3.0], 0.0));
        let heights: Vec<f64> = (0..=6096).map(|k| course.height(100.0 + 0.05 * f64::from(k), 1.0)).collect();
        let square: f64 = heights.iter().map(|z| z * z).sum();
        let rms = (square / heights.len() as f64).sqrt() / 0.0254;
        assert!((rms / inches - 1.0).abs() < 0.02, "{name}: {rms}");
        assert_eq!([course.height(99.0, 0.0), course.height(406.0, 0.0)], [0.0; 2]);
    }
    // "traverse halfround obstacle H = 12 in": half a circle of that radius.
    for inches in [12.0, 24.0] {
        let (course, radius) = (road(&format!("halfround_{inches}in.crg")), 0.0254 * inches);
        let middle = 50.0 + radius;
        for x in [-0.9, -0.4, 0.0, 0.3, 0.7] {
            let z = course.height(middle + x * radius, -2.0);
            let expected = radius * f64::sqrt(1.0 - x * x);
            assert!((z - expected).abs() < 0.01, "{inches} in at {x}: {z}, not {expected}");
        }
    }
    let straight = road("handmade_straight_minimalist.crg");
    assert_eq!((straight.cuts(), straight.borders()), (23, [-1.5, 1.5]));
}
