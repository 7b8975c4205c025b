//! Running events, side by side.

use crate::bench::Bench;
use crate::check::{Check, Kind};
use crate::course::NamedCourse;
use crate::error::ValidateError;
use crate::event::{Event, LineKind, Outcome, Place};
use crate::events::{COURSES, event, events};
use crate::reference::References;
use crate::report::Report;
use crate::result::{EventResult, InSetup};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use vb_sim::{SimOptions, SoilSet};
use vb_vehicle::VehicleSpec;

#[derive(Clone, Debug, PartialEq)]
pub struct RunOptions {
    /// Names of events; empty for all.
    pub events: Vec<String>,
    /// The step, s.
    pub step: f64,
    /// Events run at a time.
    pub jobs: usize,
    /// A course that `ride-course` and `half-round` drive instead of their own. If no events are named, these alone are run.
    pub course: Option<NamedCourse>,
}

impl Default for RunOptions {
    /// All events at the step that the harness ships with, one after the other.
    fn default() -> Self {
        Self { events: Vec::new(), step: SimOptions::default().step, jobs: 1, course: None }
    }
}

/// Puts a vehicle through events, those on soil on the soils of `soils`. `finished` is told of each as it ends, in whatever order they do; the report has them
/// in the order of [`events`], and the same numbers for any number of jobs.
///
/// # Errors
/// [`ValidateError::UnknownEvent`], [`ValidateError::Step`], or [`ValidateError::Simulation`] for a vehicle that can't be
/// simulated at all. A simulation that fails within an event is a failure of that event.
pub fn run(
    spec: &VehicleSpec,
    soils: &[SoilSet],
    references: &References,
    options: &RunOptions,
    finished: impl Fn(&EventResult) + Sync,
) -> Result<Report, ValidateError> {
    if !(options.step >= 1e-5 && options.step <= 1e-2) {
        return Err(ValidateError::Step { step: options.step });
    }
    for name in &options.events {
        if !event(name)?.fits(spec) {
            let kind = event(name)?.vehicles.kind();
            let vehicle = spec.name.clone();
            return Err(ValidateError::NotForVehicle { name: name.clone(), kind, vehicle });
        }
    }
    let course = options.course.as_ref();
    let bench = Bench::new(spec, soils, options.step)?.on_course(course);
    let mut others = Vec::new();
    for (kind, setup) in &references.setups {
        let ready = |vehicle| Bench::new(vehicle, soils, options.step).map(|bench| bench.on_course(course));
        others.push((*kind, ready(&setup.ground)?, ready(&setup.soil)?));
    }
    let wanted: Vec<&'static Event> = events()
        .iter()
        .filter(|e| e.fits(spec))
        .filter(|e| match options.events.as_slice() {
            [] => course.is_none() || COURSES.contains(&e.name),
            named => named.iter().any(|n| n == e.name),
        })
        .collect();
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<(usize, EventResult)>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            // The events at the end of the list take longest: they go first.
            let Some(index) = wanted.len().checked_sub(k + 1) else { return };
            let result = drive(wanted[index], &bench, &others, references);
            finished(&result);
            vb_files::lock(&results).push((index, result));
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..options.jobs.clamp(1, wanted.len().max(1)) {
            scope.spawn(work);
        }
        work();
    });
    let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    results.sort_by_key(|r| r.0);
    let results = results.into_iter().map(|r| r.1).collect();
    let setups = references.setups.iter().map(|(kind, s)| (*kind, s.about.clone())).collect();
    Ok(Report { vehicle: spec.clone(), step: options.step, setups, results })
}

/// Drives an event with the vehicle as it is and in the set-ups of its references (a kind, the vehicle on rigid ground and on
/// soil), and judges it.
fn drive(
    event: &'static Event,
    bench: &Bench<'_>,
    others: &[(Kind, Bench<'_>, Bench<'_>)],
    references: &References,
) -> EventResult {
    let driven = |bench: &Bench<'_>| match event.run(bench) {
        Ok(outcome) => (outcome, None),
        Err(e) => (Outcome::default(), Some(e.to_string())),
    };
    let (mut outcome, failure) = driven(bench);
    let mut setups = Vec::new();
    for (kind, ground, soil) in others.iter().filter(|o| references.concern(event.name, o.0)) {
        let (outcome, failure) = driven(if event.place == Place::Soil { soil } else { ground });
        setups.push(InSetup { kind: *kind, outcome, failure });
    }
    let known = references.expectations.get(event.name).into_iter().flatten();
    let checks = known.map(|e| match setups.iter().find(|s| s.kind == e.kind) {
        Some(s) => Check::in_setup(e.clone(), &s.outcome.figures),
        None => Check::new(e.clone(), &outcome.figures),
    });
    let theory = outcome.theory.iter().map(|e| Check::new(e.clone(), &outcome.figures));
    let checks = theory.chain(checks).collect();
    draw(event, &mut outcome, &setups, references);
    EventResult { event, outcome, failure, setups, checks }
}

