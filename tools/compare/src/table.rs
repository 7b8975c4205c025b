//! Both results side by side, as Markdown.

use std::fmt::Write as _;

use vb_score::{Outcome, TaskRecord};
use vb_world::Elevation;

use crate::mode::Mode;
use crate::reference::{End, GROUNDS, Run};

/// Our records of one task: as it is, and with the start moved by 0.1 m all around.
#[derive(Clone, Debug)]
pub(crate) struct Ours {
    pub(crate) nominal: TaskRecord,
    pub(crate) moved: Vec<TaskRecord>,
}

impl Ours {
    fn succeeds(&self) -> bool {
        self.nominal.outcome == Outcome::Success
    }

    /// How many of all starts arrive, and of how many.
    fn arrivals(&self) -> (usize, usize) {
        let all = self.moved.iter().chain([&self.nominal]);
        (all.filter(|r| r.outcome == Outcome::Success).count(), self.moved.len() + 1)
    }
}

/// A recorded run and ours of the same task in each mode, in the order of [`Mode::ALL`]; none where the ground can't
/// be simulated.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) run: Run,
    pub(crate) ours: Vec<Option<Ours>>,
}

/// A recorded run and ours in one mode.
type Pair<'a> = (&'a Run, &'a Ours);

/// Whether the vehicle arrived in both or in neither: the ways of failing have different names, and a vehicle that
/// lies on its side is stuck by these rules.
fn agree((run, ours): Pair<'_>) -> bool {
    (run.end == End::Success) == ours.succeeds()
}

/// How many of our starts end as Chrono's run does, and of how many.
fn alike((run, ours): Pair<'_>) -> (usize, usize) {
    let (arrive, all) = ours.arrivals();
    (if run.end == End::Success { arrive } else { all - arrive }, all)
}

/// Our value over Chrono's, each summed over the pairs in which both vehicles arrive; none if there is no such pair.
fn ratio(
    pairs: &[Pair<'_>],
    ours: impl Fn(&TaskRecord) -> Option<f64>,
    theirs: impl Fn(&Run) -> f64,
) -> Option<f64> {
    let mut sums = [0.0; 2];
    for (run, own) in pairs.iter().filter(|(run, own)| run.end == End::Success && own.succeeds()) {
        sums[0] += ours(&own.nominal)?;
        sums[1] += theirs(run);
    }
    (sums[1] > 0.0).then(|| sums[0] / sums[1])
}

/// The original's name of a level.
fn level(elevation: Elevation) -> &'static str {
    match elevation {
        Elevation::Low => "low",
        Elevation::Medium => "mid",
        Elevation::High => "high",
    }
}

/// One line a task.
pub(crate) fn tasks(rows: &[Row], modes: &[Mode]) -> String {
    let mut out = String::from("| world, pair | ground | level | Chrono |");
    for mode in modes {
        let _ = write!(out, " {} |", mode.title());
    }
    out.push_str("\n|---|---|---|---|");
    out.push_str(&"---|".repeat(modes.len()));
    out.push('\n');
    for Row { run, ours } in rows {
        let theirs = cell(&run.end.to_string(), run.time, run.roll, run.pitch, run.goal_distance);
        let (ground, level) = (run.terrain.name(), level(run.elevation));
        let _ = write!(out, "| {}, {} | {ground} | {level} | {theirs} |", run.world, run.pair);
        for own in ours {
            let text = own.as_ref().map_or_else(|| "–".into(), |own| own_cell((run, own)));
            let _ = write!(out, " {text} |");
        }
        out.push('\n');
    }
    out
}

fn own_cell(pair: Pair<'_>) -> String {
    let record = &pair.1.nominal;
    let text = match record.metrics {
        Some(m) => {
            let name = record.outcome.name().replace('_', " ");
            cell(&name, record.time_s, m.roll_mean_deg, m.pitch_mean_deg, m.goal_distance_end_m)
        }
        None => record.reason.clone(),
    };
    let mark = if agree(pair) { "" } else { "**≠** " };
    let (arrive, all) = pair.1.arrivals();
    let chance = if arrive == 0 || arrive == all { String::new() } else { format!(" ({arrive} of {all})") };
    format!("{mark}{text}{chance}")
}

/// Time and mean |roll| and |pitch| of an arrival; how and where a failure ended.
fn cell(outcome: &str, time: f64, roll: f64, pitch: f64, goal_distance: f64) -> String {
    if outcome == "success" {
        format!("{time:.1} s, {roll:.1}°, {pitch:.1}°")
    } else {
        format!("{outcome} after {time:.0} s, {goal_distance:.0} m short")
    }
}

