//! The structs of `sdk/c/vb_planner.h` as Rust lays them out, and the conversions between them and the SDK's types.
//!
//! Made by `cargo xtask abi`; edit the WIT instead.

#![allow(missing_docs, reason = "the fields are those of the SDK's types")]
#![allow(unused_variables, reason = "not every struct needs memory of its own")]

use std::ffi::c_char;
use std::ptr;

use abi_stable::StableAbi;

use super::memory::{Arena, slice, text};
use crate::types::*;

/// `vb_vec3`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CVec3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `vb_point2`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CPoint2 {
    pub x: f64,
    pub y: f64,
}

/// `vb_pose2`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CPose2 {
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
}

/// `vb_vehicle`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CVehicle {
    pub name: *const c_char,
    pub scale: f64,
    pub mass: f64,
    pub length: f64,
    pub width: f64,
    pub height: f64,
    pub wheelbase: f64,
    pub track: f64,
    pub wheel_radius: f64,
    pub wheels: u32,
    pub ground_clearance: f64,
    pub max_steer_angle: f64,
    pub max_steer_rate: f64,
    pub min_turn_radius: f64,
    pub max_speed: f64,
    pub max_reverse_speed: f64,
    pub direction_change_speed: f64,
    pub direction_change_time: f64,
}

/// `vb_grid_frame`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CGridFrame {
    pub rows: u32,
    pub cols: u32,
    pub resolution: f64,
    pub origin_x: f64,
    pub origin_y: f64,
}

/// `vb_height_map`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CHeightMap {
    pub frame: CGridFrame,
    pub data: *const f32,
    pub data_len: usize,
}

/// `vb_label_map`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CLabelMap {
    pub frame: CGridFrame,
    pub data: *const u8,
    pub data_len: usize,
}

/// `vb_param`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CParam {
    pub key: *const c_char,
    pub value: *const c_char,
}

/// `vb_mount`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CMount {
    pub position: CVec3,
    pub roll: f64,
    pub pitch: f64,
    pub yaw: f64,
}

/// `vb_lidar_info`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CLidarInfo {
    pub period: f64,
    pub rows: u32,
    pub cols: u32,
    pub lowest: f64,
    pub highest: f64,
    pub min_range: f64,
    pub max_range: f64,
    pub mount: CMount,
}

/// `vb_depth_info`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CDepthInfo {
    pub period: f64,
    pub rows: u32,
    pub cols: u32,
    pub field_of_view: f64,
    pub min_depth: f64,
    pub max_depth: f64,
    pub labels: u8,
    pub mount: CMount,
}

/// `vb_task`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CTask {
    pub id: *const c_char,
    pub vehicle: CVehicle,
    pub elevation: *const CHeightMap,
    pub semantics: *const CLabelMap,
    pub occupancy: *const CLabelMap,
    pub half_extent: CPoint2,
    pub path: *const CPoint2,
    pub path_len: usize,
    pub start: CPose2,
    pub goal: CPoint2,
    pub goal_radius: f64,
    pub time_limit: f64,
    pub control_period: f64,
    pub seed: u64,
    pub params: *const CParam,
    pub params_len: usize,
    pub perception: *const c_char,
    pub lidar: *const CLidarInfo,
    pub depth: *const CDepthInfo,
}

/// `vb_pose`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CPose {
    pub position: CVec3,
    pub roll: f64,
    pub pitch: f64,
    pub yaw: f64,
    pub linear_velocity: CVec3,
    pub angular_velocity: CVec3,
}

/// `vb_wheel`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CWheel {
    pub spin: f64,
    pub travel: f64,
}

/// `vb_imu_sample`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CImuSample {
    pub time: f64,
    pub specific_force: CVec3,
    pub angular_velocity: CVec3,
}

/// `vb_gnss_fix`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CGnssFix {
    pub time: f64,
    pub position: CVec3,
}

/// `vb_lidar_scan`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CLidarScan {
    pub time: f64,
    pub ranges: *const f32,
    pub ranges_len: usize,
}

/// `vb_depth_image`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CDepthImage {
    pub time: f64,
    pub depths: *const f32,
    pub depths_len: usize,
    pub labels: *const u8,
    pub labels_len: usize,
}

/// `vb_local_map`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CLocalMap {
    pub time: f64,
    pub elevation: CHeightMap,
    pub semantics: CLabelMap,
    pub occupancy: CLabelMap,
}

