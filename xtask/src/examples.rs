//! Building the example planners that are written in other languages, each by its own `build.sh`.
//!
//! A compiler is installed from the registry of its language, in the version that the example's own files pin, into a
//! folder of the cache that is named by it.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::SystemTime;

use crate::run::{Failure, run, step};

/// Where a compiler comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Registry {
    /// Of `requirements.txt`, by pip.
    Pip,
    /// Of `package.json`, by npm.
    Npm,
}

/// The examples: folders below `examples`.
const EXAMPLES: [(&str, Registry); 3] =
    [("pursuit-c", Registry::Pip), ("pursuit-js", Registry::Npm), ("pursuit-python", Registry::Pip)];

/// Set to 1 where a missing compiler is to be installed and may not be skipped: in CI.
const ALL_VAR: &str = "VB_LANGUAGES";

/// Installs what is missing and builds all examples into `out`.
pub(crate) fn build(out: &Path) -> Result<(), Failure> {
    EXAMPLES.iter().try_for_each(|(name, registry)| {
        let compiler = Compiler::of(name, *registry)?;
        compiler.install()?;
        build_one(name, &compiler, out)
    })
}

/// Builds the examples whose compiler is there; all of them where `VB_LANGUAGES` is 1.
pub(crate) fn build_available(out: &Path) -> Result<(), Failure> {
    if std::env::var_os(ALL_VAR).is_some_and(|v| v == "1") {
        return build(out);
    }
    for (name, registry) in EXAMPLES {
        let compiler = Compiler::of(name, registry)?;
        if compiler.is_installed() {
            build_one(name, &compiler, out)?;
        } else {
            step(&format!("skipping {name}: {} is missing; get it by `cargo xtask examples`", compiler.name));
        }
    }
    Ok(())
}

fn build_one(name: &str, compiler: &Compiler, out: &Path) -> Result<(), Failure> {
    let folder = crate::root().join("examples").join(name);
    let failure = |e: std::io::Error| Failure::new(format!("{}: {e}", folder.display()));
    std::fs::create_dir_all(out).map_err(|e| Failure::new(format!("can't make {}: {e}", out.display())))?;
    let plugin = std::path::absolute(out.join(format!("{name}.wasm"))).map_err(failure)?;
    let built = std::fs::metadata(&plugin).and_then(|m| m.modified()).ok();
    if built > Some(newest(&folder).map_err(failure)?) {
        return Ok(());
    }
    step(&format!("building {name}"));
    let harness = std::path::absolute(crate::built("vb-harness")).map_err(failure)?;
    let mut command = Command::new("bash");
    command.arg("build.sh").arg(&plugin).current_dir(&folder).env("VB_HARNESS", harness);
    run(compiler.environment(&mut command).stdout(Stdio::null()))?;
    step(&format!("{name}: {}", plugin.display()));
    Ok(())
}

/// When the newest file of a project was changed, but for those that were built.
fn newest(folder: &Path) -> std::io::Result<SystemTime> {
    let mut newest = SystemTime::UNIX_EPOCH;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if ["build", "node_modules", "__pycache__"].iter().any(|n| entry.file_name() == *n) {
            continue;
        }
        // Links are followed: the interface's text is one.
        let meta = std::fs::metadata(entry.path())?;
        newest = newest.max(if meta.is_dir() { self::newest(&entry.path())? } else { meta.modified()? });
    }
    Ok(newest)
}

/// A compiler, or another program that builds, of a pinned version.
#[derive(Debug)]
pub(crate) struct Compiler {
    /// Name and version, e.g. `ziglang-0.17.0`.
    name: String,
    /// What the registry's client is asked for, e.g. `ziglang==0.17.0`.
    wanted: String,
    registry: Registry,
    /// Where it is installed.
    pub(crate) folder: PathBuf,
}

impl Compiler {
    fn of(example: &str, registry: Registry) -> Result<Self, Failure> {
        let folder = crate::root().join("examples").join(example);
        let read = |file: &str| {
            let path = folder.join(file);
            let text = std::fs::read_to_string(&path);
            text.map_err(|e| Failure::new(format!("{}: {e}", path.display()))).map(|text| (path, text))
        };
        let (path, pinned) = match registry {
            Registry::Pip => read("requirements.txt").map(|(path, text)| (path, pip_pin(&text)))?,
            Registry::Npm => read("package.json").map(|(path, text)| (path, npm_pin(&text)))?,
        };
        let pin = pinned
            .ok_or_else(|| Failure::new(format!("{}: it pins no compiler's version", path.display())))?;
        Self::new(pin, registry)
    }

    /// What pip installs: `maturin==1.16.0`.
    pub(crate) fn of_pip(pin: &str) -> Result<Self, Failure> {
        let read = pip_pin(pin).ok_or_else(|| Failure::new(format!("{pin}: it pins no version")))?;
        Self::new(read, Registry::Pip)
    }

    fn new((package, version): (String, String), registry: Registry) -> Result<Self, Failure> {
        let wanted = match registry {
            Registry::Pip => format!("{package}=={version}"),
            Registry::Npm => format!("{package}@{version}"),
        };
        let name = format!("{package}-{version}");
        let folder = cache()?.join(&name);
        Ok(Self { name, wanted, registry, folder })
    }

