//! A sweep as data.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use vb_files::{Document, DocumentError, Flaw, Schema};
use vb_record::TraceMode;
use vb_trial::defaults::{PERCEPTION, RULES, VEHICLE};

use crate::sweep::name::safe;

/// The maximum number of runs of a sweep.
const MOST: usize = 100_000;

/// A sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    pub name: String,
    /// The suite, as `--suite` takes it; `None` for the default.
    pub suite: Option<String>,
    /// The selector of the tasks, as `--tasks` takes it; `None` for all.
    pub tasks: Option<String>,
    /// The rules, as `--rules` takes them.
    pub rules: String,
    /// The samples to keep.
    pub trace: TraceMode,
    runs: Vec<PlannedRun>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRun {
    /// The name, which is that of its folder: `PLANNER,PARAMETER=VALUE--VEHICLE--PERCEPTION--SEED`.
    pub name: String,
    /// The label of the planner with its parameters in this sweep: the first component of the name.
    pub planner: String,
    /// The planner's file or command, as `--plugin` takes it.
    pub plugin: String,
    pub params: BTreeMap<String, String>,
    /// The vehicle, as `--vehicle` takes it.
    pub vehicle: String,
    /// The perception profile, as `--perception` takes it.
    pub perception: String,
    pub seed: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    name: String,
    #[serde(default)]
    #[allow(dead_code, reason = "for readers of the file")]
    description: String,
    /// The suite, as `--suite` takes it.
    suite: Option<String>,
    /// The selector of tasks; all if absent.
    tasks: Option<String>,
    /// The rule profile, as `--rules` takes it.
    #[serde(default = "rules")]
    rules: String,
    #[serde(default)]
    trace: TraceMode,
    /// The planners.
    planners: Vec<Planner>,
    #[serde(default = "vehicles")]
    /// The vehicles, as `--vehicle` takes them.
    vehicles: Vec<String>,
    #[serde(default = "perceptions")]
    /// The perception profiles, as `--perception` takes them.
    perceptions: Vec<String>,
    /// The seeds.
    #[serde(default = "zero")]
    seeds: Vec<u64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Planner {
    /// The planner's file.
    plugin: String,
    /// The name in results; that of the planner if absent.
    name: Option<String>,
    /// The parameters, each with a value or a list of values.
    #[serde(default)]
    params: BTreeMap<String, Values>,
}

/// A value, or a list of values.
#[derive(Deserialize)]
#[serde(untagged)]
enum Values {
    One(Value),
    Many(Vec<Value>),
}

/// A value as it is handed on. Numbers keep the text that stands in the file where it is one that programs write.
#[derive(Clone, Deserialize)]
#[serde(untagged)]
enum Value {
    Bool(bool),
    Whole(i64),
    Number(f64),
    Text(String),
}

impl Value {
    fn text(&self) -> String {
        match self {
            Self::Bool(v) => v.to_string(),
            Self::Whole(v) => v.to_string(),
            Self::Number(v) => v.to_string(),
            Self::Text(v) => v.clone(),
        }
    }
}

fn rules() -> String {
    RULES.to_owned()
}

fn vehicles() -> Vec<String> {
    vec![VEHICLE.to_owned()]
}

fn perceptions() -> Vec<String> {
    vec![PERCEPTION.to_owned()]
}

fn zero() -> Vec<u64> {
    vec![0]
}

impl Document for File {
    type File = Self;
    const KIND: &'static str = "sweep";
    const FIELDS: &'static str = "docs/scale.md";

    fn from_file(file: Self) -> Result<Self, Flaw> {
        Ok(file)
    }
}

impl Spec {
    /// Reads a sweep from a file. Files that it names by a path are looked for beside it.
    pub fn load(path: &Path) -> Result<Self, DocumentError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of(File::load(path)?, folder).map_err(|flaw| flaw.of(File::KIND, path.display().to_string()))
    }

    fn of(read: File, folder: &Path) -> Result<Self, Flaw> {
        let lists = [
            ("planners", read.planners.len()),
            ("vehicles", read.vehicles.len()),
            ("perceptions", read.perceptions.len()),
            ("seeds", read.seeds.len()),
        ];
        if let Some((field, _)) = lists.iter().find(|(_, n)| *n == 0) {
            return Err(Flaw::new(*field, "the list is empty (omit it, or add an entry)"));
        }
        let mut variants = Vec::new();
        for (k, planner) in read.planners.iter().enumerate() {
            variants.extend(planner.variants(folder).map_err(|flaw| flaw.within(&format!("planners[{k}]")))?);
        }
        let count = [variants.len(), read.vehicles.len(), read.perceptions.len(), read.seeds.len()]
            .into_iter()
            .try_fold(1usize, usize::checked_mul);
        if count.is_none_or(|n| n > MOST) {
            return Err(Flaw::new("planners", format!("the sweep has more than {MOST} runs (split it)")));
        }
        let mut runs = Vec::new();
        for variant in &variants {
            for vehicle in &read.vehicles {
                for perception in &read.perceptions {
                    runs.extend(
                        read.seeds.iter().map(|seed| variant.run(vehicle, perception, *seed, folder)),
                    );
                }
            }
        }
        let mut names = BTreeSet::new();
        if let Some(twice) = runs.iter().find(|r| !names.insert(r.name.as_str())) {
            let problem = format!("two runs have the name {} (rename one of the planners)", twice.name);
            return Err(Flaw::new("planners", problem));
        }
        let suite = read.suite.map(|s| beside(folder, &s));
        Ok(Self {
            name: read.name,
            suite,
            tasks: read.tasks,
            rules: beside(folder, &read.rules),
            trace: read.trace,
            runs,
        })
    }

    /// The runs, those of a planner one after the other.
    #[must_use]
    pub fn runs(&self) -> &[PlannedRun] {
        &self.runs
    }
}

