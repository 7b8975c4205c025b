//! What simulating costs: processor time a simulated second.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use vb_world::Terrain;

use crate::reference::{GROUNDS, Run};

/// Processor time and simulated time, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    pub(crate) processor: f64,
    pub(crate) simulated: f64,
}

impl Cost {
    pub(crate) fn add(&mut self, other: Self) {
        self.processor += other.processor;
        self.simulated += other.simulated;
    }

    fn rate(self) -> Option<f64> {
        (self.simulated > 0.0 && self.processor > 0.0).then(|| self.processor / self.simulated)
    }
}

/// Chrono's cost by ground over the runs of a table, which were made without pairs of fixed bodies.
///
/// Rocks rest in the ground as fixed bodies. In the recorded set-up Chrono looks for contacts between them and the ground
/// at every step and throws them away, since neither can move; without these pairs its results are the same.
pub(crate) fn without_fixed_pairs(runs: &[Run]) -> BTreeMap<Terrain, Cost> {
    let mut costs: BTreeMap<Terrain, Cost> = BTreeMap::new();
    for run in runs {
        let cost = Cost { processor: run.cost * run.time, simulated: run.time };
        costs.entry(run.terrain).or_default().add(cost);
    }
    costs
}

/// Chrono's cost and ours by ground, as Markdown: Chrono's as recorded, and without pairs of fixed bodies (`lean`) where
/// that is known, each with its ratio to ours.
pub(crate) fn table(runs: &[&Run], lean: &BTreeMap<Terrain, Cost>, ours: &BTreeMap<Terrain, Cost>) -> String {
    let mut out = String::from(
        "| ground | Chrono as set up | without pairs of fixed bodies | here | ratio as set up | without those pairs |\n\
         |---|---|---|---|---|---|\n",
    );
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    for terrain in GROUNDS {
        let mut theirs = Cost::default();
        for run in runs.iter().filter(|r| r.terrain == terrain) {
            theirs.add(Cost { processor: run.cost * run.time, simulated: run.time });
        }
        let Some(set_up) = theirs.rate() else { continue };
        let lean = lean.get(&terrain).and_then(|c| c.rate());
        let here = ours.get(&terrain).and_then(|c| c.rate());
        let ratio = |chrono: Option<f64>| or_dash(chrono.zip(here).map(|(c, h)| format!("{:.0}", c / h)));
        let _ = writeln!(
            out,
            "| {} | {:.0} ms | {} | {} | {} | {} |",
            terrain.name(),
            1e3 * set_up,
            or_dash(lean.map(|v| format!("{:.0} ms", 1e3 * v))),
            or_dash(here.map(|v| format!("{:.1} ms", 1e3 * v))),
            ratio(Some(set_up)),
            ratio(lean),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::End;
    use vb_world::Elevation;

    #[test]
    fn costs_are_weighed_by_simulated_time_and_a_ground_without_ours_has_no_ratio() {
        let run = |terrain, time, cost| Run {
            world: 1,
            pair: 0,
            elevation: Elevation::Low,
            terrain,
            end: End::Success,
            time,
            roll: 1.0,
            pitch: 1.0,
            goal_distance: 8.0,
            roll_end: None,
            cost,
        };
        let runs =
            [run(Terrain::Rigid, 30.0, 0.4), run(Terrain::Rigid, 10.0, 0.8), run(Terrain::Mixed, 9.0, 0.5)];
        let ours = BTreeMap::from([(Terrain::Rigid, Cost { processor: 2.0, simulated: 400.0 })]);
        let lean = without_fixed_pairs(&[
            run(Terrain::Rigid, 30.0, 0.05),
            run(Terrain::Rigid, 20.0, 0.075),
            run(Terrain::Mixed, 20.0, 0.08),
        ]);
        // (30 · 0.4 + 10 · 0.8) / 40 = 0.5 s, and (30 · 0.05 + 20 · 0.075) / 50 = 0.06 s, over 2 / 400 = 0.005 s.
        let told = table(&runs.each_ref(), &lean, &ours);
        let rows = "| rigid | 500 ms | 60 ms | 5.0 ms | 100 | 12 |\n| mixed | 500 ms | 80 ms | – | – | – |\n";
        assert!(told.ends_with(rows), "{told}");
        // Without such measurements the table stays, with dashes.
        let told = table(&runs.each_ref(), &BTreeMap::new(), &ours);
        assert!(told.contains("| rigid | 500 ms | – | 5.0 ms | 100 | – |\n"), "{told}");
    }
}
