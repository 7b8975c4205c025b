//! The process that runs a native planner: its sandbox, and the protocol between it and the harness.
//!
//! Native code can do to its process whatever it likes, so it never runs in the harness's: the harness starts itself
//! again with a hidden subcommand, which ends in [`serve`]. That process confines itself ([`sandbox`]), opens the
//! library, and answers [`protocol`] messages. Planners in any language can speak the same protocol as a command of
//! their own (`docs/worker-protocol.md`).

#[cfg(unix)]
mod calls;
#[cfg(unix)]
mod library;
#[cfg(unix)]
mod log;
pub mod protocol;
pub mod sandbox;
#[cfg(unix)]
mod serve;

#[cfg(unix)]
pub use serve::serve;

/// Runs the worker, which needs a Unix system: says so and ends with code 1.
#[cfg(not(unix))]
pub fn serve() -> std::process::ExitCode {
    use std::io::Write as _;
    // There is nobody else to tell.
    let _ = writeln!(std::io::stderr(), "planner worker: native planners run on Unix systems only");
    std::process::ExitCode::FAILURE
}
