use super::*;
use crate::{Gear, Observation, Point2, Pose, Series, Task, Wheel};

use std::ffi::{CStr, c_char};
use std::ptr;

struct Odd(f64);
impl Planner for Odd {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        crate::log(LogLevel::Info, &format!("init {}", task.id));
        if task.seed == 13 { Err("unlucky".into()) } else { Ok(Self(task.path[1].x)) }
    }
    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        assert!(o.time < 1.0, "too late: {}", o.time);
        let debug = vec![Series { name: "s".into(), values: vec![1.5] }];
        let throttle = o.wheels[0].spin + o.pose()?.yaw;
        Ok(Command { steering: self.0, throttle, brake: 0.25, gear: Gear::Reverse, debug })
    }
}

unsafe extern "C" fn collect(context: *mut c_void, level: u32, message: *const c_char) {
    // SAFETY: `context` is the vector that `host` was given, and the text ends with 0.
    let (lines, text) = unsafe { (&mut *context.cast::<Vec<(u32, String)>>(), CStr::from_ptr(message)) };
    lines.push((level, text.to_string_lossy().into_owned()));
}

fn host(lines: &mut Vec<(u32, String)>) -> CHost {
    CHost { context: ptr::from_mut(lines).cast(), log: collect }
}

fn task(seed: u64) -> Task {
    let path = vec![Point2::default(), Point2 { x: 0.75, y: 0.0 }];
    Task { id: "w/t".into(), seed, path, ..Task::default() }
}

fn start(task: &Task, lines: &mut Vec<(u32, String)>) -> Result<*mut c_void, (i32, Option<String>)> {
    let (mut arena, mut planner, mut error) = (Arena::default(), ptr::null_mut(), CError::default());
    let task = c::lower_task(task, &mut arena);
    // SAFETY: all pointers lead to values that live until the call ends.
    let status = unsafe {
        module::<Odd>(b"x").init()(&raw const task, &host(lines), &raw mut planner, &raw mut error)
    };
    if status == c::OK { Ok(planner) } else { Err((status, error.get())) }
}

/// # Safety
/// The planner comes from `start`.
unsafe fn go(
    planner: *mut c_void,
    o: &Observation,
    lines: &mut Vec<(u32, String)>,
) -> Result<Command, (i32, Option<String>)> {
    let (mut arena, mut command, mut error) = (Arena::default(), CCommand::default(), CError::default());
    let o = c::lower_observation(o, &mut arena);
    // SAFETY: by this function's own condition; all other pointers lead to values that live until the call ends.
    let status = unsafe {
        let step = module::<Odd>(b"x").step();
        step(planner, &raw const o, &host(lines), &raw mut command, &raw mut error)
    };
    if status != c::OK {
        return Err((status, error.get()));
    }
    // SAFETY: the planner is still there, and its command with it.
    Ok(unsafe { c::lift_command(&command) }.unwrap())
}

#[test]
fn data_cross_unchanged_and_log_lines_reach_the_caller() {
    let mut lines = Vec::new();
    let planner = start(&task(1), &mut lines).unwrap();
    let wheels = vec![Wheel { spin: 0.5, travel: 0.0 }];
    let pose = Some(Pose { yaw: 0.125, ..Pose::default() });
    let observation = Observation { time: 0.5, wheels, pose, ..Observation::default() };
    // SAFETY: the planner is fresh from `init`.
    let command = unsafe { go(planner, &observation, &mut lines) }.unwrap();
    let debug = vec![Series { name: "s".into(), values: vec![1.5] }];
    let expected = Command { steering: 0.75, throttle: 0.625, brake: 0.25, gear: Gear::Reverse, debug };
    assert_eq!(command, expected);
    // SAFETY: as above, and it isn't used again.
    unsafe { module::<Odd>(b"x").free()(planner) };
    assert_eq!(lines, [(2, "init w/t".to_owned())]);
    // Outside a call there is nobody to listen.
    crate::log(LogLevel::Error, "nobody hears this");
    assert_eq!(lines.len(), 1);
}

#[test]
fn an_error_and_a_panic_come_back_as_statuses_with_their_text() {
    let mut lines = Vec::new();
    assert_eq!(start(&task(13), &mut lines).unwrap_err(), (c::FAILED, Some("unlucky".into())));
    let planner = start(&task(1), &mut lines).unwrap();
    let late = Observation { time: 2.0, ..Observation::default() };
    // SAFETY: the planner is fresh from `init`.
    let (status, text) = unsafe { go(planner, &late, &mut lines) }.unwrap_err();
    // SAFETY: as above, and it isn't used again.
    unsafe { module::<Odd>(b"x").free()(planner) };
    let text = text.unwrap();
    assert_eq!(status, c::PANICKED);
    assert!(text.contains("native") && text.contains("too late: 2"), "{text}");
}

#[test]
fn a_long_text_is_cut_between_characters() {
    let mut error = CError::default();
    error.set(&"é".repeat(c::ERROR_BYTES));
    let text = error.get().unwrap();
    assert_eq!(text, "é".repeat((c::ERROR_BYTES - 1) / 2));
}
