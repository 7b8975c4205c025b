//! An event and what it measures.

use crate::characteristics::Characteristics;
use crate::check::{Expectation, Expected, Kind};
use crate::course::NamedCourse;
use crate::geometry::Geometry;
use crate::pace::Pace;
use serde::Serialize;
use vb_sim::{SimError, SimOptions, SoilSet, VehicleState};
use vb_vehicle::{VehicleModel, VehicleSpec, powertrain::Differential};

/// A vehicle ready to be put through events.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    pub(crate) spec: &'a VehicleSpec,
    pub(crate) model: VehicleModel,
    pub(crate) soils: &'a [SoilSet],
    pub(crate) options: SimOptions,
    pub(crate) geometry: Geometry,
    pub(crate) pace: Pace,
    /// The vehicle as it stands on level ground.
    pub(crate) standing: VehicleState,
    /// The course of a file that takes the place of those of the events.
    pub(crate) course: Option<&'a NamedCourse>,
}

impl<'a> Bench<'a> {
    /// For a vehicle, the sets of soils to put it on and a step, s.
    ///
    /// # Errors
    /// [`SimError::Vehicle`] for a vehicle whose suspension doesn't close.
    pub fn new(spec: &'a VehicleSpec, soils: &'a [SoilSet], step: f64) -> Result<Self, SimError> {
        let options = SimOptions { step, ..SimOptions::default() };
        let model = VehicleModel::new(spec.clone())?;
        let rest = crate::grounds::at_rest(&model, options)?;
        let geometry = Geometry::new(&model, rest.wheels.iter().map(|w| w.deflection).collect());
        Ok(Self {
            spec,
            soils,
            options,
            geometry,
            pace: Pace::new(spec),
            model,
            standing: rest,
            course: None,
        })
    }

    /// The same with a course for the events `ride-course` and `half-round`.
    pub(crate) fn on_course(self, course: Option<&'a NamedCourse>) -> Self {
        Self { course, ..self }
    }

    #[must_use]
    pub fn characteristics(&self) -> Characteristics {
        Characteristics::new(self)
    }

    /// Radius of the wheels on level ground and smallest distance between the wheels of an axle, m: those of the kinematics without slip in
    /// comparisons with recordings.
    #[must_use]
    pub fn radius_and_track(&self) -> [f64; 2] {
        [self.geometry.radius, self.geometry.track()]
    }

    /// Friction between the ground and the vehicle's tyres where it is the lesser of theirs; that of the ground for tyres whose
    /// forces scale with it.
    pub(crate) fn grip(&self, ground: f64) -> f64 {
        self.spec.tyre.coulomb_friction().map_or(ground, |own| own.min(ground))
    }

    /// Whether an engine that idles behind a converter drives the vehicle with nothing pressed.
    pub(crate) fn creeps(&self) -> bool {
        self.spec.powertrain.converter.is_some()
    }

    /// Whether a differential, or the motors of the sides, turn both wheels of an axle alike, by which its corners are those of no theory
    /// here.
    pub(crate) fn winds_up(&self) -> bool {
        let line = &self.spec.powertrain.driveline;
        line.axles.iter().any(|a| a.differential == Differential::Locked {}) || self.spec.skid.is_some()
    }

    pub(crate) fn at_resolution(&self, soil_resolution: f64) -> Self {
        Self { options: SimOptions { soil_resolution, ..self.options }, ..self.clone() }
    }

    pub(crate) fn at_step(&self, step: f64) -> Self {
        Self { options: SimOptions { step, ..self.options }, ..self.clone() }
    }
}

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
