//! The structs of version 0.1's `vb_planner.h` as Rust lays them out, and calls through them.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

use vb_abi_v0_1::{Command, GridFrame, Map, Observation, Point2, Pose2, Series, Task, Vec3, Wheel};

use crate::library::{Log, level_of};

/// `VB_ABI_MAJOR` and `VB_ABI_MINOR`.
const ABI: (u32, u32) = (0, 1);
/// `VB_ERROR_BYTES`.
const ERROR_BYTES: usize = 1024;

/// `vb_heights`.
#[repr(C)]
pub(crate) struct CHeights {
    pub(crate) frame: GridFrame,
    pub(crate) data: *const f32,
}

/// `vb_labels`.
#[repr(C)]
pub(crate) struct CLabels {
    pub(crate) frame: GridFrame,
    pub(crate) data: *const u8,
}

/// `vb_param`.
#[repr(C)]
pub(crate) struct CParam {
    pub(crate) key: *const c_char,
    pub(crate) value: *const c_char,
}

/// `vb_vehicle`.
#[repr(C)]
pub(crate) struct CVehicle {
    pub(crate) size: usize,
    pub(crate) name: *const c_char,
    pub(crate) scale: f64,
    pub(crate) mass: f64,
    pub(crate) length: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) wheelbase: f64,
    pub(crate) track: f64,
    pub(crate) wheel_radius: f64,
    pub(crate) wheels: u32,
    pub(crate) ground_clearance: f64,
    pub(crate) max_steer_angle: f64,
    pub(crate) max_steer_rate: f64,
    pub(crate) min_turn_radius: f64,
    pub(crate) max_speed: f64,
}

/// `vb_task`.
#[repr(C)]
pub(crate) struct CTask {
    pub(crate) size: usize,
    pub(crate) id: *const c_char,
    pub(crate) vehicle: *const CVehicle,
    pub(crate) elevation: CHeights,
    pub(crate) semantics: CLabels,
    pub(crate) occupancy: CLabels,
    pub(crate) path: *const Point2,
    pub(crate) path_len: usize,
    pub(crate) start: Pose2,
    pub(crate) goal: Point2,
    pub(crate) goal_radius: f64,
    pub(crate) time_limit: f64,
    pub(crate) control_period: f64,
    pub(crate) seed: u64,
    pub(crate) params: *const CParam,
    pub(crate) params_len: usize,
}

/// `vb_observation`.
#[repr(C)]
pub(crate) struct CObservation {
    pub(crate) size: usize,
    pub(crate) time: f64,
    pub(crate) position: Vec3,
    pub(crate) roll: f64,
    pub(crate) pitch: f64,
    pub(crate) yaw: f64,
    pub(crate) linear_velocity: Vec3,
    pub(crate) angular_velocity: Vec3,
    pub(crate) wheels: *const Wheel,
    pub(crate) wheels_len: usize,
    pub(crate) last_steering: f64,
    pub(crate) last_throttle: f64,
    pub(crate) last_brake: f64,
}

/// `vb_series`.
#[repr(C)]
pub(crate) struct CSeries {
    pub(crate) name: *const c_char,
    pub(crate) values: *const f32,
    pub(crate) values_len: usize,
}

/// `vb_command`.
#[repr(C)]
pub(crate) struct CCommand {
    pub(crate) size: usize,
    pub(crate) steering: f64,
    pub(crate) throttle: f64,
    pub(crate) brake: f64,
    pub(crate) debug: *const CSeries,
    pub(crate) debug_len: usize,
}

/// `vb_error`.
#[repr(C)]
pub(crate) struct CError {
    pub(crate) size: usize,
    pub(crate) message: [c_char; ERROR_BYTES],
}

/// `vb_host`.
#[repr(C)]
pub(crate) struct CHost {
    pub(crate) size: usize,
    pub(crate) context: *mut c_void,
    pub(crate) log: unsafe extern "C" fn(*mut c_void, u32, *const c_char),
}

