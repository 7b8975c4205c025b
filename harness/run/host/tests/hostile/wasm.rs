//! WASM planners that do harm in what they compute, take, say and give back.

use vb_host::FaultCode::{self, *};

use crate::Ends::{self, *};
use crate::common::{METADATA, core_module, planner_wat};
use crate::{Case, Source, case};

pub const OK: &str = "(call $ok_planner)";
pub const GO: &str = "(call $ok_command (f64.const 0.25) (f64.const 0.5) (f64.const 0))";

/// A function that is exported under a name of the canonical ABI.
const POST_STEP: &str = r#"(export "cabi_post_vertibench:planner/guest@1.0.0#[method]planner.step")"#;

/// A planner that fails with these bodies of its functions.
fn bodies(
    name: &'static str,
    init: &str,
    step: &str,
    ends: Ends,
    code: FaultCode,
    says: &'static str,
) -> Case {
    case(name, Source::File(core_module(&planner_wat(init, step), METADATA)), ends, code, says)
}

fn init(name: &'static str, body: &str, code: FaultCode, says: &'static str) -> Case {
    bodies(name, body, GO, Init, code, says)
}

fn step(name: &'static str, body: &str, code: FaultCode, says: &'static str) -> Case {
    bodies(name, OK, body, Step, code, says)
}

/// A planner in whose text one thing is another, and with more functions.
fn changed(
    name: &'static str,
    (from, to): (&str, &str),
    (ends, code, says): (Ends, FaultCode, &'static str),
) -> Case {
    let text = planner_wat(OK, GO);
    assert!(text.contains(from), "{name}");
    case(name, Source::File(core_module(&text.replacen(from, to, 1), METADATA)), ends, code, says)
}

/// The planner with one item more.
fn with(name: &'static str, item: &str, end: (Ends, FaultCode, &'static str)) -> Case {
    changed(name, ("(func $spin", &format!("{item} (func $spin")), end)
}

/// A planner whose step puts this into the byte of the command's gear.
fn gear(name: &'static str, value: u8, says: &'static str) -> Case {
    let step = format!("(drop {GO}) (i32.store8 (i32.const 2080) (i32.const {value})) (i32.const 2048)");
    let module = core_module(&planner_wat(OK, &step), METADATA);
    case(name, Source::File(module), Step, InvalidOutput, says)
}

/// The result of a step that is an error whose text has this address and length.
fn error(address: u32, bytes: u32) -> String {
    format!(
        "(i32.store (i32.const 2048) (i32.const 1)) (i32.store (i32.const 2056) (i32.const {address}))
         (i32.store (i32.const 2060) (i32.const {bytes})) (i32.const 2048)"
    )
}

/// A command with one series, of a name and values with these addresses and lengths.
fn series(name: [u32; 2], values: [u32; 2]) -> String {
    let words = name.into_iter().chain(values).enumerate();
    let stores: String = words
        .map(|(i, word)| format!("(i32.store (i32.const {}) (i32.const {word})) ", 3000 + 4 * i))
        .collect();
    format!(
        "(drop {GO}) {stores} (i32.store (i32.const 2084) (i32.const 3000))
         (i32.store (i32.const 2088) (i32.const 1)) (i32.const 2048)"
    )
}

fn command(steering: &str, throttle: &str, brake: &str) -> String {
    format!("(call $ok_command (f64.const {steering}) (f64.const {throttle}) (f64.const {brake}))")
}

pub fn table() -> Vec<Case> {
    [without_end(), too_much(), traps(), lies()].concat()
}

