//! Writes what follows from the text of the planner interface, `sdk/wit`: the types of the SDKs, the conversions between
//! them, the C header, and the tables of the documentation.
//!
//! `cargo xtask abi` runs it. A test holds that the files in the repository are those that it writes.

mod model;
mod rust_types;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use model::Model;

/// The folder of the newest version's text.
const NEWEST: &str = "sdk/wit/v0_2";
/// What every file says that a person must not edit.
pub(crate) const HEADER: &str = "Made by `cargo xtask abi`; edit the WIT instead.";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All files that follow from the text: their paths and contents.
fn outputs() -> Result<Vec<(&'static str, String)>, String> {
    let model = Model::read(&root().join(NEWEST))?;
    Ok(vec![("sdk/src/types.rs", rust_types::write(&model))])
}

fn run() -> Result<(), String> {
    for (path, text) in outputs()? {
        let file = root().join(path);
        std::fs::write(&file, text).map_err(|e| format!("can't write {}: {e}", file.display()))?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}
