//! Cost of hosting a WASM planner: `cargo bench -p vb-host`.

// Helpers of benches may unwrap as benches do.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use vb_host::{Limits, LogSink, Plugin};

#[path = "../tests/common/mod.rs"]
mod common;

use common::{METADATA, core_module, file, observation, plugin, task};

const OK: &str = "(call $ok_planner)";
/// Its allocator never frees: each step begins where the one before did.
const GO: &str =
    "(global.set $heap (i32.const 4096)) (call $ok_command (f64.const 0.25) (f64.const 0.5) (f64.const 0))";

/// A step of a planner that does nothing: what remains is the harness's own cost. The aim is below 2 µs.
fn step(c: &mut Criterion) {
    for (name, wasm_watchdog) in [("a step that does nothing", false), ("the same with the watchdog", true)] {
        let plugin = plugin(OK, GO, &Limits { wasm_watchdog, ..Limits::default() });
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        let observation = observation();
        c.bench_function(name, |b| b.iter(|| session.step(black_box(&observation)).unwrap()));
    }
}

/// A loop of a million units, with and without the watchdog: what its checks cost.
fn compute(c: &mut Criterion) {
    // Ten units a round: a recurrence of 64-bit integers.
    let work = format!(
        "(local $n i64) (local $x i64)
         (local.set $n (i64.const 100000))
         (loop $l
           (local.set $x (i64.add (i64.mul (local.get $x) (i64.const 6364136223846793005)) (local.get $n)))
           (br_if $l (i64.ne (local.tee $n (i64.sub (local.get $n) (i64.const 1))) (i64.const 0))))
         (i64.store (i32.const 3000) (local.get $x))
         {GO}"
    );
    for (name, wasm_watchdog) in [("100 000 rounds of a loop", false), ("the same with the watchdog ", true)]
    {
        let (_dir, path) = file(&core_module(&with_locals(&work), METADATA));
        let plugin = Plugin::load(&path, &Limits { wasm_watchdog, ..Limits::default() }, None).unwrap();
        let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
        let observation = observation();
        c.bench_function(name, |b| b.iter(|| session.step(black_box(&observation)).unwrap()));
    }
}

/// The work in a function of its own, since locals come first in a function.
fn with_locals(work: &str) -> String {
    common::planner_wat(OK, "(call $work)").replacen(
        "(func $spin",
        &format!("(func $work (result i32) {work})\n  (func $spin"),
        1,
    )
}

/// A million units of which each is a load that waits for the one before and misses every cache: the most time that we know fuel
/// to take (docs/abi.md). The chain leads through 128 MiB in the order of a linear congruential generator of full period.
fn dependent_loads(c: &mut Criterion) {
    let chain = "(local $i i32)
         (loop $l
           (i32.store (i32.add (i32.const 1048576) (i32.shl (local.get $i) (i32.const 6)))
             (i32.add (i32.const 1048576) (i32.shl (i32.and (i32.const 2097151)
               (i32.add (i32.mul (local.get $i) (i32.const 1664525)) (i32.const 1013904223))) (i32.const 6))))
           (br_if $l (i32.ne (local.tee $i (i32.add (local.get $i) (i32.const 1))) (i32.const 2097152))))
         (i32.store (i32.const 3000) (i32.const 1048576))";
    let work = format!(
        "(local $n i32) (local $p i32)
         (local.set $n (i32.const 1000))
         (local.set $p (i32.load (i32.const 3000)))
         (loop $l
           local.get $p {} local.set $p
           (br_if $l (local.tee $n (i32.sub (local.get $n) (i32.const 1)))))
         (i32.store (i32.const 3000) (local.get $p))",
        "i32.load ".repeat(1000)
    );
    let wat = common::planner_wat(&format!("(call $chain) {OK}"), &format!("(call $work) {GO}"))
        .replacen("\"memory\") 4", "\"memory\") 2100", 1)
        .replacen("(func $spin", &format!("(func $chain {chain}) (func $work {work}) (func $spin"), 1);
    let (_dir, path) = file(&core_module(&wat, METADATA));
    let plugin = Plugin::load(&path, &Limits::default(), None).unwrap();
    let mut session = plugin.start(&task(), LogSink::discard()).unwrap();
    let observation = observation();
    session.step(&observation).unwrap();
    let fuel = session.fuel().unwrap().steps;
    assert!((1_000_000..1_020_000).contains(&fuel), "a load costs one unit: {fuel}");
    let mut group = c.benchmark_group("a million units of fuel");
    group.sample_size(20).bench_function("of loads that wait for each other", |b| {
        b.iter(|| session.step(black_box(&observation)).unwrap());
    });
    group.finish();
}

/// A plugin of a megabyte: loaded from the cache and put on a task. The aim is below 10 ms.
fn cached_start(c: &mut Criterion) {
    let mut body = String::new();
    for i in 0..4400 {
        let _ = write!(body, "(func $f{i} (param i64) (result i64) (local.get 0)");
        for k in 0..24 {
            let _ = write!(
                body,
                "(i64.const {}) i64.mul (i64.const {k}) i64.xor",
                i * 7919 + k * 104_729 + 1_000_003
            );
        }
        body += ")\n";
    }
    let wat = common::planner_wat(OK, GO).replacen("(func $spin", &format!("{body}(func $spin"), 1);
    let bytes = core_module(&wat, METADATA);
    let (dir, path) = file(&bytes);
    let cache = dir.path().join("cache");
    let load = |cache: Option<&Path>| Plugin::load(&path, &Limits::default(), cache).unwrap();
    load(Some(&cache));
    let name = format!("cached start of a plugin of {:.2} MB", bytes.len() as f64 * 1e-6);
    c.bench_function(&name, |b| {
        b.iter(|| load(Some(&cache)).start(black_box(&task()), LogSink::discard()).unwrap());
    });
    let mut group = c.benchmark_group("compilation of the same");
    group.sample_size(10).bench_function("without the cache", |b| b.iter(|| load(None)));
    group.finish();
}

criterion_group!(benches, step, compute, dependent_loads, cached_start);
criterion_main!(benches);
