//! `vb-harness list`: what is shipped or installed, with a description of each in one line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use serde_json::{Map, Value, json};
use vb_catalog::{Catalog, CatalogError, Data};
use vb_files::one_line;
use vb_score::Rules;
use vb_sense::Profile;
use vb_sim::SoilSet;
use vb_vehicle::VehicleSpec;
use vb_world::Suite;

use crate::args::FormatArgs;
use crate::error::CliError;
use crate::{output, places};

/// Kinds of items that `list` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listed {
    /// Suites, for --suite
    Suites,
    /// Vehicles, for --vehicle
    Vehicles,
    /// Shipped and installed planners, which are found by their file names
    Planners,
    /// Rule profiles, for --rules
    Rules,
    /// Soil sets, for --soils
    Soils,
    /// Perception profiles, for --perception
    Profiles,
}

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// What to list
    #[arg(value_name = "WHAT", value_enum)]
    pub(crate) what: Listed,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// The endings of planners' files.
pub(crate) const PLANNERS: [&str; 4] = ["wasm", "so", "dylib", "dll"];

/// Something that can be named on the command line.
#[derive(Debug, Serialize)]
struct Entry {
    event: &'static str,
    /// What the option takes.
    name: String,
    description: String,
    /// Further columns of the table.
    #[serde(skip)]
    columns: Vec<String>,
    /// Further fields of the message.
    #[serde(flatten)]
    fields: Map<String, Value>,
}

impl Entry {
    fn new(event: &'static str, name: impl Into<String>, description: &str) -> Self {
        let description = one_line(description);
        Self { event, name: name.into(), description, columns: Vec::new(), fields: Map::new() }
    }
}

pub(crate) fn list(args: &ListArgs) -> Result<(), CliError> {
    let catalog = places::catalog();
    let entries = match args.what {
        Listed::Suites => suites(&catalog)?,
        Listed::Vehicles => each(&catalog, Data::Vehicle, vehicle)?,
        Listed::Planners => planners(&vb_catalog::planner_dirs())?,
        Listed::Rules => rules()?,
        Listed::Soils => each(&catalog, Data::Soils, soils)?,
        Listed::Profiles => each(&catalog, Data::Perception, profile)?,
    };
    if args.format.is_json() {
        entries.iter().for_each(output::json);
        return Ok(());
    }
    let row = |e: Entry| std::iter::once(e.name).chain(e.columns).chain([e.description]).collect();
    output::text(&output::columns(&entries.into_iter().map(row).collect::<Vec<_>>()));
    Ok(())
}

fn suites(catalog: &Catalog) -> Result<Vec<Entry>, CliError> {
    let dirs = catalog.suites()?;
    if dirs.is_empty() {
        return Err(catalog.nothing("suite").into());
    }
    let entry = |dir: PathBuf| {
        let suite = Suite::open(&dir)?;
        let (worlds, tasks) = (suite.worlds().len(), suite.task_count());
        let name = dir.file_name().unwrap_or_default().to_string_lossy();
        let mut entry = Entry::new("suite", name, &suite.meta().description);
        entry.columns = vec![format!("{worlds} worlds, {tasks} tasks")];
        entry.fields = fields(json!({
            "version": suite.meta().version, "worlds": worlds, "tasks": tasks, "hash": suite.hash(),
        }));
        Ok(entry)
    };
    dirs.into_iter().map(entry).collect()
}

/// An entry for each data file of a kind.
fn each(
    catalog: &Catalog,
    kind: Data,
    entry: impl Fn(String, &Path) -> Result<Entry, CatalogError>,
) -> Result<Vec<Entry>, CliError> {
    let names = catalog.names(kind)?;
    if names.is_empty() {
        return Err(catalog.nothing(kind.noun()).into());
    }
    let entries = names.into_iter().map(|name| {
        let file = catalog.own_data(kind, &name)?;
        Ok(entry(name, &file)?)
    });
    entries.collect()
}

