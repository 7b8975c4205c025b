//! The Python package: its wheel (`docs/python.md`).
//!
//! maturin builds the module and writes the wheel. It builds no other programs, so the package is put together before, in
//! `target/wheel`: sources, program, tasks, planners and licences.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::examples::{Compiler, python};
use crate::options::Options;
use crate::package::{self, copy_stripped, failure, planners, read, sources};
use crate::portable::{self, GLIBC};
use crate::release::host;
use crate::run::{Failure, remove, run, step};
use crate::{licences, plugins};

/// The environment variable that lets the check install what policies are trained with.
const TORCH_VAR: &str = "VB_TORCH";

/// Builder of wheels.
const MATURIN: &str = "maturin==1.16.0";
/// What a portable wheel is for if nothing is said.
const TARGET: &str = "x86_64-unknown-linux-gnu";

/// What is asked for, and the folder of the kernels for GPUs that the wheel gets.
fn options(args: &[&str]) -> Result<(Options, Option<PathBuf>), Failure> {
    let mut rest = args.to_vec();
    let kernels = match rest.iter().position(|arg| *arg == "--kernels") {
        Some(at) if at + 1 < rest.len() => rest.drain(at..at + 2).nth(1).map(PathBuf::from),
        Some(_) => return Err(Failure::new("wheel --kernels: its value is missing")),
        None => None,
    };
    Ok((Options::parse("wheel", &rest, "wheels", Some(TARGET))?, kernels))
}

/// Makes the wheel, and checks it if that is requested.
pub(crate) fn wheel(args: &[&str]) -> Result<(), Failure> {
    let (Options { target, check, out }, kernels) = options(args)?;
    let maturin = Compiler::of_pip(MATURIN)?;
    maturin.install()?;
    let mut tools = if target.is_some() { portable::tools()? } else { Vec::new() };
    tools.push(maturin);
    // As `cargo xtask test` builds them, so that nothing is built twice.
    plugins::build_as_wasm(&crate::default_plugin_dir())?;
    let program = match &target {
        None => {
            crate::build_harness()?;
            crate::built("vb-harness")
        }
        // Without the tasks within it, which lie beside it.
        Some(target) => portable::program(target, &tools, &["--no-default-features", "--features", "full"])?,
    };
    let folder = crate::target_dir().join("wheel");
    stage(&folder, &program, kernels.as_deref(), &target.clone().map_or_else(host, Ok)?)?;
    step("making the wheel of the Python package");
    let made = folder.join("made");
    let mut command = Command::new("maturin");
    command.args(["build", "--compression-level", "9", "--interpreter"]).arg(python());
    command.arg("--out").arg(&made).current_dir(&folder);
    match &target {
        None => {
            portable::find(&mut command, &tools);
            portable::flags_of_here(&mut command);
            // maturin would name the oldest Linux on which the module runs, but the program needs a newer one.
            command.args(["--compatibility", "linux"]);
        }
        Some(target) => {
            portable::environment(&mut command, target, &tools);
            let linux = format!("manylinux_{}", GLIBC.replace('.', "_"));
            command.args(["--zig", "--target", target, "--compatibility", &linux]);
        }
    }
    run(&mut command)?;
    let mut wheels = std::fs::read_dir(&made).map_err(failure(&made))?.flatten();
    let wheel = wheels.next().ok_or_else(|| Failure::new("maturin has made no wheel"))?;
    std::fs::create_dir_all(&out).map_err(failure(&out))?;
    let file = out.join(wheel.file_name());
    std::fs::copy(wheel.path(), &file).map_err(failure(&file))?;
    let size = std::fs::metadata(&file).map_or(0, |m| m.len());
    step(&format!("{}: {:.1} MB", file.display(), size as f64 / 1e6));
    if check { self::check(&file) } else { Ok(()) }
}

/// Puts the contents of the wheel for a system into a folder.
fn stage(folder: &Path, program: &Path, kernels: Option<&Path>, target: &str) -> Result<(), Failure> {
    remove(folder)?;
    let root = crate::root();
    let copy = |from: &Path, to: &Path| {
        let parent = to.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(failure(parent))?;
        std::fs::copy(from, to).map_err(failure(from)).map(drop)
    };
    let python = root.join("harness/python");
    for file in sources("harness/python/vertibench")? {
        copy(&root.join(&file), &folder.join(file.strip_prefix("harness/python").unwrap_or(&file)))?;
    }
    let planner = "sdk/python/src";
    for file in sources(planner)? {
        copy(&root.join(&file), &folder.join(file.strip_prefix(planner).unwrap_or(&file)))?;
    }
    let data = folder.join("vertibench/_data");
    for file in sources("tasks")? {
        copy(&root.join(&file), &data.join(&file))?;
    }
    for (path, content) in package::sdk()? {
        let file = data.join("sdk").join(path);
        let parent = file.parent().unwrap_or(&data);
        std::fs::create_dir_all(parent).map_err(failure(parent))?;
        std::fs::write(&file, content).map_err(failure(&file))?;
    }
    for file in planners()? {
        copy(&file, &data.join("plugins").join(file.file_name().unwrap_or_default()))?;
    }
    for file in kernels.map(of_gpu).transpose()?.unwrap_or_default() {
        copy(&file, &data.join("kernels").join(file.file_name().unwrap_or_default()))?;
    }
    std::fs::create_dir_all(data.join("bin")).map_err(failure(&data))?;
    copy_stripped(program, &data.join("bin").join(portable::program_name(target)))?;
    for file in ["LICENSE-APACHE", "LICENSE-MIT"] {
        copy(&root.join(file), &folder.join(file))?;
    }
    // Messages name the pages.
    for file in sources("docs")?.iter().filter(|file| file.extension().is_some_and(|e| e == "md")) {
        copy(&root.join(file), &folder.join("vertibench").join(file))?;
    }
    for (file, text) in [
        ("README.md", package::without_links(&String::from_utf8_lossy(&read(&python.join("README.md"))?))),
        ("LICENSE-THIRD-PARTY.txt", licences::text(target)?),
        ("pyproject.toml", description(&String::from_utf8_lossy(&read(&python.join("pyproject.toml"))?))?),
    ] {
        let file = folder.join(file);
        std::fs::write(&file, text).map_err(failure(&file))?;
    }
    Ok(())
}

