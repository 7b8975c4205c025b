//! Bad input ends in one line – what, where, what to do – with the documented exit code, and never in a panic.

use std::fs;
use std::path::Path;

use vb_tests::{Bench, Done, PluginKind, copy_dir, pid, plugin};

/// Exit codes of docs/results.md.
const USAGE: i32 = 2;
const BAD_INPUT: i32 = 3;
const OUTPUT: i32 = 4;

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// The command must fail with this code and say all of this.
fn refused(bench: &Bench, args: &[&str], code: i32, says: &[&str]) {
    let error = bench.run(args).error(code);
    for part in says {
        assert!(error.contains(part), "{args:?}: {part:?} is not in {error:?}");
    }
}

/// As [`refused`], and the run must have written nothing.
fn not_started(bench: &Bench, args: &[&str], code: i32, says: &[&str]) {
    refused(bench, args, code, says);
    assert!(!bench.path("runs").exists(), "{args:?}: nothing is written for a run that can't start");
}

#[test]
fn a_plugin_that_can_not_be_one_is_refused_by_run_and_inspect() {
    let bench = Bench::new();
    let (wasm, native) = (fs::read(pid()), fs::read(plugin("pid", PluginKind::Native)));
    let (wasm, native) = (wasm.expect("pid.wasm"), native.expect("libpid"));
    let half = |bytes: &[u8]| bytes[..bytes.len() / 2].to_vec();
    // The metadata is text in a section of either file (docs/abi.md); both versions have the same length.
    let aged = |bytes: &[u8]| replaced(bytes, b"abi: 1.0", b"abi: 9.7");
    let bent = |bytes: &[u8]| replaced(bytes, b"control-period: 0.1", b"control-period: soo");
    let files: [(&str, Vec<u8>, &[&str]); 12] = [
        ("text.wasm", b"this is no plugin".to_vec(), &["not a planner plugin", "neither"]),
        ("empty.wasm", Vec::new(), &["empty", "rebuild it"]),
        ("short.wasm", b"\0as".to_vec(), &["not a planner plugin"]),
        // A core module and a component with nothing in them: magic number, version, layer.
        ("core.wasm", b"\0asm\x01\0\0\0".to_vec(), &["not a planner plugin", "export_planner!"]),
        ("component.wasm", b"\0asm\x0d\0\x01\0".to_vec(), &["no planner metadata", "export_planner!"]),
        ("torn.wasm", b"\0asm\x0d\0\x01\0\0\xff".to_vec(), &["truncated or damaged", "rebuild it"]),
        ("half.wasm", half(&wasm), &["truncated or damaged", "rebuild it"]),
        ("half.so", half(&native), &["truncated or damaged", "rebuild it"]),
        ("aged.wasm", aged(&wasm), &["planner ABI 9.7", "supports 1.0", "Rebuild"]),
        ("aged.so", aged(&native), &["planner ABI 9.7", "supports 1.0", "Rebuild"]),
        ("bent.wasm", bent(&wasm), &["control-period", "soo"]),
        ("bent.so", bent(&native), &["control-period", "soo"]),
    ];
    for (name, bytes, says) in &files {
        bench.write(name, bytes);
        let says = &[says, &[*name][..]].concat();
        not_started(&bench, &["--plugin", name], BAD_INPUT, says);
        refused(&bench, &["inspect", "--plugin", name], BAD_INPUT, says);
    }
    // A whole native program that is no planner: this one. (The harness itself is larger than a plugin may be.)
    let program = std::env::current_exe().expect("the test's own file");
    let others: [(&str, &str); 3] = [
        ("gone.wasm", "no such plugin file"),
        (".", "can't read the plugin"),
        (text(&program), "no planner metadata"),
    ];
    for (name, says) in others {
        not_started(&bench, &["--plugin", name], BAD_INPUT, &[name, says]);
        refused(&bench, &["inspect", "--plugin", name], BAD_INPUT, &[name, says]);
    }
}

