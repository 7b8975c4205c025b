//! Where things are: what comes with the harness, the SDK, new run directories.

use std::path::{Path, PathBuf};

use vb_catalog::Catalog;

/// What comes with the harness.
pub(crate) fn catalog() -> Catalog {
    Catalog::find()
}

/// The folder of the SDK in the checkout that the built-in tasks lie in.
pub(crate) fn sdk() -> Option<PathBuf> {
    let tasks = std::path::absolute(catalog().tasks().ok()?).ok()?;
    tasks.parent().map(|root| root.join("sdk")).filter(|sdk| sdk.join("Cargo.toml").is_file())
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
