//! `vb-harness terrain` with the model that comes with the harness.

#![allow(clippy::unwrap_used)]

use crate::common::harness;
use tempfile::TempDir;

/// Exit code and the error's one line.
fn failure(dir: &TempDir, args: &[&str]) -> (Option<i32>, String) {
    let output = harness(dir, args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.starts_with("error: ") && text.lines().count() == 1, "{text}");
    (output.status.code(), text)
}

#[test]
fn a_surface_is_drawn_to_a_file_with_a_picture_and_measured() {
    let dir = tempfile::tempdir().unwrap();
    let draw = |out: &str, more: &[&str]| {
        let args = [&["terrain", "generate", "--seed", "5", "--size", "40x30", "--out", out], more].concat();
        let output = harness(&dir, &args);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let told = String::from_utf8(output.stdout).unwrap();
        assert!(told.starts_with(&format!("{out}: 40 x 30 nodes, ")), "{told}");
        std::fs::read(dir.path().join(out)).unwrap()
    };
    let first = draw("a.npy", &["--preview", "a.png"]);
    assert_eq!(first, draw("b.npy", &[]));
    assert_ne!(first, draw("c.npy", &["--level", "low"]));
    // NumPy's header (NEP 1): shape of rows and columns.
    assert!(String::from_utf8_lossy(&first[..100]).contains("(30, 40"));
    assert!(std::fs::read(dir.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    draw("d.png", &["--resolution", "0.5"]);
    for out in [&["--out", "a.npy"][..], &["--out", "e.npy", "--preview", "a.png"]] {
        let args = [&["terrain", "generate", "--seed", "5", "--size", "40x30"], out].concat();
        let (code, text) = failure(&dir, &args);
        assert!(code == Some(4) && text.contains("already exists") && text.contains("--force"), "{text}");
    }
    assert_eq!(first, draw("a.npy", &["--force"]));
    let measured = harness(&dir, &["terrain", "measure", "a.npy", "c.npy"]);
    let table = String::from_utf8(measured.stdout).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(rows.len(), 4, "{table}");
    let std = |row: usize| rows[row][6].parse::<f64>().unwrap();
    assert_eq!(rows[0][rows[0].len() - 2..], ["p99.5", "power"], "{table}");
    // A window of 32 × 32 fits on no 40 × 30 nodes; on 64 × 64 four do, and power falls with the wave number.
    assert_eq!(rows[1].last(), Some(&"-"), "{table}");
    // 30 % of the relief.
    assert!((std(2) / std(1) - 0.3).abs() < 0.01, "{table}");
    let args = ["terrain", "generate", "--seed", "5", "--size", "64", "--out", "e.npy"];
    assert!(harness(&dir, &args).status.success());
    let measured = harness(&dir, &["terrain", "measure", "--repair", "e.npy"]);
    let table = String::from_utf8(measured.stdout).unwrap();
    let power = table.split_whitespace().last().unwrap().strip_prefix("k^").unwrap();
    assert!((-3.0..-1.0).contains(&power.parse::<f64>().unwrap()), "{table}");
}

#[test]
fn what_can_not_be_done_ends_with_its_code() {
    let dir = tempfile::tempdir().unwrap();
    let generate = |more: &[&str]| failure(&dir, &[&["terrain", "generate", "--seed", "1"], more].concat());
    let (code, text) = generate(&["--out", "a.txt"]);
    assert!(code == Some(2) && text.contains(".npy or .png"), "{text}");
    let (code, text) = generate(&["--out", "a.npy", "--size", "1"]);
    assert!(code == Some(2) && text.contains("1 nodes"), "{text}");
    let (code, text) = generate(&["--out", "a.npy", "--resolution", "0"]);
    assert!(code == Some(2) && text.contains("resolution"), "{text}");
    let (code, text) = generate(&["--out", "a.npy", "--model", "none.safetensors"]);
    assert!(code == Some(3) && text.contains("none.safetensors"), "{text}");
    let (code, text) = generate(&["--out", "no/folder/a.npy"]);
    assert!(code == Some(4) && text.contains("no/folder/a.npy"), "{text}");
    let (code, text) = failure(&dir, &["terrain", "measure", "none.tif"]);
    assert!(code == Some(3) && text.contains("none.tif"), "{text}");
    assert!(!dir.path().join("a.npy").exists());
}
