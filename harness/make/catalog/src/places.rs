//! Where what comes with the harness lies, and what it keeps: environment variables, folders around the program, and the
//! user's own.

use std::path::{Path, PathBuf};

/// The environment variable that names the directory with the built-in suites, rules and vehicles.
pub const TASKS_VAR: &str = "VB_TASKS";
/// The environment variable that names the directory with the planners that are found by their file names.
pub const PLUGINS_VAR: &str = "VB_PLUGINS";
/// The environment variable that names the directory for what is kept between commands.
pub const CACHE_VAR: &str = "VB_CACHE";
/// The environment variable that names the directory for what is unpacked and installed.
pub const DATA_VAR: &str = "VB_DATA";

/// The folder `tasks`: the one that [`TASKS_VAR`] names, else one in a directory above the program, else one in or above the
/// working directory.
pub(crate) fn tasks() -> Option<PathBuf> {
    let is_ours = |tasks: &PathBuf| tasks.join("vehicles").is_dir();
    let around = || {
        let working = std::env::current_dir().ok().map(|dir| dir.join("tasks"));
        let roots = [program(), working].into_iter().flatten();
        roots.flat_map(|root| above(&root, "tasks")).find(is_ours)
    };
    var(TASKS_VAR).or_else(around)
}

/// The directories in which a planner is looked for by its file name: the one that [`PLUGINS_VAR`] names, and no other; else
/// `plugins` in the directories above the program, as in an archive of a release, in a checkout's `target` and in the Python
/// package, and the one with the [installed](installed_planners).
#[must_use]
pub fn planner_dirs() -> Vec<PathBuf> {
    if let Some(dir) = var(PLUGINS_VAR) {
        return vec![dir];
    }
    let beside = program().map(|program| above(&program, "plugins")).unwrap_or_default();
    beside.into_iter().chain(installed_planners()).filter(|dir| has_planners(dir)).collect()
}

/// The directory with the planners that the user has installed; none if the system has no place for it.
#[must_use]
pub fn installed_planners() -> Option<PathBuf> {
    Some(data_dir()?.join("plugins"))
}

/// Where compiled plugins and training worlds are kept between commands; none if the system has no place for it.
#[must_use]
pub fn cache_dir() -> Option<PathBuf> {
    var(CACHE_VAR)
        .or_else(|| var("XDG_CACHE_HOME").map(|d| d.join("verti-bench")))
        .or_else(|| var("HOME").map(|d| d.join(".cache").join("verti-bench")))
        // Of Windows.
        .or_else(|| var("LOCALAPPDATA").map(|d| d.join("verti-bench").join("cache")))
}

/// Where the built-in tasks are unpacked and planners installed; none if the system has no place for it.
#[must_use]
pub fn data_dir() -> Option<PathBuf> {
    var(DATA_VAR)
        .or_else(|| var("XDG_DATA_HOME").map(|d| d.join("verti-bench")))
        .or_else(|| var("HOME").map(|d| d.join(".local").join("share").join("verti-bench")))
        // Of Windows.
        .or_else(|| var("LOCALAPPDATA").map(|d| d.join("verti-bench")))
}

/// The folders of this name in the directories above a path, the nearest first.
fn above(path: &Path, name: &str) -> Vec<PathBuf> {
    path.ancestors().skip(1).map(|dir| dir.join(name)).filter(|dir| dir.is_dir()).collect()
}

/// The file of the program that is running; where it is a link, what it leads to.
fn program() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    // Windows has hardly any links, and names what it resolves in a way that takes no `/`.
    let resolved = (!cfg!(windows)).then(|| program.canonicalize().ok()).flatten();
    Some(resolved.unwrap_or(program))
}

fn has_planners(dir: &Path) -> bool {
    let is_planner = |entry: std::fs::DirEntry| entry.path().extension().is_some_and(|e| e == "wasm");
    std::fs::read_dir(dir).is_ok_and(|mut entries| entries.any(|entry| entry.is_ok_and(is_planner)))
}

fn var(name: &str) -> Option<PathBuf> {
    std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_above_a_file_are_found_from_the_nearest_on_and_files_are_none() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for folder in ["plugins", "a/b/plugins", "a/b/c"] {
            std::fs::create_dir_all(at(folder)).unwrap();
        }
        std::fs::write(at("a/plugins"), "").unwrap();
        let found = above(&at("a/b/c/program"), "plugins");
        assert_eq!(found[..2], [at("a/b/plugins"), at("plugins")]);
        // Sources of planners are no planners.
        assert!(!has_planners(&at("plugins")));
        std::fs::write(at("plugins/pid.wasm"), "").unwrap();
        assert!(has_planners(&at("plugins")));
        assert!(!has_planners(&at("none")));
    }
}
