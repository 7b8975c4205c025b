//! The planners of this repository as `cargo xtask plugins` builds them. Skipped where that hasn't been done.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::path::PathBuf;

use vb_host::{Limits, LoadError, LogSink, Plugin, PluginKind, ProcessOptions, inspect};
use vb_sdk::{Command, GridFrame, Map, Observation, Point2, Pose, Task, Vec3, Vehicle, Wheel, math};

/// A built planner, or a word on why the test is skipped.
fn built(file: &str) -> Option<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../target"), PathBuf::from);
    let path = target.join("plugins").join(file);
    if path.is_file() {
        return Some(path);
    }
    vb_testing::skip(format_args!("{} is missing; run `cargo xtask plugins`", path.display()));
    None
}

/// The worker that cargo builds with this crate.
fn native() -> ProcessOptions {
    ProcessOptions { worker: Some(env!("CARGO_BIN_EXE_vb-worker").into()), ..ProcessOptions::default() }
}

fn load(file: &str) -> Option<Plugin> {
    let limits = Limits {
        fuel_init: 50_000_000,
        fuel_per_step: 50_000_000,
        memory_bytes: 16 << 20,
        ..Limits::default()
    };
    built(file).map(|path| Plugin::load_with(&path, &limits, None, &native()).unwrap())
}

/// A winding path over a small map, with awkward numbers.
fn task(plugin: &Plugin, params: &[(&str, &str)]) -> Task {
    let given: Vec<_> = params.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let frame = GridFrame { rows: 9, cols: 9, resolution: 1.0, origin_x: -4.0, origin_y: -4.0 };
    Task {
        id: "w001/t01".into(),
        vehicle: Vehicle { scale: 1.0, wheelbase: 3.3, max_steer_angle: 0.6, ..Vehicle::default() },
        elevation: Some(Map { frame, data: (0..81u8).map(|i| f32::from(i) * 0.1).collect() }),
        semantics: Some(Map { frame, data: vec![3; 81] }),
        occupancy: Some(Map { frame, data: vec![0; 81] }),
        path: (0..200)
            .map(|i| Point2 { x: f64::from(i) * 0.7, y: 8.0 * math::sin(f64::from(i) * 0.07) })
            .collect(),
        time_limit: 60.0,
        control_period: 0.1,
        params: plugin.params(&given).unwrap(),
        ..Task::default()
    }
}

/// Drives a kinematic bicycle for 60 s and returns its commands.
fn drive(plugin: &Plugin, params: &[(&str, &str)]) -> Vec<Command> {
    let mut session = plugin.start(&task(plugin, params), LogSink::discard()).unwrap();
    let (mut x, mut y, mut yaw, mut speed) = (0.1, -1.3, 0.2, 0.0f64);
    let mut commands = Vec::new();
    for i in 0..600 {
        let observation = Observation {
            time: f64::from(i) * 0.1,
            wheels: vec![Wheel { spin: speed / 0.47, travel: 0.01 }; 4],
            ..Observation::of(Pose {
                position: Vec3 { x, y, z: 0.4 },
                yaw,
                linear_velocity: Vec3 { x: speed, ..Vec3::default() },
                ..Pose::default()
            })
        };
        let (command, _) = session.step(&observation).unwrap().clamped();
        speed += 0.1 * (4.0 * command.throttle - 6.0 * command.brake - 0.1 * speed);
        yaw += 0.1 * speed / 3.3 * math::tan(0.6 * command.steering);
        x += 0.1 * speed * math::cos(yaw);
        y += 0.1 * speed * math::sin(yaw);
        commands.push(command);
    }
    commands
}

fn bits(commands: &[Command]) -> Vec<[u64; 3]> {
    commands.iter().map(|c| [c.steering, c.throttle, c.brake].map(f64::to_bits)).collect()
}

#[test]
fn both_kinds_of_a_planner_give_the_same_commands_bit_for_bit() {
    for (name, param) in [("pid", ("kd", "0.3")), ("pursuit", ("speed", "5"))] {
        let (Some(wasm), Some(native)) = (load(&format!("{name}.wasm")), load(&format!("lib{name}.so")))
        else {
            return;
        };
        assert_eq!((wasm.kind(), native.kind()), (PluginKind::Wasm, PluginKind::Native));
        assert_eq!(wasm.metadata(), native.metadata());
        let (w, n) = (drive(&wasm, &[param]), drive(&native, &[param]));
        assert_eq!(bits(&w), bits(&n), "{name}");
        // It did something, and its parameter matters.
        assert!(w.iter().any(|c| c.steering > 0.1) && w.iter().any(|c| c.steering < -0.1), "{name}");
        assert_ne!(bits(&drive(&native, &[])), bits(&n), "{name}");
    }
}

#[test]
fn a_planners_metadata_are_those_of_its_crate() {
    for file in ["pid.wasm", "libpid.so"] {
        let Some(path) = built(file) else { return };
        let m = inspect(&path).unwrap();
        assert_eq!((m.name.as_str(), m.abi.as_str(), m.control_period), ("pid", "1.0", 0.1));
        assert_eq!(m.authors, [env!("CARGO_PKG_AUTHORS")]);
        let speed = m.params.iter().find(|p| p.key == "speed").unwrap();
        assert_eq!((speed.default.as_str(), speed.help.as_str()), ("5.0", "target speed, m/s at full scale"));
    }
}

