//! Datasets of driving to look at: a page of the whole ([`Overview`]), and the replay of a single episode ([`clip`]).

mod chart;
mod clip;
mod figures;
mod page;

pub use clip::clip;
pub use figures::{Figures, Histogram, QUANTITIES, Quantity};
pub use page::{Clip, Overview, examples};
