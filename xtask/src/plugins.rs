//! Building the planners: each as a WASM component and as a native library, from the same source.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{Failure, cargo_program, output, run, step};
use crate::wasm_target::{TARGET, cargo_for_wasm};

/// Folders of planner crates; each crate is named after its folder.
const FOLDERS: [&str; 2] = ["plugins", "examples"];
/// The profile of the workspace for WASM.
const WASM_PROFILE: &str = "wasm";

/// Builds all planners and puts `NAME.wasm` and the native libraries into `out`.
pub(crate) fn build(out: &Path) -> Result<(), Failure> {
    let packages = packages(crate::root())?;
    std::fs::create_dir_all(out).map_err(|e| Failure::new(format!("can't make {}: {e}", out.display())))?;
    build_native(&packages, out)?;
    build_wasm(&packages, out)?;
    step(&format!("planners in {}: {}", out.display(), packages.join(", ")));
    Ok(())
}

/// Builds all planners as WASM alone.
pub(crate) fn build_as_wasm(out: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(|e| Failure::new(format!("can't make {}: {e}", out.display())))?;
    build_wasm(&packages(crate::root())?, out)
}

/// Builds one planner as WASM and puts it into `out`.
pub(crate) fn build_one(package: &str, out: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(|e| Failure::new(format!("can't make {}: {e}", out.display())))?;
    build_wasm(&[package.to_owned()], out)
}

/// The planners that are for users: all but those that are there to fail, or to misuse the vehicle.
pub(crate) fn to_drive_with() -> Result<Vec<String>, Failure> {
    let mut names = packages(crate::root())?;
    names.retain(|name| !["faulty", "wild"].contains(&name.as_str()));
    Ok(names)
}

fn packages(root: &Path) -> Result<Vec<String>, Failure> {
    let mut names = Vec::new();
    for folder in FOLDERS {
        let folder = root.join(folder);
        let entries =
            std::fs::read_dir(&folder).map_err(|e| Failure::new(format!("{}: {e}", folder.display())))?;
        // What planners share is a library and no plugin.
        let is_plugin = |folder: &Path| {
            std::fs::read_to_string(folder.join("Cargo.toml")).is_ok_and(|text| text.contains("\"cdylib\""))
        };
        let crates = entries.flatten().filter(|e| is_plugin(&e.path()));
        names.extend(crates.map(|e| e.file_name().to_string_lossy().into_owned()));
    }
    names.sort();
    Ok(names)
}

fn package_args(packages: &[String]) -> impl Iterator<Item = &str> {
    packages.iter().flat_map(|p| ["--package", p.as_str()])
}

fn build_native(packages: &[String], out: &Path) -> Result<(), Failure> {
    step("building the planners as native libraries");
    let mut command = Command::new(cargo_program());
    command.args(["build", "--release"]).args(package_args(packages)).current_dir(crate::root());
    run(&mut command)?;
    for package in packages {
        let name = native_name(package);
        install(&crate::target_dir().join("release").join(&name), &out.join(&name))?;
    }
    Ok(())
}

fn build_wasm(packages: &[String], out: &Path) -> Result<(), Failure> {
    step(&match packages {
        [one] => format!("building the planner {one} as WASM"),
        _ => "building the planners as WASM".to_owned(),
    });
    // A folder of its own: flags and perhaps the compiler differ from those of the native build.
    let target_dir = crate::target_dir().join("wasm");
    let cargo = cargo_for_wasm()?;
    let mut command = Command::new(cargo);
    command
        .args(["build", "--profile", WASM_PROFILE, "--target", TARGET, "--target-dir"])
        .arg(&target_dir)
        .args(package_args(packages))
        .env("CARGO_ENCODED_RUSTFLAGS", wasm_flags())
        .env_remove("RUSTFLAGS")
        .current_dir(crate::root());
    run(&mut command)?;
    for package in packages {
        let file = format!("{}.wasm", package.replace('-', "_"));
        let module = target_dir.join(TARGET).join(WASM_PROFILE).join(file);
        let bytes = std::fs::read(&module).map_err(|e| Failure::new(format!("{}: {e}", module.display())))?;
        let component = wit_component::ComponentEncoder::default()
            .validate(true)
            .module(&bytes)
            .and_then(|mut encoder| encoder.encode())
            .map_err(|e| {
                Failure::new(format!("{}: can't make a component of it: {e:#}", module.display()))
            })?;
        let plugin = out.join(format!("{package}.wasm"));
        std::fs::write(&plugin, component)
            .map_err(|e| Failure::new(format!("can't write {}: {e}", plugin.display())))?;
    }
    Ok(())
}