#[test]
fn faults_are_the_same_with_both_kinds_where_a_native_planner_survives_them() {
    let (Some(wasm), Some(native)) = (load("faulty.wasm"), load("libfaulty.so")) else { return };
    for (fault, code, text) in [
        ("error", "planner/error", "step 3 (t = 0.00 s): returned an error: instructed to give up"),
        ("panic", "planner/panic", "examples/faulty/src/lib.rs"),
        ("nan", "planner/invalid-output", "step 3 (t = 0.00 s): steering is NaN; a command must be finite"),
        ("init-error", "planner/init-failed", "init: returned an error: instructed to give up"),
        ("init-panic", "planner/panic", "instructed to panic"),
    ] {
        let [w, n] = [&wasm, &native].map(|p| run_to_fault(p, fault));
        assert_eq!((w.code().name(), n.code().name()), (code, code));
        assert!(w.to_string().contains(text) && n.to_string().contains(text), "{w} | {n}");
        assert_eq!(w.to_string(), n.to_string());
    }
}

#[test]
fn a_wasm_planner_cannot_take_the_harness_down() {
    let Some(wasm) = load("faulty.wasm") else { return };
    for (fault, code) in [
        ("endless", "planner/out-of-fuel"),
        ("memory", "planner/out-of-memory"),
        ("stack", "planner/stack-overflow"),
    ] {
        for fault in [fault.to_owned(), format!("init-{fault}")] {
            let found = run_to_fault(&wasm, &fault);
            assert_eq!(found.code().name(), code, "{fault}: {found}");
            assert_eq!(run_to_fault(&wasm, &fault), found, "not the same twice");
        }
    }
}

fn run_to_fault(plugin: &Plugin, fault: &str) -> vb_host::PlannerFault {
    match plugin.start(&task(plugin, &[("fault", fault)]), LogSink::discard()) {
        Err(fault) => fault,
        Ok(mut session) => loop {
            if let Err(fault) = session.step(&Observation::default()) {
                return fault;
            }
        },
    }
}

#[test]
fn a_truncated_native_library_is_refused() {
    let Some(path) = built("libpid.so") else { return };
    let bytes = std::fs::read(path).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let cut = dir.path().join("cut.so");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let error = Plugin::load_with(&cut, &Limits::default(), None, &native()).unwrap_err();
    assert!(matches!(error, LoadError::Damaged { .. } | LoadError::Unloadable { .. }), "{error}");
    assert_eq!(error.to_string().lines().count(), 1);
}

#[test]
fn a_native_library_with_metadata_but_no_root_module_is_refused() {
    let Some(path) = built("libpid.so") else { return };
    // The symbol that the loader looks for, spelled differently.
    let mut bytes = std::fs::read(path).unwrap();
    let symbol = b"_1as_0lib_1header_0root_bmodule_bloader";
    let places: Vec<_> =
        bytes.windows(symbol.len()).enumerate().filter(|(_, w)| w == symbol).map(|(i, _)| i).collect();
    for i in places {
        bytes[i] = b'x';
    }
    let dir = tempfile::tempdir().unwrap();
    let other = dir.path().join("other.so");
    std::fs::write(&other, bytes).unwrap();
    let error = Plugin::load_with(&other, &Limits::default(), None, &native()).unwrap_err();
    assert!(matches!(error, LoadError::NotAPlugin { .. } | LoadError::Unloadable { .. }), "{error}");
}

#[test]
fn the_largest_planner_is_compiled_with_room() {
    let Some(any) = built("mppi.wasm") else { return };
    let size = |path: &PathBuf| path.metadata().unwrap().len();
    let files = std::fs::read_dir(any.parent().unwrap()).unwrap().map(|f| f.unwrap().path());
    let largest = files.filter(|f| f.extension().is_some_and(|e| e == "wasm")).max_by_key(size).unwrap();
    // Python's interpreter among them, where the planners in other languages were built: it needs 0.3 GB.
    let limits = Limits::default();
    let (compile_bytes, compile_seconds) = (limits.compile_bytes / 4, limits.compile_seconds / 4);
    let tight = Limits { compile_bytes, compile_seconds, ..limits };
    Plugin::load_with(&largest, &tight, None, &native()).unwrap();
}

#[test]
fn ten_megabytes_of_ordinary_code_are_compiled_with_room() {
    // Functions of a few hundred bytes each, as compilers make them: arithmetic, loads and stores, branches and calls.
    let body = "(local.set 1 (i32.add (local.get 0) (i32.load offset=64 (local.get 1))))
        (if (i32.gt_s (local.get 1) (i32.const 100)) (then (i32.store offset=128 (local.get 0) (local.get 1))))
        (f64.store offset=8 (local.get 0) (f64.mul (f64.load (local.get 0)) (f64.const 1.5)))";
    let function = |i: usize| {
        let call =
            if i == 0 { String::new() } else { format!("(call $f{} (local.get 1) (local.get 0))", i - 1) };
        format!("(func $f{i} (param i32 i32) {} {call})", body.repeat(8))
    };
    let items: String = (0..22_000).map(function).collect();
    let text = crate::common::planner_wat(
        "(call $ok_planner)",
        "(call $ok_command (f64.const 0) (f64.const 0) (f64.const 0))",
    );
    let text = text.replacen("(func $spin", &format!("{items} (func $spin"), 1);
    let module = crate::common::core_module(&text, crate::common::METADATA);
    assert!(module.len() > 7_000_000, "{}", module.len());
    let (_dir, path) = crate::common::file(&module);
    let limits = Limits::default();
    let (compile_bytes, compile_seconds) = (limits.compile_bytes / 2, limits.compile_seconds / 2);
    let tight = Limits { compile_bytes, compile_seconds, ..limits };
    Plugin::load_with(&path, &tight, None, &native()).unwrap();
}
