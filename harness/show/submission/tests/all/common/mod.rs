//! A small suite, a run of a real planner over it, and what forgers do.

// Helpers of tests may unwrap as tests do, and not every test needs all of them.
#![allow(clippy::unwrap_used, dead_code)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use vb_host::{Limits, LoadError, Plugin};
use vb_record::{LogMode, RunHeader, TraceMode};
use vb_runner::RunConfig;
use vb_score::{Rules, Summary, TaskRecord};
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_submission::{
    Entrant, Expected, Manifest, Request, Sampling, Shipped, ShippedSuite, ShippedVehicle, Submission,
    SubmissionError, Verification,
};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{
    Heightfield, Pose2, Provenance, Suite, SuiteMeta, Task, TaskId, TerrainClass, World, WorldInfo,
};

pub const VERSION: &str = "0.1.0";

pub fn repository(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..").join(file)
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

pub struct Bench {
    pub dir: tempfile::TempDir,
    pub suite: Suite,
    pub plugin: Plugin,
    pub vehicle: Vehicle,
    pub soils: Soils,
    pub perception: Profile,
    pub shipped: Shipped,
}

/// One for all tests of a program: the run is made once.
pub fn bench() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(Bench::new)
}

fn world(id: &str, friction: f64) -> World {
    let mut world = World::uniform(id, Heightfield::flat(65, 65, 1.0, 0.0), TerrainClass::Gravel, friction);
    for (k, y) in [0.0, 8.0].into_iter().enumerate() {
        let start = Pose2 { x: -15.0, y, yaw: 0.0 };
        let path = vec![[-15.0, y], [0.0, y], [15.0, y]];
        world.tasks.push(Task { id: format!("t{k:02}"), start, goal: [15.0, y], path });
    }
    world
}

pub fn suite(dir: &Path, frictions: [f64; 2]) -> Suite {
    let meta = SuiteMeta {
        name: "tiny".into(),
        version: "1".into(),
        description: "Level ground.".into(),
        provenance: Provenance::Authored { by: "a test".into() },
    };
    Suite::write(dir, &meta, &[world("w001", frictions[0]), world("w002", frictions[1])]).unwrap()
}

impl Bench {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let suite = suite(&dir.path().join("tiny"), [0.9, 0.4]);
        let read = |file: &str| {
            let text = fs::read_to_string(repository(file)).unwrap();
            (sha256(text.as_bytes()), text)
        };
        let (hash, text) = read("tasks/vehicles/hmmwv.yaml");
        let vehicle = Vehicle { spec: VehicleSpec::parse(&text, "hmmwv").unwrap(), hash };
        let (hash, text) = read("tasks/soils/default.yaml");
        let soils = Soils { set: SoilSet::parse(&text, "default").unwrap(), hash, resolution: 0.1 };
        let shipped = Shipped {
            suites: vec![ShippedSuite { name: "tiny".into(), hash: suite.hash(), tasks: 4 }],
            vehicles: BTreeMap::from([(
                vehicle.spec.name.clone(),
                ShippedVehicle { hash: vehicle.hash.clone(), scale: vehicle.spec.scale },
            )]),
            soils: soils.hash.clone(),
        };
        let plugin = load(&Limits::default(), dir.path());
        let bench = Self { dir, suite, plugin, vehicle, soils, perception: Profile::oracle(), shipped };
        bench.run("run", |_| {});
        bench.make("run", "honest").unwrap();
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Drives the suite into `out`.
    pub fn run(&self, out: &str, change: impl FnOnce(&mut RunConfig)) {
        let mut config = RunConfig {
            suite: self.suite.clone(),
            tasks: self.suite.worlds().iter().flat_map(WorldInfo::task_ids).collect(),
            selector: None,
            shard: None,
            plugin: self.plugin.clone(),
            plugin_path: "/home/somebody/pursuit.wasm".into(),
            params: Vec::new(),
            vehicle: self.vehicle.clone(),
            soils: self.soils.clone(),
            perception: Profile::oracle(),
            rules: Rules::paper(),
            time_step: 0.001,
            scale: 1.0,
            seed: 0,
            jobs: 2,
            trace: TraceMode::TenHz,
            logs: LogMode::default(),
            out: self.path(out),
            resume: false,
            keep_going: false,
            started_at: "2026-01-01T00:00:00Z".into(),
            harness_version: VERSION.into(),
            harness_commit: "unknown".into(),
        };
        change(&mut config);
        vb_runner::run(&config, &mut |_| {}, &AtomicBool::new(false)).unwrap();
    }

