//! Random programs show the same bits, whoever makes their NaNs canonical.

use sha2::{Digest as _, Sha256};
use wasmtime::{Config, Engine, Instance, Module, Store, Val};

use super::super::operators::{Action, action};
use super::super::{FEATURES, rewrite};
use super::programs::{BYTES, program};
use super::{bodies, canonical_in};

/// Programs that are tried; all take some seconds.
const PROGRAMS: u64 = 600;
/// Programs that are tried where processors are emulated, which takes twenty times as long, and 20 MB of memory for each.
const EMULATED: u64 = 150;
/// Fuel that no program uses up, even with what is added.
const FUEL: u64 = 100_000_000;

fn engine_with(change: impl Fn(&mut Config)) -> Engine {
    let mut config = Config::new();
    config.consume_fuel(true).wasm_features(FEATURES.complement(), false).wasm_features(FEATURES, true);
    change(&mut config);
    Engine::new(&config).unwrap()
}

/// All that can be seen of a program when it has run.
#[derive(Debug, PartialEq)]
struct Seen {
    end: Option<String>,
    globals: [u128; 3],
    memory: Vec<u8>,
}

fn run(engine: &Engine, module: &[u8]) -> Seen {
    let module = Module::new(engine, module).unwrap();
    let mut store = Store::new(engine, ());
    store.set_fuel(FUEL).unwrap();
    let instance = Instance::new(&mut store, &module, &[]).unwrap();
    let end = instance.get_typed_func::<(), ()>(&mut store, "run").unwrap().call(&mut store, ());
    let globals = ["f32", "f64", "v128"].map(|name| {
        match instance.get_global(&mut store, name).unwrap().get(&mut store) {
            Val::F32(bits) => u128::from(bits),
            Val::F64(bits) => u128::from(bits),
            Val::V128(bits) => bits.as_u128(),
            other => panic!("{other:?}"),
        }
    });
    let memory = instance.get_memory(&mut store, "memory").unwrap();
    let memory = memory.data(&store)[..BYTES as usize].to_vec();
    Seen { end: end.err().map(|error| error.root_cause().to_string()), globals, memory }
}

fn arithmetic_in(module: &[u8]) -> usize {
    let operators = bodies(module).into_iter().flat_map(|body| body.get_operators_reader().unwrap());
    operators
        .filter(|operator| matches!(action(operator.as_ref().unwrap()), Action::Arithmetic { .. }))
        .count()
}

#[test]
fn random_programs_show_the_bits_that_the_engines_own_pass_gives() {
    let ours = engine_with(|_| {});
    let theirs = engine_with(|config| {
        config.cranelift_nan_canonicalization(true);
    });
    let (mut differ, mut arithmetic, mut canonical) = (0, 0, 0);
    for seed in 0..PROGRAMS {
        let text = program(seed);
        let module = wat::parse_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let rewritten = rewrite(&module).unwrap();
        let expected = run(&theirs, &module);
        assert_eq!(run(&ours, &rewritten), expected, "program {seed}:\n{text}");
        differ += u64::from(run(&ours, &module) != expected);
        arithmetic += arithmetic_in(&module);
        canonical += canonical_in(&rewritten).len();
    }
    // The programs are such that it matters, and that much of it can be left out.
    assert!(differ > PROGRAMS / 3, "{differ} programs show other bits as they are");
    assert!(4 * canonical < 3 * arithmetic, "{canonical} of {arithmetic} results are made canonical");
}

/// A snapshot, of no meaning in itself: it was made on x86-64, where an invalid operation gives a negative NaN, and holds on
/// AArch64, where it gives a positive one.
#[test]
fn random_programs_show_the_same_bits_on_every_machine() {
    let engine = engine_with(|_| {});
    let mut digest = Sha256::new();
    for seed in 0..EMULATED {
        let module = wat::parse_str(program(seed)).unwrap();
        let seen = run(&engine, &rewrite(&module).unwrap());
        digest.update(seen.end.unwrap_or_default());
        seen.globals.iter().for_each(|global| digest.update(global.to_le_bytes()));
        digest.update(seen.memory);
    }
    let digest: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(digest, "b5b54d495cbbc6395bc82ff6b15b199e379fcb8c38b4b7f2fe4b12e657496eb8");
}
