//! Telling how a run goes: a bar on a terminal, else plain lines, or JSON.

use std::collections::BTreeMap;
use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use serde::Serialize;
use vb_runner::Event;
use vb_score::{Outcome, TaskRecord};

use crate::args::MessageFormat;
use crate::output;

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Message<'a> {
    Started {
        #[serde(skip_serializing_if = "Option::is_none")]
        run: Option<&'a str>,
        total: u64,
        resumed: u64,
    },
    Task {
        #[serde(skip_serializing_if = "Option::is_none")]
        run: Option<&'a str>,
        done: u64,
        total: u64,
        record: &'a TaskRecord,
    },
}

enum Kind {
    Json,
    /// Nothing but what must be said.
    Quiet,
    Lines,
    Bar(ProgressBar),
}

/// The course of a run, for people or programs that watch it.
pub(crate) struct Progress {
    kind: Kind,
    /// Of many runs the one that goes on, and whether there are many.
    run: Option<String>,
    total: u64,
    done: u64,
    outcomes: BTreeMap<Outcome, u64>,
    /// Commands of all tasks, and those of them that were out of range.
    commands: u64,
    clamped: u64,
    /// Simulated time of the tasks that this process ran, s.
    simulated: f64,
    since: Instant,
}

impl Progress {
    pub(crate) fn new(format: MessageFormat) -> Self {
        let kind = match format {
            MessageFormat::Json => Kind::Json,
            MessageFormat::Human if output::is_quiet() => Kind::Quiet,
            MessageFormat::Human if std::io::stderr().is_terminal() => Kind::Bar(ProgressBar::no_length()),
            MessageFormat::Human => Kind::Lines,
        };
        Self {
            kind,
            run: None,
            total: 0,
            done: 0,
            outcomes: BTreeMap::new(),
            commands: 0,
            clamped: 0,
            simulated: 0.0,
            since: now(),
        }
    }

    /// The course of many runs that have so many tasks in all.
    pub(crate) fn of_many(format: MessageFormat, total: u64) -> Self {
        let progress = Self { run: Some(String::new()), total, ..Self::new(format) };
        progress.show_bar();
        progress
    }

    /// Of many runs, the next one begins.
    pub(crate) fn enter(&mut self, run: &str) {
        self.run = Some(run.to_owned());
    }

    /// Of many runs, some tasks are done already.
    pub(crate) fn done_before(&mut self, tasks: u64) {
        self.done += tasks;
        self.show_bar();
    }

    /// Something to be said in between, whatever else is said.
    pub(crate) fn say(&self, text: &str) {
        match &self.kind {
            Kind::Json => {}
            Kind::Quiet | Kind::Lines => output::say(text),
            Kind::Bar(bar) => bar.suspend(|| output::say(text)),
        }
    }

    /// Something has happened in the run.
    pub(crate) fn hear(&mut self, event: Event) {
        match event {
            Event::Started { total, resumed } => self.started(total as u64, &resumed),
            Event::TaskEnded(record) => self.ended(&record),
            Event::TaskStarted { .. } => {}
        }
    }

    /// The run begins: `total` tasks, of which those of `resumed` are done already.
    fn started(&mut self, total: u64, resumed: &[TaskRecord]) {
        for record in resumed {
            self.count(record);
        }
        let resumed = resumed.len() as u64;
        if self.run.is_some() {
            self.done += resumed;
        } else {
            (self.total, self.done, self.since) = (total, resumed, now());
        }
        let run = self.run.as_deref();
        match &self.kind {
            Kind::Json => output::json(&Message::Started { run, total, resumed }),
            Kind::Lines if resumed > 0 => {
                output::note(&format!("{resumed} of {total} tasks are already finished"))
            }
            Kind::Quiet | Kind::Lines => {}
            Kind::Bar(_) => self.show_bar(),
        }
    }

