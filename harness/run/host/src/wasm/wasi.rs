//! WASI for planners from toolchains whose standard libraries can't do without: an empty, deterministic world.
//!
//! There are no files, arguments, environment variables or network. Clocks show simulated time, random numbers come
//! from the task's seed, and what is written to standard output and error goes to the task's log. Waiting for a time
//! returns at once. Every call is paid for in fuel.
//!
//! The interfaces are those of WASI 0.2, whatever the patch version. What isn't here (HTTP, say) is refused when the
//! plugin is loaded; functions of these interfaces that only make sense with files or a network say "access denied",
//! or end the task if they have no way to say it.

use vb_sdk::LogLevel;
use wasmtime::component::types::{ComponentFunc, ComponentInstance, ComponentItem};
use wasmtime::component::{
    Component, ComponentType, Linker, LinkerInstance, Lower, Resource, ResourceType, Type, Val,
};
use wasmtime::{Engine, Error, StoreContextMut};

use super::state::{State, pay};
use crate::fault::{FaultCause, ProcessEnd};

const INTERFACES: [&str; 27] = [
    "cli/environment",
    "cli/exit",
    "cli/stdin",
    "cli/stdout",
    "cli/stderr",
    "cli/terminal-input",
    "cli/terminal-output",
    "cli/terminal-stdin",
    "cli/terminal-stdout",
    "cli/terminal-stderr",
    "clocks/monotonic-clock",
    "clocks/wall-clock",
    "filesystem/preopens",
    "filesystem/types",
    "io/error",
    "io/poll",
    "io/streams",
    "random/insecure",
    "random/insecure-seed",
    "random/random",
    "sockets/instance-network",
    "sockets/ip-name-lookup",
    "sockets/network",
    "sockets/tcp",
    "sockets/tcp-create-socket",
    "sockets/udp",
    "sockets/udp-create-socket",
];

/// Step of the clocks: that of the simulation, ns.
const RESOLUTION_NS: u64 = 1_000_000;
/// Bytes that a stream takes at a time.
const CHUNK_BYTES: u64 = 4096;
/// Text of one stream that is kept until its line ends, bytes.
const LINE_BYTES: usize = 4096;
/// Representations of the output streams.
const STDOUT: u32 = 1;
const STDERR: u32 = 2;

struct InputStream;
struct OutputStream;
struct Pollable;
struct IoError;

#[derive(ComponentType, Lower)]
#[component(variant)]
enum StreamError {
    #[allow(dead_code, reason = "part of the interface's type")]
    #[component(name = "last-operation-failed")]
    LastOperationFailed(Resource<IoError>),
    #[component(name = "closed")]
    Closed,
}

#[derive(ComponentType, Lower)]
#[component(record)]
struct Datetime {
    seconds: u64,
    nanoseconds: u32,
}

impl State {
    fn write(&mut self, stream: u32, bytes: &[u8]) {
        let (level, line) = match stream {
            STDERR => (LogLevel::Warn, &mut self.wasi.err),
            _ => (LogLevel::Info, &mut self.wasi.out),
        };
        for &byte in bytes {
            if byte != b'\n' {
                line.push(byte);
            }
            if (byte == b'\n' && !line.is_empty()) || line.len() == LINE_BYTES {
                self.log.write(level, &String::from_utf8_lossy(line));
                line.clear();
            }
        }
        if stream == STDERR {
            let room = LINE_BYTES.saturating_sub(self.wasi.report.len());
            self.wasi.report.extend(&bytes[..bytes.len().min(room)]);
        }
    }

    /// Writes lines that haven't ended to the log, as a call ends.
    pub(super) fn flush_output(&mut self) {
        for stream in [STDOUT, STDERR] {
            let line = if stream == STDERR { &self.wasi.err } else { &self.wasi.out };
            if !line.is_empty() {
                self.write(stream, b"\n");
            }
        }
        let report = std::mem::take(&mut self.wasi.report);
        self.note_report(&String::from_utf8_lossy(&report));
    }
}

