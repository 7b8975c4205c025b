//! Where things are: what comes with the harness, the SDK, new run directories.

use std::path::{Path, PathBuf};

use vb_catalog::Catalog;

/// The environment variable that names the directory with the planners that are found by their file names.
pub(crate) const PLUGINS_VAR: &str = "VB_PLUGINS";

/// What comes with the harness.
pub(crate) fn catalog() -> Catalog {
    Catalog::find()
}

/// The folder of the SDK in the checkout that the built-in tasks lie in.
pub(crate) fn sdk() -> Option<PathBuf> {
    let tasks = std::path::absolute(catalog().tasks().ok()?).ok()?;
    tasks.parent().map(|root| root.join("sdk")).filter(|sdk| sdk.join("Cargo.toml").is_file())
}

/// The planner's file that the user means by `--plugin`: as it is written, or a bare file name that isn't in the working directory
/// in the directory that `VB_PLUGINS` names.
pub(crate) fn plugin(wanted: PathBuf) -> PathBuf {
    match plugins_dir() {
        Some(dir) => plugin_in(&dir, wanted),
        None => wanted,
    }
}

/// The directory with the planners that are found by their file names, if there is one.
pub(crate) fn plugins_dir() -> Option<PathBuf> {
    std::env::var_os(PLUGINS_VAR).filter(|v| !v.is_empty()).map(PathBuf::from)
}

fn plugin_in(dir: &Path, wanted: PathBuf) -> PathBuf {
    let file = dir.join(&wanted);
    let is_bare = wanted.file_name() == Some(wanted.as_os_str());
    if is_bare && !wanted.exists() && file.is_file() { file } else { wanted }
}

/// The first `runs/NAME-N` that isn't there.
pub(crate) fn new_run_dir(name: &str) -> PathBuf {
    let safe: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' })
        .collect();
    let mut n = 1;
    loop {
        let dir = Path::new("runs").join(format!("{safe}-{n}"));
        if !dir.exists() {
            return dir;
        }
        n += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_is_found_by_its_file_name_and_by_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("pid.wasm");
        std::fs::write(&file, "").unwrap();
        std::fs::create_dir(dir.path().join("inner")).unwrap();
        let found = |wanted: &str| plugin_in(dir.path(), wanted.into());
        assert_eq!(found("pid.wasm"), file);
        // A path is one that the user has, a name without its ending is none of a file, and Cargo.toml is here.
        std::fs::write(dir.path().join("Cargo.toml"), "").unwrap();
        for as_it_is in
            ["./pid.wasm", "planners/pid.wasm", "pid", "gone.wasm", "inner", "Cargo.toml", "..", ""]
        {
            assert_eq!(found(as_it_is), Path::new(as_it_is), "{as_it_is}");
        }
    }
}
