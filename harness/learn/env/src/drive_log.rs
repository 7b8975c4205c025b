//! Serialized form of an environment's state: the task, its seed and all actions. It holds no state of the simulation, so untrusted
//! bytes can't bring the simulation into a state that is not reachable by driving.

use serde::{Deserialize, Serialize};
use vb_world::TaskId;

use crate::EnvError;

/// Magic number; the last character is the version of the format.
const MAGIC: &[u8] = b"vbstate1";
/// Limit on the size, bytes. An hour of actions at 100 Hz is less.
const MAX_BYTES: usize = 16 << 20;

/// The episode up to a state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriveLog {
    /// The hash of the options of the arena.
    pub(crate) options: String,
    pub(crate) task: TaskId,
    /// The seed of the sensors' noise.
    pub(crate) run_seed: u64,
    /// Where the stream stands that later tasks are drawn from.
    pub(crate) draws: ([u8; 32], u64),
    /// All actions, one after another.
    pub(crate) actions: Vec<f64>,
    /// The hash over all states of the simulation until then.
    pub(crate) state_hash: u64,
}

impl DriveLog {
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        // Numbers and text can always be written into memory.
        let _ = rmp_serde::encode::write(&mut bytes, self);
        bytes
    }

    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, EnvError> {
        if bytes.len() > MAX_BYTES {
            let (size, most) = (bytes.len(), MAX_BYTES);
            return Err(EnvError::State(format!("it has {size} bytes; at most {most} are allowed")));
        }
        let body = bytes.strip_prefix(MAGIC).ok_or_else(|| EnvError::State("it is not a state".into()))?;
        let log: Self = rmp_serde::from_slice(body).map_err(|e| EnvError::State(e.to_string()))?;
        // The decoder ignores trailing bytes.
        if log.to_bytes() != bytes {
            return Err(EnvError::State("it contains invalid bytes".into()));
        }
        Ok(log)
    }
}
