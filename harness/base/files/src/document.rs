//! Documents: YAML files that people write. Each kind implements [`Document`]; all are read, checked and reported in the same way.

use std::fmt::Display;
use std::path::Path;

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::flaw::{DocumentError, Flaw};
use crate::{DOCUMENT, read_text, yaml};

/// A kind of document, e.g. rules or vehicles.
///
/// A new kind needs its struct (with `schema:` [`Schema`] as its first field and `deny_unknown_fields`), this trait, and one line:
/// `vb_files::document!(Kind);`.
pub trait Document: Sized {
    /// Content of the file; `Self` unless it is converted.
    type File: DeserializeOwned;

    /// Name of the kind in messages, e.g. `rules`.
    const KIND: &'static str;

    /// Documentation page of the fields, e.g. `docs/scoring.md`; empty if there is none.
    const FIELDS: &'static str = "";

    /// Documents within the program, as name and text.
    const BUILTIN: &'static [(&'static str, &'static str)] = &[];

    /// Checks the values, and converts them.
    ///
    /// # Errors
    /// Returns the first field whose value is invalid.
    fn from_file(file: Self::File) -> Result<Self, Flaw>;

    /// Reads a document from text; messages name it `file`.
    ///
    /// # Errors
    /// Returns an error if the text is not YAML, or if a field is missing, unknown or invalid.
    fn parse(text: &str, file: &str) -> Result<Self, DocumentError> {
        parse(text, file)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// As [`Self::parse`], and if the file cannot be read or is larger than [`DOCUMENT`].
    fn load(path: &Path) -> Result<Self, DocumentError> {
        let file = path.display().to_string();
        match read_text(path, DOCUMENT) {
            Ok(text) => Self::parse(&text, &file),
            Err(e) => {
                let names: Vec<&str> = Self::BUILTIN.iter().map(|(name, _)| *name).collect();
                let problem = if names.is_empty() {
                    e.to_string()
                } else {
                    format!("{e} (give a YAML file, or one of {})", names.join(", "))
                };
                Err(DocumentError { kind: Self::KIND, file, field: String::new(), problem })
            }
        }
    }

    /// Finds a document of [`Self::BUILTIN`] by name, or reads a file by its path.
    ///
    /// # Errors
    /// As [`Self::load`].
    fn resolve(name_or_path: &str) -> Result<Self, DocumentError> {
        match Self::BUILTIN.iter().find(|(name, _)| *name == name_or_path) {
            Some((name, text)) => Self::parse(text, name),
            None => Self::load(Path::new(name_or_path)),
        }
    }
}

/// What [`Document::parse`] does unless a kind checks the text before.
///
/// # Errors
/// As [`Document::parse`].
pub fn parse<D: Document>(text: &str, file: &str) -> Result<D, DocumentError> {
    let read = yaml::parse(text).map_err(|Flaw { field, mut problem }| {
        if !D::FIELDS.is_empty() {
            problem = format!("{problem} (fields: {})", D::FIELDS);
        }
        Flaw { field, problem }
    });
    read.and_then(D::from_file).map_err(|flaw| flaw.of(D::KIND, file))
}

/// Gives a kind of document its public functions.
#[macro_export]
macro_rules! document {
    ($kind:ty) => {
        impl $kind {
            /// Documents within the program, as name and text.
            pub const BUILTIN: &'static [(&'static str, &'static str)] = <Self as $crate::Document>::BUILTIN;

            /// Reads the document from text; messages name it `file`.
            ///
            /// # Errors
            /// Returns an error if the text is not YAML, or if a field is missing, unknown or invalid.
            pub fn parse(text: &str, file: &str) -> Result<Self, $crate::DocumentError> {
                <Self as $crate::Document>::parse(text, file)
            }

            /// Reads a file.
            ///
            /// # Errors
            /// As [`Self::parse`], and if the file cannot be read or is too large.
            pub fn load(path: &std::path::Path) -> Result<Self, $crate::DocumentError> {
                <Self as $crate::Document>::load(path)
            }

            /// Finds a document within the program by name, or reads a file by its path.
            ///
            /// # Errors
            /// As [`Self::load`].
            pub fn resolve(name_or_path: &str) -> Result<Self, $crate::DocumentError> {
                <Self as $crate::Document>::resolve(name_or_path)
            }
        }
    };
}

/// Checks that a value lies between two others, both included. NaN does not.
///
/// # Errors
/// Returns a flaw with value and range.
pub fn within<T: PartialOrd + Display>(field: &str, value: T, low: T, high: T) -> Result<(), Flaw> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(Flaw::new(field, format!("{value} must lie in {low} to {high}")))
}

