//! Building for systems other than this one: zig is a C compiler and linker for all of them, and brings the headers of their C
//! libraries along.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::Command;

use crate::examples::Compiler;
use crate::plugins;
use crate::run::{Failure, output, run, step};

/// zig, with every version of glibc, and what makes cargo call it.
const ZIG: [&str; 2] = ["ziglang==0.17.0", "cargo-zigbuild==0.24.0"];
/// The oldest glibc that Rust supports, from 2012; nobody's cluster has an older one.
pub(crate) const GLIBC: &str = "2.17";

/// The programs that build for other systems, installed where they are missing.
pub(crate) fn tools() -> Result<Vec<Compiler>, Failure> {
    let tools = ZIG.into_iter().map(Compiler::of_pip).collect::<Result<Vec<_>, _>>()?;
    tools.iter().try_for_each(Compiler::install)?;
    Ok(tools)
}

/// What `.cargo/config.toml` tells the compiler, which says why, and for which processor.
const FAST: [&str; 2] = ["-C", "no-vectorize-slp"];
const FAST_PROCESSOR: &str = "x86_64";

/// Where what is built for other systems lies: everything is linked in another way.
pub(crate) fn dir() -> PathBuf {
    crate::target_dir().join("portable")
}

/// Builds the program for a system so that it runs on older ones of its kind too; `features` are cargo's arguments.
pub(crate) fn program(target: &str, tools: &[Compiler], features: &[&str]) -> Result<PathBuf, Failure> {
    step(&format!("building the harness for {target}, which takes as long as the first time"));
    run(cargo(tools, "zigbuild", target).args(["--release", "--package", "vb-harness"]).args(features))?;
    Ok(dir().join(target).join("release").join(program_name(target)))
}

/// The name of the program's file on a system.
pub(crate) fn program_name(target: &str) -> &'static str {
    if target.contains("windows") { "vb-harness.exe" } else { "vb-harness" }
}

/// A command of cargo-zigbuild for a system, such as `zigbuild` and `check`.
pub(crate) fn cargo(tools: &[Compiler], subcommand: &str, target: &str) -> Command {
    let mut command = Command::new("cargo-zigbuild");
    command.arg(subcommand).arg("--target").arg(with_glibc(target)).current_dir(crate::root());
    environment(&mut command, target, tools);
    command
}

fn with_glibc(target: &str) -> String {
    if target.ends_with("linux-gnu") { format!("{target}.{GLIBC}") } else { target.to_owned() }
}

/// Gives a command that calls cargo outside of the checkout, where cargo doesn't find `.cargo/config.toml`, the flags from there, so
/// that nothing is built twice. What the user has set stays.
pub(crate) fn flags_of_here(command: &mut Command) {
    let is_set = |name: &str| std::env::var_os(name).is_some();
    if std::env::consts::ARCH == FAST_PROCESSOR && !is_set("RUSTFLAGS") && !is_set("CARGO_ENCODED_RUSTFLAGS")
    {
        command.env("CARGO_ENCODED_RUSTFLAGS", FAST.join("\u{1f}"));
    }
}

/// Lets a command that builds for a system find the tools, and build without this machine's
/// places in what is built.
pub(crate) fn environment(command: &mut Command, target: &str, tools: &[Compiler]) {
    find(command, tools);
    command.env("CARGO_TARGET_DIR", dir());
    // strip is there for one processor only.
    command.env("CARGO_PROFILE_RELEASE_STRIP", "symbols");
    let mut place = OsString::from("--remap-path-prefix=");
    place.push(dir());
    place.push("=/target");
    let mut flags: Vec<_> = plugins::without_places().into_iter().chain([place]).collect();
    // Flags in the environment take the place of those of .cargo/config.toml.
    if target.starts_with(FAST_PROCESSOR) {
        flags.extend(FAST.map(OsString::from));
    }
    command.env("CARGO_ENCODED_RUSTFLAGS", flags.join(OsStr::new("\u{1f}")));
    command.env_remove("RUSTFLAGS");
}

/// Lets a command find tools that pip installed.
pub(crate) fn find(command: &mut Command, tools: &[Compiler]) {
    command.env("PYTHONPATH", joined(tools.iter().map(|t| t.folder.clone()), None));
    let path = std::env::var_os("PATH");
    command.env("PATH", joined(tools.iter().map(|t| t.folder.join("bin")), path.as_deref()));
}

/// Has rustup install the standard library for a system, if it isn't there.
pub(crate) fn add_target(target: &str) -> Result<(), Failure> {
    output(Command::new("rustup").args(["target", "add", target])).map(|_| ()).ok_or_else(|| {
        Failure::new(format!(
            "rustup can't add the target {target}: see what `rustup target add {target}` says"
        ))
    })
}

/// A list of folders for the environment, in front of one that is there.
fn joined(folders: impl Iterator<Item = PathBuf>, rest: Option<&OsStr>) -> OsString {
    let rest = rest.map(std::env::split_paths).into_iter().flatten();
    // A folder whose name holds the separator can't be in such a list at all.
    std::env::join_paths(folders.chain(rest)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tool_has_one_version() {
        for pin in ZIG {
            let folder = Compiler::of_pip(pin).unwrap().folder;
            assert!(folder.ends_with(pin.replace("==", "-")), "{}", folder.display());
        }
    }

    #[test]
    fn what_is_built_for_other_systems_has_the_flags_of_what_is_built_here() {
        let told = include_str!("../../.cargo/config.toml");
        let flags = format!("'cfg(target_arch = \"{FAST_PROCESSOR}\")']\nrustflags = {FAST:?}\n");
        assert!(told.ends_with(&flags), "{told}");
    }

    #[test]
    fn only_linux_has_versions_of_glibc() {
        assert_eq!(with_glibc("aarch64-unknown-linux-gnu"), "aarch64-unknown-linux-gnu.2.17");
        assert_eq!(with_glibc("x86_64-pc-windows-gnu"), "x86_64-pc-windows-gnu");
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
