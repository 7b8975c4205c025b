//! What a planner sent to be looked at, by the names of its series.
//!
//! A series named `NAME.xy` or `NAME.xyz` is lines in the world frame: x0, y0, x1, y1, … in metres, lines parted by a point
//! that is no number; a line of one point is a place. `NAME.cost` gives each of these lines a cost; without a parting point, as
//! many costs as there are lines of equal length part them. `trajectories`, `trajectory_costs` and `local_goal` are the names that
//! the planners of this repository use for such lines, their costs and a place. Any other series is a curve over time; of
//! several values at a time the least is shown.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use vb_record::DebugEntry;

/// Numbers of all series that are shown; of more, every second step is left out until they fit.
const VALUES: usize = 400_000;
/// Points of a curve at most.
const POINTS: usize = 4_000;
/// Curves at most.
const CURVES: usize = 12;

/// A point of a line: x, y and, if the planner gave it, z, m.
pub(crate) type Point = (f64, f64, Option<f64>);

/// What a series is, by its name.
enum Role<'a> {
    /// Lines of points of so many coordinates.
    Lines(&'a str, usize),
    /// Costs of the lines of this name.
    Costs(&'a str),
    Curve,
}

fn role(name: &str) -> Role<'_> {
    match name {
        "trajectories" | "local_goal" => Role::Lines(name, 2),
        "trajectory_costs" => Role::Costs("trajectories"),
        _ => match (name.strip_suffix(".xy"), name.strip_suffix(".xyz"), name.strip_suffix(".cost")) {
            (Some(of), _, _) => Role::Lines(of, 2),
            (_, Some(of), _) => Role::Lines(of, 3),
            (_, _, Some(of)) => Role::Costs(of),
            _ => Role::Curve,
        },
    }
}

/// Lines that a planner sent at one time.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    /// Name of the series without its ending.
    pub(crate) name: &'a str,
    /// s.
    pub(crate) time: f64,
    /// The points of each line, at least one.
    pub(crate) lines: Vec<Vec<Point>>,
    /// A cost a line; of fewer costs than lines, the first lines have them.
    pub(crate) costs: Option<&'a [f32]>,
}

/// The lines that these coordinates make.
fn part(values: &[f32], dimensions: usize, costs: Option<&[f32]>) -> Vec<Vec<Point>> {
    let points = values.chunks_exact(dimensions);
    let count = points.len();
    let whole = values.iter().all(|v| v.is_finite());
    let each =
        costs.map(<[f32]>::len).filter(|n| whole && *n > 1 && count.is_multiple_of(*n)).map(|n| count / n);
    let mut all: Vec<Vec<Point>> = vec![Vec::new()];
    for p in points {
        let full = each.is_some_and(|n| all.last().is_some_and(|l| l.len() == n));
        let parted = p.iter().any(|v| !v.is_finite());
        if full || parted {
            all.push(Vec::new());
        }
        if let Some(line) = all.last_mut().filter(|_| !parted) {
            line.push((p[0].into(), p[1].into(), p.get(2).map(|z| f64::from(*z))));
        }
    }
    all.retain(|l| !l.is_empty());
    all
}

/// The series of one trial.
#[derive(Clone, Debug, Default)]
pub struct PlannerSeries {
    entries: Vec<DebugEntry>,
    /// Each how many steps of the planner are shown.
    stride: usize,
}

impl PlannerSeries {
    /// Series in the order of time.
    #[must_use]
    pub fn new(entries: Vec<DebugEntry>) -> Self {
        let mut times: Vec<f64> = entries.iter().map(|e| e.time).collect();
        times.dedup();
        let size = |stride: usize| -> usize {
            let kept = |e: &&DebugEntry| {
                times.binary_search_by(|t| t.total_cmp(&e.time)).is_ok_and(|k| k.is_multiple_of(stride))
            };
            entries.iter().filter(kept).map(|e| e.values.len()).sum()
        };
        let mut stride = 1;
        while size(stride) > VALUES && stride < times.len() {
            stride *= 2;
        }
        let kept: Vec<DebugEntry> = if stride == 1 {
            entries
        } else {
            let at = |e: &DebugEntry| times.binary_search_by(|t| t.total_cmp(&e.time));
            entries.into_iter().filter(|e| at(e).is_ok_and(|k| k.is_multiple_of(stride))).collect()
        };
        Self { entries: kept, stride }
    }

