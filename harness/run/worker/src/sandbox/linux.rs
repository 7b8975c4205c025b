//! The sandbox on Linux.

use std::fs::File;
use std::io::{self, Read as _, Seek as _};
use std::path::Path;

use landlock::{
    ABI, Access as _, AccessFs, AccessNet, CompatLevel, Compatible as _, LandlockStatus, PathBeneath, PathFd,
    Ruleset, RulesetAttr as _, RulesetCreatedAttr as _, RulesetError, RulesetStatus, Scope,
};
use rustix::process::{DumpableBehavior, Resource, Rlimit, Signal};

use super::SandboxReport;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use super::{seccomp, signals};

/// The newest rules that are asked for; older kernels enforce what they know.
const NEWEST: ABI = ABI::V6;

/// What the dynamic loader reads, where distributions keep it.
const LOADER: [&str; 9] = [
    "/lib",
    "/lib32",
    "/lib64",
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/nix/store",
    "/gnu/store",
    "/etc/ld.so.cache",
];

/// Address space for the code of the library and of what it links, bytes: what can be written to is limited as data.
const LIBRARIES: u64 = 1 << 30;

/// Processor time of a worker, s. The harness ends a worker that hangs much sooner; this is for one that has lost it.
const CPU_SECONDS: u64 = 24 * 60 * 60;

/// Cuts the process off from where it came from: its session, its other descriptors, tracing. It dies with the
/// harness. `protocol` is the descriptor that a forbidden system call is reported to.
pub(crate) fn isolate(protocol: i32) -> io::Result<()> {
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
    // Its own session: keys pressed in the terminal are for the harness.
    rustix::process::setsid()?;
    rustix::process::set_dumpable_behavior(DumpableBehavior::NotDumpable)?;
    close_descriptors_from(protocol + 1);
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    signals::handle(protocol)?;
    Ok(())
}

/// The descriptors below are the standard ones and the protocol's two.
fn close_descriptors_from(first: i32) {
    // SAFETY: the process has opened nothing that it needs beyond.
    let done = unsafe { libc::syscall(libc::SYS_close_range, first, libc::c_int::MAX, 0) };
    if done != 0 {
        // Before Linux 5.9. The harness opens all of its own with close-on-exec, so that there is nothing as a rule.
        for fd in first..1024 {
            // SAFETY: as above.
            unsafe { libc::close(fd) };
        }
    }
}

/// Confines this process, a compiler, to computing within these limits of memory (beside what it has now, bytes) and of
/// processor time (s), and to the descriptors that it has. Other means than the limits are used where the system has them:
/// what is compiled is not run, so that they only guard against flaws of the compiler.
pub fn confine_compiler(memory_bytes: u64, seconds: u64) -> io::Result<()> {
    let data = data_in_use(&mut File::open("/proc/self/statm")?)?;
    let limits = limit(&[
        (Resource::Core, 0),
        (Resource::Fsize, 0),
        (Resource::Memlock, 0),
        (Resource::Data, data.saturating_add(memory_bytes)),
    ]);
    // At the first the process is told, by a signal that tells the harness why it ended.
    let (first, last) = (Some(seconds), Some(seconds.saturating_add(5)));
    let cpu = rustix::process::setrlimit(Resource::Cpu, Rlimit { current: first, maximum: last });
    if !limits || cpu.is_err() {
        return Err(io::Error::other("the system rejects the limits of memory and processor time"));
    }
    if rustix::thread::set_no_new_privs(true).is_ok() {
        restrict(None).map_err(io::Error::other)?;
        limit(&[(Resource::Nofile, 0)]);
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
        seccomp::filter(true);
    }
    Ok(())
}

