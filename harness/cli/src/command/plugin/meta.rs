//! The file in which an author describes a planner that isn't written in Rust.

use std::path::Path;

use serde::Deserialize;
use vb_sdk::metadata::{self, Metadata, Need, ParamSpec};

use crate::error::CliError;

/// The metadata of a planner that isn't written in Rust.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    /// The planner's name.
    name: String,
    /// The planner's version.
    version: String,
    /// The authors, with addresses if they like.
    #[serde(default)]
    authors: Vec<String>,
    /// One sentence on the planner.
    #[serde(default)]
    about: String,
    /// The time between two steps, s.
    control_period: f64,
    /// The parameters that users can set.
    #[serde(default)]
    params: Vec<Param>,
    /// Requested sensors, each with its rate in Hz, e.g. `lidar 10`.
    #[serde(default)]
    needs: Vec<String>,
    /// Sensors requested in addition under profiles without prior maps.
    #[serde(default)]
    needs_without_maps: Vec<String>,
    /// Learned weights with their hashes.
    #[serde(default)]
    models: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Param {
    /// The parameter's name.
    name: String,
    /// The parameter's default value.
    default: String,
    /// A description with the unit.
    #[serde(default)]
    help: String,
}

/// Reads such a file. The ABI version is that of this harness.
pub(super) fn read(file: &Path) -> Result<Metadata, CliError> {
    let text = vb_files::read_text(file, vb_files::DOCUMENT).map_err(|e| {
        CliError::input(format!("{}: can't read the planner's metadata: {e}", file.display()))
    })?;
    parse(&text).map_err(|problem| CliError::input(format!("{}: {problem}", file.display())))
}

fn parse(text: &str) -> Result<Metadata, String> {
    let document: Document = vb_files::yaml::parse(text).map_err(|e| e.to_string())?;
    let Document { name, version, authors, about, control_period, params, needs, needs_without_maps, models } =
        document;
    if !metadata::is_name(&name) {
        return Err(format!("name: {name:?} is not a valid planner name; use a-z, 0-9, - and _"));
    }
    if version.trim().is_empty() {
        return Err("version: it is empty; it identifies results, e.g. 0.1.0".into());
    }
    if let Some(author) = authors.iter().find(|a| a.is_empty() || a.contains(':')) {
        return Err(format!("authors: {author:?} must be a text without a colon, which separates authors"));
    }
    if !metadata::is_control_period(control_period) {
        return Err(format!("control_period: {control_period} must be a positive multiple of 0.001 s"));
    }
    for (i, param) in params.iter().enumerate() {
        let fit = |c: char| !c.is_control() && !c.is_whitespace() && c != '=';
        if param.name.is_empty() || !param.name.chars().all(fit) {
            let name = &param.name;
            return Err(format!("params[{i}].name: {name:?} can't be set by --param; use no space and no ="));
        }
        if params[..i].iter().any(|p| p.name == param.name) {
            return Err(format!("params[{i}].name: {:?} is declared twice", param.name));
        }
    }
    let list = |field: &str, texts: Vec<String>| {
        let mut needs = Vec::new();
        for (i, text) in texts.iter().enumerate() {
            Need::add(&mut needs, text).map_err(|reason| format!("{field}[{i}]: {reason}"))?;
        }
        Ok::<_, String>(needs)
    };
    let needs = list("needs", needs)?;
    let needs_without_maps = list("needs_without_maps", needs_without_maps)?;
    let spec = |p: Param| ParamSpec { key: p.name, default: p.default, help: p.help };
    let params = params.into_iter().map(spec).collect();
    let abi = vb_sdk::ABI_VERSION.to_owned();
    Ok(Metadata {
        abi,
        name,
        version,
        authors,
        about,
        control_period,
        params,
        needs,
        needs_without_maps,
        models,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "\
name: drive-c
version: 0.1.0
authors: [A B <a@b>, C]
about: 'Drives: well'
control_period: 0.05
params:
  - { name: speed, default: \"4.0\", help: \"m/s, at most\" }
  - { name: mode, default: \"\" }
models: [hills.vbnn sha256 1]
";

    #[test]
    fn a_description_becomes_metadata_of_this_abi() {
        let m = parse(WHOLE).unwrap();
        assert_eq!((m.abi.as_str(), m.name.as_str(), m.version.as_str()), ("1.0", "drive-c", "0.1.0"));
        assert_eq!((m.authors, m.about.as_str()), (vec!["A B <a@b>".into(), "C".into()], "Drives: well"));
        assert_eq!(m.control_period, 0.05);
        let spec = |k: &str, d: &str, h: &str| ParamSpec { key: k.into(), default: d.into(), help: h.into() };
        assert_eq!(m.params, [spec("speed", "4.0", "m/s, at most"), spec("mode", "", "")]);
        assert_eq!(m.models, ["hills.vbnn sha256 1"]);
        let least = parse("{name: a, version: '1', control_period: 1}").unwrap();
        assert_eq!((least.params.len(), least.control_period), (0, 1.0));
    }

    #[test]
    fn what_the_harness_could_not_use_is_refused_with_its_place() {
        let changed = |from: &str, to: &str| parse(&WHOLE.replace(from, to)).unwrap_err();
        for (from, to, says) in [
            ("drive-c", "Drive C", "name: \"Drive C\""),
            ("version: 0.1.0", "version: ''", "version: it is empty"),
            ("A B <a@b>", "'a:b'", "authors: \"a:b\""),
            ("0.05", "0.0005", "control_period: 0.0005"),
            ("0.05", "soon", "control_period"),
            ("name: mode", "name: speed", "params[1].name: \"speed\" is declared twice"),
            ("name: mode", "name: 'a=b'", "params[1].name: \"a=b\""),
            ("about:", "abuot:", "abuot"),
            ("about:", "needs: [radar]\nabout:", "needs[0]: unknown sensor `radar`"),
            ("about:", "needs: [imu 30]\nabout:", "needs[0]: the rate `30` of imu must be"),
            ("about:", "needs: [imu, imu 10]\nabout:", "needs[1]: imu is requested twice"),
        ] {
            let e = changed(from, to);
            assert!(e.contains(says) && e.lines().count() == 1, "{to}: {e}");
        }
    }
}
