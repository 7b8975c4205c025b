//! Processes by means of the standard library alone: a thread for each pipe.

use std::collections::VecDeque;
use std::io::{self, Read, Write as _};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use vb_files::lock;

use super::{Ready, Role};
use crate::fault::ProcessEnd;

/// Whether there are native planners: the worker opens libraries as Unix systems do.
pub(crate) const HAS_NATIVE_PLANNERS: bool = false;
/// Bytes that wait between a pipe and the harness at most; a process that writes more waits.
const WAITING: usize = 1 << 20;
/// How long the last words of a process that has ended may take through its pipe.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// A process with its three pipes, none of which blocks.
#[derive(Debug)]
pub(crate) struct Child {
    process: std::process::Child,
    pipes: Arc<Pipes>,
    ended: Option<ProcessEnd>,
}

/// What the threads at the pipes and the harness share.
#[derive(Debug, Default)]
struct Pipes {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    input: Input,
    output: Stream,
    errors: Stream,
    /// Nobody takes anything any more.
    is_abandoned: bool,
}

#[derive(Debug, Default)]
struct Input {
    /// What the pipe hasn't taken yet.
    waiting: Vec<u8>,
    is_closed: bool,
    /// Nobody reads it any more.
    is_broken: bool,
}

/// What came from a pipe and wasn't taken yet.
#[derive(Debug, Default)]
struct Stream {
    waiting: VecDeque<u8>,
    is_at_end: bool,
}

impl Stream {
    fn is_ready(&self) -> bool {
        self.is_at_end || !self.waiting.is_empty()
    }

    fn take(&mut self, into: &mut [u8]) -> Option<usize> {
        if !self.is_ready() {
            return None;
        }
        // Reading a queue never fails.
        self.waiting.read(into).ok()
    }
}

/// There is no better place for a thread.
pub(crate) enum Together {}

/// Readies a command for its role; there is nothing that would be done here.
pub(crate) fn prepare(_: &mut Command, _: Role) {}

