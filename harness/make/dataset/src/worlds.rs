//! Worlds of datasets: parts of a suite, and several suites in one.

use std::collections::BTreeMap;
use std::path::Path;

use vb_world::{Suite, SuiteMeta, SuiteWriter, World};

use crate::error::DatasetError;

/// A suite of some of another's worlds, in a folder that must not exist or be empty.
pub(crate) fn subset(of: &Suite, worlds: &[&str], dir: &Path) -> Result<Suite, DatasetError> {
    let mut writer = SuiteWriter::create(dir, of.meta().clone())?;
    for info in of.worlds().iter().filter(|w| worlds.contains(&w.id.as_str())) {
        writer.add(&of.load_world(&info.id)?)?;
    }
    Ok(writer.finish()?)
}

/// The names that worlds have in a suite of several, by the number of their own suite and their name there.
pub(crate) type Names = BTreeMap<(usize, String), String>;

/// The worlds of several suites in one, and the name that each has there, by the suite's number and its name. The same world in
/// two suites is one.
pub(crate) fn union(suites: &[Suite], dir: &Path) -> Result<(Suite, Names), DatasetError> {
    let first = suites[0].meta();
    let description = "Training worlds of several suites.".to_owned();
    let meta = SuiteMeta { name: "training-merged".into(), description, ..first.clone() };
    let mut writer = SuiteWriter::create(dir, meta)?;
    let (mut names, mut by_hash) = (Names::new(), BTreeMap::<String, String>::new());
    for (k, suite) in suites.iter().enumerate() {
        for info in suite.worlds() {
            let own = match by_hash.get(&info.sha256) {
                Some(own) => own.clone(),
                None => {
                    let own = format!("w{:03}", by_hash.len() + 1);
                    writer.add(&World { id: own.clone(), ..suite.load_world(&info.id)? })?;
                    by_hash.insert(info.sha256.clone(), own.clone());
                    own
                }
            };
            names.insert((k, info.id.clone()), own);
        }
    }
    Ok((writer.finish()?, names))
}
