//! What a step costs beyond the planner's own work when the planner is in a process of its own: a C planner that returns
//! at once.

#![allow(clippy::unwrap_used, reason = "a bench")]

use std::path::Path;
use std::process::Command;

use criterion::{Criterion, criterion_group, criterion_main};
use vb_host::{Limits, LogSink, Plugin, ProcessOptions};
use vb_sdk::{Observation, Pose, Task, Wheel};

fn step(c: &mut Criterion) {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dir = tempfile::tempdir().unwrap();
    let library = dir.path().join("hostile.so");
    let mut compile = Command::new("cc");
    compile.args(["-O2", "-fPIC", "-shared", "-w", "-pthread", "-I"]).arg(here.join("../../../sdk/c"));
    assert!(
        compile.arg("-o").arg(&library).arg(here.join("tests/hostile/hostile.c")).status().unwrap().success()
    );
    let options =
        ProcessOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), ..ProcessOptions::default() };
    let plugin = Plugin::load_with(&library, &Limits::default(), None, &options).unwrap();
    let task = Task { params: plugin.params(&[]).unwrap(), ..Task::default() };
    let mut session = plugin.start(&task, LogSink::discard()).unwrap();
    let wheels = vec![Wheel { spin: 1.0, travel: 0.01 }; 4];
    let observation =
        Observation { time: 0.5, wheels, ..Observation::of(Pose { yaw: 1.25, ..Pose::default() }) };
    c.bench_function("native step", |b| b.iter(|| session.step(&observation).unwrap()));
    drop(session);
    c.bench_function("native task in a process that is there", |b| {
        b.iter(|| plugin.start(&task, LogSink::discard()).unwrap());
    });
    c.bench_function("native load", |b| {
        b.iter(|| Plugin::load_with(&library, &Limits::default(), None, &options).unwrap());
    });
}

criterion_group!(benches, step);
criterion_main!(benches);