/// `vb_planner_functions`.
#[repr(C)]
pub(crate) struct CFunctions {
    pub(crate) size: usize,
    pub(crate) abi_major: u32,
    pub(crate) abi_minor: u32,
    pub(crate) init:
        Option<unsafe extern "C" fn(*const CTask, *const CHost, *mut *mut c_void, *mut CError) -> i32>,
    pub(crate) step: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *const CObservation,
            *const CHost,
            *mut CCommand,
            *mut CError,
        ) -> i32,
    >,
    pub(crate) free: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// The functions of an open library.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CPlanner {
    init: unsafe extern "C" fn(*const CTask, *const CHost, *mut *mut c_void, *mut CError) -> i32,
    step: unsafe extern "C" fn(
        *mut c_void,
        *const CObservation,
        *const CHost,
        *mut CCommand,
        *mut CError,
    ) -> i32,
    free: unsafe extern "C" fn(*mut c_void),
}

impl CPlanner {
    /// Takes the functions, or says in what they differ from what this harness calls.
    ///
    /// # Safety
    /// `entry` is the address of the library's `vb_planner_entry`, and the library stays open.
    pub(crate) unsafe fn new(entry: *const CFunctions) -> Result<Self, String> {
        if entry.is_null() || !entry.is_aligned() {
            return Err("the address of vb_planner_entry is not one of a struct".into());
        }
        // SAFETY: the three first fields are there in every version; later ones are read when the size covers them.
        let (size, major, minor) = unsafe { ((*entry).size, (*entry).abi_major, (*entry).abi_minor) };
        if (major, minor) != ABI {
            let (a, b) = ABI;
            return Err(format!(
                "vb_planner_entry is of version {major}.{minor}, the harness speaks {a}.{b}"
            ));
        }
        if size < size_of::<CFunctions>() {
            let wanted = size_of::<CFunctions>();
            return Err(format!("vb_planner_entry has {size} bytes, the harness wants {wanted}"));
        }
        // SAFETY: as above, and the size covers all of it.
        let entry = unsafe { &*entry };
        let missing = |name| format!("vb_planner_entry has no function {name}");
        Ok(Self {
            init: entry.init.ok_or_else(|| missing("init"))?,
            step: entry.step.ok_or_else(|| missing("step"))?,
            free: entry.free.ok_or_else(|| missing("free"))?,
        })
    }

    /// Calls `init`.
    pub(crate) fn init(&self, task: &Task, mut log: Log<'_>) -> Result<*mut c_void, String> {
        let v = &task.vehicle;
        let (id, name) = (text(&task.id), text(&v.name));
        let texts: Vec<(CString, CString)> =
            task.params.iter().map(|p| (text(&p.key), text(&p.value))).collect();
        let params: Vec<CParam> =
            texts.iter().map(|(k, v)| CParam { key: k.as_ptr(), value: v.as_ptr() }).collect();
        let vehicle = CVehicle {
            size: size_of::<CVehicle>(),
            name: name.as_ptr(),
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
        };
        let labels = |m: &Map<u8>| CLabels { frame: m.frame, data: m.data.as_ptr() };
        let task = CTask {
            size: size_of::<CTask>(),
            id: id.as_ptr(),
            vehicle: &raw const vehicle,
            elevation: CHeights { frame: task.elevation.frame, data: task.elevation.data.as_ptr() },
            semantics: labels(&task.semantics),
            occupancy: labels(&task.occupancy),
            path: task.path.as_ptr(),
            path_len: task.path.len(),
            start: task.start,
            goal: task.goal,
            goal_radius: task.goal_radius,
            time_limit: task.time_limit,
            control_period: task.control_period,
            seed: task.seed,
            params: params.as_ptr(),
            params_len: params.len(),
        };
        let (mut planner, mut error) = (ptr::null_mut(), no_error());
        // SAFETY: all pointers lead to values that live until the call ends, as the header promises.
        let status =
            unsafe { (self.init)(&raw const task, &host(&mut log), &raw mut planner, &raw mut error) };
        if status == 0 { Ok(planner) } else { Err(told(&error, "init", status)) }
    }

