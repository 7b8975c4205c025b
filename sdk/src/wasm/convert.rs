//! Between the SDK's types and those of the component's bindings.
//!
//! Made by `cargo xtask abi`; edit the WIT instead.

use super::bindings::vertibench::planner::types;
use crate::types::*;

impl From<types::Vec3> for Vec3 {
    fn from(v: types::Vec3) -> Self {
        Self {
            x: v.x,
            y: v.y,
            z: v.z,
        }
    }
}

impl From<types::Point2> for Point2 {
    fn from(v: types::Point2) -> Self {
        Self {
            x: v.x,
            y: v.y,
        }
    }
}

impl From<types::Pose2> for Pose2 {
    fn from(v: types::Pose2) -> Self {
        Self {
            x: v.x,
            y: v.y,
            yaw: v.yaw,
        }
    }
}

impl From<types::Vehicle> for Vehicle {
    fn from(v: types::Vehicle) -> Self {
        Self {
            name: v.name,
            scale: v.scale,
            mass: v.mass,
            length: v.length,
            width: v.width,
            height: v.height,
            wheelbase: v.wheelbase,
            track: v.track,
            wheel_radius: v.wheel_radius,
            wheels: v.wheels,
            ground_clearance: v.ground_clearance,
            max_steer_angle: v.max_steer_angle,
            max_steer_rate: v.max_steer_rate,
            min_turn_radius: v.min_turn_radius,
            max_speed: v.max_speed,
            max_reverse_speed: v.max_reverse_speed,
            direction_change_speed: v.direction_change_speed,
            direction_change_time: v.direction_change_time,
        }
    }
}

impl From<types::GridFrame> for GridFrame {
    fn from(v: types::GridFrame) -> Self {
        Self {
            rows: v.rows,
            cols: v.cols,
            resolution: v.resolution,
            origin_x: v.origin_x,
            origin_y: v.origin_y,
        }
    }
}

impl From<types::HeightMap> for HeightMap {
    fn from(v: types::HeightMap) -> Self {
        Self {
            frame: v.frame.into(),
            data: v.data,
        }
    }
}

impl From<types::LabelMap> for LabelMap {
    fn from(v: types::LabelMap) -> Self {
        Self {
            frame: v.frame.into(),
            data: v.data,
        }
    }
}

impl From<types::Param> for Param {
    fn from(v: types::Param) -> Self {
        Self {
            key: v.key,
            value: v.value,
        }
    }
}

impl From<types::Mount> for Mount {
    fn from(v: types::Mount) -> Self {
        Self {
            position: v.position.into(),
            roll: v.roll,
            pitch: v.pitch,
            yaw: v.yaw,
        }
    }
}

impl From<types::LidarInfo> for LidarInfo {
    fn from(v: types::LidarInfo) -> Self {
        Self {
            period: v.period,
            rows: v.rows,
            cols: v.cols,
            lowest: v.lowest,
            highest: v.highest,
            min_range: v.min_range,
            max_range: v.max_range,
            mount: v.mount.into(),
        }
    }
}

impl From<types::DepthInfo> for DepthInfo {
    fn from(v: types::DepthInfo) -> Self {
        Self {
            period: v.period,
            rows: v.rows,
            cols: v.cols,
            field_of_view: v.field_of_view,
            min_depth: v.min_depth,
            max_depth: v.max_depth,
            labels: v.labels,
            mount: v.mount.into(),
        }
    }
}

impl From<types::Task> for Task {
    fn from(v: types::Task) -> Self {
        Self {
            id: v.id,
            vehicle: v.vehicle.into(),
            elevation: v.elevation.map(Into::into),
            semantics: v.semantics.map(Into::into),
            occupancy: v.occupancy.map(Into::into),
            half_extent: v.half_extent.into(),
            path: v.path.into_iter().map(Into::into).collect(),
            start: v.start.into(),
            goal: v.goal.into(),
            goal_radius: v.goal_radius,
            time_limit: v.time_limit,
            control_period: v.control_period,
            seed: v.seed,
            params: v.params.into_iter().map(Into::into).collect(),
            perception: v.perception,
            lidar: v.lidar.map(Into::into),
            depth: v.depth.map(Into::into),
        }
    }
}

impl From<types::Pose> for Pose {
    fn from(v: types::Pose) -> Self {
        Self {
            position: v.position.into(),
            roll: v.roll,
            pitch: v.pitch,
            yaw: v.yaw,
            linear_velocity: v.linear_velocity.into(),
            angular_velocity: v.angular_velocity.into(),
        }
    }
}

impl From<types::Wheel> for Wheel {
    fn from(v: types::Wheel) -> Self {
        Self {
            spin: v.spin,
            travel: v.travel,
        }
    }
}

impl From<types::ImuSample> for ImuSample {
    fn from(v: types::ImuSample) -> Self {
        Self {
            time: v.time,
            specific_force: v.specific_force.into(),
            angular_velocity: v.angular_velocity.into(),
        }
    }
}

impl From<types::GnssFix> for GnssFix {
    fn from(v: types::GnssFix) -> Self {
        Self {
            time: v.time,
            position: v.position.into(),
        }
    }
}

impl From<types::LidarScan> for LidarScan {
    fn from(v: types::LidarScan) -> Self {
        Self {
            time: v.time,
            ranges: v.ranges,
        }
    }
}

impl From<types::DepthImage> for DepthImage {
    fn from(v: types::DepthImage) -> Self {
        Self {
            time: v.time,
            depths: v.depths,
            labels: v.labels,
        }
    }
}

impl From<types::LocalMap> for LocalMap {
    fn from(v: types::LocalMap) -> Self {
        Self {
            time: v.time,
            elevation: v.elevation.into(),
            semantics: v.semantics.into(),
            occupancy: v.occupancy.into(),
        }
    }
}

impl From<types::Observation> for Observation {
    fn from(v: types::Observation) -> Self {
        Self {
            time: v.time,
            pose: v.pose.map(Into::into),
            wheels: v.wheels.into_iter().map(Into::into).collect(),
            imu: v.imu.into_iter().map(Into::into).collect(),
            gnss: v.gnss.map(Into::into),
            lidar: v.lidar.map(Into::into),
            depth: v.depth.map(Into::into),
            local_map: v.local_map.map(Into::into),
            gear: v.gear.into(),
            engine_speed: v.engine_speed,
            steering: v.steering,
            last_steering: v.last_steering,
            last_throttle: v.last_throttle,
            last_brake: v.last_brake,
        }
    }
}

impl From<types::Gear> for Gear {
    fn from(v: types::Gear) -> Self {
        match v {
            types::Gear::Forward => Self::Forward,
            types::Gear::Neutral => Self::Neutral,
            types::Gear::Reverse => Self::Reverse,
        }
    }
}

impl From<Series> for types::Series {
    fn from(v: Series) -> Self {
        Self {
            name: v.name,
            values: v.values,
        }
    }
}

impl From<Command> for types::Command {
    fn from(v: Command) -> Self {
        Self {
            steering: v.steering,
            throttle: v.throttle,
            brake: v.brake,
            gear: v.gear.into(),
            debug: v.debug.into_iter().map(Into::into).collect(),
        }
    }
}

impl From<Gear> for types::Gear {
    fn from(v: Gear) -> Self {
        match v {
            Gear::Forward => Self::Forward,
            Gear::Neutral => Self::Neutral,
            Gear::Reverse => Self::Reverse,
        }
    }
}
