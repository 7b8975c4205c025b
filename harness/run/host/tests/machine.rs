//! What the machine refuses is not the planner's fault. In a program of its own: it has less memory than others.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

mod common;

use common::{observation, plugin, task};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use vb_host::{FaultCode, Limits, LogSink};

#[test]
fn memory_that_the_machine_refuses_is_the_machines_fault() {
    let hog = plugin("(call $ok_planner)", "(call $hog) unreachable", &Limits::default());
    let end = || {
        let mut session = hog.start(&task(), LogSink::discard()).unwrap();
        session.step(&observation()).unwrap_err()
    };
    assert_eq!(end().code(), FaultCode::OutOfMemory);
    let before = getrlimit(Resource::Data);
    // The process has less than this now, and the planner would have up to 256 MiB.
    setrlimit(Resource::Data, Rlimit { current: Some(192 << 20), maximum: before.maximum }).unwrap();
    let found = end();
    setrlimit(Resource::Data, before).unwrap();
    assert_eq!(found.code(), FaultCode::Machine, "{found}");
    assert!(!found.is_planners());
    assert_eq!(end().code(), FaultCode::OutOfMemory);
}