/// Checks that both values of a pair, the lower first, lie between two others.
///
/// # Errors
/// Returns a flaw of `field[0]` or `field[1]`.
pub fn pair_within(field: &str, [lower, upper]: [f64; 2], low: f64, high: f64) -> Result<(), Flaw> {
    within(&format!("{field}[0]"), lower, low, high)?;
    within(&format!("{field}[1]"), upper, lower, high)
}

/// The version of a format, as its field `schema`. Another version is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Schema<const VERSION: u32>;

impl<const VERSION: u32> Serialize for Schema<VERSION> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(VERSION)
    }
}

impl<'de, const VERSION: u32> Deserialize<'de> for Schema<VERSION> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u32::deserialize(deserializer)? {
            version if version == VERSION => Ok(Self),
            version => Err(D::Error::custom(format!(
                "version {version} is not supported; this build reads version {VERSION}"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Bed {
        schema: Schema<2>,
        depth: f64,
    }

    impl Document for Bed {
        type File = Self;
        const KIND: &'static str = "bed";
        const FIELDS: &'static str = "docs/beds.md";
        const BUILTIN: &'static [(&'static str, &'static str)] = &[("deep", "schema: 2\ndepth: 3.0\n")];

        fn from_file(bed: Self) -> Result<Self, Flaw> {
            within("depth", bed.depth, 0.0, 9.0)?;
            Ok(bed)
        }
    }

    #[test]
    fn a_document_is_found_by_name_or_path() {
        assert_eq!(Bed::resolve("deep").unwrap().depth, 3.0);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.yaml");
        std::fs::write(&path, "schema: 2\ndepth: 1\n").unwrap();
        assert_eq!(Bed::resolve(path.to_str().unwrap()).unwrap().depth, 1.0);
        let missing = Bed::resolve("shallow").unwrap_err().to_string();
        assert!(missing.starts_with("cannot read bed shallow: "), "{missing}");
        assert!(missing.ends_with("(give a YAML file, or one of deep)"), "{missing}");
    }

    #[test]
    fn a_flaw_names_file_field_value_and_fields() {
        let flaw = |text: &str| Bed::parse(text, "own.yaml").unwrap_err().to_string();
        assert_eq!(flaw("schema: 2\ndepth: 10\n"), "own.yaml: depth: 10 must lie in 0 to 9");
        assert!(flaw("schema: 2\ndepth: .nan\n").starts_with("own.yaml: depth: NaN must lie in 0 to 9"));
        let other = flaw("schema: 3\ndepth: 1\n");
        assert!(
            other.contains("schema: ")
                && other.contains("version 3 is not supported; this build reads version 2"),
            "{other}"
        );
        let unknown = flaw("schema: 2\ndepth: 1\nwidth: 2\n");
        assert!(unknown.contains("width") && unknown.ends_with("(fields: docs/beds.md)"), "{unknown}");
        assert!(flaw("schema: 2\ndepth: deep\n").contains("own.yaml: depth: \"deep\": "));
    }

    #[test]
    fn the_version_is_written_as_a_number() {
        assert_eq!(serde_json::to_string(&Schema::<7>).unwrap(), "7");
    }
}
