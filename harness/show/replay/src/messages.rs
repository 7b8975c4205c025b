//! Parts of Foxglove's messages that several topics of an MCAP file share.

use std::sync::Arc;

use foxglove::messages::{Pose, Quaternion, Timestamp, Vector3};
use foxglove::{ChannelBuilder, Context, PartialMetadata, Schema};
use nalgebra::UnitQuaternion;

pub(crate) const WORLD: &str = "world";

/// A time of the simulation as a time since the epoch.
pub(crate) fn at(time: f64) -> (Timestamp, PartialMetadata) {
    let nanos = (time.max(0.0) * 1e9).round() as u64;
    let stamp = Timestamp::new((nanos / 1_000_000_000) as u32, (nanos % 1_000_000_000) as u32);
    (stamp, PartialMetadata::with_log_time(nanos))
}

pub(crate) fn vector(v: [f64; 3]) -> Vector3 {
    Vector3 { x: v[0], y: v[1], z: v[2] }
}

pub(crate) fn quaternion(q: UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: q.i, y: q.j, z: q.k, w: q.w }
}

pub(crate) fn pose(position: [f64; 3]) -> Pose {
    Pose { position: Some(vector(position)), orientation: Some(quaternion(UnitQuaternion::identity())) }
}

pub(crate) fn json_channel(
    topic: String,
    schema: (&str, &'static str),
    context: &Arc<Context>,
) -> Result<Arc<foxglove::RawChannel>, foxglove::FoxgloveError> {
    ChannelBuilder::new(topic)
        .message_encoding("json")
        .schema(Schema::new(schema.0, "jsonschema", schema.1.as_bytes()))
        .context(context)
        .build_raw()
}