/// The interface's name without package prefix and version, if it is one of those that are here.
pub(super) fn interface(import: &str) -> Option<&'static str> {
    let (name, version) = import.strip_prefix("wasi:")?.split_once('@')?;
    INTERFACES.into_iter().find(|known| *known == name && version.starts_with("0.2."))
}

/// Gives the linker those WASI interfaces that the component imports.
pub(super) fn add_to_linker(
    linker: &mut Linker<State>,
    component: &Component,
    engine: &Engine,
) -> wasmtime::Result<()> {
    for (name, item) in component.component_type().imports(engine) {
        if let (Some(interface), ComponentItem::ComponentInstance(instance)) = (interface(name), &item.ty) {
            add_interface(&mut linker.instance(name)?, interface, instance, engine)?;
        }
    }
    Ok(())
}

fn add_interface(
    linker: &mut LinkerInstance<'_, State>,
    interface: &'static str,
    instance: &ComponentInstance,
    engine: &Engine,
) -> wasmtime::Result<()> {
    for (name, export) in instance.exports(engine) {
        match export.ty {
            ComponentItem::Resource(_) => linker.resource(name, resource(name), |_, _| Ok(()))?,
            ComponentItem::ComponentFunc(_) => add_function(linker, interface, name)?,
            _ => {}
        }
    }
    Ok(())
}

/// The type of a resource: WASI's names are unique across its interfaces.
fn resource(name: &str) -> ResourceType {
    match name {
        "input-stream" => ResourceType::host::<InputStream>(),
        "output-stream" => ResourceType::host::<OutputStream>(),
        "pollable" => ResourceType::host::<Pollable>(),
        "error" => ResourceType::host::<IoError>(),
        // Nobody ever gets one of these.
        other => {
            let number = other.bytes().fold(0u32, |n, b| n.wrapping_mul(31).wrapping_add(u32::from(b)));
            ResourceType::host_dynamic(number)
        }
    }
}

type Context<'a> = StoreContextMut<'a, State>;
type Written = wasmtime::Result<(Result<(), StreamError>,)>;

fn add_function(
    linker: &mut LinkerInstance<'_, State>,
    interface: &'static str,
    name: &str,
) -> wasmtime::Result<()> {
    match (interface, name) {
        ("cli/environment", "get-environment" | "get-arguments")
        | ("filesystem/preopens", "get-directories") => constant(linker, name, Val::List(Vec::new())),
        ("cli/environment", "initial-cwd")
        | ("cli/terminal-stdin", "get-terminal-stdin")
        | ("cli/terminal-stdout", "get-terminal-stdout")
        | ("cli/terminal-stderr", "get-terminal-stderr") => constant(linker, name, Val::Option(None)),
        ("cli/exit", "exit") => linker.func_wrap(name, |_: Context<'_>, (status,): (Result<(), ()>,)| {
            exited::<()>(i32::from(status.is_err()))
        }),
        ("cli/exit", "exit-with-code") => {
            linker.func_wrap(name, |_: Context<'_>, (code,): (u8,)| exited::<()>(i32::from(code)))
        }
        ("cli/stdin", "get-stdin") => linker.func_wrap(name, |mut store: Context<'_>, (): ()| {
            pay(&mut store, 0)?;
            Ok((Resource::<InputStream>::new_own(0),))
        }),
        ("cli/stdout", "get-stdout") => output(linker, name, STDOUT),
        ("cli/stderr", "get-stderr") => output(linker, name, STDERR),
        ("clocks/monotonic-clock", "now") => linker.func_wrap(name, |mut store: Context<'_>, (): ()| {
            pay(&mut store, 0)?;
            Ok((store.data().wasi.time_ns,))
        }),
        ("clocks/monotonic-clock", "resolution") => {
            linker.func_wrap(name, |_: Context<'_>, (): ()| Ok((RESOLUTION_NS,)))
        }
        ("clocks/monotonic-clock", "subscribe-instant" | "subscribe-duration") => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (u64,)| {
                pay(&mut store, 0)?;
                Ok((Resource::<Pollable>::new_own(0),))
            })
        }
        ("clocks/wall-clock", "now") => linker.func_wrap(name, |mut store: Context<'_>, (): ()| {
            pay(&mut store, 0)?;
            Ok((datetime(store.data().wasi.time_ns),))
        }),
        ("clocks/wall-clock", "resolution") => {
            linker.func_wrap(name, |_: Context<'_>, (): ()| Ok((datetime(RESOLUTION_NS),)))
        }
        ("io/poll", _) => poll(linker, name),
        ("io/streams", _) => stream(linker, name),
        ("random/random" | "random/insecure", "get-random-bytes" | "get-insecure-random-bytes") => linker
            .func_wrap(name, |mut store: Context<'_>, (count,): (u64,)| {
                pay(&mut store, count)?;
                let limit = store.data().output_bytes;
                if count > limit {
                    return Err(Error::new(FaultCause::OutputTooLarge { limit }));
                }
                Ok((store.data_mut().wasi.random(count as usize),))
            }),
        ("random/random" | "random/insecure", "get-random-u64" | "get-insecure-random-u64") => linker
            .func_wrap(name, |mut store: Context<'_>, (): ()| {
                pay(&mut store, 8)?;
                Ok((store.data_mut().wasi.rng.next_u64(),))
            }),
        ("random/insecure-seed", "insecure-seed") => {
            linker.func_wrap(name, |mut store: Context<'_>, (): ()| {
                pay(&mut store, 16)?;
                let rng = &mut store.data_mut().wasi.rng;
                Ok(((rng.next_u64(), rng.next_u64()),))
            })
        }
        _ => deny(linker, interface, name),
    }
}

