//! Where things are: what comes with the harness, the SDK, new run directories.

use std::path::{Path, PathBuf};

use vb_catalog::{Catalog, planner_dirs};
use vb_record::RunHeader;
use vb_vehicle::VehicleSpec;
use vb_world::Suite;

use crate::error::CliError;

/// What comes with the harness.
pub(crate) fn catalog() -> Catalog {
    let found = Catalog::find();
    #[cfg(feature = "carried-tasks")]
    let found = found.or(vb_catalog::Carried {
        bundle: include_bytes!(concat!(env!("OUT_DIR"), "/tasks.bundle")),
        hash: env!("VB_TASKS_HASH"),
    });
    found
}

/// The vehicle that the user means, and its file.
pub(crate) fn vehicle(wanted: &str) -> Result<(PathBuf, VehicleSpec), CliError> {
    let path = catalog().data(vb_catalog::Data::Vehicle, wanted)?;
    let spec = VehicleSpec::load(&path).map_err(CliError::input)?;
    Ok((path, spec))
}

/// The suite of a run: where the user says, where it was, or the one of its name that comes with the harness.
pub(crate) fn suite_of(header: &RunHeader, wanted: Option<&Path>) -> Result<Suite, CliError> {
    let places = match wanted {
        Some(dir) => vec![catalog().suite(Some(dir))?],
        None => {
            let named = catalog().suites().unwrap_or_default();
            let named = named.into_iter().filter(|p| p.file_name().is_some_and(|n| *n == *header.suite.name));
            // A submission doesn't say where its suite was.
            let own = Some(PathBuf::from(&header.suite.path)).filter(|p| !p.as_os_str().is_empty());
            own.into_iter().chain(named).collect()
        }
    };
    let opened = places.iter().filter_map(|p| Suite::open(p).ok());
    opened.into_iter().find(|s| s.hash() == header.suite.hash).ok_or_else(|| {
        let looked: Vec<String> = places.iter().map(|p| p.display().to_string()).collect();
        let place = match looked.is_empty() {
            true => "one of the built-in suites".to_owned(),
            false => format!("at {}", looked.join(" nor at ")),
        };
        CliError::input(format!(
            "suite {} of the run (hash {}) is not {place} (give its folder with --suite)",
            header.suite.name,
            header.suite.hash.get(..12).unwrap_or(&header.suite.hash),
        ))
    })
}

/// The folder of the SDK for Rust next to the built-in tasks: in a checkout, a wheel and an archive.
pub(crate) fn sdk() -> Option<PathBuf> {
    let tasks = std::path::absolute(catalog().tasks().ok()?).ok()?;
    tasks.parent().map(|root| root.join("sdk")).filter(|sdk| sdk.join("Cargo.toml").is_file())
}

/// The planner's file that the user means by `--plugin`: as it is written, or a bare file name that isn't in the working directory
/// in one of those with planners ([`planner_dirs`]).
pub(crate) fn plugin(wanted: PathBuf) -> PathBuf {
    if is_bare(&wanted) && !wanted.exists() { plugin_in(&planner_dirs(), wanted) } else { wanted }
}

/// Whether it is a file name alone.
pub(crate) fn is_bare(path: &Path) -> bool {
    path.file_name() == Some(path.as_os_str())
}

fn plugin_in(dirs: &[PathBuf], wanted: PathBuf) -> PathBuf {
    dirs.iter().map(|dir| dir.join(&wanted)).find(|file| file.is_file()).unwrap_or(wanted)
}

/// The first `runs/NAME-N` that isn't there.
pub(crate) fn new_run_dir(name: &str) -> PathBuf {
    let mut n = 1;
    while run_dir(name, n).exists() {
        n += 1;
    }
    run_dir(name, n)
}

/// The last of `runs/NAME-1`, `runs/NAME-2`, … that is there.
pub(crate) fn last_run_dir(name: &str) -> Option<PathBuf> {
    (1..).map(|n| run_dir(name, n)).take_while(|dir| dir.exists()).last()
}

fn run_dir(name: &str, n: u32) -> PathBuf {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    Path::new("runs").join(format!("{}-{n}", name.chars().map(safe).collect::<String>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_is_found_by_its_file_name_in_the_first_folder_that_has_it() {
        let dir = tempfile::tempdir().unwrap();
        let dirs = ["first", "second"].map(|name| dir.path().join(name));
        for (folder, file) in [(&dirs[0], "pid.wasm"), (&dirs[1], "pid.wasm"), (&dirs[1], "mppi.wasm")] {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join(file), "").unwrap();
        }
        std::fs::create_dir(dirs[0].join("inner")).unwrap();
        let found = |wanted: &str| plugin_in(&dirs, wanted.into());
        assert_eq!(found("pid.wasm"), dirs[0].join("pid.wasm"));
        assert_eq!(found("mppi.wasm"), dirs[1].join("mppi.wasm"));
        // A name without its ending is none of a file.
        for as_it_is in ["pid", "gone.wasm", "inner", ""] {
            assert_eq!(found(as_it_is), Path::new(as_it_is), "{as_it_is}");
        }
        // A path is one that the user has, whatever lies elsewhere.
        for path in ["./pid.wasm", "planners/pid.wasm", "..", ""] {
            assert!(!is_bare(Path::new(path)), "{path}");
        }
    }
}