/// Confines the process for good to computing, to talking to the harness, and to what the dynamic loader needs for
/// `library`, before any code of the library runs. Of memory it gets `memory_bytes` beside what it has.
///
/// The one thing that is still to be given up when the library is open, the harness takes: it forbids the process to open
/// any more files ([`Introduction`](crate::protocol::Introduction) is its word).
pub(crate) fn confine(library: &Path, memory_bytes: u64) -> io::Result<SandboxReport> {
    let mut statm = File::open("/proc/self/statm")?;
    let mut report = SandboxReport::default();
    let (space, data) = (address_space(&mut statm)?, data_in_use(&mut statm)?);
    drop(statm);
    let (data, space) =
        (data.saturating_add(memory_bytes), space.saturating_add(memory_bytes).saturating_add(LIBRARIES));
    for (resource, name, wanted) in [(Resource::Data, "d", data), (Resource::As, "v", space)] {
        // With less than it may have, a planner would fail for want of memory that the machine refuses.
        if let Some(granted) = rustix::process::getrlimit(resource).maximum.filter(|m| *m < wanted) {
            let text = format!("the system provides {granted} bytes (ulimit -{name}) of {wanted}");
            return Err(io::Error::other(text));
        }
    }
    report.rlimits = limit(&[
        (Resource::Core, 0),
        (Resource::Fsize, 0),
        (Resource::Nproc, 0),
        (Resource::Memlock, 0),
        (Resource::Nofile, 64),
        (Resource::Cpu, CPU_SECONDS),
        (Resource::Data, data),
        (Resource::As, space),
    ]);
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    signals::expect_memory(memory_bytes);
    report.no_new_privs = rustix::thread::set_no_new_privs(true).is_ok();
    report.landlock = restrict(Some(library)).map_err(io::Error::other)?;
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    {
        report.seccomp = seccomp::filter(false);
    }
    Ok(report)
}

/// Sets limits, soft and hard, none of them above what is allowed now; false if the system refuses one.
fn limit(limits: &[(Resource, u64)]) -> bool {
    limits.iter().all(|&(resource, wanted)| {
        let allowed = rustix::process::getrlimit(resource).maximum.unwrap_or(u64::MAX);
        let value = Some(wanted.min(allowed));
        rustix::process::setrlimit(resource, Rlimit { current: value, maximum: value }).is_ok()
    })
}

/// Address space in use, bytes.
fn address_space(statm: &mut File) -> io::Result<u64> {
    in_use(statm, 0)
}

/// Memory in use of the kind that the limit of data counts, and stacks, bytes.
fn data_in_use(statm: &mut File) -> io::Result<u64> {
    in_use(statm, 5)
}

/// A field of `/proc/self/statm`, in bytes.
fn in_use(statm: &mut File, field: usize) -> io::Result<u64> {
    let mut text = String::new();
    statm.rewind()?;
    statm.read_to_string(&mut text)?;
    let pages = text.split_ascii_whitespace().nth(field).and_then(|n| n.parse::<u64>().ok());
    let pages = pages.ok_or_else(|| io::Error::other(format!("/proc/self/statm is `{text}`")))?;
    Ok(pages * rustix::param::page_size() as u64)
}

/// Denies all files but those that the loader reads for `library`, all TCP, and signals to others; returns the version
/// of landlock, or none if the kernel has none.
fn restrict(library: Option<&Path>) -> Result<Option<u32>, RulesetError> {
    let mut rules = Ruleset::default()
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(NEWEST))?
        .handle_access(AccessNet::from_all(NEWEST))?
        .scope(Scope::from_all(NEWEST))?
        .create()?;
    if let Some(library) = library {
        let folders = LOADER.iter().map(Path::new);
        for path in folders.chain([library]) {
            // What isn't there can't be read.
            let Ok(fd) = PathFd::new(path) else { continue };
            let access = if path.is_dir() {
                AccessFs::ReadFile | AccessFs::ReadDir
            } else {
                AccessFs::ReadFile.into()
            };
            rules = rules.add_rule(PathBeneath::new(fd, access))?;
        }
    }
    let status = rules.restrict_self()?;
    Ok(match (status.ruleset, status.landlock) {
        (RulesetStatus::NotEnforced, _) => None,
        (_, LandlockStatus::Available { effective_abi, .. }) => Some(effective_abi as u32),
        _ => None,
    })
}
