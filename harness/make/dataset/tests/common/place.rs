//! A folder with a suite of one world, and episodes in it.

use std::path::PathBuf;

use vb_dataset::{Dtype, Ending, Episode, EpisodeInfo, Layout, Values};
use vb_score::Outcome;
use vb_world::{Suite, Terrain};

use crate::common;

pub const LAYOUT: Layout = Layout { wheels: 4, speed: true, goal: false, truth: false, crops: 0 };

/// An episode of two frames, in which every number is a thousandth of `k`.
pub fn episode(suite: &Suite, k: u64) -> Episode {
    let columns = LAYOUT.features().into_iter().map(|f| {
        let n = 2 * f.width();
        match f.dtype {
            Dtype::F32 => Values::F32(vec![0.001 * k as f32; n]),
            Dtype::I64 => Values::I64(vec![0; n]),
            Dtype::U8 => Values::U8(vec![0; n]),
            Dtype::Bool => Values::Bool((0..n).map(|row| f.name == "next.done" && row == 1).collect()),
        }
    });
    let world = &suite.worlds()[0];
    let info = EpisodeInfo {
        drive: k,
        world: world.id.clone(),
        world_hash: world.sha256.clone(),
        outcome: Ending::Decided(Outcome::Rollover),
        terrain: Terrain::Rigid,
        state_hash: format!("{k:016x}"),
        ..EpisodeInfo::default()
    };
    Episode { info, frames: 2, columns: columns.collect() }
}

pub struct Place {
    pub dir: tempfile::TempDir,
    pub suite: Suite,
}

impl Place {
    pub fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        let suite = common::suite(&dir.path().join("suite"));
        Self { dir, suite }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }
}