    pub(crate) fn lines(&self) -> Vec<Lines<'_>> {
        let mut costs: BTreeMap<(u64, &str), &[f32]> = BTreeMap::new();
        for e in &self.entries {
            if let Role::Costs(of) = role(&e.name) {
                costs.insert((e.time.to_bits(), of), &e.values);
            }
        }
        let of = |e: &'_ DebugEntry| match role(&e.name) {
            Role::Lines(name, dimensions) => Some((name.len(), dimensions)),
            _ => None,
        };
        self.entries
            .iter()
            .filter_map(|e| {
                let (length, dimensions) = of(e)?;
                let name = &e.name[..length];
                let costs = costs.get(&(e.time.to_bits(), name)).copied();
                let lines = part(&e.values, dimensions, costs);
                // Many entries of a name may share its costs: each has but those of its own lines.
                let costs = costs.map(|all| &all[..all.len().min(lines.len())]);
                Some(Lines { name, time: e.time, lines, costs })
            })
            .collect()
    }

    /// Curves over time by name: (time, value).
    pub(crate) fn curves(&self) -> BTreeMap<&str, Vec<[f64; 2]>> {
        let mut curves: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
        for e in self.entries.iter().filter(|e| !matches!(role(&e.name), Role::Lines(..))) {
            let least = e.values.iter().copied().filter(|v| v.is_finite()).fold(f32::INFINITY, f32::min);
            if least.is_finite() && (curves.len() < CURVES || curves.contains_key(&*e.name)) {
                curves.entry(&e.name).or_default().push([e.time, f64::from(least)]);
            }
        }
        for points in curves.values_mut() {
            let step = points.len().div_ceil(POINTS).max(1);
            *points = points.iter().copied().step_by(step).collect();
        }
        curves
    }

    pub(crate) fn json(&self) -> Value {
        let round = |v: f64| (v * 1000.0).round() / 1000.0;
        let mut lines: BTreeMap<&str, Vec<Value>> = BTreeMap::new();
        for l in self.lines() {
            let each: Vec<Vec<f64>> = l
                .lines
                .iter()
                .map(|line| {
                    // Three numbers a point; without a height it is null.
                    line.iter()
                        .flat_map(|&(x, y, z)| [round(x), round(y), z.map_or(f64::NAN, round)])
                        .collect()
                })
                .collect();
            let costs: Option<Vec<f64>> = l.costs.map(|c| c.iter().map(|v| f64::from(*v)).collect());
            lines.entry(l.name).or_default().push(json!([round(l.time), each, costs]));
        }
        json!({"lines": lines, "curves": self.curves(), "stride": self.stride})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(time: f64, name: &str, values: &[f32]) -> DebugEntry {
        DebugEntry { time, name: name.into(), values: values.to_vec() }
    }

    #[test]
    fn series_are_lines_costs_or_curves_by_their_names() {
        let s = PlannerSeries::new(vec![
            entry(0.0, "plan.xy", &[0.0, 1.0, 2.0, 3.0, f32::NAN, f32::NAN, 4.0, 5.0]),
            entry(0.0, "plan.cost", &[2.0, 1.0]),
            entry(0.1, "error", &[0.5]),
        ]);
        let lines = s.lines();
        assert_eq!(lines.len(), 1);
        assert_eq!((lines[0].name, lines[0].costs), ("plan", Some(&[2.0, 1.0][..])));
        assert_eq!(lines[0].lines, [vec![(0.0, 1.0, None), (2.0, 3.0, None)], vec![(4.0, 5.0, None)]]);
        let curves = s.curves();
        assert_eq!(curves["plan.cost"], [[0.0, 1.0]], "of several values the least");
        assert_eq!(curves["error"], [[0.1, 0.5]]);
        let json = s.json().to_string();
        assert!(json.contains("null") && !json.contains("NaN"), "{json}");
    }

    #[test]
    fn as_many_costs_as_lines_of_equal_length_part_them() {
        let s = PlannerSeries::new(vec![
            entry(0.0, "trajectories", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
            entry(0.0, "trajectory_costs", &[3.0, 4.0]),
            entry(0.0, "local_goal", &[7.0, 8.0]),
        ]);
        let lines = s.lines();
        assert_eq!(
            lines[0].lines,
            [[(0.0, 0.0, None), (1.0, 0.0, None)], [(0.0, 0.0, None), (0.0, 1.0, None)]]
        );
        assert_eq!((lines[1].name, &lines[1].lines[..]), ("local_goal", &[vec![(7.0, 8.0, None)]][..]));
        assert_eq!(s.curves().keys().collect::<Vec<_>>(), [&"trajectory_costs"]);
    }

    #[test]
    fn what_a_planner_sends_without_measure_is_thinned() {
        let many = (0..1000).map(|k| entry(f64::from(k) * 0.1, "c.xy", &[0.0; 2000])).collect();
        let s = PlannerSeries::new(many);
        assert!(s.entries.iter().map(|e| e.values.len()).sum::<usize>() <= VALUES);
        assert_eq!((s.stride, s.entries.len()), (8, 125));
    }

    #[test]
    fn costs_are_not_repeated_for_every_entry_of_a_name() {
        let mut entries: Vec<DebugEntry> = (0..1000).map(|_| entry(0.0, "a.xy", &[1.0, 2.0])).collect();
        entries.push(entry(0.0, "a.cost", &[0.5; 1000]));
        let series = PlannerSeries::new(entries);
        let lines = series.lines();
        assert_eq!(lines.len(), 1000);
        assert_eq!(lines.iter().map(|l| l.costs.map_or(0, <[f32]>::len)).sum::<usize>(), 1000);
        assert!(series.json().to_string().len() < 100_000);
    }
}