/// A planner with one value of each of its parameters.
struct Variant {
    name: String,
    plugin: String,
    params: BTreeMap<String, String>,
}

impl Planner {
    fn variants(&self, folder: &Path) -> Result<Vec<Variant>, Flaw> {
        let plugin = beside(folder, &self.plugin);
        let stem = Path::new(&self.plugin).file_stem().map(|s| s.to_string_lossy().into_owned());
        let own = match self.name.clone().or(stem) {
            Some(name) if !name.is_empty() => name,
            _ => {
                return Err(Flaw::new(
                    "plugin",
                    format!("{:?} is neither a file nor a command", self.plugin),
                ));
            }
        };
        let mut combinations = vec![BTreeMap::new()];
        for (key, values) in &self.params {
            let values: Vec<String> = match values {
                Values::One(value) => vec![value.text()],
                Values::Many(values) => values.iter().map(Value::text).collect(),
            };
            if values.is_empty() {
                return Err(Flaw::new(format!("params.{key}"), "the list is empty (add a value)"));
            }
            if values.len().saturating_mul(combinations.len()) > MOST {
                let problem = format!("the sweep has more than {MOST} runs (split it)");
                return Err(Flaw::new(format!("params.{key}"), problem));
            }
            let with = |known: &BTreeMap<String, String>| {
                let mut all = Vec::new();
                for value in &values {
                    let mut more = known.clone();
                    more.insert(key.clone(), value.clone());
                    all.push(more);
                }
                all
            };
            combinations = combinations.iter().flat_map(with).collect();
        }
        let name = |params: &BTreeMap<String, String>| {
            params.iter().fold(own.clone(), |name, (key, value)| format!("{name},{key}={value}"))
        };
        Ok(combinations
            .into_iter()
            .map(|params| Variant { name: name(&params), plugin: plugin.clone(), params })
            .collect())
    }
}

impl Variant {
    fn run(&self, vehicle: &str, perception: &str, seed: u64, folder: &Path) -> PlannedRun {
        let stem = |name: &str| Path::new(name).file_stem().map(|s| s.to_string_lossy().into_owned());
        let short = |name: &str| stem(name).unwrap_or_else(|| name.to_owned());
        let name = format!("{}--{}--{}--{seed}", self.name, short(vehicle), short(perception));
        PlannedRun {
            name: safe(&name),
            planner: self.name.clone(),
            plugin: self.plugin.clone(),
            params: self.params.clone(),
            vehicle: beside(folder, vehicle),
            perception: beside(folder, perception),
            seed,
        }
    }
}

