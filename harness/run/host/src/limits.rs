//! The limits on what a planner may use.

use serde::{Deserialize, Serialize};
use vb_files::document::{self, within};
use vb_files::{Document, DocumentError, Flaw};

macro_rules! limits {
    ($($(#[doc = $doc:literal])* $field:ident: $kind:ty = $default:expr, $low:expr => $high:expr;)*) => {
        /// Limits of a planner session. Fuel is a planner's computing time in units that are equal on every machine: about one
        /// per WebAssembly instruction. All other limits are generous bounds against accidents. `docs/abi.md` describes what the
        /// defaults mean for a planner.
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct Limits {
            $($(#[doc = $doc])* pub $field: $kind,)*
        }

        impl Default for Limits {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl Limits {
            /// Checks that each limit lies in its range: below it no planner starts, above it the number means nothing.
            ///
            /// # Errors
            /// Returns the first limit that does not.
            pub fn validate(&self) -> Result<(), Flaw> {
                $(within(stringify!($field), self.$field as u64, $low, $high)?;)*
                Ok(())
            }

            /// All limits with their names, as results record them; `wasm_watchdog` is 0 or 1.
            #[must_use]
            pub fn named(&self) -> Vec<(&'static str, u64)> {
                vec![$((stringify!($field), self.$field as u64),)*]
            }
        }
    };
}

// Name, type and default; then the range.
limits! {
    /// Fuel for start-up and `init` of one task; WASM only.
    fuel_init: u64 = 20_000_000_000, 1 => i64::MAX as u64;
    /// Fuel for one step; WASM only.
    fuel_per_step: u64 = 2_000_000_000, 1 => i64::MAX as u64;
    /// Fuel for start-up, `init` and all steps of one task together; WASM only.
    fuel_per_task: u64 = 1_000_000_000_000, 1 => i64::MAX as u64;
    /// Linear memory of all memories of the plugin together, bytes.
    memory_bytes: usize = 256 << 20, 64 << 10 => 1 << 40;
    /// Elements of all tables of the plugin together; WASM only.
    table_elements: usize = 1 << 20, 0 => u64::from(u32::MAX);
    /// Stack of the WASM code, bytes. A thread that runs sessions needs [`Limits::THREAD_STACK_BYTES`] more.
    stack_bytes: usize = 1 << 20, 64 << 10 => 64 << 20;
    /// Data that one call may hand over (command with debug series), bytes.
    output_bytes: usize = 16 << 20, 1 << 10 => 1 << 30;
    /// Log text of one task, bytes. What exceeds it is dropped.
    log_bytes: usize = 64 << 10, 0 => 1 << 30;
    /// Size of the plugin file, bytes.
    module_bytes: u64 = 64 << 20, 1 => 4 << 30;
    /// Memory of the compiler, bytes; WASM only.
    compile_bytes: usize = 2 << 30, 64 << 20 => 1 << 40;
    /// Processor time of the compiler, all its threads together, s; WASM only.
    compile_seconds: u64 = 120, 1 => 24 * 3600;
    /// Wall-clock time of one call, ms. It only ends what hangs: no score depends on it. A planner in a process of its own
    /// always has it; WASM code has it only if `wasm_watchdog` is set.
    watchdog_ms: u64 = 60_000, 1 => 24 * 3600 * 1000;
    /// Whether the watchdog also watches WASM code, which makes that about a fifth slower. It is not needed: fuel ends every call
    /// after the same instruction everywhere, and nothing that a planner can call blocks.
    wasm_watchdog: bool = false, 0 => 1;
}

impl Limits {
    /// The stack that the host's own code needs on a thread that runs sessions, bytes, in addition to
    /// [`stack_bytes`](Self::stack_bytes).
    pub const THREAD_STACK_BYTES: usize = 1 << 20;

    /// The stack of a thread that runs trials with planners under these limits, bytes.
    #[must_use]
    pub fn thread_stack_bytes(&self) -> usize {
        self.stack_bytes + 2 * Self::THREAD_STACK_BYTES
    }
}

impl Document for Limits {
    type File = Self;
    const KIND: &'static str = "limits";
    const FIELDS: &'static str = "docs/abi.md";

    fn from_file(limits: Self) -> Result<Self, Flaw> {
        limits.validate()?;
        Ok(limits)
    }

    fn parse(text: &str, file: &str) -> Result<Self, DocumentError> {
        // A file of comments leaves every field out.
        if text.lines().all(|line| line.trim().is_empty() || line.trim_start().starts_with('#')) {
            return Ok(Self::default());
        }
        document::parse(text, file)
    }
}

vb_files::document!(Limits);

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
        assert_eq!(error.to_string(), "stack_bytes: 1099511627776 must lie in 65536 to 67108864");
        assert!(Limits { fuel_per_step: 0, ..Limits::default() }.validate().is_err());
        // The engine counts fuel in signed 64 bits.
        assert!(Limits { fuel_init: u64::MAX, ..Limits::default() }.validate().is_err());
    }

    #[test]
    fn the_documented_defaults_are_those_of_the_code() {
        let text = include_str!("../../../../docs/abi.md");
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
