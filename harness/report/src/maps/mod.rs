//! Maps: each world with the ways of all runs, and where and why they ended.

mod page;

use std::collections::BTreeSet;

use vb_record::RunReader;
use vb_world::World;

use crate::runs::Row;
use crate::{Report, ReportError};

/// The greatest distance of a sample from the line that is drawn, m at scale 1: a fifth of a vehicle's width.
const FLAT: f64 = 0.1;

/// What lies beside a map: it is `maps/WORLD.html`, the report `index.html`, and a replay `replays/WORLD/TASK.html`.
#[derive(Clone, Debug, Default)]
pub struct MapLinks<'a> {
    /// The world before this one of which there is a map.
    pub previous: Option<&'a str>,
    /// The world after it.
    pub next: Option<&'a str>,
    /// The tasks of which there is a replay.
    pub replays: BTreeSet<String>,
}

/// The way of a task in a run.
struct Way<'a> {
    /// The index of the run.
    run: usize,
    row: &'a Row,
    /// The places from the start to the end, x and y, m; none if the run kept no trace of it.
    points: Vec<[f64; 2]>,
}

impl Report {
    /// A page with the map of a world, scaled as the runs had it, and on it the ways of all runs.
    ///
    /// # Errors
    /// Returns an error if a trace can't be read.
    pub fn map(&self, world: &World, links: &MapLinks<'_>) -> Result<String, ReportError> {
        let prefix = format!("{}/", world.id);
        let mut ways = Vec::new();
        for (run, own) in self.runs.runs.iter().enumerate() {
            let reader = RunReader::open(&own.dir)?;
            for row in own.rows.iter().filter(|r| r.task.starts_with(&prefix)) {
                let points = if reader.has_trace(&row.task) {
                    let samples = reader.trace(&row.task)?.samples;
                    let all: Vec<[f64; 2]> = samples.iter().map(|s| [s.x, s.y]).collect();
                    vb_map::simplified(&all, FLAT * world.scale)
                } else {
                    Vec::new()
                };
                ways.push(Way { run, row, points });
            }
        }
        Ok(page::of_world(self, world, &ways, links))
    }
}
