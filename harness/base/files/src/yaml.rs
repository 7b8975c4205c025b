//! Strict reading of YAML documents with messages that people can act on.

use serde::de::DeserializeOwned;

use crate::flaw::Flaw;

/// Parses one document. A number may still be NaN or infinite: the caller checks its values.
///
/// # Errors
/// Returns an error if the text is not YAML or does not have the shape of `T`. Unknown fields are refused where `T`
/// denies them.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Flaw> {
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
        let mut problem = crate::one_line(&e.without_snippet().to_string());
        let place = e.location().map(|l| (l.line() as usize, l.column() as usize));
        if let Some(value) = place.and_then(|(line, column)| scalar_at(text, line, column)) {
            problem = format!("{value:?}: {problem}");
        }
        Flaw { field, problem }
    })
}

/// The scalar that begins at a line and column (from 1), as it stands in the text.
fn scalar_at(text: &str, line: usize, column: usize) -> Option<&str> {
    let rest = text.lines().nth(line.checked_sub(1)?)?;
    let (start, _) = rest.char_indices().nth(column.checked_sub(1)?)?;
    let rest = &rest[start..];
    let end = rest.find([',', '}', ']', '#']).unwrap_or(rest.len());
    let value = rest[..end].trim();
    (!value.is_empty() && !value.starts_with(['{', '[']) && !value.starts_with("- ")).then_some(value)
}
