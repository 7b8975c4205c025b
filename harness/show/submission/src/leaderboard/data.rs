//! The leaderboard for programs: `leaderboard.json`.

use serde_json::{Value, json};
use vb_report::{Estimate, Measure};
use vb_score::{Cause, Flag, Outcome};

use super::rank::{Board, Ranked};

pub const LEADERBOARD_SCHEMA: u32 = 1;

pub(super) fn document(title: &str, boards: &[Board]) -> Value {
    json!({
        "schema": LEADERBOARD_SCHEMA,
        "title": title,
        "harness_version": env!("CARGO_PKG_VERSION"),
        "boards": boards.iter().map(board).collect::<Vec<_>>(),
    })
}

fn board(board: &Board) -> Value {
    let m = &board.entries[0].entry.manifest;
    json!({
        "division": board.division,
        "ranked_by": board.ranked_by,
        "suite": {"name": m.run.suite.name, "version": m.suite_version, "hash": m.run.suite.hash},
        "selector": m.run.selector,
        "vehicle": m.run.vehicle,
        "scale": m.run.scale,
        "soils": m.run.soils,
        "rules": {"name": m.run.rules.name, "hash": m.run.rules.hash},
        "harness_version": m.run.harness_version,
        "entries": board.entries.iter().map(entry).collect::<Vec<_>>(),
    })
}

fn entry(r: &Ranked) -> Value {
    let (e, m) = (&r.entry, &r.entry.manifest);
    let outcomes: serde_json::Map<String, Value> =
        Outcome::ALL.iter().map(|o| (o.name().to_owned(), e.figures.count(*o).into())).collect();
    let flags = Flag::ALL.iter().filter_map(|f| Some((f.name().to_owned(), e.figures.flagged(*f)?.into())));
    let flags: serde_json::Map<String, Value> = flags.collect();
    let causes = Cause::ALL.iter().map(|c| (c.name().to_owned(), Value::from(e.figures.caused(*c))));
    let causes: serde_json::Map<String, Value> = causes.filter(|(_, n)| *n != 0).collect();
    let levels = e.levels.iter().map(|(level, rate)| ((*level).to_owned(), Value::from(*rate)));
    let levels: serde_json::Map<String, Value> = levels.collect();
    json!({
        "rank": r.rank,
        "tied": r.tied,
        "id": e.id,
        "page": format!("entries/{}/index.html", e.id),
        "entrant": m.entrant,
        "planner": m.run.plugin.name,
        "version": m.run.plugin.version,
        "plugin_sha256": m.run.plugin.sha256,
        "kind": m.run.plugin.kind,
        "abi": m.abi,
        "open_because": m.open_because,
        "tasks": e.figures.tasks,
        "worlds": e.figures.worlds,
        "outcomes": outcomes,
        "flags": flags,
        "success_rate": estimate(e.figures.mean(Measure::Success)),
        "behind_first_of_rank": estimate(r.behind),
        "time_s": estimate(e.figures.mean(Measure::Time)),
        "roll_deg": estimate(e.figures.mean(Measure::Roll)),
        "pitch_deg": estimate(e.figures.mean(Measure::Pitch)),
        "success_by_elevation": levels,
        "causes": causes,
        "fuel_of_a_step_share": e.fuel,
        "started_at": m.run.started_at,
        "holdout": e.holdout,
        "verified": {
            "harness_version": e.verification.harness_version,
            "tasks_driven_again": e.verification.sample.as_ref().map(|s| s.tasks.len()),
            "seed": e.verification.sample.as_ref().and_then(|s| s.seed),
            "submission_sha256": e.verification.submission_sha256,
        },
    })
}

/// A mean with the ends of its interval.
fn estimate(e: Option<Estimate>) -> Value {
    e.map_or(Value::Null, |e| {
        json!({
            "mean": e.mean,
            "low": e.interval.map(|i| i.low),
            "high": e.interval.map(|i| i.high),
        })
    })
}
