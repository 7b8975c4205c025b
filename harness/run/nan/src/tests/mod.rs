//! What is made canonical in functions that are small enough to tell, and that random programs can't tell this pass from
//! the engine's own.

mod files;
mod programs;
mod random;

use wasmparser::{FunctionBody, Operator, Parser, Payload};

use super::*;

fn bodies(module: &[u8]) -> Vec<FunctionBody<'_>> {
    let body = |payload| match payload {
        Payload::CodeSectionEntry(body) => Some(body),
        _ => None,
    };
    Parser::new(0).parse_all(module).filter_map(|payload| body(payload.unwrap())).collect()
}

/// The operators of a module whose results are made canonical, with the locals that are behind loops.
fn canonical_in(module: &[u8]) -> Vec<String> {
    let mut found = Vec::new();
    for body in bodies(module) {
        let operators: Vec<_> =
            body.get_operators_reader().unwrap().into_iter().map(|operator| operator.unwrap()).collect();
        for window in operators.windows(8) {
            use Operator as O;
            let (before, first, a, after) = match window {
                [
                    before,
                    first,
                    O::F32Const { .. } | O::F64Const { .. } | O::V128Const { .. },
                    O::LocalGet { local_index: a },
                    O::LocalGet { local_index: b },
                    O::F32Eq | O::F64Eq | O::F32x4Eq | O::F64x2Eq,
                    O::Select | O::V128Bitselect,
                    after,
                ] if a == b => (before, first, a, after),
                _ => continue,
            };
            match (first, after) {
                (O::LocalTee { local_index }, _) if local_index == a => found.push(format!("{before:?}")),
                (O::LocalGet { local_index }, O::LocalSet { .. }) if local_index == a => {
                    found.push(format!("local {local_index}"));
                }
                _ => {}
            }
        }
    }
    found
}

/// A module with one function: its parameters, results and locals, and its body.
fn module(signature: &str, body: &str) -> Vec<u8> {
    let text = format!(
        "(module (memory 1) (global $g (mut f32) (f32.const 0))
          (func $takes (param f32)) (func $gives (result f32) (f32.const 1))
          (func {signature} {body}))"
    );
    wat::parse_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// What is made canonical in the one function.
#[track_caller]
fn check(signature: &str, body: &str, expected: &[&str]) {
    let rewritten = rewrite(&module(signature, body)).unwrap();
    Validator::new_with_features(FEATURES).validate_all(&rewritten).unwrap();
    assert_eq!(canonical_in(&rewritten), expected, "{body}");
}

const FLOATS: &str =
    "(param $a f32) (param $b f32) (param $d f64) (param $v v128) (param $w v128) (param $i i32)
    (local $x f32) (local $z f32)";

/// What is made canonical in a function with parameters and locals of all kinds.
#[track_caller]
fn sees(body: &str, expected: &[&str]) {
    check(FLOATS, body, expected);
}

#[test]
fn only_the_last_result_of_a_chain_is_seen() {
    let sum = "(f32.add (local.get $a) (local.get $b))";
    sees(&format!("(f32.store (i32.const 0) {sum})"), &["F32Add"]);
    sees(&format!("(f32.store (i32.const 0) (f32.mul {sum} (local.get $a)))"), &["F32Mul"]);
    sees(&format!("(drop {sum})"), &[]);
    sees(&format!("(drop (f32.lt {sum} (local.get $a)))"), &[]);
    sees(&format!("(i32.store (i32.const 0) (i32.trunc_sat_f32_s {sum}))"), &[]);
    sees(&format!("(i32.store (i32.const 0) (i32.reinterpret_f32 {sum}))"), &["F32Add"]);
    sees(&format!("(global.set $g {sum})"), &["F32Add"]);
    sees(&format!("(call $takes {sum})"), &["F32Add"]);
    sees(&format!("(f64.store (i32.const 0) (f64.promote_f32 {sum}))"), &["F64PromoteF32"]);
    // What no arithmetic has made is passed on with all its bits.
    sees("(f32.store (i32.const 0) (call $gives)) (f32.store (i32.const 0) (local.get $a))", &[]);
}

