//! The Python package: its wheel and its source distribution (`docs/python.md`).
//!
//! `harness/python/build_backend` makes both. Here it gets the programs that it needs, in pinned versions, and what is built
//! already.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::examples::{Compiler, python};
use crate::plugins;
use crate::run::{Failure, cargo_program, run, step};

/// The environment variable that lets the check install what policies are trained with.
const TORCH_VAR: &str = "VB_TORCH";

/// What makes wheels.
const MATURIN: &str = "maturin==1.16.0";
/// What links for other systems than this one: a C compiler with every version of glibc, and what makes cargo call it.
const ZIG: [&str; 2] = ["ziglang==0.17.0", "cargo-zigbuild==0.24.0"];
/// The oldest glibc that Rust supports, from 2012; nobody's cluster has an older one.
const GLIBC: &str = "2.17";
/// What a portable wheel is for if nothing is said.
const TARGET: &str = "x86_64-unknown-linux-gnu";

/// What is asked for.
#[derive(Debug, PartialEq, Eq)]
struct Options {
    /// The platform of a portable wheel; none for a wheel that is built as everything else here is.
    target: Option<String>,
    check: bool,
    out: PathBuf,
}

impl Options {
    fn parse(args: &[&str]) -> Result<Self, Failure> {
        let mut options = Self { target: None, check: false, out: crate::target_dir().join("wheels") };
        let mut rest = args.iter();
        while let Some(arg) = rest.next() {
            let mut value =
                || rest.next().ok_or_else(|| Failure::new(format!("wheel {arg}: its value is missing")));
            match *arg {
                "--portable" => options.target = options.target.or_else(|| Some(TARGET.into())),
                "--target" => options.target = Some((*value()?).into()),
                "--out" => options.out = (*value()?).into(),
                "--check" => options.check = true,
                _ => {
                    return Err(Failure::new(format!(
                        "wheel: no such option: `{arg}` (see `cargo xtask help`)"
                    )));
                }
            }
        }
        Ok(options)
    }
}

/// Makes both, and checks them if that is asked for.
pub(crate) fn wheel(args: &[&str]) -> Result<(), Failure> {
    let Options { target, check, out } = Options::parse(args)?;
    let pins = [MATURIN].into_iter().chain(ZIG.into_iter().filter(|_| target.is_some()));
    let tools = pins.map(Compiler::of_pip).collect::<Result<Vec<_>, _>>()?;
    tools.iter().try_for_each(Compiler::install)?;
    let failure = |e| Failure::new(format!("{}: {e}", out.display()));
    let out = std::path::absolute(&out).map_err(failure)?;
    // As `cargo xtask test` builds them, so that nothing is built twice.
    plugins::build_as_wasm(&crate::default_plugin_dir())?;
    let program = match &target {
        None => {
            crate::build_harness()?;
            crate::built("vb-harness")
        }
        Some(target) => portable_program(target, &tools)?,
    };
    let make = |what: &str| {
        step(&format!("making the {what} of the Python package"));
        let mut command = Command::new(python());
        command.args(["-B", "-m", "vertibench_build", what]).arg(&out).current_dir(crate::root());
        environment(&mut command, &tools, target.is_some());
        command
            .env("VB_WHEEL_HARNESS", absolute(&program))
            .env("VB_WHEEL_PLUGINS", absolute(&crate::default_plugin_dir()));
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

/// Builds the program so that it runs with an old glibc, in a folder of its own: everything is linked in another way.
fn portable_program(target: &str, tools: &[Compiler]) -> Result<PathBuf, Failure> {
    step(&format!(
        "building the harness for {target} with glibc {GLIBC}, which takes as long as the first time"
    ));
    let mut command = Command::new(cargo_program());
    command.args(["zigbuild", "--release", "--package", "vb-harness"]);
    command.arg("--target").arg(format!("{target}.{GLIBC}")).current_dir(crate::root());
    run(environment(&mut command, tools, true))?;
    Ok(portable_dir().join(target).join("release/vb-harness"))
}

fn portable_dir() -> PathBuf {
    absolute(&crate::target_dir().join("portable"))
}

/// Lets a command find the tools and the build backend; `portable`, where it builds for other systems.
fn environment<'a>(command: &'a mut Command, tools: &[Compiler], portable: bool) -> &'a mut Command {
    let backend = crate::root().join("harness/python/build_backend");
    command
        .env("PYTHONPATH", joined([backend].into_iter().chain(tools.iter().map(|t| t.folder.clone())), None));
    let path = std::env::var_os("PATH");
    command.env("PATH", joined(tools.iter().map(|t| t.folder.join("bin")), path.as_deref()));
    if portable {
        command.env("CARGO_TARGET_DIR", portable_dir());
        // strip is there for one processor only.
        command.env("CARGO_PROFILE_RELEASE_STRIP", "symbols");
        let mut target = OsString::from("--remap-path-prefix=");
        target.push(portable_dir());
        target.push("=/target");
        let flags: Vec<_> = plugins::without_places().into_iter().chain([target]).collect();
        command.env("CARGO_ENCODED_RUSTFLAGS", flags.join(OsStr::new("\u{1f}")));
        command.env_remove("RUSTFLAGS");
    }
    command
}

/// A list of folders for the environment, in front of one that is there.
fn joined(folders: impl Iterator<Item = PathBuf>, rest: Option<&OsStr>) -> OsString {
    let rest = rest.map(std::env::split_paths).into_iter().flatten();
    // A folder whose name holds the separator can't be in such a list at all.
    std::env::join_paths(folders.chain(rest)).unwrap_or_default()
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
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
        let parse = |args: &[&str]| Options::parse(args);
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
        assert!(parse(&["--out"]).unwrap_err().to_string().contains("its value is missing"));
        assert!(parse(&["--zig"]).unwrap_err().to_string().contains("--zig"));
    }

    #[test]
    fn every_tool_has_one_version() {
        for pin in [MATURIN].into_iter().chain(ZIG) {
            let folder = Compiler::of_pip(pin).unwrap().folder;
            assert!(folder.ends_with(pin.replace("==", "-")), "{}", folder.display());
        }
        assert!(Compiler::of_pip("maturin").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn folders_come_before_those_that_are_there() {
        let folders = || ["/a", "/b"].map(PathBuf::from).into_iter();
        assert_eq!(
            joined(folders(), Some(OsStr::new("/usr/bin:/bin"))),
            OsString::from("/a:/b:/usr/bin:/bin")
        );
        assert_eq!(joined(folders(), None), OsString::from("/a:/b"));
    }
}
