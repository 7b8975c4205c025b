//! The same figures at other steps.

use super::{cornering, grades, longitudinal, vertical};
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Bench, Event, Outcome, Plot, Series};
use vb_sim::SimError;

pub(super) const CONVERGENCE: Event = Event {
    name: "convergence",
    title: "Convergence over the step",
    about: "Canonical figures at a quarter of the step, at half, at the step, at twice and at four times it. At the step and at \
            half of it they must agree within 2 %.",
    run: convergence,
};

/// Events and their figures that are canonical, with a name short enough for a legend.
const CANONICAL: [(&Event, &str, &str); 8] = [
    (&longitudinal::ACCELERATION, "throttle 1.0, μ 0.9: time to 10 m/s", "0–10 m/s"),
    (&longitudinal::BRAKING, "15 m/s, brake 1, μ 0.9: distance", "braking distance"),
    (&longitudinal::BRAKING, "15 m/s, brake 0.25, μ 0.9: distance", "gentle braking"),
    (&cornering::CORNERING, "steering 0.5, 4 m/s, μ 0.9: radius", "radius"),
    (&grades::GRADE_PUBLISHED, "speed after 15 s", "speed on 60 %"),
    (&vertical::BUMP, "2 m, 5 m/s: highest acceleration", "bump, acceleration"),
    (&vertical::BUMP, "2 m, 5 m/s: highest pitch", "bump, pitch"),
    (&vertical::DROP, "lowest reference height", "drop, lowest height"),
];
const FACTORS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

fn convergence(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut rows = Vec::new();
    for factor in FACTORS {
        let at = bench.at_step(factor * bench.options.step);
        let mut row = vec![at.options.step];
        let mut last: Option<(&str, Result<Outcome, SimError>)> = None;
        for (event, figure, _) in CANONICAL {
            if last.as_ref().is_none_or(|l| l.0 != event.name) {
                last = Some((event.name, event.run(&at)));
            }
            // A step too coarse to run at all has no figures.
            let value = last.as_ref().and_then(|l| l.1.as_ref().ok()).and_then(|r| r.value(figure));
            row.push(value.unwrap_or(f64::NAN));
        }
        rows.push(row);
    }
    let mut plot = Plot::new("Deviation from the finest step", "step, ms", "deviation, %");
    for (k, (_, _, short)) in CANONICAL.iter().enumerate() {
        let value = |row: usize| rows[row][k + 1];
        let change = 100.0 * (value(2) / value(1) - 1.0).abs();
        let name = format!("{short}: change from half the step");
        o.figure(name.clone(), change, "%");
        o.theory.push(Expectation {
            figure: name,
            expected: Expected::AtMost(2.0),
            kind: Kind::Convergence,
            source: format!("the same event at {} ms", 0.5e3 * bench.options.step),
            unsound: None,
        });
        plot.ours(*short, rows.iter().map(|r| [1e3 * r[0], 100.0 * (r[k + 1] / value(0) - 1.0)]).collect());
    }
    let mut columns = vec![("step".to_owned(), "s")];
    columns.extend(CANONICAL.iter().map(|c| (c.2.to_owned(), "")));
    o.series.push(Series { name: "steps".to_owned(), columns, rows });
    o.plots.push(plot);
    Ok(o)
}
