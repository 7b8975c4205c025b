//! Success of planners with each uncertain parameter of the default vehicle and of the soils at its lower and upper bound.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::records::records;
use crate::run::{Failure, remove, run, step};
use crate::{built, default_plugin_dir, root, target_dir};

/// The tasks that are driven: two of each world of `vb-100`.
const TASKS: &str = "w*/t00,w*/t05";
const PLANNERS: [&str; 2] = ["pid", "tal"];

/// The file that has a parameter, below `tasks`.
#[derive(Clone, Copy, PartialEq)]
enum File {
    Vehicle,
    Soils,
}

impl File {
    fn path(self) -> PathBuf {
        root().join("tasks").join(match self {
            Self::Vehicle => "vehicles/hmmwv.yaml",
            Self::Soils => "soils/default.yaml",
        })
    }
}

/// A parameter at one of its bounds: texts of the file and what replaces them. Each text occurs in the file.
struct Bound {
    name: &'static str,
    value: &'static str,
    file: File,
    edits: &'static [(&'static str, &'static str)],
}

const fn vehicle(
    name: &'static str,
    value: &'static str,
    edits: &'static [(&'static str, &'static str)],
) -> Bound {
    Bound { name, value, file: File::Vehicle, edits }
}

/// Spring rates are changed at the same static force: free length = design length + static compression · old rate / new rate.
const BOUNDS: &[Bound] = &[
    vehicle("hull friction", "0.3", &[("\n  friction: 0.4", "\n  friction: 0.3")]),
    vehicle("hull friction", "0.5", &[("\n  friction: 0.4", "\n  friction: 0.5")]),
    vehicle("hull friction", "1.0", &[("\n  friction: 0.4", "\n  friction: 1.0")]),
    vehicle(
        "axle differentials",
        "open",
        &[("differential: {type: limited_slip, bias: 4.0, preload: 50.0}", "differential: {type: open}")],
    ),
    vehicle("torque bias", "2", &[("bias: 4.0", "bias: 2.0")]),
    vehicle("torque bias", "5", &[("bias: 4.0", "bias: 5.0")]),
    vehicle("preload", "0 N m", &[("preload: 50.0", "preload: 0.0")]),
    vehicle("preload", "150 N m", &[("preload: 50.0", "preload: 150.0")]),
    vehicle("centre differential", "open (range H)", &[("centre: {type: locked}", "centre: {type: open}")]),
    vehicle(
        "tyre stiffness",
        "110 kN/m",
        &[("vertical_stiffness: 157000.0", "vertical_stiffness: 110000.0")],
    ),
    vehicle(
        "tyre stiffness",
        "411 kN/m",
        &[("vertical_stiffness: 157000.0", "vertical_stiffness: 411000.0")],
    ),
    vehicle(
        "spring rates",
        "−30 %",
        &[
            ("stiffness: 167070.939, free_length: 0.31650", "stiffness: 116949.657, free_length: 0.34650"),
            ("stiffness: 369167.231, free_length: 0.33650", "stiffness: 258417.062, free_length: 0.34957"),
        ],
    ),
    vehicle(
        "spring rates",
        "+30 %",
        &[
            ("stiffness: 167070.939, free_length: 0.31650", "stiffness: 217192.221, free_length: 0.30035"),
            ("stiffness: 369167.231, free_length: 0.33650", "stiffness: 479917.400, free_length: 0.32946"),
        ],
    ),
    // Wheel rates of Chrono's reduced suspension model, which the vehicle file had before.
    vehicle(
        "spring rates",
        "× 4.4",
        &[
            ("stiffness: 167070.939, free_length: 0.31650", "stiffness: 735112.132, free_length: 0.26241"),
            ("stiffness: 369167.231, free_length: 0.33650", "stiffness: 1624335.816, free_length: 0.31293"),
        ],
    ),
    Bound {
        name: "soil strength",
        value: "cohesion −30 %, friction angle −3°",
        file: File::Soils,
        edits: &[
            ("cohesion: 5.5e3", "cohesion: 3.85e3"),
            ("cohesion: 9.65e3", "cohesion: 6.755e3"),
            ("cohesion: 13.79e3", "cohesion: 9.653e3"),
            ("cohesion: 27.58e3", "cohesion: 19.306e3"),
            ("cohesion: 1.04e3", "cohesion: 0.728e3"),
            ("cohesion: 3.3e3", "cohesion: 2.31e3"),
            ("cohesion: 1.3e3", "cohesion: 0.91e3"),
            ("friction_angle_deg: 17.5", "friction_angle_deg: 14.5"),
            ("friction_angle_deg: 11.0", "friction_angle_deg: 8.0"),
            ("friction_angle_deg: 28.0", "friction_angle_deg: 25.0"),
            ("friction_angle_deg: 33.7", "friction_angle_deg: 30.7"),
            ("friction_angle_deg: 31.1", "friction_angle_deg: 28.1"),
        ],
    },
    Bound {
        name: "soil strength",
        value: "cohesion +30 %, friction angle +3°",
        file: File::Soils,
        edits: &[
            ("cohesion: 5.5e3", "cohesion: 7.15e3"),
            ("cohesion: 9.65e3", "cohesion: 12.545e3"),
            ("cohesion: 13.79e3", "cohesion: 17.927e3"),
            ("cohesion: 27.58e3", "cohesion: 35.854e3"),
            ("cohesion: 1.04e3", "cohesion: 1.352e3"),
            ("cohesion: 3.3e3", "cohesion: 4.29e3"),
            ("cohesion: 1.3e3", "cohesion: 1.69e3"),
            ("friction_angle_deg: 17.5", "friction_angle_deg: 20.5"),
            ("friction_angle_deg: 11.0", "friction_angle_deg: 14.0"),
            ("friction_angle_deg: 28.0", "friction_angle_deg: 31.0"),
            ("friction_angle_deg: 33.7", "friction_angle_deg: 36.7"),
            ("friction_angle_deg: 31.1", "friction_angle_deg: 34.1"),
        ],
    },
];

