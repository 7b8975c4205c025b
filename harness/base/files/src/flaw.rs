//! Errors of documents: an invalid field, and the error of a file that contains it.

use std::fmt::Display;

/// Why a document cannot be used, on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DocumentError {
    /// Name of the kind.
    pub kind: &'static str,
    /// Name of the file in messages.
    pub file: String,
    /// Path of the field, e.g. `soils.mud.cohesion`; empty if the file cannot be read.
    pub field: String,
    /// The value and what is allowed, or the error of the operating system.
    pub problem: String,
}

impl Display for DocumentError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { kind, file, field, problem } = self;
        if field.is_empty() {
            return write!(f, "cannot read {kind} {file}: {problem}");
        }
        write!(f, "{file}: {field}: {problem}")
    }
}

impl std::error::Error for DocumentError {}

/// An invalid field of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flaw {
    /// Path of the field, e.g. `tasks[2].goal`.
    pub field: String,
    /// The value and what is allowed.
    pub problem: String,
}

impl Flaw {
    /// A flaw of a field.
    pub fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { field: field.into(), problem: problem.into() }
    }

    /// A field whose value must be something else: `value must be want`.
    pub fn must_be(field: impl Into<String>, value: impl Display, want: &str) -> Self {
        Self::new(field, format!("{value} must be {want}"))
    }

    /// This flaw as the error of a file.
    #[must_use]
    pub fn of(self, kind: &'static str, file: impl Into<String>) -> DocumentError {
        DocumentError { kind, file: file.into(), field: self.field, problem: self.problem }
    }

    /// The same flaw of a part of the document at `place`.
    #[must_use]
    pub fn within(self, place: &str) -> Self {
        Self { field: format!("{place}.{}", self.field), ..self }
    }
}

impl Display for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.field, self.problem)
    }
}

impl std::error::Error for Flaw {}