    pub fn make(&self, run: &str, out: &str) -> Result<Manifest, SubmissionError> {
        self.make_with(run, out, None)
    }

    pub fn make_with(
        &self,
        run: &str,
        out: &str,
        replays: Option<Vec<TaskId>>,
    ) -> Result<Manifest, SubmissionError> {
        let entrant = Entrant {
            name: "A team".into(),
            url: Some("https://example.org".into()),
            code: Some("https://example.org/code".into()),
            paper: Some("https://example.org/paper".into()),
            note: Some("A note.".into()),
        };
        let request = Request {
            suite: &self.suite,
            plugin: &self.plugin,
            shipped: &self.shipped,
            harness_version: VERSION,
            entrant,
            replays,
        };
        vb_submission::make(&self.path(run), &self.path(out), &request)
    }

    pub fn verify(&self, name: &str, draw: Option<(usize, u64)>) -> Result<Verification, SubmissionError> {
        let load = |limits: &Limits| {
            Ok(if *limits == Limits::default() { self.plugin.clone() } else { load(limits, self.dir.path()) })
        };
        self.verify_with(name, draw, &load, |_| {})
    }

    /// Verifies with something else at hand than what it was made with.
    pub fn verify_with(
        &self,
        name: &str,
        draw: Option<(usize, u64)>,
        load: &dyn Fn(&Limits) -> Result<Plugin, LoadError>,
        change: impl for<'a> FnOnce(&mut Expected<'a>),
    ) -> Result<Verification, SubmissionError> {
        let submission = Submission::open(&self.path(name))?;
        let mut expected = Expected {
            suite: &self.suite,
            plugin_sha256: self.plugin.sha256(),
            vehicle: &self.vehicle,
            soils: &self.soils,
            perception: &self.perception,
            shipped: &self.shipped,
            harness_version: VERSION,
        };
        change(&mut expected);
        let sampling = Sampling { draw, jobs: 2 };
        let cancel = AtomicBool::new(false);
        vb_submission::verify(&submission, &expected, load, &sampling, &mut |_, _, _| {}, &cancel)
    }

    /// A copy of a folder to forge in.
    pub fn copy(&self, from: &str, to: &str) {
        copy(&self.path(from), &self.path(to));
    }

    pub fn json(&self, file: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(file)).unwrap()).unwrap()
    }

    /// Writes a document as the harness does, fields in its order; one that is no such document as it comes.
    pub fn write_json(&self, file: &str, value: &Value) {
        let mut text = match file.rsplit('/').next().unwrap() {
            "submission.json" => typed::<Manifest>(value),
            "run.json" => typed::<RunHeader>(value),
            _ => typed::<Summary>(value),
        };
        text.push(b'\n');
        self.forge(file, &text);
    }

    /// The lines of a run's or submission's records.
    pub fn records(&self, file: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.path(file)).unwrap();
        text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
    }

    pub fn write_records(&self, file: &str, records: &[Value]) {
        let mut lines = Vec::new();
        for value in records {
            // As the harness writes it, if it is a record and nothing else.
            let known = serde_json::from_value::<TaskRecord>(value.clone()).ok();
            let known = known.filter(|r| serde_json::to_value(r).unwrap() == *value);
            match known {
                Some(record) => serde_json::to_writer(&mut lines, &record).unwrap(),
                None => serde_json::to_writer(&mut lines, value).unwrap(),
            }
            lines.push(b'\n');
        }
        self.forge(file, &lines);
    }

    /// Writes a file. Checksums beside it are against accidents; a forger deletes them.
    fn forge(&self, file: &str, bytes: &[u8]) {
        let path = self.path(file);
        let _ = fs::remove_file(path.with_file_name("checksums.txt"));
        fs::write(path, bytes).unwrap();
    }

    /// What a forger does after he changed a file: he states its hash.
    pub fn state_hash_of(&self, submission: &str, file: &str) {
        let manifest = format!("{submission}/submission.json");
        let text = fs::read_to_string(self.path(&manifest)).unwrap();
        let old: Value = serde_json::from_str(&text).unwrap();
        let old = old["files"][file].as_str().unwrap().to_owned();
        let new = sha256(&fs::read(self.path(submission).join(file)).unwrap());
        fs::write(self.path(&manifest), text.replace(&old, &new)).unwrap();
    }
}

