//! `meta/info.json`: what LeRobot reads first.

use serde_json::{Map, Value, json};

use super::{CHUNK, CODEBASE_VERSION};
use crate::feature::Feature;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Totals {
    pub(crate) episodes: usize,
    pub(crate) frames: usize,
    pub(crate) tasks: usize,
}

/// The content of `meta/info.json`.
pub(crate) fn info(robot: &str, hz: u32, features: &[Feature], totals: Totals) -> Value {
    let mut all = Map::new();
    for f in features {
        let names = if f.names.is_empty() { Value::Null } else { json!(f.names) };
        all.insert(f.name.to_owned(), json!({"dtype": f.dtype.name(), "shape": f.shape, "names": names}));
    }
    let own = [
        ("timestamp", "float32"),
        ("frame_index", "int64"),
        ("episode_index", "int64"),
        ("index", "int64"),
        ("task_index", "int64"),
    ];
    for (name, dtype) in own {
        all.insert(name.to_owned(), json!({"dtype": dtype, "shape": [1], "names": null}));
    }
    json!({
        "codebase_version": CODEBASE_VERSION,
        "robot_type": robot,
        "total_episodes": totals.episodes,
        "total_frames": totals.frames,
        "total_tasks": totals.tasks,
        "chunks_size": CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": hz,
        "splits": {"train": format!("0:{}", totals.episodes)},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": null,
        "features": all
    })
}
