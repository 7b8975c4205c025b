//! `vb-harness inspect` and `plugin`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::FormatArgs;
use super::values::planner;

#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// The planner: a WASM file, a native library, or a command, which is started for it
    #[arg(long, value_name = "FILE|COMMAND", value_parser = planner())]
    pub(crate) plugin: PathBuf,
    #[command(flatten)]
    pub(crate) format: FormatArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// Make a project for a planner: source, build, README and CI
    New(NewArgs),
    /// Write a planner's name, version and parameters into its WASM file; Rust's export_planner! does it by itself
    Stamp(StampArgs),
    /// Put planners where they are found by their file names, whatever the working directory
    Install(InstallArgs),
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Name of the planner: a-z, 0-9, - and _
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Language that it is written in
    #[arg(long, value_name = "LANGUAGE", value_enum)]
    pub(crate) lang: Language,
    /// Folder for the project; default: NAME
    #[arg(long, value_name = "DIR")]
    pub(crate) dir: Option<PathBuf>,
    /// For Rust, where the SDK is: a folder or a git URL; default: the folder sdk beside the built-in tasks
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) sdk: Option<String>,
}

/// The language of a planner's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Rust, with the SDK.
    Rust,
    /// C, by zig's compiler.
    C,
    /// Python, with its interpreter in the plugin.
    Python,
    /// JavaScript, with the QuickJS engine in the plugin.
    Js,
}

#[derive(Debug, Args)]
pub(crate) struct StampArgs {
    /// The planner: a WASM component, or a core module as wit-bindgen leaves it
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// What the planner says of itself, as YAML: name, version, authors, about, control_period, params, needs,
    /// needs_without_maps, models
    #[arg(long, value_name = "FILE")]
    pub(crate) meta: PathBuf,
    /// Where to write it; default: in place
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct InstallArgs {
    /// Planners: WASM files and native libraries
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
}
