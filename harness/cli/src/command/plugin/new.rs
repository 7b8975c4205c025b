//! `vb-harness plugin new`: makes a project for a planner.

use std::path::{Path, PathBuf};

use clap::Args;
use vb_sdk::metadata::is_name;

use super::template::{self, File, Language};
use crate::error::CliError;
use crate::{output, places};

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Planner name: a-z, 0-9, - and _
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Programming language
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub(crate) lang: Language,
    /// Directory for the project; default: NAME
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
    /// For Rust: the SDK, a directory or a git URL; default: the directory sdk next to the built-in tasks
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) sdk: Option<String>,
}

/// Letters of a name at most: files and folders are named by it.
const NAME_MAX: usize = 64;
/// Names that cargo or the compiler keeps for itself.
const RESERVED: [&str; 7] = ["alloc", "core", "proc-macro", "proc_macro", "std", "test", "vb-sdk"];

/// Makes the project and says how to go on.
pub(crate) fn new(args: &NewArgs) -> Result<(), CliError> {
    check_name(&args.name)?;
    let sdk = match args.lang {
        Language::Rust => sdk(args.sdk.as_deref())?,
        _ if args.sdk.is_some() => {
            return Err(CliError::usage(
                "--sdk applies to --lang rust; other languages contain the interface in wit/",
            ));
        }
        _ => String::new(),
    };
    let dir = args.dir.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    write(&dir, &template::files(args.lang, &args.name, &sdk))?;
    output::text(&format!(
        "{}: a planner template; its README.md describes how to build and run it\n",
        dir.display()
    ));
    Ok(())
}

fn check_name(name: &str) -> Result<(), CliError> {
    let starts_well = name.starts_with(|c: char| c.is_ascii_lowercase());
    if is_name(name) && starts_well && name.len() <= NAME_MAX && !RESERVED.contains(&name) {
        return Ok(());
    }
    Err(CliError::usage(format!(
        "{name:?} is not a valid planner name: use up to {NAME_MAX} of a-z, 0-9, - and _, starting with a letter, and no \
         Rust crate name such as core"
    )))
}

/// Where cargo finds the SDK: as the user says, else in the checkout that the harness comes from.
fn sdk(wanted: Option<&str>) -> Result<String, CliError> {
    let key = |key: &str, value: &str| format!("{key} = {}", serde_json::Value::from(value));
    if let Some(url) = wanted.filter(|w| w.contains("://") || w.starts_with("git@")) {
        return Ok(key("git", url));
    }
    let dir = match wanted {
        Some(path) => PathBuf::from(path),
        None => places::sdk().ok_or_else(|| {
            CliError::input("the SDK was not found next to the built-in tasks; give its folder with --sdk")
        })?,
    };
    if !dir.join("Cargo.toml").is_file() {
        return Err(CliError::input(format!(
            "{}: it has no Cargo.toml of the SDK; give --sdk the folder `sdk` of a checkout, or a git URL",
            dir.display()
        )));
    }
    let dir = std::fs::canonicalize(&dir).map_err(|e| CliError::input(format!("{}: {e}", dir.display())))?;
    match dir.to_str() {
        // JSON's quotes and escapes are TOML's too.
        Some(path) => Ok(key("path", path)),
        None => Err(CliError::input(format!("{}: cargo needs a UTF-8 path", dir.display()))),
    }
}

/// Writes a project into a folder that isn't there or is empty.
fn write(dir: &Path, files: &[File]) -> Result<(), CliError> {
    let failed = |path: &Path, e: std::io::Error| CliError::output(format!("{}: {e}", path.display()));
    let is_free = match std::fs::read_dir(dir) {
        Ok(mut entries) => entries.next().is_none(),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => true,
        Err(e) => return Err(failed(dir, e)),
    };
    if !is_free {
        return Err(CliError::output(format!(
            "{}: files already exist and are not overwritten; choose another place with --dir",
            dir.display()
        )));
    }
    for file in files {
        let path = dir.join(file.path);
        let folder = path.parent().unwrap_or(dir);
        std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
        vb_files::write(&path, &file.content).map_err(|e| failed(&path, e))?;
        if file.executable {
            make_executable(&path).map_err(|e| failed(&path, e))?;
        }
    }
    Ok(())
}

#[cfg(unix)]
fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = std::fs::metadata(path)?.permissions().mode();
    // Whoever may read it may run it.
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode | (mode & 0o444) >> 2))
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_files_crates_and_the_harness_take() {
        assert!(["a", "mppi-6", "my_planner"].into_iter().all(|n| check_name(n).is_ok()));
        let long = "a".repeat(NAME_MAX + 1);
        for name in ["", "-a", "6a", "A", "a b", "../a", "a/b", "a.b", "core", "é", &long] {
            let e = check_name(name).unwrap_err().to_string();
            assert!(e.contains(&format!("{name:?}")) && e.lines().count() == 1, "{e}");
        }
    }

    #[test]
    fn the_sdk_is_a_folder_or_a_repository() {
        assert_eq!(sdk(Some("https://example.org/vb")).unwrap(), "git = \"https://example.org/vb\"");
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().canonicalize().unwrap();
        let text = path.to_str().unwrap();
        assert!(sdk(Some(text)).unwrap_err().to_string().contains("no Cargo.toml"));
        std::fs::write(path.join("Cargo.toml"), "").unwrap();
        assert_eq!(sdk(Some(text)).unwrap(), format!("path = \"{text}\""));
    }

    #[test]
    fn nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let file = |content: &str| File { path: "a/b.txt", content: content.into(), executable: false };
        let project = dir.path().join("p");
        write(&project, &[file("first")]).unwrap();
        let e = write(&project, &[file("second")]).unwrap_err().to_string();
        assert!(e.contains("are not overwritten"), "{e}");
        assert_eq!(std::fs::read_to_string(project.join("a/b.txt")).unwrap(), "first");
        // An empty folder is as good as none; a file is no folder.
        std::fs::create_dir(dir.path().join("empty")).unwrap();
        write(&dir.path().join("empty"), &[file("x")]).unwrap();
        std::fs::write(dir.path().join("file"), "").unwrap();
        assert!(write(&dir.path().join("file"), &[file("x")]).is_err());
    }
}
