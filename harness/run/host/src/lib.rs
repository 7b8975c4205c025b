//! Loads planner plugins (WASM, native libraries, commands) and drives them within limits.
//!
//! [`inspect`] tells what a plugin says of itself without running it; [`Plugin::load`] makes it ready for any number
//! of workers; [`Plugin::external`] is for planners that run elsewhere; [`Plugin::start`] puts a fresh planner on a task, and [`Session::step`] drives it. What the planner
//! does wrong ends as a [`PlannerFault`], never as a panic. The interface itself is described in `docs/abi.md`.

mod abi;
mod error;
mod external;
mod fault;
mod hint;
mod inspect;
mod limits;
mod log;
mod native;
mod plugin;
mod process;
mod system;
mod wasm;

pub use abi::AbiVersion;
pub use error::{LoadError, ParamError};
pub use external::{External, ExternalLog, ExternalSession};
pub use fault::{FaultCause, PlannerFault, ProcessEnd, Resource};
pub use inspect::{imports, inspect};
pub use limits::Limits;
pub use log::LogSink;
pub use native::{ProcessOptions, serve_as_worker};
pub use plugin::{FuelMeter, Plugin, PluginKind, Session, resolve_params};
pub use vb_sdk::fault::{Blame, FaultCode};
pub use vb_sdk::metadata::{Metadata, ParamSpec};
pub use vb_worker::sandbox::SandboxReport;
