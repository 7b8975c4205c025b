//! Suites that results may already name: whoever changes one gives it a new version.

use serde::Deserialize;
use vb_files::yaml;
use vb_world::SuiteMeta;

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

/// The hash under which a suite of this name and version was released; `None` if it was not released.
///
/// # Errors
/// Returns the problem if the list can't be read.
pub(super) fn hash_of(meta: &SuiteMeta) -> Result<Option<String>, String> {
    hash_in(LIST, meta)
}

fn hash_in(list: &str, meta: &SuiteMeta) -> Result<Option<String>, String> {
    let list: List = yaml::parse(list)
        .map_err(|e| format!("tasks/released.yaml of this build: {}: {}", e.field, e.problem))?;
    let released = list.suites.into_iter().find(|r| r.name == meta.name && r.version == meta.version);
    Ok(released.map(|r| r.sha256))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use vb_world::Suite;

    #[test]
    fn the_suites_in_tasks_are_those_that_were_released() {
        let list: List = yaml::parse(LIST).unwrap();
        assert!(list.suites.len() >= 3);
        for name in ["granular", "smoke", "testbed", "vb-100"] {
            let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
            let suite = Suite::open(tasks.join(name)).unwrap();
            let released = hash_of(suite.meta()).unwrap();
            assert_eq!(released, Some(suite.hash()), "a changed suite needs a new version");
        }
    }

    #[test]
    fn a_list_that_cannot_be_read_is_an_error() {
        let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/smoke");
        let smoke = Suite::open(smoke).unwrap();
        let error = hash_in(&LIST.replacen("sha256:", "sha265:", 1), smoke.meta()).unwrap_err();
        assert!(error.contains("tasks/released.yaml") && error.contains("sha265"), "{error}");
    }
}
