//! Rules of exploration, as data: `tasks/exploration/*.yaml`.

use serde::{Deserialize, Serialize};
use vb_files::document::{pair_within, within};
use vb_files::{Document, Flaw, Schema};

/// The distribution of exploration drives. Lengths are those of the full-size world and are multiplied by a world's
/// scale, times and speeds by its square root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exploration {
    /// Version of the format.
    pub schema: Schema<1>,
    /// The name of the file without its extension.
    pub name: String,
    /// A description in one sentence.
    #[serde(default)]
    pub description: String,
    pub steering: SteeringDraws,
    pub speed: SpeedDraws,
    /// Driving in reverse; never if omitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reverse: Option<ReverseDraws>,
    pub start: StartDraws,
}

/// The distribution of the steering: offset + amplitude · sin(2π · frequency · t + phase), within [-1, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteeringDraws {
    /// The minimum and the maximum amplitude, from 0 to 1.
    pub amplitude: [f64; 2],
    /// The minimum and the maximum frequency, Hz.
    pub frequency_hz: [f64; 2],
    /// The minimum and the maximum offset, from -1 to 1.
    pub offset: [f64; 2],
    /// The minimum and the maximum time between two samples, s.
    pub hold_s: [f64; 2],
}

/// The distribution of the target speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedDraws {
    /// The minimum and the maximum speed, m/s.
    pub range_m_per_s: [f64; 2],
    /// The minimum and the maximum time between two samples, s.
    pub hold_s: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReverseDraws {
    /// The probability that a sampled speed is in reverse.
    pub probability: f64,
    /// The minimum and the maximum speed, m/s.
    pub range_m_per_s: [f64; 2],
}

/// The distribution of start poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartDraws {
    /// The maximum tilt of the ground under the wheels, degrees.
    pub tilt_deg: f64,
    /// The minimum distance from the vehicle to an obstacle, m.
    pub clearance_m: f64,
    /// The minimum distance to the edge of the world, m.
    pub edge_m: f64,
}

impl Document for Exploration {
    type File = Self;
    const KIND: &'static str = "exploration";
    const FIELDS: &'static str = "docs/datasets.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("default", include_str!("../../../../../tasks/exploration/default.yaml")),
        ("paper", include_str!("../../../../../tasks/exploration/paper.yaml")),
    ];

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.check()?;
        Ok(rules)
    }
}

vb_files::document!(Exploration);

impl Exploration {
    fn check(&self) -> Result<(), Flaw> {
        pair_within("steering.amplitude", self.steering.amplitude, 0.0, 1.0)?;
        pair_within("steering.frequency_hz", self.steering.frequency_hz, 0.001, 5.0)?;
        pair_within("steering.offset", self.steering.offset, -1.0, 1.0)?;
        pair_within("steering.hold_s", self.steering.hold_s, 0.1, 3600.0)?;
        pair_within("speed.range_m_per_s", self.speed.range_m_per_s, 0.1, 30.0)?;
        pair_within("speed.hold_s", self.speed.hold_s, 0.1, 3600.0)?;
        if let Some(reverse) = self.reverse {
            within("reverse.probability", reverse.probability, 0.0, 1.0)?;
            pair_within("reverse.range_m_per_s", reverse.range_m_per_s, 0.1, 10.0)?;
        }
        within("start.tilt_deg", self.start.tilt_deg, 1.0, 45.0)?;
        within("start.clearance_m", self.start.clearance_m, 0.0, 50.0)?;
        within("start.edge_m", self.start.edge_m, 0.0, 50.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_that_come_with_the_harness_are_valid_and_the_paper_s_drives_at_two_metres_a_second() {
        for (name, _) in Exploration::BUILTIN {
            assert_eq!(Exploration::resolve(name).unwrap().name, *name);
        }
        // RSS 2025, section on datasets.
        let paper = Exploration::resolve("paper").unwrap();
        assert_eq!((paper.speed.range_m_per_s, paper.reverse), ([2.0, 2.0], None));
    }

    #[test]
    fn a_flaw_is_told_with_file_field_and_value() {
        let text = Exploration::BUILTIN[0].1;
        let told = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            let e = Exploration::parse(&text.replace(from, to), "mine.yaml").unwrap_err().to_string();
            assert!(e.starts_with("mine.yaml: ") && !e.contains('\n'), "{e}");
            e
        };
        assert!(
            told("schema: 1", "schema: 2").contains("version 2 is not supported; this build reads version 1")
        );
        assert!(told("[1.0, 6.0]", "[1.0, 60.0]").contains("speed.range_m_per_s[1]: 60 must lie in 1 to 30"));
        assert!(told("[1.0, 6.0]", "[7.0, 6.0]").contains("speed.range_m_per_s[1]: 6 must lie in 7 to 30"));
        assert!(told("[0.0, 1.0]", "[.nan, 1.0]").contains("steering.amplitude[0]: NaN"));
        assert!(told("probability: 0.05", "probability: 2").contains("reverse.probability: 2"));
        assert!(told("tilt_deg", "tilt").contains("tilt"));
        let e = Exploration::resolve("wandering").unwrap_err().to_string();
        assert!(e.contains("wandering") && e.contains("default, paper"), "{e}");
    }
}
