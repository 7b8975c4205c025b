//! Frames of drives on ground where they are known beforehand.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod common;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use common::{header, named, suite};
use vb_dataset::{
    Amount, Dataset, DatasetWriter, Ending, Episode, EpisodeInfo, Exploration, Feature, Header, Layout,
    Making,
};
use vb_math::{cos, sin};
use vb_score::{Outcome, Rules};
use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_trial::Setting;
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::TerrainClass;

/// Straight ahead at 3 m/s.
const STRAIGHT: &str = "
schema: 1
name: straight
steering: {amplitude: [0, 0], frequency_hz: [0.1, 0.1], offset: [0, 0], hold_s: [60, 60]}
speed: {range_m_per_s: [3, 3], hold_s: [60, 60]}
start: {tilt_deg: 20, clearance_m: 1, edge_m: 40}
";

fn explored(dir: &Path, crops: usize, profile: &Profile) -> Dataset {
    let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
    let vehicle = Vehicle { spec: VehicleSpec::parse(text, "hmmwv.yaml").unwrap(), hash: String::new() };
    let soils = Soils { set: SoilSet::default(), hash: String::new(), resolution: 0.1 };
    let rules = Rules::resolve("exploration").unwrap();
    let setting = Setting::new(&vehicle, &soils, &rules, profile, 0.001, 1.0, 1).unwrap();
    let suite = suite(&dir.join("suite"));
    let exploration = Exploration::parse(STRAIGHT, "straight.yaml").unwrap();
    let layout = Layout { wheels: 4, speed: true, goal: false, truth: !profile.tells_the_truth(), crops };
    let header = Header {
        perception: named(profile.name()),
        exploration: Some(exploration.clone()),
        ..header("straight", layout, &suite)
    };
    let out = dir.join("d");
    let mut writer = DatasetWriter::create(&out, header, &suite, 600).unwrap();
    let cancel = AtomicBool::new(false);
    let making =
        Making { setting: &setting, worlds: &suite, hz: 10, jobs: 1, stack_bytes: 4 << 20, cancel: &cancel };
    assert!(making.explore(&mut writer, &exploration, Amount::Episodes(3), &mut |_| {}).unwrap());
    assert_eq!(writer.finish().unwrap().episodes, 3);
    Dataset::open(&out).unwrap()
}

/// The values of a column, frame by frame.
fn column(features: &[Feature], episode: &Episode, name: &str) -> Vec<Vec<f64>> {
    let k = features.iter().position(|f| f.name == name).unwrap_or_else(|| panic!("no column {name}"));
    let (width, values) = (features[k].width(), &episode.columns[k]);
    (0..episode.frames).map(|f| (f * width..(f + 1) * width).map(|i| values.number(i)).collect()).collect()
}

#[test]
fn frames_hold_together_as_kinematics_demand() {
    let dir = tempfile::tempdir().unwrap();
    let dataset = explored(dir.path(), 8, &Profile::oracle());
    let features = dataset.features();
    for episode in dataset.episodes() {
        let episode = episode.unwrap();
        let of = |name: &str| column(features, &episode, name);
        let (state, action, applied) = (of("observation.state"), of("action"), of("action.applied"));
        // It drives straight at its speed until the edge of the world ends it.
        assert_eq!(episode.info.outcome, Ending::Decided(Outcome::OutOfBounds));
        assert_eq!((episode.info.ground, episode.info.cause), (Some(TerrainClass::Gravel), None));
        for k in 40..episode.frames - 1 {
            let (a, b) = (&state[k], &state[k + 1]);
            // The step is the velocity of the middle, turned into the world: within the errors of a tenth of a second.
            let speed = 0.5 * (a[6] + b[6]);
            let along = 0.1 * speed * cos(0.5 * (a[4] + b[4]));
            let ahead = (b[0] - a[0]) * cos(a[5]) + (b[1] - a[1]) * sin(a[5]);
            assert!((ahead - along).abs() < 2e-3, "{k}: {ahead} {along}");
            assert!((speed - 3.0).abs() < 0.3, "{speed}");
            // On a slope of 5 % to the east the ground under the heading rises by 5 % of its cosine.
            let climb = vb_math::atan(0.05 * cos(a[5]));
            assert!((-a[4] - climb).abs() < 0.03, "pitch {} for {climb}", a[4]);
            assert_eq!((action[k][0], applied[k][0], action[k][3]), (0.0, 0.0, 1.0));
        }
        assert!(of("action.speed").iter().all(|v| (v[0] - 3.0).abs() < 1e-6));
        // Each wheel carries about its share of 2493.56 kg, and none sinks into rigid ground.
        let wheels = of("truth.wheels");
        let mean = |entry: usize| wheels.iter().map(|w| w[entry]).sum::<f64>() / wheels.len() as f64;
        let load: f64 = [0, 2, 4, 6].map(mean).iter().sum();
        assert!((load / (2493.56 * 9.81) - 1.0).abs() < 0.02, "{load}");
        assert!(wheels.iter().all(|w| w[1] == 0.0 && w[7] == 0.0));
        assert!(of("truth.ground").iter().all(|g| g[0] == 4.0));
        let done: Vec<f64> = of("next.done").iter().map(|d| d[0]).collect();
        assert!(done[..done.len() - 1].iter().all(|d| *d == 0.0) && done[done.len() - 1] == 1.0);
        crops(&episode, features, &state);
    }
}