    fn show_bar(&self) {
        let Kind::Bar(bar) = &self.kind else { return };
        bar.set_length(self.total);
        bar.set_position(self.done);
        bar.reset_eta();
        // A wrong template would only cost the style. The second line is cut to the terminal's width.
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len}  {left}\n{wide_msg}") {
            let before = self.done;
            let left = move |state: &ProgressState, to: &mut dyn std::fmt::Write| {
                let done = state.pos().saturating_sub(before);
                let _ = to.write_str(&left(
                    state.elapsed(),
                    done,
                    state.len().unwrap_or(0).saturating_sub(state.pos()),
                ));
            };
            bar.set_style(style.with_key("left", left).progress_chars("━╸ "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
    }

    /// A task has ended.
    fn ended(&mut self, record: &TaskRecord) {
        self.done += 1;
        self.simulated += record.time_s;
        self.count(record);
        let run = self.run.as_deref();
        match &self.kind {
            Kind::Json => output::json(&Message::Task { run, done: self.done, total: self.total, record }),
            Kind::Quiet => {}
            Kind::Lines => {
                let run = run.map_or_else(String::new, |run| format!("{run} "));
                let width = self.total.to_string().len();
                let task = format!("[{:>width$}/{}] {run}{} ", self.done, self.total, record.task);
                let end = format!(" {:.2} s: {}", record.time_s, record.explanation());
                output::note_outcome(&task, record.outcome, &end);
                details(record, output::is_verbose()).iter().for_each(|line| output::note(line));
            }
            Kind::Bar(bar) => {
                let counts: Vec<String> =
                    self.outcomes.iter().map(|(o, n)| format!("{n} {}", output::coloured(*o))).collect();
                let run = run.map_or_else(String::new, |run| format!("{run}  "));
                bar.set_message(format!("{run}{}  {}", counts.join(", "), self.speed()));
                bar.set_position(self.done);
                let logged = output::is_verbose() && !record.log.is_empty();
                if record.fault.is_some() || logged {
                    bar.suspend(|| {
                        let (task, end) = (format!("{} ", record.task), format!(": {}", record.reason));
                        output::note_outcome(&task, record.outcome, &end);
                        details(record, output::is_verbose()).iter().for_each(|line| output::note(line));
                    });
                }
            }
        }
    }

    fn count(&mut self, record: &TaskRecord) {
        *self.outcomes.entry(record.outcome).or_default() += 1;
        self.commands += record.planner_steps;
        self.clamped += record.clamped;
    }

    /// How many commands weren't carried out as the planner gave them, if any: scores alone don't show it.
    pub(crate) fn clamped(&self) -> Option<String> {
        let (clamped, commands) = (self.clamped, self.commands);
        (clamped > 0).then(|| {
            format!(
                "{clamped} of {commands} commands were out of range and clamped (keep steering within [-1, 1], throttle and \
                 brake within [0, 1])"
            )
        })
    }

    /// The run has ended, in whichever way.
    pub(crate) fn finish(&self) {
        if let Kind::Bar(bar) = &self.kind {
            bar.finish_and_clear();
        }
        if self.simulated > 0.0 && !matches!(self.kind, Kind::Json) {
            let wall = self.since.elapsed().as_secs_f64();
            output::note(&format!("{:.0} s simulated in {wall:.1} s: {}", self.simulated, self.speed()));
        }
    }

    /// Simulated time over wall time, all workers together.
    fn speed(&self) -> String {
        let wall = self.since.elapsed().as_secs_f64();
        if wall > 0.0 { format!("{:.0}x real time", self.simulated / wall) } else { String::new() }
    }
}

/// How long the tasks that are left will take if they take as long as those that are done, as told beside the bar. Before the first
/// is done nothing is known.
fn left(elapsed: Duration, done: u64, left: u64) -> String {
    if left == 0 {
        return String::new();
    }
    if done == 0 {
        return "time left: –".to_owned();
    }
    let seconds = (elapsed.as_secs_f64() / done as f64 * left as f64).ceil() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds} s left"),
        (0, _) => format!("{minutes} min {seconds:02} s left"),
        _ => format!("{hours} h {minutes:02} min left"),
    }
}

/// What helps to find out why a task failed: the last lines that the planner logged, if an error ended it, and, where details are wanted,
/// of any task, with where it trapped.
fn details(record: &TaskRecord, verbose: bool) -> Vec<String> {
    /// More of them are in tasks.jsonl.
    const LOG_LINES: usize = 5;
    let mut lines = Vec::new();
    // Of the tasks of a run many fail, and few by an error: their logs would bury all else.
    let log = if record.fault.is_some() || verbose { &record.log[..] } else { &[] };
    for line in &log[log.len().saturating_sub(LOG_LINES)..] {
        // A record on disk is data from outside too.
        lines.push(format!("    log | {}", vb_files::one_line(line)));
    }
    if verbose {
        let frames = record.backtrace.iter().enumerate();
        lines.extend(frames.map(|(n, name)| format!("    {n:>3} | {}", vb_files::one_line(name))));
    }
    lines
}

#[allow(clippy::disallowed_methods, reason = "for people who watch: nothing of it reaches a score")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_the_tasks_left_and_unknown_before_the_first() {
        let after = |seconds, done, of| left(Duration::from_secs(seconds), done, of);
        assert_eq!(after(9, 0, 100), "time left: –");
        assert_eq!(after(10, 5, 10), "20 s left");
        assert_eq!(after(60, 10, 90), "9 min 00 s left");
        assert_eq!(after(3600, 1, 2), "2 h 00 min left");
        assert_eq!(after(10, 100, 0), "");
    }
}
