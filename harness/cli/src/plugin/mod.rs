//! `vb-harness plugin`: what authors of planners need beside running them.

mod meta;
mod new;
mod stamp;
mod template;

pub(crate) use new::new;
pub(crate) use stamp::stamp;
