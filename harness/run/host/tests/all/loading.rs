//! What is a plugin, and what is said of files that are not. More of them are in `hostile`.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::path::Path;

use crate::common::{METADATA, core_module, file, observation, planner_wat, task, with_metadata};
use sha2::Digest as _;
use vb_host::{Limits, LoadError, LogSink, Plugin, imports, inspect};

const OK: &str = "(call $ok_planner)";
const GO: &str = "(call $ok_command (f64.const 0.25) (f64.const 0.5) (f64.const 0))";

fn good() -> Vec<u8> {
    core_module(&planner_wat(OK, GO), METADATA)
}

/// The message for a file with these bytes, from loading it. It must be a single line that begins with the path.
fn refusal(bytes: &[u8]) -> (LoadError, String) {
    let (_dir, path) = file(bytes);
    let error = Plugin::load(&path, &Limits::default(), None).unwrap_err();
    let message = error.to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.starts_with(path.to_str().unwrap()), "{message}");
    (error, message)
}

#[test]
fn metadata_are_read_without_running_the_plugin() {
    // Its code is not even valid: `i64.add` has nothing to add.
    let (_dir, path) = file(&core_module(&planner_wat("i64.add", GO), METADATA));
    assert!(Plugin::load(&path, &Limits::default(), None).is_err());
    let m = inspect(&path).unwrap();
    assert_eq!((m.name.as_str(), m.version.as_str(), m.control_period), ("probe", "1.0.0", 0.1));
}

#[test]
fn a_component_serves_as_well_as_its_core_module() {
    let mut encoder = wit_component::ComponentEncoder::default().module(&good()).unwrap();
    let (_dir, path) = file(&encoder.encode().unwrap());
    assert_eq!(inspect(&path).unwrap().name, "probe");
    let plugin = Plugin::load(&path, &Limits::default(), None).unwrap();
    let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
    assert_eq!(session.step(&observation()).unwrap().throttle, 0.5);
}

#[test]
fn a_compiled_plugin_is_kept_and_used_again() {
    let (dir, path) = file(&good());
    let cache = dir.path().join("cache");
    let step = |plugin: &Plugin| {
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        (session.step(&observation()).unwrap(), session.fuel_used())
    };
    let fresh = step(&Plugin::load(&path, &Limits::default(), Some(&cache)).unwrap());
    let files: Vec<_> = std::fs::read_dir(&cache).unwrap().map(|f| f.unwrap().path()).collect();
    let files: Vec<_> = files.into_iter().filter(|f| f.extension().is_some_and(|e| e == "cwasm")).collect();
    assert_eq!(files.len(), 1);
    let before = std::fs::read(&files[0]).unwrap();
    assert_eq!(step(&Plugin::load(&path, &Limits::default(), Some(&cache)).unwrap()), fresh);
    assert!(std::fs::read(&files[0]).unwrap() == before, "written again");
    // A damaged file is replaced.
    std::fs::write(&files[0], b"rubbish").unwrap();
    assert_eq!(step(&Plugin::load(&path, &Limits::default(), Some(&cache)).unwrap()), fresh);
    assert!(std::fs::metadata(&files[0]).unwrap().len() > 1000);
}

#[test]
fn an_unusable_cache_is_no_error() {
    let (dir, path) = file(&good());
    std::fs::write(dir.path().join("taken"), b"a file").unwrap();
    Plugin::load(&path, &Limits::default(), Some(&dir.path().join("taken"))).unwrap();
}

#[test]
fn the_hash_is_that_of_the_file() {
    // Of the file itself, not of the component that is made of it.
    let (_dir, path) = file(&good());
    let plugin = Plugin::load(&path, &Limits::default(), None).unwrap();
    let digest = sha2::Sha256::digest(good());
    assert_eq!(plugin.sha256(), digest.iter().map(|b| format!("{b:02x}")).collect::<String>());
}

