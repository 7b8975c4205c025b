//! Figures and comparison for programs.

use serde_json::{Map, Value, json};
use vb_score::{Cause, Conditions, Flag, Outcome, Ride};

use crate::Report;
use crate::figures::{Estimate, Figures, Measure};
use crate::ranking::Place;
use crate::verdict::{Difference, LEVEL, Verdict};

/// The name of a measure, with its unit.
fn key(measure: Measure) -> &'static str {
    match measure {
        Measure::Success => "success_rate",
        Measure::Time => "time_s",
        Measure::Roll => "roll_deg",
        Measure::Pitch => "pitch_deg",
    }
}

fn estimate(e: Estimate) -> Value {
    json!({"mean": e.mean, "low": e.interval.map(|i| i.low), "high": e.interval.map(|i| i.high)})
}

fn figures(f: &Figures) -> Value {
    let outcomes: Map<String, Value> =
        Outcome::ALL.iter().map(|o| (o.name().to_owned(), json!(f.count(*o)))).collect();
    let causes = Cause::ALL.iter().map(|c| (c.name().to_owned(), json!(f.caused(*c))));
    let causes: Map<String, Value> = causes.filter(|(_, n)| *n != 0).collect();
    let flags = Flag::ALL.iter().filter_map(|flag| Some((flag.name().to_owned(), json!(f.flagged(*flag)?))));
    let ride =
        Ride::MEASURES.iter().zip(f.ride).filter_map(|(m, mean)| Some((m.name.to_owned(), json!(mean?))));
    let mut all = Map::from_iter([
        ("tasks".to_owned(), json!(f.tasks)),
        ("worlds".to_owned(), json!(f.worlds)),
        ("outcomes".to_owned(), Value::Object(outcomes)),
        ("flags".to_owned(), Value::Object(flags.collect())),
        ("ride".to_owned(), Value::Object(ride.collect())),
        ("causes".to_owned(), Value::Object(causes)),
    ]);
    all.extend(Measure::ALL.map(|m| (key(m).to_owned(), f.mean(m).map_or(Value::Null, estimate))));
    Value::Object(all)
}

fn difference(d: &Difference) -> Value {
    d.difference.map_or(Value::Null, |e| {
        let mut all = estimate(e);
        all["tasks"] = json!(d.tasks);
        all["worlds"] = json!(d.worlds);
        all["p"] = json!(d.p);
        all["p_adjusted"] = json!(d.adjusted);
        all["verdict"] = json!(d.verdict.map(Verdict::name));
        all["worlds_needed"] = match d.verdict {
            Some(Verdict::TooFewWorlds { needed }) => json!(needed),
            _ => Value::Null,
        };
        let secondary = if d.measure == Measure::Success { "p_mcnemar" } else { "p_wilcoxon" };
        all[secondary] = json!(d.secondary);
        all
    })
}

/// A run's place, with runs by their index as in `pairs`.
fn place(p: &Place) -> Value {
    json!({"run": p.run, "rank": p.rank, "rank_last": p.last, "ties": p.ties})
}

impl Report {
    /// All figures and the comparison as JSON: `runs`, `pairs`, `ranking`, `unranked` and `headline` (docs/reports.md).
    #[must_use]
    pub fn statistics(&self) -> Value {
        let runs: Vec<Value> = self
            .runs
            .runs
            .iter()
            .zip(&self.figures)
            .map(|(run, f)| {
                let mut all = json!({
                    "label": run.label, "path": run.dir.display().to_string(), "missing": run.missing(),
                    "host_errors": run.host_errors(),
                    "departures": Conditions::of(&run.header).departures(), "all": figures(&f.all),
                });
                for (name, levels) in ["elevation", "terrain", "density"].into_iter().zip(&f.splits) {
                    // In the order of Split::ALL; levels without tasks are left out.
                    let levels: Map<String, Value> = levels
                        .iter()
                        .filter(|(_, f)| f.tasks > 0)
                        .map(|(level, f)| ((*level).to_owned(), figures(f)))
                        .collect();
                    all[name] = Value::Object(levels);
                }
                all
            })
            .collect();
        let pairs: Vec<Value> = self.comparison.iter().flat_map(|c| &c.pairs).map(|p| {
            let differences: Map<String, Value> =
                p.differences.iter().map(|d| (key(d.measure).to_owned(), difference(d))).collect();
            json!({"first": p.a, "second": p.b, "common": p.common, "both": p.both, "only_first": p.only_a,
                   "only_second": p.only_b, "differences": differences})
        }).collect();
        let ranking: Vec<Value> =
            self.ranking().iter().flat_map(|ranking| &ranking.places).map(place).collect();
        json!({"level": 1.0 - LEVEL, "runs": runs, "pairs": pairs, "ranking": ranking, "unranked": self.unranked,
            "headline": self.headline()})
    }
}