    fn is_installed(&self) -> bool {
        self.folder.is_dir()
    }

    /// Installs it where it is missing.
    pub(crate) fn install(&self) -> Result<(), Failure> {
        if self.is_installed() {
            return Ok(());
        }
        step(&format!("installing {}", self.name));
        // Whole or not at all: what was interrupted is no compiler.
        let new = self.folder.with_file_name(format!(".{}-{}", self.name, std::process::id()));
        let failure = |e: std::io::Error| Failure::new(format!("{}: {e}", new.display()));
        std::fs::create_dir_all(&new).map_err(failure)?;
        let mut command = match self.registry {
            Registry::Pip => {
                let mut command = Command::new(python());
                command.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
                command.args(["--no-cache-dir", "--root-user-action", "ignore", "--target"]).arg(&new);
                command
            }
            Registry::Npm => {
                std::fs::write(new.join("package.json"), "{ \"private\": true }\n").map_err(failure)?;
                let mut command = Command::new("npm");
                command.args(["install", "--silent", "--no-audit", "--no-fund", "--prefix"]).arg(&new);
                command
            }
        };
        run(command.arg(&self.wanted)).map_err(|e| {
            // Best effort: the folder is in the cache and has a name of its own.
            let _ = std::fs::remove_dir_all(&new);
            Failure::new(format!(
                "{e}; python3 with pip and npm must be there, and their registries in reach"
            ))
        })?;
        std::fs::rename(&new, &self.folder).map_err(failure)
    }

    /// Lets a command find the compiler.
    fn environment<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        let programs = match self.registry {
            Registry::Pip => {
                command.env("PYTHONPATH", &self.folder).env("PYTHON", python());
                self.folder.join("bin")
            }
            Registry::Npm => self.folder.join("node_modules/.bin"),
        };
        command.env("PATH", first_in_path(&programs, std::env::var_os("PATH").as_deref()))
    }
}

/// Python as the user wants it.
pub(crate) fn python() -> OsString {
    std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into())
}

fn first_in_path(folder: &Path, path: Option<&OsStr>) -> OsString {
    let rest = path.map(std::env::split_paths).into_iter().flatten();
    // A folder whose name holds the separator can't be in the path at all.
    std::env::join_paths([folder.to_owned()].into_iter().chain(rest)).unwrap_or_default()
}

/// The folder of compilers: `$XDG_CACHE_HOME/verti-bench/languages`, or below `~/.cache`.
fn cache() -> Result<PathBuf, Failure> {
    let set = std::env::var_os("XDG_CACHE_HOME").filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = set.or_else(|| std::env::home_dir().map(|home| home.join(".cache")));
    let base = base.ok_or_else(|| Failure::new("there is no home for the cache; set XDG_CACHE_HOME"))?;
    Ok(base.join("verti-bench/languages"))
}

/// Package and version of the first line of a pip requirements file.
fn pip_pin(text: &str) -> Option<(String, String)> {
    let (package, version) = text.lines().next()?.trim().split_once("==")?;
    Some((package.to_owned(), version.to_owned()))
}

/// Package and version of the one development dependency in npm's `package.json`.
fn npm_pin(text: &str) -> Option<(String, String)> {
    let document: serde_json::Value = serde_json::from_str(text).ok()?;
    let (package, version) = document.get("devDependencies")?.as_object()?.iter().next()?;
    Some((package.clone(), version.as_str()?.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_pins_its_compiler() {
        for (name, registry) in EXAMPLES {
            let compiler = Compiler::of(name, registry).unwrap();
            let exact = compiler.name.rsplit('-').next().unwrap();
            assert!(exact.split('.').all(|n| n.parse::<u32>().is_ok()), "{name}: {}", compiler.name);
        }
    }

    #[test]
    fn pins_are_read_from_the_files_that_users_install_from() {
        let pin = |p: &str, v: &str| Some((p.to_owned(), v.to_owned()));
        assert_eq!(pip_pin("ziglang==0.17.0\n"), pin("ziglang", "0.17.0"));
        assert_eq!(pip_pin("ziglang\n"), None);
        assert_eq!(npm_pin(r#"{"devDependencies": {"a": "1.2.3"}}"#), pin("a", "1.2.3"));
        assert_eq!(npm_pin("{}"), None);
    }

    #[test]
    fn a_project_is_as_new_as_its_newest_file_that_was_not_built() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, seconds: u64| {
            let path = dir.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            let file = std::fs::File::create(path).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds)).unwrap();
        };
        write("a.c", 10);
        write("gen/b.c", 20);
        write("build/a.wasm", 30);
        let age = newest(dir.path()).unwrap().duration_since(SystemTime::UNIX_EPOCH).unwrap();
        assert_eq!(age.as_secs(), 20);
    }

    #[test]
    fn the_compiler_comes_first_in_the_path() {
        let path = first_in_path(Path::new("/c/bin"), Some(OsStr::new("/usr/bin:/bin")));
        #[cfg(unix)]
        assert_eq!(path, OsString::from("/c/bin:/usr/bin:/bin"));
        assert!(!path.is_empty());
    }
}
