//! What to do about a plugin that can't be used, guessed from what its author may have meant.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vb_sdk::metadata::MetadataError;

/// Endings of the names of native libraries.
const LIBRARIES: [&str; 3] = ["so", "dylib", "dll"];
/// Endings of scripts, and the program that runs each as a command.
const SCRIPTS: [(&str, &str); 6] =
    [("py", "python3"), ("js", "node"), ("mjs", "node"), ("jl", "julia"), ("rb", "ruby"), ("sh", "sh")];
/// First bytes of a static library, which an rlib of Rust is too.
const ARCHIVE: &[u8] = b"!<arch>\n";
/// What a crate must say to become a file that can be loaded.
const CDYLIB: &str = "crate-type = [\"cdylib\"] below [lib] in Cargo.toml";

/// About a plugin file that isn't there. Looks at the files around it, since a name is often nearly right.
pub(crate) fn missing(path: &Path) -> String {
    if let Some(near) = near(path) {
        return format!("did you mean {}?", near.display());
    }
    let text = path.to_string_lossy();
    if let Some((program, _)) = text.split_once(char::is_whitespace) {
        return format!("a command needs a program in the PATH as its first word, but {program} is none");
    }
    let ending = |wanted: &[&str]| path.extension().is_some_and(|e| wanted.iter().any(|w| e == *w));
    let is_of_cargo = path.components().any(|part| part.as_os_str() == "target");
    if ending(&LIBRARIES) || (is_of_cargo && ending(&["wasm"])) {
        return format!("cargo builds it only from a crate with {CDYLIB}; {SHIPPED}");
    }
    SHIPPED.into()
}

const SHIPPED: &str = "build the shipped planners with `cargo xtask plugins`";

/// A file in the same folder whose name differs in what is easily mixed up: `-` and `_`, capitals, the `lib` before
/// a native library.
fn near(path: &Path) -> Option<PathBuf> {
    let plain = |name: &str| {
        let name = name.to_lowercase().replace('-', "_");
        name.strip_prefix("lib").map(str::to_owned).unwrap_or(name)
    };
    let wanted = plain(path.file_name()?.to_str()?);
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names = entries.flatten().filter_map(|e| e.file_name().into_string().ok());
    // The order of a folder's entries is the system's own.
    let name = names.filter(|name| plain(name) == wanted).min()?;
    Some(folder.map_or_else(|| PathBuf::from(&name), |folder| folder.join(&name)))
}

/// About a file that is neither WebAssembly nor a native library; it begins with these bytes.
pub(crate) fn of_another_kind(path: &Path, bytes: &[u8]) -> Option<String> {
    if bytes.starts_with(ARCHIVE) {
        return Some(format!("it is a static library; set {CDYLIB}, and give the resulting file"));
    }
    let ending = path.extension();
    let program = SCRIPTS.iter().find(|(e, _)| ending.is_some_and(|found| found == *e)).map(|(_, p)| *p);
    match program {
        Some(program) => Some(format!(
            "run a script as a command, in quotation marks: --plugin \"{program} {}\"",
            path.display()
        )),
        None if bytes.starts_with(b"#!") => Some(
            "run a script as a command with its interpreter, in quotation marks, e.g. --plugin \"python3 mine.py\""
                .into(),
        ),
        None => None,
    }
}

/// About a plugin without metadata.
pub(crate) fn no_metadata(is_native: bool) -> &'static str {
    if is_native {
        "vb_sdk::export_planner! in Rust and VB_PLANNER_METADATA of vb_planner.h in C and C++ write them"
    } else {
        "vb_sdk::export_planner! in Rust and `vb-harness plugin stamp` for other languages write them"
    }
}

/// About metadata that can't be read: the rule that they break.
pub(crate) fn metadata(error: &MetadataError) -> String {
    let rule = match error {
        MetadataError::BadLine { text, .. } => match text.split_once(": ") {
            None => ", but a line is `key: value`",
            Some(("name", _)) => ", but a name consists of a-z, 0-9, - and _",
            Some(("control-period", _)) => {
                ", but a control period is a positive multiple of 0.001, in seconds"
            }
            Some(("default" | "help", _)) => ", but it must follow a param",
            Some(_) => ", but only n, r or another backslash may follow a backslash",
        },
        // Their own texts name it.
        _ => "",
    };
    format!(
        "{rule}; change it in export_planner!, in VB_PLANNER_METADATA or in planner.yaml, and rebuild the plugin"
    )
}

