//! YAML as the documents of a suite need it: reading with the file's name in messages, plain writing.

use super::error::SuiteError;
use serde::de::DeserializeOwned;
use std::fmt::Write as _;
use std::path::Path;
use vb_files::yaml;

/// Parses a document; an error names the file, the field and the line.
pub(crate) fn parse<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T, SuiteError> {
    yaml::parse(text).map_err(|e| SuiteError::invalid(file, e.field, e.problem))
}

/// A number as people write it, in the shortest form that reads back to the same bits, always with a decimal point
/// or an exponent so that it stays a number with a fraction for every reader.
pub(crate) fn number(v: f64) -> String {
    // Rust prints the shortest digits that round-trip; -0.0 would only puzzle.
    format!("{:?}", v + 0.0)
}

/// `[a, b, …]`.
pub(crate) fn numbers(values: &[f64]) -> String {
    let list: Vec<_> = values.iter().map(|&v| number(v)).collect();
    format!("[{}]", list.join(", "))
}

/// A double-quoted scalar: JSON's escapes are YAML's.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04x}", c as u32);
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    struct Holder {
        text: String,
        values: Vec<f64>,
    }

    proptest::proptest! {
        #[test]
        fn numbers_and_strings_read_back_exactly(bits: u64, text in "\\PC*[\"\\\\\n\t\u{1}]?\\PC*") {
            let v = f64::from_bits(bits);
            let v = if v.is_finite() { v } else { 0.25 };
            let yaml = format!("text: {}\nvalues: {}\n", quoted(&text), numbers(&[v, -v]));
            let back: Holder = parse(Path::new("t.yaml"), &yaml).unwrap();
            proptest::prop_assert_eq!(back.text, text);
            proptest::prop_assert_eq!(back.values, vec![v, -v]);
        }
    }
}
