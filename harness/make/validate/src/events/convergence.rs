//! The same figures at other steps.

use super::{cornering, grades, longitudinal, vertical};
use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Event, Outcome, Place, Plot, Series, Vehicles};
use vb_sim::SimError;

pub(super) const CONVERGENCE: Event = Event {
    name: "convergence",
    title: "Convergence over the step",
    about: "Canonical measurements at a quarter of the time step, half of it, the step itself, twice and four times the step. At the step and at \
            half of it they must agree within 2 %.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: convergence,
};

/// Names of the canonical figures, in the order of [`figures`].
const NAMES: [&str; 8] = [
    "0–10 m/s",
    "braking distance",
    "gentle braking",
    "radius",
    "speed on 60 %",
    "bump, acceleration",
    "bump, pitch",
    "drop, lowest height",
];
const FACTORS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// The canonical figures, each in its own unit.
fn figures(bench: &Bench<'_>) -> Result<[f64; 8], SimError> {
    let [acceleration, pitch] = vertical::bump_peaks(bench)?;
    Ok([
        longitudinal::time_to_10(bench)?,
        longitudinal::braking_distance(bench, 1.0)?,
        longitudinal::braking_distance(bench, 0.25)?,
        cornering::radius(bench, 0.5)?,
        of(&grades::GRADE_PUBLISHED, bench, "speed after 15 s")?,
        acceleration,
        pitch,
        of(&vertical::DROP, bench, "lowest reference height")?,
    ])
}

fn of(event: &Event, bench: &Bench<'_>, figure: &str) -> Result<f64, SimError> {
    Ok(event.run(bench)?.value(figure).unwrap_or(f64::NAN))
}

fn convergence(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut rows = Vec::new();
    for factor in FACTORS {
        let at = bench.at_step(factor * bench.options.step);
        let mut row = vec![at.options.step];
        // A step too coarse to run at all has no figures.
        row.extend(figures(&at).unwrap_or([f64::NAN; 8]));
        rows.push(row);
    }
    let mut plot = Plot::new("Deviation from the finest step", "step, ms", "deviation, %");
    for (k, short) in NAMES.into_iter().enumerate() {
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
        plot.ours(short, rows.iter().map(|r| [1e3 * r[0], 100.0 * (r[k + 1] / value(0) - 1.0)]).collect());
    }
    let mut columns = vec![("step".to_owned(), "s")];
    columns.extend(NAMES.map(|n| (n.to_owned(), "")));
    o.series.push(Series { name: "steps".to_owned(), columns, rows });
    o.plots.push(plot);
    Ok(o)
}
