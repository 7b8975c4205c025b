//! One row of a trajectory.

/// The state of the vehicle at one instant: its position in the world frame, its velocities and rates in body axes (x
/// forward, y left, z up). Units are SI, angles in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The simulated time since the start, s.
    pub time: f64,
    /// The position of the vehicle's reference point towards the east, m.
    pub x: f64,
    /// The position of the reference point towards the north, m.
    pub y: f64,
    /// The height of the reference point, m.
    pub z: f64,
    /// The roll, rad, positive with the right side down.
    pub roll: f64,
    /// The pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// The heading, rad, counter-clockwise from east.
    pub yaw: f64,
    /// The forward velocity of the reference point, m/s.
    pub vx: f64,
    /// The leftward velocity of the reference point, m/s.
    pub vy: f64,
    /// The velocity of the reference point along the body's upward axis, m/s.
    pub vz: f64,
    /// The rate of rotation about the body's forward axis, rad/s.
    pub wx: f64,
    /// The rate of rotation about the body's leftward axis, rad/s.
    pub wy: f64,
    /// The rate of rotation about the body's upward axis, rad/s.
    pub wz: f64,
    /// The steering command applied up to this instant, after clamping, in [-1, 1], positive to the left.
    pub steering: f64,
    /// The throttle command applied up to this instant, after clamping, in [0, 1].
    pub throttle: f64,
    /// The brake command applied up to this instant, after clamping, in [0, 1].
    pub brake: f64,
    /// The gear command applied up to this instant: 0 forward, 1 neutral, 2 reverse.
    pub gear: f64,
}

impl Sample {
    /// The names of the fields, in the order of [`Sample::to_array`], which are the columns of a trace file.
    pub const FIELDS: [&str; 17] = [
        "time", "x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "wx", "wy", "wz", "steering",
        "throttle", "brake", "gear",
    ];
    /// The value of `gear` under a command for neutral.
    pub const NEUTRAL: f64 = 1.0;
    /// The value of `gear` under a command for the reverse gear.
    pub const REVERSE: f64 = 2.0;

    /// The fields as an array, in the order of [`Sample::FIELDS`].
    #[must_use]
    pub fn to_array(&self) -> [f64; 17] {
        let Self { time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, .. } = *self;
        let Self { steering, throttle, brake, gear, .. } = *self;
        [time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake, gear]
    }

    /// The sample with these fields, in the order of [`Sample::FIELDS`].
    #[must_use]
    pub fn from_array(fields: [f64; 17]) -> Self {
        let [time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake, gear] =
            fields;
        Self { time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake, gear }
    }

    /// Tells whether every field is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|v| v.is_finite())
    }
}

/// One wheel at the instant of a [`Sample`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSample {
    /// The spin, rad/s, positive when rolling forward.
    pub speed: f64,
    /// The suspension travel from the design position, m, positive in compression.
    pub deflection: f64,
}
