//! The records of runs.

use std::path::Path;

use serde_json::Value;

use crate::run::Failure;

/// The records of a run in this folder, in the order of the tasks' names, whatever order they ended in.
pub(crate) fn records(run: &Path) -> Result<Vec<Value>, Failure> {
    let file = run.join("tasks.jsonl");
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(&file).map_err(|e| wrong(&e))?;
    let mut records: Vec<Value> =
        text.lines().map(serde_json::from_str).collect::<Result<_, _>>().map_err(|e| wrong(&e))?;
    records.sort_by(|a, b| a["task"].as_str().cmp(&b["task"].as_str()));
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_come_in_the_order_of_tasks_and_what_is_none_is_told_with_its_file() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("tasks.jsonl");
        let told = records(dir.path()).unwrap_err().to_string();
        assert!(told.starts_with(&file.display().to_string()), "{told}");
        std::fs::write(&file, "{\"task\":\"w002/t00\"}\n{\"task\":\"w001/t01\"}\n").unwrap();
        let found = records(dir.path()).unwrap();
        assert_eq!((&found[0]["task"], &found[1]["task"]), (&"w001/t01".into(), &"w002/t00".into()));
        std::fs::write(&file, "{\"task\":").unwrap();
        assert!(records(dir.path()).unwrap_err().to_string().contains("tasks.jsonl"));
    }
}
