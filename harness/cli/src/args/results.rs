//! The command line of what shows results.

use std::path::PathBuf;

use clap::Args;

use super::MessageFormat;

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Directories of runs of one suite; several are compared task by task
    #[arg(value_name = "RUN", required = true)]
    pub(crate) runs: Vec<PathBuf>,
    /// Directory for the page, index.html
    #[arg(long, value_name = "DIR", required_unless_present_any = ["markdown", "csv", "parquet"])]
    pub(crate) out: Option<PathBuf>,
    /// Write the results as Markdown, for a paper or a pull request; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) markdown: Option<PathBuf>,
    /// Write every task of every run as CSV
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write every task of every run as Parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) parquet: Option<PathBuf>,
    /// How results are told
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) message_format: MessageFormat,
}
