//! Canonical NaNs, where their bits can be seen.
//!
//! WebAssembly leaves open which NaN an operation gives, and processors differ in it. A planner that looks at the bits –
//! that stores them, hands them out or reads them as an integer – would compute something else on another machine. The
//! engine can make each result canonical as it comes, but then code of floats in vectors takes up to three times as
//! long. Nearly always the bits are not looked at: a sum that is only multiplied, compared or made an integer needs no
//! more than to be a NaN.
//!
//! So planners are rewritten before they are compiled. Where the bits of a result may be seen, operators are added that
//! make it canonical (`emit`); where they can't (`flow`, over the values of `graph`, by the table of `operators`), the
//! result stays as it is. What can be seen of a planner is, bit for bit, what the engine's own pass would give. The
//! operators that are added cost fuel as all others do.

mod emit;
mod flow;
mod graph;
mod operators;
#[cfg(test)]
mod tests;

use wasm_encoder::Encode as _;
use wasmparser::{BinaryReaderError, FuncValidatorAllocations, Parser, Payload, ValidPayload, Validator};

use super::engine;
use emit::Failure;

/// The version of what this makes of a plugin. Whatever is compiled of a plugin depends on it.
pub(super) const VERSION: u32 = 1;

/// Numbers of the sections that hold modules and components in components, and code in modules.
const MODULE_SECTION: u8 = 1;
const COMPONENT_SECTION: u8 = 4;
const CODE_SECTION: u8 = 10;

/// Why a plugin can't be rewritten.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unfit {
    /// The engine says so in its own words, too.
    #[error("{0}")]
    Invalid(#[from] BinaryReaderError),
    #[error(
        "a function has {found} {what} once its NaNs are made the same on every processor, and may have {limit}; divide \
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

/// A module or component with canonical NaNs in all its functions. All of it but the functions that need it stays as it
/// is, byte for byte.
pub(super) fn rewrite(file: &[u8]) -> Result<Vec<u8>, Unfit> {
    let mut validator = Validator::new_with_features(engine::FEATURES);
    let mut allocations = FuncValidatorAllocations::default();
    let mut parser = Parser::new(0);
    parser.set_features(engine::FEATURES);
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
