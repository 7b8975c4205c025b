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
    libc::SYS_prlimit64,
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
    libc::SYS_getrlimit,
    #[cfg(target_arch = "x86_64")]
    libc::SYS_arch_prctl,
];

/// Asking about files, and opening them for reading: the dynamic loader does it. What may be read is landlock's affair.
const FILES: &[i64] = &[
    libc::SYS_openat,
    libc::SYS_newfstatat,
    libc::SYS_statx,
    libc::SYS_readlinkat,
    libc::SYS_faccessat,
    libc::SYS_faccessat2,
    libc::SYS_getdents64,
    libc::SYS_getcwd,
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
];

/// What fails: asking about terminals and the machine, changing what the process is to the system, handling signals.
const REFUSED: &[i64] = &[
    libc::SYS_prctl,
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
    (libc::SYS_seccomp, "seccomp"),
    (libc::SYS_landlock_restrict_self, "landlock_restrict_self"),
    (libc::SYS_rt_sigqueueinfo, "rt_sigqueueinfo"),
    (libc::SYS_pidfd_open, "pidfd_open"),
    (libc::SYS_pidfd_send_signal, "pidfd_send_signal"),
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
    (libc::SYS_setrlimit, "setrlimit"),
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

/// What an argument must be: its place, how much of it the kernel looks at, and what it is compared with.
type Condition = (u8, SeccompCmpArgLen, SeccompCmpOp, u64);

/// Filters all calls of this process from now on; it may have `threads` or not. False if the kernel has no filters.
///
/// They are all in force before any code of a library runs, and no call by which they, or other limits, could be changed
/// is among those that remain.
pub(super) fn filter(threads: bool) -> bool {
    filters(threads).is_some_and(|filters| filters.iter().all(apply))
}

fn filters(threads: bool) -> Option<Vec<BpfProgram>> {
    let unconditional = |calls: &[&[i64]]| -> Rules {
        calls.iter().copied().flatten().map(|call| (*call, Vec::new())).collect()
    };
    let mut refused = unconditional(&[REFUSED]);
    if !threads {
        refused.insert(libc::SYS_clone, Vec::new());
    }
    // The C library tries clone3 first and then clone.
    let unknown = unconditional(&[&[libc::SYS_clone3]]);
    let mut known = unconditional(&[ALLOWED, FILES, REFUSED, &[libc::SYS_clone3]]);
    for (call, rules) in allowed_if() {
        known.insert(call, rules?);
    }
    let conditional =
        |rules: Vec<(i64, Option<Vec<SeccompRule>>)>| rules.into_iter().map(|(c, r)| Some((c, r?))).collect();
    let refused_if: Option<Rules> = conditional(refused_if());
    let unreadable_if: Option<Rules> = conditional(unreadable_if());
    let fails = |errno: i32| SeccompAction::Errno(errno as u32);
    [
        program(refused, SeccompAction::Allow, fails(libc::EPERM)),
        program(refused_if?, SeccompAction::Allow, fails(libc::EPERM)),
        program(unreadable_if?, SeccompAction::Allow, fails(libc::EACCES)),
        program(unknown, SeccompAction::Allow, fails(libc::ENOSYS)),
        program(known, SeccompAction::Trap, SeccompAction::Allow),
    ]
    .into_iter()
    .collect()
}

/// Calls that are allowed with some arguments only, and end the process with others.
fn allowed_if() -> Vec<(i64, Option<Vec<SeccompRule>>)> {
    use SeccompCmpArgLen::{Dword, Qword};
    use SeccompCmpOp::{Eq, MaskedEq, Ne};
    /// Signals by which others end a process: the harness must be able to tell that it was them.
    const FROM_OUTSIDE: [i32; 5] = [libc::SIGKILL, libc::SIGTERM, libc::SIGINT, libc::SIGHUP, libc::SIGQUIT];
    // abort() sends a signal to its own thread.
    let own = (0, Dword, Eq, u64::from(std::process::id()));
    let other = FROM_OUTSIDE.map(|signal| (2, Dword, Ne, signal as u64));
    let to_itself: Vec<Condition> = [own].into_iter().chain(other).collect();
    let thread = libc::CLONE_THREAD as u64;
    vec![
        (libc::SYS_tgkill, rules(&[&to_itself])),
        (libc::SYS_clone, rules(&[&[(0, Qword, MaskedEq(thread), thread)]])),
    ]
}

/// Calls that fail with some arguments, as if the user had no permission.
fn refused_if() -> Vec<(i64, Option<Vec<SeccompRule>>)> {
    use SeccompCmpArgLen::{Dword, Qword};
    use SeccompCmpOp::{MaskedEq, Ne};
    // Asking for signals, for locks and for other sizes of a pipe are commands of fcntl too.
    let command = [libc::F_GETFD, libc::F_SETFD, libc::F_GETFL].map(|c| (1, Dword, Ne, c as u64));
    let flag = |flag: i32| (3, Qword, MaskedEq(flag as u64), flag as u64);
    vec![
        (libc::SYS_fcntl, rules(&[&command])),
        // Limits may be read, its own only.
        (libc::SYS_prlimit64, rules(&[&[(0, Dword, Ne, 0)], &[(2, Qword, Ne, 0)]])),
        // Memory that the limit of data doesn't count.
        (libc::SYS_mmap, rules(&[&[flag(libc::MAP_SHARED)], &[flag(libc::MAP_GROWSDOWN)]])),
    ]
}

/// Calls that open files for anything but reading.
fn unreadable_if() -> Vec<(i64, Option<Vec<SeccompRule>>)> {
    let writing = |argument: u8| {
        let is = |mask: i32, value: i32| {
            [(argument, SeccompCmpArgLen::Dword, SeccompCmpOp::MaskedEq(mask as u64), value as u64)]
        };
        let temporary = libc::O_TMPFILE & !libc::O_DIRECTORY;
        rules(&[
            &is(libc::O_ACCMODE, libc::O_WRONLY),
            &is(libc::O_ACCMODE, libc::O_RDWR),
            &is(libc::O_ACCMODE, libc::O_ACCMODE),
            &is(libc::O_CREAT, libc::O_CREAT),
            &is(libc::O_TRUNC, libc::O_TRUNC),
            &is(temporary, temporary),
        ])
    };
    vec![
        (libc::SYS_openat, writing(2)),
        #[cfg(target_arch = "x86_64")]
        (libc::SYS_open, writing(1)),
    ]
}

/// Rules of which one must hold; all conditions of a rule must.
fn rules(all: &[&[Condition]]) -> Option<Vec<SeccompRule>> {
    let condition = |(argument, length, operator, value): &Condition| {
        SeccompCondition::new(*argument, length.clone(), operator.clone(), *value).ok()
    };
    let rule = |conditions: &&[Condition]| {
        SeccompRule::new(conditions.iter().map(condition).collect::<Option<Vec<_>>>()?).ok()
    };
    all.iter().map(rule).collect()
}

/// Puts a filter in force. The process has no way to new privileges already; `seccompiler` would ask for that again, by a
/// call that the first filter refuses.
fn apply(program: &BpfProgram) -> bool {
    let Ok(len) = u16::try_from(program.len()) else { return false };
    // What the kernel's and seccompiler's structs hold is the same: two bytes of code, two of jumps, four of value.
    let program = libc::sock_fprog { len, filter: program.as_ptr().cast_mut().cast::<libc::sock_filter>() };
    // SAFETY: the struct and the instructions live until the call returns, and the kernel only reads them.
    unsafe { libc::syscall(libc::SYS_seccomp, libc::SECCOMP_SET_MODE_FILTER, 0, &raw const program) == 0 }
}

fn program(rules: Rules, otherwise: SeccompAction, listed: SeccompAction) -> Option<BpfProgram> {
    let arch = std::env::consts::ARCH.try_into().ok()?;
    SeccompFilter::new(rules, otherwise, listed, arch).ok()?.try_into().ok()
}
