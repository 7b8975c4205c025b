//! The versions of the planner interface that this harness hosts. The rules by which they change are in `docs/abi.md`.

use std::fmt;

/// A version of the planner interface that this harness hosts.
///
/// Whatever depends on the version matches on this, so that the compiler finds the places that a new one needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum AbiVersion {
    /// The first version, `sdk/wit/v1_0`.
    V1_0,
}

impl AbiVersion {
    /// The window: all versions that are hosted, oldest first.
    pub const SUPPORTED: &'static [Self] = &[Self::V1_0];
    /// The version that new planners are built for.
    pub const NEWEST: Self = Self::V1_0;

    /// The name of the version, which plugins are stamped with: its major and minor number.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::V1_0 => "1.0",
        }
    }

    /// The interface with functions that a WASM planner of this version may import.
    pub(crate) const fn host_interface(self) -> &'static str {
        match self {
            Self::V1_0 => "vertibench:planner/host@1.0.0",
        }
    }

    /// The version of this name; `None` if it is not in the window.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        Self::SUPPORTED.iter().copied().find(|version| version.name() == name)
    }

    /// The names of the window as a text, e.g. `1.0, 1.1`.
    #[must_use]
    pub fn window() -> String {
        Self::SUPPORTED.iter().map(|version| version.name()).collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for AbiVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What to do with a plugin of a version outside of the window.
pub(crate) fn advice(found: &str) -> String {
    let newest = AbiVersion::NEWEST.name();
    let newer = matches!((numbers(found), numbers(newest)), (Some(found), Some(newest)) if found > newest);
    let else_newer = if newer { ", or use a newer harness" } else { "" };
    format!("Rebuild it with vb-sdk {newest}{else_newer}")
}

fn numbers(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

/// The version that a metadata text is stamped with. It is found whatever else the text holds, so that a plugin of a
/// later version, whose metadata may have other rules, is refused for its version.
pub(crate) fn stamp(text: &[u8]) -> Option<&str> {
    let line = text.split(|b| *b == b'\n').find_map(|line| line.strip_prefix(b"abi: "))?;
    std::str::from_utf8(line).ok().map(|version| version.trim_end_matches('\r'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_window_is_in_order_and_ends_with_the_newest_which_is_the_sdks() {
        assert!(AbiVersion::SUPPORTED.is_sorted_by(|a, b| numbers(a.name()) < numbers(b.name())));
        assert_eq!(AbiVersion::SUPPORTED.last(), Some(&AbiVersion::NEWEST));
        assert_eq!(AbiVersion::NEWEST.name(), vb_sdk::ABI_VERSION);
        for version in AbiVersion::SUPPORTED {
            assert_eq!(AbiVersion::find(version.name()), Some(*version));
        }
        assert_eq!(AbiVersion::find("0.0"), None);
    }

    #[test]
    fn every_version_of_the_window_has_its_interface_and_golden_plugins() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
        for version in AbiVersion::SUPPORTED {
            let folder = root.join("sdk/wit").join(format!("v{}", version.name().replace('.', "_")));
            let wit = std::fs::read_to_string(folder.join("planner.wit")).unwrap();
            let package = version.host_interface().replace("/host@", "@");
            assert!(wit.contains(&format!("package {package};")), "{version}");
            let golden = root.join("tests/golden").join(format!("abi-{version}"));
            let files = std::fs::read_dir(golden).unwrap().map(|f| f.unwrap().path());
            assert!(files.filter(|f| f.extension().is_some_and(|e| e == "wasm")).count() > 0, "{version}");
        }
    }

    #[test]
    fn the_documented_window_is_that_of_the_code() {
        let text = include_str!("../../../../docs/abi.md");
        let table = text.lines().skip_while(|l| !l.starts_with("| harness | ")).skip(2);
        let last = table.take_while(|l| l.starts_with('|')).last().unwrap();
        assert_eq!(last.split('|').nth(2).unwrap().trim(), AbiVersion::window());
    }

    #[test]
    fn who_has_a_newer_plugin_may_use_a_newer_harness() {
        assert_eq!(advice("0.0"), "Rebuild it with vb-sdk 1.0");
        assert_eq!(advice("soon"), "Rebuild it with vb-sdk 1.0");
        // Numbers, not texts: 1.10 is after 1.9.
        for newer in ["1.1", "1.10", "2.0"] {
            assert_eq!(advice(newer), "Rebuild it with vb-sdk 1.0, or use a newer harness");
        }
    }

    #[test]
    fn the_stamp_is_found_in_metadata_that_cannot_be_read_otherwise() {
        assert_eq!(stamp(b"abi: 0.1\nname: x\n"), Some("0.1"));
        assert_eq!(stamp(b"name\n\xff\xfe\nabi: 7.3"), Some("7.3"));
        assert_eq!(stamp(b"about: abi: 9\n"), None);
        assert_eq!(stamp(b"abi: \xff\n"), None);
    }
}
