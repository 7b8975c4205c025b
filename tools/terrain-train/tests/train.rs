//! The program that trains, as a user runs it.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

use vb_terrain::{Model, Request};
use vb_world::Heightfield;

fn run(dir: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vb-terrain-train")).args(args).current_dir(dir).output().unwrap()
}

/// Three scans of hills, as NumPy arrays; one is held out.
fn data(dir: &Path) {
    std::fs::create_dir(dir.join("data")).unwrap();
    for k in 0..3 {
        let z = |i: usize| {
            let (r, c) = ((i / 72) as f64, (i % 72) as f64);
            vb_math::sin(0.35 * r + f64::from(k)) * vb_math::cos(0.25 * c) + 0.3 * vb_math::sin(0.9 * (r - c))
        };
        let surface = Heightfield::new(72, 72, 1.0, (0..72 * 72).map(z).collect());
        std::fs::write(dir.join(format!("data/{k}.npy")), vb_terrain::write::npy(&surface).unwrap()).unwrap();
    }
    let selection = "schema: 1\nfiles: {0.npy: {}, 1.npy: {}, 2.npy: {held_out: true}}\n";
    std::fs::write(dir.join("data/terrain.yaml"), selection).unwrap();
}

#[test]
fn a_folder_of_elevation_becomes_a_model_with_its_card() {
    let dir = tempfile::tempdir().unwrap();
    data(dir.path());
    let args = ["--data", "data", "--out", "hills.safetensors", "--epochs", "2", "--relief", "1.5"];
    let output = run(dir.path(), &args);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{told}");
    assert!(told.starts_with("2 files to train on, 1 held out; "), "{told}");
    let model = Model::read(&dir.path().join("hills.safetensors")).unwrap();
    assert_eq!((model.header().relief, model.header().resolution), (1.5, 1.0));
    // Heights have the relief that was asked for, over a surface that is large beside its waves.
    let request = Request { seed: 9, rows: 400, cols: 400, resolution: 1.0, fraction: 1.0 };
    let std = vb_terrain::stats::deviation(model.surface(&request).unwrap().heights());
    assert!((std / 1.5 - 1.0).abs() < 0.1, "{std}");
    let card: serde_json::Value =
        serde_json::from_slice(&std::fs::read(dir.path().join("hills.json")).unwrap()).unwrap();
    assert_eq!(card["data"]["trained"], serde_json::json!(["0.npy", "1.npy"]));
    assert_eq!(card["data"]["held_out"], serde_json::json!(["2.npy"]));
    assert!(card["held_out"]["spectrum_db"].as_f64().unwrap() > 0.0);
    assert!(!dir.path().join("hills.checkpoint").exists());
}

#[test]
fn what_can_not_be_trained_ends_with_its_code_and_one_line() {
    let dir = tempfile::tempdir().unwrap();
    data(dir.path());
    let fails = |args: &[&str]| {
        let output = run(dir.path(), args);
        let text = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), text.lines().last().unwrap_or_default().to_owned())
    };
    let (code, text) = fails(&["--data", "data"]);
    assert!(code == Some(2) && text.contains("--out"), "{text}");
    let (code, text) = fails(&["--data", "none", "--out", "a.safetensors"]);
    assert!(code == Some(3) && text.contains("none"), "{text}");
    let (code, text) = fails(&["--data", "data", "--out", "a.safetensors", "--every", "2"]);
    assert!(code == Some(3) && text.contains("64 x 64"), "{text}");
    let (code, text) = fails(&["--data", "data", "--out", "a.safetensors", "--resume"]);
    assert!(code == Some(3) && text.contains("a.checkpoint"), "{text}");
    let (code, text) = fails(&["--data", "data", "--out", "no/folder/a.safetensors", "--epochs", "1"]);
    assert!(code == Some(4) && text.contains("no/folder"), "{text}");
}
