//! Notes on a conversion: choices, approximations, assumptions, and values without a counterpart.

use std::fmt;

/// The kind of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A choice between files or options of the source.
    Chosen,
    /// A part that the simulator represents by another one.
    Approximated,
    /// A value that the source does not give.
    Assumed,
    /// A value of the source that has no counterpart.
    NoCounterpart,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Chosen => "chosen",
            Self::Approximated => "approximated",
            Self::Assumed => "assumed",
            Self::NoCounterpart => "no counterpart",
        })
    }
}

/// A remark on a conversion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Its kind.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.text)
    }
}

/// The remarks on a conversion, without repetitions.
#[derive(Clone, Debug, Default)]
pub struct Notes(Vec<Note>);

impl Notes {
    pub(crate) fn add(&mut self, kind: Kind, text: impl Into<String>) {
        let note = Note { kind, text: vb_files::cut_line(&text.into(), 1200) };
        if !self.0.contains(&note) {
            self.0.push(note);
        }
    }

    pub(crate) fn chosen(&mut self, text: impl Into<String>) {
        self.add(Kind::Chosen, text);
    }

    pub(crate) fn approximated(&mut self, text: impl Into<String>) {
        self.add(Kind::Approximated, text);
    }

    pub(crate) fn assumed(&mut self, text: impl Into<String>) {
        self.add(Kind::Assumed, text);
    }

    pub(crate) fn dropped(&mut self, text: impl Into<String>) {
        self.add(Kind::NoCounterpart, text);
    }

    /// All notes: choices first, then approximations, assumptions, and values without a counterpart.
    pub fn iter(&self) -> impl Iterator<Item = &Note> {
        let kinds = [Kind::Chosen, Kind::Approximated, Kind::Assumed, Kind::NoCounterpart];
        kinds.into_iter().flat_map(|k| self.of(k))
    }

    /// The notes of a kind.
    pub fn of(&self, kind: Kind) -> impl Iterator<Item = &Note> {
        self.0.iter().filter(move |n| n.kind == kind)
    }
}
