//! ARCHITECTURE.md against the workspace.

use std::path::Path;
use std::process::Command;

#[test]
fn the_table_of_crates_has_each_with_its_folder_and_what_it_depends_on() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--format-version", "1", "--offline"]).current_dir(root);
    let told = cargo.output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let mut crates = 0;
    for package in told["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        let folder = folder.strip_prefix(root).unwrap().display().to_string();
        // Planners are told of below the table.
        if folder.starts_with("plugins") || folder.starts_with("examples") {
            continue;
        }
        crates += 1;
        let normal = package["dependencies"].as_array().unwrap().iter().filter(|d| d["kind"].is_null());
        let mut needed: Vec<_> =
            normal.filter_map(|d| d["name"].as_str().and_then(|n| n.strip_prefix("vb-"))).collect();
        needed.sort_unstable();
        needed.dedup();
        let needed = if needed.is_empty() { "–".to_owned() } else { needed.join(", ") };
        let (begin, end) = (format!("| `{name}` | `{folder}` | "), format!(" | {needed} |"));
        let has = text.lines().any(|row| row.starts_with(&begin) && row.ends_with(&end));
        assert!(has, "ARCHITECTURE.md wants a row: {begin}… {end}");
    }
    let rows = text.lines().filter(|l| l.starts_with("| `")).count();
    assert_eq!(rows, crates, "the table has a row of a crate that is no more");
}
