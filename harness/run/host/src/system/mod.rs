//! What the harness wants of the operating system for planners' processes: pipes that don't block, an end that can be asked
//! for, limits. There is a module for each kind of system, and nothing outside of here depends on it.
//!
//! `unix` is what results are made with. `elsewhere` needs the standard library alone, and serves Windows: commands and the
//! compiler run there, without limits but the clock's, and native planners don't.

#[cfg(any(not(unix), test))]
#[cfg_attr(unix, allow(dead_code, reason = "its tests run on Unix, too, and don't use all of it"))]
mod elsewhere;
#[cfg(unix)]
mod spawn;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(crate) use elsewhere::{
    Child, HAS_NATIVE_PLANNERS, is_refusal, memory_granted, prepare, stack_limit, used_up_time, was_killed,
    was_killed_by_others,
};
#[cfg(unix)]
pub(crate) use unix::{
    Child, HAS_NATIVE_PLANNERS, is_refusal, memory_granted, prepare, stack_limit, used_up_time, was_killed,
    was_killed_by_others,
};

/// Whose program a process runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// The harness's worker: it has one thread and no children.
    Worker,
    /// The harness's compiler: it may have threads.
    Compiler,
    /// Somebody's program, started as the leader of a process group where there are such.
    Command,
}

/// What can be done with a process's pipes without waiting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Ready {
    /// There is output, or its end.
    pub(crate) output: bool,
    /// There is something on standard error, or its end.
    pub(crate) errors: bool,
    /// Standard input takes more.
    pub(crate) input: bool,
}
