//! The archive of a release for one system: the program with tasks and planners next to it. And the program installed for this
//! user.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::{Compression, GzBuilder};
use sha2::{Digest as _, Sha256};

use crate::licences;
use crate::options::Options;
use crate::package::{self, copy_stripped, failure, planners, read, sources};
use crate::run::{Failure, cargo_program, output, remove, run, step};
use crate::targets::TASKS;
use crate::{built, default_plugin_dir, plugins, portable, target_dir};

/// Time of the files, s since 1970, without git and without `SOURCE_DATE_EPOCH`.
const TIME: u64 = 315_532_800;

/// Shells with completions, and their files.
const FOR_SHELLS: [(&str, &str); 4] = [
    ("bash", "vb-harness.bash"),
    ("zsh", "_vb-harness"),
    ("fish", "vb-harness.fish"),
    ("powershell", "_vb-harness.ps1"),
];
/// Folder of the manual pages.
const PAGES: &str = "man/man1";

/// Files of an archive by path: content and mode.
type Files = BTreeMap<String, (Vec<u8>, u32)>;

fn options(args: &[&str]) -> Result<Options, Failure> {
    Options::parse("release", args, "releases", None)
}

/// Makes the archive, and checks it if that is asked for.
pub(crate) fn release(args: &[&str]) -> Result<(), Failure> {
    let Options { target, check, out } = options(args)?;
    let out = std::path::absolute(&out).map_err(|e| Failure::new(format!("{}: {e}", out.display())))?;
    let host = host()?;
    let target = target.unwrap_or_else(|| host.clone());
    if check && target != host {
        return Err(Failure::new(format!("release --check: a program for {target} doesn't run on {host}")));
    }
    plugins::build_as_wasm(&default_plugin_dir())?;
    // By zig it runs on older Linux too, and is made for other systems.
    let is_portable = target.contains("linux") || target != host;
    let program = if is_portable {
        let tools = portable::tools()?;
        portable::add_target(&target)?;
        portable::program(&target, &tools, &[])?
    } else {
        crate::build_harness()?;
        built("vb-harness")
    };
    let shell = if target == host {
        for_shells(&program)?
    } else {
        // A program for another system can't be asked; this one's says the same.
        crate::build_harness()?;
        for_shells(&built("vb-harness"))?
    };
    step(&format!("making the archive for {target}"));
    std::fs::create_dir_all(&out).map_err(failure(&out))?;
    let archive = write(&out, &target, &files(&program, &shell, &target)?)?;
    sums(&out)?;
    let size = std::fs::metadata(&archive).map_or(0, |m| m.len());
    step(&format!("{}: {:.1} MB", archive.display(), size as f64 / 1e6));
    if check { self::check(&archive, &target) } else { Ok(()) }
}

/// Returns the files of the archive.
fn files(program: &Path, shell: &Path, target: &str) -> Result<Files, Failure> {
    let mut files = Files::new();
    let mut add = |path: &Path, content, mode| {
        // Archives have forward slashes on all systems.
        files.insert(path.to_string_lossy().replace('\\', "/"), (content, mode));
    };
    let stripped = target_dir().join("stripped");
    copy_stripped(program, &stripped)?;
    add(Path::new(portable::program_name(target)), read(&stripped)?, 0o755);
    for file in sources("tasks")? {
        add(&file, read(&crate::root().join(&file))?, 0o644);
    }
    for (path, content) in package::sdk()? {
        add(&Path::new("sdk").join(path), content, 0o644);
    }
    for file in planners()? {
        add(&Path::new("plugins").join(file.file_name().unwrap_or_default()), read(&file)?, 0o644);
    }
    for file in FOR_SHELLS.iter().map(|(_, file)| format!("completions/{file}")) {
        add(Path::new(&file), read(&shell.join(&file))?, 0o644);
    }
    let pages = shell.join(PAGES);
    for entry in std::fs::read_dir(&pages).map_err(failure(&pages))?.flatten() {
        add(&Path::new(PAGES).join(entry.file_name()), read(&entry.path())?, 0o644);
    }
    for file in package::documents()? {
        add(&file, read(&crate::root().join(&file))?, 0o644);
    }
    add(Path::new("LICENSE-THIRD-PARTY.txt"), licences::text(target)?.into_bytes(), 0o644);
    Ok(files)
}

