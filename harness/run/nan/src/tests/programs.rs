//! Random programs as WebAssembly text, most of whose numbers become NaNs sooner or later.

use std::fmt::Write as _;

use vb_sdk::rng::Rng;

/// Bytes at the begin of the memory that programs read and write.
pub(super) const BYTES: u64 = 256;

#[derive(Clone, Copy, PartialEq)]
enum Type {
    I32,
    F32,
    F64,
    V128,
}
use Type::{F32, F64, I32, V128};

const TYPES: [Type; 4] = [I32, F32, F64, V128];
/// Locals of each type.
const LOCALS: u64 = 3;
/// Loops in each other, each with a counter of its own.
const LOOPS: usize = 3;

impl Type {
    fn name(self) -> &'static str {
        match self {
            I32 => "i32",
            F32 => "f32",
            F64 => "f64",
            V128 => "v128",
        }
    }
}

/// A module that exports its memory, three globals, and the function `run`.
pub(super) fn program(seed: u64) -> String {
    let mut writer = Writer { rng: Rng::new(seed), labels: Vec::new(), count: 0, loops: 0, in_mix: false };
    let data: String =
        (0..BYTES / 4).flat_map(|_| writer.word().to_le_bytes()).fold(String::new(), |mut text, byte| {
            let _ = write!(text, "\\{byte:02x}");
            text
        });
    let mut locals = String::new();
    for (name, count) in TYPES.map(|ty| (ty.name(), LOCALS)) {
        for i in 0..count {
            let _ = write!(locals, " (local ${name}{i} {name})");
        }
    }
    for i in 0..LOOPS {
        let _ = write!(locals, " (local $turns{i} i32)");
    }
    let statements = writer.statements(14, 3);
    writer.in_mix = true;
    let mixed = writer.expression(F64, 3);
    format!(
        r#"(module
  (memory (export "memory") 1)
  (data (i32.const 0) "{data}")
  (global $f32 (export "f32") (mut f32) (f32.const 0))
  (global $f64 (export "f64") (mut f64) (f64.const 0))
  (global $v128 (export "v128") (mut v128) (v128.const i64x2 0 0))
  (func $mix (param $f320 f32) (param $f640 f64) (param $v1280 v128) (result f64)
    (local $i320 i32) (local $i321 i32) (local $i322 i32) (local $f321 f32) (local $f322 f32) (local $f641 f64)
    (local $f642 f64) (local $v1281 v128) (local $v1282 v128)
    {mixed})
  (func (export "run") {locals}
    {statements}))"#
    )
}

struct Writer {
    rng: Rng,
    /// Blocks without results around the current place.
    labels: Vec<String>,
    count: usize,
    loops: usize,
    /// Whether it writes the function that others call.
    in_mix: bool,
}

impl Writer {
    fn below(&mut self, n: u64) -> u64 {
        self.rng.below(n)
    }

