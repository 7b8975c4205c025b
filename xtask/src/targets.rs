//! Other systems: whether everything compiles for them, and whether what runs in an emulator gives the same bits.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

use crate::records::records;
use crate::run::{Failure, cargo_program, output, remove, run, step};
use crate::{built, default_plugin_dir, plugins, portable, root, target_dir};

/// The systems that releases are made for, and Windows with GNU's linker in place of Microsoft's.
pub(crate) const TARGETS: [&str; 5] = [
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "aarch64-apple-darwin",
    "x86_64-apple-darwin",
    "x86_64-pc-windows-gnu",
];
/// What is not checked here, and why.
const NOT_HERE: [(&str, &str); 1] =
    [("x86_64-pc-windows-msvc", "its C compiler is on Windows alone; the release workflow builds it there")];
/// What is checked: the program with all that it is made of, the Python package's module, and a planner as a native library.
const PACKAGES: [&str; 3] = ["vb-harness", "vb-python", "pid"];

/// The processor that is emulated by default.
const ARM: &str = "aarch64-unknown-linux-gnu";
/// Tasks that are driven on other systems and in emulators, which take fifty times as long: of worlds with all kinds of ground.
pub(crate) const TASKS: &str = "w001/t00,w004/t03,w008/t05";
/// Planners that drive them: one that computes little, and one with a network.
const PLANNERS: [&str; 2] = ["pid", "tnt"];
/// Where Debian puts the C library for the emulated processor.
const ARM_LIBRARIES: &str = "/usr/aarch64-linux-gnu";
/// x86-64 processors for planners, which need x86-64-v3: the first of 2013, and all that the emulator knows.
const DRIVING: [&str; 2] = ["Haswell", "max"];
/// The same for all else, which needs no more than a processor of 2008, without any AVX.
const TESTING: [&str; 2] = ["Nehalem", "max"];
/// What has tests of its bits, the arguments of `cargo test` that run them, and the x86-64 processors for them.
const TESTED: [(&str, &[&str], [&str; 2]); 3] = [
    ("the simulator", &["--package", "vb-sim", "--test", "all", "bits::"], TESTING),
    ("training", &["--package", "vb-model-train", "--lib", "the_same_bits_on_every_machine"], TESTING),
    ("planners' NaNs", &["--package", "vb-host", "--lib", "the_same_bits_on_every_machine"], DRIVING),
];

/// Checks each target, or all, and prints what came of it.
pub(crate) fn check(wanted: &[&str]) -> Result<(), Failure> {
    let targets = if wanted.is_empty() { &TARGETS[..] } else { wanted };
    let tools = portable::tools()?;
    let mut lines = Vec::new();
    let mut failed = 0;
    for target in targets {
        step(&format!("checking {target}"));
        let start = now();
        let result = portable::add_target(target).map(|()| {
            let mut command = portable::cargo(&tools, "check", target);
            command.args(PACKAGES.iter().flat_map(|name| ["--package", name]));
            // A module for any Python from 3.10 on, without one of that system.
            run(command.args(["--release", "--quiet"]).env("PYO3_NO_PYTHON", "1"))
        });
        let told = match result {
            Ok(Ok(())) => "compiles".to_owned(),
            Ok(Err(_)) => {
                failed += 1;
                "fails (the reason is told above)".to_owned()
            }
            Err(e) => format!("skipped: {e}"),
        };
        lines.push(format!("{target}: {told}, {:.0} s", start.elapsed().as_secs_f64()));
    }
    if wanted.is_empty() {
        lines.extend(NOT_HERE.map(|(target, reason)| format!("{target}: skipped: {reason}")));
    }
    lines.iter().for_each(|line| step(line));
    match failed {
        0 => Ok(()),
        n => Err(Failure::new(format!("{n} of {} targets fail", targets.len()))),
    }
}

/// Lets an emulated AArch64 and emulated x86-64 processors do what this machine does, and compares the bits.
pub(crate) fn emulate() -> Result<(), Failure> {
    for program in ["qemu-aarch64", "qemu-x86_64"] {
        if output(Command::new(program).arg("--version")).is_none() {
            return Err(Failure::new(format!("there is no {program}: install Debian's qemu-user")));
        }
    }
    if !Path::new(ARM_LIBRARIES).is_dir() {
        return Err(Failure::new(format!("there is no {ARM_LIBRARIES}: install Debian's libc6-arm64-cross")));
    }
    let tools = portable::tools()?;
    portable::add_target(ARM)?;
    let arm = ["qemu-aarch64", "-L", ARM_LIBRARIES].map(str::to_owned).to_vec();
    let x86 = |model: &str| ["qemu-x86_64", "-cpu", model].map(str::to_owned).to_vec();
    let mut lines = Vec::new();

    for (what, arguments, models) in TESTED {
        step(&format!("the test of the bits of {what}, for {ARM}"));
        test(portable::cargo(&tools, "test", ARM), arguments, ARM, &arm)?;
        lines.push(format!("{ARM}, emulated: {what} computes the same bits"));
        for model in models {
            step(&format!("the same for x86-64, a processor {model}"));
            let mut command = Command::new(cargo_program());
            command.arg("test").current_dir(root());
            test(command, arguments, "x86_64-unknown-linux-gnu", &x86(model))?;
            lines.push(format!("x86-64, emulated {model}: {what} computes the same bits"));
        }
    }

    crate::build_harness()?;
    PLANNERS.iter().try_for_each(|name| plugins::build_one(name, &default_plugin_dir()))?;
    let arm_program = portable::program(ARM, &tools, &[])?;
    let mut machines = vec![(format!("{ARM}, emulated"), arm_program, arm)];
    machines.extend(DRIVING.map(|m| (format!("x86-64, emulated {m}"), built("vb-harness"), x86(m))));
    for planner in PLANNERS {
        step(&format!("driving {TASKS} with {planner} on this machine"));
        let here = drive(planner, "here", &built("vb-harness"), &[])?;
        for (name, program, emulator) in &machines {
            step(&format!("the same on {name}"));
            let there = drive(planner, name, program, emulator)?;
            compare(&here, &there).map_err(|e| Failure::new(format!("{name}, {planner}: {e}")))?;
            lines.push(format!("{name}: {} tasks with {planner}.wasm, the same records", there.len()));
        }
    }
    lines.iter().for_each(|line| step(line));
    Ok(())
}

