//! What the rules of generator, sites and test beds have in common.

use vb_files::document::within;
use vb_files::{Document, Flaw};

/// Most nodes along a side of a world that is made.
pub(crate) const MOST_NODES: usize = 4097;

/// The flaw of a field.
pub(crate) fn flaw(field: impl Into<String>, problem: impl Into<String>) -> Flaw {
    Flaw::new(field, problem)
}

/// Rules whose text is part of the program. Tests parse them all, so they have no flaw.
pub(crate) fn built_in<R: Document>(text: &str) -> R {
    R::parse(text, "default").unwrap_or_else(|e| unreachable!("built-in rules: {e}"))
}

/// A square of ground by its lengths, m: its side is so many patches, and the side of a patch so many distances between nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Square {
    /// Between nodes.
    pub(crate) resolution: f64,
    /// Side of a patch.
    pub(crate) patch: f64,
    /// Side of the square.
    pub(crate) side: f64,
}

impl Square {
    /// Whether each is a length and divides the next. Before their names in messages stands a prefix such as `bed.`.
    pub(crate) fn check(self, prefix: &str) -> Result<(), Flaw> {
        let Self { resolution, patch, side } = self;
        let lengths = [("resolution", resolution), ("patch", patch), ("side", side)];
        for (name, length) in lengths {
            within(&format!("{prefix}{name}"), length, 1e-3, 1e5)?;
        }
        for ((below, small), (name, large)) in [(lengths[0], lengths[1]), (lengths[1], lengths[2])] {
            if whole(large / small).is_none() {
                let problem = format!("{large} must be a multiple of {prefix}{below}, {small}");
                return Err(flaw(format!("{prefix}{name}"), problem));
            }
        }
        Ok(())
    }

    /// Nodes along a side.
    pub(crate) fn nodes(self) -> usize {
        // Each ratio is a whole number but for rounding, and so their product may be farther from one than either.
        self.patches() * whole(self.patch / self.resolution).unwrap_or(1) + 1
    }

    /// Patches along a side.
    pub(crate) fn patches(self) -> usize {
        whole(self.side / self.patch).unwrap_or(1)
    }
}

/// A ratio that is a whole number but for rounding, at least 1.
fn whole(ratio: f64) -> Option<usize> {
    let n = ratio.round();
    (n >= 1.0 && (ratio - n).abs() < 1e-9 * n).then_some(n as usize)
}
