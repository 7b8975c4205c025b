//! Planners as native libraries: a library whose root module `abi_stable` checks for its layout when it is loaded.
//!
//! Text and arrays cross as borrowed slices.

use abi_stable::StableAbi;
use abi_stable::library::RootModule;
use abi_stable::sabi_types::VersionStrings;
use abi_stable::std_types::{RResult, RSlice, RStr, RString, RVec};

use crate::{Command, GridFrame, Map, Observation, Param, Point2, Pose2, Series, Task, Vec3, Wheel};

/// The functions of a planner library.
#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = PlannerModuleRef)))]
pub struct PlannerModule {
    /// The metadata text; that it is named here keeps the linker from dropping its section.
    pub metadata: RSlice<'static, u8>,
    /// Makes a planner for a task. The pointer that it returns goes to `step` and `free`, which are called from one
    /// thread at a time.
    pub init: extern "C" fn(task: &NativeTask<'_>, log: LogCallback) -> RResult<*mut (), Fault>,
    /// Takes one step of a planner that `init` made. After a fault, no function but `free` may be called with that
    /// planner.
    pub step: unsafe extern "C" fn(
        planner: *mut (),
        observation: &NativeObservation<'_>,
        log: LogCallback,
    ) -> RResult<NativeCommand, Fault>,
    /// Frees a planner that `init` made.
    #[sabi(last_prefix_field)]
    pub free: unsafe extern "C" fn(planner: *mut ()),
}

impl RootModule for PlannerModuleRef {
    abi_stable::declare_root_module_statics! {PlannerModuleRef}
    const BASE_NAME: &'static str = "vb_planner";
    const NAME: &'static str = "vb_planner";
    const VERSION_STRINGS: VersionStrings = abi_stable::package_version_strings!();
}

impl std::fmt::Debug for PlannerModuleRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("PlannerModuleRef")
    }
}

/// The failure of a native planner.
#[repr(C)]
#[derive(Clone, Debug, PartialEq, Eq, StableAbi)]
pub struct Fault {
    /// Whether the planner panicked; otherwise it returned an error.
    pub panicked: bool,
    /// The planner's error text, or that of the panic.
    pub message: RString,
}

/// The function to which log lines go during a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
pub struct LogCallback {
    /// The first argument of `write`.
    pub context: *mut (),
    /// The function that takes a line: its arguments are the context, the level (0 error, 1 warn, 2 info, 3 debug) and
    /// the text.
    pub write: unsafe extern "C" fn(context: *mut (), level: u8, message: RStr<'_>),
}

/// A [`crate::Vehicle`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Vehicle`")]
pub struct NativeVehicle<'a> {
    pub name: RStr<'a>,
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
}

/// A [`Map`] of heights as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Map`")]
pub struct NativeHeights<'a> {
    pub frame: GridFrame,
    pub data: RSlice<'a, f32>,
}

/// A [`Map`] of labels as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Map`")]
pub struct NativeLabels<'a> {
    pub frame: GridFrame,
    pub data: RSlice<'a, u8>,
}

/// A [`Param`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Param`")]
pub struct NativeParam<'a> {
    pub key: RStr<'a>,
    pub value: RStr<'a>,
}

/// A [`Task`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Task`")]
pub struct NativeTask<'a> {
    pub id: RStr<'a>,
    pub vehicle: NativeVehicle<'a>,
    pub elevation: NativeHeights<'a>,
    pub semantics: NativeLabels<'a>,
    pub occupancy: NativeLabels<'a>,
    pub path: RSlice<'a, Point2>,
    pub start: Pose2,
    pub goal: Point2,
    pub goal_radius: f64,
    pub time_limit: f64,
    pub control_period: f64,
    pub seed: u64,
    pub params: RVec<NativeParam<'a>>,
}

/// An [`Observation`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Observation`")]
pub struct NativeObservation<'a> {
    pub time: f64,
    pub position: Vec3,
    pub roll: f64,
    pub pitch: f64,
    pub yaw: f64,
    pub linear_velocity: Vec3,
    pub angular_velocity: Vec3,
    pub wheels: RSlice<'a, Wheel>,
    pub last_steering: f64,
    pub last_throttle: f64,
    pub last_brake: f64,
}

/// A [`Series`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Series`")]
pub struct NativeSeries {
    pub name: RString,
    pub values: RVec<f32>,
}

/// A [`Command`] as it crosses the border of the library.
#[repr(C)]
#[derive(Clone, Debug, StableAbi)]
#[allow(missing_docs, reason = "the fields are those of `Command`")]
pub struct NativeCommand {
    pub steering: f64,
    pub throttle: f64,
    pub brake: f64,
    pub debug: RVec<NativeSeries>,
}

impl<'a> From<&'a Task> for NativeTask<'a> {
    fn from(t: &'a Task) -> Self {
        let v = &t.vehicle;
        let labels = |m: &'a Map<u8>| NativeLabels { frame: m.frame, data: RSlice::from_slice(&m.data) };
        let param =
            |p: &'a Param| NativeParam { key: RStr::from_str(&p.key), value: RStr::from_str(&p.value) };
        Self {
            id: RStr::from_str(&t.id),
            vehicle: NativeVehicle {
                name: RStr::from_str(&v.name),
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
            },
            elevation: NativeHeights {
                frame: t.elevation.frame,
                data: RSlice::from_slice(&t.elevation.data),
            },
            semantics: labels(&t.semantics),
            occupancy: labels(&t.occupancy),
            path: RSlice::from_slice(&t.path),
            start: t.start,
            goal: t.goal,
            goal_radius: t.goal_radius,
            time_limit: t.time_limit,
            control_period: t.control_period,
            seed: t.seed,
            params: t.params.iter().map(param).collect(),
        }
    }
}

impl<'a> From<&'a Observation> for NativeObservation<'a> {
    fn from(o: &'a Observation) -> Self {
        Self {
            time: o.time,
            position: o.position,
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: o.linear_velocity,
            angular_velocity: o.angular_velocity,
            wheels: RSlice::from_slice(&o.wheels),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        }
    }
}

impl From<NativeCommand> for Command {
    fn from(c: NativeCommand) -> Self {
        let debug = c.debug.into_iter().map(|s| Series { name: s.name.into(), values: s.values.into() });
        Self { steering: c.steering, throttle: c.throttle, brake: c.brake, debug: debug.collect() }
    }
}
