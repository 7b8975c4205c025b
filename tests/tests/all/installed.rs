//! The program alone, as `cargo install` leaves it: no checkout around it, no tasks and no planners beside it (docs/platforms.md).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use vb_tests::{Bench, Done, copy_dir, pid};

/// The program in a folder of its own, called from an empty one by a user who has nothing.
struct Installed {
    bench: Bench,
    program: PathBuf,
}

impl Installed {
    fn new() -> Self {
        let bench = Bench::new();
        for folder in ["bin", "empty", "home"] {
            fs::create_dir(bench.path(folder)).unwrap();
        }
        let program = bench.path("bin").join(format!("vb-harness{}", std::env::consts::EXE_SUFFIX));
        fs::copy(vb_tests::release_harness(), &program).unwrap();
        Self { bench, program }
    }

    fn command(&self, args: &[&str]) -> Command {
        self.command_of(&self.program, args)
    }

    fn command_of(&self, program: &Path, args: &[&str]) -> Command {
        // Its cache stays: planners are compiled once for all tests.
        let mut command = self.bench.command_of(program, args);
        for variable in ["VB_TASKS", "VB_PLUGINS", "VB_DATA", "XDG_DATA_HOME", "LOCALAPPDATA"] {
            command.env_remove(variable);
        }
        command.current_dir(self.bench.path("empty")).env("HOME", self.bench.path("home"));
        command
    }

    fn run(&self, args: &[&str]) -> Done {
        Done::of(&mut self.command(args))
    }

    /// What the user's data folder has.
    fn data(&self) -> Vec<String> {
        let folder = self.bench.path("home/.local/share/verti-bench");
        let names = fs::read_dir(folder).into_iter().flatten();
        let mut names: Vec<_> =
            names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

#[test]
fn the_program_alone_has_its_suites_and_vehicles_and_unpacks_them_when_they_are_needed() {
    let installed = Installed::new();
    assert!(installed.run(&["--version"]).ok().contains("vb-harness"));
    assert!(installed.data().is_empty(), "what isn't needed isn't unpacked");
    let suites = installed.run(&["list", "suites"]).ok();
    assert!(suites.contains("smoke") && suites.contains("vb-100"), "{suites}");
    let data = installed.data();
    assert!(matches!(&data[..], [tasks] if tasks.starts_with("tasks-")), "{data:?}");
    let unpacked = installed.bench.files(&format!("home/.local/share/verti-bench/{}", data[0]));
    assert!(unpacked == source(), "it is the folder of the sources, file by file");
    // A run writes the same records as one with the tasks of the checkout.
    let run = |mut command: Command| {
        let planner = pid();
        let args = ["--suite", "smoke", "--tasks", "w001/t00-t01", "--trace", "none", "--out", "run"];
        let _ = Done::of(command.arg("--plugin").arg(planner).args(args)).ok();
    };
    run(installed.command(&["run"]));
    run(installed.bench.command(&["run"]));
    let records = installed.bench.records("empty/run");
    assert_eq!(records.len(), 2);
    let hash = |run: &str| {
        installed.bench.records(run).values().map(|r| r["state_hash"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(hash("empty/run"), hash("run"));
    assert_eq!(installed.data(), data);
}

/// The files of the folder `tasks` of this repository, but for those that are git's.
fn source() -> std::collections::BTreeMap<PathBuf, Vec<u8>> {
    let bench = Bench::new();
    copy_dir(&vb_tests::root().join("tasks"), &bench.path("tasks"));
    let mut files = bench.files("tasks");
    files.retain(|path, _| !path.to_string_lossy().starts_with(".git"));
    files
}

#[test]
fn a_planner_is_installed_once_and_then_found_by_its_file_name() {
    let installed = Installed::new();
    let run = ["--plugin", "pid.wasm", "--suite", "smoke", "--tasks", "w001/t00", "--out", "run"];
    let told = installed.run(&run).error(3);
    assert!(told.contains("pid.wasm") && told.contains("plugin install"), "{told}");
    let planner = pid();
    let planner = planner.to_str().unwrap();
    // All or none.
    let told = installed.run(&["plugin", "install", planner, "gone.wasm"]).error(3);
    let has_planners = installed.data().contains(&"plugins".to_owned());
    assert!(told.contains("gone.wasm") && !has_planners, "{told}");
    let done = installed.run(&["plugin", "install", planner]);
    assert!(done.stderr.contains("pid.wasm"), "{}", done.stderr);
    let _ = done.ok();
    let _ = installed.run(&run).ok();
    let told = installed.run(&["plugin", "install", planner]).error(4);
    assert!(told.contains("pid.wasm is installed already") && told.contains("--force"), "{told}");
    let _ = installed.run(&["plugin", "install", "--force", planner]).ok();
    let told = installed.run(&["--plugin", "gone.wasm"]).error(3);
    assert!(told.contains("gone.wasm") && told.contains("verti-bench/plugins"), "{told}");
}

/// An archive of a release: program, tasks and planners in one folder; a link leads to the program.
#[cfg(unix)]
#[test]
fn what_lies_beside_the_program_comes_first() {
    let installed = Installed::new();
    copy_dir(&vb_tests::root().join("tasks"), &installed.bench.path("bin/tasks"));
    fs::create_dir(installed.bench.path("bin/plugins")).unwrap();
    fs::copy(pid(), installed.bench.path("bin/plugins/pid.wasm")).unwrap();
    let link = installed.bench.path("link");
    std::os::unix::fs::symlink(&installed.program, &link).unwrap();
    let run = ["--plugin", "pid.wasm", "--suite", "smoke", "--tasks", "w001/t00", "--out", "run"];
    let _ = Done::of(&mut installed.command_of(&link, &run)).ok();
    assert!(installed.data().is_empty());
}

#[test]
fn where_tasks_cannot_be_unpacked_one_line_says_where_and_what_to_do() {
    let installed = Installed::new();
    let file = installed.bench.path("file");
    fs::write(&file, "").unwrap();
    let told = Done::of(installed.command(&["list", "suites"]).env("VB_DATA", &file)).error(4);
    assert!(told.contains(file.to_str().unwrap()) && told.contains("VB_DATA"), "{told}");
    let told = Done::of(installed.command(&["list", "suites"]).env_remove("HOME")).error(4);
    assert!(told.contains("VB_DATA") && told.contains("VB_TASKS"), "{told}");
}
