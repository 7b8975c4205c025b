//! A function's body with operators that make NaNs canonical. All else in it stays byte for byte.

use wasm_encoder::{Encode, Ieee32, Ieee64, Instruction, ValType};
use wasmparser::{BinaryReaderError, FunctionBody};

use super::graph::Site;
use super::operators::Shape;

/// What the engine takes at most in one function. The numbers are those of all engines (WebAssembly's JavaScript interface,
/// "Implementation-defined limits").
const MAX_LOCALS: u32 = 50_000;
const MAX_BODY_BYTES: usize = 7_654_321;

/// The locals in which results are kept while they are compared, by type; each is there if it is used.
#[derive(Default)]
struct Scratch {
    f32: Option<u32>,
    f64: Option<u32>,
    v128: Option<u32>,
}

impl Scratch {
    fn local(&mut self, shape: Shape) -> &mut Option<u32> {
        match shape {
            Shape::F32 => &mut self.f32,
            Shape::F64 => &mut self.f64,
            Shape::F32x4 | Shape::F64x2 => &mut self.v128,
        }
    }
}

fn value_type(shape: Shape) -> ValType {
    match shape {
        Shape::F32 => ValType::F32,
        Shape::F64 => ValType::F64,
        Shape::F32x4 | Shape::F64x2 => ValType::V128,
    }
}

/// Why a function can't be written.
pub(super) enum Failure {
    Invalid(BinaryReaderError),
    /// With what is added it has more than the engine takes: so many of what, and what it may have.
    TooLarge {
        what: &'static str,
        found: usize,
        limit: usize,
    },
}

impl From<BinaryReaderError> for Failure {
    fn from(error: BinaryReaderError) -> Self {
        Self::Invalid(error)
    }
}

/// Writes the body of a function that has so many locals, parameters included. The sites are in their order; offsets
/// count from the begin of the file.
pub(super) fn body(
    file: &[u8],
    body: &FunctionBody<'_>,
    locals: u32,
    sites: &[Site],
) -> Result<Vec<u8>, Failure> {
    let range = body.range();
    if sites.is_empty() {
        return Ok(file[range].to_vec());
    }
    let mut groups = body.get_locals_reader()?;
    let mut declared = groups.get_count();
    for _ in 0..declared {
        groups.read()?;
    }
    let kept = groups.original_position();
    // The number of groups stands in front of them.
    let mut first = body.get_binary_reader();
    first.read_var_u32()?;

    let mut scratch = Scratch::default();
    let mut added = Vec::new();
    let mut count = locals;
    for site in sites.iter().filter(|site| site.local.is_none()) {
        let local = scratch.local(site.shape);
        if local.is_none() {
            *local = Some(count);
            1u32.encode(&mut added);
            value_type(site.shape).encode(&mut added);
            (count, declared) = (count + 1, declared + 1);
        }
    }
    within("locals", count as usize, MAX_LOCALS as usize)?;

    let mut out = Vec::with_capacity(range.len() + 48 * sites.len());
    declared.encode(&mut out);
    out.extend_from_slice(&file[first.original_position()..kept]);
    out.append(&mut added);
    let mut from = kept;
    for site in sites {
        out.extend_from_slice(&file[from..site.end]);
        match (site.local, *scratch.local(site.shape)) {
            (Some(local), _) => {
                Instruction::LocalGet(local).encode(&mut out);
                choose(site.shape, local, &mut out);
                Instruction::LocalSet(local).encode(&mut out);
            }
            (None, Some(local)) => {
                Instruction::LocalTee(local).encode(&mut out);
                choose(site.shape, local, &mut out);
            }
            (None, None) => {}
        }
        from = site.end;
    }
    out.extend_from_slice(&file[from..range.end]);
    within("bytes in a function", out.len(), MAX_BODY_BYTES)?;
    Ok(out)
}

fn within(what: &'static str, found: usize, limit: usize) -> Result<(), Failure> {
    if found > limit { Err(Failure::TooLarge { what, found, limit }) } else { Ok(()) }
}

/// Replaces the float on the stack, or each lane that it has, by the canonical NaN if it is a NaN, which alone doesn't
/// equal itself. A local holds the float as well.
fn choose(shape: Shape, local: u32, out: &mut Vec<u8>) {
    use Instruction::*;
    let (nan, equal, choose) = match shape {
        Shape::F32 => (F32Const(Ieee32::new(0x7fc0_0000)), F32Eq, Select),
        Shape::F64 => (F64Const(Ieee64::new(0x7ff8_0000_0000_0000)), F64Eq, Select),
        Shape::F32x4 => (V128Const(0x7fc0_0000_7fc0_0000_7fc0_0000_7fc0_0000), F32x4Eq, V128Bitselect),
        Shape::F64x2 => (V128Const(0x7ff8_0000_0000_0000_7ff8_0000_0000_0000), F64x2Eq, V128Bitselect),
    };
    for instruction in [nan, LocalGet(local), LocalGet(local), equal, choose] {
        instruction.encode(out);
    }
}