/// What a text of the file means: a file beside it if there is one, else as it is, which may be a name or a command.
fn beside(folder: &Path, text: &str) -> String {
    let path: PathBuf = folder.join(text);
    if path.exists() { path.to_string_lossy().into_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(text: &str) -> Result<Spec, String> {
        let text = format!("schema: 1\nname: mine\n{text}");
        let file = File::parse(&text, "mine.yaml").map_err(|e| e.to_string())?;
        Spec::of(file, Path::new("/nowhere")).map_err(|e| e.to_string())
    }

    fn names(text: &str) -> Vec<String> {
        spec(text).unwrap().runs().iter().map(|r| r.name.clone()).collect()
    }

    #[test]
    fn every_planner_with_every_value_is_driven_on_every_vehicle_under_every_profile_with_every_seed() {
        let spec = spec(
            "tasks: w001\nplanners:\n- plugin: pid.wasm\n  params: {speed: [3, 5.5], kp: 1}\n- plugin: python3 mine.py\n  name: mine\n\
             vehicles: [hmmwv, gator]\nperceptions: [oracle, onboard]\nseeds: [0, 7]\n",
        )
        .unwrap();
        assert_eq!(spec.runs().len(), 3 * 2 * 2 * 2);
        let first = &spec.runs()[0];
        assert_eq!(first.name, "pid,kp=1,speed=3--hmmwv--oracle--0");
        assert_eq!((first.planner.as_str(), first.plugin.as_str()), ("pid,kp=1,speed=3", "pid.wasm"));
        let params =
            BTreeMap::from([("kp".to_owned(), "1".to_owned()), ("speed".to_owned(), "5.5".to_owned())]);
        assert_eq!(spec.runs()[8].params, params);
        let last = &spec.runs()[23];
        assert_eq!(
            (last.name.as_str(), last.plugin.as_str()),
            ("mine--gator--onboard--7", "python3 mine.py")
        );
        assert_eq!(
            (spec.tasks.as_deref(), spec.rules.as_str(), spec.trace),
            (Some("w001"), "paper", TraceMode::TenHz)
        );
    }

    #[test]
    fn names_stay_when_values_are_added() {
        let few = names("planners: [{plugin: pid.wasm, params: {speed: 3}}]\n");
        let many = names(
            "planners: [{plugin: a.wasm}, {plugin: pid.wasm, params: {speed: [1, 3]}}]\nseeds: [5, 0]\n",
        );
        assert!(few.iter().all(|name| many.contains(name)), "{few:?} {many:?}");
    }

    #[test]
    fn flaws_are_told_with_file_field_and_value() {
        let told = |text: &str| spec(text).unwrap_err();
        assert!(told("planers: []\n").starts_with("mine.yaml: "));
        assert!(told("planners: []\n").contains("planners: the list is empty"));
        let pid = "planners: [{plugin: pid.wasm}]\n";
        assert!(told(&format!("{pid}seeds: []\n")).contains("seeds: the list is empty"));
        assert!(told(&format!("{pid}vehicle: [hmmwv]\n")).contains("vehicle"));
        assert!(
            told("planners: [{plugin: pid.wasm, params: {speed: []}}]\n")
                .contains("planners[0].params.speed: the list is empty")
        );
        let twice = told("planners: [{plugin: a/pid.wasm}, {plugin: b/pid.wasm}]\n");
        assert!(twice.contains("two runs have the name pid--hmmwv--oracle--0"), "{twice}");
        let many =
            format!("{pid}seeds: [{}]\n", (0..1001).map(|n| n.to_string()).collect::<Vec<_>>().join(", "));
        let vehicles =
            format!("vehicles: [{}]\n", (0..101).map(|n| format!("v{n}")).collect::<Vec<_>>().join(", "));
        assert!(told(&format!("{many}{vehicles}")).contains("more than 100000 runs"));
        assert!(
            Spec::load(Path::new("nowhere.yaml"))
                .unwrap_err()
                .to_string()
                .contains("cannot read sweep nowhere.yaml: ")
        );
    }

    #[test]
    fn files_beside_the_sweep_are_found_from_everywhere() {
        let dir = tempfile::tempdir().unwrap();
        let plugin = dir.path().join("mine.wasm");
        std::fs::write(&plugin, "").unwrap();
        let text = "schema: 1\nname: mine\nplanners: [{plugin: mine.wasm}, {plugin: pid.wasm}]\n";
        let spec = Spec::of(File::parse(text, "x").unwrap(), dir.path()).unwrap();
        let plugins: Vec<&str> = spec.runs().iter().map(|r| r.plugin.as_str()).collect();
        assert_eq!(plugins, [plugin.to_str().unwrap(), "pid.wasm"]);
    }
}
