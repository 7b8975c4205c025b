//! Planners as native libraries: a library whose root module `abi_stable` checks for its layout when it is loaded.
//!
//! Planner authors need none of this: [`export_planner!`](crate::export_planner) uses it on one side, the harness on
//! the other. Text and arrays cross as borrowed slices; a panic becomes a [`Fault`] and never crosses.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use abi_stable::StableAbi;
use abi_stable::library::{RootModule, RootModuleResult};
use abi_stable::prefix_type::{PrefixRefTrait, PrefixTypeTrait};
use abi_stable::sabi_types::VersionStrings;
use abi_stable::std_types::{RErr, ROk, RResult, RSlice, RStr, RString, RVec};

use crate::{
    Command, GridFrame, LogLevel, Map, Observation, Param, Planner, PlannerError, Point2, Pose2, Series,
    Task, Vec3, Vehicle, Wheel,
};

/// The functions of a planner library.
#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = PlannerModuleRef)))]
pub struct PlannerModule {
    /// The [metadata](crate::metadata) text; that it is named here keeps the linker from dropping its section.
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

/// A [`Vehicle`] as it crosses the border of the library.
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

impl From<&NativeTask<'_>> for Task {
    fn from(t: &NativeTask<'_>) -> Self {
        let v = &t.vehicle;
        let labels = |m: &NativeLabels<'_>| Map { frame: m.frame, data: m.data.to_vec() };
        Self {
            id: t.id.to_string(),
            vehicle: Vehicle {
                name: v.name.to_string(),
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
            elevation: Map { frame: t.elevation.frame, data: t.elevation.data.to_vec() },
            semantics: labels(&t.semantics),
            occupancy: labels(&t.occupancy),
            path: t.path.to_vec(),
            start: t.start,
            goal: t.goal,
            goal_radius: t.goal_radius,
            time_limit: t.time_limit,
            control_period: t.control_period,
            seed: t.seed,
            params: t
                .params
                .iter()
                .map(|p| Param { key: p.key.to_string(), value: p.value.to_string() })
                .collect(),
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

impl From<&NativeObservation<'_>> for Observation {
    fn from(o: &NativeObservation<'_>) -> Self {
        Self {
            time: o.time,
            position: o.position,
            roll: o.roll,
            pitch: o.pitch,
            yaw: o.yaw,
            linear_velocity: o.linear_velocity,
            angular_velocity: o.angular_velocity,
            wheels: o.wheels.to_vec(),
            last_steering: o.last_steering,
            last_throttle: o.last_throttle,
            last_brake: o.last_brake,
        }
    }
}

impl From<Command> for NativeCommand {
    fn from(c: Command) -> Self {
        let debug =
            c.debug.into_iter().map(|s| NativeSeries { name: s.name.into(), values: s.values.into() });
        Self { steering: c.steering, throttle: c.throttle, brake: c.brake, debug: debug.collect() }
    }
}

impl From<NativeCommand> for Command {
    fn from(c: NativeCommand) -> Self {
        let debug = c.debug.into_iter().map(|s| Series { name: s.name.into(), values: s.values.into() });
        Self { steering: c.steering, throttle: c.throttle, brake: c.brake, debug: debug.collect() }
    }
}

thread_local! {
    /// Where log lines go, while the harness is calling on this thread.
    static LOG: Cell<Option<LogCallback>> = const { Cell::new(None) };
    /// The text of the last panic during such a call.
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

pub(crate) fn log(level: LogLevel, message: &str) {
    if let Some(callback) = LOG.get() {
        // SAFETY: the harness keeps the context alive during its call, which is when LOG is set.
        unsafe { (callback.write)(callback.context, level as u8, RStr::from_str(message)) };
    }
}

/// Keeps the text and place of a panic within a call of the harness, instead of printing it.
fn install_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if LOG.get().is_some() {
                PANIC.set(Some(info.to_string()));
            } else {
                previous(info);
            }
        }));
    });
}

/// Runs planner code for the harness: log lines go to `callback`, a panic becomes a fault.
fn guarded<T>(callback: LogCallback, f: impl FnOnce() -> Result<T, PlannerError>) -> RResult<T, Fault> {
    install_panic_hook();
    LOG.set(Some(callback));
    // A planner that panicked is never called again, so a broken invariant of its is not observed.
    let result = catch_unwind(AssertUnwindSafe(f));
    LOG.set(None);
    match result {
        Ok(Ok(value)) => ROk(value),
        Ok(Err(e)) => RErr(Fault { panicked: false, message: e.to_string().into() }),
        Err(_) => {
            let message = PANIC.take().unwrap_or_else(|| "panicked".to_owned());
            RErr(Fault { panicked: true, message: message.into() })
        }
    }
}

extern "C" fn init<P: Planner>(task: &NativeTask<'_>, log: LogCallback) -> RResult<*mut (), Fault> {
    guarded(log, || Ok(Box::into_raw(Box::new(P::init(&task.into())?)).cast()))
}

