//! A vehicle file with a number that no vehicle has is refused, or the vehicle drives or ends in an error: never in a panic.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use crate::common::{controls, flat, soil_world, soils};
use vb_math::rng::Stream;
use vb_sim::{SimOptions, Simulation};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

/// Vehicles whose files are changed: one of each kind of linkage, tyre and driveline, and the tracked one.
const VEHICLES: [(&str, &str); 4] = [
    ("m113", include_str!("../../../../../tasks/vehicles/m113.yaml")),
    ("hmmwv", include_str!("../../../../../tasks/vehicles/hmmwv.yaml")),
    ("man5t", include_str!("../../../../../tasks/vehicles/man5t.yaml")),
    ("gator", include_str!("../../../../../tasks/vehicles/gator.yaml")),
];

/// Mutations of each file.
const MUTATIONS: usize = 150;

/// Where numbers stand in the text, outside of comments.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or_default();
        let bytes = code.as_bytes();
        let mut at = 0;
        while at < bytes.len() {
            let begins = (bytes[at].is_ascii_digit()
                || bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit))
                && (at == 0 || matches!(bytes[at - 1], b' ' | b'['));
            let end = (at + 1..=bytes.len())
                .find(|e| {
                    bytes.get(*e).is_none_or(|b| !(b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'-')))
                })
                .unwrap_or(bytes.len());
            if begins && code[at..end].parse::<f64>().is_ok() {
                found.push((start + at, start + end));
                at = end;
            } else {
                at += 1;
            }
        }
        start += line.len();
    }
    found
}

/// A value in the place of another: beyond all sense, or off by some powers of ten.
fn instead(old: f64, rng: &mut Stream) -> String {
    let values = [
        "0".to_owned(),
        "1e300".to_owned(),
        "-1e300".to_owned(),
        "1e-300".to_owned(),
        "1e9".to_owned(),
        "-1e9".to_owned(),
        "1e-9".to_owned(),
        ".nan".to_owned(),
        ".inf".to_owned(),
        format!("{:e}", -old),
        format!("{:e}", old * 10.0),
        format!("{:e}", old * 1e3),
        format!("{:e}", old * 1e6),
        format!("{:e}", old * 1e-3),
        format!("{:e}", old * 1e-6),
    ];
    values[rng.below(values.len() as u64) as usize].clone()
}

/// What becomes of a vehicle file: an error that names it, or half a second of driving.
fn outcome(text: &str, world: &Arc<World>) -> Result<(), String> {
    let spec = VehicleSpec::parse(text, "mutant.yaml").map_err(|e| e.to_string())?;
    let model = VehicleModel::new(spec).map_err(|e| e.to_string())?;
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.3 };
    let mut sim = Simulation::new(world.clone(), &model, &soils(), start, SimOptions::default())
        .map_err(|e| e.to_string())?;
    sim.advance(controls(0.7, 1.0, 0.0), 250).map_err(|e| e.to_string())?;
    sim.advance(controls(-0.7, 0.0, 1.0), 250).map_err(|e| e.to_string())
}

#[test]
fn no_number_in_a_vehicle_file_ends_in_a_panic() {
    let worlds = [flat(0.8), soil_world(Heightfield::flat(65, 65, 1.0, 0.0), TerrainClass::Mud)];
    let (mut panics, mut refused, mut slow) = (Vec::new(), 0, Vec::new());
    for (name, text) in VEHICLES {
        let mut rng = Stream::new(2025, &["mutations", name]);
        let places = numbers(text);
        assert!(places.len() > 100, "{name}: {}", places.len());
        for _ in 0..MUTATIONS {
            let (from, to) = places[rng.below(places.len() as u64) as usize];
            let value = instead(text[from..to].parse().expect("a number"), &mut rng);
            let mutant = format!("{}{value}{}", &text[..from], &text[to..]);
            let world = &worlds[rng.below(2) as usize];
            #[allow(clippy::disallowed_methods, reason = "for the message only")]
            let began = std::time::Instant::now();
            let ended = catch_unwind(AssertUnwindSafe(|| outcome(&mutant, world)));
            let line = text[..from].lines().count();
            match ended {
                Err(_) => panics.push(format!("{name}, line {line}: {} -> {value}", &text[from..to])),
                Ok(Err(message)) => {
                    assert!(!message.contains('\n'), "{message}");
                    refused += 1;
                }
                Ok(Ok(())) => {}
            }
            if began.elapsed() > Duration::from_secs(20) {
                slow.push(format!("{name}, line {line}: {value}: {:?}", began.elapsed()));
            }
        }
    }
    assert!(panics.is_empty(), "{} panics:\n{}", panics.len(), panics.join("\n"));
    assert!(slow.is_empty(), "{slow:?}");
    assert!(refused > VEHICLES.len() * MUTATIONS / 4, "only {refused} are refused: the test tests nothing");
}
