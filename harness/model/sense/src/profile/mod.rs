//! Perception profiles: what a vehicle knows beforehand and what its sensors are like, as data.
//!
//! Lengths are those of the full-size world and are multiplied by a world's scale; docs/perception.md says what becomes of
//! the other figures. A sensor that a profile leaves out isn't there.

mod check;
mod confusion;

pub use confusion::{Confusions, Seen};
pub(crate) use confusion::{OBSTACLE, Recogniser, UNKNOWN};

use serde::Deserialize;
use std::path::Path;

use vb_files::{Document, DocumentError, Flaw, Schema};
use vb_sdk::metadata::{Metadata, Need};

/// A profile, and what its file is told apart by.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    data: ProfileData,
    sha256: String,
}

/// The content of a profile's file (`tasks/perception/*.yaml`).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileData {
    pub schema: Schema<1>,
    pub name: String,
    /// What the profile stands for, in one line, for people.
    pub description: String,
    /// The maps that a planner is given at the start.
    pub prior: Prior,
    /// The estimate of the vehicle's state.
    pub pose: Option<PoseModel>,
    pub wheel_odometry: Option<WheelModel>,
    /// The inertial sensor.
    pub imu: Option<ImuModel>,
    /// The receiver of satellite positions.
    pub gnss: Option<GnssModel>,
    /// The lidar.
    pub lidar: Option<LidarModel>,
    /// The depth camera.
    pub depth: Option<DepthModel>,
    /// The map of heights and classes that lidar and camera build up around the vehicle.
    pub local_map: Option<LocalMapModel>,
}

/// The maps that a planner is given at the start; one that is left out is unknown.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prior {
    pub elevation: Option<PriorElevation>,
    /// The kinds of ground.
    pub semantics: Option<PriorSemantics>,
    /// The squares that obstacles cover.
    pub occupancy: Option<PriorOccupancy>,
}

/// The accuracy of the elevation map that planners receive at the start.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PriorElevation {
    Exact,
    /// As on a map made from afar: means over squares, with errors that neighbouring samples share.
    Coarse {
        /// The distance between samples, m.
        resolution_m: f64,
        /// The side of the squares over which heights are averaged, m.
        smoothing_m: f64,
        /// The standard deviation of the error, m.
        error_std_m: f64,
        /// The distance along x or y over which the correlation of the error falls to 1/e, m.
        error_correlation_m: f64,
    },
}

/// The accuracy of the map of terrain classes that planners receive at the start.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PriorSemantics {
    Exact,
    /// As on a map made from afar: the commonest kind of each square, which may be taken for another.
    Coarse {
        /// The side of the squares, m.
        resolution_m: f64,
        #[serde(default)]
        confusions: Confusions,
    },
}

/// The accuracy of the obstacle map that planners receive at the start.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorOccupancy {
    /// The side of the squares, m.
    pub resolution_m: f64,
}

/// The estimate of the vehicle's state.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseModel {
    Exact,
    /// Dead reckoning from the start, which drifts with the way that is driven.
    Estimated(PoseNoise),
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseNoise {
    /// The random walk of the heading, rad for √(1 m) driven.
    pub heading_walk_rad_per_sqrt_m: f64,
    /// The random walk of the position along x and y each, m for √(1 m) driven.
    pub position_walk_m_per_sqrt_m: f64,
    /// The random walk of the height, m for √(1 m) driven.
    pub height_walk_m_per_sqrt_m: f64,
    /// The error of roll and pitch each.
    pub tilt: AngleError,
    /// The standard deviation of the velocity along each axis, m/s, independent every 10 ms.
    pub velocity_std_m_per_s: f64,
    /// The standard deviation of the angular velocity about each axis, rad/s, independent every 10 ms.
    pub angular_velocity_std_rad_per_s: f64,
}

/// An error of an angle that follows a first-order Gauss–Markov process.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AngleError {
    /// The standard deviation, degrees.
    pub std_deg: f64,
    /// The time over which the correlation falls to 1/e, s.
    pub correlation_s: f64,
}

/// Times of two states that take turns.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spells {
    /// The mean time from the end of one spell to the beginning of the next, s.
    pub mean_interval_s: f64,
    /// The mean time that a spell takes, s.
    pub mean_duration_s: f64,
}

