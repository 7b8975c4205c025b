//! Finding or making a compiler for WASM.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::run::{Failure, cargo_program, output, step};

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";

/// The cargo to build WASM with: the usual one if its target is installed or rustup can add it, else one that drives
/// Debian's compiler.
pub(crate) fn cargo_for_wasm() -> Result<OsString, Failure> {
    if std::env::var_os("VB_WASM_FALLBACK").is_none_or(|v| v.is_empty() || v == "0") {
        if installed() {
            return Ok(cargo_program());
        }
        step(&format!("adding the target {TARGET} by rustup"));
        let added = Command::new("rustup").args(["target", "add", TARGET]).stdout(Stdio::null()).status();
        if added.is_ok_and(|s| s.success()) && installed() {
            return Ok(cargo_program());
        }
        step("rustup could not add it; trying Debian's compiler packages instead");
    }
    let script = crate::root().join("xtask/install-wasm-toolchain.sh");
    let mut command = Command::new("bash");
    command.arg(script).stderr(Stdio::inherit());
    output(&mut command).map(OsString::from).ok_or_else(|| {
        Failure::new(format!(
            "there is no compiler for {TARGET}, which planners are built for: run `rustup target add {TARGET}`, or \
             on Debian see that `apt-get download rustc-web` works"
        ))
    })
}

/// Whether the usual compiler has the standard library for the target.
fn installed() -> bool {
    let Some(folder) = output(Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]))
    else {
        return false;
    };
    has_std(Path::new(&folder))
}

fn has_std(folder: &Path) -> bool {
    let is_std = |name: &str| name.starts_with("libstd-") && name.ends_with(".rlib");
    std::fs::read_dir(folder).is_ok_and(|mut files| {
        files.any(|file| file.is_ok_and(|f| f.file_name().to_str().is_some_and(is_std)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_installed_when_its_standard_library_is_there() {
        let dir = tempfile::tempdir().unwrap();
        assert!(!has_std(&dir.path().join("missing")));
        assert!(!has_std(dir.path()));
        std::fs::write(dir.path().join("libcore-0123.rlib"), "").unwrap();
        assert!(!has_std(dir.path()));
        std::fs::write(dir.path().join("libstd-0123.rlib"), "").unwrap();
        assert!(has_std(dir.path()));
    }
}
