//! Processes on Linux and other Unix systems.

use std::io;
use std::os::fd::{AsFd as _, BorrowedFd};
use std::os::unix::process::CommandExt as _;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, Resource, Signal, getrlimit};

use super::spawn::spawn;
use super::{Ready, Role};
use crate::fault::ProcessEnd;

/// Whether there are native planners: the worker opens libraries as Unix systems do.
pub(crate) const HAS_NATIVE_PLANNERS: bool = true;

/// A process with its three pipes, none of which blocks.
#[derive(Debug)]
pub(crate) struct Child {
    pid: Pid,
    role: Role,
    #[cfg(target_os = "linux")]
    place: linux::Place,
    /// None once it is closed.
    stdin: Option<ChildStdin>,
    stdout: ChildStdout,
    /// None once it is at its end.
    stderr: Option<ChildStderr>,
    /// How it ended, once that has been asked of the system: its number may be another's from then on.
    ended: Option<ProcessEnd>,
}

#[cfg(target_os = "linux")]
pub(crate) use linux::Together;
/// Elsewhere the system alone says where threads run.
#[cfg(not(target_os = "linux"))]
pub(crate) enum Together {}

/// Readies a command for its role: a planner's process ends with the harness.
pub(crate) fn prepare(command: &mut Command, role: Role) {
    if role == Role::Command {
        // A group of its own: its children are ended with it, and keys pressed in the terminal are not for it.
        command.process_group(0);
    }
    #[cfg(target_os = "linux")]
    linux::die_with_parent(command);
}

