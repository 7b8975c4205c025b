//! The worlds of entries as maps, with pictures that all entries on a suite share.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use vb_page::map::{LAYERS, Sources};
use vb_report::{MAP_SIDE, MapLinks, Report};
use vb_world::{Suite, TaskId, World};

use super::rank::Board;
use super::{Entry, REPORT};
use crate::SubmissionError;
use crate::files;

/// The folder of the worlds' pictures.
const WORLDS: &str = "worlds";
/// The number of pixels along the longer side of a small picture, which a page shows 96 pixels wide.
const SMALL_SIDE: usize = 128;

#[derive(Clone, Debug)]
pub(super) enum Maps {
    /// Each world that has one, in the order of the suite.
    Made(Vec<Made>),
    /// The suite is hidden: its worlds are nobody's but the owner's.
    Hidden,
    /// The suite isn't at hand.
    Missing,
}

impl Maps {
    /// The names of the worlds that have one.
    pub(super) fn names(&self) -> BTreeSet<String> {
        match self {
            Self::Made(all) => all.iter().map(|m| m.world.clone()).collect(),
            Self::Hidden | Self::Missing => BTreeSet::new(),
        }
    }
}

/// The map of a world, which lies at `maps/WORLD.html` beside the entry's page.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub(super) world: String,
    /// The map as a small picture for the entry's page.
    pub(super) thumbnail: String,
    /// Number of tasks that were done, and of all that were driven.
    pub(super) done: (u64, u64),
}

/// The names of hidden suites: those that an entry has scores on.
pub(super) fn hidden(boards: &[Board]) -> BTreeSet<String> {
    let entries = boards.iter().flat_map(|b| &b.entries);
    entries.filter_map(|r| Some(r.entry.holdout.as_ref()?.suite.clone())).collect()
}

/// Makes room for a new site.
pub(super) fn clear(out: &Path) -> Result<(), SubmissionError> {
    let folder = out.join(WORLDS);
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(SubmissionError::write(&folder))?;
    }
    Ok(())
}

/// Writes maps, and of each world the pictures once.
pub(super) struct Painter<'a> {
    /// The folder of the site.
    out: &'a Path,
    title: &'a str,
    painted: BTreeSet<PathBuf>,
}

impl<'a> Painter<'a> {
    pub(super) fn new(out: &'a Path, title: &'a str) -> Self {
        Self { out, title, painted: BTreeSet::new() }
    }

    /// The pictures of a world, as files whose names begin so, relative to the site's folder.
    fn paint(&mut self, suite: &Suite, world: &World) -> Result<String, SubmissionError> {
        let hash = suite.hash();
        let hash = hash.get(..12).unwrap_or(&hash);
        // Slopes and heights are those of the world as it was driven.
        let scale = if world.scale == 1.0 { String::new() } else { format!("-{}", world.scale) };
        let name = format!("{WORLDS}/{hash}{scale}/{}", world.id);
        if self.painted.insert(self.out.join(&name)) {
            let write =
                |layer: &str, png: &[u8]| files::write(&self.out.join(format!("{name}-{layer}.png")), png);
            for (layer, png) in LAYERS.iter().zip(&vb_page::map::pictures(world, MAP_SIDE).0) {
                write(layer, png)?;
            }
            write("small", &vb_page::map::ground(world, SMALL_SIDE))?;
        }
        Ok(name)
    }

    /// Makes the maps of an entry's worlds in its folder `own`, which lies two folders below that of the site.
    pub(super) fn maps(
        &mut self,
        entry: &Entry,
        suite: &Suite,
        report: &Report,
        replays: &BTreeSet<TaskId>,
        own: &Path,
    ) -> Result<Maps, SubmissionError> {
        let runs = report.runs();
        let driven: BTreeSet<&str> = runs.worlds.iter().map(|w| w.name.as_str()).collect();
        let worlds: Vec<&str> =
            suite.worlds().iter().map(|w| w.id.as_str()).filter(|id| driven.contains(id)).collect();
        let scale = entry.manifest.run.scale;
        let planner = vb_report::one_line(&entry.manifest.run.plugin.name, 60);
        let title = vb_report::one_line(self.title, 60);
        let to_report = format!("../{REPORT}");
        let mut made = Vec::with_capacity(worlds.len());
        for (k, id) in worlds.iter().enumerate() {
            let Ok(world) = suite.load_world(id) else {
                // Worlds that can't be read are not at hand.
                let maps = own.join("maps");
                return match fs::remove_dir_all(&maps) {
                    Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                        Err(SubmissionError::write(&maps)(e))
                    }
                    _ => Ok(Maps::Missing),
                };
            };
            let world = world.at_scale(scale);
            let pictures = self.paint(suite, &world)?;
            let map = report.map(&world)?;
            let links = MapLinks {
                above: vec![(&title, "../../../index.html"), (&planner, "../index.html#worlds")],
                report: &to_report,
                previous: k.checked_sub(1).map(|k| worlds[k]),
                next: worlds.get(k + 1).copied(),
                replays: replays.clone(),
                pictures: Some(Sources::files(&format!("../../../{pictures}"))),
            };
            files::write(&own.join("maps").join(format!("{id}.html")), map.page(&links).as_bytes())?;
            let done = entry.worlds.iter().find(|(w, _)| w.name == *id).map_or((0, 0), |(_, done)| *done);
            let label = format!("{id}: {} of {} tasks solved", done.0, done.1);
            let thumbnail = map.thumbnail(&format!("../../{pictures}-small.png"), &label);
            made.push(Made { world: (*id).to_owned(), thumbnail, done });
        }
        Ok(Maps::Made(made))
    }
}
