//! The messages between the harness and a planner in another process, and how they are framed.
//!
//! A frame is the length of what follows, four bytes, least significant first, and one [MessagePack] value: a map with
//! one entry, whose key is the kind of the message and whose value is a map of its fields. Unknown fields are ignored,
//! so that later versions may add some. MessagePack's 64-bit floats carry every bit of an `f64`. `docs/worker-protocol.md`
//! is the text for authors of planners.
//!
//! [MessagePack]: https://github.com/msgpack/msgpack/blob/master/spec.md

use std::fmt;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::sandbox::SandboxReport;
use vb_sdk::{Command, Observation, Task};

/// Version of the protocol. A message or field that an old peer can't ignore is a new version.
pub const PROTOCOL: u32 = 1;

/// Bytes of a frame before its payload.
pub const HEADER: usize = 4;

/// What the harness sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// Comes first and is answered by [`Reply::Hello`].
    Hello(Greeting),
    /// Starts a planner on a task; answered by [`Reply::Ready`].
    Init(Box<Task>),
    /// Asks for a command; answered by [`Reply::Command`].
    Step(Box<Observation>),
    /// Ends the task: the planner forgets it; answered by [`Reply::Dropped`]. Another task may follow.
    Drop(Empty),
    /// The end: the process leaves.
    Bye(Empty),
}

/// The requests with data, as the harness writes them: like those of [`Request`], without a copy of what they carry.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Asked<'a> {
    /// [`Request::Init`].
    Init(&'a Task),
    /// [`Request::Step`].
    Step(&'a Observation),
}

/// What a planner sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// Answers [`Request::Hello`].
    Hello(Introduction),
    /// The planner is ready for the first step.
    Ready(Empty),
    /// What the planner wants done.
    Command(Command),
    /// The task is forgotten.
    Dropped(Empty),
    /// The request failed. After a failed `init` or `step` the task is over.
    Error(Failure),
    /// A line for the task's log; no answer to anything. May come at any time.
    Log(LogLine),
}

impl Reply {
    /// The name of the message, for texts.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Hello(_) => "hello",
            Self::Ready(_) => "ready",
            Self::Command(_) => "command",
            Self::Dropped(_) => "dropped",
            Self::Error(_) => "error",
            Self::Log(_) => "log",
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Empty {}

/// The harness says what it speaks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Greeting {
    /// [`PROTOCOL`].
    pub protocol: u32,
    /// Version of the planner interface, e.g. `0.1`: the meaning of task, observation and command.
    pub abi: String,
    /// The library to open, for the harness's own worker only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<Library>,
}

/// A native plugin and what it may use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Library {
    /// Absolute path of the file.
    pub path: String,
    /// SHA-256 of what it must hold, hexadecimal.
    pub sha256: String,
    /// Memory that the planner may allocate, bytes, beside what the worker takes.
    pub memory_bytes: u64,
    /// Whether to give up where the system can't confine the library in every way.
    pub require_sandbox: bool,
}

/// A planner says what it is. All but `protocol` and `abi` are for commands, which have no metadata to be read
/// without running them; the harness's own worker leaves them empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Introduction {
    /// [`PROTOCOL`].
    pub protocol: u32,
    /// Version of the planner interface.
    pub abi: String,
    /// The planner's name: `a-z`, `0-9`, `-` and `_`.
    pub name: String,
    pub version: String,
    pub authors: Vec<String>,
    /// One sentence on what it does.
    pub about: String,
    /// Wanted time between two steps, s; a positive multiple of 0.001.
    pub control_period: f64,
    /// Parameters that a user may set.
    pub params: Vec<WireParamSpec>,
    /// Sensors that the planner asks for, e.g. `lidar 10`.
    pub needs: Vec<String>,
    /// The same for profiles that leave out one of the task's maps.
    pub needs_without_maps: Vec<String>,
    /// The learned weights that the planner has, with their hashes.
    pub models: Vec<String>,
    /// How the process is confined; the harness's own worker only.
    pub sandbox: Option<SandboxReport>,
}

/// A parameter that a planner declares.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct WireParamSpec {
    pub key: String,
    /// Value when the user sets none.
    pub default: String,
    /// What it means, with its unit.
    pub help: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    pub kind: FailureKind,
    /// One line.
    pub message: String,
}