    fn pick<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len() as u64) as usize]
    }

    /// The bits of a number: NaNs of all kinds, infinities, zeros, ordinary ones.
    fn word(&mut self) -> u32 {
        let payload = self.rng.next_u64() as u32;
        match self.below(8) {
            0 => 0x7f80_0001 | payload & 0x803f_ffff,
            1 => 0x7fc0_0000 | payload & 0x803f_ffff,
            2 => 0x7ff8_0000 | payload & 0x8007_ffff,
            3 => 0x7f80_0000 | payload & 0x8000_0000,
            4 => payload & 0x8000_0000,
            5 => 0x7ff0_0000 | payload & 0x8000_0001,
            6 => (payload as f32 / 1e9).to_bits(),
            _ => payload,
        }
    }

    fn address(&mut self) -> u64 {
        // Mostly in step with lanes, so that what is stored is read again as what it was.
        let address = 4 * self.below((BYTES - 16) / 4);
        if self.below(4) == 0 { address } else { address & !15 }
    }

    fn constant(&mut self, ty: Type) -> String {
        match ty {
            I32 => format!("(i32.const {})", self.below(5)),
            // A constant of floats may be any NaN, too.
            F32 => format!("(f32.reinterpret_i32 (i32.const {}))", self.word()),
            F64 if self.below(2) == 0 => {
                self.pick(&["(f64.const nan:0x4000000000123)", "(f64.const -inf)", "(f64.const 0)"]).into()
            }
            F64 => format!("(f64.const {})", self.below(9)),
            V128 if self.below(3) == 0 => self
                .pick(&[
                    "(v128.const i32x4 -1 0 -1 0)",
                    "(v128.const i64x2 0 -1)",
                    "(v128.const i32x4 0 0 -1 -1)",
                ])
                .into(),
            V128 => {
                format!("(v128.const i32x4 {} {} {} {})", self.word(), self.word(), self.word(), self.word())
            }
        }
    }

    fn expression(&mut self, ty: Type, depth: u32) -> String {
        let name = ty.name();
        if depth == 0 || self.below(8) == 0 {
            return match self.below(4) {
                0 => self.constant(ty),
                1 => format!("({name}.load (i32.const {}))", self.address()),
                _ => format!("(local.get ${name}{})", self.below(LOCALS)),
            };
        }
        let depth = depth - 1;
        match self.below(12) {
            0 => {
                let (a, b, by) =
                    (self.expression(ty, depth), self.expression(ty, depth), self.expression(I32, depth));
                return if self.below(2) == 0 {
                    format!("(select {a} {b} {by})")
                } else {
                    format!("(select (result {name}) {a} {b} {by})")
                };
            }
            1 => {
                let (by, a, b) =
                    (self.expression(I32, depth), self.expression(ty, depth), self.expression(ty, depth));
                return format!("(if (result {name}) {by} (then {a}) (else {b}))");
            }
            2 => {
                let value = self.expression(ty, depth);
                return format!("(local.tee ${name}{} {value})", self.below(LOCALS));
            }
            3 => {
                // Two results, of which the upper one goes.
                let (value, more) = (self.expression(ty, depth), self.expression(F32, depth));
                return format!("(block (result {name}) (block (result {name} f32) {value} {more}) (drop))");
            }
            _ => {}
        }
        match ty {
            I32 => self.integer(depth),
            F32 => self.scalar(F32, depth),
            F64 => self.scalar(F64, depth),
            V128 => self.vector(depth),
        }
    }

    fn of(&mut self, operator: &str, operands: &[Type], depth: u32) -> String {
        let operands: Vec<String> = operands.iter().map(|ty| self.expression(*ty, depth)).collect();
        format!("({operator} {})", operands.join(" "))
    }

    fn integer(&mut self, depth: u32) -> String {
        match self.below(9) {
            0 => self.of("i32.reinterpret_f32", &[F32], depth),
            1 => {
                let operator = self.pick(&["f32.lt", "f32.eq", "f32.ge", "f32.ne"]);
                self.of(operator, &[F32, F32], depth)
            }
            2 => {
                let operator = self.pick(&["f64.lt", "f64.eq", "f64.ge", "f64.ne"]);
                self.of(operator, &[F64, F64], depth)
            }
            3 => self.of("i32.trunc_sat_f32_s", &[F32], depth),
            4 => self.of("i32.trunc_sat_f64_u", &[F64], depth),
            5 => {
                let operator = self.pick(&[
                    "i32x4.extract_lane 1",
                    "i16x8.extract_lane_u 3",
                    "v128.any_true",
                    "i32x4.bitmask",
                    "i64x2.bitmask",
                    "i8x16.all_true",
                ]);
                self.of(operator, &[V128], depth)
            }
            6 => {
                let long = self.of("i64.reinterpret_f64", &[F64], depth);
                format!("(i32.wrap_i64 (i64.shr_u {long} (i64.const 40)))")
            }
            _ => {
                let operator = self.pick(&["i32.add", "i32.xor", "i32.shr_u", "i32.gt_u"]);
                self.of(operator, &[I32, I32], depth)
            }
        }
    }

    fn scalar(&mut self, ty: Type, depth: u32) -> String {
        let name = ty.name();
        let (other, lanes) = if ty == F32 { (F64, "f32x4") } else { (F32, "f64x2") };
        match self.below(16) {
            0..7 => {
                let operator = self.pick(&["add", "sub", "mul", "div", "min", "max"]);
                self.of(&format!("{name}.{operator}"), &[ty, ty], depth)
            }
            7..10 => {
                let operator = self.pick(&["sqrt", "ceil", "floor", "trunc", "nearest"]);
                self.of(&format!("{name}.{operator}"), &[ty], depth)
            }
            10 => {
                let operator = self.pick(&["neg", "abs"]);
                self.of(&format!("{name}.{operator}"), &[ty], depth)
            }
            11 => self.of(&format!("{name}.copysign"), &[ty, ty], depth),
            12 => self.of(if ty == F32 { "f32.demote_f64" } else { "f64.promote_f32" }, &[other], depth),
            13 if ty == F64 && !self.in_mix => self.of("call $mix", &[F32, F64, V128], depth),
            13 => self.of(&format!("{name}.convert_i32_s"), &[I32], depth),
            _ => {
                let lane = self.below(2);
                self.of(&format!("{lanes}.extract_lane {lane}"), &[V128], depth)
            }
        }
    }

    fn vector(&mut self, depth: u32) -> String {
        let lanes = self.pick(&["f32x4", "f64x2"]);
        let scalar = if lanes == "f32x4" { F32 } else { F64 };
        match self.below(24) {
            0..7 => {
                let operator = self.pick(&["add", "sub", "mul", "div", "min", "max"]);
                self.of(&format!("{lanes}.{operator}"), &[V128, V128], depth)
            }
            7..9 => {
                let operator = self.pick(&["sqrt", "ceil", "floor", "trunc", "nearest"]);
                self.of(&format!("{lanes}.{operator}"), &[V128], depth)
            }
            9 => {
                let operator = self.pick(&["pmin", "pmax"]);
                self.of(&format!("{lanes}.{operator}"), &[V128, V128], depth)
            }
            10 => {
                let operator = self.pick(&["neg", "abs"]);
                self.of(&format!("{lanes}.{operator}"), &[V128], depth)
            }
            11 => self.of(&format!("{lanes}.splat"), &[scalar], depth),
            12 => self.of(&format!("{lanes}.replace_lane 1"), &[V128, scalar], depth),
            13 => {
                let operator = self.pick(&["f32x4.demote_f64x2_zero", "f64x2.promote_low_f32x4"]);
                self.of(operator, &[V128], depth)
            }
            14 => {
                let operator = self.pick(&[
                    "i32x4.trunc_sat_f32x4_s",
                    "i32x4.trunc_sat_f64x2_u_zero",
                    "f32x4.convert_i32x4_u",
                ]);
                self.of(operator, &[V128], depth)
            }
            15..17 => self.shuffle(depth),
            17..20 => {
                let (a, b) = (self.expression(V128, depth), self.expression(V128, depth));
                let mask = if self.below(4) == 0 { self.expression(V128, depth) } else { self.mask(depth) };
                format!("(v128.bitselect {a} {b} {mask})")
            }
            20..22 => {
                let operator = self.pick(&["v128.and", "v128.andnot", "v128.or", "v128.xor"]);
                let (value, mask) = (self.expression(V128, depth), self.mask(depth));
                if self.below(3) == 0 {
                    format!("({operator} {mask} {value})")
                } else {
                    format!("({operator} {value} {mask})")
                }
            }
            22 => self.mask(depth),
            _ => {
                let operator = self.pick(&["i32x4.add", "i64x2.sub", "i8x16.max_u", "i16x8.mul"]);
                self.of(operator, &[V128, V128], depth)
            }
        }
    }

    fn mask(&mut self, depth: u32) -> String {
        let depth = depth.saturating_sub(1);
        match self.below(6) {
            0 if depth > 0 => {
                let operator = self.pick(&["v128.and", "v128.or", "v128.xor", "v128.andnot"]);
                let (a, b) = (self.mask(depth), self.mask(depth));
                format!("({operator} {a} {b})")
            }
            1 if depth > 0 => format!("(v128.not {})", self.mask(depth)),
            2 => self.pick(&["(v128.const i32x4 -1 0 -1 0)", "(v128.const i64x2 0 -1)"]).into(),
            _ => {
                let operator = self.pick(&[
                    "f32x4.lt",
                    "f32x4.ne",
                    "f64x2.ge",
                    "f64x2.eq",
                    "i32x4.gt_s",
                    "i64x2.ne",
                    "i16x8.eq",
                ]);
                self.of(operator, &[V128, V128], depth)
            }
        }
    }

    fn shuffle(&mut self, depth: u32) -> String {
        let width = [1, 4, 8, 8, 4][self.below(5) as usize];
        let mut lanes = String::new();
        for _ in 0..16 / width {
            let first = width * self.below(32 / width);
            lanes.extend((first..first + width).map(|lane| format!(" {lane}")));
        }
        self.of(&format!("i8x16.shuffle{lanes}"), &[V128, V128], depth)
    }

    fn statements(&mut self, count: u64, depth: u32) -> String {
        (0..=self.below(count)).map(|_| self.statement(depth)).collect::<Vec<_>>().join("\n    ")
    }

    fn statement(&mut self, depth: u32) -> String {
        let ty = TYPES[self.below(4) as usize];
        let name = ty.name();
        match self.below(if depth == 0 { 8 } else { 14 }) {
            0..4 => {
                let value = self.expression(ty, 3);
                format!("(local.set ${name}{} {value})", self.below(LOCALS))
            }
            4..6 => {
                let value = self.expression(ty, 2);
                format!("({name}.store (i32.const {}) {value})", self.address())
            }
            6 if ty != I32 => format!("(global.set ${name} {})", self.expression(ty, 2)),
            6 => format!("(drop {})", self.expression(V128, 2)),
            7 => self.jump(),
            8 | 9 => {
                let by = self.expression(I32, 2);
                let (then, otherwise) = (self.statements(3, depth - 1), self.statements(3, depth - 1));
                if self.below(2) == 0 {
                    format!("(if {by} (then {then}))")
                } else {
                    format!("(if {by} (then {then}) (else {otherwise}))")
                }
            }
            10 | 11 => {
                let label = self.label();
                let inside = self.statements(4, depth - 1);
                self.labels.pop();
                format!("(block {label} {inside})")
            }
            _ if self.loops < LOOPS => self.turns(depth - 1),
            _ => {
                let value = self.expression(ty, 2);
                format!("{value} (block (param {name}) (result {name}) (nop)) (drop)")
            }
        }
    }

    fn label(&mut self) -> String {
        let label = format!("$l{}", self.count);
        self.count += 1;
        self.labels.push(label.clone());
        label
    }

    /// Leaves blocks, or begins loops anew.
    fn jump(&mut self) -> String {
        let by = self.expression(I32, 2);
        let Some(last) = self.labels.len().checked_sub(1) else { return format!("(drop {by})") };
        let [a, b] = [0; 2].map(|_| self.below(last as u64 + 1) as usize).map(|i| self.labels[i].clone());
        match self.below(5) {
            // What follows in the block is never reached.
            0 => format!("(br {a})"),
            1 => format!("(br_table {a} {b} {a} {by})"),
            _ => format!("(br_if {a} {by})"),
        }
    }

    /// A loop of some turns. Its condition is in front of its body or behind it; in the latter case nothing may begin the
    /// next turn but the condition.
    fn turns(&mut self, depth: u32) -> String {
        let counter = format!("$turns{}", self.loops);
        let turns = 1 + self.below(4);
        self.loops += 1;
        let in_front = self.below(2) == 0;
        let out = self.label();
        let again = self.label();
        if !in_front {
            self.labels.pop();
        }
        let inside = self.statements(6, depth);
        self.labels.truncate(self.labels.len() - if in_front { 2 } else { 1 });
        self.loops -= 1;
        let count = format!("(local.set {counter} (i32.sub (local.get {counter}) (i32.const 1)))");
        let body = if in_front {
            format!("(br_if {out} (i32.eqz (local.get {counter}))) {count} {inside} (br {again})")
        } else {
            format!("{count} {inside} (br_if {again} (local.get {counter}))")
        };
        format!("(local.set {counter} (i32.const {turns})) (block {out} (loop {again} {body}))")
    }
}
