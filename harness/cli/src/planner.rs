//! The planner of a command line: a plugin file, a recording, or a command.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use vb_host::{Limits, LoadError, Plugin, ProcessOptions, SandboxReport};
use vb_record::Recording;

use crate::error::CliError;
use crate::{output, places};

/// The environment variable that lets native planners run where the system can't confine them at all, if it is 1.
const UNCONFINED_VAR: &str = "VB_UNCONFINED";

/// The environment variable that names the program to start in place of this one for planners' processes: a script that starts
/// this one where the system can't by itself, as in an emulator.
const WORKER_VAR: &str = "VB_WORKER";

/// Loads a plugin file or starts a command, and says on stderr what isn't confined as it should be.
pub(crate) fn load(wanted: &Path, limits: &Limits, require_sandbox: bool) -> Result<Plugin, LoadError> {
    if command(wanted).is_some() {
        output::say("note: a command is not sandboxed, and its results are not eligible for ranking");
    }
    let plugin = load_quietly(wanted, limits, require_sandbox)?;
    let missing = plugin.sandbox().map(SandboxReport::missing).unwrap_or_default();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        output::say(&format!(
            "warning: this system cannot sandbox native planners with {missing}; run only trusted planners, or \
             reject them with --require-sandbox"
        ));
    }
    Ok(plugin)
}

/// Loads a plugin file or starts a command.
pub(crate) fn load_quietly(
    wanted: &Path,
    limits: &Limits,
    require_sandbox: bool,
) -> Result<Plugin, LoadError> {
    let unconfined = std::env::var_os(UNCONFINED_VAR).is_some_and(|v| v == "1");
    let worker = std::env::var_os(WORKER_VAR).filter(|v| !v.is_empty()).map(PathBuf::from);
    let native = ProcessOptions { worker, require_sandbox, unconfined };
    match command(wanted) {
        Some(words) => Plugin::command(&words, limits),
        None if Recording::is_one(wanted) => vb_runner::recorded(wanted, limits),
        None => Plugin::load_with(wanted, limits, vb_catalog::cache_dir().as_deref(), &native),
    }
}

/// Why a plugin can't be used. Of a bare file name it is said where else it was looked for.
pub(crate) fn unusable(e: &LoadError) -> CliError {
    let elsewhere = match e {
        LoadError::NotFound { path } if places::is_bare(path) => {
            let dirs = vb_catalog::planner_dirs();
            let near = [PathBuf::from(".")]
                .into_iter()
                .chain(dirs.iter().cloned())
                .find_map(|dir| meant(path, &dir));
            near.unwrap_or_else(|| elsewhere(&dirs))
        }
        _ => String::new(),
    };
    CliError::input(format!("{e}{elsewhere} ({})", e.code()))
}

/// The file of a folder whose name is that of a planner without its ending, or differs in case alone.
fn meant(wanted: &Path, dir: &Path) -> Option<String> {
    let wanted = wanted.to_str()?.to_lowercase();
    let mut names: Vec<String> = std::fs::read_dir(dir)
        .ok()?
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    names.sort();
    let is_planner = |name: &str| [".wasm", ".so", ".dylib", ".dll"].iter().any(|end| name.ends_with(end));
    let plain = |name: &str| {
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        stem.strip_prefix("lib").unwrap_or(stem).to_lowercase()
    };
    let fits = |name: &&String| is_planner(name) && (name.to_lowercase() == wanted || plain(name) == wanted);
    // WASM first: results of it may be ranked.
    let found = names.iter().filter(fits).min_by_key(|name| !name.ends_with(".wasm"))?;
    Some(format!("; did you mean {found}?"))
}

/// Where a planner was looked for beside the working directory, and how it gets there.
fn elsewhere(dirs: &[PathBuf]) -> String {
    let named: Vec<_> = dirs.iter().map(|dir| dir.display().to_string()).collect();
    let variable = vb_catalog::PLUGINS_VAR;
    match &named[..] {
        [] => {
            "; no planners are installed: give a path, or install planners with `vb-harness plugin install`"
                .to_owned()
        }
        [one] if std::env::var_os(variable).is_some_and(|v| !v.is_empty()) => {
            format!("; it is not in {one} ({variable}) either")
        }
        _ => {
            format!("; it is not in {} either", named.join(", "))
        }
    }
}

/// Refuses a command where the user demands a sandbox.
pub(crate) fn can_be_confined(wanted: &Path, require_sandbox: bool) -> Result<(), CliError> {
    if require_sandbox && command(wanted).is_some() {
        return Err(CliError::usage("--require-sandbox: a command cannot be sandboxed (give a WASM file)"));
    }
    Ok(())
}

/// The words of a command: `wanted` is no file, has more than one word, as a shell splits them, and the first is a
/// program.
pub(crate) fn command(wanted: &Path) -> Option<Vec<OsString>> {
    if wanted.exists() {
        return None;
    }
    let words = shlex::split(wanted.to_str()?)?;
    let program = words.first().filter(|_| words.len() > 1)?;
    is_program(Path::new(program)).then(|| words.into_iter().map(OsString::from).collect())
}

fn is_program(name: &Path) -> bool {
    if name.components().count() != 1 {
        return is_executable(name);
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let mut files = std::env::split_paths(&folders).flat_map(|folder| candidates(&folder.join(name)));
    files.any(|file| is_executable(&file))
}

fn candidates(file: &Path) -> [PathBuf; 2] {
    [file.to_owned(), file.with_extension(std::env::consts::EXE_EXTENSION)]
}

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::metadata(file).is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    file.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_more_than_one_word_of_which_the_first_is_a_program() {
        let words = |text: &str| command(Path::new(text)).map(|w| w.join("|".as_ref()));
        assert_eq!(words("sh my_planner.sh --fast").unwrap(), "sh|my_planner.sh|--fast");
        assert_eq!(words("/bin/sh 'my planner.sh'").unwrap(), "/bin/sh|my planner.sh");
        // A file that isn't there, no program, a word alone, a quote without its end.
        for text in ["planners/pid.wasm", "no-such-program-here x", "sh", "sh 'x", ""] {
            assert_eq!(words(text), None, "{text}");
        }
    }

    #[test]
    fn a_planner_s_name_without_its_ending_is_told_with_it() {
        let dir = tempfile::tempdir().unwrap();
        for file in ["pid.wasm", "libpid.so", "libtnt.so", "pid.txt"] {
            std::fs::write(dir.path().join(file), "").unwrap();
        }
        let said = |name: &str| meant(Path::new(name), dir.path());
        assert_eq!(said("pid").as_deref(), Some("; did you mean pid.wasm?"));
        assert_eq!(said("PID.wasm").as_deref(), Some("; did you mean pid.wasm?"));
        assert_eq!(said("tnt").as_deref(), Some("; did you mean libtnt.so?"));
        assert_eq!(said("mppi"), None);
    }

    #[test]
    fn a_file_is_a_file_whatever_its_name() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("sh x");
        std::fs::write(&file, "").unwrap();
        assert_eq!(command(&file), None);
    }
}
