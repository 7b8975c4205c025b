//! Tasks of which a run takes seconds: what comes with the harness, with a suite of two worlds in it.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Bench, Done, copy_dir, root};

/// A folder of tasks in which `mini`, the first two worlds of `smoke`, is a suite that comes with the harness.
#[derive(Debug)]
pub struct Mini {
    pub bench: Bench,
}

impl Default for Mini {
    fn default() -> Self {
        let bench = Bench::new();
        for folder in ["vehicles", "soils", "terrain", "rules"] {
            copy_dir(&root().join("tasks").join(folder), &bench.path("tasks").join(folder));
        }
        let mini = Self { bench };
        mini.suite("tasks/mini", "mini", &["w001", "w002"]);
        mini
    }
}

impl Mini {
    /// With the release harness.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes a suite of some worlds of `smoke`.
    pub fn suite(&self, folder: &str, name: &str, worlds: &[&str]) {
        let smoke = root().join("tasks/smoke");
        let index = fs::read_to_string(smoke.join("suite.yaml")).unwrap();
        let (head, list) = index.split_once("worlds:\n").unwrap();
        let head = head.replace("name: \"smoke\"", &format!("name: {name:?}"));
        let kept: String = list
            .split("  - id: ")
            .filter(|w| worlds.iter().any(|id| w.starts_with(id)))
            .map(|w| format!("  - id: {w}"))
            .collect();
        self.bench.write(&format!("{folder}/suite.yaml"), format!("{head}worlds:\n{kept}"));
        for world in worlds {
            copy_dir(&smoke.join("worlds").join(world), &self.bench.path(folder).join("worlds").join(world));
        }
    }

    /// A command of the harness with these tasks.
    #[must_use]
    pub fn command<S: AsRef<OsStr>>(&self, args: &[S]) -> Command {
        let mut command = self.bench.command(args);
        command.env("VB_TASKS", self.bench.path("tasks"));
        command
    }

    /// Runs a command to its end.
    pub fn run<S: AsRef<OsStr>>(&self, args: &[S]) -> Done {
        Done::of(&mut self.command(args))
    }

    /// The standard output of a command that must succeed.
    pub fn ok<S: AsRef<OsStr>>(&self, args: &[S]) -> String {
        self.run(args).ok()
    }

    /// Submits a planner on `mini`, into `out`.
    pub fn submit(&self, plugin: &Path, out: &str, more: &[&str]) {
        let plugin = plugin.to_str().unwrap();
        let args = ["submit", "--plugin", plugin, "--suite", "mini", "--out", out];
        self.ok(&[&args[..], more].concat());
    }

    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.bench.path(name)
    }
}
