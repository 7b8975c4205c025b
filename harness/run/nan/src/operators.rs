//! What the operators of WebAssembly do with the bits of NaNs: the one table that all else here is built on.

use wasmparser::{Operator, V128};

/// The width of the lanes as which an operator takes its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Width {
    W32,
    W64,
}

/// What the results of arithmetic are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    F32,
    F64,
    F32x4,
    F64x2,
}

impl Shape {
    pub(super) fn width(self) -> Width {
        match self {
            Self::F32 | Self::F32x4 => Width::W32,
            Self::F64 | Self::F64x2 => Width::W64,
        }
    }
}

/// What an operator does with the bits of its operands, and where the bits of its results are from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// It computes new numbers of its operands. Which NaN comes out is the processor's choice, whatever goes in.
    Arithmetic { reads: Width, makes: Shape },
    /// It reads its operands as numbers, and what it makes has nothing of their NaNs.
    Reading(Width),
    /// It compares lanes as numbers; a lane of the result is all ones or all zeros.
    Comparison(Width),
    /// It compares lanes bit by bit, with such a result.
    BitComparison(Width),
    /// It passes lanes on with another sign.
    Sign(Width),
    /// It passes on the lanes of its first operand with the signs of the second.
    CopySign(Width),
    /// It passes on one of its two operands, or lanes of both, by a comparison of them.
    Pick(Width),
    /// It passes on one of two operands, by a third that is no float.
    Select,
    /// It moves lanes: all operands go, as lanes of this width, into the result or leave it.
    Lanes(Width),
    /// It passes on each bit from one of two operands, by a third.
    BitSelect,
    /// It clears bits of the one operand that are clear in the other.
    And,
    /// It clears bits of the first operand that are set in the second.
    AndNot,
    /// It combines the bits of its operands so that a mask of lanes comes of masks of lanes.
    Combination,
    /// It moves bytes; lanes of this width, or of greater ones, stay whole.
    Shuffle(Option<Width>),
    /// It is a vector that is a mask of lanes of this width, or of smaller ones, if of any.
    Constant(Option<Width>),
    /// It forgets its operand.
    Drop,
    /// It may do anything with the bits of its operands.
    Observing,
    /// It takes another way of control than blocks and branches do.
    Detour,
}