/// Names of imports for people: the first few.
pub(crate) fn shown(imports: &[String]) -> String {
    const SHOWN: usize = 5;
    let mut text = imports[..imports.len().min(SHOWN)].join(", ");
    if imports.len() > SHOWN {
        // Writing into a text can't fail.
        let _ = write!(text, " and {} more", imports.len() - SHOWN);
    }
    text
}

/// About imports that planners don't get.
pub(crate) fn imports(names: &[String]) -> String {
    let asks_for = |words: &[&str]| {
        let mut all = names.iter().flat_map(|name| name.split(|c: char| !c.is_ascii_alphanumeric()));
        all.any(|word| words.iter().any(|w| word.eq_ignore_ascii_case(w)))
    };
    let mut hints = Vec::new();
    if asks_for(&["clock", "clocks", "now", "time", "performance", "date", "instant", "gettimeofday"]) {
        hints.push(NO_CLOCK);
    }
    if asks_for(&["thread", "threads", "pthread", "spawn", "worker"]) {
        hints.push(NO_THREADS);
    }
    hints.push("build it for wasm32-unknown-unknown and use only vb-sdk");
    hints.join("; ")
}

const NO_CLOCK: &str = "planners have no clock: use the observation's `time`, which is simulated";
const NO_THREADS: &str = "planners have no threads: use a single thread";

/// About a panic with this text.
pub(crate) fn panic(message: &str) -> &'static str {
    // As Rust's standard library panics where the system has neither.
    if message.contains("time not implemented on this platform") {
        NO_CLOCK
    } else if message.contains("failed to spawn thread") {
        NO_THREADS
    } else {
        "fix the code at this location"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_nearly_right_is_suggested() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for there in ["hill_fox.wasm", "libhare.so", "other.wasm"] {
            std::fs::write(at(there), "").unwrap();
        }
        for (given, meant) in [
            ("hill-fox.wasm", "hill_fox.wasm"),
            ("Hill_Fox.wasm", "hill_fox.wasm"),
            ("hare.so", "libhare.so"),
        ] {
            assert_eq!(missing(&at(given)), format!("did you mean {}?", at(meant).display()));
        }
        assert_eq!(missing(&at("fox.wasm")), SHIPPED);
    }

    #[test]
    fn what_cargo_would_build_needs_a_cdylib_and_a_command_a_program() {
        for given in ["mine/libmine.so", "x/target/wasm32-unknown-unknown/release/mine.wasm"] {
            assert!(missing(Path::new(given)).contains("cdylib"), "{given}");
        }
        assert!(missing(Path::new("pyton3 mine.py")).contains("first word, but pyton3 is none"));
    }

    #[test]
    fn scripts_and_static_libraries_are_told_apart_from_other_files() {
        let of = |name: &str, bytes: &[u8]| of_another_kind(Path::new(name), bytes).unwrap_or_default();
        assert!(of("a/mine.py", b"import x").ends_with("--plugin \"python3 a/mine.py\""));
        assert!(of("mine", b"#!/usr/bin/env python3\n").contains("\"python3 mine.py\""));
        assert!(of("libmine.rlib", b"!<arch>\nx").contains("cdylib"));
        assert_eq!(of("notes.txt", b"text"), "");
    }

    #[test]
    fn imports_of_clocks_and_threads_say_what_planners_use_instead() {
        let of = |names: &[&str]| imports(&names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>());
        for clock in ["__wbindgen_placeholder__.__wbg_now_2c44", "wasi:clocks/wall-clock@0.3.0", "env.time"] {
            assert!(of(&[clock]).contains("the observation's `time`"), "{clock}");
        }
        assert!(of(&["wasi.thread-spawn"]).contains("no threads"));
        let other = of(&["env.runtime_spawned"]);
        assert!(!other.contains("clock") && !other.contains("threads"), "{other}");
    }

    #[test]
    fn of_many_imports_the_first_are_shown() {
        let many: Vec<String> = (0..7).map(|n| format!("a.f{n}")).collect();
        assert_eq!(shown(&many), "a.f0, a.f1, a.f2, a.f3, a.f4 and 2 more");
        assert_eq!(shown(&many[..2]), "a.f0, a.f1");
    }

    #[test]
    fn a_panic_for_want_of_a_clock_says_so() {
        let text = "panicked at library/std/src/sys/pal/wasm/../unsupported/time.rs:13:9: time not implemented on this platform";
        assert_eq!(panic(text), NO_CLOCK);
        assert_eq!(panic("panicked at src/lib.rs:1:1: index out of bounds"), "fix the code at this location");
    }
}