/// Draws the curves of references beside our lines, with our lines in the set-up of theirs.
fn draw(event: &Event, outcome: &mut Outcome, setups: &[InSetup], references: &References) {
    for curve in references.curves.iter().filter(|c| c.event == event.name) {
        let other = setups.iter().find(|s| s.kind == curve.kind);
        for plot in outcome.plots.iter_mut().filter(|p| curve.plots.contains(&p.title)) {
            let case = plot.lines.iter().find(|l| l.label == curve.beside).map_or(0, |l| l.case);
            let same = other.and_then(|s| s.outcome.plots.iter().find(|p| p.title == plot.title));
            if let Some(line) = same.and_then(|p| p.lines.iter().find(|l| l.label == curve.beside)) {
                let label = format!("{}, in {}", line.label, curve.kind.setup());
                plot.line(LineKind::Setup, case, label, line.points.clone());
            }
            let [from, to] = plot.span();
            let points = curve.points.iter().copied().filter(|p| p[0] >= from && p[0] <= to).collect();
            plot.line(LineKind::Reference, case, curve.label.clone(), points);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn hmmwv() -> VehicleSpec {
        VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv.yaml")
            .unwrap()
    }

    fn references() -> References {
        let text = include_str!("../../../../tasks/validation/hmmwv-released.yaml");
        References::parse(text, "hmmwv.yaml", &hmmwv()).unwrap()
    }

    fn only(events: &[&str]) -> RunOptions {
        RunOptions { events: events.iter().map(|e| (*e).to_owned()).collect(), ..RunOptions::default() }
    }

    #[test]
    fn checks_of_theory_come_before_those_of_the_references_and_curves_are_drawn_where_we_have_been() {
        let report = run(&hmmwv(), &[], &references(), &only(&["drop"]), |_| {}).unwrap();
        let result = &report.results[0];
        let kinds: Vec<Kind> = result.checks.iter().map(|c| c.expectation.kind).collect();
        assert!(
            kinds.is_sorted() && kinds.contains(&Kind::Theory) && kinds.contains(&Kind::Chrono),
            "{kinds:?}"
        );
        let plot = &result.outcome.plots[0];
        let [from, to] = plot.span();
        let curve = plot.lines.iter().find(|l| l.kind == LineKind::Reference).unwrap();
        assert!(curve.points.len() > 5 && curve.points.iter().all(|p| p[0] >= from && p[0] <= to));
        assert_eq!(curve.case, plot.lines[0].case, "one colour for one case");
    }

    #[test]
    fn references_of_a_kind_are_held_against_the_vehicle_in_their_set_up_and_theory_against_it_as_it_is() {
        let plain = References { setups: BTreeMap::new(), ..references() };
        let [as_it_is, both] = [plain, references()]
            .map(|r| run(&hmmwv(), &[], &r, &only(&["drop"]), |_| {}).unwrap().results.remove(0));
        assert!(as_it_is.setups.is_empty() && both.setups.len() == 1);
        assert_eq!(as_it_is.outcome.figures, both.outcome.figures, "the first drive knows of no set-up");
        let [own, other] = [&both.outcome, &both.setups[0].outcome];
        let name = "final reference height";
        assert!(own.value(name) != other.value(name), "the brush yields more than the rigid tyre");
        for (before, check) in as_it_is.checks.iter().zip(&both.checks) {
            let name = &check.expectation.figure;
            let theirs = check.expectation.kind == Kind::Chrono;
            assert_eq!(check.setup, theirs.then_some(Kind::Chrono), "{name}");
            assert_eq!(check.measured, if theirs { other } else { own }.value(name), "{name}");
            assert_eq!((before.setup, before.measured), (None, own.value(name)), "{name}");
        }
    }

    #[test]
    fn beside_a_reference_curve_is_our_line_in_its_set_up() {
        let report = run(&hmmwv(), &[], &references(), &only(&["drop"]), |_| {}).unwrap();
        let lines = &report.results[0].outcome.plots[0].lines;
        let of = |kind: LineKind| lines.iter().find(|l| l.kind == kind).unwrap();
        let [ours, setup] = [of(LineKind::Ours), of(LineKind::Setup)];
        assert_eq!(setup.label, format!("{}, in Chrono's set-up", ours.label));
        assert_eq!(setup.case, ours.case, "one colour for one case");
        assert!(setup.points != ours.points && setup.points.len() > 50);
    }

    #[test]
    fn results_and_page_and_files_tell_what_was_measured_in_a_set_up() {
        let report = run(&hmmwv(), &[], &references(), &only(&["drop", "free-fall"]), |_| {}).unwrap();
        let file: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        assert!(file["setups"]["chrono"].as_str().unwrap().starts_with("Rigid tyres"));
        let [drop, fall] = [&file["events"][0], &file["events"][1]];
        assert_eq!((&drop["event"], &fall["event"]), (&"drop".into(), &"free-fall".into()));
        assert!(fall.get("setups").is_none(), "nothing of Chrono's is held against it");
        assert_eq!(drop["setups"][0]["setup"], "chrono");
        let figures = drop["setups"][0]["figures"].as_array().unwrap();
        assert_eq!(figures.len(), drop["figures"].as_array().unwrap().len());
        for check in drop["checks"].as_array().unwrap() {
            let chrono = check["kind"] == "chrono";
            assert_eq!(check["setup"], if chrono { "chrono".into() } else { serde_json::Value::Null });
            if chrono {
                let same = figures.iter().find(|f| f["name"] == check["figure"]).unwrap();
                assert_eq!(check["measured"], same["value"], "{check}");
            }
        }
        let page = report.page();
        assert!(page.contains("<br><span class=\"tag\">in Chrono's set-up</span>"));
        assert!(page.contains("Measurements in Chrono's set-up without a reference"));
        assert!(page.contains("<polyline class=\"setup c0\""));
        let dir = std::env::temp_dir().join(format!("vb-validate-{}", std::process::id()));
        report.write(&dir).unwrap();
        let names: Vec<String> = std::fs::read_dir(dir.join("series"))
            .unwrap()
            .map(|f| f.unwrap().file_name().into_string().unwrap())
            .collect();
        std::fs::remove_dir_all(&dir).unwrap();
        let has = |name: &str| names.iter().any(|n| n == name);
        assert!(has("drop-drop.csv") && has("drop-drop-chrono.csv"), "{names:?}");
        assert!(has("free-fall-fall.csv") && !has("free-fall-fall-chrono.csv"), "{names:?}");
    }

    #[test]
    fn the_set_up_is_the_same_whatever_tyre_is_put_on() {
        let checks = |spec: &VehicleSpec| {
            let report = run(spec, &[], &references(), &only(&["static"]), |_| {}).unwrap();
            let of = |kind: Kind| -> Vec<Option<f64>> {
                let all = report.results[0].checks.iter();
                all.filter(|c| c.expectation.kind == kind).map(|c| c.measured).collect()
            };
            (of(Kind::Theory), of(Kind::Chrono))
        };
        let (rigid, brush) = (checks(&hmmwv()), checks(&hmmwv().with_tyre("brush").unwrap()));
        assert!(rigid.1 == brush.1 && !rigid.1.is_empty());
        assert!(rigid.0 != brush.0, "theory's are of the tyre that is on");
    }

    #[test]
    fn unknown_events_and_impossible_steps_are_refused() {
        let refused =
            |o: &RunOptions| run(&hmmwv(), &[], &References::default(), o, |_| {}).unwrap_err().to_string();
        assert!(refused(&only(&["flying"])).contains("unknown event flying"));
        for step in [0.0, f64::NAN, 0.02, 1e-6] {
            assert!(
                refused(&RunOptions { step, ..only(&["static"]) }).contains("between 0.01 and 10 ms"),
                "{step}"
            );
        }
    }

    #[test]
    fn without_its_soils_an_event_says_so_and_measures_nothing() {
        let report = run(&hmmwv(), &[], &References::default(), &only(&["soil-rest"]), |_| {}).unwrap();
        let outcome = &report.results[0].outcome;
        assert!(outcome.figures.is_empty() && outcome.notes[0].contains("soil set original is missing"));
        let report = run(&hmmwv(), &[], &references(), &only(&["soil-rest"]), |_| {}).unwrap();
        assert!(!report.passed(), "a reference that nothing is measured for fails");
    }
}
