//! Tells the crate what it is made of, as `VB_KERNEL_SOURCES`: the kernels of a GPU are a file of their own, and kernels of other
//! sources than the program's would drive otherwise than it, and nobody would notice.

use std::io::{Error, Result};
use std::path::{Path, PathBuf};

/// The folders in `harness` of this crate and of those of the workspace that it depends on.
const CRATES: [&str; 7] = [
    "base/files",
    "base/math",
    "learn/kernel",
    "model/granular",
    "model/sim",
    "model/vehicle",
    "model/world",
];
/// The libraries that compute a state, or read what is sent.
const LIBRARIES: [&str; 10] = [
    "fearless_simd",
    "glam",
    "glamx",
    "libm",
    "nalgebra",
    "parry3d-f64",
    "rapier3d-f64",
    "rmp-serde",
    "simba",
    "wide",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    match hash(&root) {
        Ok(hash) => println!("cargo::rustc-env=VB_KERNEL_SOURCES={}", &hash[..16]),
        Err(e) => println!("cargo::error=can't tell what the kernels are made of: {e}"),
    }
}

fn hash(root: &Path) -> Result<String> {
    let mut hash = vb_files::Hash::new();
    let mut add = |name: &str, content: &[u8]| {
        hash.update(format!("{name} {}\n", content.len()));
        hash.update(content);
    };
    for name in CRATES {
        let sources = root.join("harness").join(name).join("src");
        println!("cargo::rerun-if-changed={}", sources.display());
        let mut files = Vec::new();
        list(&sources, &mut files)?;
        files.sort();
        for file in files {
            // The same bytes where git writes lines' ends as Windows has them.
            let text = read(&file)?.replace('\r', "");
            let place = file.strip_prefix(&sources).unwrap_or(&file);
            add(&format!("{name}/{}", place.display()).replace('\\', "/"), text.as_bytes());
        }
    }
    let lock = root.join("Cargo.lock");
    println!("cargo::rerun-if-changed={}", lock.display());
    let text = read(&lock)?;
    for name in LIBRARIES {
        // Of a library that is there in several versions, all: which of them the simulator has isn't told here.
        let named = format!("name = \"{name}\"");
        let lines: Vec<&str> = text.lines().collect();
        let versions: Vec<&str> = lines.windows(2).filter(|two| two[0] == named).map(|two| two[1]).collect();
        if versions.is_empty() {
            return Err(Error::other(format!("{} has no {name}", lock.display())));
        }
        add(name, versions.join("\n").as_bytes());
    }
    Ok(hash.hex())
}

/// The files of Rust in a folder that aren't tests.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let named = |e: Error| Error::other(format!("{}: {e}", folder.display()));
    for entry in std::fs::read_dir(folder).map_err(named)? {
        let path = entry.map_err(named)?.path();
        let is_test = path.file_stem().is_some_and(|name| name == "tests");
        if path.is_dir() && !is_test {
            list(&path, files)?;
        } else if path.extension().is_some_and(|kind| kind == "rs") && !is_test {
            files.push(path);
        }
    }
    Ok(())
}

fn read(file: &Path) -> Result<String> {
    std::fs::read_to_string(file).map_err(|e| Error::other(format!("{}: {e}", file.display())))
}
