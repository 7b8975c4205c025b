//! Failures: the last seconds before them.

use vb_score::Outcome;

use crate::episode::{Ending, Episode, EpisodeInfo};
use crate::error::DatasetError;
use crate::feature::{Feature, Values};
use crate::reader::Dataset;
use crate::writer::DatasetWriter;

/// The seconds before a failure that are looked at and kept, as in the paper.
pub const SECONDS: f64 = 10.0;

/// Whether an episode ended as the paper's failures do: rolled over, or stuck.
pub(crate) fn is_failure(info: &EpisodeInfo) -> bool {
    matches!(info.outcome, Ending::Decided(Outcome::Rollover | Outcome::Stuck))
}

impl Episode {
    /// The last frames of an episode, as an episode of its own.
    #[must_use]
    pub(crate) fn tail(&self, features: &[Feature], frames: usize) -> Self {
        let first = self.frames.saturating_sub(frames);
        let columns = features.iter().zip(&self.columns).map(|(f, all)| {
            let mut own = Values::new(f.dtype);
            own.append(all, first * f.width()..self.frames * f.width());
            own
        });
        let mut tail =
            Self { info: self.info.clone(), frames: self.frames - first, columns: columns.collect() };
        tail.info.distance_m = tail.way(features);
        tail
    }

    /// The length of the way from frame to frame, m.
    fn way(&self, features: &[Feature]) -> f64 {
        let view = self.view(features);
        let step = |k: usize| {
            let (a, b) = (view.state(k - 1), view.state(k));
            (0..3).map(|i| (b[i] - a[i]) * (b[i] - a[i])).sum::<f64>().sqrt()
        };
        (1..self.frames).map(step).sum()
    }
}

/// Adds the last seconds before each failure of a dataset; how many there were.
pub fn failures(of: &Dataset, writer: &mut DatasetWriter, seconds: f64) -> Result<usize, DatasetError> {
    let header = of.header();
    let (hz, name) = (f64::from(header.hz), header.name.clone());
    let frames = (seconds * header.scale.sqrt() * hz).round() as usize;
    let mut found = 0;
    for (index, episode) in of.episodes().enumerate() {
        let episode = episode?;
        if !is_failure(&episode.info) {
            continue;
        }
        found += 1;
        let mut clip = episode.tail(of.features(), frames);
        let from = (episode.frames - clip.frames) as f64 / hz;
        clip.info.origin = format!("{name}: episode {index} from {from:.1} s");
        clip.info.drive = index as u64;
        // The hash is that of the whole drive.
        clip.info.state_hash = String::new();
        writer.add(&clip)?;
    }
    Ok(found)
}
