//! Both results side by side, as Markdown.

use std::fmt::Write as _;

use vb_score::{Outcome, TaskRecord};
use vb_world::{Elevation, Terrain};

use crate::reference::{End, Run};

/// A recorded run and our record of the same task.
pub(crate) type Pair = (Run, TaskRecord);

fn both_succeed((run, record): &Pair) -> bool {
    run.end == End::Success && record.outcome == Outcome::Success
}

/// Whether the vehicle arrived in both or in neither: the ways of failing have different names, and a vehicle that
/// lies on its side is stuck by these rules.
fn agree((run, record): &Pair) -> bool {
    (run.end == End::Success) == (record.outcome == Outcome::Success)
}

/// Our value over Chrono's, each summed over the pairs in which both vehicles arrive; none if there is no such pair.
fn ratio(
    pairs: &[&Pair],
    ours: impl Fn(&TaskRecord) -> Option<f64>,
    theirs: impl Fn(&Run) -> f64,
) -> Option<f64> {
    let mut sums = [0.0; 2];
    for (run, record) in pairs.iter().filter(|p| both_succeed(p)) {
        sums[0] += ours(record)?;
        sums[1] += theirs(run);
    }
    (sums[1] > 0.0).then(|| sums[0] / sums[1])
}

/// The table of tasks.
pub(crate) fn tasks(pairs: &[Pair]) -> String {
    let mut out = String::from(
        "| world | ground | level | pair | outcome: Chrono | here | | time, s | | mean \\|roll\\|, ° | | mean \\|pitch\\|, ° | |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for pair @ (run, record) in pairs {
        let metrics = record.metrics;
        let cell = |value: Option<f64>, decimals: usize| {
            value.map_or_else(|| "–".to_owned(), |v| format!("{v:.decimals$}"))
        };
        let short = |outcome: &str, distance: Option<f64>| match distance {
            Some(d) if outcome != "success" => format!("{outcome}, {d:.0} m short"),
            _ => outcome.to_owned(),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.1} | {} | {:.1} | {} |",
            run.world,
            run.terrain.name(),
            level(run.elevation),
            run.pair,
            short(&run.end.to_string(), Some(run.goal_distance)),
            short(record.outcome.name(), metrics.map(|m| m.goal_distance_end_m)),
            if agree(pair) { "" } else { "≠" },
            run.time,
            record.time_s,
            run.roll,
            cell(metrics.map(|m| m.roll_mean_deg), 1),
            run.pitch,
            cell(metrics.map(|m| m.pitch_mean_deg), 1),
        );
    }
    out
}

/// The original's name of a level.
fn level(elevation: Elevation) -> &'static str {
    match elevation {
        Elevation::Low => "low",
        Elevation::Medium => "mid",
        Elevation::High => "high",
    }
}

/// The table by ground and level.
pub(crate) fn aggregate(pairs: &[Pair]) -> String {
    let mut out = String::from(
        "| ground | level | tasks | same outcome | successes: Chrono | here | time, here / Chrono | mean \\|roll\\| | mean \\|pitch\\| |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for terrain in [Terrain::Rigid, Terrain::Mixed, Terrain::Deformable] {
        for elevation in Elevation::ALL {
            let group: Vec<&Pair> =
                pairs.iter().filter(|p| p.0.terrain == terrain && p.0.elevation == elevation).collect();
            if group.is_empty() {
                continue;
            }
            let count = |test: &dyn Fn(&Pair) -> bool| group.iter().filter(|p| test(p)).count();
            let cell = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                terrain.name(),
                level(elevation),
                group.len(),
                count(&agree),
                count(&|p| p.0.end == End::Success),
                count(&|p| p.1.outcome == Outcome::Success),
                cell(ratio(&group, |r| Some(r.time_s), |r| r.time)),
                cell(ratio(&group, |r| r.metrics.map(|m| m.roll_mean_deg), |r| r.roll)),
                cell(ratio(&group, |r| r.metrics.map(|m| m.pitch_mean_deg), |r| r.pitch)),
            );
        }
    }
    out
}
