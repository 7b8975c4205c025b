//! Fault codes: stable names of everything that can end a task or refuse a plugin, and who is to blame.

use std::fmt;
use std::str::FromStr;

/// The part that is to blame for a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The planner is to blame: its task counts as failed.
    Planner,
    /// The harness or the machine is to blame: the task counts for nothing and can be run again.
    Host,
    /// The simulation is to blame: it fails alike on every machine, so the task counts as failed, but apart.
    Simulation,
}

macro_rules! codes {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $blame:ident;)*) => {
        /// The cause of a fault, by a name that is the same in all versions. `docs/abi.md` has the table. Records,
        /// messages and serde have it as text.
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

            /// The part that is to blame.
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
    /// A call, or the task, used up its fuel.
    OutOfFuel = "planner/out-of-fuel", Planner;
    /// The planner was refused memory or table elements and gave up.
    OutOfMemory = "planner/out-of-memory", Planner;
    /// The planner's calls are nested too deeply.
    StackOverflow = "planner/stack-overflow", Planner;
    /// The planner gave a command that is not a number, or a result that is too large.
    InvalidOutput = "planner/invalid-output", Planner;
    /// The planner used something that planners don't get.
    ImportDenied = "planner/import-denied", Planner;
    /// The plugin was built for another version of the interface, or lays its data out in another way.
    AbiMismatch = "planner/abi-mismatch", Planner;
    /// The process of a native or command planner died.
    Crashed = "planner/crashed", Planner;
    /// A native or command planner didn't answer in time.
    Hung = "planner/hung", Planner;
    /// A native or command planner sent something that the protocol doesn't know.
    Protocol = "planner/protocol", Planner;
    /// There is no such plugin file.
    NotFound = "planner/not-found", Planner;
    /// The plugin file can't be read.
    Unreadable = "planner/unreadable", Planner;
    /// The file is not a planner plugin.
    NotAPlugin = "planner/not-a-plugin", Planner;
    /// The plugin file is truncated or damaged.
    Damaged = "planner/damaged", Planner;
    /// The plugin's metadata can't be read.
    Metadata = "planner/metadata", Planner;
    /// The plugin file, or something in it, is larger than it may be.
    TooLarge = "planner/too-large", Planner;
    /// Compiling the plugin takes more memory or processor time than it may.
    TooCostly = "planner/too-costly", Planner;
    /// The engine or the system refuses the plugin's code.
    Unloadable = "planner/unloadable", Planner;
    /// The operating system refused what the host needs.
    Machine = "host/machine", Host;
    /// A WASM call took too much wall-clock time for its fuel.
    Watchdog = "host/watchdog", Host;
    /// The process for a native planner can't be started or confined.
    Worker = "host/worker", Host;
    /// The harness panicked.
    HostPanic = "host/panic", Host;
    /// The simulation can't be set up for the task.
    Simulation = "host/simulation", Simulation;
    /// The simulation left the numbers that a state can have.
    Diverged = "host/diverged", Simulation;
}

impl fmt::Display for FaultCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for FaultCode {
    type Err = String;

    /// The code of this name.
    ///
    /// # Errors
    /// Returns a message if there is no such code.
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
