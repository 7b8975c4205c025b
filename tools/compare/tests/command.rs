//! The built program.

use std::process::Command;

#[test]
fn without_reference_data_it_says_so_and_ends_well() {
    let out = tempfile::tempdir().expect("a folder");
    let result = Command::new(env!("CARGO_BIN_EXE_vb-compare"))
        .args([
            "--harness",
            "vb-harness",
            "--plugins",
            "plugins",
            "--vehicle",
            "a.yaml",
            "--recorded-vehicle",
            "b.yaml",
            "--soils",
            "c.yaml",
        ])
        .args(["--recorded", "no/recorded/runs", "--original", "no/worlds", "--out"])
        .arg(out.path().join("out"))
        .output()
        .expect("the program runs");
    let told = String::from_utf8_lossy(&result.stderr);
    assert!(result.status.success(), "{told}");
    assert!(told.contains("skipped: no recorded runs at no/recorded/runs"), "{told}");
    assert!(!out.path().join("out").exists());
}
