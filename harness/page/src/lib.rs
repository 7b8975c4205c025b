//! Pages that need no other file and no network: reports, albums, validations, replays, leaderboards.
//!
//! What they share is their frame with its policy ([`Page`]), text that is safe in them ([`escape`], [`json`]), the style and the
//! script of tables ([`TABLE_STYLE`], [`SORTED_TABLES`]) and the axes of plots ([`plot`]).

mod document;
pub mod plot;
mod text;

pub use document::Page;
pub use text::{escape, grouped, json, number, p_value, signed};

/// The style of pages of tables and plots, in light and dark.
pub const TABLE_STYLE: &str = include_str!("tables.css");

/// A script that sorts each `table.sortable` by a click on a column's head, but those of class `fixed`: by the `data-v` of its
/// cells, else by their text.
pub const SORTED_TABLES: &str = include_str!("tables.js");
