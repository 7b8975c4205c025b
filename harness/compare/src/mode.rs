//! What is held equal with the recorded runs, and the inputs that this takes.

use std::path::Path;

use serde_json::{Value, json};
use vb_world::{ObstacleKind, World, yaml};

use crate::CompareError;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The same planner and the same hull: what is left is the physics, and chance.
    Physics,
    /// The same planner, our vehicle.
    Planner,
    /// Our planner on our path, our vehicle.
    Shipped,
}

impl Mode {
    pub(crate) const ALL: [Self; 3] = [Self::Physics, Self::Planner, Self::Shipped];

    /// Name of its folder.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Physics => "physics",
            Self::Planner => "planner",
            Self::Shipped => "shipped",
        }
    }

    /// What it is, in a table's head.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Physics => "released planner, Chrono's hull",
            Self::Planner => "released planner, our hull",
            Self::Shipped => "our planner, our hull",
        }
    }

    /// Name of its planner.
    pub(crate) fn planner(self) -> &'static str {
        match self {
            Self::Physics | Self::Planner => "pid-release",
            Self::Shipped => "pid",
        }
    }
}

/// Half extents of the recorded vehicle's collision box and the height of its centre above the reference point, m
/// (facts §4.4: 2.0 × 1.0 × 0.2 m, centred at (0, 0, 0.1)).
const HULL: [f64; 4] = [1.0, 0.5, 0.1, 0.1];
/// Greatest rate of the recorded steering command, 1/s: 0.05 in a step of 5 ms.
const STEERING_RATE: f64 = 10.0;

/// Travel over which the recorded vehicle's linkages are solved, m: it has no stops, and its records show up to 0.21 m
/// (`tasks/validation/hmmwv.yaml`, `free_travel`).
const TRAVEL: [f64; 2] = [-0.16, 0.24];

/// Our vehicle with the hull, the faces of wheels, the steering rate, the suspensions without stops and the rigid tyres
/// of the recorded one, as a document that the harness reads.
pub(crate) fn recorded_vehicle(file: &Path) -> Result<String, CompareError> {
    let text =
        std::fs::read_to_string(file).map_err(|source| CompareError::Io { path: file.into(), source })?;
    let flaw = |field: &str, problem: String| CompareError::Vehicle {
        file: file.into(),
        field: field.into(),
        problem,
    };
    let mut vehicle: Value = yaml::parse(&text).map_err(|e| flaw(&e.field, e.problem))?;
    let [x, y, z, above] = HULL;
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        [sign(2) * x, sign(1) * y, above + sign(0) * z]
    };
    let hull: Vec<_> = (0..8).map(corner).collect();
    let tyre = vehicle.as_object_mut().and_then(|v| v.remove("tyres")).and_then(|t| t.get("rigid").cloned());
    let Some(Value::Object(tyre)) = tyre else {
        return Err(flaw("tyres.rigid", "is missing: the recorded vehicle has rigid tyres".into()));
    };
    const PLACE: &str = "the tyre";
    let changes =
        [("/chassis/hull", json!([hull])), ("/steering/rate", json!(STEERING_RATE)), ("/tyre", json!(PLACE))];
    for (field, value) in changes {
        match vehicle.pointer_mut(field) {
            Some(place) => *place = value,
            None => return Err(flaw(field, "is missing: the comparison sets it".into())),
        }
    }
    for axle in vehicle["axles"].as_array_mut().into_iter().flatten() {
        let suspension = axle.get_mut("suspension").and_then(Value::as_object_mut);
        if let Some(suspension) = suspension.filter(|s| s.contains_key("stops")) {
            suspension.remove("stops");
            suspension.insert("range".to_owned(), json!(TRAVEL));
        }
    }
    // Chrono's wheels are cylinders, which lie on their faces when the vehicle has tipped over.
    vehicle["chassis"]["wheel_faces"] = json!(true);
    // JSON is YAML. A tyre's model is its first key, and a JSON value has its keys sorted.
    let (model, rest): (Vec<_>, Vec<_>) = tyre.iter().partition(|(key, _)| *key == "model");
    let fields: Vec<_> = model.into_iter().chain(rest).map(|(k, v)| format!("{}:{v}", json!(k))).collect();
    Ok(vehicle.to_string().replace(&json!(PLACE).to_string(), &format!("{{{}}}", fields.join(","))))
}

