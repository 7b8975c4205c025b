//! The run store: run.json, tasks.jsonl, traces.
