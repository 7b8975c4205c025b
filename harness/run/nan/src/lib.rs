//! Makes NaNs canonical where their bits are observable.
//!
//! WebAssembly leaves open which NaN an operation returns, and processors differ. A planner that observes the bits (stores
//! them, returns them, or reads them as an integer) would compute other results on another machine. The bits are rarely
//! observed: a sum that is only multiplied, compared or converted to an integer only has to be some NaN.
//!
//! [`rewrite`] changes a plugin before it is compiled. Where the bits of a result may be observed, it inserts operators that
//! make the NaN canonical (`emit`); elsewhere (`flow`, over the values of `graph`, with the table of `operators`) the result
//! stays as it is. The observable behaviour equals, bit for bit, that of wasmtime's own pass
//! (`Config::cranelift_nan_canonicalization`), which canonicalises each result: the tests run random programs with both. Inserted
//! operators cost fuel as all others do.
//!
//! Why not wasmtime's own pass: it makes planners that compute with floats slower, most of all in SIMD code. Duration of a step
//! with wasmtime's pass relative to this one (`cargo bench -p vb-host --bench planners`, both relative to the native planner in
//! the same run; wasmtime 48, 2 x86-64 cores, medians of two runs):
//!
//! | planner | wasmtime's pass / this pass |
//! |---|---|
//! | WM-VCT | 1.05 |
//! | RL | 1.4 |
//! | TAL | 1.2 |
//! | TNT | 1.3 |
//! | MPPI-6 | 1.3 |
//! | MPPI, EH | 2.1 |
//! | Ibex | 2.5 |
//! | network in f32 SIMD (`rollouts`) | 2.9 |

mod emit;
mod flow;
mod graph;
mod operators;
#[cfg(test)]
mod tests;

use wasm_encoder::Encode as _;
use wasmparser::{
    BinaryReaderError, FuncValidatorAllocations, Parser, Payload, ValidPayload, Validator, WasmFeatures,
};

use emit::Failure;

/// The WebAssembly features of plugins: version 3.0 without those that planners have no use for (threads, garbage collection,
/// exceptions) and without relaxed SIMD, whose results differ between processors. A feature with operators that compute floats
/// or branch must be in the tables of this crate before it is added.
pub const FEATURES: WasmFeatures = WasmFeatures::WASM3
    .difference(WasmFeatures::RELAXED_SIMD)
    .difference(WasmFeatures::THREADS)
    .difference(WasmFeatures::GC_TYPES)
    .difference(WasmFeatures::EXCEPTIONS)
    .union(WasmFeatures::COMPONENT_MODEL);

/// Version of the output of [`rewrite`]; part of the key of cached code.
pub const VERSION: u32 = 1;

/// Numbers of the sections that hold modules and components in components, and code in modules.
const MODULE_SECTION: u8 = 1;
const COMPONENT_SECTION: u8 = 4;
const CODE_SECTION: u8 = 10;

/// Why a plugin can't be rewritten.
#[derive(Debug, thiserror::Error)]
pub enum Unfit {
    /// The engine says so in its own words, too.
    #[error("{0}")]
    Invalid(#[from] BinaryReaderError),
    #[error(
        "a function has {found} {what} after NaN canonicalisation; the limit is {limit}: split \
         the function"
    )]
    TooLarge { what: &'static str, found: usize, limit: usize },
}

impl From<Failure> for Unfit {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Invalid(error) => Self::Invalid(error),
            Failure::TooLarge { what, found, limit } => Self::TooLarge { what, found, limit },
        }
    }
}

/// Rewrites a module or component so that all its functions have canonical NaNs. Everything but the functions that need it
/// stays equal, byte for byte.
///
/// # Errors
/// Returns an error if the file is invalid or uses more than [`FEATURES`], or if a function becomes too large.
pub fn rewrite(file: &[u8]) -> Result<Vec<u8>, Unfit> {
    let mut validator = Validator::new_with_features(FEATURES);
    let mut allocations = FuncValidatorAllocations::default();
    let mut parser = Parser::new(0);
    parser.set_features(FEATURES);
    let mut outermost = Vec::with_capacity(file.len() + file.len() / 8);
    // The modules and components around the current place, which become sections of what is around them.
    let mut nested: Vec<(u8, Vec<u8>)> = Vec::new();
    let mut code = Code::default();
    for payload in parser.parse_all(file) {
        let payload = payload?;
        let valid = validator.payload(&payload)?;
        let out = nested.last_mut().map_or(&mut outermost, |(_, out)| out);
        match &payload {
            Payload::Version { range, .. } => out.extend_from_slice(&file[range.clone()]),
            Payload::ModuleSection { .. } => nested.push((MODULE_SECTION, Vec::new())),
            Payload::ComponentSection { .. } => nested.push((COMPONENT_SECTION, Vec::new())),
            Payload::End(_) => {
                if let Some((id, section)) = nested.pop() {
                    let out = nested.last_mut().map_or(&mut outermost, |(_, out)| out);
                    put_section(id, &section, out);
                }
            }
            Payload::CodeSectionStart { count, .. } => code = Code::new(*count, out),
            other => {
                if let ValidPayload::Func(function, body) = valid {
                    let mut function = function.into_validator(allocations);
                    let sites = flow::sites(&body, &mut function)?;
                    let body = emit::body(file, &body, function.len_locals(), &sites)?;
                    code.put(&body, out);
                    allocations = function.into_allocations();
                } else if let Some((id, range)) = other.as_section() {
                    put_section(id, &file[range], out);
                }
            }
        }
    }
    Ok(outermost)
}

/// A code section in the making.
#[derive(Default)]
struct Code {
    missing: u32,
    section: Vec<u8>,
}

impl Code {
    fn new(functions: u32, out: &mut Vec<u8>) -> Self {
        let mut code = Self { missing: functions, section: Vec::new() };
        functions.encode(&mut code.section);
        code.finish(out);
        code
    }

    fn put(&mut self, body: &[u8], out: &mut Vec<u8>) {
        body.encode(&mut self.section);
        self.missing = self.missing.saturating_sub(1);
        self.finish(out);
    }

    /// Writes the section if it is whole.
    fn finish(&self, out: &mut Vec<u8>) {
        if self.missing == 0 {
            put_section(CODE_SECTION, &self.section, out);
        }
    }
}

fn put_section(id: u8, content: &[u8], out: &mut Vec<u8>) {
    out.push(id);
    content.encode(out);
}