    /// Calls `step`.
    ///
    /// # Safety
    /// `planner` comes from `init` and isn't freed.
    pub(crate) unsafe fn step(
        &self,
        planner: *mut c_void,
        o: &Observation,
        mut log: Log<'_>,
    ) -> Result<Command, String> {
        let observation = CObservation {
            size: size_of::<CObservation>(),
            time: o.time,
            position: o.position,
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: o.linear_velocity,
            angular_velocity: o.angular_velocity,
            wheels: o.wheels.as_ptr(),
            wheels_len: o.wheels.len(),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        };
        let mut command = CCommand {
            size: size_of::<CCommand>(),
            steering: 0.0,
            throttle: 0.0,
            brake: 0.0,
            debug: ptr::null(),
            debug_len: 0,
        };
        let mut error = no_error();
        // SAFETY: by this function's own condition; all pointers lead to values that live until the call ends.
        let status = unsafe {
            (self.step)(planner, &raw const observation, &host(&mut log), &raw mut command, &raw mut error)
        };
        if status != 0 {
            return Err(told(&error, "step", status));
        }
        let CCommand { steering, throttle, brake, debug, debug_len, .. } = command;
        // SAFETY: the header makes the planner promise it. One that lies harms its own process only.
        let debug = unsafe { series(debug, debug_len) };
        Ok(Command { steering, throttle, brake, debug })
    }

    /// Calls `free`.
    ///
    /// # Safety
    /// `planner` comes from `init` and isn't used again.
    pub(crate) unsafe fn free(&self, planner: *mut c_void) {
        // SAFETY: by this function's own condition.
        unsafe { (self.free)(planner) };
    }
}

/// # Safety
/// The pointers and lengths describe memory that can be read, unless they are null or 0.
unsafe fn series(debug: *const CSeries, len: usize) -> Vec<Series> {
    if debug.is_null() || len == 0 {
        return Vec::new();
    }
    // SAFETY: by this function's own condition.
    let list = unsafe { std::slice::from_raw_parts(debug, len) };
    let one = |s: &CSeries| {
        let name = if s.name.is_null() {
            String::new()
        } else {
            // SAFETY: by this function's own condition.
            unsafe { CStr::from_ptr(s.name) }.to_string_lossy().into_owned()
        };
        let values = if s.values.is_null() || s.values_len == 0 {
            Vec::new()
        } else {
            // SAFETY: by this function's own condition.
            unsafe { std::slice::from_raw_parts(s.values, s.values_len) }.to_vec()
        };
        Series { name, values }
    };
    list.iter().map(one).collect()
}

/// Text for C, up to the first 0.
fn text(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text.as_bytes()[..end]).unwrap_or_default()
}

fn no_error() -> CError {
    CError { size: size_of::<CError>(), message: [0; ERROR_BYTES] }
}

fn told(error: &CError, function: &str, status: i32) -> String {
    // A char of C has a sign on x86-64 and none on aarch64.
    let bytes: Vec<u8> =
        error.message.iter().take_while(|c| **c != 0).flat_map(|c| c.to_ne_bytes()).collect();
    if bytes.is_empty() {
        format!("{function} returned {status} without a message")
    } else {
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

fn host(log: &mut Log<'_>) -> CHost {
    CHost { size: size_of::<CHost>(), context: ptr::from_mut(log).cast(), log: write }
}

/// The `log` of [`CHost`].
unsafe extern "C" fn write(context: *mut c_void, level: u32, message: *const c_char) {
    if context.is_null() || message.is_null() {
        return;
    }
    // SAFETY: `context` is the one that `host` made, alive during the call.
    let log = unsafe { &mut *context.cast::<Log<'_>>() };
    // SAFETY: the header demands text that ends with 0.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    log(level_of(level), &text);
}
