//! Between the SDK's types and those of the bindings for version 0.2.
//!
//! Made by `cargo xtask abi`; edit the WIT instead.

use super::bindings::vertibench::planner::types;

impl From<&vb_sdk::Vec3> for types::Vec3 {
    fn from(v: &vb_sdk::Vec3) -> Self {
        Self {
            x: v.x,
            y: v.y,
            z: v.z,
        }
    }
}

impl From<&vb_sdk::Point2> for types::Point2 {
    fn from(v: &vb_sdk::Point2) -> Self {
        Self {
            x: v.x,
            y: v.y,
        }
    }
}

impl From<&vb_sdk::Pose2> for types::Pose2 {
    fn from(v: &vb_sdk::Pose2) -> Self {
        Self {
            x: v.x,
            y: v.y,
            yaw: v.yaw,
        }
    }
}

impl From<&vb_sdk::Vehicle> for types::Vehicle {
    fn from(v: &vb_sdk::Vehicle) -> Self {
        Self {
            name: v.name.clone(),
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

impl From<&vb_sdk::GridFrame> for types::GridFrame {
    fn from(v: &vb_sdk::GridFrame) -> Self {
        Self {
            rows: v.rows,
            cols: v.cols,
            resolution: v.resolution,
            origin_x: v.origin_x,
            origin_y: v.origin_y,
        }
    }
}

impl From<&vb_sdk::HeightMap> for types::HeightMap {
    fn from(v: &vb_sdk::HeightMap) -> Self {
        Self {
            frame: (&v.frame).into(),
            data: v.data.clone(),
        }
    }
}

impl From<&vb_sdk::LabelMap> for types::LabelMap {
    fn from(v: &vb_sdk::LabelMap) -> Self {
        Self {
            frame: (&v.frame).into(),
            data: v.data.clone(),
        }
    }
}

impl From<&vb_sdk::Param> for types::Param {
    fn from(v: &vb_sdk::Param) -> Self {
        Self {
            key: v.key.clone(),
            value: v.value.clone(),
        }
    }
}

impl From<&vb_sdk::Mount> for types::Mount {
    fn from(v: &vb_sdk::Mount) -> Self {
        Self {
            position: (&v.position).into(),
            roll: v.roll,
            pitch: v.pitch,
            yaw: v.yaw,
        }
    }
}

impl From<&vb_sdk::LidarInfo> for types::LidarInfo {
    fn from(v: &vb_sdk::LidarInfo) -> Self {
        Self {
            period: v.period,
            rows: v.rows,
            cols: v.cols,
            lowest: v.lowest,
            highest: v.highest,
            min_range: v.min_range,
            max_range: v.max_range,
            mount: (&v.mount).into(),
        }
    }
}

impl From<&vb_sdk::DepthInfo> for types::DepthInfo {
    fn from(v: &vb_sdk::DepthInfo) -> Self {
        Self {
            period: v.period,
            rows: v.rows,
            cols: v.cols,
            field_of_view: v.field_of_view,
            min_depth: v.min_depth,
            max_depth: v.max_depth,
            labels: v.labels,
            mount: (&v.mount).into(),
        }
    }
}

impl From<&vb_sdk::Task> for types::Task {
    fn from(v: &vb_sdk::Task) -> Self {
        Self {
            id: v.id.clone(),
            vehicle: (&v.vehicle).into(),
            elevation: v.elevation.as_ref().map(Into::into),
            semantics: v.semantics.as_ref().map(Into::into),
            occupancy: v.occupancy.as_ref().map(Into::into),
            half_extent: (&v.half_extent).into(),
            path: v.path.iter().map(Into::into).collect(),
            start: (&v.start).into(),
            goal: (&v.goal).into(),
            goal_radius: v.goal_radius,
            time_limit: v.time_limit,
            control_period: v.control_period,
            seed: v.seed,
            params: v.params.iter().map(Into::into).collect(),
            perception: v.perception.clone(),
            lidar: v.lidar.as_ref().map(Into::into),
            depth: v.depth.as_ref().map(Into::into),
        }
    }
}

impl From<&vb_sdk::Pose> for types::Pose {
    fn from(v: &vb_sdk::Pose) -> Self {
        Self {
            position: (&v.position).into(),
            roll: v.roll,
            pitch: v.pitch,
            yaw: v.yaw,
            linear_velocity: (&v.linear_velocity).into(),
            angular_velocity: (&v.angular_velocity).into(),
        }
    }
}

impl From<&vb_sdk::Wheel> for types::Wheel {
    fn from(v: &vb_sdk::Wheel) -> Self {
        Self {
            spin: v.spin,
            travel: v.travel,
        }
    }
}

impl From<&vb_sdk::ImuSample> for types::ImuSample {
    fn from(v: &vb_sdk::ImuSample) -> Self {
        Self {
            time: v.time,
            specific_force: (&v.specific_force).into(),
            angular_velocity: (&v.angular_velocity).into(),
        }
    }
}

impl From<&vb_sdk::GnssFix> for types::GnssFix {
    fn from(v: &vb_sdk::GnssFix) -> Self {
        Self {
            time: v.time,
            position: (&v.position).into(),
        }
    }
}

impl From<&vb_sdk::LidarScan> for types::LidarScan {
    fn from(v: &vb_sdk::LidarScan) -> Self {
        Self {
            time: v.time,
            ranges: v.ranges.clone(),
        }
    }
}

impl From<&vb_sdk::DepthImage> for types::DepthImage {
    fn from(v: &vb_sdk::DepthImage) -> Self {
        Self {
            time: v.time,
            depths: v.depths.clone(),
            labels: v.labels.clone(),
        }
    }
}

impl From<&vb_sdk::LocalMap> for types::LocalMap {
    fn from(v: &vb_sdk::LocalMap) -> Self {
        Self {
            time: v.time,
            elevation: (&v.elevation).into(),
            semantics: (&v.semantics).into(),
            occupancy: (&v.occupancy).into(),
        }
    }
}

impl From<&vb_sdk::Observation> for types::Observation {
    fn from(v: &vb_sdk::Observation) -> Self {
        Self {
            time: v.time,
            pose: v.pose.as_ref().map(Into::into),
            wheels: v.wheels.iter().map(Into::into).collect(),
            imu: v.imu.iter().map(Into::into).collect(),
            gnss: v.gnss.as_ref().map(Into::into),
            lidar: v.lidar.as_ref().map(Into::into),
            depth: v.depth.as_ref().map(Into::into),
            local_map: v.local_map.as_ref().map(Into::into),
            gear: v.gear.into(),
            engine_speed: v.engine_speed,
            steering: v.steering,
            last_steering: v.last_steering,
            last_throttle: v.last_throttle,
            last_brake: v.last_brake,
        }
    }
}

impl From<vb_sdk::Gear> for types::Gear {
    fn from(v: vb_sdk::Gear) -> Self {
        match v {
            vb_sdk::Gear::Forward => Self::Forward,
            vb_sdk::Gear::Neutral => Self::Neutral,
            vb_sdk::Gear::Reverse => Self::Reverse,
        }
    }
}

impl From<types::Series> for vb_sdk::Series {
    fn from(v: types::Series) -> Self {
        Self {
            name: v.name,
            values: v.values,
        }
    }
}

impl From<types::Command> for vb_sdk::Command {
    fn from(v: types::Command) -> Self {
        Self {
            steering: v.steering,
            throttle: v.throttle,
            brake: v.brake,
            gear: v.gear.into(),
            debug: v.debug.into_iter().map(Into::into).collect(),
        }
    }
}

impl From<types::Gear> for vb_sdk::Gear {
    fn from(v: types::Gear) -> Self {
        match v {
            types::Gear::Forward => Self::Forward,
            types::Gear::Neutral => Self::Neutral,
            types::Gear::Reverse => Self::Reverse,
        }
    }
}
