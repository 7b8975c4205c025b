//! What the tests of datasets share.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::Path;

use vb_dataset::{DATASET_SCHEMA, Format, Header, Kind, Layout};
use vb_record::DataHeader;
use vb_world::{
    Heightfield, Obstacle, ObstacleKind, Provenance, Suite, SuiteMeta, SuiteWriter, TerrainClass, World,
};

/// A slope of 5 % to the east, with a box in the north.
fn world() -> World {
    let n = 129;
    let heights = (0..n * n).map(|k| 0.05 * ((k % n) as f64 - 64.0)).collect();
    let mut world = World::uniform("w001", Heightfield::new(n, n, 1.0, heights), TerrainClass::Gravel, 0.55);
    let kind = ObstacleKind::Box { size: [4.0, 4.0, 2.0] };
    world.obstacles.push(Obstacle { x: 0.0, y: 40.0, yaw: 0.0, buried: 0.5, kind });
    world
}

pub fn suite(dir: &Path) -> Suite {
    let provenance = Provenance::Generated { generator: "by hand".into(), seed: 7000 };
    let meta =
        SuiteMeta { name: "slope".into(), version: "1".into(), description: String::new(), provenance };
    let mut writer = SuiteWriter::create(dir, meta).unwrap();
    writer.add(&world()).unwrap();
    writer.finish().unwrap()
}

pub fn named(name: &str) -> DataHeader {
    DataHeader { name: name.into(), hash: String::new() }
}

/// What a dataset of exploration says of itself.
pub fn header(name: &str, layout: Layout, suite: &Suite) -> Header {
    Header {
        schema: DATASET_SCHEMA,
        format: Format::default(),
        name: name.into(),
        kind: Kind::Explore,
        licence: "CC0-1.0".into(),
        harness_version: "0".into(),
        harness_commit: "none".into(),
        command: Vec::new(),
        seed: 1,
        hz: 10,
        layout,
        vehicle: named("hmmwv"),
        soils: named("default"),
        rules: named("exploration"),
        perception: named("oracle"),
        scale: 1.0,
        time_step: 0.001,
        worlds: DataHeader { name: "slope".into(), hash: suite.hash() },
        exploration: None,
        planners: Vec::new(),
        of_a_suite: false,
        options: [].into(),
    }
}
