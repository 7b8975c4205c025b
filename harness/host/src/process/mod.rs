//! A planner's process as the harness sees it: three pipes, none of which is trusted.

mod spawn;

use std::io;
use std::os::fd::{AsFd as _, BorrowedFd};
use std::os::unix::process::CommandExt as _;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, Signal};
#[cfg(target_os = "linux")]
use rustix::process::{Resource, Rlimit};
#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use vb_sdk::LogLevel;
use vb_worker::protocol::{self, FrameError, HEADER, Reply, Request, WireLevel};

use crate::fault::ProcessEnd;
use crate::log::Log;
use spawn::spawn;

/// Bytes taken from a pipe at once.
const CHUNK: usize = 64 << 10;
/// A line of standard error is cut here, bytes.
const ERROR_LINE: usize = 4 << 10;
/// How long a process that has closed its output may take to end by itself.
const GRACE: Duration = Duration::from_millis(500);

/// Why a request got no answer.
#[derive(Debug)]
pub(crate) enum Trouble {
    /// The process ended, or closed its output.
    Gone,
    /// It didn't answer in time.
    Late,
    /// What it sent is no answer.
    Nonsense(FrameError),
    /// It sent a message that nothing asked for.
    Unasked(&'static str),
    /// The system refused to carry messages.
    System(io::Error),
}

/// How a process ended.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub(crate) how: ProcessEnd,
    /// The last lines on standard error.
    pub(crate) words: Vec<String>,
    /// Whether its system calls were filtered, so that it couldn't end itself in every way.
    pub(crate) is_filtered: bool,
}

/// Whose program a process runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// The harness's worker: it has one thread and no children.
    Worker,
    /// The harness's compiler: it may have threads.
    Compiler,
    /// Somebody's program, started as the leader of a process group.
    Command,
}

#[derive(Debug)]
pub(crate) struct Process {
    pid: Pid,
    role: Role,
    /// The processor that it was put on last.
    #[cfg(target_os = "linux")]
    place: Option<usize>,
    /// None after [`Process::farewell`].
    stdin: Option<ChildStdin>,
    stdout: ChildStdout,
    /// None when it is at its end.
    stderr: Option<ChildStderr>,
    /// Bytes that came and belong to the next message.
    inbox: Vec<u8>,
    outbox: Vec<u8>,
    chunk: Box<[u8]>,
    /// The line on standard error that hasn't ended.
    line: Vec<u8>,
    words: Vec<String>,
    /// Bytes that a message of the process may have.
    limit: usize,
    /// Whether its system calls are filtered.
    is_filtered: bool,
    /// Whether it has got a request.
    was_asked: bool,
    /// How it ended, once that has been asked of the system: its number may be another's from then on.
    ended: Option<ProcessEnd>,
}