fn typed<T: Serialize + DeserializeOwned>(value: &Value) -> Vec<u8> {
    let known = serde_json::from_value::<T>(value.clone()).ok();
    match known.filter(|k| serde_json::to_value(k).unwrap() == *value) {
        Some(known) => serde_json::to_vec_pretty(&known).unwrap(),
        None => serde_json::to_vec_pretty(value).unwrap(),
    }
}

fn load(limits: &Limits, dir: &Path) -> Plugin {
    let file = repository("tests/golden/abi-1.0/pursuit.wasm");
    Plugin::load(&file, limits, Some(&dir.join("cache"))).unwrap()
}

fn copy(from: &Path, to: &Path) {
    let _ = fs::remove_dir_all(to);
    fs::create_dir_all(to).unwrap();
    for path in fs::read_dir(from).unwrap().map(|e| e.unwrap().path()) {
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// The paths of all leaves of a document, as pointers.
pub fn leaves(value: &Value) -> Vec<String> {
    fn walk(path: &str, value: &Value, out: &mut Vec<String>) {
        // Pointers of RFC 6901: names of tasks hold a slash.
        let below = |key: &str| format!("{path}/{}", key.replace('~', "~0").replace('/', "~1"));
        match value {
            Value::Object(fields) if !fields.is_empty() => {
                fields.iter().for_each(|(k, v)| walk(&below(k), v, out));
            }
            Value::Array(items) if !items.is_empty() => {
                items.iter().enumerate().for_each(|(k, v)| walk(&below(&k.to_string()), v, out));
            }
            _ => out.push(path.to_owned()),
        }
    }
    let mut out = Vec::new();
    walk("", value, &mut out);
    out
}

/// Words of which a field takes one: it is changed to another, so that it can still be read.
const KNOWN: [&[&str]; 8] = [
    &["ranked", "open"],
    &["success", "stuck", "rollover", "timeout"],
    &["low", "medium", "high"],
    &["rigid", "deformable", "mixed"],
    &["sparse", "dense"],
    &["wasm", "native"],
    &["10hz", "full"],
    &["0.1.0", "0.0.9"],
];

/// Another value for a leaf, as little changed as can be.
pub fn changed(value: &Value) -> Value {
    match value {
        Value::Null => "x".into(),
        Value::Bool(b) => (!b).into(),
        Value::Number(n) => match n.as_u64() {
            Some(n) => (n + 1).into(),
            // The next number that there is.
            None => n.as_f64().map(|x| f64::from_bits(x.to_bits() + 1)).into(),
        },
        Value::String(s) => {
            match KNOWN.iter().find_map(|w| w.iter().position(|k| k == s).map(|at| (w, at))) {
                Some((words, at)) => words[(at + 1) % words.len()].into(),
                None => format!("{s}x").into(),
            }
        }
        Value::Array(_) => vec![serde_json::json!({"field": "seed", "text": "x"})].into(),
        Value::Object(_) => serde_json::json!({"x": 1}),
    }
}

/// A pointer as the dotted path of findings.
pub fn dotted(pointer: &str) -> String {
    pointer[1..].replace('/', ".").replace("~1", "/").replace("~0", "~")
}
