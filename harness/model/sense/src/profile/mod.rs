//! Perception profiles: prior maps and sensors of a vehicle, as data.
//!
//! Lengths are those of the full-size world and are multiplied by a world's scale; docs/perception.md describes the
//! other values. A profile has only the sensors that it lists.

mod check;
mod confusion;

pub use confusion::{Confusions, Seen};
pub(crate) use confusion::{OBSTACLE, Recogniser, UNKNOWN};

use serde::Deserialize;
use std::path::Path;

use vb_files::{Document, DocumentError, Flaw, Schema};
use vb_sdk::metadata::{Metadata, Need};

/// A profile, and the hash of its file.
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
    /// A description in one line.
    pub description: String,
    /// The maps that planners receive at the start.
    pub prior: Prior,
    /// The estimate of the vehicle's state.
    pub pose: Option<PoseModel>,
    pub wheel_odometry: Option<WheelModel>,
    /// The inertial measurement unit (IMU).
    pub imu: Option<ImuModel>,
    /// The GNSS receiver.
    pub gnss: Option<GnssModel>,
    /// The lidar.
    pub lidar: Option<LidarModel>,
    /// The depth camera.
    pub depth: Option<DepthModel>,
    /// The local map of heights and terrain classes from lidar and camera.
    pub local_map: Option<LocalMapModel>,
}

/// The maps that planners receive at the start; an omitted one is unknown.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prior {
    pub elevation: Option<PriorElevation>,
    /// The terrain classes.
    pub semantics: Option<PriorSemantics>,
    /// The cells that obstacles cover.
    pub occupancy: Option<PriorOccupancy>,
}

/// The accuracy of the elevation map that planners receive at the start.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PriorElevation {
    Exact,
    /// As in remote sensing: means over squares, with spatially correlated errors.
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
    /// As in remote sensing: the most frequent class of each square, which may be misclassified.
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
    /// Dead reckoning from the start, which drifts with distance.
    Estimated(PoseNoise),
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseNoise {
    /// The random walk of the heading, rad/√m.
    pub heading_walk_rad_per_sqrt_m: f64,
    /// The random walk of the position along x and y each, m/√m.
    pub position_walk_m_per_sqrt_m: f64,
    /// The random walk of the height, m/√m.
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

/// Durations of two alternating states.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spells {
    /// The mean time from the end of one period to the start of the next, s.
    pub mean_interval_s: f64,
    /// The mean duration of a period, s.
    pub mean_duration_s: f64,
}

/// The measurements of the wheel encoders and the suspension travel sensors.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WheelModel {
    Exact,
    /// Encoders with finite resolution, and suspension travels with noise.
    Measured(WheelNoise),
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelNoise {
    /// The encoder's counts per wheel revolution.
    pub counts_per_turn: u32,
    /// The averaging time of the spin, s: a multiple of 10 ms.
    pub window_s: f64,
    /// The standard deviation of the suspension travel, m, independent every 10 ms.
    pub travel_std_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImuModel {
    /// The number of measurements per second.
    pub rate_hz: f64,
    /// The errors of the specific force along each axis, in m/s².
    pub accelerometer: Inertial,
    /// The errors of the angular velocity about each axis, in rad/s.
    pub gyroscope: Inertial,
}

/// The errors of an inertial sensor by the terms of IEEE Std 952-1997 (annex C), where u is m/s² for an accelerometer
/// and rad/s for a gyroscope. A value of 0 disables an error.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inertial {
    /// The white noise N, u·√s: the velocity random walk, m/s/√s, or the angle random walk, rad/√s.
    pub random_walk: f64,
    /// The minimum of the Allan deviation due to the bias, u; called in-run bias stability in data sheets.
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
    /// The number of positions per second.
    pub rate_hz: f64,
    /// The errors along x and y each.
    pub horizontal: GnssError,
    /// The error of the height.
    pub vertical: GnssError,
    /// Outages: periods without a position.
    pub outages: Option<Spells>,
}

/// The errors of a position along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GnssError {
    /// The standard deviation of the correlated component, a first-order Gauss–Markov process, m.
    pub std_m: f64,
    /// Its correlation time, s.
    pub correlation_s: f64,
    /// The standard deviation of the white component, m.
    pub white_std_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LidarModel {
    /// The number of revolutions per second.
    pub rate_hz: f64,
    /// The number of beams.
    pub rows: u32,
    /// The number of azimuths per revolution.
    pub cols: u32,
    /// The elevation of the lowest beam, degrees.
    pub lowest_deg: f64,
    /// The elevation of the highest beam, degrees.
    pub highest_deg: f64,
    /// The minimum range, m.
    pub min_range_m: f64,
    /// The maximum range, m.
    pub max_range_m: f64,
    /// The standard deviation of the range, m.
    pub range_std_m: f64,
    /// The dropout probability at short range.
    pub dropout_near: f64,
    /// The dropout probability at the maximum range; in between it grows with the range squared, as the returned light
    /// decreases.
    pub dropout_far: f64,
    /// Dust in the air; none if absent.
    pub dust: Option<Dust>,
    /// The mounting position and orientation of the lidar.
    pub mount: MountModel,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dust {
    pub spells: Spells,
    /// The extinction coefficient, 1/m.
    pub extinction_per_m: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthModel {
    /// The number of images per second.
    pub rate_hz: f64,
    /// The number of rows of an image.
    pub rows: u32,
    /// The number of columns of an image.
    pub cols: u32,
    /// The angle between the left and the right edge of an image, degrees.
    pub field_of_view_deg: f64,
    /// The minimum depth, m.
    pub min_depth_m: f64,
    /// The maximum depth, m.
    pub max_depth_m: f64,
    /// The standard deviation of a depth over the depth squared, 1/m.
    pub error_per_m: f64,
    /// The probability that a pixel has no depth.
    pub dropout: f64,
    /// Whether pixels have labels.
    pub labels: bool,
    #[serde(default)]
    pub confusions: Confusions,
    /// The mounting position and orientation of the camera.
    pub mount: MountModel,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MountModel {
    /// Above the middle of the highest part of the hull.
    Roof {
        /// The height above the hull, m.
        above_m: f64,
        /// The pitch, degrees, positive downward.
        pitch_deg: f64,
    },
    /// Above the front edge of the highest part of the hull.
    RoofFront {
        /// The height above the hull, m.
        above_m: f64,
        /// The pitch, degrees, positive downward.
        pitch_deg: f64,
    },
    /// At a position in the body frame.
    At {
        /// The position, m.
        position_m: [f64; 3],
        /// The roll, degrees.
        roll_deg: f64,
        /// The pitch, degrees, positive downward.
        pitch_deg: f64,
        /// The yaw, degrees, positive to the left.
        yaw_deg: f64,
    },
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalMapModel {
    /// The maximum number of maps per second.
    pub rate_hz: f64,
    /// The side of the map, m.
    pub side_m: f64,
    /// The side of its cells, m.
    pub resolution_m: f64,
    /// The maximum number of hits over which a cell averages; a later hit has the weight 1/`memory`.
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

    /// The profile without errors, used by ranked runs.
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

    /// Whether a planner receives maps of heights, of terrain classes and of obstacles.
    #[must_use]
    pub fn gives_all_maps(&self) -> bool {
        let prior = &self.data.prior;
        prior.elevation.is_some() && prior.semantics.is_some() && prior.occupancy.is_some()
    }

    /// Whether the maps that a planner receives are exact, and thus the same in every run.
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

    /// Whether pose and wheel readings are exact.
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
