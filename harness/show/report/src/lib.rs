//! Runs as something to look at and to publish: statistics, one page, tables.
//!
//! [`Runs`] reads run directories line by line, [`Report`] computes everything that is told of them, and gives it as a page
//! that needs nothing else, as Markdown, or writes every task as CSV or Parquet. Texts of planners – names, reasons – are
//! foreign: they reach the page as text and never as markup.

mod compare;
mod drawing;
mod error;
mod failures;
mod figures;
mod headline;
mod json;
mod latex;
mod maps;
mod markdown;
mod page;
mod print;
mod ranking;
mod report;
mod robustness;
mod runs;
pub mod statistics;
mod sweep;
mod table;
mod verdict;

pub use compare::{Comparison, Pair};
pub use error::ReportError;
pub use figures::{Estimate, Figures, Measure, RunFigures, Split, heat};
pub use maps::{MAP_SIDE, MapLinks, THUMBNAIL_STYLE, WorldMap};
pub use print::{Paper, PaperError, PaperFigure};
pub use ranking::{Place, Ranking};
pub use report::{Beside, Report};
pub use robustness::{Line, Point, Robustness};
pub use runs::{Row, Run, Runs, WorldLabels, one_line};
pub use sweep::{Sweep, SweepRow};
pub use table::{write_csv, write_parquet};
pub use verdict::{Difference, LEVEL, Verdict};