/// Returns the package's `pyproject.toml` for the folder of the wheel: the manifest's path is absolute, and the SDK of planners, whose
/// sources lie elsewhere, is a second package.
fn description(text: &str) -> Result<String, Failure> {
    let manifest = crate::root().join("harness/python/Cargo.toml");
    let mut text = text.to_owned();
    for (line, new) in [
        ("manifest-path = \"Cargo.toml\"\n", format!("manifest-path = '{}'\n", manifest.display())),
        (
            "python-packages = [\"vertibench\"]\n",
            "python-packages = [\"vertibench\", \"vertibench_planner\"]\n".into(),
        ),
    ] {
        if text.matches(line).count() != 1 {
            return Err(Failure::new(format!(
                "harness/python/pyproject.toml: there must be one line `{}`",
                line.trim()
            )));
        }
        text = text.replace(line, &new);
    }
    Ok(text)
}

/// Returns the GPU kernels in a folder.
fn of_gpu(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(failure(folder))?;
    let mut files: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("vb-kernel-") && name.ends_with(".cubin.xz")
    });
    if files.is_empty() {
        return Err(Failure::new(format!(
            "{}: no kernels (make them with `cargo xtask kernel`)",
            folder.display()
        )));
    }
    Ok(files)
}

/// Installs the wheel in a fresh environment and tests it.
fn check(wheel: &Path) -> Result<(), Failure> {
    step("trying the Python package in a fresh environment");
    let script = crate::root().join("tests/wheel/smoke.py");
    let mut command = Command::new(python());
    // With what the tests need, so that none of the environments' is skipped but those of large libraries: torch alone is several
    // gigabytes.
    let with_torch = std::env::var_os(TORCH_VAR).is_some_and(|v| v == "1");
    let extras = if with_torch { "[test,train]" } else { "[test]" };
    command.arg("-B").arg(script).arg(wheel).args(["--extras", extras]);
    run(&mut command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_in_any_order() {
        let parse = |args: &[&str]| options(args).map(|(options, _)| options);
        let plain = parse(&[]).unwrap();
        assert_eq!((plain.target, plain.check), (None, false));
        assert!(plain.out.ends_with("wheels"));
        assert_eq!(parse(&["--portable"]).unwrap().target.as_deref(), Some(TARGET));
        let arm = Some("aarch64-unknown-linux-gnu".to_owned());
        for args in [
            ["--portable", "--target", "aarch64-unknown-linux-gnu"],
            ["--target", "aarch64-unknown-linux-gnu", "--portable"],
        ] {
            assert_eq!(parse(&args).unwrap().target, arm);
        }
        let both = parse(&["--check", "--out", "dist"]).unwrap();
        assert_eq!((both.check, both.out.as_path()), (true, Path::new("dist")));
        let (_, kernels) = options(&["--check", "--kernels", "target/kernel", "--portable"]).unwrap();
        assert_eq!(kernels.as_deref(), Some(Path::new("target/kernel")));
        for option in ["--out", "--kernels"] {
            assert!(parse(&[option]).unwrap_err().to_string().contains("its value is missing"));
        }
        assert!(parse(&["--zig"]).unwrap_err().to_string().contains("--zig"));
    }

    #[test]
    fn the_description_fits_another_folder() {
        let own = include_str!("../../harness/python/pyproject.toml");
        let text = description(own).unwrap();
        assert!(
            text.contains("/harness/python/Cargo.toml'\n") && text.lines().count() == own.lines().count()
        );
        assert!(description("").unwrap_err().to_string().contains("there must be one line"));
    }

    #[test]
    fn kernels_are_found_by_their_names() {
        let dir = tempfile::tempdir().unwrap();
        assert!(of_gpu(dir.path()).unwrap_err().to_string().contains("cargo xtask kernel"));
        for name in ["vb-kernel-sm_90.cubin.xz", "notes.xz"] {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        assert_eq!(of_gpu(dir.path()).unwrap(), [dir.path().join("vb-kernel-sm_90.cubin.xz")]);
    }

    #[test]
    fn maturin_has_one_version() {
        let folder = Compiler::of_pip(MATURIN).unwrap().folder;
        assert!(folder.ends_with(MATURIN.replace("==", "-")), "{}", folder.display());
        assert!(Compiler::of_pip("maturin").is_err());
    }
}
