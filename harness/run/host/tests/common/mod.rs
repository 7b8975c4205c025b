//! Plugin files made in place.

#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

use vb_host::{Limits, LogSink, Plugin};
use vb_sdk::{LogLevel, Observation, Task};

/// Metadata of the smallest planner.
pub const METADATA: &str =
    "abi: 1.0\nname: probe\nversion: 1.0.0\nauthors: A\nabout: b\ncontrol-period: 0.1\n";

/// A planner as WebAssembly text: `init` and `step` are the bodies of the two functions of the interface, in the
/// canonical ABI. `init` gets a pointer to the task and `step` the planner's handle and a pointer to the
/// observation, both as `$args`; each returns a pointer to its result. Helpers: `$ok_planner` and `$ok_command` make
/// good results (the command of three f64 given), `$log` the host's log.
pub fn planner_wat(init: &str, step: &str) -> String {
    format!(
        r#"(module
  (import "vertibench:planner/host@1.0.0" "log" (func $log (param i32 i32 i32)))
  (import "[export]vertibench:planner/guest@1.0.0" "[resource-new]planner" (func $new (param i32) (result i32)))
  (memory (export "memory") 4)
  (table $table 1 funcref)
  (data (i32.const 16) "hello log")
  (data (i32.const 32) "panicked at src/lib.rs:3:5:\nindex out of bounds")
  (data (i32.const 96) "no way out")
  (global $heap (mut i32) (i32.const 4096))
  (global $calls (mut i32) (i32.const 0))
  (func (export "cabi_realloc") (param i32 i32 i32 i32) (result i32)
    (local $p i32)
    (local.set $p (i32.and (i32.add (global.get $heap) (i32.const 15)) (i32.const -16)))
    (global.set $heap (i32.add (local.get $p) (local.get 3)))
    (local.get $p))
  (func $ok_planner (result i32)
    (i32.store (i32.const 1024) (i32.const 0))
    (i32.store (i32.const 1028) (call $new (i32.const 7)))
    (i32.const 1024))
  (func $ok_command (param f64 f64 f64) (result i32)
    (i32.store (i32.const 2048) (i32.const 0))
    (f64.store (i32.const 2056) (local.get 0))
    (f64.store (i32.const 2064) (local.get 1))
    (f64.store (i32.const 2072) (local.get 2))
    (i64.store (i32.const 2080) (i64.const 0))
    (i32.store (i32.const 2088) (i32.const 0))
    (i32.const 2048))
  (func $spin (loop $l (br $l)))
  (func $hog (loop $l (br_if $l (i32.ne (memory.grow (i32.const 16)) (i32.const -1)))) unreachable)
  (func $tables
    (loop $l (br_if $l (i32.ne (table.grow $table (ref.null func) (i32.const 1000)) (i32.const -1)))) unreachable)
  (func $fail unreachable)
  (func $recurse (call $recurse) (call $fail))
  (func (export "vertibench:planner/guest@1.0.0#[static]planner.init") (param $args i32) (result i32) {init})
  (func (export "vertibench:planner/guest@1.0.0#[method]planner.step") (param $args i32) (result i32)
    (global.set $calls (i32.add (global.get $calls) (i32.const 1)))
    {step}))"#
    )
}

/// A core module from text, with its component type and the metadata, as the Rust compiler would leave it.
pub fn core_module(wat: &str, metadata: &str) -> Vec<u8> {
    core_module_of(wat, metadata, &[])
}

/// The same with more packages of WIT, of which the last has a world `probe` to be used in place of the planner's own.
pub fn core_module_of(wat: &str, metadata: &str, packages: &[&str]) -> Vec<u8> {
    let mut module = wat::parse_str(wat).unwrap();
    let mut resolve = wit_parser::Resolve::default();
    let wit = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../sdk/wit/v1_0");
    let (mut package, _) = resolve.push_path(wit).unwrap();
    for text in packages {
        package = resolve.push_str("more.wit", text).unwrap();
    }
    let name = if packages.is_empty() { "planner-plugin" } else { "probe" };
    let world = resolve.select_world(&[package], Some(name)).unwrap();
    wit_component::embed_component_metadata(
        &mut module,
        &resolve,
        world,
        wit_component::StringEncoding::UTF8,
    )
    .unwrap();
    with_metadata(module, metadata)
}

/// The bytes with a custom section that holds the metadata.
pub fn with_metadata(mut module: Vec<u8>, metadata: &str) -> Vec<u8> {
    let name = "vb:planner";
    module.push(0);
    leb128(&mut module, 1 + name.len() + metadata.len());
    leb128(&mut module, name.len());
    module.extend(name.as_bytes());
    module.extend(metadata.as_bytes());
    module
}

fn leb128(out: &mut Vec<u8>, mut value: usize) {
    while value >= 128 {
        out.push(value as u8 | 128);
        value >>= 7;
    }
    out.push(value as u8);
}

/// A file in a folder of its own, which lives as long as the result.
pub fn file(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("probe.wasm");
    std::fs::write(&path, bytes).unwrap();
    (dir, path)
}

/// A loaded planner with these bodies of `init` and `step`.
pub fn plugin(init: &str, step: &str, limits: &Limits) -> Plugin {
    let (_dir, path) = file(&core_module(&planner_wat(init, step), METADATA));
    Plugin::load(&path, limits, None).unwrap()
}

pub fn task() -> Task {
    Task { id: "w001/t01".into(), ..Task::default() }
}

pub fn observation() -> Observation {
    Observation { time: 0.5, ..Observation::default() }
}

/// Lines of a log, as they came.
pub type Lines = Arc<Mutex<Vec<(LogLevel, String)>>>;

/// A sink that keeps the lines.
pub fn keeper() -> (LogSink, Lines) {
    let lines = Lines::default();
    let kept = Arc::clone(&lines);
    (LogSink::new(move |level, line| kept.lock().unwrap().push((level, line.to_owned()))), lines)
}

/// Compiles a C planner of `tests/hostile`, or any other file, into a library, with macros as `NAME=VALUE`; none where
/// there is no compiler.
pub fn compile_c(source: &Path, library: &Path, macros: &[&str]) -> Option<()> {
    let macros: Vec<String> = macros.iter().map(|text| format!("-D{text}")).collect();
    compile_c_with(source, library, &macros.iter().map(String::as_str).collect::<Vec<_>>())
}

/// The same with any options of the compiler.
pub fn compile_c_with(source: &Path, library: &Path, options: &[&str]) -> Option<()> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile").join(source);
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../sdk/c");
    let mut command = Command::new("cc");
    command.args(["-O1", "-fPIC", "-shared", "-w", "-pthread", "-I"]).arg(header);
    let Ok(built) = command.args(options).arg("-o").arg(library).arg(source).output() else {
        vb_testing::skip("there is no C compiler");
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(())
}
