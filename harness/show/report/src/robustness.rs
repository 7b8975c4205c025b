//! How planners bear what they perceive: the same planner under several perception profiles.

use std::collections::BTreeMap;

use crate::compare::pair;
use crate::figures::Measure;
use crate::runs::{Runs, one_line, settings};
use crate::verdict::{Difference, decide};

/// The profile under which everything is known exactly. It comes first, and the others are held against it.
const EXACT: &str = "oracle";

/// A planner under one profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The run, an index into [`Runs::runs`].
    pub run: usize,
    /// The profile, an index into [`Robustness::profiles`].
    pub profile: usize,
    /// The difference of success from the planner's first profile, on the tasks that both runs have done; `None` for the
    /// first.
    pub difference: Option<Difference>,
}

/// A planner under its profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the planner is called: its name, with what it takes to tell it from the others.
    pub label: String,
    /// The planner under each profile, in the order of the profiles; two at least.
    pub points: Vec<Point>,
}

/// The planners of a report that were run under several perception profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Robustness {
    /// The names of the profiles: `oracle` first, the others as the runs come.
    pub profiles: Vec<String>,
    /// The planners, in the order of their first runs.
    pub lines: Vec<Line>,
}

impl Robustness {
    /// The robustness of the planners in `runs`; `None` if none was run under several profiles. Runs belong together if
    /// nothing but the perception profile differs: planner, version, file, parameters, vehicle, rules, seed and so on.
    #[must_use]
    pub fn new(runs: &Runs) -> Option<Self> {
        let mut groups: Vec<(BTreeMap<String, String>, Vec<usize>)> = Vec::new();
        for (k, run) in runs.runs.iter().enumerate() {
            let mut own = settings(&run.header);
            own.remove("perception");
            own.insert("planner".into(), run.header.plugin.name.clone());
            own.insert("sha256".into(), run.header.plugin.sha256.clone());
            match groups.iter_mut().find(|(settings, _)| *settings == own) {
                Some((_, members)) => members.push(k),
                None => groups.push((own, vec![k])),
            }
        }
        let profile = |run: usize| runs.runs[run].header.perception.name.as_str();
        let mut profiles: Vec<String> = Vec::new();
        for (_, members) in &groups {
            for name in members.iter().map(|k| one_line(profile(*k), 40)) {
                if !profiles.contains(&name) {
                    profiles.push(name);
                }
            }
        }
        profiles.sort_by_key(|name| name != EXACT);
        let place = |run: usize| profiles.iter().position(|p| *p == one_line(profile(run), 40)).unwrap_or(0);
        let mut lines = Vec::new();
        for (settings, mut members) in groups {
            members.sort_by_key(|run| (place(*run), *run));
            // The same once more says nothing new.
            members.dedup_by_key(|run| place(*run));
            let [first, _, ..] = members[..] else { continue };
            let point = |run: usize| Point {
                run,
                profile: place(run),
                difference: (run != first)
                    .then(|| pair(runs, first, run).differences.swap_remove(Measure::Success as usize)),
            };
            let points = members.iter().map(|run| point(*run)).collect();
            lines.push((settings, Line { label: String::new(), points }));
        }
        if lines.is_empty() {
            return None;
        }
        // One family: what is shown in one curve.
        let points = lines.iter_mut().flat_map(|(_, line)| &mut line.points);
        decide(points.filter_map(|p| p.difference.as_mut()).collect());
        let named = lines.iter().map(|(own, line)| Line { label: label(own, &lines), ..line.clone() });
        Some(Self { lines: named.collect(), profiles })
    }
}

/// The planner's name, with the settings in which it differs from a namesake.
fn label(own: &BTreeMap<String, String>, all: &[(BTreeMap<String, String>, Line)]) -> String {
    let name = own.get("planner").map_or("", String::as_str);
    let namesakes = || all.iter().map(|(s, _)| s).filter(|s| s.get("planner") == own.get("planner"));
    let told: Vec<String> = own
        .iter()
        .filter(|(key, value)| namesakes().any(|s| s.get(*key) != Some(*value)))
        .map(|(key, value)| format!("{key} {}", value.get(..24).unwrap_or(value)))
        .collect();
    let name = one_line(name, 60);
    if told.is_empty() { name } else { format!("{name} ({})", one_line(&told.join(", "), 80)) }
}
