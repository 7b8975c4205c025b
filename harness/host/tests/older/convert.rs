//! Between the SDK's types and those of the bindings for version 0.0.
//!
//! Made by `cargo xtask abi`; edit the WIT instead.

use super::bindings::vertibench::planner::types;

impl From<&vb_sdk::Point2> for types::Point2 {
    fn from(v: &vb_sdk::Point2) -> Self {
        Self {
            x: v.x,
            y: v.y,
        }
    }
}

impl From<&vb_sdk::Vehicle> for types::Vehicle {
    fn from(v: &vb_sdk::Vehicle) -> Self {
        Self {
            name: v.name.clone(),
            mass: v.mass,
        }
    }
}

impl From<&vb_sdk::Task> for types::Task {
    fn from(v: &vb_sdk::Task) -> Self {
        Self {
            id: v.id.clone(),
            vehicle: (&v.vehicle).into(),
            path: v.path.iter().map(Into::into).collect(),
            goal_radius: v.goal_radius,
        }
    }
}

impl From<&vb_sdk::Observation> for types::Observation {
    fn from(v: &vb_sdk::Observation) -> Self {
        Self {
            time: v.time,
            last_steering: v.last_steering,
        }
    }
}

impl From<types::Command> for vb_sdk::Command {
    fn from(v: types::Command) -> Self {
        Self {
            steering: v.steering,
            throttle: v.throttle,
            brake: v.brake,
            ..Self::default()
        }
    }
}
