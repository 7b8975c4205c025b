//! Files that are no planners, or planners that want what they don't get.

use std::path::Path;

use rustix::fs::{CWD, FileType, Mode, mknodat};
use vb_host::FaultCode::{self, *};

use crate::Ends::Load;
use crate::common::{METADATA, core_module, core_module_of, planner_wat, with_metadata};
use crate::wasm::{GO, OK, importing};
use crate::{Case, Source, case};

fn file(name: &'static str, bytes: Vec<u8>, code: FaultCode, says: &'static str) -> Case {
    case(name, Source::File(bytes), Load, code, says)
}

fn place(name: &'static str, make: fn(&Path), code: FaultCode, says: &'static str) -> Case {
    case(name, Source::Place(make), Load, code, says)
}

fn good() -> Vec<u8> {
    core_module(&planner_wat(OK, GO), METADATA)
}

/// A component from text, with the metadata.
fn planner_component(text: &str) -> Vec<u8> {
    with_metadata(wat::parse_str(text).unwrap(), METADATA)
}

/// The good planner with one line of its metadata replaced.
fn metadata(from: &str, to: &str) -> Vec<u8> {
    assert!(METADATA.contains(from));
    core_module(&planner_wat(OK, GO), &METADATA.replace(from, to))
}

/// SplitMix64 (Steele, Lea, Flood 2014) after some first bytes.
fn random_after(first: &[u8]) -> Vec<u8> {
    let mut state = 2025u64;
    let words = (0..512).flat_map(|_| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)).to_le_bytes()
    });
    first.iter().copied().chain(words).collect()
}

pub fn table() -> Vec<Case> {
    [no_files(), no_plugins(), other_plugins(), greedy(), refused_code(), costly()].concat()
}

fn no_files() -> Vec<Case> {
    vec![
        place("nothing", |_| {}, NotFound, "no such plugin file"),
        place("a folder", |path| std::fs::create_dir(path).unwrap(), Unreadable, "can't read the plugin"),
        // Opening it waits until somebody writes into it.
        place(
            "a pipe that nobody writes into",
            |path| mknodat(CWD, path, FileType::Fifo, Mode::from_raw_mode(0o600), 0).unwrap(),
            Unreadable,
            "not a regular file",
        ),
        place(
            "a device without end",
            |path| std::os::unix::fs::symlink("/dev/zero", path).unwrap(),
            Unreadable,
            "not a regular file",
        ),
        place(
            "a link to itself",
            |path| std::os::unix::fs::symlink(path, path).unwrap(),
            Unreadable,
            "can't read the plugin",
        ),
    ]
}

fn no_plugins() -> Vec<Case> {
    let whole = good();
    let half = whole[..whole.len() / 2].to_vec();
    let component = wit_component::ComponentEncoder::default().module(&whole).unwrap().encode().unwrap();
    let deep = format!("{}{}", "(component ".repeat(20), ")".repeat(20));
    let many = format!("(component {})", "(core module)".repeat(1001));
    let mut giant = whole.clone();
    // One more custom section: any size is valid.
    giant.extend([&[0, 0x80, 0x80, 0x80, 0x04, 0][..], &vec![0; (8 << 20) - 1]].concat());
    let kind = "neither WebAssembly nor a native library";
    vec![
        file("no bytes", Vec::new(), NotAPlugin, "empty"),
        file("a script", b"#!/usr/bin/env python\n".to_vec(), NotAPlugin, kind),
        file("random bytes", random_after(b""), NotAPlugin, kind),
        file("random bytes that begin as WASM", random_after(b"\0asm\x01\0\0\0"), Damaged, "damaged"),
        file(
            "random bytes that begin as a component",
            random_after(b"\0asm\x0d\0\x01\0"),
            Damaged,
            "damaged",
        ),
        file(
            "random bytes that begin as a library",
            random_after(b"\x7fELF\x02\x01\x01\0"),
            Damaged,
            "damaged",
        ),
        file("half a planner", half, Damaged, "rebuild it"),
        file("half a component", component[..component.len() / 2].to_vec(), Damaged, "rebuild it"),
        file("a giant planner", giant, TooLarge, "the limit is 4194304"),
        file(
            "components in components",
            planner_component(&deep),
            TooLarge,
            "17 levels of nested components; the limit is 16",
        ),
        file(
            "too many modules",
            planner_component(&many),
            TooLarge,
            "1001 modules and components inside; the limit is 1000",
        ),
        file(
            "a module of something else",
            wat::parse_str("(module)").unwrap(),
            NotAPlugin,
            "planner interface",
        ),
        file("a component of something else", wat::parse_str("(component)").unwrap(), NotAPlugin, "metadata"),
    ]
}