/// Drives the tasks with every bound and prints the table of success rates. With `--resume`, runs that are complete are taken as
/// they are, and one that was stopped is continued.
pub(crate) fn sensitivity(options: &[&str]) -> Result<(), Failure> {
    if let Some(unknown) = options.iter().find(|option| **option != "--resume") {
        return Err(Failure::new(format!("sensitivity: unknown option {unknown} (it takes --resume)")));
    }
    crate::build_harness()?;
    for planner in PLANNERS {
        crate::plugins::build_one(planner, &default_plugin_dir())?;
    }
    let folder = target_dir().join("sensitivity");
    if options.is_empty() {
        remove(&folder)?;
    }
    step(
        "| parameter | value | PID, success % | PID, changed verdicts (gained, lost) | TAL, success % | TAL, changed verdicts (gained, lost) |",
    );
    step("|---|---|---|---|---|---|");
    let mut base = Vec::new();
    let mut row = String::from("| – | as in the files | ");
    for planner in PLANNERS {
        let found = drive(planner, &folder.join(planner).join("base"), None)?;
        row += &format!("{} | – | ", percent(&found));
        base.push(found);
    }
    step(row.trim_end());
    for (i, bound) in BOUNDS.iter().enumerate() {
        let file = edited(bound, &folder.join(format!("bound-{i}")))?;
        let mut row = format!("| {} | {} | ", bound.name, bound.value);
        for (planner, base) in PLANNERS.iter().zip(&base) {
            let found = drive(planner, &folder.join(planner).join(i.to_string()), Some((bound.file, &file)))?;
            let count =
                |from: bool| base.iter().zip(&found).filter(|(a, b)| **a == from && **b != from).count();
            row += &format!("{} | {}, {} | ", percent(&found), count(false), count(true));
        }
        step(row.trim_end());
    }
    Ok(())
}

fn percent(successes: &[bool]) -> String {
    let n = successes.iter().filter(|&&s| s).count();
    format!("{:.1}", 100.0 * n as f64 / successes.len().max(1) as f64)
}

/// Writes the file of a bound with its edits and returns its path.
fn edited(bound: &Bound, folder: &Path) -> Result<PathBuf, Failure> {
    let source = bound.file.path();
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", source.display()));
    let mut text = std::fs::read_to_string(&source).map_err(|e| wrong(&e))?;
    for (old, new) in bound.edits {
        if !text.contains(old) {
            return Err(wrong(&format!("{}: {old:?} is not in the file", bound.name)));
        }
        text = text.replace(old, new);
    }
    std::fs::create_dir_all(folder).map_err(|e| wrong(&e))?;
    let file = folder.join(source.file_name().unwrap_or_default());
    std::fs::write(&file, text).map_err(|e| wrong(&e))?;
    Ok(file)
}

/// The verdicts of a planner on the tasks, in the order of their names.
fn drive(planner: &str, out: &Path, changed: Option<(File, &Path)>) -> Result<Vec<bool>, Failure> {
    let mut drive = Command::new(built("vb-harness"));
    drive.arg("run").arg(default_plugin_dir().join(format!("{planner}.wasm")));
    drive
        .args(["--suite", "vb-100", "--tasks", TASKS, "--trace", "none", "--keep-going", "--resume"])
        .arg("--out")
        .arg(out);
    if let Some((file, path)) = changed {
        drive.arg(if file == File::Vehicle { "--vehicle" } else { "--soils" }).arg(path);
    }
    run(drive.stdout(Stdio::null()).stderr(Stdio::null()))?;
    let success = |r: &Value| r["outcome"].as_str() == Some("success");
    Ok(records(out)?.iter().map(success).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edit_names_a_text_of_its_file() {
        let folder = tempfile::tempdir().unwrap();
        for bound in BOUNDS {
            let file = edited(bound, folder.path()).unwrap();
            let (old, new) = (std::fs::read(bound.file.path()).unwrap(), std::fs::read(file).unwrap());
            assert_ne!(old, new, "{} {}", bound.name, bound.value);
        }
    }
}
