//! `vb-harness plugin`: what authors of planners need beside running them.

mod meta;
mod stamp;

pub(crate) use stamp::stamp;
