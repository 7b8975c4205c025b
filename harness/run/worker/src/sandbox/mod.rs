//! How the worker gives up what a planner doesn't get. It needs no privileges.
//!
//! On Linux: no new privileges, resource limits, landlock (files, TCP, signals), and a seccomp list of the system calls
//! that remain, all before the library is opened: what it does as it is opened is its code already. Files that the loader
//! reads can be read until the harness, from outside, forbids the process to open any. Elsewhere the process is only a
//! process of its own.

use serde::{Deserialize, Serialize};

#[cfg(target_os = "linux")]
mod linux;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod seccomp;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod signals;

/// What the worker says on standard error before it dies of a stack that is full; Rust's own runtime says the same.
pub const STACK_OVERFLOW: &str = "has overflowed its stack";

/// What the worker says on standard error before it dies for want of memory.
pub const OUT_OF_MEMORY: &str = "has used up its memory";

/// Whether the system can confine a worker. On Linux it can in part even where a kernel lacks something, which
/// [`SandboxReport::missing`] tells; elsewhere not at all.
pub const EXISTS: bool = cfg!(target_os = "linux");

/// The version of landlock from which on it keeps signals from other processes.
const SIGNALS: u32 = 6;

/// How a worker is confined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SandboxReport {
    /// Version of landlock in force; none where the kernel lacks it.
    pub landlock: Option<u32>,
    /// Whether system calls are filtered.
    pub seccomp: bool,
    /// Whether new privileges are out of reach.
    pub no_new_privs: bool,
    /// Whether memory, files, processes and core dumps are limited.
    pub rlimits: bool,
}

impl SandboxReport {
    /// What the system lacks, for a warning; empty if nothing.
    #[must_use]
    pub fn missing(&self) -> Vec<&'static str> {
        let parts = [
            (self.landlock.is_some(), "landlock"),
            (
                self.landlock.is_none_or(|version| version >= SIGNALS),
                "landlock's scope of signals (Linux 6.12)",
            ),
            (self.seccomp, "seccomp"),
            (self.no_new_privs, "no_new_privs"),
            (self.rlimits, "resource limits"),
        ];
        parts.into_iter().filter(|(there, _)| !there).map(|(_, name)| name).collect()
    }
}

/// Name of a system call on this machine, for messages; `system call N` where it isn't one of the usual suspects.
#[must_use]
pub fn system_call_name(number: i64) -> String {
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    if let Some(name) = seccomp::name(number) {
        return format!("the system call {name}");
    }
    format!("system call {number}")
}

#[cfg(target_os = "linux")]
pub use linux::confine_compiler;
#[cfg(target_os = "linux")]
pub(crate) use linux::{confine, isolate};

#[cfg(not(target_os = "linux"))]
pub use elsewhere::confine_compiler;
#[cfg(all(unix, not(target_os = "linux")))]
pub(crate) use elsewhere::{confine, isolate};

#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use std::io;

    /// Elsewhere a compiler has no limits but the clock's.
    pub fn confine_compiler(_memory_bytes: u64, _seconds: u64) -> io::Result<()> {
        Ok(())
    }

    #[cfg(unix)]
    pub(crate) fn isolate(_protocol: i32) -> io::Result<()> {
        Ok(())
    }

    #[cfg(unix)]
    pub(crate) fn confine(
        _library: &std::path::Path,
        _memory_bytes: u64,
    ) -> io::Result<super::SandboxReport> {
        Ok(super::SandboxReport::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_lacks_is_named() {
        let whole = SandboxReport { landlock: Some(6), seccomp: true, no_new_privs: true, rlimits: true };
        assert!(whole.missing().is_empty());
        assert_eq!(
            SandboxReport { landlock: None, seccomp: false, ..whole }.missing(),
            ["landlock", "seccomp"]
        );
        let old = SandboxReport { landlock: Some(5), ..whole };
        assert_eq!(old.missing(), ["landlock's scope of signals (Linux 6.12)"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn system_calls_have_names() {
        assert_eq!(system_call_name(libc::SYS_socket), "the system call socket");
        assert_eq!(system_call_name(9999), "system call 9999");
    }
}
