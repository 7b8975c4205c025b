//! The kind of a run's planner.

use serde::{Deserialize, Serialize};

/// The kind of a planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PluginKind {
    /// The planner is WebAssembly, sandboxed and metered.
    Wasm,
    /// The planner is a native library, in a sandboxed process of its own.
    Native,
    /// The planner is a command that the user gave.
    Command,
    /// The planner is a ROS 2 node that the user started.
    Ros,
    /// The recorded commands of a run replace a planner.
    Recording,
}

impl PluginKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Wasm, Self::Native, Self::Command, Self::Ros, Self::Recording];

    /// The name as written in run.json.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wasm => "wasm",
            Self::Native => "native",
            Self::Command => "command",
            Self::Ros => "ros",
            Self::Recording => "recording",
        }
    }
}

impl std::fmt::Display for PluginKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_run_json_and_others_are_refused() {
        for kind in PluginKind::ALL {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
            assert_eq!(serde_json::from_value::<PluginKind>(kind.name().into()).unwrap(), kind);
        }
        let error = serde_json::from_value::<PluginKind>("wams".into()).unwrap_err().to_string();
        assert!(error.contains("wams") && error.contains("wasm"), "{error}");
    }
}
