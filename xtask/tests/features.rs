//! The features of dependencies, which are the same whatever of the workspace is built.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// The crates that a selection of packages is built of, each with its features.
fn built(selection: &[&str]) -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["tree", "--offline", "--prefix", "none", "--format", "{p} with {f}"]).args(selection);
    let told = cargo.current_dir(root).output().expect("cargo runs");
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let text = String::from_utf8(told.stdout).expect("cargo prints text");
    text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn what_the_harness_and_the_python_package_are_built_of_serves_the_tests_too() {
    let all = built(&["--workspace", "--edges", "normal,build,dev"]);
    for package in ["vb-harness", "vb-python"] {
        let own = built(&["--package", package, "--edges", "normal,build"]);
        assert!(own.len() > 200 && all.len() > own.len());
        let alone: Vec<&String> = own.difference(&all).collect();
        assert!(
            alone.is_empty(),
            "tests build these crates of {package} again, with other features: name those in tools/unify/Cargo.toml: {alone:#?}"
        );
    }
}
