//! Tests, lints and documentation of the workspace: what must hold on main.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use crate::examples;
use crate::run::{Failure, cargo, cargo_program, run, step};

/// The crates whose tests are built with overflow checks and debug assertions: those that compute. What they compute is the same
/// without, which snapshots of `vb-sim` show.
const CHECKED: [&str; 7] =
    ["vb-math", "vb-world", "vb-vehicle", "vb-sim", "vb-score", "vb-terrain", "vb-terrain-train"];

/// Builds what the tests need and runs them all.
pub(crate) fn test() -> Result<(), Failure> {
    crate::build_all()?;
    examples::build_available(&crate::default_plugin_dir())?;
    step("running the tests");
    let skipped = crate::target_dir().join("skipped.tsv");
    let _ = std::fs::remove_file(&skipped);
    let cargo = |args: &[&str]| {
        let mut command = Command::new(cargo_program());
        command.arg("test").args(["--quiet", "--no-fail-fast"]).args(args).env(vb_testing::SKIPPED, &skipped);
        run(command.current_dir(crate::root()))
    };
    let of = |option: &'static str| CHECKED.iter().flat_map(move |name| [option, *name]);
    // What the harness was built of is there in release; to build it again without optimisation takes half an hour.
    let most: Vec<&str> = ["--release", "--workspace"].into_iter().chain(of("--exclude")).collect();
    let result = cargo(&most);
    // In release too, with checks in these crates alone, so that all that they depend on is there already. It is there with the
    // features that the workspace gives it, which `vb-unify` asks for here.
    // They are hardly optimised, too, as in a debug build, but for what draws and trains on some hundreds of surfaces.
    let checks = CHECKED.iter().flat_map(|name| {
        let optimised = if *name == "vb-terrain" { "opt-level=3" } else { "opt-level=1" };
        ["overflow-checks=true", "debug-assertions=true", optimised]
            .map(|setting| format!("profile.release.package.{name}.{setting}"))
    });
    let checks: Vec<String> = checks.collect();
    let mut checked = vec!["--release", "--package", "vb-unify"];
    checked.extend(of("--package"));
    checked.extend(checks.iter().flat_map(|check| ["--config", check]));
    let result = cargo(&checked).and(result);
    // Of a run without any there is no file.
    say_skipped(&std::fs::read_to_string(&skipped).unwrap_or_default());
    result
}

/// Prints which tests were skipped, by the reason; `list` has a line each: name, tab, reason.
fn say_skipped(list: &str) {
    let mut reasons: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (test, reason) in list.lines().filter_map(|line| line.split_once('\t')) {
        reasons.entry(reason).or_default().insert(test);
    }
    for (reason, tests) in reasons {
        let names: Vec<&str> = tests.into_iter().collect();
        step(&format!("skipped {}, {reason}: {}", names.len(), names.join(", ")));
    }
}

/// Checks formatting, lints and documentation.
pub(crate) fn lint() -> Result<(), Failure> {
    step("checking formatting, lints and documentation");
    cargo(&["fmt", "--all", "--check"])?;
    crate::words::check()?;
    // In release, where the macros that they expand were built for the tests.
    cargo(&["clippy", "--quiet", "--release", "--workspace", "--all-targets", "--", "--deny", "warnings"])?;
    // The program of the demo, which has fewer features, with dependencies that were built just now.
    let demo = ["--package", "vb-harness", "--no-default-features", "--features", "carried-tasks,unified"];
    cargo(&[&["clippy", "--quiet", "--release"][..], &demo, &["--", "--deny", "warnings"]].concat())?;
    cargo(&["doc", "--quiet", "--release", "--workspace", "--no-deps"])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The crates that a selection of packages is built of, each with its features; of those that run at build time only where
    /// the edges say so.
    fn built(selection: &[&str], edges: &str) -> BTreeSet<String> {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["tree", "--offline", "--prefix", "none", "--format", "{p} with {f}", "--edges", edges]);
        let told = cargo.args(selection).current_dir(crate::root()).output().expect("cargo runs");
        assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
        let text = String::from_utf8(told.stdout).expect("cargo prints text");
        text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
    }

    /// What cargo builds of one selection with other features than of the whole workspace.
    fn apart(selection: &[&str], edges: &str) -> Vec<String> {
        let all = built(&["--workspace"], &format!("{edges},dev"));
        let own = built(selection, edges);
        assert!(own.len() > 100 && all.len() > own.len(), "{} of {}", own.len(), all.len());
        own.difference(&all).cloned().collect()
    }

    #[test]
    fn whatever_is_built_serves_the_tests_of_the_workspace_too() {
        let checked: Vec<&str> =
            CHECKED.into_iter().chain(["vb-unify"]).flat_map(|name| ["--package", name]).collect();
        let harness = ["--package", "vb-harness"];
        let module = ["--package", "vb-python"];
        // Single crates, as CONTRIBUTING.md has their tests run.
        let single = ["vb-dataset", "vb-env", "vb-host", "vb-replay"]
            .map(|name| ["--package", "vb-unify", "--package", name]);
        // Those that are part of a program, and all with those that only run while it is built.
        for edges in ["normal,no-proc-macro", "normal,build"] {
            let single = single.iter().map(|one| &one[..]);
            for selection in [&harness[..], &module, &checked].into_iter().chain(single) {
                let apart = apart(selection, edges);
                assert!(
                    apart.is_empty(),
                    "these crates of {selection:?} are built again, with other features: name those in tools/unify/Cargo.toml: {apart:#?}"
                );
            }
        }
        let apart = apart(&checked, "normal,dev,no-proc-macro");
        assert!(apart.is_empty(), "of the tests with checks, too: {apart:#?}");
    }
}
