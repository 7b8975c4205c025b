//! Where things are: the suites and vehicles that come with the harness, caches, new run directories.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::error::CliError;

/// The environment variable that names the directory with the built-in suites, rules and vehicles.
const TASKS_VAR: &str = "VB_TASKS";
/// The environment variable that names the directory with the planners that are found by their file names.
pub(crate) const PLUGINS_VAR: &str = "VB_PLUGINS";
/// The environment variable that names the directory for compiled plugins.
const CACHE_VAR: &str = "VB_CACHE";

/// The `tasks` directory that comes with the harness: `VB_TASKS`, else one in a directory above the program, else
/// one in or above the working directory.
fn tasks_dir() -> Option<PathBuf> {
    if let Some(dir) = var(TASKS_VAR) {
        return Some(dir);
    }
    let roots = [std::env::current_exe().ok(), std::env::current_dir().ok().map(|d| d.join("."))];
    roots.into_iter().flatten().find_map(|root| {
        root.ancestors().map(|dir| dir.join("tasks")).find(|tasks| tasks.join("vehicles").is_dir())
    })
}

/// The folder of the SDK in the checkout that the built-in tasks lie in.
pub(crate) fn sdk() -> Option<PathBuf> {
    let tasks = std::path::absolute(tasks_dir()?).ok()?;
    tasks.parent().map(|root| root.join("sdk")).filter(|sdk| sdk.join("Cargo.toml").is_file())
}

fn var(name: &str) -> Option<PathBuf> {
    std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from)
}

fn no_tasks_dir() -> CliError {
    CliError::input(format!(
        "the built-in tasks are not found (run in a checkout of the project, or set {TASKS_VAR} to its tasks directory)"
    ))
}

/// The built-in suites, by name.
pub(crate) fn suites() -> Result<Vec<PathBuf>, CliError> {
    let dir = tasks_dir().ok_or_else(no_tasks_dir)?;
    let entries = std::fs::read_dir(&dir).map_err(|e| CliError::input(format!("{}: {e}", dir.display())))?;
    let mut found: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.join("suite.yaml").is_file()).collect();
    found.sort();
    Ok(found)
}

/// The suite that is run where none is named.
const DEFAULT_SUITE: &str = "vb-100";

/// The suite that the user means: a directory, or the name of one that comes with the harness.
pub(crate) fn suite(wanted: Option<&Path>) -> Result<PathBuf, CliError> {
    let Some(wanted) = wanted else {
        return Ok(tasks_dir().ok_or_else(no_tasks_dir)?.join(DEFAULT_SUITE));
    };
    match wanted.to_str() {
        Some(name) if !wanted.exists() && is_name(wanted.as_os_str()) => own_suite(name),
        _ => Ok(wanted.to_owned()),
    }
}

/// The suite of this name that comes with the harness, whatever lies in the working directory.
pub(crate) fn own_suite(name: &str) -> Result<PathBuf, CliError> {
    let all = suites()?;
    if let Some(found) = all.iter().find(|p| p.file_name() == Some(OsStr::new(name))) {
        return Ok(found.clone());
    }
    let names: Vec<_> = all.iter().filter_map(|p| p.file_name()).map(OsStr::to_string_lossy).collect();
    let names = names.join(", ");
    Err(CliError::input(format!(
        "there is no suite {name} (give a directory with --suite, or one of: {names})"
    )))
}

/// The terrain model of this name that comes with the harness.
pub(crate) fn terrain_model(name: &str) -> Result<PathBuf, CliError> {
    Ok(tasks_dir().ok_or_else(no_tasks_dir)?.join("terrain").join(format!("{name}.safetensors")))
}

/// A kind of data file that comes with the harness.
#[derive(Clone, Copy)]
pub(crate) enum Data {
    /// `tasks/vehicles`.
    Vehicle,
    /// `tasks/soils`.
    Soils,
    /// `tasks/perception`.
    Perception,
}

impl Data {
    fn folder(self) -> &'static str {
        match self {
            Self::Vehicle => "vehicles",
            Self::Soils => "soils",
            Self::Perception => "perception",
        }
    }

    /// What one file is called in messages.
    pub(crate) fn noun(self) -> &'static str {
        match self {
            Self::Vehicle => "vehicle",
            Self::Soils => "soil set",
            Self::Perception => "perception profile",
        }
    }
}

/// The data file that the user means: a path, or the name of one that comes with the harness.
pub(crate) fn data(kind: Data, wanted: &str) -> Result<PathBuf, CliError> {
    if !is_name(OsStr::new(wanted)) || Path::new(wanted).is_file() {
        return Ok(PathBuf::from(wanted));
    }
    own_data(kind, wanted)
}

/// The data file of this name that comes with the harness, whatever lies in the working directory.
pub(crate) fn own_data(kind: Data, wanted: &str) -> Result<PathBuf, CliError> {
    let dir = tasks_dir().ok_or_else(no_tasks_dir)?.join(kind.folder());
    let file = dir.join(format!("{wanted}.yaml"));
    if file.is_file() {
        return Ok(file);
    }
    Err(CliError::input(format!(
        "there is no {} {wanted} (give a file, or one of: {})",
        kind.noun(),
        names(kind)?.join(", ")
    )))
}

/// The names of the data files of a kind that come with the harness.
pub(crate) fn names(kind: Data) -> Result<Vec<String>, CliError> {
    let dir = tasks_dir().ok_or_else(no_tasks_dir)?.join(kind.folder());
    let mut names: Vec<String> = std::fs::read_dir(&dir)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|e| e.file_name().to_string_lossy().strip_suffix(".yaml").map(str::to_owned))
        .collect();
    names.sort();
    Ok(names)
}

/// The file of reference figures that comes with the harness for a vehicle of this name, if there is one.
pub(crate) fn references(vehicle: &str) -> Option<PathBuf> {
    let file = tasks_dir()?.join("validation").join(format!("{vehicle}.yaml"));
    file.is_file().then_some(file)
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
    var(PLUGINS_VAR)
}

fn plugin_in(dir: &Path, wanted: PathBuf) -> PathBuf {
    let file = dir.join(&wanted);
    let is_bare = wanted.file_name() == Some(wanted.as_os_str());
    if is_bare && !wanted.exists() && file.is_file() { file } else { wanted }
}

/// Whether this is a bare name rather than a path.
pub(crate) fn is_name(text: &OsStr) -> bool {
    !text.to_string_lossy().contains(['/', '\\', '.'])
}

/// Where compiled plugins are kept between runs; none if the system has no place for it.
pub(crate) fn cache_dir() -> Option<PathBuf> {
    var(CACHE_VAR)
        .or_else(|| var("XDG_CACHE_HOME").map(|d| d.join("verti-bench")))
        .or_else(|| var("HOME").map(|d| d.join(".cache").join("verti-bench")))
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
