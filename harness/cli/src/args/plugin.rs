//! `vb-harness inspect` and `plugin`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand, ValueEnum};

use super::{FormatArgs, PluginArgs};

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    pub(crate) plugin: PluginArgs,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// Create a planner project: source, build, README and CI
    New(NewArgs),
    /// Write a planner's metadata into its WASM file (Rust's export_planner! does this during the build)
    Stamp(StampArgs),
    /// Install planners, for use by file name from any working directory
    Install(InstallArgs),
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Planner name: a-z, 0-9, - and _
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Programming language
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub(crate) lang: Language,
    /// Directory for the project; default: NAME
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
    /// For Rust: the SDK, a directory or a git URL; default: the directory sdk next to the built-in tasks
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) sdk: Option<String>,
}

/// The language of a planner's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Rust, with the SDK.
    Rust,
    /// C, compiled with zig.
    C,
    /// Python, with its interpreter in the plugin.
    Python,
    /// Python with NumPy, as a process, which is not ranked.
    Numpy,
    /// JavaScript, with the QuickJS engine in the plugin.
    Js,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("place").required(true)))]
pub(crate) struct StampArgs {
    /// Planner: a WASM component, or a core module built with wit-bindgen
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Metadata as YAML: name, version, authors, about, control_period, params, needs, needs_without_maps, models
    #[arg(long, value_name = "FILE")]
    pub(crate) meta: PathBuf,
    /// Output file
    #[arg(short, long, value_name = "FILE", group = "place")]
    pub(crate) out: Option<PathBuf>,
    /// Change FILE itself
    #[arg(long, group = "place")]
    pub(crate) in_place: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InstallArgs {
    /// Planners: WASM files and native libraries
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Replace installed planners with the same file names
    #[arg(long)]
    pub(crate) force: bool,
}
