//! `vb-harness sweep status`.

use serde::Serialize;
use vb_runner::sweep::RunState;
use vb_score::Outcome;

use super::{Sweep, SweepArgs};
use crate::error::CliError;
use crate::output;

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Run {
        run: &'a str,
        tasks: u64,
        #[serde(flatten)]
        state: &'a RunState,
    },
    Sweep {
        name: &'a str,
        runs: usize,
        runs_done: usize,
        tasks: u64,
        tasks_done: u64,
    },
}

pub(crate) fn status(args: &SweepArgs) -> Result<(), CliError> {
    let sweep = Sweep::open(args)?;
    let tasks = sweep.tasks.len() as u64;
    let mut rows = vec![["run", "done", "success", ""].map(str::to_owned).to_vec()];
    let (mut runs_done, mut tasks_done) = (0, 0);
    for planned in sweep.spec.runs() {
        let state = sweep.layout.state(&planned.name)?;
        let done = state.tasks();
        runs_done += usize::from(done == tasks);
        tasks_done += done;
        if args.format.is_json() {
            output::json(&Message::Run { run: &planned.name, tasks, state: &state });
        }
        let success = state.done.get(&Outcome::Success).copied().unwrap_or(0);
        let share =
            if done > 0 { format!("{:.1} %", 100.0 * success as f64 / done as f64) } else { String::new() };
        let note = match (state.failed, state.is_whole, done) {
            (n, ..) if n > 0 => format!("{n} tasks failed because of the machine"),
            (_, false, n) if n > 0 => "in shards".to_owned(),
            _ => String::new(),
        };
        rows.push(vec![planned.name.clone(), format!("{done}/{tasks}"), share, note]);
    }
    let (runs, all) = (sweep.spec.runs().len(), tasks * sweep.spec.runs().len() as u64);
    if args.format.is_json() {
        output::json(&Message::Sweep { name: &sweep.spec.name, runs, runs_done, tasks: all, tasks_done });
        return Ok(());
    }
    output::text(&output::columns(&rows));
    output::text(&format!(
        "{}: {runs_done} of {runs} runs and {tasks_done} of {all} tasks are finished\n",
        sweep.spec.name
    ));
    Ok(())
}