/// Flags for the code of a planner, separated as cargo wants them.
fn wasm_flags() -> OsString {
    let flags = [OsString::from("-Ctarget-feature=+simd128")].into_iter().chain(without_places());
    flags.collect::<Vec<_>>().join(OsStr::new("\u{1f}"))
}

/// Flags that keep the places of checkout, registry and compiler out of what is built. Paths end up in panic messages: without
/// these the bytes of a plugin would depend on where it was built.
pub(crate) fn without_places() -> Vec<OsString> {
    let mut flags = Vec::new();
    let cargo_home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"])).map(PathBuf::from);
    let places = [(Some(crate::root().to_owned()), "."), (cargo_home, "/cargo"), (sysroot, "/toolchain")];
    for (from, to) in places {
        if let Some(from) = from {
            let mut flag = OsString::from("--remap-path-prefix=");
            flag.push(from);
            flag.push("=");
            flag.push(to);
            flags.push(flag);
        }
    }
    flags
}

/// The file name of a native library of a package.
fn native_name(package: &str) -> String {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    format!("{DLL_PREFIX}{}{DLL_SUFFIX}", package.replace('-', "_"))
}

/// Puts a file in place at once: a harness may be running with the old one.
fn install(from: &Path, to: &Path) -> Result<(), Failure> {
    let failure = |e| Failure::new(format!("can't copy {} to {}: {e}", from.display(), to.display()));
    let new = to.with_extension("new");
    std::fs::copy(from, &new).map_err(failure)?;
    std::fs::rename(&new, to).map_err(failure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_plugin_in_the_planner_folders_is_a_package() {
        let dir = tempfile::tempdir().unwrap();
        assert!(packages(dir.path()).is_err());
        for folder in ["plugins/pid", "plugins/notes", "plugins/shared", "examples/two-words"] {
            std::fs::create_dir_all(dir.path().join(folder)).unwrap();
        }
        for (folder, kind) in
            [("plugins/pid", "cdylib"), ("plugins/shared", "rlib"), ("examples/two-words", "cdylib")]
        {
            let manifest = format!("[lib]\ncrate-type = [\"{kind}\"]\n");
            std::fs::write(dir.path().join(folder).join("Cargo.toml"), manifest).unwrap();
        }
        assert_eq!(packages(dir.path()).unwrap(), ["pid", "two-words"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn libraries_are_named_as_cargo_names_them() {
        assert_eq!(native_name("two-words"), "libtwo_words.so");
    }

    #[test]
    fn the_flags_hide_the_place_of_the_checkout() {
        let flags = wasm_flags().into_string().unwrap();
        let root = crate::root().to_str().unwrap();
        assert!(flags.split('\u{1f}').any(|f| f == format!("--remap-path-prefix={root}=.")), "{flags}");
    }

    #[test]
    fn installing_replaces_the_old_file() {
        let dir = tempfile::tempdir().unwrap();
        let (from, to) = (dir.path().join("from"), dir.path().join("lib.so"));
        std::fs::write(&from, "new").unwrap();
        std::fs::write(&to, "old").unwrap();
        install(&from, &to).unwrap();
        assert_eq!(std::fs::read_to_string(&to).unwrap(), "new");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2);
    }
}
