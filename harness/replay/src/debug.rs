//! What a planner sent to be looked at, by the names of its series.
//!
//! A series named `NAME.xy` or `NAME.xyz` is lines in the world frame: x0, y0, x1, y1, … in metres, lines parted by a point
//! that is no number. `NAME.cost` gives each of these lines a cost. Any other series is a curve over time; of several values
//! at a time the least is shown.

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

/// Lines that a planner sent at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines<'a> {
    /// Name of the series without its ending.
    pub(crate) name: &'a str,
    /// 2 or 3.
    pub(crate) dimensions: usize,
    /// s.
    pub(crate) time: f64,
    /// Coordinates, m; points that are no number part the lines.
    pub(crate) values: &'a [f32],
    /// A cost a line.
    pub(crate) costs: Option<&'a [f32]>,
}

impl Lines<'_> {
    /// The points of each line: x, y and, if there is one, z.
    pub(crate) fn each(&self) -> Vec<Vec<Point>> {
        let mut all = vec![Vec::new()];
        for p in self.values.chunks_exact(self.dimensions) {
            if p.iter().any(|v| !v.is_finite()) {
                all.push(Vec::new());
            } else if let Some(line) = all.last_mut() {
                line.push((p[0].into(), p[1].into(), p.get(2).map(|z| f64::from(*z))));
            }
        }
        all.retain(|l| l.len() > 1);
        all
    }
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

    /// The lines at each time: (name, dimensions, time, values, costs).
    pub(crate) fn lines(&self) -> Vec<Lines<'_>> {
        let costs: BTreeMap<(u64, &str), &[f32]> = self
            .entries
            .iter()
            .filter_map(|e| Some(((e.time.to_bits(), e.name.strip_suffix(".cost")?), e.values.as_slice())))
            .collect();
        let of = |e: &'_ DebugEntry| match (e.name.strip_suffix(".xy"), e.name.strip_suffix(".xyz")) {
            (Some(name), _) => Some((name.len(), 2)),
            (_, Some(name)) => Some((name.len(), 3)),
            _ => None,
        };
        self.entries
            .iter()
            .filter_map(|e| {
                let (length, dimensions) = of(e)?;
                let name = &e.name[..length];
                let costs = costs.get(&(e.time.to_bits(), name)).copied();
                Some(Lines { name, dimensions, time: e.time, values: &e.values, costs })
            })
            .collect()
    }

    /// Curves over time by name: (time, value).
    pub(crate) fn curves(&self) -> BTreeMap<&str, Vec<[f64; 2]>> {
        let mut curves: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
        for e in self.entries.iter().filter(|e| !e.name.ends_with(".xy") && !e.name.ends_with(".xyz")) {
            let least = e.values.iter().copied().filter(|v| v.is_finite()).fold(f32::INFINITY, f32::min);
            if least.is_finite() && (curves.len() < CURVES || curves.contains_key(e.name.as_str())) {
                curves.entry(&e.name).or_default().push([e.time, f64::from(least)]);
            }
        }
        for points in curves.values_mut() {
            let step = points.len().div_ceil(POINTS).max(1);
            *points = points.iter().copied().step_by(step).collect();
        }
        curves
    }

    /// For the page.
    pub(crate) fn json(&self) -> Value {
        let round = |v: f64| (v * 1000.0).round() / 1000.0;
        // JSON has no NaN: a point that is none is null.
        let values = |v: &[f32]| -> Vec<Option<f64>> {
            v.iter().map(|x| x.is_finite().then(|| round(f64::from(*x)))).collect()
        };
        let mut lines: BTreeMap<&str, Vec<Value>> = BTreeMap::new();
        for l in self.lines() {
            let step = json!([round(l.time), l.dimensions, values(l.values), l.costs.map(values)]);
            lines.entry(l.name).or_default().push(step);
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
        let each = lines[0].each();
        assert_eq!(each, [vec![(0.0, 1.0, None), (2.0, 3.0, None)]], "a point is no line");
        let curves = s.curves();
        assert_eq!(curves["plan.cost"], [[0.0, 1.0]], "of several values the least");
        assert_eq!(curves["error"], [[0.1, 0.5]]);
        let json = s.json().to_string();
        assert!(json.contains("null") && !json.contains("NaN"), "{json}");
    }

    #[test]
    fn what_a_planner_sends_without_measure_is_thinned() {
        let many = (0..1000).map(|k| entry(f64::from(k) * 0.1, "c.xy", &[0.0; 2000])).collect();
        let s = PlannerSeries::new(many);
        assert!(s.entries.iter().map(|e| e.values.len()).sum::<usize>() <= VALUES);
        assert_eq!((s.stride, s.entries.len()), (8, 125));
    }
}
