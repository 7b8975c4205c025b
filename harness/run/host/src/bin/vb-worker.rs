//! The processes that run native planners and compile WASM, on their own: what `vb-harness` does under its hidden
//! subcommands. The tests and benches of this crate use it.

use std::process::ExitCode;

fn main() -> ExitCode {
    vb_host::serve_as_worker().unwrap_or(ExitCode::FAILURE)
}
