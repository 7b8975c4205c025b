//! Where sensors are on a vehicle, and which of their rays the vehicle itself is in the way of.

use crate::frame::{Frame, attitude, vec3};
use crate::profile::MountModel;
use crate::rays::Solid;
use crate::{Quat, V3};
use vb_math::angle::radians;
use vb_sdk::Mount;
use vb_vehicle::VehicleSpec;

/// What of a vehicle matters to its sensors.
#[derive(Clone, Debug)]
pub(crate) struct Bodywork {
    parts: Vec<Solid>,
    /// Height of the highest part of the hull in the body frame, m.
    top: f64,
    /// From where to where that part reaches along x, m.
    along: [f64; 2],
}

/// How far below the top a point may lie that is of the highest part, m.
const LEVEL: f64 = 1e-6;

impl Bodywork {
    pub(crate) fn of(spec: &VehicleSpec) -> Self {
        let points = || spec.chassis.hull.iter().flatten();
        let top = points().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
        let highest = points().filter(|p| p[2] >= top - LEVEL);
        let along = highest
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p[0]), high.max(p[0])]);
        let hull = |part: &Vec<[f64; 3]>| Solid::hull(&part.iter().map(|p| V3::from(*p)).collect::<Vec<_>>());
        let parts = spec.chassis.hull.iter().map(hull).collect();
        // A vehicle without a hull has its sensors as high as it is.
        if top.is_finite() {
            Self { parts, top, along }
        } else {
            Self { parts, top: spec.height, along: [0.0; 2] }
        }
    }

    /// Whether a ray in the body frame ends on the vehicle within `reach`, m.
    pub(crate) fn hides(&self, origin: &V3, direction: &V3, reach: f64) -> bool {
        self.parts.iter().any(|part| part.cast(origin, direction, reach).is_some())
    }

    /// The place of a sensor, with lengths of the full-size world scaled.
    pub(crate) fn mount(&self, model: &MountModel, scale: f64) -> Mount {
        let [rear, front] = self.along;
        let on_roof = |x: f64, above: f64, pitch_deg: f64| Mount {
            position: vec3(&V3::new(x, 0.0, self.top + above * scale)),
            roll: 0.0,
            pitch: radians(pitch_deg),
            yaw: 0.0,
        };
        match *model {
            MountModel::Roof { above_m, pitch_deg } => on_roof(0.5 * (rear + front), above_m, pitch_deg),
            MountModel::RoofFront { above_m, pitch_deg } => on_roof(front, above_m, pitch_deg),
            MountModel::At { position_m, roll_deg, pitch_deg, yaw_deg } => Mount {
                position: vec3(&(V3::from(position_m) * scale)),
                roll: radians(roll_deg),
                pitch: radians(pitch_deg),
                yaw: radians(yaw_deg),
            },
        }
    }
}

/// The place of a mount in the body frame.
pub(crate) fn frame(mount: &Mount) -> Frame {
    let p = mount.position;
    let turn: Quat = attitude(mount.roll, mount.pitch, mount.yaw);
    Frame { at: V3::new(p.x, p.y, p.z), turn }
}