#[test]
fn a_missing_or_unreadable_file() {
    let error = inspect(Path::new("/nowhere/pid.wasm")).unwrap_err();
    assert!(matches!(error, LoadError::NotFound { .. }));
    assert!(error.to_string().starts_with("/nowhere/pid.wasm: no such plugin file"));
    let dir = tempfile::tempdir().unwrap();
    assert!(matches!(inspect(dir.path()).unwrap_err(), LoadError::Io { .. }));
}

#[test]
fn an_empty_file_or_one_of_another_kind() {
    assert!(matches!(refusal(b"").0, LoadError::Empty { .. }));
    for bytes in [&b"#!/usr/bin/env python"[..], b"PK\x03\x04", b"\0as"] {
        let (error, message) = refusal(bytes);
        assert!(matches!(error, LoadError::NotAPlugin { .. }), "{message}");
        assert!(message.contains("neither WebAssembly nor a native library"), "{message}");
    }
}

#[test]
fn a_truncated_plugin_wherever_it_is_cut() {
    let bytes = good();
    for cut in [5, 9, 40, bytes.len() / 2, bytes.len() - 1] {
        let (error, message) = refusal(&bytes[..cut]);
        assert!(matches!(error, LoadError::Damaged { .. }), "{cut}: {message}");
    }
    let (error, message) = refusal(b"\x7fELF\x02\x01\x01\0\0\0\0\0");
    assert!(matches!(error, LoadError::Damaged { .. }), "{message}");
}

#[test]
fn wasm_that_is_no_planner() {
    let (error, message) = refusal(&wat::parse_str("(module)").unwrap());
    assert!(matches!(error, LoadError::NotAPlugin { .. }));
    assert!(message.contains("core WebAssembly module without the planner interface"), "{message}");
    let (error, message) = refusal(&wat::parse_str("(component)").unwrap());
    assert!(matches!(error, LoadError::NotAPlugin { .. }));
    assert!(message.contains("no planner metadata"), "{message}");
    assert!(message.contains("export_planner!") && message.contains("plugin stamp"), "{message}");
    // Metadata but nothing exported.
    let (error, message) = refusal(&with_metadata(wat::parse_str("(component)").unwrap(), METADATA));
    assert!(matches!(error, LoadError::NotAPlugin { .. }));
    assert!(message.contains("vertibench:planner/guest"), "{message}");
    // The component type promises functions that the module lacks.
    let (error, message) = refusal(&core_module("(module)", METADATA));
    assert!(matches!(error, LoadError::NotAPlugin { .. }), "{message}");
}