/// # Safety
/// `planner` comes from `init::<P>`, isn't freed, and isn't used by another thread meanwhile.
unsafe extern "C" fn step<P: Planner>(
    planner: *mut (),
    observation: &NativeObservation<'_>,
    log: LogCallback,
) -> RResult<NativeCommand, Fault> {
    // SAFETY: by this function's own conditions.
    let planner = unsafe { &mut *planner.cast::<P>() };
    guarded(log, || planner.step(&observation.into()).map(Into::into))
}

/// # Safety
/// `planner` comes from `init::<P>` and isn't used again.
unsafe extern "C" fn free<P: Planner>(planner: *mut ()) {
    // SAFETY: by this function's own conditions.
    let planner = unsafe { Box::from_raw(planner.cast::<P>()) };
    // There is nobody left to tell of a panic in `drop`.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(planner)));
}

/// The root module of a planner `P`.
#[must_use]
pub fn module<P: Planner>(metadata: &'static [u8]) -> PlannerModuleRef {
    PlannerModule {
        metadata: RSlice::from_slice(metadata),
        init: init::<P>,
        step: step::<P>,
        free: free::<P>,
    }
    .leak_into_prefix()
}

/// The root module as [`export_planner!`](crate::export_planner) hands it over.
#[doc(hidden)]
pub fn erased_module<P: Planner>(metadata: &'static [u8]) -> RootModuleResult {
    // SAFETY: `LibHeader` casts it back after the layout check.
    ROk(unsafe { module::<P>(metadata).to_prefix_ref().cast() })
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Odd(f64);
    impl Planner for Odd {
        fn init(task: &Task) -> Result<Self, PlannerError> {
            crate::log(LogLevel::Info, &format!("init {}", task.id));
            if task.seed == 13 { Err("unlucky".into()) } else { Ok(Self(task.path[1].x)) }
        }
        fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
            assert!(o.time < 1.0, "too late: {}", o.time);
            let debug = vec![Series { name: "s".into(), values: vec![1.5] }];
            Ok(Command { steering: self.0, throttle: o.wheels[0].speed, brake: 0.25, debug })
        }
    }

    unsafe extern "C" fn collect(context: *mut (), level: u8, message: RStr<'_>) {
        // SAFETY: `context` is the vector that `sink` was given.
        unsafe { &mut *context.cast::<Vec<(u8, String)>>() }.push((level, message.to_string()));
    }
    fn sink(lines: &mut Vec<(u8, String)>) -> LogCallback {
        LogCallback { context: std::ptr::from_mut(lines).cast(), write: collect }
    }
    fn task(seed: u64) -> Task {
        let path = vec![Point2::default(), Point2 { x: 0.75, y: 0.0 }];
        Task { id: "w/t".into(), seed, path, ..Task::default() }
    }

    #[test]
    fn data_cross_unchanged_and_log_lines_reach_the_caller() {
        let (module, mut lines) = (module::<Odd>(b"x"), Vec::new());
        let planner = module.init()(&NativeTask::from(&task(1)), sink(&mut lines)).unwrap();
        let wheels = vec![Wheel { speed: 0.5, deflection: 0.0 }];
        let observation = Observation { time: 0.5, wheels, ..Observation::default() };
        // SAFETY: the planner is fresh from `init`.
        let command = unsafe { module.step()(planner, &(&observation).into(), sink(&mut lines)) };
        let debug = vec![Series { name: "s".into(), values: vec![1.5] }];
        let expected = Command { steering: 0.75, throttle: 0.5, brake: 0.25, debug };
        assert_eq!(Command::from(command.unwrap()), expected);
        // SAFETY: as above, and it isn't used again.
        unsafe { module.free()(planner) };
        assert_eq!(lines, [(2, "init w/t".to_owned())]);
        // Outside a call there is nobody to listen.
        crate::log(LogLevel::Error, "nobody hears this");
        assert_eq!(lines.len(), 1);
    }

    #[test]
    fn an_error_and_a_panic_come_back_as_faults_with_their_text() {
        let (module, mut lines) = (module::<Odd>(b"x"), Vec::new());
        let fault = module.init()(&NativeTask::from(&task(13)), sink(&mut lines)).unwrap_err();
        assert_eq!(fault, Fault { panicked: false, message: "unlucky".into() });
        let planner = module.init()(&NativeTask::from(&task(1)), sink(&mut lines)).unwrap();
        let late = Observation { time: 2.0, ..Observation::default() };
        // SAFETY: the planner is fresh from `init`.
        let fault = unsafe { module.step()(planner, &(&late).into(), sink(&mut lines)) }.unwrap_err();
        // SAFETY: as above, and it isn't used again.
        unsafe { module.free()(planner) };
        assert!(fault.panicked);
        assert!(
            fault.message.contains("native.rs") && fault.message.contains("too late: 2"),
            "{}",
            fault.message
        );
    }
}
