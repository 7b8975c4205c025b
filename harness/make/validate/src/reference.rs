//! Reference figures and curves of one vehicle, as data.

use crate::check::{Expectation, Expected, Kind};
use crate::events::{event, events};
use crate::setup::{self, Setup};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use vb_files::{Document, DocumentError, Flaw, Schema};
use vb_vehicle::VehicleSpec;

/// What is known of one vehicle beside theory. The file format is `tasks/validation/*.yaml`; see there for an example.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct References {
    /// By event.
    pub expectations: BTreeMap<String, Vec<Expectation>>,
    /// Reference curves to draw beside ours.
    pub curves: Vec<Curve>,
    /// The set-up in which references of a kind were made, where it is not the vehicle as it is.
    pub setups: BTreeMap<Kind, Setup>,
}

/// A reference curve.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    pub event: String,
    /// Titles of the plots that show it.
    pub plots: Vec<String>,
    pub kind: Kind,
    pub label: String,
    /// The label of our line that it belongs to: both have one colour.
    pub beside: String,
    pub source: String,
    /// Pairs of x and y in the plot's units.
    pub points: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    vehicle: String,
    #[serde(default)]
    setups: BTreeMap<Kind, setup::Entry>,
    events: BTreeMap<String, Vec<Entry>>,
    #[serde(default)]
    curves: Vec<Curve>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    figure: String,
    kind: Kind,
    source: String,
    value: Option<f64>,
    fraction: Option<f64>,
    tolerance: Option<f64>,
    at_least: Option<f64>,
    at_most: Option<f64>,
    unsound: Option<String>,
}

impl Document for File {
    type File = Self;
    const KIND: &'static str = "references";
    const FIELDS: &'static str = "docs/validation.md";

    fn from_file(file: Self) -> Result<Self, Flaw> {
        Ok(file)
    }
}

impl Entry {
    /// What is expected, or the field that is at fault and why.
    fn expected(&self) -> Result<Expected, Flaw> {
        let fields = [
            ("value", self.value),
            ("fraction", self.fraction),
            ("tolerance", self.tolerance),
            ("at_least", self.at_least),
            ("at_most", self.at_most),
        ];
        for (name, value) in fields {
            if let Some(v) = value.filter(|v| !v.is_finite()) {
                return Err(Flaw::new(name, format!("{v} is not a number to compare with")));
            }
        }
        for (name, value) in [("fraction", self.fraction), ("tolerance", self.tolerance)] {
            if let Some(v) = value.filter(|v| *v <= 0.0) {
                return Err(Flaw::must_be(name, v, "positive"));
            }
        }
        match (self.value, self.fraction, self.tolerance, self.at_least, self.at_most) {
            (Some(value), Some(fraction), None, None, None) => Ok(Expected::fraction(value, fraction)),
            (Some(value), None, Some(tolerance), None, None) => Ok(Expected::Within { value, tolerance }),
            (None, None, None, Some(low), None) => Ok(Expected::AtLeast(low)),
            (None, None, None, None, Some(high)) => Ok(Expected::AtMost(high)),
            (None, None, None, Some(low), Some(high)) if low <= high => Ok(Expected::Between(low, high)),
            (None, None, None, Some(low), Some(high)) => {
                Err(Flaw::new("at_least", format!("{low} is greater than at_most, {high}")))
            }
            _ => Err(Flaw::new(
                "value",
                "give value with fraction or tolerance, or at_least, or at_most, or at_least and at_most",
            )),
        }
    }
}

impl References {
    /// Reads a file and checks that it is for this vehicle, which is given as its own file has it.
    ///
    /// # Errors
    /// Returns an error if the file can't be read, isn't for this vehicle, or has an invalid field.
    pub fn load(path: &Path, vehicle: &VehicleSpec) -> Result<Self, DocumentError> {
        let file = path.display().to_string();
        Self::of(File::load(path)?, vehicle).map_err(|flaw| flaw.of(File::KIND, file))
    }

    /// Parses the text of a file; `file` names it in messages.
    pub fn parse(text: &str, file: &str, vehicle: &VehicleSpec) -> Result<Self, DocumentError> {
        Self::of(File::parse(text, file)?, vehicle).map_err(|flaw| flaw.of(File::KIND, file))
    }

    fn of(read: File, vehicle: &VehicleSpec) -> Result<Self, Flaw> {
        if read.vehicle != vehicle.name {
            let problem = format!("{:?} is not the vehicle under test, {:?}", read.vehicle, vehicle.name);
            return Err(Flaw::new("vehicle", problem));
        }
        let mut expectations = BTreeMap::new();
        for (name, entries) in read.events {
            let at = format!("events.{name}");
            event(&name).map_err(|e| Flaw::new(at.as_str(), e.to_string()))?;
            let mut list = Vec::new();
            for (i, e) in entries.into_iter().enumerate() {
                let expected = e.expected().map_err(|flaw| flaw.within(&format!("{at}[{i}]")))?;
                let Entry { figure, kind, source, unsound, .. } = e;
                list.push(Expectation { figure, expected, kind, source, unsound });
            }
            expectations.insert(name, list);
        }
        for (i, curve) in read.curves.iter().enumerate() {
            event(&curve.event).map_err(|e| Flaw::new(format!("curves[{i}].event"), e.to_string()))?;
            if let Some(p) = curve.points.iter().flatten().find(|v| !v.is_finite()) {
                return Err(Flaw::new(format!("curves[{i}].points"), format!("{p} is not a number to draw")));
            }
        }
        let mut references = Self { expectations, curves: read.curves, setups: BTreeMap::new() };
        for (kind, entry) in read.setups {
            let at = format!("setups.{}", kind.name());
            if let Some(problem) = setup::refused(kind) {
                return Err(Flaw::new(at, problem));
            }
            if !events().iter().any(|e| references.concern(e.name, kind)) {
                return Err(Flaw::new(at, "there is neither a figure nor a curve of this kind"));
            }
            let setup = entry.setup(vehicle).map_err(|flaw| flaw.within(&at))?;
            references.setups.insert(kind, setup);
        }
        Ok(references)
    }