/// The measurements of the wheel encoders and the suspension travel sensors.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WheelModel {
    Exact,
    /// Encoders that count, and measured travels.
    Measured(WheelNoise),
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelNoise {
    /// The counts of an encoder in a turn of the wheel.
    pub counts_per_turn: u32,
    /// The time over which counts are taken for a spin, s: a multiple of 10 ms.
    pub window_s: f64,
    /// The standard deviation of the suspension travel, m, independent every 10 ms.
    pub travel_std_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImuModel {
    /// The number of measurements in a second.
    pub rate_hz: f64,
    /// The errors of the specific force along each axis, in m/s².
    pub accelerometer: Inertial,
    /// The errors of the angular velocity about each axis, in rad/s.
    pub gyroscope: Inertial,
}

/// The errors of an inertial sensor by the terms of IEEE Std 952-1997 (annex C), where u is m/s² for an accelerometer and
/// rad/s for a gyroscope. Values of 0 leave an error out.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inertial {
    /// The white noise N, u·√s: the velocity random walk, m/s/√s, or the angle random walk, rad/√s.
    pub random_walk: f64,
    /// The lowest part of the Allan deviation that the bias leaves, u, which data sheets call in-run bias stability.
    pub bias_instability: f64,
    /// The correlation time of that bias, s.
    pub bias_correlation_s: f64,
    /// The rate random walk K of the bias, u/√s.
    pub rate_random_walk: f64,
    /// The standard deviation of the bias at the start, u.
    pub turn_on_bias: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GnssModel {
    /// The number of positions in a second.
    pub rate_hz: f64,
    /// The errors along x and y each.
    pub horizontal: GnssError,
    /// The error of the height.
    pub vertical: GnssError,
    /// When there is no position.
    pub outages: Option<Spells>,
}

/// The errors of a position along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GnssError {
    /// The standard deviation of the correlated part, a first-order Gauss–Markov process, m.
    pub std_m: f64,
    /// Its correlation time, s.
    pub correlation_s: f64,
    /// The standard deviation of the part that is independent every time, m.
    pub white_std_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LidarModel {
    /// The number of turns in a second.
    pub rate_hz: f64,
    /// The number of beams.
    pub rows: u32,
    /// The number of directions of a turn.
    pub cols: u32,
    /// The elevation of the lowest beam, degrees.
    pub lowest_deg: f64,
    /// The elevation of the highest beam, degrees.
    pub highest_deg: f64,
    /// The minimum distance that it measures, m.
    pub min_range_m: f64,
    /// The maximum distance that it measures, m.
    pub max_range_m: f64,
    /// The standard deviation of a distance, m.
    pub range_std_m: f64,
    /// The probability that nothing comes back from near by.
    pub dropout_near: f64,
    /// The probability that nothing comes back from the maximum distance. In between it grows with the distance squared,
    /// as the light that comes back becomes less.
    pub dropout_far: f64,
    /// The dust in the air; none if absent.
    pub dust: Option<Dust>,
    /// The place and direction of the lidar.
    pub mount: MountModel,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dust {
    pub spells: Spells,
    /// The share of light that is lost along a way, 1/m.
    pub extinction_per_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthModel {
    /// The number of images in a second.
    pub rate_hz: f64,
    /// The number of rows of an image.
    pub rows: u32,
    /// The number of columns of an image.
    pub cols: u32,
    /// The angle between the left and the right edge of an image, degrees.
    pub field_of_view_deg: f64,
    /// The minimum depth that it measures, m.
    pub min_depth_m: f64,
    /// The maximum depth that it measures, m.
    pub max_depth_m: f64,
    /// The standard deviation of a depth over the depth squared, 1/m.
    pub error_per_m: f64,
    /// The probability that a pixel has no depth.
    pub dropout: f64,
    /// Whether pixels have labels.
    pub labels: bool,
    #[serde(default)]
    pub confusions: Confusions,
    /// The place and direction of the camera.
    pub mount: MountModel,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MountModel {
    /// Over the middle of the highest part of the hull.
    Roof {
        /// How far above the hull, m.
        above_m: f64,
        /// How far it looks down, degrees.
        pitch_deg: f64,
    },
    /// Over the front edge of the highest part of the hull.
    RoofFront {
        /// How far above the hull, m.
        above_m: f64,
        /// How far it looks down, degrees.
        pitch_deg: f64,
    },
    /// At a place in the body frame.
    At {
        /// The place, m.
        position_m: [f64; 3],
        /// The roll, degrees.
        roll_deg: f64,
        /// The pitch, degrees, positive when it looks down.
        pitch_deg: f64,
        /// The yaw, degrees, positive when it looks to the left.
        yaw_deg: f64,
    },
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalMapModel {
    /// The number of maps in a second, at most.
    pub rate_hz: f64,
    /// The side of the map, m.
    pub side_m: f64,
    /// The side of its cells, m.
    pub resolution_m: f64,
    /// The number of hits on a cell from which on a new one counts as one of so many.
    pub memory: u32,
}

impl Document for ProfileData {
    type File = Self;
    const KIND: &'static str = "perception profile";
    const FIELDS: &'static str = "docs/perception.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("oracle", include_str!("../../../../../tasks/perception/oracle.yaml")),
        ("onboard", include_str!("../../../../../tasks/perception/onboard.yaml")),
        ("degraded", include_str!("../../../../../tasks/perception/degraded.yaml")),
    ];

    fn from_file(data: Self) -> Result<Self, Flaw> {
        check::check(&data)?;
        Ok(data)
    }
}

/// The name of the profile without any error.
pub const ORACLE: &str = "oracle";

impl Profile {
    /// The names of the profiles that come with the harness.
    pub fn names() -> impl Iterator<Item = &'static str> {
        ProfileData::BUILTIN.iter().map(|(name, _)| *name)
    }

    /// The profile of this name that comes with the harness; `None` if there is none.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        let (name, text) = ProfileData::BUILTIN.iter().find(|(n, _)| *n == name)?;
        // Tests parse them all, so they have no flaw.
        Some(Self::parse(text, name).unwrap_or_else(|e| unreachable!("built-in profile: {e}")))
    }

    /// The profile without any error, which ranked runs have.
    #[must_use]
    pub fn oracle() -> Self {
        Self::built_in(ORACLE).unwrap_or_else(|| unreachable!("the profile `{ORACLE}` is built in"))
    }

    /// Reads a profile from a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, and as [`Self::parse`].
    pub fn load(path: &Path) -> Result<Self, DocumentError> {
        let file = path.display().to_string();
        match vb_files::read_text(path, vb_files::DOCUMENT) {
            Ok(text) => Self::parse(&text, &file),
            Err(e) => Err(Flaw::new("", e.to_string()).of(ProfileData::KIND, file)),
        }
    }

    /// Reads a profile from text; messages name it `file`.
    ///
    /// # Errors
    /// Returns an error if the text is not YAML, or if a field is missing, unknown or invalid.
    pub fn parse(text: &str, file: &str) -> Result<Self, DocumentError> {
        let data = ProfileData::parse(text, file)?;
        Ok(Self { data, sha256: vb_files::sha256(text.as_bytes()) })
    }

    /// Tells whether a planner gets a map of heights, of the kinds of ground and of obstacles.
    #[must_use]
    pub fn gives_all_maps(&self) -> bool {
        let prior = &self.data.prior;
        prior.elevation.is_some() && prior.semantics.is_some() && prior.occupancy.is_some()
    }

    /// Tells whether the maps that a planner gets are the same in every run: as the world is.
    #[must_use]
    pub fn has_exact_maps(&self) -> bool {
        let prior = &self.data.prior;
        matches!(prior.elevation, None | Some(PriorElevation::Exact))
            && matches!(prior.semantics, None | Some(PriorSemantics::Exact))
    }

    /// The sensors that a planner gets.
    #[must_use]
    pub fn sensors_of(&self, planner: &Metadata) -> Vec<Need> {
        planner.sensors(self.gives_all_maps())
    }

    /// Tells whether a planner that asks for its pose and its wheels is told the truth.
    #[must_use]
    pub fn tells_the_truth(&self) -> bool {
        let data = &self.data;
        matches!(data.pose, Some(PoseModel::Exact)) && matches!(data.wheel_odometry, Some(WheelModel::Exact))
    }

    #[must_use]
    pub fn name(&self) -> &str {
        &self.data.name
    }

    #[must_use]
    pub fn data(&self) -> &ProfileData {
        &self.data
    }

    /// The SHA-256 of the file's bytes, as 64 hexadecimal digits in lower case.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}
