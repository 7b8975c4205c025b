//! Messages of a planner's process.

use vb_sdk::{Command, Observation, Wheel};
use vb_worker::protocol::{
    Empty, Failure, FailureKind, Introduction, LogLine, Reply, Request, WireLevel, decode, encode, payload,
};

/// Frames one after the other, as they come from a pipe; a frame that can't be read ends the conversation.
pub(crate) fn run(data: &[u8]) {
    const LIMIT: usize = 1 << 20;
    let mut rest = data;
    while let Ok(Some(bytes)) = payload(rest, LIMIT) {
        let (reply, request) = (decode::<Reply>(bytes), decode::<Request>(bytes));
        match reply {
            Ok(_) => {}
            Err(_) if request.is_ok() => {}
            Err(_) => return,
        }
        rest = &rest[4 + bytes.len()..];
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let frame = |reply: &Reply| {
        let mut out = Vec::new();
        encode(reply, &mut out).map(|()| out).unwrap_or_default()
    };
    let line = LogLine { level: WireLevel::Info, message: "a line".into() };
    let debug = vec![vb_sdk::Series { name: "s".into(), values: vec![1.0, 2.0] }];
    let command = Command { steering: 0.5, throttle: 1.0, brake: 0.0, debug, ..Command::default() };
    let observation = Observation { wheels: vec![Wheel::default(); 4], ..Observation::default() };
    let failure = Failure { kind: FailureKind::Error, message: "no path".into() };
    let replies = [
        Reply::Hello(Introduction { name: "x".into(), ..Introduction::default() }),
        Reply::Ready(Empty {}),
        Reply::Log(line),
        Reply::Command(command),
        Reply::Dropped(Empty {}),
        Reply::Error(failure),
    ];
    let mut seeds: Vec<Vec<u8>> = replies.iter().map(frame).collect();
    seeds.push(seeds.concat());
    for request in [Request::Init(Box::default()), Request::Step(Box::new(observation))] {
        let mut out = Vec::new();
        if encode(&request, &mut out).is_ok() {
            seeds.push(out);
        }
    }
    seeds
}
