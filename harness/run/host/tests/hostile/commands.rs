//! Commands that do harm: shell scripts that send messages made beforehand.

use std::path::Path;

use vb_host::FaultCode::{self, *};
use vb_sdk::Command;
use vb_worker::protocol::{
    Empty, Failure, FailureKind, Greeting, Introduction, LogLine, PROTOCOL, Reply, Request, WireLevel, encode,
};

use crate::Ends::{self, *};
use crate::common::task;
use crate::{Case, Source, case};

/// Writes every message that the scripts send into a file of its name.
pub fn write_messages(dir: &Path) {
    let hello = Introduction {
        protocol: PROTOCOL,
        abi: vb_sdk::ABI_VERSION.into(),
        name: "script".into(),
        control_period: 0.1,
        ..Introduction::default()
    };
    let failure = |kind| Reply::Error(Failure { kind, message: "no way \u{1b}[2J".into() });
    let messages = [
        ("old", Reply::Hello(Introduction { abi: "0.0".into(), ..hello.clone() })),
        ("foreign", Reply::Hello(Introduction { protocol: 99, ..hello.clone() })),
        ("nameless", Reply::Hello(Introduction { name: "../..".into(), ..hello.clone() })),
        ("hasty", Reply::Hello(Introduction { control_period: -0.1, ..hello.clone() })),
        ("greedy", Reply::Hello(Introduction { needs: vec!["radar 10".into()], ..hello.clone() })),
        ("hello", Reply::Hello(hello)),
        ("ready", Reply::Ready(Empty {})),
        ("dropped", Reply::Dropped(Empty {})),
        ("nan", Reply::Command(Command { brake: f64::NAN, ..Command::default() })),
        ("sideways", Reply::Command(Command::default())),
        ("error", failure(FailureKind::Error)),
        ("panic", failure(FailureKind::Panic)),
        ("line", Reply::Log(LogLine { level: WireLevel::Info, message: "la".repeat(100) })),
    ];
    for (name, message) in messages {
        let mut bytes = Vec::new();
        encode(&message, &mut bytes).unwrap();
        if name == "sideways" {
            let gear = bytes.windows(7).position(|w| w == b"forward").unwrap();
            bytes[gear..gear + 7].copy_from_slice(b"sideway");
        }
        std::fs::write(dir.join(name), bytes).unwrap();
    }
}

fn script(name: &'static str, text: &str, ends: Ends, code: FaultCode, says: &'static str) -> Case {
    case(name, Source::Script(text.to_owned()), ends, code, says)
}

pub fn table() -> Vec<Case> {
    let length = |request| {
        let mut frame = Vec::new();
        encode(&request, &mut frame).unwrap();
        frame.len()
    };
    let greeting = Greeting { protocol: PROTOCOL, abi: vb_sdk::ABI_VERSION.into(), library: None };
    // Waits until it is asked for a task, and until it is asked for a command: the former requests have come, and the
    // length of the next.
    let asked = format!("cat hello; head -c {} > /dev/null", length(Request::Hello(greeting)) + 4);
    let init = length(Request::Init(Box::new(task())));
    let set_off = format!("{asked}; cat ready; head -c {init} > /dev/null");
    // The rest of what is asked is read, so that the harness can write it, and the output stays open.
    let rest = "exec cat 3>&1 > /dev/null";
    vec![
        script("a command that leaves", "exit 3", Load, Unloadable, "exit code 3"),
        script("a command that prints", "echo hello", Load, Protocol, "print to standard error"),
        script("a command that repeats the question", "exec cat", Load, NotAPlugin, "its name is ``"),
        script(
            "a command of zeros",
            "exec head -c 4096 /dev/zero",
            Load,
            Protocol,
            "docs/worker-protocol.md",
        ),
        script(
            "a command with three bytes too many",
            "head -c 3 /dev/zero; exec cat hello",
            Load,
            InvalidOutput,
            "",
        ),
        script(
            "a command with a message that is too long",
            r"printf '\377\377\377\177'; exec cat",
            Load,
            InvalidOutput,
            "1114112",
        ),
        script("a command of another version", "exec cat old", Load, AbiMismatch, "ABI 0.0"),
        script("a command of another protocol", "exec cat foreign", Load, NotAPlugin, "version 99"),
        script(
            "a command whose name is a path",
            "exec cat nameless",
            Load,
            NotAPlugin,
            "its name is `../..`",
        ),
        script(
            "a command that asks for a sensor that there isn't",
            "exec cat greedy",
            Load,
            NotAPlugin,
            "radar",
        ),
        script("a command of a period below 0", "exec cat hasty", Load, NotAPlugin, "-0.1"),
        script(
            "a command that closes its output and stays",
            "cat hello; exec sleep 1000 >&-",
            Init,
            Crashed,
            "was killed",
        ),
        script("a command that leaves after its name", "exec cat hello", Init, Crashed, "code 0"),
        script("a command that never is ready", &format!("cat hello; {rest}"), Init, Hung, "1500"),
        script(
            "a command that is always ready",
            &format!("{asked}; cat ready ready; {rest}"),
            Step,
            Protocol,
            "ready",
        ),
        script(
            "a command whose brake is no number",
            &format!("{set_off}; cat nan; {rest}"),
            Step,
            InvalidOutput,
            "brake is NaN",
        ),
        script(
            "a command with a gear that there isn't",
            &format!("{set_off}; cat sideways; {rest}"),
            Step,
            Protocol,
            "unknown variant `sideway`, expected one of `forward`, `neutral`, `reverse`",
        ),
        script(
            "a command that leaves a child behind",
            "cat hello; sleep 1000 & exec sleep 1000",
            Init,
            Hung,
            "1500",
        ),
        script(
            "a command that forgets too soon",
            &format!("{asked}; cat dropped; {rest}"),
            Init,
            Protocol,
            "dropped",
        ),
        script(
            "a command that fails in init",
            &format!("{asked}; cat error; {rest}"),
            Init,
            InitFailed,
            "no way",
        ),
        script("a command that panics", &format!("{asked}; cat panic; {rest}"), Init, Panic, "no way"),
        script("a command of endless log", "cat hello; while cat line; do :; done", Init, Hung, "1500"),
        script(
            "a command without memory",
            "cat hello; echo MemoryError >&2; exit 1",
            Init,
            OutOfMemory,
            "ran out of memory",
        ),
    ]
}
