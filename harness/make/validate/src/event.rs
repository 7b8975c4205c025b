//! An event and what it measures.

use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use serde::Serialize;
use vb_sim::SimError;
use vb_vehicle::VehicleSpec;

/// The vehicles of which an event says something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vehicles {
    All,
    /// Vehicles on wheels: the event is of tyres or of single wheels.
    Wheeled,
    /// Vehicles on wheels with steered axles: the event is of wheels that roll without slip about one centre.
    Steered,
    /// Vehicles on wheels that are steered by the speeds of their sides.
    SkidSteered,
    Tracked,
}

impl Vehicles {
    /// As an adjective.
    pub(crate) fn kind(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Wheeled => "wheeled",
            Self::Steered => "wheel-steered",
            Self::SkidSteered => "skid-steered",
            Self::Tracked => "tracked",
        }
    }
}

/// What the vehicle is on in an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Rigid,
    /// Soil. There the set-up of a reference may be another than on rigid ground.
    Soil,
    /// A stand: a plate or a single wheel is on soil, not the vehicle.
    Stand,
}

#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Name on the command line and in files.
    pub name: &'static str,
    pub title: &'static str,
    /// What is driven, and what is asked of the vehicle.
    pub about: &'static str,
    pub vehicles: Vehicles,
    pub place: Place,
    pub(crate) run: fn(&Bench<'_>) -> Result<Outcome, SimError>,
}

impl Event {
    #[must_use]
    pub fn fits(&self, spec: &VehicleSpec) -> bool {
        match self.vehicles {
            Vehicles::All => true,
            Vehicles::Wheeled => spec.tracks.is_none(),
            Vehicles::Steered => spec.tracks.is_none() && spec.skid.is_none(),
            Vehicles::SkidSteered => spec.skid.is_some(),
            Vehicles::Tracked => spec.tracks.is_some(),
        }
    }

    pub fn run(&self, bench: &Bench<'_>) -> Result<Outcome, SimError> {
        (self.run)(bench)
    }
}

/// One number that an event measures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What it is; unique within its event.
    pub name: String,
    /// Not a number where the event did not get so far.
    pub value: f64,
    /// Unit of the value; empty for a ratio.
    pub unit: &'static str,
}

/// All that an event measured.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// In the order of the event's own story.
    pub figures: Vec<Figure>,
    /// What theory says of them.
    pub theory: Vec<Expectation>,
    /// Time series, one a case.
    pub series: Vec<Series>,
    pub plots: Vec<Plot>,
    /// What a reader should know before judging.
    pub notes: Vec<String>,
}

impl Outcome {
    pub(crate) fn figure(&mut self, name: impl Into<String>, value: f64, unit: &'static str) {
        self.figures.push(Figure { name: name.into(), value, unit });
    }

    pub(crate) fn theory(
        &mut self,
        figure: impl Into<String>,
        expected: Expected,
        source: impl Into<String>,
    ) {
        self.theory.push(Expectation::theory(figure, expected, source));
    }

    /// A figure with its theory.
    pub(crate) fn expect(
        &mut self,
        name: &str,
        value: f64,
        unit: &'static str,
        expected: Expected,
        source: impl Into<String>,
    ) {
        self.figure(name, value, unit);
        self.theory(name, expected, source);
    }

    /// A figure with what was published of it.
    pub(crate) fn published(
        &mut self,
        name: &str,
        value: f64,
        unit: &'static str,
        expected: Expected,
        source: &str,
    ) {
        self.figure(name, value, unit);
        self.theory.push(Expectation {
            figure: name.to_owned(),
            expected,
            kind: Kind::Published,
            source: source.to_owned(),
            unsound: None,
        });
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|f| f.name == name).map(|f| f.value)
    }
}

/// A table of numbers over time, or over whatever its first column is.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name of the case; letters, digits, `-` and `.`, so that it can name a file.
    pub name: String,
    /// Name and unit of each column.
    pub columns: Vec<(String, &'static str)>,
    /// One number a column.
    pub rows: Vec<Vec<f64>>,
}

impl Series {
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.0 == name)
    }

    /// Pairs of two columns; empty if one isn't there.
    #[must_use]
    pub fn pairs(&self, x: &str, y: &str) -> Vec<[f64; 2]> {
        match (self.column(x), self.column(y)) {
            (Some(i), Some(j)) => self.rows.iter().map(|r| [r[i], r[j]]).collect(),
            _ => Vec::new(),
        }
    }

    /// As CSV: a header of `name [unit]`, then the rows.
    #[must_use]
    pub fn csv(&self) -> String {
        let head: Vec<String> = self
            .columns
            .iter()
            .map(|(n, u)| if u.is_empty() { n.clone() } else { format!("{n} [{u}]") })
            .collect();
        let mut out = head.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(|v| format!("{v:.6}")).collect();
            out += &cells.join(",");
            out.push('\n');
        }
        out
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    Ours,
    /// Our simulation in the set-up of a reference that is drawn beside it.
    Setup,
    /// A reference run or publication.
    Reference,
    Theory,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub label: String,
    pub kind: LineKind,
    pub points: Vec<[f64; 2]>,
    /// Which of the plot's cases it belongs to: lines of one case have one colour.
    pub case: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Unique within its event.
    pub title: String,
    /// Quantity and unit of the x axis.
    pub x: String,
    /// Quantity and unit of the y axis.
    pub y: String,
    /// The lines, in the order of the legend.
    pub lines: Vec<Line>,
    /// Whether both axes are places on the ground and must have one scale.
    pub map: bool,
}

impl Plot {
    pub(crate) fn new(title: &str, x: &str, y: &str) -> Self {
        Self { title: title.to_owned(), x: x.to_owned(), y: y.to_owned(), lines: Vec::new(), map: false }
    }

    /// A map of places, m.
    pub(crate) fn map(title: &str, x: &str, y: &str) -> Self {
        Self { map: true, ..Self::new(title, x, y) }
    }

    /// Range of x over our own lines, those in a set-up included.
    pub(crate) fn span(&self) -> [f64; 2] {
        let own = |l: &&Line| matches!(l.kind, LineKind::Ours | LineKind::Setup);
        let ours = self.lines.iter().filter(own).flat_map(|l| &l.points);
        ours.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p[0]), b.max(p[0])])
    }

    pub(crate) fn line(
        &mut self,
        kind: LineKind,
        case: usize,
        label: impl Into<String>,
        points: Vec<[f64; 2]>,
    ) {
        self.lines.push(Line { label: label.into(), kind, points, case });
    }

    /// Adds our line of the next case.
    pub(crate) fn ours(&mut self, label: impl Into<String>, points: Vec<[f64; 2]>) {
        let case = self.lines.iter().map(|l| l.case + 1).max().unwrap_or(0);
        self.line(LineKind::Ours, case, label, points);
    }
}
