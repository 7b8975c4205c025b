//! Writes what follows from the text of the planner interface, `sdk/wit`: the types of the SDKs, the conversions between
//! them, the C header, and the tables of the documentation.
//!
//! `cargo xtask abi` runs it. A test holds that the files in the repository are those that it writes.

mod bindings;
mod c_header;
mod c_layout;
mod docs;
mod model;
mod python;
mod rust_types;
mod wasm;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use model::Model;

/// The folder of the newest version's text.
const NEWEST: &str = "sdk/wit/v0_2";
/// Folders of the texts of hosted versions before the newest, each with the file of its conversions in the harness. A version that
/// leaves the newest place in the window moves here. The only one at present is synthetic, for a test of the mechanism.
const OLDER: [(&str, &str); 1] = [("harness/host/tests/older", "harness/host/tests/older/convert.rs")];
/// What every file says that a person must not edit.
pub(crate) const HEADER: &str = "Made by `cargo xtask abi`; edit the WIT instead.";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All files that follow from the text: their paths and contents.
fn outputs() -> Result<Vec<(&'static str, String)>, String> {
    let model = Model::read(&root().join(NEWEST))?;
    let mut outputs = vec![
        ("sdk/src/types.rs", rust_types::write(&model)),
        ("sdk/src/c/layout.rs", c_layout::write(&model)?),
        ("sdk/src/wasm/convert.rs", wasm::guest(&model)?),
        ("sdk/src/wasm/bindings.rs", bindings::write(&root().join(NEWEST))?),
        ("harness/host/src/wasm/v0_2/convert.rs", wasm::host(&model, &model)?),
        ("sdk/python/src/vertibench_planner/_data.py", python::write(&model)?),
        ("docs/abi.md", between_marks("docs/abi.md", &[("data", docs::tables(&model)?)])?),
        (
            "docs/worker-protocol.md",
            between_marks("docs/worker-protocol.md", &[("data", docs::wire(&model)?)])?,
        ),
        ("harness/worker/tests/c_header_fields.in", c_header::fields(&model)?),
        ("sdk/c/vb_planner.h", between_marks("sdk/c/vb_planner.h", &[("data", c_header::write(&model)?)])?),
    ];
    for (folder, conversions) in OLDER {
        let older = Model::read(&root().join(folder))?;
        outputs.push((conversions, wasm::host(&older, &model)?));
    }
    Ok(outputs)
}

/// A file that people write, with what lies between its marks replaced: `made: NAME` and `end of NAME`, each on a line of
/// its own with whatever makes a comment of it.
fn between_marks(path: &str, parts: &[(&str, String)]) -> Result<String, String> {
    let file = root().join(path);
    let text = std::fs::read_to_string(&file).map_err(|e| format!("can't read {}: {e}", file.display()))?;
    let mut out = String::new();
    let mut skipped: Option<&str> = None;
    for line in text.split_inclusive('\n') {
        if let Some(name) = skipped {
            if !line.contains(&format!("end of {name}")) {
                continue;
            }
            skipped = None;
        }
        out.push_str(line);
        if let Some((name, part)) = parts.iter().find(|(name, _)| line.contains(&format!("made: {name}"))) {
            out.push('\n');
            out.push_str(part);
            skipped = Some(*name);
        }
    }
    match skipped {
        Some(name) => Err(format!("{path}: there is no line with `end of {name}`")),
        None => Ok(out),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_in_the_repository_are_those_that_follow_from_the_text() {
        for (path, text) in outputs().unwrap() {
            let found = std::fs::read_to_string(root().join(path)).unwrap();
            assert!(found == text, "{path} is not what follows from {NEWEST}; run `cargo xtask abi`");
        }
    }

    #[test]
    fn what_has_no_output_yet_is_refused_by_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |body: &str| {
            let text = format!("package a:b@0.9.0;\ninterface types {{\n{body}\n}}\n");
            std::fs::write(folder.path().join("a.wit"), text).unwrap();
            Model::read(folder.path()).unwrap_err()
        };
        assert_eq!(
            refused("/// A.\nrecord a-b { /// C.\n c: s64 }"),
            "a-b.c: no outputs yet for the type S64"
        );
        assert_eq!(refused("/// A.\nrecord a-b { c: f64 }"), "`a-b.c` has no description");
        assert_eq!(refused("record a-b { /// C.\n c: f64 }"), "`a-b` has no description");
        assert!(refused("/// A.\nflags a-b { c }").contains("`a-b` is a flags"));
    }

    #[test]
    fn an_older_version_that_the_newest_cannot_express_is_refused_by_its_place() {
        let newest = Model::read(&root().join(NEWEST)).unwrap();
        let text = std::fs::read_to_string(root().join(NEWEST).join("planner.wit")).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let refused = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            std::fs::write(folder.path().join("planner.wit"), text.replacen(from, to, 1)).unwrap();
            wasm::host(&Model::read(folder.path()).unwrap(), &newest).unwrap_err()
        };
        // A field that there is no more, one of another type, and a case that the older version lacks.
        let renamed = refused("    goal-radius: f64,", "    goal-size: f64,");
        assert_eq!(renamed, "`task.goal-size` has no field of this name and type in the newest version");
        let retyped = refused("    goal-radius: f64,", "    goal-radius: f32,");
        assert_eq!(retyped, "`task.goal-radius` has no field of this name and type in the newest version");
        let shorter = refused("    /// The reverse gear.\n    reverse,\n", "");
        assert_eq!(shorter, "case `reverse` of `gear` can't be expressed in the other version");
    }
}