/// Writes the archive into a folder, with equal bytes for equal files, and returns its path.
fn write(out: &Path, target: &str, files: &Files) -> Result<PathBuf, Failure> {
    let name = format!("vertibench-{}-{target}", env!("CARGO_PKG_VERSION"));
    let archive = out.join(format!("{name}.tar.gz"));
    let time = time();
    let file = File::create(&archive).map_err(failure(&archive))?;
    let gzip = GzBuilder::new().mtime(u32::try_from(time).unwrap_or(0)).write(file, Compression::best());
    let mut tar = tar::Builder::new(gzip);
    for (path, (content, mode)) in files {
        let mut header = tar::Header::new_gnu();
        header.set_size(content.len() as u64);
        header.set_mode(*mode);
        header.set_mtime(time);
        tar.append_data(&mut header, format!("{name}/{path}"), &content[..]).map_err(failure(&archive))?;
    }
    tar.into_inner().and_then(|gzip| gzip.finish()).map_err(failure(&archive))?;
    Ok(archive)
}

/// Returns the time of the files, s since 1970.
fn time() -> u64 {
    let set = std::env::var("SOURCE_DATE_EPOCH").ok();
    let commit =
        || output(Command::new("git").args(["log", "-1", "--format=%ct"]).current_dir(crate::root()));
    set.or_else(commit).and_then(|time| time.parse().ok()).unwrap_or(TIME)
}

/// Writes `SHA256SUMS` of all archives and wheels in a folder, for `sha256sum --check`.
fn sums(out: &Path) -> Result<(), Failure> {
    let mut lines = BTreeMap::new();
    for entry in std::fs::read_dir(out).map_err(failure(out))?.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".tar.gz") || name.ends_with(".whl") {
            let digest = Sha256::digest(read(&entry.path())?);
            let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
            lines.insert(name.clone(), format!("{hex}  {name}\n"));
        }
    }
    let file = out.join("SHA256SUMS");
    std::fs::write(&file, lines.into_values().collect::<String>()).map_err(failure(&file))
}

/// Installs the program as `cargo install` does, and planners where it finds them.
pub(crate) fn install() -> Result<(), Failure> {
    plugins::build_as_wasm(&default_plugin_dir())?;
    let mut command = Command::new(cargo_program());
    command.args(["install", "--locked", "--path", "harness/cli"]).current_dir(crate::root());
    run(&mut command)?;
    let files = plugins::to_drive_with()?;
    let files = files.iter().map(|name| default_plugin_dir().join(format!("{name}.wasm")));
    run(Command::new(installed()).args(["plugin", "install", "--force"]).args(files))
}

/// Where cargo installs the program.
fn installed() -> PathBuf {
    let named = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = named("CARGO_INSTALL_ROOT").or_else(|| named("CARGO_HOME"));
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    home.join("bin").join(format!("vb-harness{}", std::env::consts::EXE_SUFFIX))
}

/// The system that this compiler is for.
pub(crate) fn host() -> Result<String, Failure> {
    let told = output(Command::new("rustc").arg("-vV")).unwrap_or_default();
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| Failure::new("`rustc -vV` doesn't name its host"))
}

/// A folder with what shells and `man` know of the program, as it lies in the archive.
fn for_shells(program: &Path) -> Result<PathBuf, Failure> {
    let folder = target_dir().join("shell");
    let failure = |e: std::io::Error| Failure::new(format!("{}: {e}", folder.display()));
    remove(&folder)?;
    std::fs::create_dir_all(folder.join("completions")).map_err(failure)?;
    for (shell, file) in FOR_SHELLS {
        let script = Command::new(program).args(["completions", shell]).output().map_err(failure)?;
        if !script.status.success() {
            return Err(Failure::new(format!("{} completions {shell} failed", program.display())));
        }
        std::fs::write(folder.join("completions").join(file), script.stdout).map_err(failure)?;
    }
    run(Command::new(program).args(["man", "--out"]).arg(folder.join(PAGES)))?;
    Ok(folder)
}