fn without_end() -> Vec<Case> {
    let init_fuel = "exceeded its limit of 3000000 units of fuel";
    let step_fuel = "exceeded its limit of 1000000 units of fuel";
    vec![
        init("an endless loop in init", "(call $spin) unreachable", OutOfFuel, init_fuel),
        step("an endless loop in a step", "(call $spin) unreachable", OutOfFuel, step_fuel),
        // Metadata are data: the first that runs is the start function.
        with("an endless loop at start-up", "(start $spin)", (Init, OutOfFuel, init_fuel)),
        changed(
            "an endless loop where the host asks for memory",
            ("(local $p i32)", "(local $p i32) (call $spin)"),
            (Init, OutOfFuel, init_fuel),
        ),
        with(
            "an endless loop when the host has taken the result",
            &format!("(func {POST_STEP} (param i32) (call $spin))"),
            (Step, OutOfFuel, step_fuel),
        ),
        step(
            "endless lines of log",
            "(loop $l (call $log (i32.const 2) (i32.const 16) (i32.const 9)) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "endless long lines of log",
            "(loop $l (call $log (i32.const 2) (i32.const 131072) (i32.const 60000)) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "endless filling of memory",
            "(loop $l (memory.fill (i32.const 8192) (i32.const 0) (i32.const 65536)) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "endless growing by nothing",
            "(loop $l (drop (memory.grow (i32.const 0))) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        bodies_with(
            "endless references to a function",
            "(elem declare func $spin)",
            "(loop $l (drop (ref.func $spin)) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "endless filling of a table by nothing",
            "(loop $l (table.fill $table (i32.const 0) (ref.null func) (i32.const 0)) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "endless dependent loads",
            "(loop $l (global.set $calls (i32.load (global.get $calls))) (br $l)) unreachable",
            OutOfFuel,
            step_fuel,
        ),
        step(
            "a recursion",
            "(call $recurse) unreachable",
            StackOverflow,
            "stack of 1048576 bytes in recurse",
        ),
        init("a recursion in init", "(call $recurse) unreachable", StackOverflow, "overflowed its stack"),
        bodies_with(
            "a recursion of two functions",
            "(func $ping (call $pong) (call $fail)) (func $pong (call $ping) (call $fail))",
            "(call $ping) unreachable",
            StackOverflow,
            "overflowed its stack",
        ),
        // As compilers do: what has an address lies on a stack at the bottom of memory.
        bodies_with(
            "a recursion with large variables",
            "(global $sp (mut i32) (i32.const 262144))
             (func $deep
               (global.set $sp (i32.sub (global.get $sp) (i32.const 4096)))
               (i32.store (global.get $sp) (i32.const 1)) (call $deep) (call $fail))",
            "(call $deep) unreachable",
            StackOverflow,
            "overflowed its stack",
        ),
    ]
}

/// A step with this body, and one item more.
fn bodies_with(name: &'static str, item: &str, body: &str, code: FaultCode, says: &'static str) -> Case {
    let text = planner_wat(OK, body).replacen("(func $spin", &format!("{item} (func $spin"), 1);
    case(name, Source::File(core_module(&text, METADATA)), Step, code, says)
}

/// A planner that imports something, with this body of a step.
pub fn importing(name: &'static str, import: &str, body: &str, end: (Ends, FaultCode, &'static str)) -> Case {
    let text = planner_wat(OK, body).replacen("(module", &format!("(module {import}"), 1);
    case(name, Source::File(core_module(&text, METADATA)), end.0, end.1, end.2)
}

fn too_much() -> Vec<Case> {
    let memory = "the limit is 67108864";
    vec![
        init("a memory bomb in init", "(call $hog) unreachable", OutOfMemory, memory),
        step("a memory bomb", "(call $hog) unreachable", OutOfMemory, memory),
        step(
            "all of memory at once",
            "(drop (memory.grow (i32.const 65532))) unreachable",
            OutOfMemory,
            "requested 4294967296 bytes",
        ),
        changed(
            "more memory at the start than it may have",
            ("(export \"memory\") 4)", "(export \"memory\") 2000)"),
            (Init, OutOfMemory, memory),
        ),
        step("a table bomb", "(call $tables) unreachable", OutOfMemory, "the limit is 5000"),
        changed(
            "more table at the start than it may have",
            ("$table 1 funcref", "$table 100000 funcref"),
            (Init, OutOfMemory, "the limit is 5000"),
        ),
        step(
            "a flood of debug data",
            &format!(
                "(drop {GO}) (i32.store (i32.const 2084) (i32.const 4096))
                 (i32.store (i32.const 2088) (i32.const 100000)) (drop (memory.grow (i32.const 40))) (i32.const 2048)"
            ),
            InvalidOutput,
            "1048576",
        ),
        step(
            "a flood of text in an error",
            &format!("(drop (memory.grow (i32.const 40))) {}", error(4096, 2_000_000)),
            InvalidOutput,
            "1048576",
        ),
        step(
            "handles without end",
            "(loop $l (drop (call $new (i32.const 7))) (br $l)) unreachable",
            Trap,
            "",
        ),
    ]
}