/// The squares that the original burns into its obstacle bitmap (facts §1.7), as the `pid-release` planner takes
/// them: around the pixel of an obstacle's centre, with as many whole metres as its box is wide, halved and cut.
pub(crate) fn obstacle_squares(world: &World) -> String {
    // Pixels are 1 m; the bitmap reaches half a pixel beyond the surface on every side.
    let last = 2.0 * world.heightfield.half_x();
    let middle = 0.5 * (last + 1.0);
    let pixel = |v: f64| (v + middle).clamp(0.0, last).round_ties_even();
    let square = |o: &vb_world::Obstacle| {
        let width = match o.kind {
            ObstacleKind::Box { size } | ObstacleKind::Boulder { size, .. } => size[0],
            ObstacleKind::Trunk { radius, .. } => 2.0 * radius,
        };
        format!("{}:{}:{}", pixel(-o.y), pixel(o.x), width as usize / 2)
    };
    world.obstacles.iter().map(square).collect::<Vec<_>>().join(";")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;
    use vb_suite::import::{Ground, Source};

    #[test]
    fn the_recorded_vehicle_differs_in_hull_faces_tyres_stops_and_steering_rate_alone() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks/vehicles/hmmwv.yaml");
        let ours: Value = yaml::parse(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let mut theirs: Value = yaml::parse(&recorded_vehicle(&file).unwrap()).unwrap();
        let hull: Vec<Vec<[f64; 3]>> = serde_json::from_value(theirs["chassis"]["hull"].clone()).unwrap();
        let range = |axis: usize| {
            let values = || hull[0].iter().map(|v| v[axis]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        assert_eq!((hull.len(), hull[0].len()), (1, 8));
        assert_eq!([range(0), range(1), range(2)], [[-1.0, 1.0], [-0.5, 0.5], [0.0, 0.2]]);
        assert_eq!(theirs["steering"]["rate"], 10.0);
        assert_eq!(theirs["chassis"].as_object_mut().unwrap().remove("wheel_faces"), Some(json!(true)));
        theirs["chassis"]["hull"] = ours["chassis"]["hull"].clone();
        theirs["steering"]["rate"] = ours["steering"]["rate"].clone();
        for (axle, own) in
            theirs["axles"].as_array_mut().unwrap().iter_mut().zip(ours["axles"].as_array().unwrap())
        {
            let suspension = &mut axle["suspension"];
            assert!(suspension.get("stops").is_none() && own["suspension"].get("stops").is_some());
            assert_eq!(suspension["range"], json!([-0.16, 0.24]));
            *suspension = own["suspension"].clone();
        }
        assert_eq!(theirs["tyre"]["model"], "rigid");
        theirs["tyre"] = ours["tyre"].clone();
        theirs["tyres"] = ours["tyres"].clone();
        assert_eq!(ours, theirs);
    }

    #[test]
    fn its_suspensions_and_tyres_are_those_of_the_canonical_comparisons() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks/validation/hmmwv.yaml");
        let references: Value = yaml::parse(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let setup = &references["setups"]["chrono"];
        assert_eq!((&setup["free_travel"], &setup["tyre"]), (&json!(TRAVEL), &json!("rigid")));
    }

    #[test]
    fn a_vehicle_without_the_field_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("cart.yaml");
        std::fs::write(&file, "chassis: {mass: 3}\ntyres: {rigid: {model: rigid}}\n").unwrap();
        let message = recorded_vehicle(&file).unwrap_err().to_string();
        assert!(message.contains("cart.yaml: /chassis/hull: is missing"), "{message}");
    }

    /// Against the original's own obstacle bitmaps: 129 rows of 132 bytes from byte 1078 on, bottom row first, 255 on
    /// obstacles (facts §1.2, §1.7).
    #[test]
    fn squares_are_those_of_the_original_bitmaps() {
        let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
        let shared = std::env::var_os("VB_SHARED").map_or(beside, PathBuf::from).join("verti-bench");
        let Ok(source) = Source::find(&shared) else {
            eprintln!("skipped: no reference data at {} (set VB_SHARED)", shared.display());
            return;
        };
        let source = source.ground(Ground::AsSimulated);
        for id in source.ids().take(6) {
            let world = source.world(id).unwrap();
            let level = ["low", "mid", "high"][world.elevation as usize];
            let file = shared.join(format!("BenchMaps/sampled_maps/Configs/Final/obs{id}_{level}.bmp"));
            let bytes = std::fs::read(file).unwrap();
            let mut blocked = vec![false; 129 * 129];
            for square in obstacle_squares(&world).split(';') {
                let n: Vec<usize> = square.split(':').map(|s| s.parse().unwrap()).collect();
                for row in n[0] - n[2]..=n[0] + n[2] {
                    for col in n[1] - n[2]..=n[1] + n[2] {
                        blocked[row * 129 + col] = true;
                    }
                }
            }
            for (k, blocked) in blocked.into_iter().enumerate() {
                let pixel = bytes[1078 + 132 * (128 - k / 129) + k % 129];
                assert_eq!(blocked, pixel == 255, "world {id}, row {}, column {}", k / 129, k % 129);
            }
        }
    }
}
