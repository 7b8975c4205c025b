//! Suites on disk.

use std::path::PathBuf;

use vb_world::{
    Density, Elevation, Heightfield, Obstacle, ObstacleKind, Pose2, Provenance, Semantics, SoilLevels, Suite,
    SuiteMeta, Task, Terrain, TerrainClass, World,
};

use crate::site::Site;

/// A world of 5 × 9 nodes with an obstacle of each kind and one task.
fn world() -> World {
    let levels: Vec<u16> = (0..45u16).map(|k| k * 257).collect();
    let obstacle = |x, y, kind| Obstacle { x, y, yaw: 0.5, buried: 0.2, kind };
    World {
        id: "w001".into(),
        elevation: Elevation::High,
        terrain: Terrain::Mixed,
        density: Density::Sparse,
        scale: 1.0,
        heightfield: Heightfield::from_levels(5, 9, 2.0, [0.0, 9.6], &levels),
        semantics: Semantics {
            rows: 2,
            cols: 4,
            patch: 4.0,
            classes: (0..8).map(|k| [TerrainClass::Clay, TerrainClass::Snow][k % 2]).collect(),
            friction: (0..8).map(|k| if k % 2 == 0 { 0.5 } else { 0.0 }).collect(),
            soil: SoilLevels::default(),
        },
        obstacles: vec![
            obstacle(0.5, -2.5, ObstacleKind::Boulder { size: [1.1, 1.0, 0.9], seed: 7 }),
            obstacle(-4.0, 2.0, ObstacleKind::Box { size: [1.0, 2.0, 3.0] }),
            obstacle(5.0, 3.0, ObstacleKind::Trunk { radius: 0.5, height: 5.0 }),
        ],
        beds: Vec::new(),
        tasks: vec![Task {
            id: "t00".into(),
            start: Pose2 { x: -7.0, y: 0.0, yaw: 0.0 },
            goal: [7.0, 0.0],
            path: vec![[-7.0, 0.0], [0.3, 1.0], [7.0, 0.0]],
        }],
    }
}

fn site() -> Site {
    let site = Site::new();
    let meta = SuiteMeta {
        name: "seed".into(),
        version: "1".into(),
        description: "A seed".into(),
        provenance: Provenance::Authored { by: "the fuzz targets".into() },
    };
    let dir = site.path().join("suite");
    Suite::write(&dir, &meta, [&world()]).expect("a valid suite");
    let names =
        ["suite.yaml", "world.yaml", "elevation.png", "semantics.yaml", "obstacles.yaml", "tasks.yaml"];
    let files = names.map(|name| {
        let path = if name == "suite.yaml" {
            PathBuf::from("suite").join(name)
        } else {
            PathBuf::from("suite/worlds/w001").join(name)
        };
        let bytes = std::fs::read(site.path().join(&path)).expect("a file of the suite");
        (path, bytes)
    });
    site.with(files.into())
}

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = site());
    SITE.with(|site| {
        site.replacing(data, |dir| {
            let Ok(suite) = Suite::open(dir.join("suite")) else { return };
            for info in suite.worlds() {
                let _ = suite.load_world(&info.id);
            }
        });
    });
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    site().seeds()
}
