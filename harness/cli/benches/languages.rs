//! What a planner costs in each language: `cargo bench --package vb-harness --bench languages`, after
//! `cargo xtask plugins` and `cargo xtask examples`.
//!
//! Prints a table, of which docs/performance.md has the figures. Times of compiling are processor time, so that two
//! cores count twice; the others are the best of several tries, by the clock.

#![allow(clippy::print_stdout, reason = "a table is what this is for")]
#![allow(clippy::disallowed_methods, reason = "it measures time; no score is near")]

use std::path::Path;
use std::time::{Duration, Instant};

use vb_host::{Limits, LogSink, Plugin};
use vb_sdk::{GridFrame, Map, Observation, Point2, Pose, Task, Vec3, Vehicle, Wheel};

/// Tries of what is quick.
const TRIES: usize = 20;
/// Steps of one try.
const STEPS: u32 = 1000;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let target = std::env::current_exe()?;
    let target = target.ancestors().nth(3).ok_or("the bench lies in cargo's target folder")?.to_owned();
    println!("| planner | size | compile | load from the cache | start and init | step | fuel a step |");
    println!("|---|---|---|---|---|---|---|");
    for name in ["pursuit", "pursuit-c", "pursuit-js", "pursuit-python"] {
        let file = target.join("plugins").join(format!("{name}.wasm"));
        if file.is_file() {
            measure(name, &file)?;
        } else {
            eprintln!("skipped: {} is missing; run `cargo xtask examples`", file.display());
        }
    }
    Ok(())
}

fn measure(name: &str, file: &Path) -> Result<()> {
    let cache = tempfile::tempdir()?;
    let limits = Limits::default();
    let load = || Plugin::load(file, &limits, Some(cache.path()));
    let before = processor_time();
    let plugin = load()?;
    let compile = processor_time() - before;
    let cached = best(|| load().map(drop))?;
    let task = task(&plugin)?;
    let start = best(|| plugin.start(&task, LogSink::discard()).map(drop))?;
    let mut session = plugin.start(&task, LogSink::discard())?;
    let step = best(|| {
        for i in 0..STEPS {
            session.step(&observation(f64::from(i)))?;
        }
        Ok::<_, Box<dyn std::error::Error>>(())
    })?;
    let fuel = session.fuel().ok_or("a WASM planner uses fuel")?;
    println!(
        "| {name} | {:.2} MB | {:.2} s | {:.1} ms | {:.2} ms | {:.1} µs | {} |",
        std::fs::metadata(file)?.len() as f64 / 1e6,
        compile.as_secs_f64(),
        1e3 * cached.as_secs_f64(),
        1e3 * start.as_secs_f64(),
        1e6 * step.as_secs_f64() / f64::from(STEPS),
        fuel.steps / (TRIES as u64 * u64::from(STEPS)),
    );
    Ok(())
}

/// The shortest of several tries.
fn best<E>(mut work: impl FnMut() -> std::result::Result<(), E>) -> std::result::Result<Duration, E> {
    let mut shortest = Duration::MAX;
    for _ in 0..TRIES {
        let start = Instant::now();
        work()?;
        shortest = shortest.min(start.elapsed());
    }
    Ok(shortest)
}

/// Processor time of this process, in steps of 10 ms; the clock's where the system doesn't tell it.
fn processor_time() -> Duration {
    let ticks = || -> Option<u64> {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        // Fields 14 and 15, user and system time in hundredths of a second; the second field may hold spaces.
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
    };
    thread_local!(static START: Instant = Instant::now());
    ticks().map_or_else(|| START.with(Instant::elapsed), |t| Duration::from_millis(10 * t))
}

/// A task of ordinary size: a map of 129 × 129 samples and a path of 200 points.
fn task(plugin: &Plugin) -> Result<Task> {
    let frame = GridFrame { rows: 129, cols: 129, resolution: 1.0, origin_x: -64.0, origin_y: -64.0 };
    let samples = 129 * 129;
    Ok(Task {
        id: "w001/t01".into(),
        vehicle: Vehicle { scale: 1.0, wheelbase: 3.3, max_steer_angle: 0.6, ..Vehicle::default() },
        elevation: Some(Map { frame, data: vec![0.0; samples] }),
        semantics: Some(Map { frame, data: vec![3; samples] }),
        occupancy: Some(Map { frame, data: vec![0; samples] }),
        path: (0..200).map(|i| Point2 { x: 0.5 * f64::from(i), y: 0.0 }).collect(),
        time_limit: 60.0,
        control_period: 0.1,
        params: plugin.params(&[])?,
        ..Task::default()
    })
}

/// On the way along the path, always at the same place: so every step has the same work to do.
fn observation(step: f64) -> Observation {
    Observation {
        time: 0.1 * step,
        wheels: vec![Wheel { spin: 2.0, travel: 0.01 }; 4],
        ..Observation::of(Pose {
            position: Vec3 { x: 20.0, y: 0.3, z: 0.4 },
            linear_velocity: Vec3 { x: 1.0, y: 0.0, z: 0.0 },
            ..Pose::default()
        })
    }
}
