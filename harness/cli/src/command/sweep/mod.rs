//! `vb-harness sweep`.

mod report;
mod run;
mod status;

use std::path::PathBuf;

use clap::Args;
use vb_runner::sweep::{Layout, PlannedRun, Spec};
use vb_world::{Suite, TaskId};

use crate::args::FormatArgs;
use crate::args::exit_codes::{codes, resumed};
use crate::command::run::RunArgs;
use crate::command::suite;
use crate::error::{CliError, FAILED_START, HOST_ERRORS, INCOMPLETE, INTERRUPTED, SIM_ERRORS};
use crate::places;
use run::SweepRunArgs;

commands! {
    SweepCommand

    /// Run all runs of a sweep, or with --resume those that are not finished
    #[command(after_help = resumed(&[SIM_ERRORS, HOST_ERRORS, FAILED_START, INTERRUPTED]))]
    Run(SweepRunArgs) => run::run,
    /// Print the progress of each run of a sweep
    Status(SweepArgs) => status::status,
    /// Join the shards of complete runs, and compare all runs in HTML reports and tables
    #[command(after_help = codes(&[INCOMPLETE]))]
    Report(SweepArgs) => report::report,
}

/// The sweep and where it lies.
#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// Sweep: a YAML file with planners, parameters, vehicles, perception profiles and seeds (docs/scale.md)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Directory for the runs of the sweep
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

/// A sweep with the tasks that each of its runs has.
struct Sweep {
    spec: Spec,
    layout: Layout,
    suite: Suite,
    tasks: Vec<TaskId>,
}

impl Sweep {
    fn open(args: &SweepArgs) -> Result<Self, CliError> {
        let spec = Spec::load(&args.file).map_err(CliError::input)?;
        let suite =
            suite::open(std::path::Path::new(spec.suite.as_deref().unwrap_or(vb_catalog::DEFAULT_SUITE)))?;
        let tasks = vb_catalog::select(&suite, spec.tasks.as_deref())
            .map_err(|e| CliError::input(format!("{}: tasks: {e}", args.file.display())))?;
        if spec.tasks.is_some() {
            suite::tell_choice(tasks.len(), &suite);
        }
        Ok(Self { spec, layout: Layout::new(&args.out), suite, tasks })
    }

    /// The command line of one of the runs.
    fn args(&self, planned: &PlannedRun) -> RunArgs {
        let mut args = RunArgs::new(&places::plugin(planned.plugin.clone().into()));
        args.planner.params = planned.params.clone().into_iter().collect();
        if let Some(suite) = &self.spec.suite {
            args.drive.suite = suite.into();
        }
        args.drive.tasks.clone_from(&self.spec.tasks);
        args.drive.rules.clone_from(&self.spec.rules);
        args.drive.trace = self.spec.trace;
        args.drive.vehicle.clone_from(&planned.vehicle);
        args.drive.perception.clone_from(&planned.perception);
        args.drive.seed = planned.seed;
        args
    }

    /// The number of worlds of each run.
    fn worlds(&self) -> u64 {
        let mut worlds: Vec<&str> = self.tasks.iter().map(|t| t.world()).collect();
        worlds.dedup();
        worlds.len() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_that_names_a_planner_alone_has_the_defaults_of_a_run() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("sweep.yaml");
        std::fs::write(&file, "schema: 1\nname: s\nplanners:\n- plugin: ./a.wasm\n").unwrap();
        let command = ["sweep", "status", file.to_str().unwrap(), "--out", "s"];
        let args = match crate::cli::parse(&command).unwrap() {
            crate::command::Command::Sweep(SweepCommand::Status(args)) => args,
            other => panic!("{other:?}"),
        };
        let sweep = Sweep::open(&args).unwrap();
        let planned = &sweep.spec.runs()[0];
        let wanted = RunArgs::new(std::path::Path::new(&planned.plugin));
        assert_eq!(format!("{:?}", sweep.args(planned)), format!("{wanted:?}"));
    }
}
