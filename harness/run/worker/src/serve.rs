//! The worker: a process that opens one native plugin in a sandbox and answers requests until its input ends.

use std::io;
use std::os::fd::{AsFd as _, AsRawFd as _, OwnedFd};
use std::path::Path;
use std::process::ExitCode;

use serde::Serialize;
use vb_sdk::LogLevel;

use crate::calls::Functions;
use crate::library::{self, Planner};
use crate::protocol::{
    self, Empty, Failure, FailureKind, FrameError, Greeting, Introduction, LogLine, PROTOCOL, Reply, Request,
    WireLevel,
};
use crate::sandbox;

/// Runs the worker on standard input and output. Nothing else may run in the process, and no thread may have been
/// started: the process gives up all that it may do.
///
/// It ends with code 0 when the harness says so or goes away, and with code 1 when it is spoken to in another way.
pub fn serve() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let text = format!("planner worker: {error}\n");
            // There is nobody else to tell.
            let _ = rustix::io::write(rustix::stdio::stderr(), text.as_bytes());
            ExitCode::FAILURE
        }
    }
}

fn run() -> io::Result<()> {
    let mut channel = Channel::take_stdio()?;
    sandbox::isolate(channel.output.as_raw_fd())?;
    let greeting = match channel.read()? {
        Some(Request::Hello(greeting)) => greeting,
        Some(_) => return Err(io::Error::other("the first message is not hello")),
        None => return Ok(()),
    };
    let library = match open(&greeting) {
        Ok((library, introduction)) => {
            channel.write(&Reply::Hello(introduction))?;
            library
        }
        Err(failure) => return channel.write(&Reply::Error(failure)),
    };
    let mut planner: Option<Planner> = None;
    while let Some(request) = channel.read()? {
        let reply = match request {
            Request::Init(task) => {
                planner = None;
                match Planner::init(library, &task, &mut channel.log()) {
                    Ok(new) => {
                        planner = Some(new);
                        Reply::Ready(Empty {})
                    }
                    Err(failure) => Reply::Error(failure),
                }
            }
            Request::Step(observation) => match &mut planner {
                Some(planner) => match planner.step(&observation, &mut channel.log()) {
                    Ok(command) => Reply::Command(command),
                    Err(failure) => Reply::Error(failure),
                },
                None => return Err(io::Error::other("a step without a task")),
            },
            Request::Drop(_) => {
                planner = None;
                Reply::Dropped(Empty {})
            }
            Request::Hello(_) => return Err(io::Error::other("a second hello")),
            Request::Bye(_) => break,
        };
        channel.write(&reply)?;
    }
    Ok(())
}

fn open(greeting: &Greeting) -> Result<(Functions, Introduction), Failure> {
    let unloadable = |message: String| Failure { kind: FailureKind::Unloadable, message };
    let Some(wanted) = &greeting.library else {
        return Err(unloadable("the harness gave no library".into()));
    };
    if (greeting.abi.as_str(), greeting.protocol) != (vb_sdk::ABI_VERSION, PROTOCOL) {
        return Err(unloadable(format!(
            "the worker has protocol {PROTOCOL} and ABI {}, the harness {} and {}",
            vb_sdk::ABI_VERSION,
            greeting.protocol,
            greeting.abi
        )));
    }
    let path = Path::new(&wanted.path);
    let identity = library::Identity::of(path).map_err(|e| unloadable(format!("can't read it: {e}")))?;
    if identity.sha256 != wanted.sha256 {
        return Err(unloadable("its file has changed after the harness read it".into()));
    }
    let refused = |e: io::Error| Failure { kind: FailureKind::Sandbox, message: e.to_string() };
    let sandbox = sandbox::confine(path, wanted.memory_bytes).map_err(refused)?;
    let missing = sandbox.missing();
    if wanted.require_sandbox && !missing.is_empty() {
        let message = format!("this system cannot sandbox it with {}", missing.join(" and "));
        return Err(Failure { kind: FailureKind::Sandbox, message });
    }
    let library = library::open(path)?;
    if !identity.is_still(path) {
        return Err(unloadable("its file changed while it was opened".into()));
    }
    let introduction = Introduction {
        protocol: PROTOCOL,
        abi: vb_sdk::ABI_VERSION.to_owned(),
        sandbox: Some(sandbox),
        ..Introduction::default()
    };
    Ok((library, introduction))
}

/// The two pipes to the harness.
struct Channel {
    input: OwnedFd,
    output: OwnedFd,
    /// Bytes read that belong to the next message.
    inbox: Vec<u8>,
    outbox: Vec<u8>,
    chunk: Vec<u8>,
}

impl Channel {
    /// Takes standard input and output for itself. What the planner reads is empty from then on, and what it prints
    /// goes to standard error.
    fn take_stdio() -> io::Result<Self> {
        let dup = |fd| rustix::io::fcntl_dupfd_cloexec(fd, 3);
        let (input, output) = (dup(rustix::stdio::stdin())?, dup(rustix::stdio::stdout())?);
        let null = std::fs::File::open("/dev/null")?;
        rustix::stdio::dup2_stdin(null.as_fd())?;
        rustix::stdio::dup2_stdout(rustix::stdio::stderr())?;
        let (inbox, outbox, chunk) = (Vec::new(), Vec::new(), vec![0; 64 << 10]);
        Ok(Self { input, output, inbox, outbox, chunk })
    }

    /// The next request; none when the harness is gone.
    fn read(&mut self) -> io::Result<Option<Request>> {
        loop {
            // The harness is trusted, so that any length is believed.
            if let Some(payload) = protocol::payload(&self.inbox, usize::MAX).map_err(io::Error::other)? {
                let (request, used) = (protocol::decode(payload), protocol::HEADER + payload.len());
                self.inbox.drain(..used);
                return request.map(Some).map_err(io::Error::other);
            }
            match rustix::io::read(&self.input, &mut self.chunk[..]) {
                Ok(0) if self.inbox.is_empty() => return Ok(None),
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(n) => self.inbox.extend_from_slice(&self.chunk[..n]),
                Err(rustix::io::Errno::INTR) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }

    /// Sends a reply, after what the planner has printed.
    fn write(&mut self, reply: &Reply) -> io::Result<()> {
        // C keeps back what is printed without a flush, since standard error is a pipe here: it would be in the log of a
        // later task, or nowhere.
        // SAFETY: a null pointer stands for all streams, and C locks each of them.
        unsafe { libc::fflush(std::ptr::null_mut()) };
        send(&self.output, &mut self.outbox, reply)
    }

    /// Takes the planner's log lines. They are sent at once, since the planner may crash next.
    fn log(&mut self) -> impl FnMut(LogLevel, &str) {
        |level, message| {
            let level = match level {
                LogLevel::Error => WireLevel::Error,
                LogLevel::Warn => WireLevel::Warn,
                LogLevel::Info => WireLevel::Info,
                LogLevel::Debug => WireLevel::Debug,
            };
            let line = Reply::Log(LogLine { level, message: message.to_owned() });
            // If the harness is gone the next answer finds out.
            let _ = send(&self.output, &mut self.outbox, &line);
        }
    }
}

fn send<T: Serialize>(output: &OwnedFd, outbox: &mut Vec<u8>, message: &T) -> io::Result<()> {
    protocol::encode(message, outbox).map_err(|e: FrameError| io::Error::other(e))?;
    let mut rest = &outbox[..];
    while !rest.is_empty() {
        match rustix::io::write(output, rest) {
            Ok(n) => rest = &rest[n..],
            Err(rustix::io::Errno::INTR) => {}
            Err(e) => return Err(e.into()),
        }
    }
    Ok(())
}
