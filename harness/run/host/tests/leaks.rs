//! What a thousand plugins leave in the harness's process. The process is looked at as a whole, so this file has one test.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

mod common;

use std::path::{Path, PathBuf};

use common::{METADATA, core_module, observation, planner_wat, task};
use vb_host::{Limits, LogSink, Plugin, ProcessOptions};

/// Rounds, in which each plugin is loaded once.
const ROUNDS: usize = 1000;
/// Rounds after which memory has to stay as it is.
const SETTLED: usize = 200;
/// The most that memory may grow in the other rounds, bytes: a kilobyte for each. A compiled plugin, its store or the
/// buffers of a process are many times that.
const MARGIN: usize = (ROUNDS - SETTLED) * 1024;

/// What the process has: bytes of resident memory that are its own, open descriptors and threads.
fn possessions() -> (usize, usize, usize) {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: Vec<usize> = statm.split_whitespace().map(|n| n.parse().unwrap()).collect();
    let entries = |path: &str| std::fs::read_dir(path).unwrap().count();
    ((pages[1] - pages[2]) * rustix::param::page_size(), entries("/proc/self/fd"), entries("/proc/self/task"))
}

/// Loads a plugin, has it drive a step, and unloads it.
fn visit(path: &Path) {
    let limits = Limits { fuel_per_step: 100_000, ..Limits::default() };
    let worker = Some(env!("CARGO_BIN_EXE_vb-worker").into());
    let options = ProcessOptions { worker, ..ProcessOptions::default() };
    let Ok(plugin) = Plugin::load_with(path, &limits, None, &options) else { return };
    let Ok(mut session) = plugin.start(&task(), LogSink::discard()) else { return };
    let _ = session.step(&observation());
}

#[test]
fn a_thousand_loads_and_unloads_do_not_grow_memory() {
    let dir = tempfile::tempdir().unwrap();
    let go = "(call $ok_command (f64.const 0) (f64.const 0) (f64.const 0))";
    let planner = |init: &str, step: &str| core_module(&planner_wat(init, step), METADATA);
    let good = planner("(call $ok_planner)", go);
    let files = [
        ("good", good.clone()),
        ("endless", planner("(call $ok_planner)", "(call $spin) unreachable")),
        ("invalid", planner("i64.add", go)),
        ("damaged", good[..good.len() / 2].to_vec()),
    ];
    let mut paths: Vec<PathBuf> = Vec::new();
    for (name, bytes) in files {
        paths.push(dir.path().join(name));
        std::fs::write(paths.last().unwrap(), bytes).unwrap();
    }
    let native = dir.path().join("steady.so");
    paths.extend(common::compile_c(Path::new("steady.c"), &native, &["PART=0.5"]).map(|()| native));
    let mut settled = (0, 0, 0);
    for round in 0..ROUNDS {
        paths.iter().for_each(|path| visit(path));
        if round + 1 == SETTLED {
            settled = possessions();
        }
    }
    let now = possessions();
    assert_eq!((now.1, now.2), (settled.1, settled.2), "descriptors and threads");
    let grown = now.0.saturating_sub(settled.0);
    eprintln!("{grown} bytes more after {ROUNDS} rounds than after {SETTLED}, of {}", settled.0);
    assert!(grown <= MARGIN, "{} bytes after {SETTLED} rounds, {} after {ROUNDS}", settled.0, now.0);
}
