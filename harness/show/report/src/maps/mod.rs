//! Maps: each world with the ways of all runs, and where and why they ended.

mod page;
mod thumbnail;

use std::collections::BTreeSet;

use vb_page::map::Sources;
use vb_record::RunReader;
use vb_world::{TaskId, World};

use crate::runs::Row;
use crate::{Report, ReportError};

/// The style of [`WorldMap::thumbnail`], beside [`vb_page::TABLE_STYLE`].
pub const THUMBNAIL_STYLE: &str = include_str!("thumbnail.css");

/// The number of pixels along the longer side of the ground's picture on a map.
pub const MAP_SIDE: usize = 640;

/// The greatest distance of a sample from the line that is drawn, m at scale 1: a fifth of a vehicle's width.
const FLAT: f64 = 0.1;

/// What lies beside a map, which is `maps/WORLD.html`; a replay is `replays/WORLD/TASK.html`.
#[derive(Clone, Debug, Default)]
pub struct MapLinks<'a> {
    /// Pages above the report: what each is called, and where it lies, relative to the map.
    pub above: Vec<(&'a str, &'a str)>,
    /// The address of the report, relative to the map.
    pub report: &'a str,
    /// The world before this one of which there is a map.
    pub previous: Option<&'a str>,
    /// The world after it.
    pub next: Option<&'a str>,
    /// The tasks of which there is a replay.
    pub replays: BTreeSet<TaskId>,
    /// Where the pictures of the ground lie; in the page itself if it isn't said.
    pub pictures: Option<Sources>,
}

/// The way of a task in a run.
pub(crate) struct Way<'a> {
    pub(crate) run: usize,
    pub(crate) row: &'a Row,
    /// The places from the start to the end, x and y, m; none if the run kept no trace of it.
    pub(crate) points: Vec<[f64; 2]>,
    /// The goal of the task, m; none if the world has no such task.
    goal: Option<[f64; 2]>,
}

impl Way<'_> {
    /// Where its outcome is shown, m: where it ended, by the trace or else by the record, or else, which is `false`, at the goal.
    pub(crate) fn end(&self) -> Option<([f64; 2], bool)> {
        let last = self.points.last().copied().or_else(|| Some(self.row.metrics?.end()));
        last.map(|p| (p, true)).or_else(|| self.goal.map(|p| (p, false)))
    }
}

/// A world with what runs did in it.
pub struct WorldMap<'a> {
    pub(crate) report: &'a Report,
    pub(crate) world: &'a World,
    pub(crate) ways: Vec<Way<'a>>,
}

impl Report {
    /// The map of a world, scaled as the runs had it, with the ways of all runs.
    pub fn map<'a>(&'a self, world: &'a World) -> Result<WorldMap<'a>, ReportError> {
        let mut ways = Vec::new();
        for (run, own) in self.runs.runs.iter().enumerate() {
            let reader = RunReader::open(&own.dir)?;
            for row in own.rows.iter().filter(|r| r.task.world() == world.id) {
                let points = if reader.has_trace(&row.task)? {
                    let samples = reader.trace(&row.task)?.samples;
                    let all: Vec<[f64; 2]> = samples.iter().map(|s| [s.x, s.y]).collect();
                    vb_page::map::simplified(&all, FLAT * world.scale)
                } else {
                    Vec::new()
                };
                let goal = world.task(row.task.task()).map(|t| t.goal);
                ways.push(Way { run, row, points, goal });
            }
        }
        Ok(WorldMap { report: self, world, ways })
    }
}

impl WorldMap<'_> {
    #[must_use]
    pub fn page(&self, links: &MapLinks<'_>) -> String {
        page::of_world(self, links)
    }

    /// The map as a small picture, an element `svg` with the ends of all ways in the colours of the outcomes: filled where they
    /// are known, rings at the goals of tasks of which neither trace nor record says it. `ground` is where the picture of [`vb_page::map::ground`] lies,
    /// relative to the page, and `label` is told instead of it.
    #[must_use]
    pub fn thumbnail(&self, ground: &str, label: &str) -> String {
        thumbnail::of_world(self, ground, label)
    }
}
