//! Runs as something to look at and to publish: statistics, one page, tables.

pub mod statistics;
