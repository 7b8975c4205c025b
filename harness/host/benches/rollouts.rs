//! What a sampling planner costs in WASM and natively, 1000 roll-outs of 20 steps through a network of 6-64-64-6 units
//! (`examples/rollouts`): `cargo bench -p vb-host --bench rollouts`, after
//! `cargo xtask plugins`.
//!
//! Prints a table, the one of docs/abi.md: medians of alternating steps, so that both meet the same machine, and the fuel
//! of a step. The native planner is in its sandboxed process, as in a run.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a table is what this is for")]
#![allow(clippy::disallowed_methods, reason = "it measures time; no score is near")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use vb_host::{Limits, LogSink, NativeOptions, Plugin, Session};
use vb_sdk::{Observation, Point2, Task, Vec3, Vehicle};

/// Steps of each carrier.
const STEPS: u32 = 200;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let target = std::env::current_exe()?;
    let plugins = target.ancestors().nth(3).ok_or("the bench lies in cargo's target folder")?.join("plugins");
    let names = ["rollouts.wasm".to_owned(), native_name()];
    let files = names.map(|name| plugins.join(name));
    if let Some(missing) = files.iter().find(|f| !f.is_file()) {
        eprintln!("skipped: {} is missing; run `cargo xtask plugins`", missing.display());
        return Ok(());
    }
    println!("| network | native | WASM | ratio | fuel a step |");
    println!("|---|---|---|---|---|");
    for arithmetic in ["float", "fixed"] {
        compare(arithmetic, &files)?;
    }
    Ok(())
}

fn compare(arithmetic: &str, files: &[PathBuf; 2]) -> Result<()> {
    let [wasm, native] = files;
    let (mut wasm, mut native) = (start(wasm, arithmetic)?, start(native, arithmetic)?);
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
        assert_eq!(commands[0], commands[1], "both carriers compute the same bits");
    }
    let [wasm_s, native_s] = times.map(median);
    let fuel = wasm.fuel().ok_or("a WASM planner uses fuel")?.steps / u64::from(STEPS);
    println!(
        "| {arithmetic} | {:.2} ms | {:.2} ms | {:.2} | {:.0} million |",
        1e3 * native_s,
        1e3 * wasm_s,
        wasm_s / native_s,
        fuel as f64 / 1e6
    );
    Ok(())
}

fn native_name() -> String {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    format!("{DLL_PREFIX}rollouts{DLL_SUFFIX}")
}

fn start(file: &Path, arithmetic: &str) -> Result<Session> {
    let options =
        NativeOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), require_sandbox: false };
    let plugin = Plugin::load_with(file, &Limits::default(), None, &options)?;
    let params = plugin.params(&[("arithmetic".to_owned(), arithmetic.to_owned())])?;
    let vehicle = Vehicle { scale: 1.0, wheelbase: 3.3, max_steer_angle: 0.5, ..Vehicle::default() };
    let path = (0..60).map(|i| Point2 { x: 2.0 * f64::from(i), y: 0.0 }).collect();
    let task = Task { path, vehicle, params, seed: 1, ..Task::default() };
    Ok(plugin.start(&task, LogSink::discard())?)
}

fn observation(i: f64) -> Observation {
    Observation {
        time: 0.1 * i,
        position: Vec3 { x: 0.4 * i, y: 1.0, z: 0.5 },
        linear_velocity: Vec3 { x: 4.0, ..Vec3::default() },
        ..Observation::default()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
