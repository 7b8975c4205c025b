//! The process that runs a native planner, on its own: what `vb-harness` does under its hidden subcommand. The tests
//! and benches of this crate use it.

use std::process::ExitCode;

fn main() -> ExitCode {
    vb_worker::serve()
}