fn traps() -> Vec<Case> {
    vec![
        step("an abort", "(call $fail) unreachable", Trap, "in fail"),
        init("an abort in init", "unreachable", Trap, "unreachable"),
        with("an abort at start-up", "(start $fail)", (Init, Trap, "unreachable")),
        step(
            "a division by zero",
            "(drop (i32.div_u (i32.const 1) (i32.const 0))) unreachable",
            Trap,
            "divide by zero",
        ),
        step(
            "a division that overflows",
            "(drop (i32.div_s (i32.const 0x80000000) (i32.const -1))) unreachable",
            Trap,
            "integer overflow",
        ),
        step(
            "no number made an integer",
            "(drop (i32.trunc_f64_s (f64.const nan))) unreachable",
            Trap,
            "conversion to integer",
        ),
        step(
            "a read beyond its memory",
            "(drop (i32.load (i32.const 0x7fffffff))) unreachable",
            Trap,
            "out of bounds memory access",
        ),
        step(
            "a call of an empty element",
            "(call_indirect (i32.const 0)) unreachable",
            Trap,
            "uninitialized element",
        ),
        step("a call beyond its table", "(call_indirect (i32.const 99)) unreachable", Trap, "table access"),
        bodies_with(
            "a call of another type",
            "(elem (table $table) (i32.const 0) func $ok_planner)",
            "(call_indirect (i32.const 0)) unreachable",
            Trap,
            "indirect call type mismatch",
        ),
        step(
            "a panic",
            "(call $log (i32.const 0) (i32.const 32) (i32.const 47)) unreachable",
            Panic,
            "panicked at src/lib.rs:3:5: index out of bounds",
        ),
        init(
            "an error in init",
            "(i32.store (i32.const 1024) (i32.const 1)) (i32.store (i32.const 1028) (i32.const 96))
             (i32.store (i32.const 1032) (i32.const 10)) (i32.const 1024)",
            InitFailed,
            "no way out",
        ),
        step("an error", &error(96, 10), Error, "no way out"),
        // Escape, bell, and the sign that turns the order of letters round.
        bodies_with(
            "an error that writes on the terminal",
            r#"(data (i32.const 3000) "\1b[2J\07no \e2\80\aeway")"#,
            &error(3000, 14),
            Error,
            "\u{fffd}[2J\u{fffd}no \u{fffd}way",
        ),
    ]
}

/// Results and arguments that are not what the interface says.
fn lies() -> Vec<Case> {
    vec![
        step("a steering that is no number", &command("nan", "0", "0"), InvalidOutput, "steering is NaN"),
        step(
            "a steering that is no number, with a payload",
            &command("-nan:0x4000000000001", "0", "0"),
            InvalidOutput,
            "steering is NaN",
        ),
        gear("a gear that there isn't", 3, "gear is 3; want forward (0), neutral (1) or reverse (2)"),
        gear("a gear of all bits", 255, "gear is 255; want forward (0)"),
        step("an infinite throttle", &command("0", "inf", "0"), InvalidOutput, "throttle is inf"),
        step("an infinite brake", &command("0", "0", "-inf"), InvalidOutput, "brake is -inf"),
        step("a result beyond its memory", "(i32.const 0x7ffffff8)", Trap, ""),
        step("a result that is not aligned", "(i32.const 2049)", Trap, ""),
        step(
            "a result that is neither good nor bad",
            &format!("(drop {GO}) (i32.store (i32.const 2048) (i32.const 9)) (i32.const 2048)"),
            Trap,
            "",
        ),
        step("an error's text beyond its memory", &error(0x7fff_0000, 100), Trap, ""),
        step("an error that is no text", &error(2048, 1), Error, ""),
        step("a series beyond its memory", &series([16, 9], [0x7fff_0000, 16]), Trap, ""),
        bodies_with(
            "a series whose name is no text",
            r#"(data (i32.const 2900) "\ff\fe")"#,
            &series([2900, 2], [16, 1]),
            Trap,
            "",
        ),
        step(
            "a line of log beyond its memory",
            "(call $log (i32.const 2) (i32.const 0x7fffffff) (i32.const 9)) unreachable",
            Trap,
            "",
        ),
        bodies_with(
            "a line of log that is no text",
            r#"(data (i32.const 2900) "\ff\fe")"#,
            "(call $log (i32.const 2) (i32.const 2900) (i32.const 2)) unreachable",
            Trap,
            "",
        ),
        step(
            "a line of log of no level",
            "(call $log (i32.const 77) (i32.const 16) (i32.const 9)) unreachable",
            Trap,
            "",
        ),
        init(
            "a planner that doesn't exist",
            "(i32.store (i32.const 1024) (i32.const 0)) (i32.store (i32.const 1028) (i32.const 999)) (i32.const 1024)",
            Trap,
            "",
        ),
        changed(
            "memory for the host beyond its own",
            ("(local.get $p))\n  (func $ok_planner", "(i32.const 0x7ffffff0))\n  (func $ok_planner"),
            (Init, Trap, ""),
        ),
        changed(
            "memory for the host that is not aligned",
            ("(local.get $p))\n  (func $ok_planner", "(i32.const 4097))\n  (func $ok_planner"),
            (Init, Trap, ""),
        ),
        importing(
            "an exit",
            r#"(import "wasi_snapshot_preview1" "proc_exit" (func $exit (param i32)))"#,
            "(call $exit (i32.const 1)) unreachable",
            (Step, Crashed, "exited with code 1"),
        ),
        importing(
            "waiting without end",
            r#"(import "wasi_snapshot_preview1" "sched_yield" (func $yield (result i32)))"#,
            "(loop $l (drop (call $yield)) (br $l)) unreachable",
            (Step, OutOfFuel, "exceeded its limit of 1000000 units of fuel"),
        ),
    ]
}
