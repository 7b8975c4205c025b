//! Development tasks: `cargo xtask help`.

mod blocks;
mod compare;
mod convergence;
mod equivalence;
mod examples;
mod fields;
mod fuzz;
mod kernel;
mod licences;
mod models;
mod options;
mod package;
mod performance;
mod pictures;
mod plugins;
mod portable;
mod prove;
mod records;
mod release;
mod results;
mod run;
mod sensitivity;
mod soak;
mod speed;
mod suites;
mod targets;
mod test;
mod tune;
mod wasm_target;
mod wheel;
mod words;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use run::{Failure, cargo, remove, step};

const USAGE: &str = "\
Usage: cargo xtask <TASK>

Tasks:
  demo                  Build the harness and the PID planner, drive it over the small suite and print the results
  test                  Build everything the tests need and run them all
  lint                  Check formatting, terms (STYLE.md), lints and documentation
  plugins [--out DIR]   Build all planners, as WASM and as native libraries [default DIR: target/plugins]
  plugins --wasm [--out DIR]
                        Build them as WASM alone
  examples [--out DIR]  Build the example planners in C, Python and JavaScript, and install their compilers from PyPI and
                        npm into ~/.cache/verti-bench [default DIR: target/plugins]
  wheel [--portable] [--target TRIPLE] [--kernels FOLDER] [--check] [--out DIR]
                        Make the wheel of the Python package [default DIR: target/wheels];
                        --kernels: with the kernels for GPUs that `kernel` has put there;
                        --portable: for Linux with glibc 2.17 on, by zig; --target: portable, for another processor;
                        --check: install the wheel in a fresh environment, and see that it works; the first build takes
                        minutes, and downloads its crates on the way
  targets [TRIPLE]...   See whether everything compiles for Linux, macOS and Windows on both kinds of processors, or for
                        some systems, and say which were skipped and why; zig is installed from PyPI
  targets --emulate     See whether an emulated AArch64 and emulated x86-64 processors compute the same bits as this machine
                        (needs Debian's qemu-user and libc6-arm64-cross)
  release [--target TRIPLE] [--check] [--out DIR]
                        Make the archive of a release, with checksums, for this system or another [default DIR:
                        target/releases]; --check: unpack it elsewhere, and see that it works
  install               Install the program for this user as `cargo install` does, with the planners
  abi                   Make what follows from the planner interface's text: types, conversions, headers, tables
  fields                Make the references of all fields of files, docs/vehicle-fields.md and docs/file-fields.md, from the code that reads them
  kernel [ARCH]...      Compile the simulator for GPUs of NVIDIA's, of all architectures or of some (sm_80, sm_90, sm_100,
                        sm_120): target/kernel/vb-kernel-ARCH.cubin.xz (needs Debian's packages, and 9 GB of memory)
  convergence           Drive 100 tasks at other steps and soil grids, and count the verdicts that stay
  equivalence           Drive 1000 tasks with ten vehicles and three planners at longer steps, and test whether their success rates are
                        equivalent to those at 1 ms
  suites                Write the suites in tasks/ anew, as the generator makes them now
  suites --check        Say whether they are what it makes
  performance           Measure the speed of simulator, tasks, planners and environments, and write the tables of docs/performance.md
                        (some 15 minutes on a machine that does nothing else; environments need a Python with the package: PYTHON)
  pictures              Drive the small suite with four planners, and make the README's pictures anew (needs Chromium)
  prove SUITE           Let the expert and other planners drive the tasks of a suite, and write who did which as its proof.json
  models                Explore training worlds, and train the models of the hybrid planners again
  results [COURSE]...   Drive the planners over the suites and the original's worlds, or over some of these courses, and write the
                        tables of results in README and docs, and state hashes in docs/results (--resume: continue the runs in
                        target/results; --verify: drive a tenth of the tasks and compare state hashes)
  leaderboard [--out DIR]
                        Submit, verify and rank the runs that `results vb-100-hmmwv` left, as a leaderboard for the documentation
                        site [default DIR: target/leaderboard]
  sensitivity           Run PID and TAL over 200 tasks of vb-100 with each uncertain parameter of vehicle and soils at its
                        bounds, and print the success rates (--resume: take complete runs as they are, continue others)
  tune PLANNER          Let candidates for its parameters drive training worlds, and print what became of them
  fuzz [TARGET] [--minutes N]
                        Fuzz every reader of foreign input, or one, with nightly Rust and cargo-fuzz [default: 20 each]
  soak [TASKS]          Drive vb-100, or the tasks of it that are selected, wildly with every vehicle, and fail where a
                        simulation does
  speed OTHER [ROUNDS]  Drive the same tasks by another version, a program or a commit, and by this one in turn, and print how
                        fast each simulates on one core [default: 5 rounds]
  compare-chrono        Drive the tasks that Project Chrono was recorded on, and write both results side by side
                        (--all: every task of which Chrono's end is known, by the recorded vehicle alone)

Environment:
  VB_WASM_FALLBACK=1    Build WASM by Debian's compiler packages, not by the installed Rust
  VB_WASM_HOME=DIR      Where those are unpacked [default: ~/.local/share/vb-wasm]
  VB_TORCH=1            Let `wheel --check` install what policies are trained with (6 GB), and train a tiny one
  VB_LANGUAGES=1        Let `test` install those compilers too, and fail where one is missing
  VB_PYTHON=PROGRAM     Python for the tests of planners in Python [default: python3]
  VB_PYTHON_LIBS=DIR    Where it finds numpy, msgpack, pytest, pyarrow, pillow, pyyaml, cyclonedds, mcap and rosbags, if they aren't installed
  VB_SHARED=DIR         Reference data, for tests and compare-chrono [default: shared, beside the repository]";

/// What the usage says of a task; none if there is no such task.
fn task_usage(task: &str) -> Option<String> {
    let (tasks, _) = USAGE.split_once("\n\nEnvironment:")?;
    let (_, tasks) = tasks.split_once("Tasks:\n")?;
    let mut own = Vec::new();
    let mut within = false;
    for line in tasks.lines() {
        // A task begins two columns from the left; what belongs to it is further in.
        if !line.starts_with("   ") {
            within = line.split_whitespace().next() == Some(task);
        }
        if within {
            own.push(line);
        }
    }
    (!own.is_empty()).then(|| format!("Usage: cargo xtask {task} [OPTIONS]\n\n{}", own.join("\n")))
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args[..] {
        [task, .., "--help" | "-h"] => {
            step(&task_usage(task).unwrap_or_else(|| USAGE.to_owned()));
            Ok(())
        }
        ["demo"] => demo(),
        ["test"] => test::test(),
        ["lint"] => test::lint(),
        ["convergence"] => convergence::convergence(),
        ["equivalence"] => equivalence::equivalence(),
        ["compare-chrono"] => compare::compare_chrono(false),
        ["compare-chrono", "--all"] => compare::compare_chrono(true),
        ["suites"] => build_harness().and_then(|()| suites::write()),
        ["suites", "--check"] => build_harness().and_then(|()| suites::check()),
        ["performance"] => performance::performance(),
        ["pictures"] => pictures::pictures(),
        ["prove", suite] => build_all().and_then(|()| prove::prove(Path::new(suite))),
        ["abi"] => abi(),
        ["fields"] => fields::fields(),
        ["models"] => models::models(),
        ["kernel", ref architectures @ ..] => kernel::kernel(architectures),
        ["results", ref options @ ..] => results::results(options),
        ["leaderboard"] => results::leaderboard(&target_dir().join("leaderboard")),
        ["leaderboard", "--out", dir] => results::leaderboard(Path::new(dir)),
        ["sensitivity", ref options @ ..] => sensitivity::sensitivity(options),
        ["tune", planner] => build_all().and_then(|()| tune::tune(planner)),
        ["soak"] => build_all().and_then(|()| soak::soak(None)),
        ["soak", tasks] => build_all().and_then(|()| soak::soak(Some(tasks))),
        ["speed", other] => build_all().and_then(|()| speed::speed(other, speed::ROUNDS)),
        ["speed", other, rounds] => {
            whole("ROUNDS", rounds).and_then(|rounds| build_all().and_then(|()| speed::speed(other, rounds)))
        }
        ["fuzz"] => fuzz::fuzz(None, FUZZ_MINUTES),
        ["fuzz", target] if !target.starts_with('-') => fuzz::fuzz(Some(target), FUZZ_MINUTES),
        ["fuzz", "--minutes", n] => whole("--minutes", n).and_then(|n| fuzz::fuzz(None, n)),
        ["fuzz", target, "--minutes", n] => whole("--minutes", n).and_then(|n| fuzz::fuzz(Some(target), n)),
        ["wheel", ref options @ ..] => wheel::wheel(options),
        ["targets", "--emulate"] => targets::emulate(),
        ["targets", ref wanted @ ..] => targets::check(wanted),
        ["release", ref options @ ..] => release::release(options),
        ["install"] => release::install(),
        ["plugins", "--wasm"] => plugins::build_as_wasm(&default_plugin_dir()),
        ["plugins", "--wasm", "--out", dir] => plugins::build_as_wasm(Path::new(dir)),
        ["plugins"] => plugins::build(&default_plugin_dir()),
        ["plugins", "--out", dir] => plugins::build(Path::new(dir)),
        ["examples"] => build_examples(&default_plugin_dir()),
        ["examples", "--out", dir] => build_examples(Path::new(dir)),
        ["help" | "--help" | "-h"] => {
            step(USAGE);
            Ok(())
        }
        _ => Err(Failure::new(format!("no such task: `{}`\n\n{USAGE}", args.join(" ")))),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            step(&format!("error: {failure}"));
            ExitCode::FAILURE
        }
    }
}

/// Minutes for which each target is fuzzed if nothing is said.
const FUZZ_MINUTES: u32 = 20;

fn whole(name: &str, text: &str) -> Result<u32, Failure> {
    let wrong = || Failure::new(format!("{name} {text}: must be a whole number from 1"));
    text.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)
}

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace")
}

