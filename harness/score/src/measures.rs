//! Structs of measures that are declared once: their fields are what records hold, their list is what tables and docs have.

/// A measure of a struct `T`.
#[derive(Clone, Copy, Debug)]
pub struct Measured<T> {
    /// The name of the measure in records, with its unit.
    pub name: &'static str,
    /// A description of the measure.
    pub about: &'static str,
    /// The function that reads it.
    pub value: Reader<T>,
}

/// The way in which a measure is read.
#[derive(Clone, Copy, Debug)]
pub enum Reader<T> {
    /// The measure is a whole number.
    Count(fn(&T) -> u64),
    /// The measure is a real number.
    Number(fn(&T) -> f64),
    /// The measure is a real number that some records lack.
    Optional(fn(&T) -> Option<f64>),
    /// The measure is true or false.
    Flag(fn(&T) -> bool),
}

impl<T> Measured<T> {
    /// The measure as a number, if it is one.
    #[must_use]
    pub fn number(&self, of: &T) -> Option<f64> {
        match self.value {
            Reader::Count(read) => Some(read(of) as f64),
            Reader::Number(read) => Some(read(of)),
            Reader::Optional(read) => read(of),
            Reader::Flag(_) => None,
        }
    }
}

/// The greatest value of a measure that a record may have; no simulation comes near it.
pub(crate) const MOST: f64 = 1e9;

/// What is wrong with the measure `name` if it lies outside of `low` to `high`.
pub(crate) fn outside(name: &str, value: f64, low: f64, high: f64) -> Option<String> {
    // The shorter form: 1e308 has 309 digits.
    let text = |v: f64| if v.abs() < 1e6 { v.to_string() } else { format!("{v:e}") };
    (!(low..=high).contains(&value))
        .then(|| format!("{name}: {} must lie in {} to {}", text(value), text(low), text(high)))
}

/// Declares a struct of measures together with the list of them, `MEASURES`, in which the documentation of each field says what
/// the measure is.
macro_rules! measures {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident {
            $($(#[doc = $about:literal])+ $(#[serde($($serde:tt)+)])? pub $field:ident: $kind:tt $(<$of:tt>)?,)+
        }
    ) => {
        $(#[$attribute])*
        pub struct $name {
            $($(#[doc = $about])+ $(#[serde($($serde)+)])? pub $field: $kind $(<$of>)?,)+
        }

        impl $name {
            /// Every measure, in the order of records and tables.
            pub const MEASURES: &'static [$crate::Measured<Self>] = &[$($crate::Measured {
                name: stringify!($field),
                about: concat!($($about),+).trim_ascii(),
                value: measures!(@reader $kind, $field),
            }),+];
        }
    };
    (@reader u64, $field:ident) => { $crate::Reader::Count(|m| m.$field) };
    (@reader f64, $field:ident) => { $crate::Reader::Number(|m| m.$field) };
    (@reader bool, $field:ident) => { $crate::Reader::Flag(|m| m.$field) };
    (@reader Option, $field:ident) => { $crate::Reader::Optional(|m| m.$field) };
}
pub(crate) use measures;

#[cfg(test)]
mod tests {
    use crate::{FuelUse, Metrics, Ride};

    #[test]
    fn every_measure_is_documented_in_the_words_of_the_code() {
        let text = include_str!("../../../docs/scoring.md");
        let rows = Metrics::MEASURES.iter().map(|m| (m.name, m.about));
        let rows = rows.chain(Ride::MEASURES.iter().map(|m| (m.name, m.about)));
        for (name, about) in rows.chain(FuelUse::MEASURES.iter().map(|m| (m.name, m.about))) {
            let row = format!("| `{name}` | {} |", about.trim_end_matches('.').replace('|', "\\|"));
            assert!(text.contains(&row), "docs/scoring.md lacks: {row}");
        }
    }
}