#[test]
fn a_plugin_that_is_nearly_named_is_suggested() {
    let bench = Bench::new();
    bench.write("hill_fox.wasm", fs::read(pid()).expect("pid.wasm"));
    bench.write("mine.py", "print('no harness here')");
    bench.write("libmine.rlib", b"!<arch>\n");
    let cases: [(&str, &[&str]); 5] = [
        ("hill-fox.wasm", &["hill-fox.wasm", "did you mean hill_fox.wasm?"]),
        ("target/release/libmine.so", &["no such plugin file", "crate-type = [\"cdylib\"]"]),
        ("libmine.rlib", &["static library", "crate-type = [\"cdylib\"]"]),
        ("mine.py", &["--plugin \"python3 mine.py\""]),
        ("pyton3 mine.py", &["pyton3", "a program in the PATH"]),
    ];
    for (name, says) in cases {
        not_started(&bench, &["--plugin", name], BAD_INPUT, says);
        refused(&bench, &["inspect", "--plugin", name], BAD_INPUT, says);
    }
}

#[test]
fn a_planner_in_the_folder_of_planners_is_found_by_its_file_name() {
    let bench = Bench::new();
    let folder = pid().parent().expect("it lies in a folder").to_owned();
    let inspect = |name: &str| {
        Done::of(bench.command(&["inspect", "--plugin", name, "--json"]).env("VB_PLUGINS", &folder))
    };
    assert!(inspect("pid.wasm").ok().contains("\"name\":\"pid\""));
    let told = inspect("gone.wasm").error(BAD_INPUT);
    let elsewhere = format!("it is not in {} (VB_PLUGINS) either", folder.display());
    assert!(told.contains("gone.wasm: no such plugin file") && told.contains(&elsewhere), "{told}");
    // A path is looked up nowhere else, and the working directory comes first.
    let told = inspect("./pid.wasm").error(BAD_INPUT);
    assert!(!told.contains("VB_PLUGINS"), "{told}");
    bench.write("pid.wasm", "no planner");
    assert!(inspect("pid.wasm").error(BAD_INPUT).contains("not a planner plugin"));
}

/// Every command of it is out of range: the scores are those of what the vehicle was let do.
#[test]
fn clamped_commands_are_told_at_the_end_of_a_run() {
    let bench = Bench::new();
    let faulty = plugin("faulty", PluginKind::Wasm);
    let run = |fault: &str| {
        let fault = format!("fault={fault}");
        bench.ok(&["--plugin", text(&faulty), "--tasks", "w001/t00", "--param", &fault, "--out", &fault])
    };
    let told = run("range");
    let record = &bench.records("fault=range")["w001/t00"];
    let (clamped, commands) = (&record["clamped"], &record["planner_steps"]);
    let wanted = format!("{clamped} of {commands} commands were out of range and clamped");
    assert!(clamped.as_u64() > Some(0) && told.contains(&wanted), "{wanted}: {told}");
    assert!(!run("none").contains("clamped"));
}

/// The bytes with one text, which must be there, in place of another of the same length.
fn replaced(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
    assert_eq!(old.len(), new.len());
    let mut bytes = bytes.to_vec();
    let places: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i..].starts_with(old)).collect();
    assert!(!places.is_empty(), "{} is not there", String::from_utf8_lossy(old));
    for at in places {
        bytes[at..at + new.len()].copy_from_slice(new);
    }
    bytes
}

/// What is done to a file of a suite.
enum Damage {
    Gone,
    /// Cut to this share of its length.
    Cut(f64),
    /// One text, which must be there, replaced by another where it first stands.
    Text(&'static str, &'static str),
}