impl Process {
    /// Starts a process whose messages may have `limit` bytes.
    pub(crate) fn start(mut command: Command, role: Role, limit: usize) -> io::Result<Self> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = spawn(command)?;
        let (Some(stdin), Some(stdout), Some(stderr)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err(io::Error::other("a process without pipes"));
        };
        let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        let pid = pid.ok_or_else(|| io::Error::other("a process without a number"))?;
        let process = Self {
            pid,
            role,
            #[cfg(target_os = "linux")]
            place: None,
            stdin: Some(stdin),
            stdout,
            stderr: Some(stderr),
            inbox: Vec::new(),
            outbox: Vec::new(),
            chunk: vec![0; CHUNK].into(),
            line: Vec::new(),
            words: Vec::new(),
            limit,
            is_filtered: false,
            was_asked: false,
            ended: None,
        };
        for pipe in [process.stdin.as_ref().map(|p| p.as_fd()), Some(process.stdout.as_fd())] {
            pipe.map_or(Ok(()), |p| rustix::io::ioctl_fionbio(p, true))?;
        }
        process.stderr.as_ref().map_or(Ok(()), |p| rustix::io::ioctl_fionbio(p, true))?;
        Ok(process)
    }

    /// Sends a request and waits for the answer. Lines of the log are taken on the way.
    pub(crate) fn ask(
        &mut self,
        request: &impl Serialize,
        limit: Duration,
        log: &mut Log,
    ) -> Result<Reply, Trouble> {
        // What came after the last answer can only be lines of the log. A command may say what it is before it is
        // asked for the first time.
        if std::mem::replace(&mut self.was_asked, true) {
            self.read_output()?;
        }
        if let Some(reply) = self.next_reply(log)? {
            return Err(Trouble::Unasked(reply.name()));
        }
        let mut outbox = std::mem::take(&mut self.outbox);
        protocol::encode(request, &mut outbox).map_err(Trouble::Nonsense)?;
        #[cfg(target_os = "linux")]
        let home = self.stay_together();
        let result = self.exchange(&outbox, limit, log, Self::next_reply);
        #[cfg(target_os = "linux")]
        if let Some(home) = home {
            // It was allowed before.
            let _ = sched_setaffinity(None, &home);
        }
        self.outbox = outbox;
        result
    }

    /// Forbids a worker whose library is open to open any more files. This is done from outside, since nothing that the
    /// process does by itself from now on is beyond doubt. `is_filtered` is whether its system calls are.
    pub(crate) fn seal(&mut self, is_filtered: bool) -> io::Result<()> {
        self.is_filtered = is_filtered;
        #[cfg(target_os = "linux")]
        if self.role == Role::Worker {
            let none = Rlimit { current: Some(0), maximum: Some(0) };
            rustix::process::prlimit(Some(self.pid), Resource::Nofile, none)?;
        }
        Ok(())
    }

    /// Sends the only message that a process gets, and waits for the only one that it sends.
    pub(crate) fn order<T: DeserializeOwned>(
        &mut self,
        message: &impl Serialize,
        limit: Duration,
        log: &mut Log,
    ) -> Result<T, Trouble> {
        let mut frame = Vec::new();
        protocol::encode(message, &mut frame).map_err(Trouble::Nonsense)?;
        self.exchange(&frame, limit, log, |process, _| {
            let payload = protocol::payload(&process.inbox, process.limit).map_err(Trouble::Nonsense)?;
            payload.map(|payload| protocol::decode(payload).map_err(Trouble::Nonsense)).transpose()
        })
    }

    /// Sends a frame and waits until `next` finds an answer in the inbox.
    fn exchange<T>(
        &mut self,
        frame: &[u8],
        limit: Duration,
        log: &mut Log,
        next: impl Fn(&mut Self, &mut Log) -> Result<Option<T>, Trouble>,
    ) -> Result<T, Trouble> {
        let deadline = now() + limit;
        let mut rest = frame;
        // As a rule this takes all of it.
        self.send(&mut rest)?;
        loop {
            let left = deadline.saturating_duration_since(now());
            if left.is_zero() {
                return Err(Trouble::Late);
            }
            let ready = self.wait(left, !rest.is_empty())?;
            if ready.errors {
                self.read_errors(log);
            }
            if ready.input {
                self.send(&mut rest)?;
            }
            if ready.output {
                let more = self.read_output()?;
                if let Some(answer) = next(self, log)? {
                    return Ok(answer);
                }
                if !more {
                    return Err(Trouble::Gone);
                }
            }
        }
    }

    /// Keeps a worker and this thread on one processor until the answer is there: the two take turns, and to wake a
    /// sleeping processor takes longer than a planner's step. Others are left alone: they may have threads. Returns
    /// where this thread may run, to be given back to it.
    #[cfg(target_os = "linux")]
    fn stay_together(&mut self) -> Option<CpuSet> {
        if self.role != Role::Worker {
            return None;
        }
        let home = sched_getaffinity(None).ok()?;
        let here = sched_getcpu();
        if here >= CpuSet::MAX_CPU {
            return None;
        }
        let mut set = CpuSet::new();
        set.set(here);
        if self.place != Some(here) {
            // Where the system doesn't allow it a step takes longer.
            sched_setaffinity(Some(self.pid), &set).ok()?;
            self.place = Some(here);
        }
        sched_setaffinity(None, &set).ok()?;
        Some(home)
    }

    /// Writes what the pipe takes of `rest`.
    fn send(&self, rest: &mut &[u8]) -> Result<(), Trouble> {
        let Some(stdin) = &self.stdin else { return Err(Trouble::Gone) };
        while !rest.is_empty() {
            match rustix::io::write(stdin, rest) {
                Ok(n) => *rest = &rest[n..],
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => break,
                // Its last words may still be in the other pipes.
                Err(Errno::PIPE) => *rest = &[],
                Err(e) => return Err(Trouble::System(e.into())),
            }
        }
        Ok(())
    }

    fn wait(&self, limit: Duration, writing: bool) -> Result<Ready, Trouble> {
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
            Err(e) => return Err(Trouble::System(e.into())),
        }
        let [output, errors, input] = places.map(|p| !p.revents().is_empty());
        Ok(Ready {
            output,
            errors: errors && !wants_errors.is_empty(),
            input: input && !wants_input.is_empty(),
        })
    }

    /// Takes what is in the output; false at its end.
    fn read_output(&mut self) -> Result<bool, Trouble> {
        match rustix::io::read(&self.stdout, &mut self.chunk[..]) {
            Ok(0) => Ok(false),
            Ok(n) => {
                self.inbox.extend_from_slice(&self.chunk[..n]);
                Ok(true)
            }
            Err(Errno::AGAIN | Errno::INTR) => Ok(true),
            Err(e) => Err(Trouble::System(e.into())),
        }
    }

    /// The next message in the inbox that isn't a line of the log; those are taken.
    fn next_reply(&mut self, log: &mut Log) -> Result<Option<Reply>, Trouble> {
        loop {
            let Some(payload) = protocol::payload(&self.inbox, self.limit).map_err(Trouble::Nonsense)? else {
                return Ok(None);
            };
            let reply = protocol::decode::<Reply>(payload).map_err(Trouble::Nonsense)?;
            let used = HEADER + payload.len();
            self.inbox.drain(..used);
            let Reply::Log(line) = reply else { return Ok(Some(reply)) };
            let level = match line.level {
                WireLevel::Error => LogLevel::Error,
                WireLevel::Warn => LogLevel::Warn,
                WireLevel::Info => LogLevel::Info,
                WireLevel::Debug => LogLevel::Debug,
            };
            log.write(level, &line.message);
        }
    }

    /// Takes what is on standard error, once; lines go to the log.
    fn read_errors(&mut self, log: &mut Log) {
        let Some(stderr) = &self.stderr else { return };
        match rustix::io::read(stderr, &mut self.chunk[..]) {
            Ok(n) if n > 0 => {
                for byte in self.chunk[..n].iter().copied() {
                    if byte == b'\n' || self.line.len() == ERROR_LINE {
                        let line = std::mem::take(&mut self.line);
                        keep(&line, &mut self.words, log);
                    }
                    if byte != b'\n' {
                        self.line.push(byte);
                    }
                }
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            // Its end; a pipe that can't be read is as good as closed.
            _ => self.stderr = None,
        }
    }

    /// Whether the process is there.
    pub(crate) fn is_alive(&mut self) -> bool {
        self.reap(false).is_none()
    }

    /// Processor time that it has used; none where the system doesn't tell.
    pub(crate) fn cpu_time(&self) -> Option<Duration> {
        let (mut clock, mut time) = (0, libc::timespec { tv_sec: 0, tv_nsec: 0 });
        // SAFETY: both pointers lead to values of their types.
        let known = unsafe {
            libc::clock_getcpuclockid(self.pid.as_raw_pid(), &raw mut clock) == 0
                && libc::clock_gettime(clock, &raw mut time) == 0
        };
        let nanos = u32::try_from(time.tv_nsec).ok()?;
        known.then(|| u64::try_from(time.tv_sec).ok().map(|s| Duration::new(s, nanos))).flatten()
    }

    /// Waits for the end of a process that has closed its output, ending it if it takes too long; then takes its last
    /// words.
    pub(crate) fn end(&mut self, log: &mut Log) -> End {
        let deadline = now() + GRACE;
        while self.reap(false).is_none() && now() < deadline {
            std::thread::sleep(Duration::from_millis(1));
        }
        let stayed = self.reap(false).is_none();
        let end = self.kill(log);
        if stayed { End { how: ProcessEnd::Mute, ..end } } else { end }
    }

    /// Ends the process at once and takes its last words.
    pub(crate) fn kill(&mut self, log: &mut Log) -> End {
        self.signal();
        let how = self.reap(true).unwrap_or(ProcessEnd::Signal(libc::SIGKILL));
        // Descendants of a command may hold the pipe open: no waiting for its end.
        for _ in 0..ERROR_LINE {
            let full = self.wait(Duration::from_nanos(1), false).is_ok_and(|ready| ready.errors);
            if !full {
                break;
            }
            self.read_errors(log);
        }
        if !self.line.is_empty() {
            let line = std::mem::take(&mut self.line);
            keep(&line, &mut self.words, log);
        }
        End { how, words: self.words.clone(), is_filtered: self.is_filtered }
    }

    /// Says goodbye, waits a moment, and ends what is left.
    pub(crate) fn farewell(&mut self, patience: Duration) {
        let mut frame = Vec::new();
        if protocol::encode(&Request::Bye(protocol::Empty {}), &mut frame).is_ok() {
            // If it doesn't listen it is ended below.
            let _ = self.send(&mut &frame[..]);
        }
        self.stdin = None;
        let deadline = now() + patience;
        while self.reap(false).is_none() && now() < deadline {
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn signal(&self) {
        if self.role == Role::Command {
            // The leader may be gone while the group is not.
            let _ = rustix::process::kill_process_group(self.pid, Signal::KILL);
        }
        if self.ended.is_none() {
            let _ = rustix::process::kill_process(self.pid, Signal::KILL);
        }
    }

    /// Asks the system how the process ended; none while it runs.
    fn reap(&mut self, wait: bool) -> Option<ProcessEnd> {
        if self.ended.is_none() {
            let flags = if wait { 0 } else { libc::WNOHANG };
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

impl Drop for Process {
    fn drop(&mut self) {
        self.signal();
        self.reap(true);
    }
}

struct Ready {
    output: bool,
    errors: bool,
    input: bool,
}

/// Puts a line of standard error into the log and among the last words.
fn keep(line: &[u8], words: &mut Vec<String>, log: &mut Log) {
    /// Enough to find the reason of an end in.
    const WORDS: usize = 20;
    let text = String::from_utf8_lossy(line).trim_end().to_owned();
    if text.is_empty() {
        return;
    }
    log.write(LogLevel::Info, &format!("stderr: {text}"));
    if words.len() == WORDS {
        words.remove(0);
    }
    words.push(text);
}

#[allow(clippy::disallowed_methods, reason = "liveness only: a planner that answers is judged by its answer")]
fn now() -> Instant {
    Instant::now()
}

/// Has the system end the process when the harness is gone.
pub(crate) fn die_with_parent(command: &mut Command) {
    #[cfg(target_os = "linux")]
    {
        let ask = || {
            rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))?;
            Ok(())
        };
        // SAFETY: it makes one system call, which is allowed between fork and exec.
        unsafe { command.pre_exec(ask) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = command;
}
