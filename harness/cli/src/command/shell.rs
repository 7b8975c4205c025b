//! `vb-harness completions` and `vb-harness man`: what shells and `man` know of the command line.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::error::CliError;
use crate::output;

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

/// Writes the script to stdout.
pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::documented(), "vb-harness", &mut script);
    // The generator for bash (clap_complete 4.6) takes the hyphen in the program's name for the beginning of a subcommand in one of
    // two places, and completes no subcommand then.
    let script = String::from_utf8_lossy(&script).replace("vb__subcmd__harness", "vb__harness");
    let mut out = std::io::stdout().lock();
    output::check(out.write_all(script.as_bytes()).and_then(|()| out.flush()));
    Ok(())
}

/// Writes a page for the program and for each command.
pub(crate) fn man(args: &ManArgs) -> Result<(), CliError> {
    let dir = &args.out;
    std::fs::create_dir_all(dir)
        .and_then(|()| clap_mangen::generate_to(Cli::documented(), dir))
        .map_err(|e| CliError::output(format!("cannot write man pages to {}: {e}", dir.display())))?;
    output::say(&format!(
        "wrote the man pages to {} (man -l {})",
        dir.display(),
        dir.join("vb-harness.1").display()
    ));
    Ok(())
}