/// `vb_observation`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CObservation {
    pub time: f64,
    pub pose: *const CPose,
    pub wheels: *const CWheel,
    pub wheels_len: usize,
    pub imu: *const CImuSample,
    pub imu_len: usize,
    pub gnss: *const CGnssFix,
    pub lidar: *const CLidarScan,
    pub depth: *const CDepthImage,
    pub local_map: *const CLocalMap,
    pub gear: u32,
    pub engine_speed: f64,
    pub steering: f64,
    pub last_steering: f64,
    pub last_throttle: f64,
    pub last_brake: f64,
}

/// `vb_series`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CSeries {
    pub name: *const c_char,
    pub values: *const f32,
    pub values_len: usize,
}

/// `vb_command`.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct CCommand {
    pub steering: f64,
    pub throttle: f64,
    pub brake: f64,
    pub gear: u32,
    pub debug: *const CSeries,
    pub debug_len: usize,
}

#[doc(hidden)]
#[must_use]
pub fn lower_vec3(v: &Vec3, arena: &mut Arena) -> CVec3 {
    CVec3 {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_vec3(c: &CVec3) -> Result<Vec3, String> {
    Ok(Vec3 {
        x: c.x,
        y: c.y,
        z: c.z,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_point2(v: &Point2, arena: &mut Arena) -> CPoint2 {
    CPoint2 {
        x: v.x,
        y: v.y,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_point2(c: &CPoint2) -> Result<Point2, String> {
    Ok(Point2 {
        x: c.x,
        y: c.y,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_pose2(v: &Pose2, arena: &mut Arena) -> CPose2 {
    CPose2 {
        x: v.x,
        y: v.y,
        yaw: v.yaw,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_pose2(c: &CPose2) -> Result<Pose2, String> {
    Ok(Pose2 {
        x: c.x,
        y: c.y,
        yaw: c.yaw,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_vehicle(v: &Vehicle, arena: &mut Arena) -> CVehicle {
    CVehicle {
        name: arena.text(&v.name),
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

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_vehicle(c: &CVehicle) -> Result<Vehicle, String> {
    Ok(Vehicle {
        // SAFETY: by this function's own condition.
        name: unsafe { text(c.name) },
        scale: c.scale,
        mass: c.mass,
        length: c.length,
        width: c.width,
        height: c.height,
        wheelbase: c.wheelbase,
        track: c.track,
        wheel_radius: c.wheel_radius,
        wheels: c.wheels,
        ground_clearance: c.ground_clearance,
        max_steer_angle: c.max_steer_angle,
        max_steer_rate: c.max_steer_rate,
        min_turn_radius: c.min_turn_radius,
        max_speed: c.max_speed,
        max_reverse_speed: c.max_reverse_speed,
        direction_change_speed: c.direction_change_speed,
        direction_change_time: c.direction_change_time,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_grid_frame(v: &GridFrame, arena: &mut Arena) -> CGridFrame {
    CGridFrame {
        rows: v.rows,
        cols: v.cols,
        resolution: v.resolution,
        origin_x: v.origin_x,
        origin_y: v.origin_y,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_grid_frame(c: &CGridFrame) -> Result<GridFrame, String> {
    Ok(GridFrame {
        rows: c.rows,
        cols: c.cols,
        resolution: c.resolution,
        origin_x: c.origin_x,
        origin_y: c.origin_y,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_height_map(v: &HeightMap, arena: &mut Arena) -> CHeightMap {
    CHeightMap {
        frame: lower_grid_frame(&v.frame, arena),
        data: v.data.as_ptr(),
        data_len: v.data.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_height_map(c: &CHeightMap) -> Result<HeightMap, String> {
    Ok(HeightMap {
        // SAFETY: by this function's own condition.
        frame: unsafe { lift_grid_frame(&c.frame) }?,
        // SAFETY: by this function's own condition.
        data: unsafe { slice(c.data, c.data_len) }.to_vec(),
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_label_map(v: &LabelMap, arena: &mut Arena) -> CLabelMap {
    CLabelMap {
        frame: lower_grid_frame(&v.frame, arena),
        data: v.data.as_ptr(),
        data_len: v.data.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_label_map(c: &CLabelMap) -> Result<LabelMap, String> {
    Ok(LabelMap {
        // SAFETY: by this function's own condition.
        frame: unsafe { lift_grid_frame(&c.frame) }?,
        // SAFETY: by this function's own condition.
        data: unsafe { slice(c.data, c.data_len) }.to_vec(),
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_param(v: &Param, arena: &mut Arena) -> CParam {
    CParam {
        key: arena.text(&v.key),
        value: arena.text(&v.value),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_param(c: &CParam) -> Result<Param, String> {
    Ok(Param {
        // SAFETY: by this function's own condition.
        key: unsafe { text(c.key) },
        // SAFETY: by this function's own condition.
        value: unsafe { text(c.value) },
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_mount(v: &Mount, arena: &mut Arena) -> CMount {
    CMount {
        position: lower_vec3(&v.position, arena),
        roll: v.roll,
        pitch: v.pitch,
        yaw: v.yaw,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_mount(c: &CMount) -> Result<Mount, String> {
    Ok(Mount {
        // SAFETY: by this function's own condition.
        position: unsafe { lift_vec3(&c.position) }?,
        roll: c.roll,
        pitch: c.pitch,
        yaw: c.yaw,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_lidar_info(v: &LidarInfo, arena: &mut Arena) -> CLidarInfo {
    CLidarInfo {
        period: v.period,
        rows: v.rows,
        cols: v.cols,
        lowest: v.lowest,
        highest: v.highest,
        min_range: v.min_range,
        max_range: v.max_range,
        mount: lower_mount(&v.mount, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_lidar_info(c: &CLidarInfo) -> Result<LidarInfo, String> {
    Ok(LidarInfo {
        period: c.period,
        rows: c.rows,
        cols: c.cols,
        lowest: c.lowest,
        highest: c.highest,
        min_range: c.min_range,
        max_range: c.max_range,
        // SAFETY: by this function's own condition.
        mount: unsafe { lift_mount(&c.mount) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_depth_info(v: &DepthInfo, arena: &mut Arena) -> CDepthInfo {
    CDepthInfo {
        period: v.period,
        rows: v.rows,
        cols: v.cols,
        field_of_view: v.field_of_view,
        min_depth: v.min_depth,
        max_depth: v.max_depth,
        labels: u8::from(v.labels),
        mount: lower_mount(&v.mount, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_depth_info(c: &CDepthInfo) -> Result<DepthInfo, String> {
    Ok(DepthInfo {
        period: c.period,
        rows: c.rows,
        cols: c.cols,
        field_of_view: c.field_of_view,
        min_depth: c.min_depth,
        max_depth: c.max_depth,
        labels: c.labels != 0,
        // SAFETY: by this function's own condition.
        mount: unsafe { lift_mount(&c.mount) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_task(v: &Task, arena: &mut Arena) -> CTask {
    CTask {
        id: arena.text(&v.id),
        vehicle: lower_vehicle(&v.vehicle, arena),
        elevation: match &v.elevation {
            Some(x) => {
                let x = lower_height_map(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        semantics: match &v.semantics {
            Some(x) => {
                let x = lower_label_map(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        occupancy: match &v.occupancy {
            Some(x) => {
                let x = lower_label_map(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        half_extent: lower_point2(&v.half_extent, arena),
        path: {
            let list = v.path.iter().map(|x| lower_point2(x, arena)).collect();
            arena.list(list)
        },
        path_len: v.path.len(),
        start: lower_pose2(&v.start, arena),
        goal: lower_point2(&v.goal, arena),
        goal_radius: v.goal_radius,
        time_limit: v.time_limit,
        control_period: v.control_period,
        seed: v.seed,
        params: {
            let list = v.params.iter().map(|x| lower_param(x, arena)).collect();
            arena.list(list)
        },
        params_len: v.params.len(),
        perception: arena.text(&v.perception),
        lidar: match &v.lidar {
            Some(x) => {
                let x = lower_lidar_info(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        depth: match &v.depth {
            Some(x) => {
                let x = lower_depth_info(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_task(c: &CTask) -> Result<Task, String> {
    Ok(Task {
        // SAFETY: by this function's own condition.
        id: unsafe { text(c.id) },
        // SAFETY: by this function's own condition.
        vehicle: unsafe { lift_vehicle(&c.vehicle) }?,
        // SAFETY: by this function's own condition.
        elevation: unsafe { c.elevation.as_ref().map(|x| lift_height_map(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        semantics: unsafe { c.semantics.as_ref().map(|x| lift_label_map(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        occupancy: unsafe { c.occupancy.as_ref().map(|x| lift_label_map(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        half_extent: unsafe { lift_point2(&c.half_extent) }?,
        // SAFETY: by this function's own condition.
        path: unsafe { slice(c.path, c.path_len).iter().map(|x| lift_point2(x)).collect::<Result<_, _>>() }?,
        // SAFETY: by this function's own condition.
        start: unsafe { lift_pose2(&c.start) }?,
        // SAFETY: by this function's own condition.
        goal: unsafe { lift_point2(&c.goal) }?,
        goal_radius: c.goal_radius,
        time_limit: c.time_limit,
        control_period: c.control_period,
        seed: c.seed,
        // SAFETY: by this function's own condition.
        params: unsafe { slice(c.params, c.params_len).iter().map(|x| lift_param(x)).collect::<Result<_, _>>() }?,
        // SAFETY: by this function's own condition.
        perception: unsafe { text(c.perception) },
        // SAFETY: by this function's own condition.
        lidar: unsafe { c.lidar.as_ref().map(|x| lift_lidar_info(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        depth: unsafe { c.depth.as_ref().map(|x| lift_depth_info(x)) }.transpose()?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_pose(v: &Pose, arena: &mut Arena) -> CPose {
    CPose {
        position: lower_vec3(&v.position, arena),
        roll: v.roll,
        pitch: v.pitch,
        yaw: v.yaw,
        linear_velocity: lower_vec3(&v.linear_velocity, arena),
        angular_velocity: lower_vec3(&v.angular_velocity, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_pose(c: &CPose) -> Result<Pose, String> {
    Ok(Pose {
        // SAFETY: by this function's own condition.
        position: unsafe { lift_vec3(&c.position) }?,
        roll: c.roll,
        pitch: c.pitch,
        yaw: c.yaw,
        // SAFETY: by this function's own condition.
        linear_velocity: unsafe { lift_vec3(&c.linear_velocity) }?,
        // SAFETY: by this function's own condition.
        angular_velocity: unsafe { lift_vec3(&c.angular_velocity) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_wheel(v: &Wheel, arena: &mut Arena) -> CWheel {
    CWheel {
        spin: v.spin,
        travel: v.travel,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_wheel(c: &CWheel) -> Result<Wheel, String> {
    Ok(Wheel {
        spin: c.spin,
        travel: c.travel,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_imu_sample(v: &ImuSample, arena: &mut Arena) -> CImuSample {
    CImuSample {
        time: v.time,
        specific_force: lower_vec3(&v.specific_force, arena),
        angular_velocity: lower_vec3(&v.angular_velocity, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_imu_sample(c: &CImuSample) -> Result<ImuSample, String> {
    Ok(ImuSample {
        time: c.time,
        // SAFETY: by this function's own condition.
        specific_force: unsafe { lift_vec3(&c.specific_force) }?,
        // SAFETY: by this function's own condition.
        angular_velocity: unsafe { lift_vec3(&c.angular_velocity) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_gnss_fix(v: &GnssFix, arena: &mut Arena) -> CGnssFix {
    CGnssFix {
        time: v.time,
        position: lower_vec3(&v.position, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_gnss_fix(c: &CGnssFix) -> Result<GnssFix, String> {
    Ok(GnssFix {
        time: c.time,
        // SAFETY: by this function's own condition.
        position: unsafe { lift_vec3(&c.position) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_lidar_scan(v: &LidarScan, arena: &mut Arena) -> CLidarScan {
    CLidarScan {
        time: v.time,
        ranges: v.ranges.as_ptr(),
        ranges_len: v.ranges.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_lidar_scan(c: &CLidarScan) -> Result<LidarScan, String> {
    Ok(LidarScan {
        time: c.time,
        // SAFETY: by this function's own condition.
        ranges: unsafe { slice(c.ranges, c.ranges_len) }.to_vec(),
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_depth_image(v: &DepthImage, arena: &mut Arena) -> CDepthImage {
    CDepthImage {
        time: v.time,
        depths: v.depths.as_ptr(),
        depths_len: v.depths.len(),
        labels: v.labels.as_ptr(),
        labels_len: v.labels.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_depth_image(c: &CDepthImage) -> Result<DepthImage, String> {
    Ok(DepthImage {
        time: c.time,
        // SAFETY: by this function's own condition.
        depths: unsafe { slice(c.depths, c.depths_len) }.to_vec(),
        // SAFETY: by this function's own condition.
        labels: unsafe { slice(c.labels, c.labels_len) }.to_vec(),
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_local_map(v: &LocalMap, arena: &mut Arena) -> CLocalMap {
    CLocalMap {
        time: v.time,
        elevation: lower_height_map(&v.elevation, arena),
        semantics: lower_label_map(&v.semantics, arena),
        occupancy: lower_label_map(&v.occupancy, arena),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_local_map(c: &CLocalMap) -> Result<LocalMap, String> {
    Ok(LocalMap {
        time: c.time,
        // SAFETY: by this function's own condition.
        elevation: unsafe { lift_height_map(&c.elevation) }?,
        // SAFETY: by this function's own condition.
        semantics: unsafe { lift_label_map(&c.semantics) }?,
        // SAFETY: by this function's own condition.
        occupancy: unsafe { lift_label_map(&c.occupancy) }?,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_observation(v: &Observation, arena: &mut Arena) -> CObservation {
    CObservation {
        time: v.time,
        pose: match &v.pose {
            Some(x) => {
                let x = lower_pose(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        wheels: {
            let list = v.wheels.iter().map(|x| lower_wheel(x, arena)).collect();
            arena.list(list)
        },
        wheels_len: v.wheels.len(),
        imu: {
            let list = v.imu.iter().map(|x| lower_imu_sample(x, arena)).collect();
            arena.list(list)
        },
        imu_len: v.imu.len(),
        gnss: match &v.gnss {
            Some(x) => {
                let x = lower_gnss_fix(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        lidar: match &v.lidar {
            Some(x) => {
                let x = lower_lidar_scan(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        depth: match &v.depth {
            Some(x) => {
                let x = lower_depth_image(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        local_map: match &v.local_map {
            Some(x) => {
                let x = lower_local_map(x, arena);
                arena.one(x)
            }
            None => ptr::null(),
        },
        gear: v.gear as u32,
        engine_speed: v.engine_speed,
        steering: v.steering,
        last_steering: v.last_steering,
        last_throttle: v.last_throttle,
        last_brake: v.last_brake,
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_observation(c: &CObservation) -> Result<Observation, String> {
    Ok(Observation {
        time: c.time,
        // SAFETY: by this function's own condition.
        pose: unsafe { c.pose.as_ref().map(|x| lift_pose(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        wheels: unsafe { slice(c.wheels, c.wheels_len).iter().map(|x| lift_wheel(x)).collect::<Result<_, _>>() }?,
        // SAFETY: by this function's own condition.
        imu: unsafe { slice(c.imu, c.imu_len).iter().map(|x| lift_imu_sample(x)).collect::<Result<_, _>>() }?,
        // SAFETY: by this function's own condition.
        gnss: unsafe { c.gnss.as_ref().map(|x| lift_gnss_fix(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        lidar: unsafe { c.lidar.as_ref().map(|x| lift_lidar_scan(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        depth: unsafe { c.depth.as_ref().map(|x| lift_depth_image(x)) }.transpose()?,
        // SAFETY: by this function's own condition.
        local_map: unsafe { c.local_map.as_ref().map(|x| lift_local_map(x)) }.transpose()?,
        gear: lift_gear(c.gear)?,
        engine_speed: c.engine_speed,
        steering: c.steering,
        last_steering: c.last_steering,
        last_throttle: c.last_throttle,
        last_brake: c.last_brake,
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_series(v: &Series, arena: &mut Arena) -> CSeries {
    CSeries {
        name: arena.text(&v.name),
        values: v.values.as_ptr(),
        values_len: v.values.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_series(c: &CSeries) -> Result<Series, String> {
    Ok(Series {
        // SAFETY: by this function's own condition.
        name: unsafe { text(c.name) },
        // SAFETY: by this function's own condition.
        values: unsafe { slice(c.values, c.values_len) }.to_vec(),
    })
}

#[doc(hidden)]
#[must_use]
pub fn lower_command(v: &Command, arena: &mut Arena) -> CCommand {
    CCommand {
        steering: v.steering,
        throttle: v.throttle,
        brake: v.brake,
        gear: v.gear as u32,
        debug: {
            let list = v.debug.iter().map(|x| lower_series(x, arena)).collect();
            arena.list(list)
        },
        debug_len: v.debug.len(),
    }
}

/// # Safety
/// All pointers lead to what the header says, or are null.
///
/// # Errors
/// If an enum has none of its values.
#[doc(hidden)]
pub unsafe fn lift_command(c: &CCommand) -> Result<Command, String> {
    Ok(Command {
        steering: c.steering,
        throttle: c.throttle,
        brake: c.brake,
        gear: lift_gear(c.gear)?,
        // SAFETY: by this function's own condition.
        debug: unsafe { slice(c.debug, c.debug_len).iter().map(|x| lift_series(x)).collect::<Result<_, _>>() }?,
    })
}

/// # Errors
/// If the number stands for nothing.
#[doc(hidden)]
pub fn lift_gear(value: u32) -> Result<Gear, String> {
    match value {
        0 => Ok(Gear::Forward),
        1 => Ok(Gear::Neutral),
        2 => Ok(Gear::Reverse),
        other => Err(format!("gear is {other}; want forward (0), neutral (1) or reverse (2)")),
    }
}