#[test]
fn a_native_library_that_is_no_planner() {
    // The test's own executable: sound ELF without the section.
    let own = std::env::current_exe().unwrap();
    let message = inspect(&own).unwrap_err().to_string();
    assert!(message.contains("no planner metadata"), "{message}");
    assert!(message.contains("export_planner!") && message.contains("VB_PLANNER_METADATA"), "{message}");
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_native_library_for_another_processor() {
    let mut bytes = std::fs::read(std::env::current_exe().unwrap()).unwrap();
    // e_machine, at offset 18 of an ELF header: 183 is AArch64.
    bytes[18] = 183;
    let (error, message) = refusal(&bytes);
    assert!(matches!(error, LoadError::Unloadable { .. }));
    assert!(message.contains("built for Aarch64, this machine is x86_64"), "{message}");
}

#[test]
fn metadata_that_are_damaged_or_of_another_version() {
    let with = |metadata: &str| core_module(&planner_wat(OK, GO), metadata);
    let (error, message) = refusal(&with("abi: 1.0\nname"));
    assert!(matches!(error, LoadError::Metadata { .. }));
    assert!(message.contains("line 2 is `name`"), "{message}");
    // The rule that a line breaks is told, and the place in each language.
    let place =
        "; change it in export_planner!, in VB_PLANNER_METADATA or in planner.yaml, and rebuild the plugin";
    for (was, is, told) in [
        ("name: probe", "name: C Lab", "line 2 is `name: C Lab`, but a name consists of a-z, 0-9, - and _"),
        (
            "control-period: 0.1",
            "control-period: 0.1 s",
            "line 6 is `control-period: 0.1 s`, but a control period is a positive multiple of 0.001, in seconds",
        ),
        (
            "about: b",
            "about: b\\t",
            "line 5 is `about: b\\t`, but only n, r or another backslash may follow a backslash",
        ),
        ("about: b", "help: b", "line 5 is `help: b`, but it must follow a param"),
        ("about: b", "about", "line 5 is `about`, but a line is `key: value`"),
        ("version: 1.0.0\n", "", "`version` is missing"),
    ] {
        let (error, message) = refusal(&with(&METADATA.replace(was, is)));
        assert!(matches!(error, LoadError::Metadata { .. }), "{message}");
        assert!(message.ends_with(&format!("{told}{place}")), "{message}");
    }
    let (error, message) = refusal(&with(&METADATA.replace("abi: 1.0", "abi: 1.1")));
    assert!(matches!(error, LoadError::AbiVersion { .. }));
    assert!(message.contains("built for planner ABI 1.1; this harness supports 1.0. Rebuild"), "{message}");
    // The version is read before the rest, which may have other rules there.
    let (error, message) = refusal(&with("abi: 1.3\nname\n"));
    assert!(matches!(error, LoadError::AbiVersion { .. }), "{message}");
    assert!(message.ends_with("Rebuild it with vb-sdk 1.0, or use a newer harness"), "{message}");
}

#[test]
fn the_imports_of_a_plugin_are_listed_without_running_it() {
    let names = |bytes: &[u8]| {
        let (_dir, path) = file(bytes);
        imports(&path).unwrap()
    };
    // What a core module gets for its exported resource is no import of the planner's.
    assert_eq!(names(&good()), ["vertibench:planner/host@1.0.0"]);
    let mut encoder = wit_component::ComponentEncoder::default().module(&good()).unwrap();
    let component = names(&encoder.encode().unwrap());
    assert!(component.contains(&"vertibench:planner/host@1.0.0".to_owned()), "{component:?}");
    assert!(component.iter().all(|name| name.starts_with("vertibench:planner/")), "{component:?}");
}

#[test]
fn imports_from_outside_are_refused_by_name() {
    let outside = r#"(component
        (import "wasi:http/outgoing-handler@0.2.0" (instance (export "handle" (func (result u64)))))
        (import "acme:files/disk@1.0.0" (instance (export "read" (func (result u64)))))
        (import "vertibench:planner/types@1.0.0" (instance (type (enum "a" "b")) (export "t" (type (eq 0))))))"#;
    let (error, message) = refusal(&with_metadata(wat::parse_str(outside).unwrap(), METADATA));
    assert_eq!(error.code().name(), "planner/import-denied");
    let LoadError::ForbiddenImports { imports, .. } = error else { panic!("{message}") };
    assert_eq!(imports, ["wasi:http/outgoing-handler@0.2.0", "acme:files/disk@1.0.0"]);
    // A core module that asks for more than the interface has.
    let greedy = planner_wat(OK, GO).replacen("(module", "(module (import \"env\" \"time\" (func))", 1);
    let (_, message) = refusal(&core_module(&greedy, METADATA));
    assert!(message.contains("imports env.time,") && message.contains("observation's `time`"), "{message}");
}

#[test]
fn a_plugin_that_is_too_large_is_refused_before_it_is_read() {
    let (_dir, path) = file(&good());
    let limits = Limits { module_bytes: 1000, ..Limits::default() };
    let error = Plugin::load(&path, &limits, None).unwrap_err();
    let LoadError::TooLarge { what, found, limit, .. } = &error else { panic!("{error}") };
    assert_eq!((*what, *found, *limit), ("bytes", good().len() as u64, 1000));
    assert_eq!(error.code().name(), "planner/too-large");
}
