//! The archive of a release for one system, and the program installed for this user. What is put into the archive, and how, is
//! said in `harness/python/build_backend/vertibench_build/_release.py`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::examples::python;
use crate::options::Options;
use crate::run::{Failure, cargo_program, output, remove, run, step};
use crate::targets::TASKS;
use crate::{built, default_plugin_dir, plugins, portable, target_dir};

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
    let mut command = Command::new(python());
    command.args(["-B", "-m", "vertibench_build", "release"]).arg(&out).current_dir(crate::root());
    command.env("PYTHONPATH", crate::root().join("harness/python/build_backend"));
    command.env("VB_RELEASE_TARGET", &target).env("VB_RELEASE_SHELL", shell);
    command.env("VB_WHEEL_HARNESS", &program);
    command.env("VB_WHEEL_PLUGINS", default_plugin_dir());
    let archive = output(command.stderr(Stdio::inherit()))
        .and_then(|told| told.lines().last().map(PathBuf::from))
        .ok_or_else(|| Failure::new("can't make the archive (the reason is told above)"))?;
    let size = std::fs::metadata(&archive).map_or(0, |m| m.len());
    step(&format!("{}: {:.1} MB", archive.display(), size as f64 / 1e6));
    if check { self::check(&archive, &target) } else { Ok(()) }
}

/// Installs the program as `cargo install` does, and planners where it finds them.
pub(crate) fn install() -> Result<(), Failure> {
    plugins::build_as_wasm(&default_plugin_dir())?;
    let mut command = Command::new(cargo_program());
    command.args(["install", "--locked", "--path", "harness/cli"]).current_dir(crate::root());
    run(&mut command)?;
    let files = plugins::to_drive_with()?;
    let files = files.iter().map(|name| default_plugin_dir().join(format!("{name}.wasm")));
    run(Command::new(installed()).args(["plugin", "install"]).args(files))
}

/// Where cargo installs the program.
fn installed() -> PathBuf {
    let named = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = named("CARGO_INSTALL_ROOT").or_else(|| named("CARGO_HOME"));
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    home.join("bin").join(format!("vb-harness{}", std::env::consts::EXE_SUFFIX))
}

/// The system that this compiler is for.
fn host() -> Result<String, Failure> {
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
    for (shell, file) in [
        ("bash", "vb-harness.bash"),
        ("zsh", "_vb-harness"),
        ("fish", "vb-harness.fish"),
        ("powershell", "_vb-harness.ps1"),
    ] {
        let script = Command::new(program).args(["completions", shell]).output().map_err(failure)?;
        if !script.status.success() {
            return Err(Failure::new(format!("{} completions {shell} failed", program.display())));
        }
        std::fs::write(folder.join("completions").join(file), script.stdout).map_err(failure)?;
    }
    run(Command::new(program).args(["man", "--out"]).arg(folder.join("man/man1")))?;
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
    fn the_compiler_names_its_host() {
        assert!(host().unwrap().contains(std::env::consts::ARCH));
    }
}