#[test]
fn a_damaged_suite_is_refused_with_file_field_and_value() {
    use Damage::{Cut, Gone, Text};
    let bench = Bench::new();
    bench.ok(&["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "good"]);
    let plugin = pid();
    let cases: [(&str, Damage, &[&str]); 23] = [
        ("suite.yaml", Gone, &["cannot read", "name a suite's folder"]),
        ("suite.yaml", Cut(0.0), &["unexpected end"]),
        ("suite.yaml", Cut(0.8), &["worlds[0]"]),
        ("suite.yaml", Text("schema: 1", "schema: yes"), &["schema", "\"yes\"", "line 1"]),
        ("suite.yaml", Text("schema: 1", "schema: 7"), &["version 7", "version 1"]),
        ("suite.yaml", Text("elevation: low", "elevation: steep"), &["worlds[0].elevation", "steep", "low"]),
        ("suite.yaml", Text("name:", "title:"), &["title"]),
        ("worlds/w001/world.yaml", Gone, &["cannot read", "each world needs"]),
        ("worlds/w001/world.yaml", Cut(0.3), &["line"]),
        ("worlds/w001/world.yaml", Text("pitch: 1.0", "pitch: wide"), &["grid.pitch", "\"wide\""]),
        ("worlds/w001/world.yaml", Text("pitch: 1.0", "pitch: .nan"), &["grid.pitch", ".nan"]),
        ("worlds/w001/elevation.png", Gone, &["cannot read", "each world needs"]),
        ("worlds/w001/elevation.png", Cut(0.5), &["not a whole PNG image", "restore it"]),
        ("worlds/w001/semantics.yaml", Gone, &["cannot read", "each world needs"]),
        ("worlds/w001/semantics.yaml", Cut(0.5), &["line"]),
        ("worlds/w001/semantics.yaml", Text("patch: 8.0", "patch: [8]"), &["patch"]),
        ("worlds/w001/obstacles.yaml", Gone, &["cannot read", "each world needs"]),
        ("worlds/w001/obstacles.yaml", Cut(0.5), &["obstacles", "line"]),
        ("worlds/w001/obstacles.yaml", Text("buried: ", "buried: deep"), &["obstacles[0].buried", "deep"]),
        ("worlds/w001/tasks.yaml", Gone, &["cannot read", "each world needs"]),
        ("worlds/w001/tasks.yaml", Cut(0.5), &["tasks[", "line"]),
        ("worlds/w001/tasks.yaml", Text("goal: [-60.0, 0.0]", "goal: west"), &["tasks[0].goal", "\"west\""]),
        (
            "worlds/w001/tasks.yaml",
            Text("goal: [-60.0", "goal: [-600.0"),
            &["tasks[0].goal", "-600", "±64 m"],
        ),
    ];
    for (i, (file, damage, says)) in cases.iter().enumerate() {
        let suite = format!("bad{i}");
        copy_dir(&bench.path("good"), &bench.path(&suite));
        let path = bench.path(&suite).join(file);
        match damage {
            Gone => fs::remove_file(path).expect("it is there"),
            Cut(fraction) => {
                let bytes = fs::read(&path).expect("it is there");
                fs::write(path, &bytes[..(bytes.len() as f64 * fraction) as usize])
                    .expect("it can be written");
            }
            Text(old, new) => {
                let content = fs::read_to_string(&path).expect("it is there");
                assert!(content.contains(old), "{old} is not in {file}");
                fs::write(path, content.replacen(old, new, 1)).expect("it can be written");
            }
        }
        let says = &[says, &[*file][..]].concat();
        let suite = format!("./{suite}");
        refused(&bench, &["suite", "validate", &suite], BAD_INPUT, says);
        refused(&bench, &["--plugin", text(&plugin), "--suite", &suite], BAD_INPUT, says);
    }
    assert!(!bench.path("runs").exists(), "bad input is found before anything is written");
    // An image of another size, whole in itself.
    bench.ok(&["suite", "generate", "--seed", "2", "--worlds", "1", "--out", "other"]);
    let world = bench.path("good/worlds/w001/world.yaml");
    let smaller = fs::read_to_string(&world).expect("it is there").replace("rows: 129", "rows: 128");
    fs::write(world, smaller).expect("it can be written");
    refused(&bench, &["suite", "validate", "./good"], BAD_INPUT, &["elevation.png", "129", "128"]);
    // Changed but well formed: the hash tells.
    fs::copy(bench.path("good/worlds/w001/tasks.yaml"), bench.path("other/worlds/w001/tasks.yaml"))
        .expect("copied");
    refused(&bench, &["suite", "validate", "./other"], BAD_INPUT, &["w001", "hash", "changed or damaged"]);
}

/// A world of 9 × 9 pixels in the original's layout (docs/making-suites.md), made here.
struct Original {
    config: String,
    bitmap: Vec<u8>,
    labels: Vec<u8>,
}

impl Original {
    fn new() -> Self {
        let config = "\
obstacle_density: sparse
obstacles: {rocks: [], trees: []}
positions:
  - {start: [-3.0, 0.0, 0.1], goal: [3.0, 0.0, 0.1]}
terrain: {difficulty: low, length: 4.5, width: 4.5, min_height: 0.0, max_height: 4.8}
terrain_type: rigid
textures:
  - {index: [0, 0], is_deformable: false, terrain_type: grass, friction: 0.6}
";
        Self { config: config.into(), bitmap: bitmap(9), labels: labels(9, 81) }
    }

    fn write(&self, bench: &Bench, dir: &str) {
        bench.write(&format!("{dir}/sampled_maps/Configs/Final/config1_low.yaml"), &self.config);
        bench.write(&format!("{dir}/sampled_maps/Configs/Final/labels1_low.npy"), &self.labels);
        bench.write(&format!("{dir}/sampled_maps/Worlds/1.bmp"), &self.bitmap);
    }

    fn with(old: &str, new: &str) -> Self {
        let good = Self::new();
        assert!(good.config.contains(old), "{old}");
        Self { config: good.config.replacen(old, new, 1), ..good }
    }
}

/// A grey Windows bitmap of this many pixels along a side: headers, palette, rows padded to four bytes.
fn bitmap(side: u32) -> Vec<u8> {
    let stride = side.div_ceil(4) * 4;
    let mut bytes = b"BM".to_vec();
    let header = [1078 + stride * side, 0, 1078, 40, side, side, 8 << 16 | 1, 0, stride * side, 0, 0, 256, 0];
    bytes.extend(header.iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend((0..=255u8).flat_map(|v| [v, v, v, 0]));
    bytes.resize(bytes.len() + (stride * side) as usize, 100);
    bytes
}

/// A NumPy array of `count` labels 3 – grass in the original's list – that states `side` × `side` of them.
fn labels(side: u32, count: usize) -> Vec<u8> {
    let header = format!("{{'descr': '<i4', 'fortran_order': False, 'shape': ({side}, {side}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(std::iter::repeat_n(3i32.to_le_bytes(), count).flatten());
    bytes
}

const CONFIG: &str = "config1_low.yaml";
const BITMAP: &str = "1.bmp";
const LABELS: &str = "labels1_low.npy";

#[test]
fn damaged_data_of_the_original_is_refused_with_file_field_and_value() {
    let bench = Bench::new();
    Original::new().write(&bench, "good");
    let told = bench.ok(&["suite", "import", "good", "--out", "imported"]);
    assert!(told.contains("1 worlds, 1 tasks"), "what is damaged below is whole here: {told}");

    let good = Original::new;
    let cases: Vec<(Original, &[&str])> = vec![
        (Original { bitmap: bitmap(12), ..good() }, &[BITMAP, "12 x 12", "9 x 9"]),
        (Original { bitmap: bitmap(9)[..1100].to_vec(), ..good() }, &[BITMAP, "1100 bytes", "truncated"]),
        (Original { bitmap: b"GIF89a".to_vec(), ..good() }, &[BITMAP, "not a Windows bitmap"]),
        (Original { bitmap: Vec::new(), ..good() }, &[BITMAP]),
        (Original { labels: labels(9, 80), ..good() }, &[LABELS, "80 values", "(9, 9)"]),
        (Original { labels: labels(12, 144), ..good() }, &[LABELS, "(12, 12)", "(9, 9)"]),
        (Original { labels: labels(9, 81)[..30].to_vec(), ..good() }, &[LABELS, "truncated"]),
        (Original { labels: b"x".to_vec(), ..good() }, &[LABELS, "not a NumPy array"]),
        (Original { config: String::new(), ..good() }, &[CONFIG]),
        (Original { config: good().config[..150].to_owned(), ..good() }, &[CONFIG]),
        (Original::with("length: 4.5", "length: long"), &[CONFIG, "terrain.length", "\"long\""]),
        (Original::with("width: 4.5", "width: 5.5"), &[CONFIG, "terrain.width", "5.5", "square"]),
        (Original::with("difficulty: low", "difficulty: high"), &[CONFIG, "terrain.difficulty", "high"]),
        (
            Original::with("friction: 0.6", "friction: slippery"),
            &[CONFIG, "textures[0].friction", "slippery"],
        ),
        (Original::with("friction: 0.6", "friction: -0.6"), &[CONFIG, "-0.6"]),
        (
            Original::with("terrain_type: grass", "terrain_type: lava"),
            &[CONFIG, "textures[0].terrain_type", "lava"],
        ),
        (Original::with("goal: [3.0", "goal: [30.0"), &[CONFIG, "positions[0]"]),
        (Original::with("start: [-3.0, 0.0, 0.1]", "start: [-3.0]"), &[CONFIG, "positions[0].start"]),
    ];
    for (i, (original, says)) in cases.iter().enumerate() {
        let (from, to) = (format!("bad{i}"), format!("out{i}"));
        original.write(&bench, &from);
        refused(&bench, &["suite", "import", &from, "--out", &to], BAD_INPUT, says);
    }
    for (i, file) in [BITMAP, LABELS].iter().enumerate() {
        let (from, to) = (format!("gone{i}"), format!("none{i}"));
        Original::new().write(&bench, &from);
        let folder = if *file == BITMAP { "Worlds" } else { "Configs/Final" };
        fs::remove_file(bench.path(format!("{from}/sampled_maps/{folder}/{file}"))).expect("it is there");
        refused(&bench, &["suite", "import", &from, "--out", &to], BAD_INPUT, &[file, "each world needs"]);
    }
    bench.write("other/notes.txt", "no maps here");
    for from in ["other", "other/notes.txt", "nowhere"] {
        refused(
            &bench,
            &["suite", "import", from, "--out", "none"],
            BAD_INPUT,
            &[from, "no world found", "give"],
        );
    }
}

#[test]
fn what_the_command_line_names_must_exist() {
    let bench = Bench::new();
    let pid = pid();
    let pid = text(&pid);
    let cases: [(&[&str], i32, &[&str]); 24] = [
        (&["--tasks", "w999"], USAGE, &["w999", "w001"]),
        (&["--tasks", "w001/t77"], USAGE, &["w001/t77", "t00"]),
        (&["--tasks", "w001-w999"], USAGE, &["w999"]),
        (&["--tasks", "elevation=steep"], USAGE, &["steep", "low"]),
        (&["--tasks", "colour=red"], USAGE, &["colour", "elevation"]),
        (&["--tasks", ","], USAGE, &[","]),
        (&["--tasks", ""], USAGE, &["selector"]),
        (&["--param", "sped=5"], USAGE, &["sped", "speed"]),
        (&["--param", "speed=5", "--param", "speed=4"], USAGE, &["speed", "once"]),
        (&["--param", "speed"], USAGE, &["speed", "KEY=VALUE"]),
        (&["--trace", "5hz"], USAGE, &["5hz", "10hz"]),
        (&["--scale", "0"], USAGE, &["--scale", "1/10"]),
        (&["--jobs", "0"], USAGE, &["0", "--jobs"]),
        (&["--seed", "many"], USAGE, &["many", "--seed"]),
        (&["--memory", "lots"], USAGE, &["lots", "256M"]),
        (&["--sped", "5"], USAGE, &["--sped"]),
        (&["--suite", "nowhere"], BAD_INPUT, &["nowhere", "smoke, testbed, vb-100"]),
        (&["--rules", "papper"], BAD_INPUT, &["papper", "paper, release, dev"]),
        (&["--vehicle", "bicycle"], BAD_INPUT, &["bicycle", "hmmwv"]),
        (&["--soils", "slush"], BAD_INPUT, &["slush", "default, original, wong"]),
        (&["--soil-resolution", "5"], USAGE, &["--soil-resolution", "0.01 to 0.5"]),
        (&["--time-step", "3ms"], USAGE, &["--time-step", "divides 10ms", "seconds"]),
        (&["--time-step", "1"], USAGE, &["--time-step", "divides 10ms"]),
        (&["--tasks", "elevation=high:terrain=rigid"], USAGE, &["elevation=high,terrain=rigid"]),
    ];
    for (args, code, says) in cases {
        not_started(&bench, &[&["--plugin", pid][..], args].concat(), code, says);
    }
    let others: [(&[&str], i32, &[&str]); 9] = [
        (&[], USAGE, &["run pid.wasm"]),
        (&["run"], USAGE, &["one planner", "--plugin"]),
        (&["--plugin"], USAGE, &["--plugin"]),
        (&["drive"], USAGE, &["drive"]),
        (&["score"], USAGE, &["RUN"]),
        (&["score", "nothing"], BAD_INPUT, &["nothing", "run.json"]),
        (&["suite", "show", "nowhere"], BAD_INPUT, &["nowhere", "smoke, testbed, vb-100"]),
        (&["suite", "validate", "./nowhere"], BAD_INPUT, &["nowhere/suite.yaml"]),
        (&["tasks", "list", "--tasks", "w999"], USAGE, &["w999"]),
    ];
    for (args, code, says) in others {
        refused(&bench, args, code, says);
    }
}

#[test]
fn rules_vehicles_and_soils_are_refused_with_file_field_and_value() {
    let bench = Bench::new();
    let pid = pid();
    let tasks = vb_tests::root().join("tasks");
    let cases: [(&str, &str, &str, &[&str]); 13] = [
        ("--rules", "time_limit_s: 60.0", "time_limit_s: soon", &["time_limit_s", "soon"]),
        ("--rules", "time_limit_s: 60.0", "time_limit_s: -1", &["time_limit_s", "-1"]),
        ("--rules", "time_limit_s: 60.0", "", &["time_limit_s"]),
        ("--rules", "radius_m: 10.0", "radius_km: 10.0", &["success", "radius_km"]),
        ("--rules", "schema: 1", "schema: 8", &["schema", "8"]),
        ("--rules", "when: end", "when: sometimes", &["rollover.when", "sometimes"]),
        ("--vehicle", "length: 4.6706 ", "length: long", &["length", "long"]),
        ("--vehicle", "mass: 2060.2", "mass: -1", &["mass", "-1"]),
        ("--vehicle", "schema: 1", "schema: 8", &["schema", "8"]),
        ("--vehicle", "chassis:", "chassis: [", &["line"]),
        ("--soils", "exponent: 1.1", "exponent: 9.9", &["soils.", "exponent: 9.9 must lie in"]),
        ("--soils", "snow: {soft: soft-snow", "snow: {soft: slush", &["classes.snow.soft", "slush"]),
        ("--soils", "cohesion: ", "stickiness: ", &["stickiness"]),
    ];
    for (i, (option, old, new, says)) in cases.iter().enumerate() {
        let source = match *option {
            "--rules" => "rules/paper.yaml",
            "--soils" => "soils/default.yaml",
            _ => "vehicles/hmmwv.yaml",
        };
        let good = fs::read_to_string(tasks.join(source)).expect("a file of the project");
        assert!(good.contains(old), "{old} is not in {source}");
        let name = format!("bad{i}.yaml");
        bench.write(&name, good.replacen(old, new, 1));
        let says = &[says, &[name.as_str()][..]].concat();
        not_started(&bench, &["--plugin", text(&pid), option, &name], BAD_INPUT, says);
    }
    for option in ["--rules", "--vehicle", "--soils"] {
        bench.write("empty.yaml", "");
        bench.write("binary.yaml", b"\xff\xfe\0");
        for name in ["empty.yaml", "binary.yaml", "gone.yaml", "./"] {
            not_started(&bench, &["--plugin", text(&pid), option, name], BAD_INPUT, &[name]);
        }
    }
}

#[test]
fn a_damaged_run_is_refused_by_score_and_resume() {
    let bench = Bench::new();
    let pid = pid();
    let run = ["--plugin", text(&pid), "--tasks", "w001/t00-t01", "--out"];
    bench.ok(&[&run[..], &["good"]].concat());
    let first = "good/tasks.jsonl";
    let lines = fs::read_to_string(bench.path(first)).expect("records");
    let trace = fs::read(bench.path("good/traces/w001/t00.parquet")).expect("a trace");
    let header = fs::read_to_string(bench.path("good/run.json")).expect("a header");
    let twice = format!("{lines}{}\n", lines.lines().next().expect("a record"));
    let cases: [(&str, Vec<u8>, &[&str], bool); 6] = [
        ("run.json", header[..header.len() / 2].into(), &["run.json", "line"], true),
        (
            "run.json",
            header.replace("\"schema\": 3", "\"schema\": 9").into(),
            &["run.json", "schema 9"],
            true,
        ),
        ("tasks.jsonl", format!("broken\n{lines}").into(), &["tasks.jsonl", "line 1"], true),
        ("tasks.jsonl", twice.into(), &["tasks.jsonl", "line 3", "duplicate"], true),
        ("traces/w001/t00.parquet", trace[..trace.len() / 2].to_vec(), &["t00.parquet"], false),
        ("traces/w001/t00.parquet", b"PAR1".to_vec(), &["t00.parquet"], false),
    ];
    for (i, (file, bytes, says, resume)) in cases.iter().enumerate() {
        let bad = format!("bad{i}");
        copy_dir(&bench.path("good"), &bench.path(&bad));
        bench.write(&format!("{bad}/{file}"), bytes);
        refused(&bench, &["score", &bad], BAD_INPUT, says);
        if *resume {
            refused(&bench, &[&run[..], &[&bad, "--resume"]].concat(), BAD_INPUT, says);
        }
    }
}

/// A run that was changed on purpose, and whose checksums were therefore deleted, may have settings that no run can have.
#[test]
fn settings_that_no_run_can_have_are_refused_by_every_command_that_reads_a_run() {
    let bench = Bench::new();
    let pid = pid();
    let run = ["--plugin", text(&pid), "--tasks", "w001/t00", "--out", "r"];
    bench.ok(&run);
    let header = fs::read_to_string(bench.path("r/run.json")).expect("a header");
    fs::remove_file(bench.path("r/checksums.txt")).expect("it is there");
    for (old, new, says) in [
        ("\"scale\": 1.0", "\"scale\": 0.0", "scale: 0 must lie in 0.01 to 10"),
        ("\"time_step\": 0.001", "\"time_step\": 0.0", "time_step: 0 must lie in 0.0001 to 0.005"),
        ("\"soil_resolution\": 0.1", "\"soil_resolution\": 1e-9", "soil_resolution: 0.000000001 must lie in"),
    ] {
        assert!(header.contains(old), "{old}");
        bench.write("r/run.json", header.replace(old, new));
        let resume = [&run[..], &["--resume"]].concat();
        let commands: [&[&str]; 5] = [
            &["report", "r", "--out", "page", "--maps", "w001"],
            &["replay", "r", "--task", "w001/t00", "--out", "x.html"],
            &["score", "r"],
            &["suite", "prove", "vb-100", "r", "--out", "proof.json"],
            &resume,
        ];
        for args in commands {
            refused(&bench, args, BAD_INPUT, &["run.json", says]);
        }
    }
    let unmet = header.replace("\"time_limit_s\": 60.0", "\"time_limit_s\": -1.0");
    assert_ne!(unmet, header);
    bench.write("r/run.json", unmet);
    refused(
        &bench,
        &["score", "r"],
        BAD_INPUT,
        &["run.json", "rules.profile", "time_limit_s: -1", "--rules"],
    );
}

#[test]
fn an_output_directory_that_can_not_be_used_is_named_with_what_to_do() {
    let bench = Bench::new();
    let pid = pid();
    bench.write("taken/notes.txt", "mine");
    // There is no run to be resumed, and none is begun among other files.
    refused(&bench, &["run", text(&pid), "--out", "taken", "--resume"], OUTPUT, &["taken", "not empty"]);
    let cases: [(&str, &[&str], &[&str]); 4] = [
        ("taken", &[], &["taken", "not empty", "--out", "--resume"]),
        ("taken/notes.txt", &[], &["taken/notes.txt", "--out"]),
        ("taken/notes.txt/run", &[], &["taken/notes.txt/run", "--out"]),
        // Nobody makes directories there, not even root.
        ("/proc/run", &[], &["/proc/run"]),
    ];
    for (out, more, says) in cases {
        refused(&bench, &[&["--plugin", text(&pid), "--out", out][..], more].concat(), OUTPUT, says);
    }
    for args in
        [["suite", "generate", "--seed", "1", "--worlds", "1"].as_slice(), &["suite", "import", "good"]]
    {
        Original::new().write(&bench, "good");
        refused(&bench, &[args, &["--out", "taken"]].concat(), OUTPUT, &["taken", "not empty"]);
        refused(&bench, &[args, &["--out", "taken/notes.txt/s"]].concat(), OUTPUT, &["taken/notes.txt"]);
    }
    assert_eq!(fs::read(bench.path("taken/notes.txt")).expect("it is there"), b"mine");
    assert_eq!(bench.files("taken").len(), 1, "what is there is left as it was");
}

#[test]
fn a_run_that_another_process_writes_is_left_alone() {
    let bench = Bench::new();
    let pid = pid();
    let run = ["--plugin", text(&pid), "--jobs", "1", "--out", "r"];
    // All hundred tasks, one at a time: it won't end before its neighbours have tried.
    let mut first = bench.watch(&run);
    first.until("started");
    refused(&bench, &run, OUTPUT, &["r", "in use by another process", "--out"]);
    refused(&bench, &[&run[..], &["--resume"]].concat(), OUTPUT, &["r", "in use by another process"]);
    first.until("task");
    first.kill();
    // The lock goes with the process.
    refused(&bench, &run, OUTPUT, &["r", "not empty", "--resume"]);
}

#[test]
fn a_run_is_resumed_only_with_what_decided_its_results() {
    let bench = Bench::new();
    let (pid, other) = (pid(), plugin("pid", PluginKind::Native));
    bench.ok(&["suite", "generate", "--seed", "1", "--worlds", "1", "--out", "suite"]);
    let vehicle = fs::read_to_string(vb_tests::root().join("tasks/vehicles/hmmwv.yaml")).expect("a vehicle");
    bench.write("heavy.yaml", vehicle.replace("mass: 2060.2", "mass: 2160.2"));
    let run = |plugin, more: &[&'static str]| {
        let args = ["--plugin", text(plugin), "--tasks", "w001/t00", "--out", "r"];
        args.iter().chain(more).map(|a| (*a).to_owned()).collect::<Vec<String>>()
    };
    bench.ok(&run(&pid, &[]));
    let before = bench.files("r");
    let cases: [(&Path, &[&'static str], &[&str]); 13] = [
        (&pid, &["--seed", "9"], &["seed", "the run has 0", "this command has 9"]),
        (&pid, &["--scale", "1/6"], &["scale", "1.0", "0.1666"]),
        (&pid, &["--rules", "release"], &["rules.name", "paper", "release"]),
        (&pid, &["--trace", "full"], &["trace", "10hz", "full"]),
        (&pid, &["--param", "speed=4"], &["params.speed", "nothing", "4"]),
        (&pid, &["--fuel-per-step", "1000"], &["limits.fuel_per_step", "2000000000", "1000"]),
        (&pid, &["--memory", "128M"], &["limits.memory_bytes", "134217728"]),
        (&pid, &["--suite", "./suite"], &["suite.hash"]),
        (&pid, &["--vehicle", "heavy.yaml"], &["vehicle.hash"]),
        (&pid, &["--soils", "original"], &["soils.hash"]),
        (&pid, &["--soil-resolution", "0.05"], &["soil_resolution", "0.1", "0.05"]),
        (&pid, &["--time-step", "0.5ms"], &["time_step", "0.001", "0.0005"]),
        (&other, &[], &["plugin.kind", "wasm", "native"]),
    ];
    for (plugin, more, says) in cases {
        let args = run(plugin, &[more, &["--resume"]].concat());
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        refused(&bench, &args, OUTPUT, &[says, &["cannot resume r", "--out"]].concat());
    }
    assert!(before == bench.files("r"), "a refused run changes nothing");
    // More workers and moved files decide nothing.
    fs::copy(&pid, bench.path("moved.wasm")).expect("copied");
    bench.ok(&run(Path::new("moved.wasm"), &["--resume", "--jobs", "2"]));
}

#[test]
fn a_report_is_not_written_over_the_run_that_it_is_of() {
    let bench = Bench::new();
    let pid = pid();
    bench.ok(&["--plugin", text(&pid), "--tasks", "w001/t00", "--out", "r"]);
    let before = bench.files("r");
    for (option, file) in [
        ("--csv", "r/tasks.jsonl"),
        ("--parquet", "r/traces/w001/t00.parquet"),
        ("--markdown", "./r/run.json"),
    ] {
        refused(
            &bench,
            &["report", "r", option, file],
            USAGE,
            &[file, "is a file of the run r", "another file"],
        );
    }
    let replay = ["replay", "r", "--task", "w001/t00", "--out", "r/summary.json"];
    refused(&bench, &replay, USAGE, &["r/summary.json is a file of the run r"]);
    refused(&bench, &["report", "r", "--csv", "t", "--parquet", "t"], USAGE, &["t: two outputs"]);
    assert_eq!(bench.files("r"), before);
    bench.ok(&["report", "r", "--csv", "r/table.csv", "--out", "r"]);
    for option in ["--csv", "--parquet", "--markdown"] {
        let says = ["r/table.csv already exists", "--force"];
        refused(&bench, &["report", "r", option, "r/table.csv"], OUTPUT, &says);
    }
    bench.ok(&["report", "r", "--csv", "r/table.csv", "--force"]);
}