/// Runs tests of bits by an emulator.
fn test(mut command: Command, arguments: &[&str], target: &str, emulator: &[String]) -> Result<(), Failure> {
    let variable = format!("CARGO_TARGET_{}_RUNNER", target.to_uppercase().replace('-', "_"));
    command.args(["--release", "--quiet"]);
    // With the features that dependencies have in the program, so that they aren't built twice.
    command.args(["--package", "vb-unify"]).args(arguments);
    run(command.env(variable, emulator.join(" ")))
}

/// The records of a run by an emulator, or by this machine without one.
fn drive(planner: &str, name: &str, program: &Path, emulator: &[String]) -> Result<Vec<Value>, Failure> {
    let folder = target_dir().join("emulated");
    let out = folder.join(format!("{planner}-{}", name.replace([' ', ','], "-")));
    let failure = |e: std::io::Error| Failure::new(format!("{}: {e}", out.display()));
    remove(&out)?;
    std::fs::create_dir_all(&out).map_err(failure)?;
    let words: Vec<String> = emulator.iter().cloned().chain([program.display().to_string()]).collect();
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).arg("run").current_dir(root());
    command.arg("--plugin").arg(default_plugin_dir().join(format!("{planner}.wasm")));
    command.args(["--suite", "smoke", "--tasks", TASKS, "--trace", "none", "--seed", "1", "--out"]);
    command.arg(out.join("run")).stdout(Stdio::null());
    // What is compiled for one processor is none of another's.
    command.env("VB_CACHE", out.join("cache"));
    if !emulator.is_empty() {
        command.env("VB_WORKER", worker(&out, &words).map_err(failure)?);
    }
    run(&mut command)?;
    records(&out.join("run"))
}

/// A script that starts the program in the emulator again: the system can't do it by itself.
fn worker(folder: &Path, words: &[String]) -> std::io::Result<PathBuf> {
    let script = folder.join("worker.sh");
    let words: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    std::fs::write(&script, format!("#!/bin/sh\nexec {} \"$@\"\n", words.join(" ")))?;
    #[cfg(unix)]
    std::fs::set_permissions(&script, std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
    Ok(script)
}

/// Fails with the first difference.
fn compare(here: &[Value], there: &[Value]) -> Result<(), Failure> {
    if here.len() != there.len() || here.is_empty() {
        return Err(Failure::new(format!("{} records here, {} there", here.len(), there.len())));
    }
    for (a, b) in here.iter().zip(there) {
        let fields = a.as_object().into_iter().flatten();
        let differs = |(key, value): &(&String, &Value)| b.get(key.as_str()) != Some(value);
        // The state hash says most.
        let first = ["state_hash"].into_iter().find(|key| a[*key] != b[*key]).map(str::to_owned);
        if let Some(key) = first.or_else(|| fields.clone().find(differs).map(|(key, _)| key.clone())) {
            return Err(Failure::new(format!(
                "{}: {key} is {} here and {} there",
                a["task"], a[&key], b[&key]
            )));
        }
        if a != b {
            return Err(Failure::new(format!("{}: there are more fields there", a["task"])));
        }
    }
    Ok(())
}

#[allow(clippy::disallowed_methods, reason = "how long a check takes is told, and nothing depends on it")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_first_difference_is_told_and_the_state_hash_before_all() {
        let here = [json!({"task": "w001/t00", "fuel": 1, "state_hash": "x"})];
        let differs = |b: Value| compare(&here, &[b]).unwrap_err().to_string();
        assert!(compare(&here, &here).is_ok());
        let b = json!({"task": "w001/t00", "fuel": 2, "state_hash": "y"});
        let told = differs(b);
        assert!(told.contains("state_hash is \"x\" here and \"y\" there"), "{told}");
        let b = json!({"task": "w001/t00", "fuel": 2, "state_hash": "x"});
        assert!(differs(b).contains("fuel is 1 here"));
        let b = json!({"task": "w001/t00", "fuel": 1, "state_hash": "x", "more": 1});
        assert!(differs(b).contains("more fields"));
        assert!(compare(&here, &[]).is_err() && compare(&[], &[]).is_err());
    }
}