/// What an operator does, unless it is a local's or a block's.
pub(super) fn action(operator: &Operator<'_>) -> Action {
    use Action::*;
    use Operator as O;
    use Width::*;
    match operator {
        O::F32Ceil | O::F32Floor | O::F32Trunc | O::F32Nearest | O::F32Sqrt | O::F32Add | O::F32Sub => {
            Arithmetic { reads: W32, makes: Shape::F32 }
        }
        O::F32Mul | O::F32Div | O::F32Min | O::F32Max => Arithmetic { reads: W32, makes: Shape::F32 },
        O::F32DemoteF64 => Arithmetic { reads: W64, makes: Shape::F32 },
        O::F64Ceil | O::F64Floor | O::F64Trunc | O::F64Nearest | O::F64Sqrt | O::F64Add | O::F64Sub => {
            Arithmetic { reads: W64, makes: Shape::F64 }
        }
        O::F64Mul | O::F64Div | O::F64Min | O::F64Max => Arithmetic { reads: W64, makes: Shape::F64 },
        O::F64PromoteF32 => Arithmetic { reads: W32, makes: Shape::F64 },
        O::F32x4Ceil | O::F32x4Floor | O::F32x4Trunc | O::F32x4Nearest | O::F32x4Sqrt | O::F32x4Add => {
            Arithmetic { reads: W32, makes: Shape::F32x4 }
        }
        O::F32x4Sub | O::F32x4Mul | O::F32x4Div | O::F32x4Min | O::F32x4Max => {
            Arithmetic { reads: W32, makes: Shape::F32x4 }
        }
        O::F32x4DemoteF64x2Zero => Arithmetic { reads: W64, makes: Shape::F32x4 },
        O::F64x2Ceil | O::F64x2Floor | O::F64x2Trunc | O::F64x2Nearest | O::F64x2Sqrt | O::F64x2Add => {
            Arithmetic { reads: W64, makes: Shape::F64x2 }
        }
        O::F64x2Sub | O::F64x2Mul | O::F64x2Div | O::F64x2Min | O::F64x2Max => {
            Arithmetic { reads: W64, makes: Shape::F64x2 }
        }
        O::F64x2PromoteLowF32x4 => Arithmetic { reads: W32, makes: Shape::F64x2 },

        O::F32Eq | O::F32Ne | O::F32Lt | O::F32Gt | O::F32Le | O::F32Ge => Reading(W32),
        O::I32TruncF32S | O::I32TruncF32U | O::I64TruncF32S | O::I64TruncF32U => Reading(W32),
        O::I32TruncSatF32S | O::I32TruncSatF32U | O::I64TruncSatF32S | O::I64TruncSatF32U => Reading(W32),
        O::I32x4TruncSatF32x4S | O::I32x4TruncSatF32x4U => Reading(W32),
        O::F64Eq | O::F64Ne | O::F64Lt | O::F64Gt | O::F64Le | O::F64Ge => Reading(W64),
        O::I32TruncF64S | O::I32TruncF64U | O::I64TruncF64S | O::I64TruncF64U => Reading(W64),
        O::I32TruncSatF64S | O::I32TruncSatF64U | O::I64TruncSatF64S | O::I64TruncSatF64U => Reading(W64),
        O::I32x4TruncSatF64x2SZero | O::I32x4TruncSatF64x2UZero => Reading(W64),

        O::F32x4Eq | O::F32x4Ne | O::F32x4Lt | O::F32x4Gt | O::F32x4Le | O::F32x4Ge => Comparison(W32),
        O::F64x2Eq | O::F64x2Ne | O::F64x2Lt | O::F64x2Gt | O::F64x2Le | O::F64x2Ge => Comparison(W64),
        O::I32x4Eq | O::I32x4Ne | O::I32x4LtS | O::I32x4LtU | O::I32x4GtS | O::I32x4GtU => BitComparison(W32),
        O::I32x4LeS | O::I32x4LeU | O::I32x4GeS | O::I32x4GeU => BitComparison(W32),
        O::I64x2Eq | O::I64x2Ne | O::I64x2LtS | O::I64x2GtS | O::I64x2LeS | O::I64x2GeS => BitComparison(W64),

        O::F32Neg | O::F32Abs | O::F32x4Neg | O::F32x4Abs => Sign(W32),
        O::F64Neg | O::F64Abs | O::F64x2Neg | O::F64x2Abs => Sign(W64),
        O::F32Copysign => CopySign(W32),
        O::F64Copysign => CopySign(W64),
        O::F32x4PMin | O::F32x4PMax => Pick(W32),
        O::F64x2PMin | O::F64x2PMax => Pick(W64),
        O::F32x4Splat | O::F32x4ExtractLane { .. } | O::F32x4ReplaceLane { .. } => Lanes(W32),
        O::F64x2Splat | O::F64x2ExtractLane { .. } | O::F64x2ReplaceLane { .. } => Lanes(W64),

        O::Select | O::TypedSelect { .. } => Select,
        O::V128Bitselect => BitSelect,
        O::V128And => And,
        O::V128AndNot => AndNot,
        O::V128Or | O::V128Xor | O::V128Not => Combination,
        O::I8x16Shuffle { lanes } => Shuffle(whole_lanes(lanes)),
        O::V128Const { value } => Constant(mask_of(value)),
        O::Drop => Drop,

        O::TryTable { .. }
        | O::Try { .. }
        | O::Catch { .. }
        | O::CatchAll
        | O::Delegate { .. }
        | O::BrOnNull { .. }
        | O::BrOnNonNull { .. }
        | O::BrOnCast { .. }
        | O::BrOnCastFail { .. }
        | O::BrOnCastDescEq { .. }
        | O::BrOnCastDescEqFail { .. }
        | O::Resume { .. }
        | O::ResumeThrow { .. }
        | O::ResumeThrowRef { .. }
        | O::Switch { .. } => Detour,
        _ => Observing,
    }
}

/// The greatest lanes that a shuffle moves whole, if there are any.
fn whole_lanes(lanes: &[u8; 16]) -> Option<Width> {
    let whole = |bytes: usize| {
        lanes.chunks_exact(bytes).all(|lane| {
            usize::from(lane[0]).is_multiple_of(bytes) && lane.windows(2).all(|w| w[1] == w[0] + 1)
        })
    };
    widest(whole)
}

/// The greatest lanes of which a constant has all bits set or none, if there are any.
fn mask_of(value: &V128) -> Option<Width> {
    let uniform = |bytes: usize| {
        value
            .bytes()
            .chunks_exact(bytes)
            .all(|lane| matches!(lane[0], 0 | 0xff) && lane.iter().all(|byte| *byte == lane[0]))
    };
    widest(uniform)
}

fn widest(holds: impl Fn(usize) -> bool) -> Option<Width> {
    if holds(8) {
        Some(Width::W64)
    } else if holds(4) {
        Some(Width::W32)
    } else {
        None
    }
}