    /// Whether a figure or a curve of this kind belongs to an event.
    pub(crate) fn concern(&self, event: &str, kind: Kind) -> bool {
        self.expectations.get(event).is_some_and(|list| list.iter().any(|e| e.kind == kind))
            || self.curves.iter().any(|c| c.event == event && c.kind == kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> VehicleSpec {
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        VehicleSpec { name: "car".to_owned(), ..VehicleSpec::parse(text, "hmmwv.yaml").unwrap() }
    }

    fn parsed(entry: &str) -> Result<Expected, String> {
        let text = format!(
            "schema: 1\nvehicle: car\nevents:\n  braking:\n    - {{figure: a, kind: chrono, source: s, {entry}}}\n"
        );
        References::parse(&text, "car.yaml", &car())
            .map(|r| r.expectations["braking"][0].expected)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn every_form_of_an_expectation_is_read() {
        assert_eq!(parsed("value: 2, fraction: 0.05"), Ok(Expected::Within { value: 2.0, tolerance: 0.1 }));
        assert_eq!(parsed("value: 2, tolerance: 0.3"), Ok(Expected::Within { value: 2.0, tolerance: 0.3 }));
        assert_eq!(parsed("at_least: 2"), Ok(Expected::AtLeast(2.0)));
        assert_eq!(parsed("at_most: 2"), Ok(Expected::AtMost(2.0)));
        assert_eq!(parsed("at_least: 2, at_most: 3"), Ok(Expected::Between(2.0, 3.0)));
    }

    #[test]
    fn messages_name_file_field_and_what_to_give() {
        let e = parsed("value: 2").unwrap_err();
        assert!(
            e.starts_with("car.yaml: events.braking[0].value: give value with fraction or tolerance"),
            "{e}"
        );
        let e = parsed("value: 2, tolerance: 0").unwrap_err();
        assert!(e.starts_with("car.yaml: events.braking[0].tolerance: 0 must be positive"), "{e}");
        let e = parsed("at_least: .nan").unwrap_err();
        assert!(e.contains("events.braking[0].at_least: NaN"), "{e}");
        let e = parsed("at_least: 3, at_most: 2").unwrap_err();
        assert!(e.contains("3 is greater than at_most, 2"), "{e}");
        let other =
            References::parse("schema: 1\nvehicle: bus\nevents: {}\n", "bus.yaml", &car()).unwrap_err();
        assert!(other.to_string().contains("\"bus\" is not the vehicle under test, \"car\""), "{other}");
        let e = References::parse("schema: 1\nvehicle: car\nevents: {flying: []}\n", "car.yaml", &car())
            .unwrap_err();
        assert!(e.to_string().contains("events.flying: unknown event flying (events: data-sheet"), "{e}");
    }

    #[test]
    fn a_set_up_is_refused_with_field_and_value_where_it_says_nothing_of_a_reference() {
        let read = |setups: &str| {
            let text = format!(
                "schema: 1\nvehicle: car\nsetups: {setups}\nevents:\n  braking:\n    \
                 - {{figure: a, kind: chrono, source: s, at_least: 1}}\n"
            );
            References::parse(&text, "car.yaml", &car()).map_err(|e| e.to_string())
        };
        let good = read("{chrono: {about: rigid, tyre: rigid}}").unwrap();
        assert_eq!(good.setups[&Kind::Chrono].ground.tyre.model(), "rigid");
        for (setups, says) in [
            (
                "{theory: {about: a}}",
                "car.yaml: setups.theory: theory is compared with the unchanged vehicle",
            ),
            ("{convergence: {about: a}}", "car.yaml: setups.convergence: convergence is compared with"),
            ("{published: {about: a}}", "car.yaml: setups.published: there is neither a figure nor a curve"),
            ("{chrono: {about: a, tyre: square}}", "car.yaml: setups.chrono.tyre: \"square\" is not among"),
            ("{chrono: {about: a, soil_width: 0}}", "car.yaml: setups.chrono.soil_width: 0 must be"),
            ("{chrono: {about: a, tire: rigid}}", "tire"),
            ("{chrono: {tyre: rigid}}", "about"),
            ("{mercury: {about: a}}", "mercury"),
        ] {
            let error = read(setups).unwrap_err();
            assert!(error.contains(says), "{setups}: {error}");
        }
    }
}
