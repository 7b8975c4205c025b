//! What a driver does in an event, at whatever scale the vehicle is.

use vb_math::angle::wrap;
use vb_math::{atan2, hypot};
use vb_sim::{Controls, Gear, VehicleState};
use vb_vehicle::VehicleSpec;

pub(crate) fn controls(steering: f64, throttle: f64, brake: f64) -> Controls {
    Controls {
        steering: steering.clamp(-1.0, 1.0),
        throttle: throttle.clamp(0.0, 1.0),
        brake: brake.clamp(0.0, 1.0),
        gear: Gear::Forward,
    }
}

pub(crate) fn reverse(steering: f64, throttle: f64, brake: f64) -> Controls {
    Controls { gear: Gear::Reverse, ..controls(steering, throttle, brake) }
}

/// Brakes on, no throttle, wheels straight.
pub(crate) const PARKED: Controls = Controls { brake: 1.0, ..COASTING };
/// Nothing pressed, wheels straight.
pub(crate) const COASTING: Controls =
    Controls { steering: 0.0, throttle: 0.0, brake: 0.0, gear: Gear::Forward };

/// How the lengths, speeds and times of an event carry over to a vehicle of another scale: lengths with the scale, speeds
/// and times with its square root, by which gravity and so accelerations stay what they are (Froude's rule). Events are
/// written for a full-size vehicle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    scale: f64,
    root: f64,
    /// Top speed of the vehicle, m/s.
    top: f64,
}

impl Pace {
    pub(crate) fn new(spec: &VehicleSpec) -> Self {
        Self { scale: spec.scale, root: spec.scale.sqrt(), top: spec.max_speed }
    }

    pub(crate) fn length(self, full_size: f64) -> f64 {
        full_size * self.scale
    }

    pub(crate) fn speed(self, full_size: f64) -> f64 {
        full_size * self.root
    }

    pub(crate) fn time(self, full_size: f64) -> f64 {
        full_size * self.root
    }

    /// Whether the vehicle can drive at a full-size speed and have something left to control it with.
    pub(crate) fn reaches(self, full_size: f64) -> bool {
        self.speed(full_size) <= 0.9 * self.top
    }

    /// A full-size speed, or the one that the vehicle can hold if it is less.
    pub(crate) fn within_reach(self, full_size: f64) -> f64 {
        full_size.min(0.75 * self.top / self.root)
    }

    /// A full-size speed as this vehicle drives it, for labels.
    pub(crate) fn speed_label(self, full_size: f64) -> String {
        label(full_size, self.speed(full_size))
    }

    /// A full-size length as this vehicle meets it, for labels.
    pub(crate) fn length_label(self, full_size: f64) -> String {
        label(full_size, self.length(full_size))
    }

    /// The original's speed controller: the error of the speed (gain 1) is the throttle, or negative the brake
    /// (`compute_throttle` in its systems/PID/PID.py). The target is a full-size speed.
    pub(crate) fn hold_speed(self, s: &VehicleState, target: f64, steering: f64) -> Controls {
        let e = target - s.velocity_body.x / self.root;
        controls(steering, e, -e)
    }

    /// The same controller backwards, in reverse; the target is not negative.
    pub(crate) fn hold_speed_back(self, s: &VehicleState, target: f64, steering: f64) -> Controls {
        let e = target + s.velocity_body.x / self.root;
        reverse(steering, e, -e)
    }

    /// The pursuit law backwards along the line y = 0 to larger x, with the rear ahead: a vehicle that backs turns its rear to
    /// the side away from which its front wheels point.
    pub(crate) fn hold_line_back(self, s: &VehicleState) -> f64 {
        let (_, _, yaw) = s.roll_pitch_yaw();
        let rear = yaw + std::f64::consts::PI;
        -wrap(atan2(-s.position.y, self.length(10.0)) - rear).clamp(-1.0, 1.0)
    }

    /// The original's pursuit law along the line y = 0: the steering command is the angle (rad) to a point 10 m ahead.
    pub(crate) fn hold_line(self, s: &VehicleState) -> f64 {
        let (_, _, yaw) = s.roll_pitch_yaw();
        wrap(atan2(-s.position.y, self.length(10.0)) - yaw).clamp(-1.0, 1.0)
    }

    /// The same along the line x = 0, heading to larger y.
    pub(crate) fn hold_line_across(self, s: &VehicleState) -> f64 {
        let (_, _, yaw) = s.roll_pitch_yaw();
        wrap(atan2(self.length(10.0), -s.position.x) - yaw).clamp(-1.0, 1.0)
    }
}

fn label(full_size: f64, scaled: f64) -> String {
    if (scaled - scaled.round()).abs() < 1e-9 || scaled == full_size {
        format!("{scaled:.0}")
    } else {
        format!("{scaled:.2}")
    }
}

/// Speed over ground, m/s.
pub(crate) fn speed(s: &VehicleState) -> f64 {
    hypot(s.velocity_body.x, s.velocity_body.y)
}