/// Unpacks the archive and lets the program drive a task with what lies beside it, called by a user who has nothing else.
fn check(archive: &Path, target: &str) -> Result<(), Failure> {
    step("trying the archive in an empty folder");
    let folder = target_dir().join("release-check");
    let failure = |e: std::io::Error| Failure::new(format!("{}: {e}", folder.display()));
    remove(&folder)?;
    std::fs::create_dir_all(folder.join("empty")).map_err(failure)?;
    run(Command::new("tar").arg("xzf").arg(archive).arg("-C").arg(&folder))?;
    let name = archive.file_name().unwrap_or_default().to_string_lossy();
    let inner = folder.join(name.trim_end_matches(".tar.gz"));
    let mut command = Command::new(inner.join(portable::program_name(target)));
    // One after the other, so that the records have an order, too.
    command
        .args(["--plugin", "pid.wasm", "--suite", "smoke", "--tasks", TASKS, "--jobs", "1", "--out", "run"]);
    command.current_dir(folder.join("empty")).env("HOME", folder.join("empty"));
    command.env("VB_DATA", folder.join("data")).env_remove("VB_TASKS").env_remove("VB_PLUGINS");
    run(&mut command)?;
    let mut project = Command::new(inner.join(portable::program_name(target)));
    project.args(["plugin", "new", "fox", "--lang", "rust"]).current_dir(folder.join("empty"));
    run(&mut project)?;
    if folder.join("data").exists() {
        return Err(Failure::new("the program unpacked tasks, although they lie beside it"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_in_any_order() {
        let plain = options(&[]).unwrap();
        assert_eq!((plain.target, plain.check), (None, false));
        let both = options(&["--check", "--out", "dist", "--target", "x"]).unwrap();
        assert_eq!(
            (both.check, both.out.as_path(), both.target.as_deref()),
            (true, Path::new("dist"), Some("x"))
        );
        assert!(options(&["--out"]).unwrap_err().to_string().contains("its value is missing"));
        assert!(options(&["--portable"]).unwrap_err().to_string().contains("--portable"));
    }

    #[test]
    fn equal_files_give_equal_archives_and_checksums() {
        let dir = tempfile::tempdir().unwrap();
        let long = format!("tasks/{}/world.yaml", "w".repeat(120));
        let files: Files = [
            ("vb-harness".to_owned(), (b"#!".to_vec(), 0o755)),
            ("tasks/smoke/suite.yaml".to_owned(), (b"a: 1".to_vec(), 0o644)),
            (long.clone(), (b"b: 2".to_vec(), 0o644)),
        ]
        .into();
        let made = ["a", "b"].map(|name| {
            let out = dir.path().join(name);
            std::fs::create_dir(&out).unwrap();
            let archive = write(&out, "x86_64-unknown-linux-gnu", &files).unwrap();
            sums(&out).unwrap();
            (std::fs::read(&archive).unwrap(), std::fs::read_to_string(out.join("SHA256SUMS")).unwrap())
        });
        assert_eq!(made[0], made[1]);
        let name = format!("vertibench-{}-x86_64-unknown-linux-gnu", env!("CARGO_PKG_VERSION"));
        assert!(made[0].1.len() > 66 && made[0].1.ends_with(&format!("  {name}.tar.gz\n")), "{}", made[0].1);
        let mut tar = tar::Archive::new(flate2::read::GzDecoder::new(&made[0].0[..]));
        let modes: BTreeMap<String, u32> = tar
            .entries()
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|entry| {
                (entry.path().unwrap().to_string_lossy().into_owned(), entry.header().mode().unwrap())
            })
            .collect();
        let at = |path: &str| modes[&format!("{name}/{path}")];
        assert_eq!((at("vb-harness"), at("tasks/smoke/suite.yaml"), at(&long)), (0o755, 0o644, 0o644));
    }

    #[test]
    fn the_compiler_names_its_host() {
        assert!(host().unwrap().contains(std::env::consts::ARCH));
    }
}
