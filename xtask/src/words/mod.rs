//! The terms that STYLE.md tells to avoid, in all that users read.

mod text;

use std::path::{Path, PathBuf};

use crate::root;
use crate::run::{Failure, step};
use text::{Line, cells, hashes, literals, prose, python, remarks, rust};

/// Files, and folders with files of an extension, with what is read of them.
struct Place(&'static str, &'static str, fn(&str) -> Vec<Line>);

const PLACES: &[Place] = &[
    Place("README.md", "md", prose),
    Place("ARCHITECTURE.md", "md", prose),
    Place("CONTRIBUTING.md", "md", prose),
    Place("SECURITY.md", "md", prose),
    Place("docs", "md", prose),
    Place("harness/python/README.md", "md", prose),
    Place("sdk/python/README.md", "md", prose),
    Place("harness/cli/src/args/snapshots", "snap", prose),
    Place("harness/python/vertibench", "py", python),
    Place("sdk/python/src", "py", python),
    Place("sdk/python/examples", "py", python),
    Place("plugins", "rs", rust),
    Place("sdk/src", "rs", rust),
    Place("sdk/wit", "wit", remarks),
    Place("sdk/c", "h", remarks),
    Place("harness", "rs", literals),
    Place("harness/cli/templates", "md", prose),
    Place("harness/cli/templates", "yml", hashes),
    Place("examples", "md", prose),
    Place("examples", "rs", rust),
    Place("examples", "py", python),
    Place("examples", "c", remarks),
    Place("examples", "h", remarks),
    Place("examples", "cpp", remarks),
    Place("examples", "js", remarks),
    Place("examples", "sh", hashes),
    Place("examples", "yaml", hashes),
    Place("examples", "yml", hashes),
    Place("examples", "ipynb", cells),
    Place("tasks/released.yaml", "yaml", hashes),
    Place("tasks/curricula", "yaml", hashes),
    Place("tasks/exploration", "yaml", hashes),
    Place("tasks/generator", "yaml", hashes),
    Place("tasks/rewards", "yaml", hashes),
    Place("tasks/rules", "yaml", hashes),
    Place("tasks/training", "yaml", hashes),
    Place("tasks/validation", "yaml", hashes),
];
