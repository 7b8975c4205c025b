//! The Python package: its wheel and its source distribution (`docs/python.md`).
//!
//! `harness/python/build_backend` makes both. Here it gets the programs that it needs, in pinned versions, and what is built
//! already.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::examples::{Compiler, python};
use crate::options::Options;
use crate::plugins;
use crate::portable::{self, GLIBC};
use crate::run::{Failure, run, step};

/// The environment variable that lets the check install what policies are trained with.
const TORCH_VAR: &str = "VB_TORCH";

/// What makes wheels.
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

/// Makes both, and checks them if that is asked for.
pub(crate) fn wheel(args: &[&str]) -> Result<(), Failure> {
    let (Options { target, check, out }, kernels) = options(args)?;
    let maturin = Compiler::of_pip(MATURIN)?;
    maturin.install()?;
    let mut tools = if target.is_some() { portable::tools()? } else { Vec::new() };
    tools.push(maturin);
    let absolute =
        |path: &Path| std::path::absolute(path).map_err(|e| Failure::new(format!("{}: {e}", path.display())));
    let out = absolute(&out)?;
    let kernels = kernels.as_deref().map(absolute).transpose()?;
    // As `cargo xtask test` builds them, so that nothing is built twice.
    plugins::build_as_wasm(&crate::default_plugin_dir())?;
    let program = match &target {
        None => {
            crate::build_harness()?;
            crate::built("vb-harness")
        }
        // Without the tasks within it, which lie beside it.
        Some(target) => portable::program(target, &tools, &["--no-default-features"])?,
    };
    let make = |what: &str| {
        step(&format!("making the {what} of the Python package"));
        let mut command = Command::new(python());
        command.args(["-B", "-m", "vertibench_build", what]).arg(&out).current_dir(crate::root());
        let modules = [crate::root().join("harness/python/build_backend")];
        match &target {
            None => {
                portable::find(&mut command, &tools, &modules);
                portable::flags_of_here(&mut command);
            }
            Some(target) => portable::environment(&mut command, target, &tools, &modules),
        }
        command.env("VB_WHEEL_HARNESS", &program).env("VB_WHEEL_PLUGINS", crate::default_plugin_dir());
        if let Some(folder) = &kernels {
            command.env("VB_WHEEL_KERNELS", folder);
        }
        if let Some(target) = &target {
            let arguments =
                format!("--zig --target {target} --compatibility manylinux_{}", GLIBC.replace('.', "_"));
            command.env("MATURIN_PEP517_ARGS", arguments);
        }
        last_line(&mut command)
            .ok_or_else(|| Failure::new(format!("can't make the {what} (the reason is told above)")))
    };
    let made = [make("wheel")?, make("sdist")?];
    for file in &made {
        let size = std::fs::metadata(file).map_or(0, |m| m.len());
        step(&format!("{file}: {:.1} MB", size as f64 / 1e6));
    }
    if check { self::check(&made) } else { Ok(()) }
}

/// Runs a command and returns the last line of what it prints, which it has to itself; none if it fails.
fn last_line(command: &mut Command) -> Option<String> {
    let output = command.stderr(Stdio::inherit()).output().ok().filter(|o| o.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().last().map(str::to_owned)
}

/// Installs the wheel in a fresh environment and tries it, and sees that the sources are whole.
fn check([wheel, sdist]: &[String; 2]) -> Result<(), Failure> {
    step("trying the Python package in a fresh environment");
    let script = crate::root().join("tests/wheel/smoke.py");
    let mut command = Command::new(python());
    // With what the tests need, so that none of the environments' is skipped but those of large libraries: torch alone is several
    // gigabytes.
    let with_torch = std::env::var_os(TORCH_VAR).is_some_and(|v| v == "1");
    let extras = if with_torch { "[test,train]" } else { "[test]" };
    command.arg("-B").arg(script).arg(wheel).arg("--sdist").arg(sdist).args(["--extras", extras]);
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
    fn maturin_has_one_version() {
        let folder = Compiler::of_pip(MATURIN).unwrap().folder;
        assert!(folder.ends_with(MATURIN.replace("==", "-")), "{}", folder.display());
        assert!(Compiler::of_pip("maturin").is_err());
    }
}
