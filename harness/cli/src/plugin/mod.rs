//! `vb-harness plugin`: what authors of planners need beside running them.

mod install;
mod meta;
mod new;
mod stamp;
mod template;

use crate::args::PluginCommand;
use crate::error::CliError;

impl PluginCommand {
    /// Does what it says.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        match self {
            Self::New(args) => new::new(args),
            Self::Stamp(args) => stamp::stamp(args),
            Self::Install(args) => install::install(args),
        }
    }
}
