//! Structs of measures that are declared once: their fields are what records hold, their list is what tables and docs have.

/// A measure of a struct `T`: what tables, pages and documentation have of it.
#[derive(Clone, Copy, Debug)]
pub struct Measured<T> {
    /// The name of the measure in records, with its unit.
    pub name: &'static str,
    /// A description of the measure.
    pub about: &'static str,
    /// The function that reads it.
    pub value: Reader<T>,
    /// Whether it can be negative.
    pub signed: bool,
    /// The greatest absolute value that a record may have; `None` for that of its type and unit.
    pub most: Option<f64>,
    /// The head of its column in lists of tasks, with the unit; `None` if it has no column.
    pub column: Option<&'static str>,
    /// Its distribution over the tasks of a run, as reports draw it; `None` if they don't.
    pub distribution: Option<Distribution>,
}

/// How the distribution of a measure over tasks is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Distribution {
    /// The title of the figure.
    pub title: &'static str,
    /// The unit on its axis.
    pub unit: &'static str,
    /// The tasks and places in question.
    pub of: Extent,
}

/// Where a distribution is drawn, and over which tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All tasks, in HTML reports and among the figures for papers.
    Papers,
    /// All tasks, in HTML reports.
    Pages,
    /// Tasks that fail, in HTML reports.
    Failures,
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
    /// The measure, negative values included.
    pub(crate) const fn signed(self) -> Self {
        Self { signed: true, ..self }
    }

    /// The measure with this greatest absolute value.
    pub(crate) const fn most(self, value: f64) -> Self {
        Self { most: Some(value), ..self }
    }

    /// The measure with a column in lists of tasks.
    pub(crate) const fn column(self, head: &'static str) -> Self {
        Self { column: Some(head), ..self }
    }

    /// The measure with a figure of its distribution.
    pub(crate) const fn drawn(self, of: Extent, title: &'static str, unit: &'static str) -> Self {
        Self { distribution: Some(Distribution { title, unit, of }), ..self }
    }

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

impl<T> Measured<T> {
    /// The flaw of a value that no trial can have: its name, its value, and what is allowed.
    pub(crate) fn flaw(&self, of: &T) -> Option<String> {
        const TURN: f64 = 180.0;
        // A mean of angles may be beyond the greatest by its last digit.
        let rounded = |v: f64| if v.abs() < 1e6 { (v * 1e6).round() / 1e6 } else { v };
        let high = self.most.unwrap_or(match (self.name, &self.value) {
            (name, _) if name.ends_with("_deg") => TURN,
            (name, _) if name.ends_with("_deg2") => TURN * TURN,
            (name, _) if name.ends_with("_fraction") => 1.0,
            (_, Reader::Count(_)) => f64::INFINITY,
            _ => MOST,
        });
        outside(self.name, rounded(self.number(of)?), if self.signed { -high } else { 0.0 }, high)
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
/// the measure is. Behind `=>` follow methods of [`Measured`] that say more of it. The name in front is that of the struct in records.
macro_rules! measures {
    (
        $(#[$attribute:meta])*
        $group:literal: pub struct $name:ident {
            $($(#[doc = $about:literal])+ $(#[serde($($serde:tt)+)])? pub $field:ident: $kind:tt $(<$of:tt>)?
                $(=> $($more:ident($($arg:tt)*))+)?,)+
        }
    ) => {
        $(#[$attribute])*
        pub struct $name {
            $($(#[doc = $about])+ $(#[serde($($serde)+)])? pub $field: $kind $(<$of>)?,)+
        }

        impl $name {
            /// Every measure, in the order of records and tables.
            pub const MEASURES: &'static [$crate::Measured<Self>] = &[$($crate::Measured::<Self> {
                name: stringify!($field),
                about: concat!($($about),+).trim_ascii(),
                value: measures!(@reader $kind, $field),
                signed: false,
                most: None,
                column: None,
                distribution: None,
            } $($(.$more($($arg)*))+)?),+];

            /// The first measure that no trial can have: its name, its value, and what is allowed. `None` if there is none.
            #[must_use]
            pub fn flaw(&self) -> Option<String> {
                Self::MEASURES.iter().find_map(|m| m.flaw(self))
            }

            /// Reads the measures of a record, which may be of strangers.
            ///
            /// # Errors
            /// Returns an error if a measure is missing, or can't be one.
            pub(crate) fn checked<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<Self>, D::Error> {
                let read = <Option<Self> as serde::Deserialize>::deserialize(from)?;
                match read.as_ref().and_then(Self::flaw) {
                    Some(flaw) => Err(serde::de::Error::custom(format!(concat!($group, ".{}"), flaw))),
                    None => Ok(read),
                }
            }
        }
    };
    (@reader u64, $field:ident) => { $crate::Reader::Count(|m| m.$field) };
    (@reader f64, $field:ident) => { $crate::Reader::Number(|m| m.$field) };
    (@reader bool, $field:ident) => { $crate::Reader::Flag(|m| m.$field) };
    (@reader Option, $field:ident) => { $crate::Reader::Optional(|m| m.$field) };
}
pub(crate) use measures;

/// Compares the rows of a table of docs/scoring.md, in the section and under the head given, with those of the code.
/// `INSTA_UPDATE=always` writes them.
#[cfg(test)]
pub(crate) fn documented(section: &str, head: &str, rows: impl Iterator<Item = Vec<String>>) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../docs/scoring.md");
    let text = std::fs::read_to_string(path).unwrap();
    let from = text.find(&format!("\n## {section}\n")).unwrap();
    let from = from + text[from..].find(head).unwrap() + head.len();
    let from = from + text[from..].find("|\n|--").unwrap() + 2;
    let from = from + text[from..].find('\n').unwrap() + 1;
    let to = from + text[from..].find("\n\n").unwrap() + 1;
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rows: String = rows.map(row).collect();
    if std::env::var("INSTA_UPDATE").is_ok_and(|v| v == "always") {
        std::fs::write(path, format!("{}{rows}{}", &text[..from], &text[to..])).unwrap();
    } else {
        assert_eq!(&text[from..to], rows, "{path}: INSTA_UPDATE=always cargo test -p vb-score documented");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Flag, FuelUse, Metrics, Ride};

    #[test]
    fn measures_and_flags_are_documented_in_the_words_of_the_code() {
        fn cell(about: &str) -> String {
            about.trim_end_matches('.').replace('|', "\\|")
        }
        fn rows<T>(of: &[Measured<T>]) -> impl Iterator<Item = Vec<String>> {
            of.iter().map(|m| vec![format!("`{}`", m.name), cell(m.about)])
        }
        documented("Metrics", "| field | meaning ", rows(Metrics::MEASURES));
        documented("Shock and ride", "| field | meaning ", rows(Ride::MEASURES));
        documented("Fuel", "| field | meaning ", rows(FuelUse::MEASURES));
        let flags = Flag::ALL.into_iter();
        let flags = flags.map(|flag| vec![format!("`{flag}`"), flag.title().to_owned(), cell(flag.about())]);
        documented("Flags", "| flag | in tables ", flags);
    }
}
