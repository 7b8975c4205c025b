//! `vb-harness plugin`: what authors of planners need beside running them.

mod install;
mod meta;
mod new;
mod stamp;
mod template;

use install::InstallArgs;
use new::NewArgs;
use stamp::StampArgs;

commands! {
    PluginCommand

    /// Create a planner project: source, build, README and CI
    New(NewArgs) => new::new,
    /// Write a planner's metadata into its WASM file (Rust's export_planner! does this during the build)
    Stamp(StampArgs) => stamp::stamp,
    /// Install planners, for use by file name from any working directory
    Install(InstallArgs) => install::install,
}
