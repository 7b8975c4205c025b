//! `vb-harness check`: the conformance kit on the command line.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use vb_files::one_line;
use vb_host::Limits;
use vb_record::Recording;
use vb_runner::conformance::{Check, Kit, Report, Verdict, check as check_plugin};
use vb_score::Rules;
use vb_world::TaskId;

use crate::args::{
    FormatArgs, MessageFormat, PlannerArgs, PluginArgs, RULES, SOIL_RESOLUTION, SOILS, VEHICLE,
};
use crate::command::{run, suite};
use crate::error::CliError;
use crate::{output, places, planner};

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    #[command(flatten)]
    pub(crate) planner: PlannerArgs,
    /// Suite: a directory, or the name of a shipped suite
    #[arg(long, value_name = "NAME|DIR", default_value = vb_catalog::DEFAULT_SUITE)]
    pub(crate) suite: PathBuf,
    /// Tasks of which the first, the middle and the last are run, e.g. w001-w004 or elevation=high,terrain=rigid; default: all
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) tasks: Option<String>,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Check(&'a Check),
    Finished { planner: Option<&'a str>, version: Option<&'a str>, passed: bool, counts: Counts },
}

#[derive(Serialize)]
struct Counts {
    pass: usize,
    warn: usize,
    fail: usize,
    skip: usize,
}

pub(crate) fn check(args: &CheckArgs) -> Result<(), CliError> {
    let plugin = args.plugin.path();
    if Recording::is_one(plugin) {
        let path = plugin.display();
        return Err(CliError::usage(format!(
            "{path}: a recording has no planner to check (check the planner of its run)"
        )));
    }
    let suite = suite::open(&args.suite)?;
    let tasks = spread(suite::select(&suite, args.tasks.as_deref())?);
    // Those of runs by default: a planner's promises don't depend on them.
    let rules = Rules::resolve(RULES).map_err(CliError::input)?;
    let vehicle = places::catalog().vehicle(VEHICLE)?;
    let soils = places::catalog().soils(SOILS, SOIL_RESOLUTION)?;
    let limits = args.planner.limits.as_deref().map_or_else(|| Ok(Limits::default()), run::limits)?;
    planner::can_be_confined(plugin, args.planner.require_sandbox)?;
    let command = planner::command(plugin);
    let file = command.is_none().then_some(plugin);
    let kit = Kit {
        load: &|| planner::load_quietly(plugin, &limits, args.planner.require_sandbox),
        file,
        params: &args.planner.params,
        limits: &limits,
        suite: &suite,
        tasks: &tasks,
        vehicle: &vehicle,
        soils: &soils,
        rules: &rules,
    };
    let cancel = run::stop_on_ctrl_c()?;
    let mut tell = |check: &Check| match args.format.get() {
        MessageFormat::Json => output::json(&Message::Check(check)),
        MessageFormat::Human => output::text(&row(check)),
    };
    let report = check_plugin(&kit, &mut tell, &cancel)?;
    finish(&report, args.format.get());
    if report.passed() {
        return Ok(());
    }
    let failed: Vec<_> =
        report.checks.iter().filter(|c| c.verdict == Verdict::Fail).map(|c| c.name).collect();
    let failed = failed.join(", ");
    Err(CliError::not_conforming(format!(
        "the planner failed these checks: {failed} (see the hint of each check)"
    )))
}

/// The first, the middle and the last: tasks of different worlds, as a rule.
fn spread(tasks: Vec<TaskId>) -> Vec<TaskId> {
    let mut places = vec![0, tasks.len() / 2, tasks.len().saturating_sub(1)];
    places.dedup();
    places.into_iter().filter_map(|i| tasks.get(i).cloned()).collect()
}

/// A check for people: what came of it, and in the next line what to do about it.
fn row(check: &Check) -> String {
    let hint = check.hint.map_or_else(String::new, |hint| format!("{:19}-> {hint}\n", ""));
    format!("{:<4}  {:<11}  {}\n{hint}", check.verdict.name(), check.name, one_line(&check.detail))
}

fn finish(report: &Report, format: MessageFormat) {
    let of = |verdict| report.count(verdict);
    let counts = Counts {
        pass: of(Verdict::Pass),
        warn: of(Verdict::Warn),
        fail: of(Verdict::Fail),
        skip: of(Verdict::Skip),
    };
    let planner = report.planner.as_ref();
    match format {
        MessageFormat::Json => output::json(&Message::Finished {
            planner: planner.map(|p| p.name.as_str()),
            version: planner.map(|p| p.version.as_str()),
            passed: report.passed(),
            counts,
        }),
        MessageFormat::Human => {
            let Counts { pass, warn, fail, skip } = counts;
            output::text(&format!("{pass} passed, {warn} with a warning, {fail} failed, {skip} skipped\n"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_tasks_are_spread_over_those_chosen_and_none_comes_twice() {
        let tasks = |n: usize| {
            let all = (0..n).map(|i| TaskId::new("w001", &format!("t{i:02}")).unwrap()).collect();
            spread(all).into_iter().map(|t| t.task().to_owned()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(tasks(100), "t00 t50 t99");
        assert_eq!(
            (tasks(3), tasks(2), tasks(1), tasks(0)),
            ("t00 t01 t02".into(), "t00 t01".into(), "t00".into(), String::new())
        );
    }
}
