//! What a planner may use.

use serde::{Deserialize, Serialize};

/// Limits of one planner session. All but the fuel are generous bounds against accidents; fuel is the planner's
/// computing time in units that are the same on every machine: about one per WebAssembly instruction.
///
/// Native planners run without fuel and memory limits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Fuel for start-up and `init` of one task.
    pub fuel_init: u64,
    /// Fuel for one step.
    pub fuel_per_step: u64,
    /// Linear memory, bytes, all memories of the plugin together.
    pub memory_bytes: usize,
    /// Log text of one task, bytes; what goes beyond is dropped.
    pub log_bytes: usize,
    /// Data that one call may hand over (command with debug series), bytes.
    pub output_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            fuel_init: 20_000_000_000,
            fuel_per_step: 2_000_000_000,
            memory_bytes: 256 << 20,
            log_bytes: 64 << 10,
            output_bytes: 16 << 20,
        }
    }
}
