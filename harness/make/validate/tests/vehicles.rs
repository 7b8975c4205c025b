//! The vehicles that come with the harness, as their files describe them and in the events of published figures.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::{Path, PathBuf};
use vb_validate::{Bench, Characteristics, References, RunOptions, run};
use vb_vehicle::VehicleSpec;

const NAMES: [&str; 13] = [
    "artcar",
    "feda",
    "gator",
    "hmmwv",
    "hmmwv-released",
    "husky",
    "jackal",
    "m113",
    "man10t",
    "man5t",
    "man7t",
    "verti4wheeler",
    "warthog",
];

fn tasks() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks")
}

fn load(name: &str) -> VehicleSpec {
    VehicleSpec::load(&tasks().join(format!("vehicles/{name}.yaml"))).unwrap()
}

fn characteristics(name: &str) -> Characteristics {
    Bench::new(&load(name), &[], 1e-3).unwrap().characteristics()
}

#[test]
fn vehicles_other_than_the_released_one_have_the_warnings_that_their_pages_explain_and_no_others() {
    // The M113 has the torsion bars of its model. The MAN 10t has no load on its rear springs, and two of its four axles bear what a
    // block takes from a third.
    let heavy: [(&str, &[&str]); 6] = [
        ("feda", &[]),
        ("gator", &[]),
        ("m113", &["ride frequency", "roll gradient"]),
        ("man10t", &["axle fourth has a ride frequency", "a wheel lifts"]),
        ("man5t", &[]),
        ("man7t", &[]),
    ];
    for (name, known) in heavy {
        for warning in characteristics(name).warnings() {
            assert!(known.iter().any(|k| warning.contains(k)), "{name}: {warning}");
        }
    }
    for name in ["artcar", "husky", "jackal", "verti4wheeler", "warthog"] {
        assert!(characteristics(name).warnings().is_empty(), "{name} is too light to be warned about");
    }
}

#[test]
fn every_vehicle_is_driven_through_the_events_of_published_figures_or_the_event_says_why_not() {
    for name in NAMES {
        let spec = load(name);
        let file = tasks().join(format!("validation/{name}.yaml"));
        let known =
            if file.exists() { References::load(&file, &spec).unwrap() } else { References::default() };
        let mut events: Vec<String> =
            ["data-sheet", "turning-circle", "side-slope"].map(str::to_owned).to_vec();
        let more = ["split-grip", "steady-circle", "turn-in-place", "skid-turning"];
        let fits = |name: &&str| vb_validate::event(name).unwrap().fits(&spec);
        events.extend(more.into_iter().filter(fits).map(str::to_owned));
        let report =
            run(&spec, &[], &known, &RunOptions { events, ..RunOptions::default() }, |_| {}).unwrap();
        for r in &report.results {
            assert_eq!(r.failure, None, "{name}, {}", r.event.name);
            assert!(!r.outcome.figures.is_empty(), "{name}, {}", r.event.name);
        }
    }
}