/// Kinds of [`Failure`]. Planners send `error` and `panic`; the rest comes from the harness's own worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FailureKind {
    /// The planner returned an error.
    Error,
    /// The planner panicked, or left an exception uncaught.
    Panic,
    /// The planner's command holds a value that there isn't.
    InvalidOutput,
    /// The planner used something that it doesn't get; the message is the number of the system call.
    Denied,
    /// The library exports no planner.
    NotAPlugin,
    /// The library lays its data out in another way.
    LayoutMismatch,
    /// The system can't open the library.
    Unloadable,
    /// The system can't confine the process as wanted.
    Sandbox,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogLine {
    pub level: WireLevel,
    pub message: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WireLevel {
    Error,
    Warn,
    Info,
    Debug,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The frame is longer than allowed.
    TooLong {
        /// Bytes that it claims to have.
        bytes: usize,
        /// Bytes that it may have.
        limit: usize,
    },
    /// The payload is no message of the protocol.
    Malformed(String),
}

/// How the text of [`FrameError::Malformed`] begins.
pub const MALFORMED: &str = "a message can't be read";

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { bytes, limit } => {
                write!(f, "a message has {bytes} bytes; at most {limit} are allowed")
            }
            Self::Malformed(text) => write!(f, "{MALFORMED}: {text}"),
        }
    }
}

impl std::error::Error for FrameError {}

/// Puts a message as a frame into `out`, replacing what was there.
///
/// # Errors
/// If the message is longer than a frame can be (4 GiB); never for a good message.
pub fn encode<T: Serialize>(message: &T, out: &mut Vec<u8>) -> Result<(), FrameError> {
    out.clear();
    out.extend([0; HEADER]);
    let mut serializer = rmp_serde::Serializer::new(&mut *out).with_struct_map();
    message.serialize(&mut serializer).map_err(|e| FrameError::Malformed(e.to_string()))?;
    let bytes = out.len() - HEADER;
    let length = u32::try_from(bytes).map_err(|_| FrameError::TooLong { bytes, limit: u32::MAX as usize })?;
    out[..HEADER].copy_from_slice(&length.to_le_bytes());
    Ok(())
}

/// The payload at the start of `bytes`, when all of it is there.
///
/// # Errors
/// If the frame claims more than `limit` bytes; nothing is read or reserved for it then.
pub fn payload(bytes: &[u8], limit: usize) -> Result<Option<&[u8]>, FrameError> {
    let Some((header, rest)) = bytes.split_first_chunk::<HEADER>() else { return Ok(None) };
    let length = u32::from_le_bytes(*header) as usize;
    if length > limit {
        return Err(FrameError::TooLong { bytes: length, limit });
    }
    Ok(rest.get(..length))
}

