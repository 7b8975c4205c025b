//! The system calls that remain.
//!
//! Three answers: what computing takes is allowed; what libraries try and can do without fails with an error, as if the
//! user had no permission; everything else ends the process, and the
//! harness is told which call it was (`signals`).

use std::collections::BTreeMap;

use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter, SeccompRule,
};

/// Computing, memory, descriptors that are open already, time, and leaving.
const ALLOWED: &[i64] = &[
    libc::SYS_read,
    libc::SYS_readv,
    libc::SYS_pread64,
    libc::SYS_write,
    libc::SYS_writev,
    libc::SYS_close,
    libc::SYS_lseek,
    libc::SYS_fstat,
    libc::SYS_fcntl,
    libc::SYS_mmap,
    libc::SYS_munmap,
    libc::SYS_mremap,
    libc::SYS_mprotect,
    libc::SYS_madvise,
    libc::SYS_brk,
    libc::SYS_futex,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_sigaltstack,
    libc::SYS_restart_syscall,
    libc::SYS_getrandom,
    libc::SYS_clock_gettime,
    libc::SYS_clock_getres,
    libc::SYS_gettimeofday,
    libc::SYS_clock_nanosleep,
    libc::SYS_nanosleep,
    libc::SYS_sched_yield,
    libc::SYS_sched_getaffinity,
    libc::SYS_getpid,
    libc::SYS_getppid,
    libc::SYS_gettid,
    libc::SYS_getuid,
    libc::SYS_geteuid,
    libc::SYS_getgid,
    libc::SYS_getegid,
    libc::SYS_getrusage,
    libc::SYS_set_robust_list,
    libc::SYS_rseq,
    libc::SYS_membarrier,
    libc::SYS_exit,
    libc::SYS_exit_group,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_time,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_arch_prctl,
];

/// What the loader and this module do until the planner is at work; later it fails.
const LOADING: &[i64] = &[
    libc::SYS_openat,
    libc::SYS_newfstatat,
    libc::SYS_statx,
    libc::SYS_readlinkat,
    libc::SYS_faccessat,
    libc::SYS_faccessat2,
    libc::SYS_getdents64,
    libc::SYS_getcwd,
    libc::SYS_prctl,
    libc::SYS_prlimit64,
    libc::SYS_seccomp,
    libc::SYS_landlock_create_ruleset,
    libc::SYS_landlock_restrict_self,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_open,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_stat,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_lstat,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_access,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_readlink,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_getrlimit,
];

/// What fails from the start: asking about terminals and the machine, handling signals, threads.
const REFUSED: &[i64] = &[
    libc::SYS_ioctl,
    libc::SYS_rt_sigaction,
    libc::SYS_sysinfo,
    libc::SYS_uname,
    libc::SYS_sched_setaffinity,
    libc::SYS_sched_getparam,
    libc::SYS_sched_getscheduler,
    libc::SYS_getpriority,
    libc::SYS_setpriority,
    libc::SYS_openat2,
    libc::SYS_mlock,
    libc::SYS_munlock,
    libc::SYS_dup,
    libc::SYS_dup3,
    libc::SYS_pipe2,
    libc::SYS_ppoll,
    libc::SYS_memfd_create,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_dup2,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_poll,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_pipe,
];

/// Calls that are likely to be asked about, with their names.
const NAMES: &[(i64, &str)] = &[
    (libc::SYS_socket, "socket"),
    (libc::SYS_socketpair, "socketpair"),
    (libc::SYS_connect, "connect"),
    (libc::SYS_bind, "bind"),
    (libc::SYS_clone, "clone (fork)"),
    (libc::SYS_execve, "execve"),
    (libc::SYS_execveat, "execveat"),
    (libc::SYS_kill, "kill"),
    (libc::SYS_tgkill, "tgkill"),
    (libc::SYS_ptrace, "ptrace"),
    (libc::SYS_process_vm_readv, "process_vm_readv"),
    (libc::SYS_process_vm_writev, "process_vm_writev"),
    (libc::SYS_unlinkat, "unlinkat"),
    (libc::SYS_mkdirat, "mkdirat"),
    (libc::SYS_renameat, "renameat"),
    (libc::SYS_mount, "mount"),
    (libc::SYS_umount2, "umount2"),
    (libc::SYS_bpf, "bpf"),
    (libc::SYS_setuid, "setuid"),
    (libc::SYS_setsid, "setsid"),
    (libc::SYS_unshare, "unshare"),
    (libc::SYS_timer_create, "timer_create"),
    (libc::SYS_setitimer, "setitimer"),
    (libc::SYS_shmget, "shmget"),
    (libc::SYS_io_uring_setup, "io_uring_setup"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_fork, "fork"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_vfork, "vfork"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_unlink, "unlink"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_mkdir, "mkdir"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_rename, "rename"),
];

/// The name of a system call.
pub(super) fn name(number: i64) -> Option<&'static str> {
    NAMES.iter().find(|(n, _)| *n == number).map(|(_, name)| *name)
}

type Rules = BTreeMap<i64, Vec<SeccompRule>>;

/// Filters for the time while the library is opened; false if the kernel has none.
pub(super) fn filter_for_loading() -> bool {
    let calls = ALLOWED.iter().chain(LOADING).chain(REFUSED).chain(&[libc::SYS_clone3]);
    let mut known: Rules = calls.map(|call| (*call, Vec::new())).collect();
    // abort() sends a signal to its own thread; threads are refused below, but other processes end this one.
    let own = std::process::id();
    let conditions = [(libc::SYS_tgkill, 0, SeccompCmpOp::Eq, u64::from(own)), {
        let thread = libc::CLONE_THREAD as u64;
        (libc::SYS_clone, 0, SeccompCmpOp::MaskedEq(thread), thread)
    }];
    for (call, argument, operator, value) in conditions {
        let Some(rule) = rule(argument, operator, value) else { return false };
        known.insert(call, vec![rule]);
    }
    let refused: Rules = REFUSED.iter().chain(&[libc::SYS_clone]).map(|call| (*call, Vec::new())).collect();
    // The C library tries clone3 first and then clone.
    let unknown: Rules = [(libc::SYS_clone3, Vec::new())].into();
    [
        program(refused, SeccompAction::Allow, SeccompAction::Errno(libc::EPERM as u32)),
        program(unknown, SeccompAction::Allow, SeccompAction::Errno(libc::ENOSYS as u32)),
        program(known, SeccompAction::Trap, SeccompAction::Allow),
    ]
    .into_iter()
    .all(apply)
}

/// One filter more, for the time when the library is open.
pub(super) fn filter_for_work() -> bool {
    let refused: Rules = LOADING.iter().map(|call| (*call, Vec::new())).collect();
    apply(program(refused, SeccompAction::Allow, SeccompAction::Errno(libc::EACCES as u32)))
}

fn rule(argument: u8, operator: SeccompCmpOp, value: u64) -> Option<SeccompRule> {
    let condition = SeccompCondition::new(argument, SeccompCmpArgLen::Qword, operator, value).ok()?;
    SeccompRule::new(vec![condition]).ok()
}

fn program(rules: Rules, otherwise: SeccompAction, listed: SeccompAction) -> Option<BpfProgram> {
    let arch = std::env::consts::ARCH.try_into().ok()?;
    SeccompFilter::new(rules, otherwise, listed, arch).ok()?.try_into().ok()
}

fn apply(program: Option<BpfProgram>) -> bool {
    program.is_some_and(|p| seccompiler::apply_filter(&p).is_ok())
}
