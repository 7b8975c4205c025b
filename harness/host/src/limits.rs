//! The limits on what a planner may use.

use serde::{Deserialize, Serialize};

/// The limits of one planner session. All but the fuel are generous bounds against accidents; fuel is the planner's
/// computing time in units that are the same on every machine: about one per WebAssembly instruction.
///
/// What the defaults mean for a planner is told in `docs/abi.md`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// The fuel for start-up and `init` of one task; WASM only.
    pub fuel_init: u64,
    /// The fuel for one step; WASM only.
    pub fuel_per_step: u64,
    /// The fuel for start-up, `init` and all steps of one task together; WASM only.
    pub fuel_per_task: u64,
    /// The linear memory of all memories of the plugin together, bytes.
    pub memory_bytes: usize,
    /// The number of elements of all tables of the plugin together; WASM only.
    pub table_elements: usize,
    /// The stack of the WASM code, bytes. A thread that runs sessions needs [`Limits::THREAD_STACK_BYTES`] more.
    pub stack_bytes: usize,
    /// The amount of data that one call may hand over (command with debug series), bytes.
    pub output_bytes: usize,
    /// The length of the log text of one task, bytes. What goes beyond is dropped.
    pub log_bytes: usize,
    /// The size of the plugin file, bytes.
    pub module_bytes: u64,
    /// The memory of the compiler, bytes; WASM only.
    pub compile_bytes: usize,
    /// The processor time of the compiler, all its threads together, s; WASM only.
    pub compile_seconds: u64,
    /// The wall-clock time of one call, ms. It only ever ends what hangs: no score depends on it. A planner in a
    /// process of its own always has it; WASM code has it only if `wasm_watchdog` is set.
    pub watchdog_ms: u64,
    /// Whether the watchdog also looks after WASM code, which makes that about a fifth slower. It need not: fuel ends
    /// every call after the same instruction everywhere, and nothing that a planner can call blocks.
    pub wasm_watchdog: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            fuel_init: 20_000_000_000,
            fuel_per_step: 2_000_000_000,
            fuel_per_task: 1_000_000_000_000,
            memory_bytes: 256 << 20,
            table_elements: 1 << 20,
            stack_bytes: 1 << 20,
            output_bytes: 16 << 20,
            log_bytes: 64 << 10,
            module_bytes: 64 << 20,
            compile_bytes: 2 << 30,
            compile_seconds: 120,
            watchdog_ms: 60_000,
            wasm_watchdog: false,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {value} is not between {low} and {high}")]
pub struct LimitsError {
    pub field: &'static str,
    pub value: u64,
    pub low: u64,
    pub high: u64,
}

impl Limits {
    /// The stack that the host's own code needs on a thread that runs sessions, bytes, beside
    /// [`stack_bytes`](Self::stack_bytes).
    pub const THREAD_STACK_BYTES: usize = 1 << 20;

    /// The stack of a thread that runs trials with planners under these limits, bytes.
    #[must_use]
    pub fn thread_stack_bytes(&self) -> usize {
        self.stack_bytes + 2 * Self::THREAD_STACK_BYTES
    }

    /// Checks that every limit is one that can be kept.
    ///
    /// # Errors
    /// Returns the first limit that can't be kept.
    pub fn validate(&self) -> Result<(), LimitsError> {
        for (field, value) in self.named() {
            // Below the lower bounds no planner starts; above the upper ones the number means nothing.
            let (low, high) = match field {
                "fuel_init" | "fuel_per_step" | "fuel_per_task" => (1, i64::MAX as u64),
                "memory_bytes" => (64 << 10, 1 << 40),
                "table_elements" => (0, u64::from(u32::MAX)),
                "stack_bytes" => (64 << 10, 64 << 20),
                "output_bytes" => (1 << 10, 1 << 30),
                "log_bytes" => (0, 1 << 30),
                "module_bytes" => (1, 4 << 30),
                "compile_bytes" => (64 << 20, 1 << 40),
                "compile_seconds" => (1, 24 * 3600),
                "watchdog_ms" => (1, 24 * 3600 * 1000),
                _ => (0, 1),
            };
            if !(low..=high).contains(&value) {
                return Err(LimitsError { field, value, low, high });
            }
        }
        Ok(())
    }

    /// All limits by name, as results record them; `wasm_watchdog` is 0 or 1.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 13] {
        [
            ("fuel_init", self.fuel_init),
            ("fuel_per_step", self.fuel_per_step),
            ("fuel_per_task", self.fuel_per_task),
            ("memory_bytes", self.memory_bytes as u64),
            ("table_elements", self.table_elements as u64),
            ("stack_bytes", self.stack_bytes as u64),
            ("output_bytes", self.output_bytes as u64),
            ("log_bytes", self.log_bytes as u64),
            ("module_bytes", self.module_bytes),
            ("compile_bytes", self.compile_bytes as u64),
            ("compile_seconds", self.compile_seconds),
            ("watchdog_ms", self.watchdog_ms),
            ("wasm_watchdog", u64::from(self.wasm_watchdog)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_has_its_name_in_results() {
        let json = serde_json::to_value(Limits::default()).unwrap();
        let mut fields: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
        let mut named: Vec<&str> = Limits::default().named().iter().map(|(name, _)| *name).collect();
        fields.sort_unstable();
        named.sort_unstable();
        assert_eq!(fields, named);
    }

    #[test]
    fn a_limit_that_cannot_be_kept_is_named_with_its_bounds() {
        Limits::default().validate().unwrap();
        let error = Limits { stack_bytes: 1 << 40, ..Limits::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "stack_bytes: 1099511627776 is not between 65536 and 67108864");
        assert!(Limits { fuel_per_step: 0, ..Limits::default() }.validate().is_err());
        // The engine counts fuel in signed 64 bits.
        assert!(Limits { fuel_init: u64::MAX, ..Limits::default() }.validate().is_err());
    }

    #[test]
    fn the_documented_defaults_are_those_of_the_code() {
        let text = include_str!("../../../docs/abi.md");
        for (name, value) in Limits::default().named() {
            let row = text.lines().find(|l| l.starts_with(&format!("| `{name}` |")));
            let row = row.unwrap_or_else(|| panic!("{name} is not in docs/abi.md"));
            let cell: String =
                row.split('|').nth(2).unwrap().chars().filter(|c| !c.is_whitespace()).collect();
            let shown = match name {
                "wasm_watchdog" => "false".to_owned(),
                _ => value.to_string(),
            };
            assert_eq!(cell, shown, "{name}");
        }
    }
}