fn poll(linker: &mut LinkerInstance<'_, State>, name: &str) -> wasmtime::Result<()> {
    type Pollables = Vec<Resource<Pollable>>;
    match name {
        "poll" => linker.func_wrap(name, |mut store: Context<'_>, (all,): (Pollables,)| {
            pay(&mut store, all.len() as u64)?;
            Ok(((0..all.len() as u32).collect::<Vec<u32>>(),))
        }),
        "[method]pollable.ready" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (Resource<Pollable>,)| {
                pay(&mut store, 0)?;
                Ok((true,))
            })
        }
        "[method]pollable.block" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (Resource<Pollable>,)| pay(&mut store, 0))
        }
        _ => deny(linker, "io/poll", name),
    }
}

fn stream(linker: &mut LinkerInstance<'_, State>, name: &str) -> wasmtime::Result<()> {
    type In = Resource<InputStream>;
    type Out = Resource<OutputStream>;
    match name {
        "[method]input-stream.read" | "[method]input-stream.blocking-read" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_, _): (In, u64)| {
                pay(&mut store, 0)?;
                Ok((Err::<Vec<u8>, _>(StreamError::Closed),))
            })
        }
        "[method]input-stream.skip" | "[method]input-stream.blocking-skip" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_, _): (In, u64)| {
                pay(&mut store, 0)?;
                Ok((Err::<u64, _>(StreamError::Closed),))
            })
        }
        "[method]input-stream.subscribe" => linker.func_wrap(name, |mut store: Context<'_>, (_,): (In,)| {
            pay(&mut store, 0)?;
            Ok((Resource::<Pollable>::new_own(0),))
        }),
        "[method]output-stream.subscribe" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (Out,)| {
                pay(&mut store, 0)?;
                Ok((Resource::<Pollable>::new_own(0),))
            })
        }
        "[method]output-stream.check-write" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (Out,)| {
                pay(&mut store, 0)?;
                Ok((Ok::<u64, StreamError>(CHUNK_BYTES),))
            })
        }
        "[method]output-stream.write" | "[method]output-stream.blocking-write-and-flush" => {
            linker.func_wrap(name, |mut store: Context<'_>, (out, bytes): (Out, Vec<u8>)| -> Written {
                pay(&mut store, bytes.len() as u64)?;
                store.data_mut().write(out.rep(), &bytes);
                Ok((Ok(()),))
            })
        }
        "[method]output-stream.flush" | "[method]output-stream.blocking-flush" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_,): (Out,)| -> Written {
                pay(&mut store, 0)?;
                Ok((Ok(()),))
            })
        }
        "[method]output-stream.write-zeroes" | "[method]output-stream.blocking-write-zeroes-and-flush" => {
            linker.func_wrap(name, |mut store: Context<'_>, (_, count): (Out, u64)| -> Written {
                // Zeros are nothing to be read in a log.
                pay(&mut store, count)?;
                Ok((Ok(()),))
            })
        }
        _ => deny(linker, "io/streams", name),
    }
}

