//! A planner's process as the harness sees it: three pipes, none of which is trusted. What depends on the system is in
//! [`crate::system`].

use std::io;
use std::process::Command;
use std::time::{Duration, Instant};

use serde::Serialize;
use serde::de::DeserializeOwned;

use vb_sdk::LogLevel;
use vb_worker::protocol::{self, FrameError, HEADER, Reply, Request, WireLevel};

use crate::fault::ProcessEnd;
use crate::log::Log;
use crate::system::{Child, Role};

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
    Late,
    /// What it sent is no answer.
    Nonsense(FrameError),
    /// It sent a message that nothing asked for.
    Unasked(&'static str),
    /// The system refused to carry messages.
    System(io::Error),
}

#[derive(Clone, Debug)]
pub(crate) struct End {
    pub(crate) how: ProcessEnd,
    /// The last lines on standard error.
    pub(crate) words: Vec<String>,
    /// Whether its system calls were filtered, so that it couldn't end itself in every way.
    pub(crate) is_filtered: bool,
}

#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
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
    was_asked: bool,
}

impl Process {
    /// Starts a process whose messages may have `limit` bytes.
    pub(crate) fn start(command: Command, role: Role, limit: usize) -> io::Result<Self> {
        Ok(Self {
            child: Child::start(command, role)?,
            inbox: Vec::new(),
            outbox: Vec::new(),
            chunk: vec![0; CHUNK].into(),
            line: Vec::new(),
            words: Vec::new(),
            limit,
            is_filtered: false,
            was_asked: false,
        })
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
        let _place = self.child.stay_together();
        let result = self.exchange(&outbox, limit, log, Self::next_reply);
        self.outbox = outbox;
        result
    }

    /// Forbids a worker whose library is open to open any more files, where the system can. `is_filtered` is whether its
    /// system calls are.
    pub(crate) fn seal(&mut self, is_filtered: bool) -> io::Result<()> {
        self.is_filtered = is_filtered;
        self.child.seal()
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
            let ready = self.child.wait(left, !rest.is_empty()).map_err(Trouble::System)?;
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

    /// Writes what the pipe takes of `rest`.
    fn send(&mut self, rest: &mut &[u8]) -> Result<(), Trouble> {
        if self.child.is_input_closed() {
            return Err(Trouble::Gone);
        }
        while !rest.is_empty() {
            match self.child.write(rest) {
                Ok(0) => break,
                Ok(n) => *rest = &rest[n..],
                // Its last words may still be in the other pipes.
                Err(e) if e.kind() == io::ErrorKind::BrokenPipe => *rest = &[],
                Err(e) => return Err(Trouble::System(e)),
            }
        }
        Ok(())
    }

    /// Takes what is in the output; false at its end.
    fn read_output(&mut self) -> Result<bool, Trouble> {
        let read = self.child.read_output(&mut self.chunk).map_err(Trouble::System)?;
        self.inbox.extend_from_slice(&self.chunk[..read.unwrap_or(0)]);
        Ok(read != Some(0))
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
        let read = self.child.read_errors(&mut self.chunk).unwrap_or(0);
        for byte in self.chunk[..read].iter().copied() {
            if byte == b'\n' || self.line.len() == ERROR_LINE {
                let line = std::mem::take(&mut self.line);
                keep(&line, &mut self.words, log);
            }
            if byte != b'\n' {
                self.line.push(byte);
            }
        }
    }

    pub(crate) fn is_alive(&mut self) -> bool {
        self.child.ended().is_none()
    }

    /// Processor time that it has used; none where the system doesn't tell.
    pub(crate) fn cpu_time(&self) -> Option<Duration> {
        self.child.cpu_time()
    }

    /// Waits for the end of a process that has closed its output, ending it if it takes too long; then takes its last
    /// words.
    pub(crate) fn end(&mut self, log: &mut Log) -> End {
        let deadline = now() + GRACE;
        while self.is_alive() && now() < deadline {
            std::thread::sleep(Duration::from_millis(1));
        }
        let stayed = self.is_alive();
        let end = self.kill(log);
        if stayed { End { how: ProcessEnd::Mute, ..end } } else { end }
    }

    /// Ends the process at once and takes its last words.
    pub(crate) fn kill(&mut self, log: &mut Log) -> End {
        self.child.kill();
        let how = self.child.wait_for_end();
        // Descendants of a command may hold the pipe open: no waiting for its end.
        for _ in 0..ERROR_LINE {
            let full = self.child.wait(Duration::from_nanos(1), false).is_ok_and(|ready| ready.errors);
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
        self.child.close_input();
        let deadline = now() + patience;
        while self.is_alive() && now() < deadline {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
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