fn vehicle(name: String, file: &Path) -> Result<Entry, CatalogError> {
    let v = VehicleSpec::load(file)?;
    let (wheels, mass) = (2 * v.axles.len(), v.total_mass());
    let mut entry = Entry::new("vehicle", name, &v.description);
    let mass_shown = format!("{} kg", vb_page::rounded(mass));
    entry.columns = vec![format!("{wheels} wheels"), format!("scale {}", scale(v.scale)), mass_shown];
    entry.fields = fields(json!({
        "scale": v.scale, "wheels": wheels, "mass_kg": mass, "length_m": v.length, "width_m": v.width,
        "height_m": v.height, "max_speed_m_per_s": v.max_speed,
    }));
    Ok(entry)
}

/// A scale as people write it.
pub(crate) fn scale(value: f64) -> String {
    let inverse = 1.0 / value;
    if value == 1.0 {
        "1".to_owned()
    } else if value < 1.0 && (inverse - inverse.round()).abs() < 1e-9 {
        format!("1/{inverse:.0}")
    } else {
        vb_page::rounded(value)
    }
}

fn soils(name: String, file: &Path) -> Result<Entry, CatalogError> {
    Ok(Entry::new("soils", name, &SoilSet::load(file)?.description))
}

fn profile(name: String, file: &Path) -> Result<Entry, CatalogError> {
    Ok(Entry::new("profile", name, &Profile::load(file)?.data().description))
}

fn rules() -> Result<Vec<Entry>, CliError> {
    let entry = |(name, text): (&str, &str)| {
        let rules = Rules::parse(text, name).map_err(CliError::internal)?;
        Ok(Entry::new("rules", name, &rules.description))
    };
    Rules::BUILTIN.iter().copied().map(entry).collect()
}

/// The planners in these folders, where the first of a name counts. What is wrong with a file takes the place of its description.
fn planners(dirs: &[PathBuf]) -> Result<Vec<Entry>, CliError> {
    let mut files = BTreeMap::new();
    for path in
        dirs.iter().filter_map(|dir| dir.read_dir().ok()).flatten().flatten().map(|entry| entry.path())
    {
        let is_planner = path.extension().is_some_and(|end| PLANNERS.iter().any(|known| end == *known));
        if let Some(name) = path.file_name().filter(|_| is_planner) {
            files.entry(name.to_string_lossy().into_owned()).or_insert(path);
        }
    }
    if files.is_empty() {
        return Err(CliError::input(format!(
            "no planners found (install planners with vb-harness plugin install, or set {} to a directory with planners)",
            vb_catalog::PLUGINS_VAR
        )));
    }
    let entry = |(name, path): (String, PathBuf)| match vb_host::inspect(&path) {
        Ok(meta) => {
            let mut entry = Entry::new("planner", name, &meta.about);
            entry.columns = vec![one_line(&meta.version)];
            entry.fields = fields(json!({"planner": meta.name, "version": meta.version, "file": path}));
            entry
        }
        Err(e) => {
            let mut entry = Entry::new("planner", name, &format!("cannot be used: {e}"));
            entry.columns = vec!["-".to_owned()];
            entry.fields = fields(json!({"planner": null, "version": null, "file": path}));
            entry
        }
    };
    Ok(files.into_iter().map(entry).collect())
}

/// The fields of a JSON object.
fn fields(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(fields) => fields,
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_planners_with_one_name_the_first_is_listed_and_damaged_ones_with_the_reason() {
        let dir = tempfile::tempdir().unwrap();
        let dirs = ["first", "second"].map(|name| dir.path().join(name));
        for (folder, file) in
            [(&dirs[0], "b.wasm"), (&dirs[1], "b.wasm"), (&dirs[1], "a.so"), (&dirs[1], "notes.txt")]
        {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join(file), "no planner").unwrap();
        }
        let listed = planners(&dirs).unwrap();
        let names: Vec<&str> = listed.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names, ["a.so", "b.wasm"]);
        assert_eq!(listed[1].fields["file"], json!(dirs[0].join("b.wasm")));
        assert!(listed.iter().all(|e| e.description.starts_with("cannot be used: ")));
        let e = planners(&[]).unwrap_err().to_string();
        assert!(e.contains("plugin install") && e.contains("VB_PLUGINS"), "{e}");
    }

    #[test]
    fn rules_are_listed_as_they_are_built_in() {
        let listed = rules().unwrap();
        assert_eq!(listed.len(), Rules::BUILTIN.len());
        assert!(listed.iter().all(|e| !e.description.is_empty()));
    }
}
