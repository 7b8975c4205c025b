//! ARCHITECTURE.md against the workspace.

use std::path::Path;
use std::process::Command;

/// The folders of the harness from the bottom up, as ARCHITECTURE.md has them.
const LAYERS: [&str; 6] = ["base", "model", "run", "show", "make", "learn"];

/// What cargo tells of the workspace.
fn metadata(root: &Path) -> serde_json::Value {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--format-version", "1", "--offline"]).current_dir(root);
    let told = cargo.output().expect("cargo runs");
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    serde_json::from_slice(&told.stdout).expect("cargo tells JSON")
}

#[test]
fn folders_of_the_harness_depend_downwards_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let told = metadata(root);
    // The place of a folder below `harness` in the list; front ends are above all.
    let layer = |folder: &Path| -> Option<usize> {
        let below = folder.strip_prefix(root.join("harness")).ok()?;
        let role = below.components().next()?.as_os_str().to_str()?;
        Some(LAYERS.iter().position(|known| *known == role).unwrap_or(LAYERS.len()))
    };
    let mut seen = [0; LAYERS.len() + 1];
    for package in told["packages"].as_array().unwrap() {
        let Some(own) = layer(Path::new(package["manifest_path"].as_str().unwrap())) else { continue };
        seen[own] += 1;
        for dependency in package["dependencies"].as_array().unwrap() {
            if let Some(other) = dependency["path"].as_str().and_then(|path| layer(Path::new(path))) {
                let (name, on) = (package["name"].as_str().unwrap(), dependency["name"].as_str().unwrap());
                assert!(dependency["kind"] == "dev" || other <= own, "{name} is below {on}, which it uses");
            }
        }
    }
    assert!(seen.iter().all(|crates| *crates > 0), "{seen:?}");
    assert_eq!(seen[LAYERS.len()], 2, "crates beside the layers are the front ends cli and python");
}

#[test]
fn the_table_of_crates_has_each_with_its_folder_and_what_it_depends_on() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let told = metadata(root);
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
    let rows = text.lines().filter(|l| l.starts_with("| `vb-") || l.starts_with("| `xtask`")).count();
    assert_eq!(rows, crates, "the table has a row of a crate that is no more");
}