fn output(linker: &mut LinkerInstance<'_, State>, name: &str, stream: u32) -> wasmtime::Result<()> {
    linker.func_wrap(name, move |mut store: Context<'_>, (): ()| {
        pay(&mut store, 0)?;
        Ok((Resource::<OutputStream>::new_own(stream),))
    })
}

fn constant(linker: &mut LinkerInstance<'_, State>, name: &str, value: Val) -> wasmtime::Result<()> {
    linker.func_new(name, move |mut store, _, _, results| {
        pay(&mut store, 0)?;
        results[0] = value.clone();
        Ok(())
    })
}

/// A function that planners don't get: its result is that access is denied, or, where it can't say so, its caller's
/// task ends.
fn deny(linker: &mut LinkerInstance<'_, State>, interface: &'static str, name: &str) -> wasmtime::Result<()> {
    let function = format!("wasi:{interface} {name}");
    linker.func_new(name, move |mut store, ty: ComponentFunc, _, results| {
        pay(&mut store, 0)?;
        let mut types = ty.results();
        let denied = match (types.next(), types.next()) {
            (Some(Type::Result(result)), None) => result.err().and_then(access_denied),
            _ => None,
        };
        let Some(denied) = denied else {
            return Err(Error::new(FaultCause::ImportDenied { import: function.clone() }));
        };
        results[0] = Val::Result(Err(Some(Box::new(denied))));
        Ok(())
    })
}

/// The case of an error code that says so.
fn access_denied(ty: Type) -> Option<Val> {
    let Type::Enum(codes) = ty else { return None };
    codes
        .names()
        .find(|name| matches!(*name, "access-denied" | "access"))
        .map(|name| Val::Enum(name.to_owned()))
}

fn exited<T>(code: i32) -> wasmtime::Result<T> {
    Err(Error::new(FaultCause::Crashed { how: ProcessEnd::Exit(code) }))
}

/// Simulated time as if the simulation had begun in 1970.
fn datetime(ns: u64) -> Datetime {
    Datetime { seconds: ns / 1_000_000_000, nanoseconds: (ns % 1_000_000_000) as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_interfaces_of_wasi_0_2_that_are_here_are_known() {
        assert_eq!(interface("wasi:random/random@0.2.0"), Some("random/random"));
        assert_eq!(interface("wasi:cli/environment@0.2.12"), Some("cli/environment"));
        for unknown in
            ["wasi:http/types@0.2.0", "wasi:random/random@0.3.0", "wasi:random/random", "random/random@0.2.0"]
        {
            assert_eq!(interface(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn resources_of_different_names_are_different() {
        let names = [
            "error",
            "pollable",
            "input-stream",
            "output-stream",
            "descriptor",
            "directory-entry-stream",
            "network",
            "tcp-socket",
            "udp-socket",
            "incoming-datagram-stream",
            "outgoing-datagram-stream",
            "resolve-address-stream",
            "terminal-input",
            "terminal-output",
        ];
        for (i, a) in names.iter().enumerate() {
            for b in &names[..i] {
                assert!(resource(a) != resource(b), "{a} {b}");
            }
        }
    }
}