#[test]
fn a_result_of_a_function_is_seen() {
    check("(param f32) (result f32)", "(f32.sqrt (local.get 0))", &["F32Sqrt"]);
    check("(param f32) (result f32)", "(return (f32.sqrt (local.get 0)))", &["F32Sqrt"]);
    check("(param f32) (result f32)", "(br 0 (f32.sqrt (local.get 0)))", &["F32Sqrt"]);
    check(
        "(param i32 f32) (result f32)",
        "(br_table 0 0 (f32.sqrt (local.get 1)) (local.get 0))",
        &["F32Sqrt"],
    );
    check("(param i32 f32) (result f32)", "(br_if 0 (f32.sqrt (local.get 1)) (local.get 0))", &["F32Sqrt"]);
}

#[test]
fn values_are_followed_through_locals_and_where_branches_meet() {
    // A local is used again for something else: only what is in it at the store is seen.
    sees(
        "(local.set $x (f32.add (local.get $a) (local.get $b)))
         (local.set $x (f32.mul (local.get $x) (local.get $x)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Mul"],
    );
    let either = |after: &str| {
        format!(
            "(if (local.get $i)
               (then (local.set $x (f32.add (local.get $a) (local.get $b))))
               (else (local.set $x (f32.sub (local.get $a) (local.get $b)))))
             {after}"
        )
    };
    sees(&either("(f32.store (i32.const 0) (local.get $x))"), &["F32Add", "F32Sub"]);
    sees(&either("(drop (f32.sqrt (local.get $x)))"), &[]);
    // Without an `else`, what was there before goes on.
    sees(
        "(local.set $x (f32.add (local.get $a) (local.get $b)))
         (if (local.get $i) (then (local.set $x (f32.const 0))))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
    // Over a branch out of a block, while the way to its end sets another value.
    sees(
        "(block
           (local.set $x (f32.add (local.get $a) (local.get $b)))
           (br_if 0 (local.get $i))
           (br_table 0 0 (local.get $i)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
}

#[test]
fn values_are_followed_round_a_loop() {
    let turns = |inside: &str, after: &str| {
        format!(
            "(loop
               {inside}
               (local.set $x (f32.add (local.get $x) (local.get $a)))
               (br_if 0 (local.tee $i (i32.sub (local.get $i) (i32.const 1)))))
             {after}"
        )
    };
    sees(&turns("", ""), &[]);
    // Seen behind the loop, where it is not what was there before the loop: it always has one turn.
    sees(&turns("", "(f32.store (i32.const 0) (local.get $x))"), &["local 6"]);
    let twice = turns(&turns("", ""), "");
    sees(&format!("{twice} (f32.store (i32.const 0) (local.get $x))"), &["local 6"]);
    sees(&turns("", "(drop (f32.mul (local.get $x) (local.get $x)))"), &[]);
    // Seen in the loop as well: one place is enough.
    let all = "(f32.store (i32.const 0) (local.get $x))";
    sees(&turns(all, all), &["F32Add"]);
    // Behind the loop is what was before the last turn, or before the loop.
    sees(
        "(loop
           (local.set $x (local.get $z))
           (local.set $z (f32.add (local.get $z) (local.get $a)))
           (br_if 0 (local.get $i)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
    sees(
        "(local.set $x (f32.add (local.get $a) (local.get $b)))
         (loop (local.set $x (local.get $x)) (br_if 0 (local.get $i)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
    sees(
        "(local.set $z (f32.add (local.get $a) (local.get $b)))
         (loop (local.set $x (local.get $z)) (br_if 0 (local.get $i)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
    // The loop is left in its midst.
    sees(
        "(block
           (loop
             (local.set $x (f32.add (local.get $x) (local.get $a)))
             (br_if 1 (local.get $i))
             (br 0)))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
    // Seen in the next turn.
    sees(&turns("(f32.store (i32.const 0) (local.get $x))", ""), &["F32Add"]);
    sees(&turns("(drop (f32.mul (local.get $x) (local.get $x)))", ""), &[]);
    // Set in an inner loop, seen in the next turn of the outer one.
    let inner = turns("", "");
    sees(
        &format!("(loop (f32.store (i32.const 0) (local.get $x)) {inner} (br_if 0 (local.get $i)))"),
        &["local 6"],
    );
}

#[test]
fn what_blocks_hand_over_is_seen() {
    let sum = "(f32.add (local.get $a) (local.get $b))";
    sees(&format!("(drop (f32.sqrt (block (result f32) {sum})))"), &["F32Add"]);
    sees(&format!("{sum} (block (param f32) (drop (f32.sqrt)))"), &["F32Add"]);
    sees(&format!("{sum} (if (param f32) (local.get $i) (then (drop)) (else (drop)))"), &["F32Add"]);
    sees(&format!("(drop (if (result f32) (local.get $i) (then {sum}) (else (f32.const 0))))"), &["F32Add"]);
}

#[test]
fn signs_and_choices_pass_values_on() {
    let store = |value: &str| format!("(f32.store (i32.const 0) {value})");
    let sum = "(f32.add (local.get $a) (local.get $b))";
    let choice = format!("(select {sum} (f32.neg (f32.sqrt (local.get $a))) (local.get $i))");
    sees(&store(&choice), &["F32Add", "F32Sqrt"]);
    sees(&format!("(drop (f32.ceil {choice}))"), &[]);
    // The sign of a NaN can be seen in what gets it.
    sees(&store(&format!("(f32.copysign (f32.const 1) {sum})")), &["F32Add"]);
    sees(&format!("(drop (f32.ceil (f32.copysign (f32.const 1) {sum})))"), &["F32Add"]);
    sees(&store(&format!("(f32.copysign {sum} (f32.const 1))")), &["F32Add"]);
    sees(&format!("(drop (f32.ceil (f32.copysign {sum} (f32.const 1))))"), &[]);
}

#[test]
fn lanes_that_are_read_in_another_width_are_seen() {
    let sum = "(f64x2.add (local.get $v) (local.get $w))";
    sees(&format!("(drop (f64x2.sqrt {sum}))"), &[]);
    sees(&format!("(drop (f32x4.sqrt {sum}))"), &["F64x2Add"]);
    sees(&format!("(drop (f32x4.sqrt (f32x4.demote_f64x2_zero {sum})))"), &[]);
    sees(&format!("(drop (f32x4.sqrt (f64x2.neg {sum})))"), &["F64x2Add"]);
    sees(&format!("(drop (f32x4.sqrt (f64x2.splat (f64x2.extract_lane 0 {sum}))))"), &["F64x2Add"]);
    sees(&format!("(drop (i64x2.add {sum} (local.get $v)))"), &["F64x2Add"]);
    // Halves of numbers are put together anew, or change in more than their sign.
    sees(&format!("(drop (f64x2.sqrt (f32x4.splat (f32x4.extract_lane 0 {sum}))))"), &["F64x2Add"]);
    sees(&format!("(drop (f64x2.sqrt (f32x4.neg {sum})))"), &["F64x2Add"]);
    let sum = "(f32x4.add (local.get $v) (local.get $w))";
    sees(&format!("(drop (f32x4.pmin {sum} (local.get $v)))"), &[]);
    sees(&format!("(drop (f64x2.pmin {sum} (local.get $v)))"), &["F32x4Add"]);
    sees(&format!("(v128.store (i32.const 0) (f32x4.pmax {sum} (local.get $v)))"), &["F32x4Add"]);
    sees(&format!("(drop (f64x2.sqrt (f32x4.replace_lane 1 {sum} (f32.const 0))))"), &["F32x4Add"]);
    sees(&format!("(drop (f32x4.sqrt (f32x4.replace_lane 1 {sum} (f32.const 0))))"), &[]);
}

#[test]
fn a_choice_of_bits_is_one_of_lanes_if_its_mask_is() {
    let sum = "(f32x4.add (local.get $v) (local.get $w))";
    let root = "(f32x4.sqrt (local.get $v))";
    let less = "(f32x4.lt (local.get $v) (local.get $w))";
    let half = "(v128.const i32x4 -1 0 -1 0)";
    let reads = |value: &str| format!("(drop (f32x4.floor {value}))");
    let chosen = |mask: &str| format!("(v128.bitselect {sum} {root} {mask})");
    sees(&reads(&chosen(less)), &[]);
    sees(&reads(&chosen(half)), &[]);
    sees(&reads(&chosen(&format!("(v128.and {less} (v128.not {half}))"))), &[]);
    sees(&reads(&chosen("(f64x2.lt (local.get $v) (local.get $w))")), &[]);
    sees(&reads(&chosen("(local.get $w)")), &["F32x4Add", "F32x4Sqrt"]);
    sees(&reads(&chosen("(i16x8.eq (local.get $v) (local.get $w))")), &["F32x4Add", "F32x4Sqrt"]);
    sees(&reads(&chosen(&format!("(v128.xor {less} (local.get $w))"))), &["F32x4Add", "F32x4Sqrt"]);
    sees(&format!("(v128.store (i32.const 0) {})", chosen(less)), &["F32x4Add", "F32x4Sqrt"]);
    // Lanes of 64 bits are put together of halves.
    for mask in
        [less, half.replace("-1 0 -1 0", "-1 0 0 0").as_str(), "(i32x4.eq (local.get $v) (local.get $w))"]
    {
        let chosen = format!("(v128.bitselect (f64x2.sqrt (local.get $v)) (local.get $w) {mask})");
        sees(&format!("(drop (f64x2.floor {chosen}))"), &["F64x2Sqrt"]);
    }
    // What is compared or combined bit by bit is seen.
    sees(&format!("(drop (i32x4.eq {sum} (local.get $w)))"), &["F32x4Add"]);
    sees(&format!("(drop (v128.not {sum}))"), &["F32x4Add"]);
    sees(&reads(&format!("(v128.and {sum} {less})")), &[]);
    sees(&reads(&format!("(v128.and {less} {sum})")), &[]);
    sees(&reads(&format!("(v128.andnot {sum} {less})")), &[]);
    sees(&reads(&format!("(v128.andnot {less} {sum})")), &["F32x4Add"]);
    sees(&reads(&format!("(v128.and {sum} (local.get $w))")), &["F32x4Add"]);
    sees(&reads(&format!("(v128.or {sum} {less})")), &["F32x4Add"]);
}

#[test]
fn a_shuffle_moves_lanes_if_it_keeps_them_whole() {
    let shuffled = |lanes: &str, value: &str| format!("(i8x16.shuffle {lanes} {value} (local.get $w))");
    let reversed = "12 13 14 15 8 9 10 11 20 21 22 23 16 17 18 19";
    let wide = "8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23";
    let shifted = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16";
    for (arithmetic, name, reads, whole) in [
        ("(f32x4.sqrt (local.get $v))", "F32x4Sqrt", "f32x4.floor", vec![reversed, wide]),
        ("(f64x2.sqrt (local.get $v))", "F64x2Sqrt", "f64x2.floor", vec![wide]),
    ] {
        for lanes in [reversed, wide, shifted] {
            let seen: &[&str] = if whole.contains(&lanes) { &[] } else { &[name] };
            sees(&format!("(drop ({reads} {}))", shuffled(lanes, arithmetic)), seen);
            sees(&format!("(v128.store (i32.const 0) {})", shuffled(lanes, arithmetic)), &[name]);
        }
    }
}

#[test]
fn what_is_never_reached_stays_as_it_is() {
    sees(
        "(f32.store (i32.const 0) (f32.add (local.get $a) (local.get $b)))
         (return)
         (f32.store (i32.const 0) (f32.mul (local.get $a) (local.get $b)))
         (loop (f32.store (i32.const 0) (block (result f32) (f32.sqrt (local.get $a)) (br 1))))
         (if (then) (else (unreachable)))",
        &["F32Add"],
    );
    // What comes behind the block is reached by the branch, with the value that the local had there.
    sees(
        "(block
           (local.set $x (f32.add (local.get $a) (local.get $b)))
           (br 0)
           (local.set $x (f32.mul (local.get $a) (local.get $b))))
         (f32.store (i32.const 0) (local.get $x))",
        &["F32Add"],
    );
}

#[test]
fn a_function_with_other_ways_of_control_is_canonical_throughout() {
    // A branch if a reference is null, which takes the operand away.
    sees(
        "(drop (f32.sqrt (f32.add (local.get $a) (local.get $b))))
         (block (drop (br_on_null 0 (ref.null func))))",
        &["F32Add", "F32Sqrt"],
    );
}