impl Child {
    pub(crate) fn start(mut command: Command, _: Role) -> io::Result<Self> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn()?;
        let (Some(stdin), Some(stdout), Some(stderr)) =
            (process.stdin.take(), process.stdout.take(), process.stderr.take())
        else {
            return Err(io::Error::other("a process without pipes"));
        };
        // From here on it is ended if something fails.
        let child = Self { process, pipes: Arc::default(), ended: None };
        let thread = |name: &str, work: Box<dyn FnOnce(&Pipes) + Send>| {
            let pipes = Arc::clone(&child.pipes);
            std::thread::Builder::new().name(name.to_owned()).spawn(move || work(&pipes)).map(|_| ())
        };
        thread("vb-input", Box::new(move |pipes| pipes.carry_input(stdin)))?;
        thread("vb-output", Box::new(move |pipes| pipes.carry(stdout, |state| &mut state.output)))?;
        thread("vb-errors", Box::new(move |pipes| pipes.carry(stderr, |state| &mut state.errors)))?;
        Ok(child)
    }

    /// Forbids nothing: no worker of native planners runs here.
    #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "it is as on Unix")]
    pub(crate) fn seal(&self) -> io::Result<()> {
        Ok(())
    }

    /// Puts nothing anywhere: the system alone says where threads run.
    #[allow(clippy::unused_self, reason = "it is as on Unix")]
    pub(crate) fn stay_together(&mut self) -> Option<Together> {
        None
    }

    /// Writes to standard input; how many bytes it took, which may be none.
    ///
    /// # Errors
    /// [`io::ErrorKind::BrokenPipe`] when nobody reads it any more.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.pipes.lock();
        if state.input.is_broken || state.input.is_closed {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let taken = bytes.len().min(WAITING.saturating_sub(state.input.waiting.len()));
        state.input.waiting.extend_from_slice(&bytes[..taken]);
        self.pipes.changed.notify_all();
        Ok(taken)
    }

    pub(crate) fn close_input(&mut self) {
        self.pipes.lock().input.is_closed = true;
        self.pipes.changed.notify_all();
    }

    /// Whether standard input was closed by this side.
    pub(crate) fn is_input_closed(&self) -> bool {
        self.pipes.lock().input.is_closed
    }

    /// Takes output; how many bytes came, which is 0 at its end, and none where there is nothing now.
    #[allow(clippy::unnecessary_wraps, reason = "it is as on Unix")]
    pub(crate) fn read_output(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        let read = self.pipes.lock().output.take(into);
        self.pipes.changed.notify_all();
        Ok(read)
    }

    /// Takes what is on standard error in the same way.
    pub(crate) fn read_errors(&mut self, into: &mut [u8]) -> Option<usize> {
        let read = self.pipes.lock().errors.take(into);
        self.pipes.changed.notify_all();
        read
    }

    /// Waits until something can be done with the pipes; with standard input only if there is something to write.
    #[allow(clippy::unnecessary_wraps, reason = "it is as on Unix")]
    pub(crate) fn wait(&self, limit: Duration, writing: bool) -> io::Result<Ready> {
        let ready = |state: &State| Ready {
            output: state.output.is_ready(),
            // Its end is told once by the output, which ends with it, and not again and again.
            errors: !state.errors.waiting.is_empty(),
            input: writing && (state.input.waiting.is_empty() || state.input.is_broken),
        };
        let idle = |state: &mut State| ready(state) == Ready::default();
        let state = self.pipes.lock();
        let (state, _) =
            self.pipes.changed.wait_timeout_while(state, limit, idle).unwrap_or_else(PoisonError::into_inner);
        Ok(ready(&state))
    }

    /// Processor time that it has used: the standard library doesn't tell.
    #[allow(clippy::unused_self, reason = "it is as on Unix")]
    pub(crate) fn cpu_time(&self) -> Option<Duration> {
        None
    }

    /// Ends it at once; not its descendants.
    pub(crate) fn kill(&mut self) {
        if self.ended.is_none() {
            // It fails only where the process is gone.
            let _ = self.process.kill();
        }
    }

    /// How it ended; none while it runs.
    pub(crate) fn ended(&mut self) -> Option<ProcessEnd> {
        if self.ended.is_none() {
            self.ended = self.process.try_wait().ok().flatten().map(end_of);
        }
        self.ended
    }

    /// Waits for its end, and a moment for its last words, which are still on their way.
    pub(crate) fn wait_for_end(&mut self) -> ProcessEnd {
        let wait = |process: &mut std::process::Child| process.wait().map_or(ProcessEnd::Mute, end_of);
        let how = *self.ended.get_or_insert_with(|| wait(&mut self.process));
        // Descendants may hold the pipe open.
        let on_their_way = |s: &mut State| !s.errors.is_at_end && s.errors.waiting.len() < WAITING;
        let state = self.pipes.lock();
        drop(self.pipes.changed.wait_timeout_while(state, LAST_WORDS, on_their_way));
        how
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
        self.wait_for_end();
        // Lets the threads at the pipes end.
        self.pipes.lock().is_abandoned = true;
        self.close_input();
    }
}

impl Pipes {
    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    fn wait_while(&self, busy: impl FnMut(&mut State) -> bool) -> MutexGuard<'_, State> {
        self.changed.wait_while(self.lock(), busy).unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what is to be written until standard input is closed.
    fn carry_input(&self, mut stdin: ChildStdin) {
        loop {
            let mut state = self.wait_while(|s| s.input.waiting.is_empty() && !s.input.is_closed);
            let bytes = std::mem::take(&mut state.input.waiting);
            let is_last = state.input.is_closed;
            drop(state);
            let written = stdin.write_all(&bytes).and_then(|()| stdin.flush());
            self.lock().input.is_broken |= written.is_err();
            self.changed.notify_all();
            if is_last || written.is_err() {
                return;
            }
        }
    }

    /// Reads a pipe to its end.
    fn carry(&self, mut pipe: impl Read, of: impl Fn(&mut State) -> &mut Stream) {
        let mut chunk = vec![0; 64 << 10];
        loop {
            let read = match pipe.read(&mut chunk) {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                other => other.unwrap_or(0),
            };
            let mut state = self.wait_while(|s| of(s).waiting.len() >= WAITING && !s.is_abandoned);
            if state.is_abandoned {
                return;
            }
            let stream = of(&mut state);
            stream.waiting.extend(&chunk[..read]);
            stream.is_at_end = read == 0;
            self.changed.notify_all();
            if read == 0 {
                return;
            }
        }
    }
}

