//! `meta/info.json`: what LeRobot reads first.

use serde_json::{Map, Value, json};

use super::{CHUNK, CODEBASE_VERSION, OWN};
use crate::feature::Feature;
use crate::format::Whole;
use crate::header::Header;

/// The content of `meta/info.json`.
pub(crate) fn info(header: &Header, features: &[Feature], whole: &Whole) -> Value {
    let mut all = Map::new();
    for f in features {
        let names = if f.names.is_empty() { Value::Null } else { json!(f.names) };
        all.insert(f.name.to_owned(), json!({"dtype": f.dtype.name(), "shape": f.shape, "names": names}));
    }
    for (name, dtype) in OWN {
        all.insert(name.to_owned(), json!({"dtype": dtype.name(), "shape": [1], "names": null}));
    }
    json!({
        "codebase_version": CODEBASE_VERSION,
        "robot_type": header.vehicle.name,
        "total_episodes": whole.episodes,
        "total_frames": whole.frames,
        "total_tasks": whole.tasks.len(),
        "chunks_size": CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": header.hz,
        "splits": {"train": format!("0:{}", whole.episodes)},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": null,
        "features": all
    })
}