fn other_plugins() -> Vec<Case> {
    let other_world = core_module_of(
        r#"(module (func (export "run")))"#,
        METADATA,
        &["package test:probe; world probe { export run: func(); }"],
    );
    let other_functions = r#"(component
        (core module $m (func (export "f")))
        (core instance $i (instantiate $m))
        (func $f (canon lift (core func $i "f")))
        (instance $guest (export "step" (func $f)))
        (export "vertibench:planner/guest@1.0.0" (instance $guest)))"#;
    let guest = "vertibench:planner/guest@1.0.0";
    vec![
        file("metadata without a planner", planner_component("(component)"), NotAPlugin, guest),
        file("an interface without its functions", core_module("(module)", METADATA), NotAPlugin, ""),
        file("another world", other_world, NotAPlugin, guest),
        file("another interface of the same name", planner_component(other_functions), NotAPlugin, guest),
        file("another version of the interface", metadata("abi: 1.0", "abi: 1.1"), AbiMismatch, "ABI 1.1"),
        file("a version that is none", metadata("abi: 1.0", "abi: new"), AbiMismatch, "ABI new"),
        file(
            "metadata that are cut",
            core_module(&planner_wat(OK, GO), "abi: 1.0\nname"),
            Metadata,
            "line 2",
        ),
        file("metadata without a name", metadata("name: probe\n", ""), Metadata, "name"),
        file("a name that is none", metadata("probe", "../../probe"), Metadata, "name"),
        file("a period of 0", metadata("period: 0.1", "period: 0"), Metadata, "control-period"),
        file(
            "a period that is no number",
            metadata("period: 0.1", "period: NaN"),
            Metadata,
            "control-period",
        ),
    ]
}

fn greedy() -> Vec<Case> {
    let import = |name: &str| {
        planner_component(&format!(
            r#"(component (import "{name}" (instance (export "get" (func (result u64))))))"#
        ))
    };
    vec![
        file("an import of files", import("acme:files/disk@1.0.0"), ImportDenied, "acme:files/disk@1.0.0"),
        file("an import of HTTP", import("wasi:http/outgoing-handler@0.2.0"), ImportDenied, "wasi:http"),
        importing(
            "a core import of a clock",
            r#"(import "env" "emscripten_get_now" (func (result f64)))"#,
            GO,
            (Load, ImportDenied, "env"),
        ),
        importing(
            "a core import of a browser",
            r#"(import "__wbindgen_placeholder__" "__wbindgen_throw" (func (param i32 i32)))"#,
            GO,
            (Load, ImportDenied, "__wbindgen_placeholder__"),
        ),
    ]
}

fn refused_code() -> Vec<Case> {
    let planner = |step: &str| core_module(&planner_wat(OK, &format!("{step} {GO}")), METADATA);
    let relaxed = "(drop (i32x4.relaxed_trunc_f32x4_s (v128.const i32x4 0 0 0 0)))";
    let shared = planner_wat(OK, GO).replacen(
        "(memory (export \"memory\") 4)",
        "(memory (export \"memory\") 4 8 shared)",
        1,
    );
    vec![
        // Encoded without validation: nothing is on the stack.
        file(
            "code that is not valid",
            planner_component("(component (core module (func (result i32) i32.add)))"),
            Unloadable,
            "",
        ),
        file("instructions that differ between processors", planner(relaxed), Unloadable, "relaxed SIMD"),
        file("memory for threads", core_module(&shared, METADATA), NotAPlugin, ""),
    ]
}

/// Files of some kilobytes or megabytes that take a compiler gigabytes, or minutes.
fn costly() -> Vec<Case> {
    /// The good planner with functions more.
    fn with(items: &str) -> Vec<u8> {
        let text = planner_wat(OK, GO).replacen("(func $spin", &format!("{items} (func $spin"), 1);
        core_module(&text, METADATA)
    }
    // A function with so many variables, and a body.
    let function =
        |locals: usize, body: &str| with(&format!("(func (local {}) {body})", "i32 ".repeat(locals)));
    let each = |locals: usize, text: fn(usize) -> String| (0..locals).map(text).collect::<String>();
    let change = |i: usize| format!("local.get {i} i32.const 1 i32.add local.set {i} ");
    let loops = |depth: usize, locals: usize| {
        let end = "local.get 0 br_if 0 end ";
        format!("{} {} {}", "loop ".repeat(depth), each(locals, change), end.repeat(depth))
    };
    let row = |depth: usize, locals: usize| {
        format!("loop {} local.get 0 br_if 0 end ", each(locals, change)).repeat(depth)
    };
    let branches =
        |count: usize, locals: usize| format!("local.get 0 if {} end ", each(locals, change)).repeat(count);
    let table = |targets: usize, locals: usize| {
        let blocks = "block ".repeat(targets);
        let table = each(targets, |i| format!("{i} "));
        let ends: String = (0..targets).map(|i| format!("end {} ", change(i % locals))).collect();
        format!("{blocks} local.get 0 br_table {table} {ends}")
    };
    let takes = "compiling the plugin takes more than";
    let cases = [
        ("loops in loops of many variables", function(2000, &loops(3000, 2000))),
        ("loops after loops of many variables", function(2000, &row(100, 2000))),
        ("a table of branches between many variables", function(1000, &table(20_000, 1000))),
        ("hundreds of thousands of functions", with(&"(func)".repeat(900_000))),
        ("branches after branches of many variables", function(1800, &branches(220, 1800))),
    ];
    cases.map(|(name, bytes)| file(name, bytes, TooCostly, takes)).into()
}
