//! What becomes of whole files.

use wasmparser::{Payload, Validator};

use super::super::{FEATURES, Unfit, rewrite};
use super::{canonical_in, module};

/// The sections of a file and of all that is nested in it, without those of code.
fn sections(file: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let payloads = wasmparser::Parser::new(0).parse_all(file).map(|payload| payload.unwrap());
    let leaves = payloads.filter(|payload| {
        !matches!(
            payload,
            Payload::ModuleSection { .. }
                | Payload::ComponentSection { .. }
                | Payload::CodeSectionStart { .. }
        )
    });
    leaves.filter_map(|payload| payload.as_section()).map(|(id, range)| (id, file[range].to_vec())).collect()
}

#[test]
fn modules_in_components_are_rewritten_and_all_else_stays() {
    let core = |name: &str, operator: &str| {
        format!(
            r#"(core module ${name}
              (memory 1)
              (func $start (f32.store (i32.const 0) (f32.{operator} (f32.const 1) (f32.const 2))))
              (func $quiet (drop (f32.div (f32.const 1) (f32.const 2))))
              (start $start)
              (data (i32.const 8) "some data")
              (@custom "notes" "of {name}"))"#
        )
    };
    let text = format!(
        r#"(component $outer
          (@custom "vb:planner" "abi: 1.0")
          {}
          (component $inner {} (core instance (instantiate $b)))
          (core module $empty)
          {}
          (core instance (instantiate $a))
          (instance (instantiate $inner)))"#,
        core("a", "add"),
        core("b", "mul"),
        core("c", "sub"),
    );
    let file = wat::parse_str(&text).unwrap();
    let rewritten = rewrite(&file).unwrap();
    Validator::new_with_features(FEATURES).validate_all(&rewritten).unwrap();
    assert_eq!(canonical_in(&rewritten), ["F32Add", "F32Mul", "F32Sub"]);
    assert_eq!(sections(&rewritten), sections(&file));
}

#[test]
fn a_file_in_which_no_nan_is_seen_stays_byte_for_byte() {
    let file = module("(param f32) (result i32)", "(f32.lt (f32.sqrt (local.get 0)) (f32.const 1))");
    assert_eq!(rewrite(&file).unwrap(), file);
    let file = wat::parse_str("(module (func))").unwrap();
    assert_eq!(rewrite(&file).unwrap(), file);
}

#[test]
fn a_function_that_becomes_too_large_is_refused() {
    let store = "(f32.store (i32.const 0) (f32.sqrt (local.get 0)))";
    // One parameter, and what the harness adds.
    let with_locals = |count: usize| {
        let locals = " f32".repeat(count);
        rewrite(&module(&format!("(param f32) (local{locals})"), store))
    };
    assert!(with_locals(49_998).is_ok());
    let error = with_locals(49_999).unwrap_err();
    assert!(matches!(error, Unfit::TooLarge { what: "locals", found: 50_001, limit: 50_000 }), "{error}");

    let error = rewrite(&module("(param f32)", &store.repeat(400_000))).unwrap_err();
    assert!(matches!(error, Unfit::TooLarge { what: "bytes in a function", .. }), "{error}");
}

#[test]
fn a_function_with_too_many_branches_for_its_locals_is_canonical_throughout() {
    let branches = |count: usize| {
        let signature = format!("(param f32 i32) (local{})", " f32".repeat(2000));
        let branches = "(if (local.get 1) (then))".repeat(count);
        let file = module(&signature, &format!("(drop (f32.sqrt (local.get 0))) {branches}"));
        canonical_in(&rewrite(&file).unwrap())
    };
    assert_eq!(branches(5_000), [""; 0]);
    assert_eq!(branches(15_000), ["F32Sqrt"]);
}

#[test]
fn what_is_not_valid_is_told() {
    let relaxed = module("(param v128)", "(drop (f32x4.relaxed_min (local.get 0) (local.get 0)))");
    let mut cut = module("(param f32)", "(drop (f32.sqrt (local.get 0)))");
    cut.truncate(cut.len() - 4);
    for file in [relaxed, cut, b"\0asm\x01\0\0".to_vec(), Vec::new()] {
        assert!(matches!(rewrite(&file), Err(Unfit::Invalid(_))));
    }
}
