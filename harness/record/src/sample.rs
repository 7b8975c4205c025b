//! One row of a trajectory.

/// The state of the vehicle at one instant. World frame for the position, body axes (x forward, y left, z up) for
/// velocities and rates; SI units, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Simulated time since the start, s.
    pub time: f64,
    /// Position of the vehicle's reference point, east, m.
    pub x: f64,
    /// North, m.
    pub y: f64,
    /// Up, m.
    pub z: f64,
    /// Roll, rad, positive with the right side down.
    pub roll: f64,
    /// Pitch, rad, positive with the nose down.
    pub pitch: f64,
    /// Heading, rad, counter-clockwise from east.
    pub yaw: f64,
    /// Forward velocity, m/s.
    pub vx: f64,
    /// Leftward velocity, m/s.
    pub vy: f64,
    /// Upward (body) velocity, m/s.
    pub vz: f64,
    /// Rate about the forward axis, rad/s.
    pub wx: f64,
    /// Rate about the leftward axis, rad/s.
    pub wy: f64,
    /// Rate about the upward (body) axis, rad/s.
    pub wz: f64,
    /// Steering command applied up to this instant, after clamping, in [-1, 1], positive to the left.
    pub steering: f64,
    /// Throttle command applied up to this instant, after clamping, in [0, 1].
    pub throttle: f64,
    /// Brake command applied up to this instant, after clamping, in [0, 1].
    pub brake: f64,
}

impl Sample {
    /// Names of the fields, in the order of [`Sample::to_array`]; the columns of a trace file.
    pub const FIELDS: [&str; 16] = [
        "time", "x", "y", "z", "roll", "pitch", "yaw", "vx", "vy", "vz", "wx", "wy", "wz", "steering",
        "throttle", "brake",
    ];

    /// The fields as an array, in the order of [`Sample::FIELDS`].
    #[must_use]
    pub fn to_array(&self) -> [f64; 16] {
        let Self { time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake } =
            *self;
        [time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake]
    }

    /// The sample with these fields, in the order of [`Sample::FIELDS`].
    #[must_use]
    pub fn from_array(fields: [f64; 16]) -> Self {
        let [time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake] = fields;
        Self { time, x, y, z, roll, pitch, yaw, vx, vy, vz, wx, wy, wz, steering, throttle, brake }
    }

    /// Whether every field is a finite number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.to_array().iter().all(|v| v.is_finite())
    }
}

/// One wheel at the instant of a [`Sample`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSample {
    /// Spin, rad/s, positive when rolling forward.
    pub speed: f64,
    /// Suspension travel from the design position, m, positive in compression.
    pub deflection: f64,
}