/// Roll at the end beyond which a failed run counts as rolled over, degrees: that of the paper's failures.
const ROLLED_OVER: f64 = 30.0;

/// How the runs of the first mode ended beside Chrono's, one line a ground and level and one for all.
///
/// The paired difference of arrivals is given in its standard errors, sqrt(b + c − (b − c)²/n), where b and c tasks were
/// done in one simulator alone.
pub(crate) fn ends(rows: &[Row]) -> String {
    let pairs: Vec<Pair<'_>> = rows.iter().filter_map(|r| Some((&r.run, r.ours[0].as_ref()?))).collect();
    let mut out = String::from(
        "| ground | level | tasks | arrives: Chrono | here | Chrono alone | here alone | difference / its error | same end \
         | rolled over at the end: Chrono | here |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut line = |ground: &str, level: &str, group: &[Pair<'_>]| {
        let count = |test: &dyn Fn(Pair<'_>) -> bool| group.iter().filter(|p| test(**p)).count();
        let (theirs, own) = (count(&|p| p.0.end == End::Success), count(&|p| p.1.succeeds()));
        let both = count(&|p| p.0.end == End::Success && p.1.succeeds());
        let (b, c, n) = ((theirs - both) as f64, (own - both) as f64, group.len() as f64);
        let error = (b + c - (b - c) * (b - c) / n).sqrt();
        let difference = if error > 0.0 { format!("{:+.1}", (c - b) / error) } else { "–".to_owned() };
        let over = |roll: Option<f64>| roll.is_some_and(|r| r.abs() > ROLLED_OVER);
        let _ = writeln!(
            out,
            "| {ground} | {level} | {} | {theirs} | {own} | {} | {} | {difference} | {} ({:.0} %) | {} | {} |",
            group.len(),
            theirs - both,
            own - both,
            count(&agree),
            100.0 * count(&agree) as f64 / n,
            count(&|p| p.0.end != End::Success && over(p.0.roll_end)),
            count(&|p| !p.1.succeeds() && over(p.1.nominal.metrics.map(|m| m.roll_end_deg))),
        );
    };
    for terrain in GROUNDS {
        for elevation in Elevation::ALL {
            let within = |p: &&Pair<'_>| p.0.terrain == terrain && p.0.elevation == elevation;
            let group: Vec<Pair<'_>> = pairs.iter().filter(within).copied().collect();
            if !group.is_empty() {
                line(terrain.name(), level(elevation), &group);
            }
        }
    }
    if !pairs.is_empty() {
        line("all", "", &pairs);
    }
    out
}

/// One line a ground and level, for one mode.
pub(crate) fn aggregate(rows: &[Row], mode: Mode) -> String {
    let index = Mode::ALL.iter().position(|m| *m == mode).unwrap_or(0);
    let pairs: Vec<Pair<'_>> = rows.iter().filter_map(|r| Some((&r.run, r.ours[index].as_ref()?))).collect();
    let mut out = String::from(
        "| ground | level | tasks | same outcome | of most starts | of one start or more | successes: Chrono | here \
         | time, here / Chrono | mean \\|roll\\| | mean \\|pitch\\| |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for terrain in GROUNDS {
        for elevation in Elevation::ALL {
            let group: Vec<Pair<'_>> = pairs
                .iter()
                .filter(|p| p.0.terrain == terrain && p.0.elevation == elevation)
                .copied()
                .collect();
            if group.is_empty() {
                continue;
            }
            let count = |test: &dyn Fn(Pair<'_>) -> bool| group.iter().filter(|p| test(**p)).count();
            let cell = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                terrain.name(),
                level(elevation),
                group.len(),
                count(&agree),
                count(&|p| 2 * alike(p).0 > alike(p).1),
                count(&|p| alike(p).0 > 0),
                count(&|p| p.0.end == End::Success),
                count(&|p| p.1.succeeds()),
                cell(ratio(&group, |r| Some(r.time_s), |r| r.time)),
                cell(ratio(&group, |r| r.metrics.map(|m| m.roll_mean_deg), |r| r.roll)),
                cell(ratio(&group, |r| r.metrics.map(|m| m.pitch_mean_deg), |r| r.pitch)),
            );
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use vb_world::Terrain;

    fn run(end: End, time: f64, roll: f64) -> Run {
        let (elevation, terrain) = (Elevation::Medium, Terrain::Rigid);
        Run {
            world: 8,
            pair: 3,
            elevation,
            terrain,
            end,
            time,
            roll,
            pitch: 2.0,
            goal_distance: 61.7,
            roll_end: None,
            cost: 0.5,
        }
    }

    fn record(outcome: &str, time: f64, roll: f64) -> TaskRecord {
        let metrics = vb_score::Metrics {
            roll_mean_deg: roll,
            pitch_mean_deg: 1.0,
            goal_distance_end_m: 42.4,
            ..Default::default()
        };
        serde_json::from_value(json!({
            "task": "w008/t03", "world": "w008", "elevation": "medium", "terrain": "rigid", "density": "dense",
            "outcome": outcome, "three_way": if outcome == "success" { outcome } else { "stuck" },
            "reason": "", "time_s": time, "state_hash": "0", "sim_steps": 1, "planner_steps": 1, "clamped": 0,
            "fuel": null, "metrics": metrics,
        }))
        .unwrap()
    }

    fn row(end: End, outcome: &str, moved: &str, time: [f64; 2], roll: [f64; 2]) -> Row {
        let nominal = record(outcome, time[1], roll[1]);
        let ours = Ours { nominal, moved: vec![record(outcome, 1.0, 1.0), record(moved, 1.0, 1.0)] };
        Row { run: run(end, time[0], roll[0]), ours: vec![Some(ours), None, None] }
    }

    #[test]
    fn ratios_are_taken_over_tasks_that_both_complete() {
        let rows = [
            row(End::Success, "success", "success", [30.0, 33.0], [4.0, 3.0]),
            row(End::Success, "success", "stuck", [30.0, 27.0], [4.0, 3.0]),
            row(End::Success, "stuck", "success", [30.0, 99.0], [4.0, 99.0]),
            row(End::FellOffMap, "stuck", "stuck", [8.0, 99.0], [99.0, 99.0]),
        ];
        let table = aggregate(&rows, Mode::Physics);
        // Four tasks; same outcome but for the third, of which one start in three agrees. Times (33 + 27) / 60, roll 6 / 8,
        // pitch 2 / 4.
        let expected = "| rigid | mid | 4 | 3 | 3 | 4 | 3 | 2 | 1.00 | 0.75 | 0.50 |\n";
        assert!(table.ends_with(expected), "{table}");
        // Nothing was driven in the other modes.
        assert_eq!(aggregate(&rows, Mode::Planner).lines().count(), 2);
    }

    #[test]
    fn ends_are_counted_with_the_error_of_a_paired_difference_and_rollovers_of_failures_alone() {
        let mut rows: Vec<Row> = [
            row(End::Success, "success", "stuck", [30.0, 31.0], [4.0, 3.0]),
            row(End::Success, "stuck", "stuck", [30.0, 31.0], [4.0, 3.0]),
            row(End::Success, "stuck", "stuck", [30.0, 31.0], [4.0, 3.0]),
            row(End::Stuck, "success", "stuck", [30.0, 31.0], [4.0, 3.0]),
        ]
        .into();
        for (row, theirs, own) in [(0, 50.0, 50.0), (1, 50.0, -31.0), (2, 0.0, 29.0), (3, 60.0, 60.0)] {
            rows[row].run.roll_end = Some(theirs);
            let ours = rows[row].ours[0].as_mut().unwrap();
            ours.nominal.metrics.as_mut().unwrap().roll_end_deg = own;
        }
        // b = 2, c = 1, n = 4: −1 / sqrt(3 − 1/4) = −0.6.
        let expected = "| 4 | 3 | 2 | 2 | 1 | -0.6 | 1 (25 %) | 1 | 1 |\n";
        assert_eq!(ends(&rows).matches(expected).count(), 2, "{}", ends(&rows));
    }

    #[test]
    fn a_task_shows_how_both_ended_and_how_many_starts_arrive_where_that_depends_on_the_start() {
        let line = |row: Row| tasks(&[row], &Mode::ALL).lines().last().unwrap_or_default().to_owned();
        let same = line(row(End::Success, "success", "stuck", [30.0, 31.0], [4.0, 3.0]));
        assert_eq!(same, "| 8, 3 | rigid | mid | 30.0 s, 4.0°, 2.0° | 31.0 s, 3.0°, 1.0° (2 of 3) | – | – |");
        let other = line(row(End::Success, "out_of_bounds", "stuck", [30.0, 20.4], [4.0, 3.0]));
        let ours = "**≠** out of bounds after 20 s, 42 m short";
        assert_eq!(other, format!("| 8, 3 | rigid | mid | 30.0 s, 4.0°, 2.0° | {ours} | – | – |"));
        let fell = line(row(End::FellOffMap, "stuck", "stuck", [8.0, 20.0], [99.0, 3.0]));
        assert!(fell.contains("| fell off after 8 s, 62 m short | stuck after 20 s, 42 m short |"), "{fell}");
    }
}
