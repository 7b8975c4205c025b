//! Fault codes: stable names of all errors that can end a task or reject a plugin, with their origin.

use std::fmt;
use std::str::FromStr;

/// The origin of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The planner: the task counts as failed.
    Planner,
    /// The harness or the machine: the task is not scored and can be re-run.
    Host,
    /// The simulation: it fails identically on every machine, so the task counts as failed, but is reported separately.
    Simulation,
}

macro_rules! codes {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $blame:ident;)*) => {
        /// The cause of a fault, with a name that is constant across versions. `docs/abi.md` contains the table.
        /// Records, messages and serde use the name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum FaultCode {
            $($(#[$doc])* $variant,)*
        }

        impl FaultCode {
            /// All codes.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The name in results and messages, e.g. `planner/out-of-fuel`.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The origin of the fault.
            #[must_use]
            pub fn blame(self) -> Blame {
                match self {
                    $(Self::$variant => Blame::$blame,)*
                }
            }
        }
    };
}

codes! {
    /// The WebAssembly code trapped.
    Trap = "planner/trap", Planner;
    /// The planner panicked.
    Panic = "planner/panic", Planner;
    /// `step` returned an error.
    Error = "planner/error", Planner;
    /// `init` returned an error.
    InitFailed = "planner/init-failed", Planner;
    /// A call, or the task, exceeded its fuel limit.
    OutOfFuel = "planner/out-of-fuel", Planner;
    /// The planner exceeded its limit of memory or table elements.
    OutOfMemory = "planner/out-of-memory", Planner;
    /// The call stack of the planner overflowed.
    StackOverflow = "planner/stack-overflow", Planner;
    /// The command of the planner is not finite, or its result is too large.
    InvalidOutput = "planner/invalid-output", Planner;
    /// The planner used an unsupported import or system call.
    ImportDenied = "planner/import-denied", Planner;
    /// The plugin was built for another interface version, or has another data layout.
    AbiMismatch = "planner/abi-mismatch", Planner;
    /// The process of a native or command planner exited.
    Crashed = "planner/crashed", Planner;
    /// A native or command planner exceeded its response time limit.
    Hung = "planner/hung", Planner;
    /// A native or command planner violated the protocol.
    Protocol = "planner/protocol", Planner;
    /// The plugin file does not exist.
    NotFound = "planner/not-found", Planner;
    /// The plugin file cannot be read.
    Unreadable = "planner/unreadable", Planner;
    /// The file is not a planner plugin.
    NotAPlugin = "planner/not-a-plugin", Planner;
    /// The plugin file is truncated or damaged.
    Damaged = "planner/damaged", Planner;
    /// The plugin's metadata is invalid.
    Metadata = "planner/metadata", Planner;
    /// The plugin file, or a part of it, exceeds its size limit.
    TooLarge = "planner/too-large", Planner;
    /// Compiling the plugin exceeds the limit of memory or processor time.
    TooCostly = "planner/too-costly", Planner;
    /// The engine or the system rejects the plugin's code.
    Unloadable = "planner/unloadable", Planner;
    /// The operating system denied a resource to the host.
    Machine = "host/machine", Host;
    /// A WASM call exceeded the wall-clock limit.
    Watchdog = "host/watchdog", Host;
    /// The process of a native planner cannot be started or sandboxed.
    Worker = "host/worker", Host;
    /// The harness panicked.
    HostPanic = "host/panic", Host;
    /// The simulation can't be set up for the task.
    Simulation = "host/simulation", Simulation;
    /// The simulation state is not finite.
    Diverged = "host/diverged", Simulation;
}

impl fmt::Display for FaultCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for FaultCode {
    type Err = String;

    /// Parses a code.
    ///
    /// # Errors
    /// Returns a message for an unknown code.
    fn from_str(name: &str) -> Result<Self, String> {
        let code = Self::ALL.iter().find(|code| code.name() == name);
        code.copied().ok_or_else(|| format!("there is no fault code {name:?}"))
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for FaultCode {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for FaultCode {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first cells of the table under "Faults" in docs/abi.md.
    fn documented() -> Vec<&'static str> {
        let text = include_str!("../../docs/abi.md");
        let table = text.lines().skip_while(|l| *l != "## Faults").skip_while(|l| !l.starts_with("| code"));
        table.skip(2).map_while(|l| l.strip_prefix("| `")?.split('`').next()).collect()
    }

    #[test]
    fn the_documented_codes_are_those_of_the_code() {
        let names: Vec<&str> = FaultCode::ALL.iter().map(|c| c.name()).collect();
        assert_eq!(documented(), names);
    }

    #[test]
    fn a_code_is_read_back_from_its_name_and_another_name_is_refused() {
        assert!(FaultCode::ALL.iter().all(|code| code.name().parse() == Ok(*code)));
        let refused = "planner/asleep".parse::<FaultCode>();
        assert_eq!(refused, Err("there is no fault code \"planner/asleep\"".to_owned()));
    }

    #[test]
    fn the_name_tells_who_is_to_blame() {
        for code in FaultCode::ALL {
            assert_eq!(code.name().starts_with("planner/"), code.blame() == Blame::Planner, "{code}");
        }
    }
}
