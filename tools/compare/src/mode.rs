//! What is held equal with the recorded runs, and the inputs that this takes.

use vb_world::{ObstacleKind, World};

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The same planner and the same vehicle: what is left is the physics, and chance.
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
            Self::Physics => "released planner, Chrono's vehicle",
            Self::Planner => "released planner, our vehicle",
            Self::Shipped => "our planner, our vehicle",
        }
    }

    pub(crate) fn planner(self) -> &'static str {
        match self {
            Self::Physics | Self::Planner => "pid-release",
            Self::Shipped => "pid",
        }
    }
}

/// The squares that the original burns into its obstacle bitmap (`gen_obs_map` in its envs/gen-VertiBench.py), as the
/// `pid-release` planner takes them: around the pixel of an obstacle's centre, with as many whole metres as its box is
/// wide, halved and cut.
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
    use serde_json::{Value, json};
    use std::path::{Path, PathBuf};
    use vb_files::yaml;
    use vb_suite::import::{Ground, Source};

    #[test]
    fn the_recorded_vehicle_is_chronos_reduced_model() {
        let file = root().join("tasks/vehicles/hmmwv-released.yaml");
        let vehicle: Value = yaml::parse(&std::fs::read_to_string(file).unwrap()).unwrap();
        let mut tyre = vehicle["tyre"].clone();
        let dilation = tyre.as_object_mut().unwrap().remove("dilation");
        assert_eq!(tyre.as_object_mut().unwrap().remove("contact"), Some(json!("facets")));
        assert_eq!(
            dilation,
            Some(json!({"step": 0.005, "reach": 0.06})),
            "the solver's step and both envelopes"
        );
        assert_eq!(tyre, vehicle["tyres"]["cylinder"]);
        assert_eq!(vehicle["steering"], json!({"rate": 10.0}));
        // HMMWV_RackPinion: a pinion of 0.1 m that turns by 30 degrees.
        assert!(
            (vehicle["axles"][0]["steering"]["travel"].as_f64().unwrap() - 0.1 * 30_f64.to_radians()).abs()
                < 1e-9
        );
        // HMMWV_DoubleWishboneReduced: struts on the uprights, 954 and 2108 lb/in, and no stops.
        for (axle, rate) in vehicle["axles"].as_array().unwrap().iter().zip([954.0, 2108.0]) {
            let (suspension, strut) = (&axle["suspension"], &axle["suspension"]["struts"][0]);
            assert!(suspension.get("stops").is_none() && strut.get("stops").is_none());
            assert_eq!(strut["part"], "upright");
            let stiffness = strut["spring"]["stiffness"].as_f64().unwrap();
            assert!((stiffness / (rate * 175.126_77) - 1.0).abs() < 1e-4, "{stiffness}");
        }
    }

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    /// Against the original's own obstacle bitmaps: 129 rows of 132 bytes from byte 1078 on, bottom row first, 255 on
    /// obstacles (`gen_obs_map` in its envs/gen-VertiBench.py).
    #[test]
    fn squares_are_those_of_the_original_bitmaps() {
        let Some(shared) = vb_testing::shared("verti-bench") else { return };
        let source = Source::find(&shared).unwrap().ground(Ground::AsSimulated);
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
