//! What a step of the planners that come with the project costs in WASM and natively: `cargo bench -p vb-host --bench
//! planners`, after `cargo xtask plugins`. `rollouts` (examples) draws 1000 courses of 20 steps through a network of
//! 6-64-64-6 units, `mppi` as many with a bicycle.
//!
//! Prints a table, with the figures of docs/performance.md and docs/planners.md: medians of alternating steps, so that
//! both meet the same machine, and the fuel of a step. The native planner is in its sandboxed process, as in a run.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a table is what this is for")]
#![allow(clippy::disallowed_methods, reason = "it measures time; no score is near")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use vb_host::{Limits, LogSink, Plugin, ProcessOptions, Session};
use vb_sdk::{GridFrame, Map, Observation, Point2, Pose, Task, Vec3, Vehicle};

/// Steps of each kind.
const STEPS: u32 = 200;

/// Planners and the parameters that are set.
const PLANNERS: [(&str, &[(&str, &str)]); 11] = [
    ("pid", &[]),
    ("eh", &[]),
    ("mppi", &[]),
    ("wmvct", &[]),
    ("mppi6", &[]),
    ("tal", &[]),
    ("tnt", &[]),
    ("ibex", &[]),
    ("rl", &[]),
    ("rollouts", &[("arithmetic", "float")]),
    ("rollouts", &[("arithmetic", "fixed")]),
];

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let target = std::env::current_exe()?;
    let plugins = target.ancestors().nth(3).ok_or("the bench lies in cargo's target folder")?.join("plugins");
    println!("| planner | native | WASM | ratio | fuel a step |");
    println!("|---|---|---|---|---|");
    for (name, params) in PLANNERS {
        let files = [format!("{name}.wasm"), native_name(name)].map(|file| plugins.join(file));
        if let Some(missing) = files.iter().find(|f| !f.is_file()) {
            eprintln!("skipped: {} is missing; run `cargo xtask plugins`", missing.display());
            continue;
        }
        compare(name, params, &files)?;
    }
    Ok(())
}

fn compare(name: &str, params: &[(&str, &str)], files: &[PathBuf; 2]) -> Result<()> {
    let [wasm, native] = files;
    let (mut wasm, mut native) = (start(wasm, params)?, start(native, params)?);
    let mut times = [Vec::new(), Vec::new()];
    for i in 0..STEPS {
        let observation = observation(f64::from(i));
        let commands = [&mut wasm, &mut native].into_iter().zip(&mut times).map(|(session, times)| {
            let begin = Instant::now();
            let command = session.step(&observation)?;
            times.push(begin.elapsed().as_secs_f64());
            Ok(command)
        });
        let commands = commands.collect::<Result<Vec<_>>>()?;
        assert_eq!(commands[0], commands[1], "both kinds of plugin compute the same bits");
    }
    let [wasm_s, native_s] = times.map(median);
    let fuel = wasm.fuel().ok_or("a WASM planner uses fuel")?.steps / u64::from(STEPS);
    let set: Vec<_> = params.iter().map(|(key, value)| format!(", {key} {value}")).collect();
    println!(
        "| {name}{} | {:.3} ms | {:.3} ms | {:.2} | {:.2} million |",
        set.concat(),
        1e3 * native_s,
        1e3 * wasm_s,
        wasm_s / native_s,
        fuel as f64 / 1e6
    );
    Ok(())
}

fn native_name(name: &str) -> String {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    format!("{DLL_PREFIX}{name}{DLL_SUFFIX}")
}

fn start(file: &Path, params: &[(&str, &str)]) -> Result<Session> {
    let options =
        ProcessOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), ..ProcessOptions::default() };
    let plugin = Plugin::load_with(file, &Limits::default(), None, &options)?;
    let params: Vec<_> = params.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let params = plugin.params(&params)?;
    let vehicle = Vehicle {
        scale: 1.0,
        name: "hmmwv".into(),
        wheelbase: 3.3,
        track: 1.8,
        wheel_radius: 0.47,
        width: 2.2,
        max_steer_angle: 0.5,
        min_turn_radius: 7.4,
        max_steer_rate: 2.0,
        max_speed: 30.0,
        ..Vehicle::default()
    };
    let path = (0..60).map(|i| Point2 { x: 2.0 * f64::from(i), y: 0.0 }).collect();
    let grid = |n: u32, resolution: f64| {
        let origin = -0.5 * f64::from(n - 1) * resolution;
        GridFrame { rows: n, cols: n, resolution, origin_x: origin, origin_y: origin }
    };
    // A world's maps: waves of half a metre, a block every 16 m.
    let wave = |i: u32| 0.5 * vb_sdk::math::sin(0.7 * f64::from(i % 129)) as f32;
    let elevation = Map { frame: grid(129, 1.0), data: (0..129 * 129).map(wave).collect() };
    let block = |i: u32| u8::from((i % 256) % 32 < 4 && (i / 256) % 32 < 4);
    let occupancy = Map { frame: grid(256, 0.5), data: (0..256 * 256).map(block).collect() };
    let semantics = Map { frame: grid(129, 1.0), data: vec![2; 129 * 129] };
    let task = Task {
        path,
        vehicle,
        params,
        elevation: Some(elevation),
        occupancy: Some(occupancy),
        semantics: Some(semantics),
        control_period: 0.1,
        seed: 1,
        ..Task::default()
    };
    Ok(plugin.start(&task, LogSink::discard())?)
}

fn observation(i: f64) -> Observation {
    Observation {
        time: 0.1 * i,
        ..Observation::of(Pose {
            position: Vec3 { x: 0.4 * i, y: 1.0, z: 0.5 },
            linear_velocity: Vec3 { x: 4.0, ..Vec3::default() },
            ..Pose::default()
        })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