/// Where cargo puts what it builds; an absolute path, since programs are run in other folders.
fn target_dir() -> PathBuf {
    // Relative to the current folder where the user sets it, as cargo takes it.
    let set = std::env::var_os("CARGO_TARGET_DIR").and_then(|dir| std::path::absolute(dir).ok());
    set.unwrap_or_else(|| root().join("target"))
}

/// A program that was built with optimisation.
fn built(name: &str) -> PathBuf {
    target_dir().join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

fn default_plugin_dir() -> PathBuf {
    target_dir().join("plugins")
}

fn build_harness() -> Result<(), Failure> {
    step("building the harness");
    cargo(&["build", "--release", "--package", "vb-harness"])
}

/// Builds the harness without the commands that a first run needs not, which takes two fifths fewer crates; none of it where all of it is
/// there.
fn build_small_harness() -> Result<(), Failure> {
    step("building the harness");
    let small = ["--no-default-features", "--features", "carried-tasks"];
    let all = built("vb-harness").exists();
    let features = if all { &[][..] } else { &small[..] };
    cargo(&[&["build", "--release", "--package", "vb-harness"], features].concat())
}

fn build_all() -> Result<(), Failure> {
    build_harness()?;
    plugins::build(&default_plugin_dir())
}

/// The harness writes their metadata.
fn build_examples(out: &Path) -> Result<(), Failure> {
    build_harness()?;
    examples::build(out)
}

fn demo() -> Result<(), Failure> {
    if !built("vb-harness").exists() {
        step("building everything for the first time takes 10 to 20 minutes on two cores");
    }
    // What it needs, and no more.
    build_small_harness()?;
    plugins::build_one("pid", &default_plugin_dir())?;
    let harness = built("vb-harness");
    let out = target_dir().join("demo-run");
    remove(&out)?;
    let suite = root().join("tasks").join("smoke");
    step(&format!("driving the PID planner over {}", suite.display()));
    let mut command = std::process::Command::new(harness);
    command.arg("--plugin").arg(default_plugin_dir().join("pid.wasm"));
    command.arg("--suite").arg(suite).arg("--out").arg(out);
    run::run(&mut command)
}

fn abi() -> Result<(), Failure> {
    cargo(&["run", "--quiet", "--package", "vb-abi"])
}

#[cfg(test)]
mod tests {
    use super::task_usage;

    #[test]
    fn each_task_tells_its_own_usage() {
        let wheel = task_usage("wheel").unwrap();
        assert!(wheel.starts_with("Usage: cargo xtask wheel [OPTIONS]\n\n  wheel [--portable]"), "{wheel}");
        assert!(wheel.contains("--kernels:") && !wheel.contains("targets"), "{wheel}");
        // Both lines of a task with two forms.
        assert_eq!(task_usage("plugins").unwrap().matches("  plugins ").count(), 2);
        assert!(task_usage("nothing").is_none() && task_usage("VB_TORCH=1").is_none());
    }
}
