//! Pages that need no other file and no network: reports, albums, validations, replays, leaderboards.
//!
//! What they share is their frame with its policy ([`Page`]), text that is safe in them ([`escape`], [`json`]), the style and the
//! script of tables ([`TABLE_STYLE`], [`SORTED_TABLES`]) and the axes of plots ([`plot`]).

mod document;
pub mod map;
#[cfg(test)]
mod palette;
pub mod plot;
mod print;
mod text;

pub use document::Page;
pub use print::print_style;
pub use text::{escape, grouped, json, number, p_value, rounded, signed};

/// The style of pages of tables and plots, in light and dark.
pub const TABLE_STYLE: &str = concat!(include_str!("tables.css"), include_str!("plots.css"));

/// The part of [`TABLE_STYLE`] that plots need.
pub const PLOT_STYLE: &str = include_str!("plots.css");

/// Number of colours that [`TABLE_STYLE`] has for series: `--c0` and so on, with the classes `s0` (stroke), `f0` (fill) and `b0`
/// (background). They are Okabe and Ito's hues (2008), moved so that they stand out in light and dark and stay apart for
/// colour-blind eyes; a test measures both.
pub const SERIES_COLOURS: usize = 8;

/// A script that sorts each `table.sortable` by a click on a column's head, but those of class `fixed`: by the `data-v` of its
/// cells, else by their text.
pub const SORTED_TABLES: &str = include_str!("tables.js");