impl Child {
    pub(crate) fn start(mut command: Command, role: Role) -> io::Result<Self> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = spawn(command)?;
        let (Some(stdin), Some(stdout), Some(stderr)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err(io::Error::other("a process without pipes"));
        };
        let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        let pid = pid.ok_or_else(|| io::Error::other("a process without a number"))?;
        // From here on it is ended if something fails.
        let child = Self {
            pid,
            role,
            #[cfg(target_os = "linux")]
            place: linux::Place::default(),
            stdin: Some(stdin),
            stdout,
            stderr: Some(stderr),
            ended: None,
        };
        let pipes = [
            child.stdin.as_ref().map(|p| p.as_fd()),
            Some(child.stdout.as_fd()),
            child.stderr.as_ref().map(|p| p.as_fd()),
        ];
        pipes.into_iter().flatten().try_for_each(|pipe| rustix::io::ioctl_fionbio(pipe, true))?;
        Ok(child)
    }

    /// Forbids a worker to open any more files. This is done from outside, since nothing that the process does by itself is
    /// beyond doubt once its library is open.
    pub(crate) fn seal(&self) -> io::Result<()> {
        #[cfg(target_os = "linux")]
        if self.role == Role::Worker {
            linux::forbid_files(self.pid)?;
        }
        Ok(())
    }

    /// Puts a worker and this thread in the best place for answers that come soon, until the value that it returns is dropped.
    pub(crate) fn stay_together(&mut self) -> Option<Together> {
        #[cfg(target_os = "linux")]
        let place = (self.role == Role::Worker).then(|| self.place.move_here(self.pid)).flatten();
        #[cfg(not(target_os = "linux"))]
        let place = None;
        place
    }

    /// Writes to standard input; how many bytes it took, which may be none.
    ///
    /// # Errors
    /// [`io::ErrorKind::BrokenPipe`] when nobody reads it any more.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(stdin) = &self.stdin else { return Err(io::ErrorKind::BrokenPipe.into()) };
        no_wait(|| rustix::io::write(stdin, bytes)).map(|n| n.unwrap_or(0))
    }

    pub(crate) fn close_input(&mut self) {
        self.stdin = None;
    }

    /// Whether standard input was closed by this side.
    pub(crate) fn is_input_closed(&self) -> bool {
        self.stdin.is_none()
    }

    /// Takes output; how many bytes came, which is 0 at its end, and none where there is nothing now.
    pub(crate) fn read_output(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        no_wait(|| rustix::io::read(&self.stdout, &mut *into))
    }

    /// Takes what is on standard error in the same way. A pipe that can't be read is as good as closed.
    pub(crate) fn read_errors(&mut self, into: &mut [u8]) -> Option<usize> {
        let stderr = self.stderr.as_ref()?;
        let read = no_wait(|| rustix::io::read(stderr, &mut *into));
        if matches!(read, Ok(Some(0)) | Err(_)) {
            self.stderr = None;
        }
        read.ok().flatten()
    }

    /// Waits until something can be done with the pipes; with standard input only if there is something to write.
    pub(crate) fn wait(&self, limit: Duration, writing: bool) -> io::Result<Ready> {
        let timeout = Timespec {
            tv_sec: i64::try_from(limit.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: limit.subsec_nanos().into(),
        };
        // A place that isn't used watches the output without asking for anything.
        let output = self.stdout.as_fd();
        let (errors, wants_errors) =
            self.stderr.as_ref().map_or((output, PollFlags::empty()), |p| (p.as_fd(), PollFlags::IN));
        let input: Option<BorrowedFd<'_>> = self.stdin.as_ref().filter(|_| writing).map(|p| p.as_fd());
        let (input, wants_input) = input.map_or((output, PollFlags::empty()), |p| (p, PollFlags::OUT));
        let mut places = [
            PollFd::from_borrowed_fd(output, PollFlags::IN),
            PollFd::from_borrowed_fd(errors, wants_errors),
            PollFd::from_borrowed_fd(input, wants_input),
        ];
        match poll(&mut places, Some(&timeout)) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(e) => return Err(e.into()),
        }
        let [output, errors, input] = places.map(|p| !p.revents().is_empty());
        Ok(Ready {
            output,
            errors: errors && !wants_errors.is_empty(),
            input: input && !wants_input.is_empty(),
        })
    }

    /// Processor time that it has used; none where the system doesn't tell.
    pub(crate) fn cpu_time(&self) -> Option<Duration> {
        #[cfg(target_os = "linux")]
        let used = linux::cpu_time(self.pid);
        #[cfg(not(target_os = "linux"))]
        let used = None;
        used
    }

    /// Ends it at once, with its descendants where it leads a group.
    pub(crate) fn kill(&self) {
        if self.role == Role::Command {
            // The leader may be gone while the group is not.
            let _ = rustix::process::kill_process_group(self.pid, Signal::KILL);
        }
        if self.ended.is_none() {
            let _ = rustix::process::kill_process(self.pid, Signal::KILL);
        }
    }

    /// How it ended; none while it runs.
    pub(crate) fn ended(&mut self) -> Option<ProcessEnd> {
        self.reap(libc::WNOHANG)
    }

    pub(crate) fn wait_for_end(&mut self) -> ProcessEnd {
        self.reap(0).unwrap_or(ProcessEnd::Signal(libc::SIGKILL))
    }

    fn reap(&mut self, flags: i32) -> Option<ProcessEnd> {
        if self.ended.is_none() {
            let mut status = 0;
            loop {
                // SAFETY: the pointer leads to a value of its type; nobody else waits for this process.
                let found = unsafe { libc::waitpid(self.pid.as_raw_pid(), &raw mut status, flags) };
                if found == -1 && io::Error::last_os_error().kind() == io::ErrorKind::Interrupted {
                    continue;
                }
                if found > 0 {
                    self.ended = Some(if libc::WIFSIGNALED(status) {
                        ProcessEnd::Signal(libc::WTERMSIG(status))
                    } else {
                        ProcessEnd::Exit(libc::WEXITSTATUS(status))
                    });
                }
                break;
            }
        }
        self.ended
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
        self.reap(0);
    }
}

/// What a call gives that doesn't wait; none where it would have to.
fn no_wait(mut call: impl FnMut() -> Result<usize, Errno>) -> io::Result<Option<usize>> {
    match call() {
        Ok(n) => Ok(Some(n)),
        Err(Errno::AGAIN | Errno::INTR) => Ok(None),
        Err(e) => Err(e.into()),
    }
}