/// Reads the message of a payload.
///
/// # Errors
/// If it is no message of the protocol, or something follows it.
pub fn decode<T: DeserializeOwned>(mut payload: &[u8]) -> Result<T, FrameError> {
    /// Real messages are four deep.
    const DEPTH: usize = 32;
    let mut deserializer = rmp_serde::Deserializer::new(&mut payload);
    deserializer.set_max_depth(DEPTH);
    let message = T::deserialize(&mut deserializer).map_err(|e| FrameError::Malformed(e.to_string()))?;
    if payload.is_empty() {
        Ok(message)
    } else {
        Err(FrameError::Malformed(format!("{} bytes follow it", payload.len())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vb_sdk::{Command, Gear, Observation, Series, Wheel};

    fn through<T: Serialize + DeserializeOwned>(message: &T) -> T {
        let mut frame = Vec::new();
        encode(message, &mut frame).unwrap();
        decode(payload(&frame, 1 << 20).unwrap().unwrap()).unwrap()
    }

    #[test]
    fn every_bit_of_a_number_crosses() {
        // Signs of zero, subnormals, infinities and the payload of a NaN.
        let odd =
            [0x8000_0000_0000_0000, 1, 0x7ff0_0000_0000_0000, 0x7ff8_dead_beef_0001, 0xbff0_0000_0000_0001];
        for bits in odd {
            let x = f64::from_bits(bits);
            let observation = Observation {
                time: x,
                last_brake: x,
                wheels: vec![Wheel { spin: x, travel: -x }],
                ..Observation::default()
            };
            let Request::Step(back) = through(&Request::Step(Box::new(observation.clone()))) else {
                panic!()
            };
            let numbers = |o: &Observation| {
                [o.time, o.last_brake, o.wheels[0].spin, o.wheels[0].travel].map(f64::to_bits)
            };
            assert_eq!(numbers(&back), numbers(&observation));
            let narrow = f32::from_bits((bits >> 32) as u32 | 1);
            let debug = vec![Series { name: "s".into(), values: vec![narrow] }];
            let command = Command { steering: x, throttle: -x, brake: x, gear: Gear::Reverse, debug };
            let Reply::Command(back) = through(&Reply::Command(command.clone())) else { panic!() };
            let numbers = |c: &Command| [c.steering, c.throttle, c.brake].map(f64::to_bits);
            assert_eq!(numbers(&back), numbers(&command));
            assert_eq!(back.debug[0].values[0].to_bits(), narrow.to_bits());
        }
    }

    #[test]
    fn a_message_is_a_map_of_its_name_to_a_map_of_its_fields() {
        // By hand from the MessagePack specification: fixmap 0x81, fixstr 0xa0 | length, fixmap.
        let mut frame = Vec::new();
        encode(&Reply::Ready(Empty {}), &mut frame).unwrap();
        assert_eq!(frame, b"\x08\0\0\0\x81\xa5ready\x80");
        let line = LogLine { level: WireLevel::Warn, message: "hm".into() };
        encode(&Reply::Log(line), &mut frame).unwrap();
        assert_eq!(frame[HEADER..], *b"\x81\xa3log\x82\xa5level\xa4warn\xa7message\xa2hm");
    }

    #[test]
    fn what_other_languages_write_for_a_command_is_understood() {
        // Integers for floats, no debug data, and a field that this version doesn't know.
        let text =
            b"\x81\xa7command\x84\xa8steering\xff\xa8throttle\x01\xa5brake\xcb\0\0\0\0\0\0\0\0\xa4more\xc0";
        let Reply::Command(command) = decode::<Reply>(text).unwrap() else { panic!() };
        let expected = Command { steering: -1.0, throttle: 1.0, ..Command::default() };
        assert_eq!(command, expected);
    }

    #[test]
    fn a_frame_waits_for_its_end_and_none_is_longer_than_allowed() {
        let mut frame = Vec::new();
        encode(&Reply::Ready(Empty {}), &mut frame).unwrap();
        for cut in 0..frame.len() {
            assert_eq!(payload(&frame[..cut], 100), Ok(None), "{cut}");
        }
        assert_eq!(payload(&frame, 8), Ok(Some(&frame[HEADER..])));
        assert_eq!(payload(&frame, 7), Err(FrameError::TooLong { bytes: 8, limit: 7 }));
        let claims = u32::MAX.to_le_bytes();
        assert_eq!(payload(&claims, 100), Err(FrameError::TooLong { bytes: u32::MAX as usize, limit: 100 }));
    }

    #[test]
    fn lengths_that_lie_and_deep_nesting_are_refused() {
        // An array of 2^32-1 values; a string of 4 GiB; a thousand arrays in one another; two messages in a frame.
        let array = b"\x81\xa7command\x81\xa5debug\xdd\xff\xff\xff\xff";
        let string = b"\x81\xa5error\x81\xa7message\xdb\xff\xff\xff\xff";
        let mut deep = b"\x81\xa7command\x81\xa4more".to_vec();
        deep.extend([0x91; 1000]);
        for bytes in [&array[..], &string[..], &deep[..], b"\x81\xa5ready\x80\x81\xa5ready\x80", b"", b"\xc1"]
        {
            assert!(matches!(decode::<Reply>(bytes), Err(FrameError::Malformed(_))), "{bytes:?}");
        }
    }

    proptest! {
        #[test]
        fn random_bytes_are_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode::<Reply>(&bytes);
            let _ = decode::<Request>(&bytes);
            let _ = payload(&bytes, 100);
        }
    }
}
