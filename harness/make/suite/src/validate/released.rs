//! Suites that results may already name: whoever changes one gives it a new version.

use serde::Deserialize;
use vb_files::yaml;
use vb_world::Suite;

/// `tasks/released.yaml`, the list that this build was made with.
const LIST: &str = include_str!("../../../../../tasks/released.yaml");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(rename = "schema")]
    _schema: u32,
    suites: Vec<Released>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Released {
    name: String,
    version: String,
    sha256: String,
}

/// The hash under which a suite of this name and version was released, if it was.
pub(super) fn hash_of(suite: &Suite) -> Option<String> {
    let list: List = yaml::parse(LIST).ok()?;
    let meta = suite.meta();
    let is_meant = |r: &&Released| r.name == meta.name && r.version == meta.version;
    list.suites.iter().find(is_meant).map(|r| r.sha256.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_suites_in_tasks_are_those_that_were_released() {
        let list: List = yaml::parse(LIST).unwrap();
        assert!(list.suites.len() >= 3);
        for name in ["granular", "smoke", "testbed", "vb-100"] {
            let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
            let suite = Suite::open(tasks.join(name)).unwrap();
            assert_eq!(hash_of(&suite), Some(suite.hash()), "a changed suite needs a new version");
        }
    }
}
