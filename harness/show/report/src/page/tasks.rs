//! The tasks, as data for the page's script.

use super::sections::label;
use crate::runs::Row;
use crate::{Beside, Report};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use vb_page::{escape, grouped, json};
use vb_score::{Cause, FuelUse, Measured, Metrics, Outcome, Reader, Ride};
use vb_world::TaskId;

/// Rows on the page at most: more would make a browser slow. All are in the tables for programs.
const ROWS: usize = 20_000;

pub(super) fn tasks(s: &mut String, report: &Report, beside: &Beside) {
    let total: usize = report.runs.runs.iter().map(|r| r.rows.len()).sum();
    let each = ROWS / report.runs.runs.len();
    let columns = columns();
    let mut shown = 0;
    let mut rows = Vec::new();
    for (k, run) in report.runs.runs.iter().enumerate() {
        // Failures first where not all have room: they are what one looks for.
        let mut chosen: Vec<&Row> = run.rows.iter().filter(|r| !r.succeeded()).take(each).collect();
        let room = each - chosen.len();
        chosen.extend(run.rows.iter().filter(|r| r.succeeded()).take(room));
        chosen.sort_by(|a, b| a.task.cmp(&b.task));
        shown += chosen.len();
        rows.extend(chosen.into_iter().map(|r| row(k, r, &columns, &beside.replays)));
    }
    let worlds: Vec<Value> = report
        .runs
        .worlds
        .iter()
        .map(|w| {
            let map = u8::from(beside.maps.contains(&w.name));
            json!([w.name, w.elevation.name(), w.terrain.name(), w.density.name(), map])
        })
        .collect();
    let runs: Vec<Value> =
        report.runs.runs.iter().map(|r| json!([r.label, r.dir.display().to_string()])).collect();
    let outcomes: Vec<String> = Outcome::ALL.map(label).into();
    let uncounted = Outcome::HostError.index();
    let causes: Vec<Value> = Cause::ALL.iter().map(|c| json!([c.name(), c.title()])).collect();
    let measures: Vec<Value> = columns.iter().map(|(head, digits, _)| json!([head, digits])).collect();
    let data = json!({"runs": runs, "worlds": worlds, "outcomes": outcomes, "causes": causes, "uncounted": uncounted,
                      "measures": measures, "rows": rows});
    if !beside.files.is_empty() {
        let list: Vec<String> =
            beside.files.iter().map(|f| format!("<a href=\"{0}\">{0}</a>", escape(f))).collect();
        let _ = write!(s, "<p class=\"about\">All tasks as a table: {}.</p>", list.join(", "));
    }
    if shown < total {
        let _ = write!(
            s,
            "<p class=\"about\">{} of {} tasks are listed, failures first; filters apply to these only. --csv and --parquet write all tasks.</p>",
            grouped(shown as u64),
            grouped(total as u64)
        );
    }
    let _ = write!(
        s,
        "<div id=\"browser\"><form class=\"bar\" autocomplete=\"off\"><label>run <select name=\"run\"></select></label><label>outcome \
         <select name=\"outcome\"></select></label><label>cause <select name=\"cause\"></select></label><label>solved by <select name=\"does\"></select></label><label>not by <select \
         name=\"not\"></select></label><label>search <input name=\"text\" type=\"search\" placeholder=\"w012/t03, high, upside…\"></label>\
         <output></output></form><div class=\"scroll\"><table><thead></thead><tbody></tbody></table></div>\
         <p class=\"more\"><button type=\"button\">Show more</button></p><noscript>The list of tasks needs JavaScript.</noscript></div>\
         <script type=\"application/json\" id=\"data\">{}</script>",
        json(&data)
    );
}

/// A number with two digits after the point.
fn round(v: f64) -> f64 {
    (v * 100.0).round() / 100.0
}

/// A column of a measure: its head, the digits after the point, and the value of a task.
type Column = (&'static str, usize, Box<dyn Fn(&Row) -> Option<Value>>);

/// The measures that are declared with a column.
fn columns() -> Vec<Column> {
    fn of<T>(measures: &'static [Measured<T>], part: fn(&Row) -> Option<&T>) -> impl Iterator<Item = Column> {
        measures.iter().filter_map(move |m| {
            let digits = usize::from(!matches!(m.value, Reader::Count(_)));
            let value = move |r: &Row| m.number(part(r)?).map(|v| json!(round(v)));
            Some((m.column?, digits, Box::new(value) as Box<_>))
        })
    }
    let metrics = of(Metrics::MEASURES, |r| r.metrics.as_ref());
    let ride = of(Ride::MEASURES, |r| r.ride.as_ref());
    metrics.chain(ride).chain(of(FuelUse::MEASURES, |r| r.fuel.as_ref())).collect()
}

/// A task as the script reads it.
fn row(run: usize, r: &Row, columns: &[Column], replays: &BTreeSet<TaskId>) -> Value {
    json!([
        run,
        r.task,
        r.world,
        r.outcome.index(),
        round(r.time),
        columns.iter().map(|(.., value)| value(r)).collect::<Vec<_>>(),
        &*r.note,
        u8::from(replays.contains(&r.task)),
        r.cause.and_then(|cause| Cause::ALL.iter().position(|c| *c == cause)),
    ])
}
