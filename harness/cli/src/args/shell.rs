//! `vb-harness completions` and `vb-harness man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_name = "SHELL", value_enum)]
    pub(crate) shell: Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Directory for the manual pages, e.g. ~/.local/share/man/man1
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}
