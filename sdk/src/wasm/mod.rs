//! Planners as WASM: exports a planner as the component `vertibench:planner/guest`.

#[rustfmt::skip]
mod convert;

use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Once;

use crate::{LogLevel, Planner};
use bindings::exports::vertibench::planner::guest;
use bindings::vertibench::planner::{host, types};

#[rustfmt::skip]
#[allow(missing_docs, unreachable_pub, clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod bindings;
pub use bindings::export;

pub(crate) fn log(level: LogLevel, message: &str) {
    let level = match level {
        LogLevel::Error => types::LogLevel::Error,
        LogLevel::Warn => types::LogLevel::Warn,
        LogLevel::Info => types::LogLevel::Info,
        LogLevel::Debug => types::LogLevel::Debug,
    };
    host::log(level, message);
}

/// A panic is a trap in a WASM guest; its text reaches the harness as a log line before the trap.
fn install_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|info| log(LogLevel::Error, &info.to_string()))));
}

/// The exported interface of a planner `P`.
#[derive(Debug)]
pub struct Guest<P>(PhantomData<P>);

/// The exported resource of a planner `P`.
#[derive(Debug)]
pub struct Resource<P>(RefCell<P>);

impl<P: Planner> guest::Guest for Guest<P> {
    type Planner = Resource<P>;
}

impl<P: Planner> guest::GuestPlanner for Resource<P> {
    fn init(task: types::Task) -> Result<guest::Planner, String> {
        install_panic_hook();
        let planner = P::init(&task.into()).map_err(|e| e.to_string())?;
        Ok(guest::Planner::new(Self(RefCell::new(planner))))
    }

    fn step(&self, observation: types::Observation) -> Result<types::Command, String> {
        self.0.borrow_mut().step(&observation.into()).map(Into::into).map_err(|e| e.to_string())
    }
}
