//! Folders of elevation data.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use vb_terrain::data::{Data, Meaning};
use vb_terrain::tiles::{Cut, Tiles};

const MEANING: Meaning = Meaning { resolution: 0.25, every: 2 };

/// An 8-bit picture of waves with a black corner and a speck.
fn picture(dir: &Path, name: &str, phase: f64) {
    let grey = |r: usize, c: usize| {
        if r < 4 && c < 4 {
            return 0;
        }
        if (r, c) == (20, 20) {
            return 250;
        }
        (100.0 + 20.0 * vb_math::sin(0.4 * c as f64 + phase) + 20.0 * vb_math::cos(0.3 * r as f64)) as u8
    };
    let data: Vec<u8> = (0..40 * 48).map(|i| grey(i / 48, i % 48)).collect();
    let mut out = Vec::new();
    let mut e = png::Encoder::new(&mut out, 48, 40);
    e.set_color(png::ColorType::Grayscale);
    e.write_header().unwrap().write_image_data(&data).unwrap();
    std::fs::write(dir.join(name), out).unwrap();
}

#[test]
fn a_selection_says_which_parts_of_which_files_are_measured_and_which_are_held_out() {
    let dir = tempfile::tempdir().unwrap();
    for (i, name) in ["a.png", "b.png", "c.png"].iter().enumerate() {
        picture(dir.path(), name, i as f64);
    }
    std::fs::write(dir.path().join("notes.txt"), "no elevation").unwrap();
    let selection = "schema: 1\nvalid: [1, 200]\nfiles:\n  a.png: {}\n  c.png: {window: [2, 0, 42, 40], held_out: true}\n";
    std::fs::write(dir.path().join("terrain.yaml"), selection).unwrap();
    let data = Data::read(dir.path(), None, MEANING).unwrap();
    let names: Vec<_> = data.scans.iter().map(|s| (s.name.as_str(), s.held_out)).collect();
    assert_eq!(names, [("a.png", false), ("c.png", true)]);
    assert_eq!(data.resolution, 0.5);
    // Every second sample can begin at four places.
    let [first, second] = [&data.scans[0].layers, &data.scans[1].layers];
    assert_eq!((first.len(), second.len()), (4, 4));
    assert_eq!((first[0].heights.rows(), first[0].heights.cols(), second[0].heights.cols()), (20, 24, 20));
    // The black corner of 4 × 4 is not measured, four of every second sample, nor is the speck, at an even row and
    // column.
    let holes = |l: &vb_terrain::data::Layer| l.measured.iter().filter(|m| !**m).count();
    assert_eq!(first.iter().map(holes).collect::<Vec<_>>(), [5, 4, 4, 4]);
    assert!(first.iter().flat_map(|l| l.heights.values()).all(|v| v.is_finite() && v.abs() < 3.0));
    // What is trained on has standard deviation 1 about its plane, over all that is measured.
    let (mut n, mut squares) = (0.0, 0.0);
    for layer in first {
        for (v, _) in layer.heights.values().iter().zip(&layer.measured).filter(|(_, m)| **m) {
            (n, squares) = (n + 1.0, squares + v * v);
        }
    }
    assert!(((squares / n).sqrt() - 1.0).abs() < 1e-9);
}

#[test]
fn the_hash_tells_data_and_selections_apart() {
    let dir = tempfile::tempdir().unwrap();
    picture(dir.path(), "a.png", 0.0);
    picture(dir.path(), "b.png", 1.0);
    let hash = || Data::read(dir.path(), None, MEANING).unwrap().sha256;
    let first = hash();
    assert_eq!(first, hash());
    picture(dir.path(), "b.png", 1.5);
    let second = hash();
    std::fs::write(dir.path().join("terrain.yaml"), "schema: 1\nfiles: {a.png: {}, b.png: {}}\n").unwrap();
    assert!(first != second && second != hash());
}

#[test]
fn without_a_selection_every_eighth_file_is_held_out() {
    let dir = tempfile::tempdir().unwrap();
    for i in 0..17 {
        picture(dir.path(), &format!("{i:02}.png"), f64::from(i));
    }
    let data = Data::read(dir.path(), None, MEANING).unwrap();
    let held: Vec<_> = data.scans.iter().filter(|s| s.held_out).map(|s| s.name.as_str()).collect();
    assert_eq!(held, ["07.png", "15.png"]);
}

#[test]
fn folders_that_cannot_be_learned_from_are_told_in_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let why = || {
        let text = Data::read(dir.path(), None, MEANING).unwrap_err().to_string();
        assert!(!text.contains('\n'), "{text}");
        text
    };
    assert!(why().contains("contains no elevation data"));
    picture(dir.path(), "a.png", 0.0);
    let select = |text: &str| std::fs::write(dir.path().join("terrain.yaml"), text).unwrap();
    select("schema: 1\nfiles: {z.png: {}}\n");
    assert!(why().contains("z.png of the selection does not exist"));
    select("schema: 1\nfiles: {a.png: {window: [0, 0, 49, 40]}}\n");
    assert!(why().contains("window [0, 0, 49, 40]"));
    select("schema: 2\nfiles: {a.png: {}}\n");
    assert!(why().contains("schema 2"));
    select("schema: 1\nfiles: {a.png: {windows: []}}\n");
    assert!(why().contains("terrain.yaml"));
    select("schema: 1\nvalid: [300, 400]\nfiles: {a.png: {}}\n");
    assert!(why().contains("are constant"));
    std::fs::write(dir.path().join("a.png"), "no picture").unwrap();
    assert!(why().contains("a.png"));
}

#[test]
fn the_originals_thousand_training_images_hold_32_tiles() {
    // The original's envs/data/elev_maps.
    let Some(dir) = vb_testing::shared("verti-bench/BenchMaps/elev_maps") else { return };
    // Levelling and repair would make tiles of one image differ by its plane: raw rasters here.
    let mut names: Vec<_> = std::fs::read_dir(&dir).unwrap().flatten().map(|e| e.path()).collect();
    names.sort();
    let scans: Vec<_> = names
        .iter()
        .map(|path| {
            let heights = vb_terrain::read::read(path, vb_terrain::read::Holes::Refuse).unwrap();
            let measured = vec![true; heights.values().len()];
            vb_terrain::data::Scan {
                name: String::new(),
                held_out: false,
                repaired: Default::default(),
                layers: vec![vb_terrain::data::Layer { heights, measured }],
            }
        })
        .collect();
    let tiles = Tiles::cut(&scans, Cut { side: 32, stride: 32, holes: 0.0 });
    assert_eq!((tiles.len(), tiles.copies()), (32, 16 * 1000 - 32));
}
