//! Licences of the crates that are linked into the program and the Python module.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::package::{failure, read};
use crate::run::{Failure, cargo_program, output};

/// Crates that are distributed.
const PACKAGES: [&str; 2] = ["vb-harness", "vb-python"];
/// Beginnings of the names of licence files, in lower case.
const NAMES: [&str; 4] = ["licen", "copying", "notice", "unlicense"];
/// Foreign content of our crates, with its licence.
const OTHERS: [(&str, &str); 1] = [("the font Liberation Sans", "harness/show/figure/fonts/LICENSE")];

/// Returns a text with all linked crates for a system, their licence identifiers, and each licence text once.
pub(crate) fn text(target: &str) -> Result<String, Failure> {
    let mut cargo = Command::new(cargo_program());
    cargo.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", target]);
    let metadata = output(cargo.current_dir(crate::root()).stderr(Stdio::inherit()))
        .and_then(|text| serde_json::from_str::<Value>(&text).ok())
        .ok_or_else(|| Failure::new("`cargo metadata` failed (see its message above)"))?;
    let mut listed = Vec::new();
    // Names of crates by licence text.
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in linked(&metadata) {
        let name = format!("{} {}", string(&package["name"]), string(&package["version"]));
        let licence = package["license"].as_str().unwrap_or("see its licence below");
        listed.push(format!("{name}: {licence}"));
        let folder = Path::new(string(&package["manifest_path"])).parent().unwrap_or(Path::new("."));
        for entry in std::fs::read_dir(folder).map_err(failure(folder))?.flatten() {
            let file = entry.file_name().to_string_lossy().to_lowercase();
            if entry.path().is_file() && NAMES.iter().any(|begin| file.starts_with(begin)) {
                let text = String::from_utf8_lossy(&read(&entry.path())?).replace("\r\n", "\n");
                texts.entry(text.trim().to_owned()).or_default().push(name.clone());
            }
        }
    }
    for (what, file) in OTHERS {
        let text = String::from_utf8_lossy(&read(&crate::root().join(file))?).trim().to_owned();
        texts.entry(text).or_default().push(what.to_owned());
    }
    let mut texts: Vec<_> = texts.into_iter().collect();
    texts.sort_by(|a, b| a.1.cmp(&b.1));
    let begin = format!("This package contains code of the following crates.\n\n{}", listed.join("\n"));
    let parts = texts.iter().map(|(text, names)| format!("{}\n\n{text}", names.join(", ")));
    let line = format!("\n\n{}\n\n", "-".repeat(80));
    Ok(std::iter::once(begin).chain(parts).collect::<Vec<_>>().join(&line) + "\n")
}

/// Returns the foreign packages on which the distributed crates depend at run time, by name and version.
fn linked(metadata: &Value) -> Vec<&Value> {
    let packages: BTreeMap<&str, &Value> =
        items(&metadata["packages"]).map(|p| (string(&p["id"]), p)).collect();
    let nodes: BTreeMap<&str, &Value> =
        items(&metadata["resolve"]["nodes"]).map(|node| (string(&node["id"]), node)).collect();
    let is_ours = |package: &Value| package["source"].is_null();
    let mut open: Vec<&str> = packages
        .iter()
        .filter(|(_, package)| is_ours(package) && PACKAGES.contains(&string(&package["name"])))
        .map(|(id, _)| *id)
        .collect();
    let mut found: BTreeSet<&str> = open.iter().copied().collect();
    while let Some(id) = open.pop() {
        for dependency in nodes.get(id).into_iter().flat_map(|node| items(&node["deps"])) {
            let is_linked = items(&dependency["dep_kinds"]).any(|kind| kind["kind"].is_null());
            let id = string(&dependency["pkg"]);
            if is_linked && found.insert(id) {
                open.push(id);
            }
        }
    }
    let mut foreign: Vec<_> =
        found.iter().filter_map(|id| packages.get(id)).copied().filter(|package| !is_ours(package)).collect();
    foreign.sort_by_key(|package| (string(&package["name"]), string(&package["version"])));
    foreign
}

fn items(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

fn string(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_linked_is_listed_and_each_once() {
        let package = |name: &str, source: Value| serde_json::json!({"id": name, "name": name, "version": "1.0.0", "source": source, "license": "MIT"});
        let node = |name: &str, deps: &[(&str, Value)]| {
            let deps: Vec<_> = deps
                .iter()
                .map(|(name, kind)| serde_json::json!({"pkg": name, "dep_kinds": [{"kind": kind}]}))
                .collect();
            serde_json::json!({"id": name, "deps": deps})
        };
        let metadata = serde_json::json!({
            "packages": [
                package("vb-harness", Value::Null), package("vb-python", Value::Null), package("vb-sim", Value::Null),
                package("used", "registry".into()), package("deep", "registry".into()), package("build", "registry".into()),
            ],
            "resolve": {"nodes": [
                node("vb-harness", &[("vb-sim", Value::Null), ("build", "build".into())]),
                node("vb-python", &[("used", Value::Null)]),
                node("vb-sim", &[("used", Value::Null)]),
                node("used", &[("deep", Value::Null)]),
                node("deep", &[("used", Value::Null)]),
                node("build", &[]),
            ]},
        });
        let names: Vec<_> = linked(&metadata).into_iter().map(|package| string(&package["name"])).collect();
        assert_eq!(names, ["deep", "used"]);
    }
}