fn end_of(status: std::process::ExitStatus) -> ProcessEnd {
    status.code().map_or(ProcessEnd::Mute, ProcessEnd::Exit)
}

/// Whether a process was killed: its exit code doesn't tell it from one that ended by itself.
pub(crate) fn was_killed(_: ProcessEnd) -> bool {
    false
}

/// Whether a process was killed by somebody else.
pub(crate) fn was_killed_by_others(_: ProcessEnd) -> bool {
    false
}

/// Whether a process died since it used up its processor time, of which there is no limit.
pub(crate) fn used_up_time(_: ProcessEnd) -> bool {
    false
}

/// Bytes that the stack of a process may have; the standard library doesn't tell.
pub(crate) fn stack_limit() -> Option<u64> {
    None
}

/// Bytes of memory that the system lets a process have: it sets no limit.
pub(crate) fn memory_granted() -> Option<u64> {
    None
}

/// Whether this is the system's own word for what it can't do.
pub(crate) fn is_refusal(error: &(dyn std::error::Error + 'static)) -> bool {
    error.is::<io::Error>()
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(20);

    fn shell(script: &str) -> Child {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Child::start(command, Role::Command).unwrap()
    }

    /// All output until its end, and all of standard error that came until then.
    fn all(child: &mut Child) -> (Vec<u8>, Vec<u8>) {
        let (mut output, mut errors, mut chunk) = (Vec::new(), Vec::new(), [0; 1000]);
        loop {
            let ready = child.wait(PATIENCE, false).unwrap();
            assert!(ready.output || ready.errors, "nothing came");
            if ready.errors {
                let n = child.read_errors(&mut chunk).unwrap();
                errors.extend_from_slice(&chunk[..n]);
            }
            match child.read_output(&mut chunk).unwrap() {
                Some(0) => return (output, errors),
                Some(n) => output.extend_from_slice(&chunk[..n]),
                None => {}
            }
        }
    }

    #[test]
    fn what_goes_in_comes_out_however_much_it_is() {
        let mut child = shell("cat");
        let sent: Vec<u8> = (0..5_000_000u32).map(|n| (n % 251) as u8).collect();
        let (mut rest, mut output, mut chunk) = (&sent[..], Vec::new(), [0; 4096]);
        while output.len() < sent.len() {
            let ready = child.wait(PATIENCE, !rest.is_empty()).unwrap();
            assert_ne!(ready, Ready::default(), "stuck at {} of {}", output.len(), sent.len());
            if ready.input {
                let taken = child.write(rest).unwrap();
                rest = &rest[taken..];
            }
            let read = child.read_output(&mut chunk).unwrap().unwrap_or(0);
            output.extend_from_slice(&chunk[..read]);
        }
        assert!(output == sent);
        child.close_input();
        assert_eq!(all(&mut child).0, b"");
        assert_eq!(child.wait_for_end(), ProcessEnd::Exit(0));
    }

    #[test]
    fn its_end_and_its_last_words_are_told() {
        let mut child = shell("echo out; echo why >&2; sleep 0.2; exit 7");
        let (output, errors) = all(&mut child);
        assert_eq!((&output[..], &errors[..]), (&b"out\n"[..], &b"why\n"[..]));
        assert_eq!((child.wait_for_end(), child.ended()), (ProcessEnd::Exit(7), Some(ProcessEnd::Exit(7))));
        while child.write(b"x").is_ok() {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(child.write(b"x").unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }

    #[test]
    fn one_that_floods_or_stays_is_waited_for_no_longer_than_said_and_ended() {
        let child = shell("yes");
        assert!(child.wait(PATIENCE, false).unwrap().output);
        std::thread::sleep(Duration::from_millis(200));
        let waiting = child.pipes.lock().output.waiting.len();
        assert!((1..=WAITING + (64 << 10)).contains(&waiting), "{waiting}");
        drop(child);
        let mut child = shell("exec sleep 100");
        assert_eq!(child.wait(Duration::from_millis(10), false).unwrap(), Ready::default());
        assert_eq!(child.ended(), None);
        child.kill();
        child.wait_for_end();
        assert!(child.ended().is_some());
    }
}
