//! YAML in and out: strict reading with the path of the field, and plain writing.

use super::error::SuiteError;
use serde::de::DeserializeOwned;
use std::fmt::Write as _;
use std::path::Path;

/// Parses a document; an error names the file, the field and the line.
pub(crate) fn parse<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T, SuiteError> {
    let mut options = serde_yaml::Options::default();
    options.with_snippet = false;
    // The sizes that these limits guard against are known: they are the sizes of our own files.
    options.budget = serde_yaml::budget!(max_events: 20_000_000, max_nodes: 10_000_000);
    let mut field = String::new();
    let parsed = serde_yaml::with_deserializer_from_str_with_options(text, options, |de| {
        serde_path_to_error::deserialize::<_, T>(de).map_err(|e| {
            field = e.path().to_string();
            e.into_inner()
        })
    });
    parsed.map_err(|e| {
        let field = if field.is_empty() || field == "." { "document".into() } else { field };
        let problem = e.without_snippet().to_string();
        SuiteError::invalid(file, field, one_line(&problem))
    })
}

/// The message on one line.
pub(crate) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
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
