//! The state hashes behind the tables: by them anybody can verify a part of the results without driving all of them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::root;
use crate::run::Failure;

/// State hash of each task, by its name.
pub(super) type Hashes = BTreeMap<String, String>;

/// The file of a course.
fn file(course: &str) -> PathBuf {
    root().join("docs/results").join(format!("{course}.csv"))
}

/// The state hashes of a run.
pub(super) fn of_run(run: &Path) -> Result<Hashes, Failure> {
    let file = run.join("tasks.jsonl");
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(&file).map_err(|e| wrong(&e))?;
    let mut hashes = Hashes::new();
    for line in text.lines() {
        let record: Value = serde_json::from_str(line).map_err(|e| wrong(&e))?;
        let field =
            |name: &str| record[name].as_str().map(str::to_owned).ok_or_else(|| wrong(&format!("no {name}")));
        hashes.insert(field("task")?, field("state_hash")?);
    }
    Ok(hashes)
}

/// Writes the hashes of the runs of a course, a column each.
pub(super) fn write(course: &str, runs: &[(String, Hashes)]) -> Result<(), Failure> {
    let file = file(course);
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    std::fs::create_dir_all(file.parent().unwrap_or(&file)).map_err(|e| wrong(&e))?;
    std::fs::write(&file, table(runs)).map_err(|e| wrong(&e))
}

/// The hashes of the runs of a course, by the names of their columns; none if the course has no file.
pub(super) fn read(course: &str) -> Result<Option<BTreeMap<String, Hashes>>, Failure> {
    let file = file(course);
    if !file.exists() {
        return Ok(None);
    }
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(&file).map_err(|e| wrong(&e))?;
    parsed(&text)
        .map(Some)
        .ok_or_else(|| wrong(&"not a table with a task and a hash for each run in each line"))
}

fn table(runs: &[(String, Hashes)]) -> String {
    let mut text = std::iter::once("task")
        .chain(runs.iter().map(|(name, _)| name.as_str()))
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    let tasks: std::collections::BTreeSet<&String> =
        runs.iter().flat_map(|(_, hashes)| hashes.keys()).collect();
    for task in tasks {
        text.push_str(task);
        for (_, hashes) in runs {
            let _ = write!(text, ",{}", hashes.get(task).map_or("", String::as_str));
        }
        text.push('\n');
    }
    text
}

fn parsed(text: &str) -> Option<BTreeMap<String, Hashes>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next()?.strip_prefix("task,")?.split(',').collect();
    let mut runs: BTreeMap<String, Hashes> =
        names.iter().map(|name| ((*name).to_owned(), Hashes::new())).collect();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let (task, hashes) = cells.split_first()?;
        if hashes.len() != names.len() {
            return None;
        }
        for (name, hash) in names.iter().zip(hashes).filter(|(_, hash)| !hash.is_empty()) {
            runs.get_mut(*name)?.insert((*task).to_owned(), (*hash).to_owned());
        }
    }
    Some(runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_read_back_as_they_were_written() {
        let hashes = |of: &[(&str, &str)]| {
            of.iter().map(|(t, h)| ((*t).to_owned(), (*h).to_owned())).collect::<Hashes>()
        };
        let runs = [
            ("pid".to_owned(), hashes(&[("w001/t00", "0123456789abcdef"), ("w001/t01", "00")])),
            ("pid-speed=3".to_owned(), hashes(&[("w001/t01", "ff")])),
        ];
        let text = table(&runs);
        assert_eq!(text, "task,pid,pid-speed=3\nw001/t00,0123456789abcdef,\nw001/t01,00,ff\n");
        assert_eq!(parsed(&text), Some(runs.into_iter().collect()));
        assert_eq!(parsed("task,pid\nw001/t00\n"), None);
    }
}
