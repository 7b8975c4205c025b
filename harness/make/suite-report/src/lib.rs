//! The properties of a suite: measures it ([`statistics`]), draws it as a page with a map of every world ([`album`]),
//! checks whether it is fit to be driven ([`validate`]), and keeps who has done which task ([`proof`]).

pub mod album;
mod clearance;
pub mod proof;
pub mod statistics;
pub mod validate;
