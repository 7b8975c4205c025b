//! What an elevation file says about its heights and where they lie, and what is known only by assumption.

use std::fmt::Write as _;

use crate::ElevationImage;
use crate::crs::{Crs, Length};

use super::Holes;

/// How an elevation file is read where it leaves something open.
#[derive(Clone, Debug, Default)]
pub struct Options {
    pub holes: Holes,
    /// Metres that one unit of the values is high, whatever the file says.
    pub unit: Option<f64>,
    /// A value that marks places without a height, whatever the file says.
    pub no_data: Option<f64>,
    /// Values that look like an unmarked mark of no data are heights.
    pub keep: bool,
    /// Distance between the samples, m, whatever the file says; of a geographic system the distance after its projection.
    pub resolution: Option<f64>,
    /// The coordinate reference system, whatever the file says.
    pub crs: Option<Crs>,
    /// Values are labels and not heights: they have no unit, and none is computed from its neighbours.
    pub labels: bool,
}

/// Where a statement comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    File,
    Caller,
    /// Nobody says so; in brackets why it was assumed, or nothing.
    Assumed(&'static str),
}

/// Where a survey lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The system of its coordinates; `None` if nobody says.
    pub crs: Option<Crs>,
    /// The middle of the raster in that system.
    pub middle: [f64; 2],
    /// Metres on the ground for a unit of the coordinates along x and y.
    pub metres: [f64; 2],
}

impl Place {
    /// Coordinates of a point, m east and north of the middle of the raster.
    #[must_use]
    pub fn at(&self, [east, north]: [f64; 2]) -> [f64; 2] {
        [self.middle[0] + east / self.metres[0], self.middle[1] + north / self.metres[1]]
    }
}

/// Heights of an elevation file, and what it says about them.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Heights in metres, first row in the north; holes are NaN.
    pub heights: ElevationImage,
    pub format: &'static str,
    /// Rows and columns of the file.
    pub samples: [usize; 2],
    /// The unit of the values in the file, after their scale and offset.
    pub unit: Length,
    /// Where the unit comes from.
    pub unit_said: Said,
    /// The order of the rows and columns in the file.
    pub orientation: &'static str,
    /// Where it lies; `None` if the file doesn't say.
    pub place: Option<Place>,
    /// What a surveyor should know of the file and of what was made of it, a sentence each.
    pub notes: Vec<String>,
    /// The value that was taken for an unmarked mark of no data.
    pub suspect: Option<f64>,
}

impl Survey {
    /// The lowest and the highest height, m; `None` if there are only holes.
    #[must_use]
    pub fn range(&self) -> Option<[f64; 2]> {
        let known = self.heights.values().iter().filter(|z| !z.is_nan());
        let range =
            known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(*z), high.max(*z)]);
        (range[0] <= range[1]).then_some(range)
    }

    /// One line: heights, samples, orientation, unit and coordinate system.
    #[must_use]
    pub fn summary(&self) -> String {
        // Nobody has said how high a grey level is.
        let levels = self.format == super::PICTURE && matches!(self.unit_said, Said::Assumed(_));
        let mut line = match self.range() {
            Some([low, high]) if levels => format!("grey levels {low} to {high}"),
            Some([low, high]) => format!("heights {low:.1} to {high:.1} m"),
            None => "no heights".to_owned(),
        };
        let (rows, cols) = (self.heights.rows(), self.heights.cols());
        let _ = write!(line, ", {cols} x {rows} samples");
        if let Some(resolution) = self.heights.resolution() {
            let _ = write!(line, " at {} m", short(resolution));
        }
        let _ = write!(line, ", {}", self.orientation);
        let name = if self.unit_said == Said::Caller {
            format!("{} m", self.unit.metres)
        } else {
            self.unit.name.clone()
        };
        let said = match self.unit_said {
            Said::File => String::new(),
            Said::Caller => " (given)".to_owned(),
            Said::Assumed("") => " (assumed)".to_owned(),
            Said::Assumed(why) => format!(" (assumed: {why})"),
        };
        if levels {
            line.push_str(", unit unknown");
        } else {
            let _ = write!(line, ", unit {name}{said}");
        }
        match &self.place {
            Some(Place { crs: Some(crs), .. }) => {
                let _ = write!(line, ", {}", crs.name);
            }
            _ => line.push_str(", no coordinate system"),
        }
        let holes = self.heights.holes();
        if holes > 0 {
            let _ = write!(line, ", {holes} holes");
        }
        line
    }
}

/// A number with six significant digits at most.
#[must_use]
pub fn short(v: f64) -> String {
    let text = format!("{v:.5e}");
    text.parse::<f64>().map_or(text, |v| v.to_string())
}