/// The crops of 8 by 8 cells of 2 m: the ground of the slope relative to the vehicle, where the cells are.
fn crops(episode: &Episode, features: &[Feature], state: &[Vec<f64>]) {
    let of = |name: &str| column(features, episode, name);
    let (heights, classes, friction) =
        (of("observation.height_crop"), of("observation.class_crop"), of("observation.friction_crop"));
    for (k, s) in state.iter().enumerate() {
        for cell in 0..64 {
            let (forward, left) = ((cell / 8) as f64 * 2.0 - 7.0, (cell % 8) as f64 * 2.0 - 7.0);
            let (x, y) = (
                s[0] + cos(s[5]) * forward - sin(s[5]) * left,
                s[1] + sin(s[5]) * forward + cos(s[5]) * left,
            );
            let clear = |v: f64| (v.abs() - 64.0).abs() > 1e-3;
            if !clear(x) || !clear(y) {
                continue;
            }
            let (class, mu, height) = (classes[k][cell], friction[k][cell], heights[k][cell]);
            if x.abs() > 64.0 || y.abs() > 64.0 {
                assert_eq!((class, mu), (255.0, 0.0));
                continue;
            }
            assert!((height - 0.05 * (x - s[0])).abs() < 1e-4, "{height} at {x}, {y}");
            assert!((mu - 0.55).abs() < 1e-3);
            let (dx, dy) = (x.abs() - 2.0, (y - 40.0).abs() - 2.0);
            if dx.abs() > 1e-3 && dy.abs() > 1e-3 {
                assert_eq!(class, if dx < 0.0 && dy < 0.0 { 10.0 } else { 4.0 }, "{x}, {y}");
            }
        }
    }
}

#[test]
fn the_docs_have_every_column_cause_and_field() {
    let docs = include_str!("../../../../docs/datasets.md");
    let layout = Layout { wheels: 4, speed: true, goal: true, truth: true, crops: 8 };
    for feature in layout.features() {
        let name = feature.name;
        let mut rows = docs.lines().filter(|line| line.starts_with(&format!("| `{name}` |")));
        let row = rows.next().unwrap_or_else(|| panic!("no row of {name}"));
        let shape = match (feature.shape.as_slice(), name.ends_with(".wheels")) {
            ([8], true) => "2 a wheel".to_owned(),
            ([8, 8], _) => "N × N".to_owned(),
            ([n], _) => n.to_string(),
            other => panic!("{other:?}"),
        };
        assert!(row.contains(&format!("| {} | {shape} |", feature.dtype.name())), "{row}");
        // The names of entries end in their units.
        for entry in feature.names.iter().filter(|_| name != "truth.state") {
            let entry = entry.strip_prefix("wheel").map_or(entry.as_str(), |wheel| &wheel[2..]);
            assert!(row.contains(&format!("`{entry}`")), "{name}: {entry}");
        }
    }
    let said = serde_json::to_value(EpisodeInfo::default()).unwrap();
    for field in said.as_object().unwrap().keys() {
        assert!(docs.contains(&format!("`{field}`")), "{field}");
    }
    let text = serde_json::to_value(Exploration::resolve("default").unwrap()).unwrap();
    for (block, fields) in text.as_object().unwrap() {
        assert!(docs.contains(&format!("`{block}")), "{block}");
        for field in fields.as_object().into_iter().flatten().map(|(name, _)| name) {
            let there = docs.contains(&format!("`{block}.{field}`")) || docs.contains(&format!("`.{field}`"));
            assert!(there, "{block}.{field}");
        }
    }
}

#[test]
fn what_the_driver_saw_and_what_was_true_are_apart_where_they_differ() {
    let dir = tempfile::tempdir().unwrap();
    let profile = Profile::built_in("degraded").unwrap();
    let dataset = explored(dir.path(), 0, &profile);
    let features = dataset.features();
    let episode = dataset.episodes().next().unwrap().unwrap();
    let (seen, truth) =
        (column(features, &episode, "observation.state"), column(features, &episode, "truth.state"));
    // The estimate drifts by decimetres over tens of metres, but not more.
    let last = seen.len() - 1;
    let off = vb_math::hypot(seen[last][0] - truth[last][0], seen[last][1] - truth[last][1]);
    assert!(off > 0.05 && off < 10.0, "{off}");
    assert_eq!(seen[0][0], truth[0][0]);
}