/// Whether a process died of `SIGKILL`.
pub(crate) fn was_killed(how: ProcessEnd) -> bool {
    how == ProcessEnd::Signal(libc::SIGKILL)
}

/// Whether a process died of what a planner can't send itself behind the filter of system calls.
pub(crate) fn was_killed_by_others(how: ProcessEnd) -> bool {
    matches!(how, ProcessEnd::Signal(libc::SIGKILL | libc::SIGTERM | libc::SIGINT))
}

/// Whether a process died since it used up its processor time.
pub(crate) fn used_up_time(how: ProcessEnd) -> bool {
    how == ProcessEnd::Signal(libc::SIGXCPU)
}

/// Bytes that the stack of a process may have; none if it has no limit.
pub(crate) fn stack_limit() -> Option<u64> {
    getrlimit(Resource::Stack).current
}

/// Bytes of memory that the system lets a process have; none if it sets no limit.
pub(crate) fn memory_granted() -> Option<u64> {
    [getrlimit(Resource::Data).maximum, getrlimit(Resource::As).current].into_iter().flatten().min()
}

/// Whether this is the system's own word for what it can't do.
pub(crate) fn is_refusal(error: &(dyn std::error::Error + 'static)) -> bool {
    error.is::<Errno>() || error.is::<io::Error>()
}

#[cfg(target_os = "linux")]
mod linux {
    use std::io;
    use std::os::unix::process::CommandExt as _;
    use std::process::Command;
    use std::time::Duration;

    use rustix::process::{Pid, Resource, Rlimit, Signal};
    use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

    /// Has the system end the process when the harness is gone.
    pub(super) fn die_with_parent(command: &mut Command) {
        let ask = || {
            rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
            Ok(())
        };
        // SAFETY: it makes one system call, which is allowed between fork and exec.
        unsafe { command.pre_exec(ask) };
    }

    pub(super) fn forbid_files(pid: Pid) -> io::Result<()> {
        let none = Rlimit { current: Some(0), maximum: Some(0) };
        rustix::process::prlimit(Some(pid), Resource::Nofile, none)?;
        Ok(())
    }

    pub(super) fn cpu_time(pid: Pid) -> Option<Duration> {
        let (mut clock, mut time) = (0, libc::timespec { tv_sec: 0, tv_nsec: 0 });
        // SAFETY: both pointers lead to values of their types.
        let known = unsafe {
            libc::clock_getcpuclockid(pid.as_raw_pid(), &raw mut clock) == 0
                && libc::clock_gettime(clock, &raw mut time) == 0
        };
        let nanos = u32::try_from(time.tv_nsec).ok()?;
        known.then(|| u64::try_from(time.tv_sec).ok().map(|s| Duration::new(s, nanos))).flatten()
    }

    /// The processor that a worker was put on last.
    #[derive(Debug, Default)]
    pub(super) struct Place(Option<usize>);

    impl Place {
        /// Puts a worker and this thread on one processor until the answer is there: the two take turns, and to wake a
        /// sleeping processor takes longer than a planner's step. Others are left alone: they may have threads. Returns
        /// where this thread may run, to be given back to it.
        pub(super) fn move_here(&mut self, pid: Pid) -> Option<Together> {
            let home = sched_getaffinity(None).ok()?;
            let here = sched_getcpu();
            if here >= CpuSet::MAX_CPU {
                return None;
            }
            let mut set = CpuSet::new();
            set.set(here);
            if self.0 != Some(here) {
                // Where the system doesn't allow it a step takes longer.
                sched_setaffinity(Some(pid), &set).ok()?;
                self.0 = Some(here);
            }
            sched_setaffinity(None, &set).ok()?;
            Some(Together(home))
        }
    }

    /// Where this thread may run again when the answer is there.
    pub(crate) struct Together(CpuSet);

    impl Drop for Together {
        fn drop(&mut self) {
            // It was allowed before.
            let _ = sched_setaffinity(None, &self.0);
        }
    }
}
