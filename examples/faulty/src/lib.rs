//! A planner that fails on demand, to test the harness.
//!
//! It stands still until the step `at`, then triggers `fault`; faults with the prefix `init-` occur in `init`. Each step sends
//! the series `step`: its number and the time.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use vb_sdk::{Command, LogLevel, Observation, Planner, PlannerError, Series, Task, log};

vb_sdk::export_planner! {
    planner: Faulty,
    name: "faulty",
    about: "Stands still until it fails on demand",
    control_period: 0.1,
    params: {
        fault: "none" => "none, error, panic, nan, range, endless, memory, stack, static or clock; init-error, init-panic, …",
        at: 3 => "step at which it fails, from 0",
        only: "" => "the task that it fails on, e.g. w001/t00; empty: all",
    }
}

/// Number of planners of this process: state that planners must not keep.
static MADE: AtomicU32 = AtomicU32::new(0);

struct Faulty {
    fault: String,
    at: u64,
    steps: u64,
}

impl Planner for Faulty {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        MADE.fetch_add(1, Ordering::Relaxed);
        let mut fault: String = task.param_as("fault")?;
        let only: String = task.param_as("only")?;
        if !only.is_empty() && only != task.id {
            fault = "none".into();
        }
        if let Some(fault) = fault.strip_prefix("init-") {
            fail(fault)?;
        }
        Ok(Self { fault, at: task.param_as("at")?, steps: 0 })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        let due = self.steps >= self.at;
        let values = vec![self.steps as f32, observation.time as f32];
        self.steps += 1;
        let mut command = if due {
            log(LogLevel::Info, &format!("failing at {} s: {}", observation.time, self.fault));
            fail(&self.fault)?
        } else {
            Command { brake: 1.0, ..Command::default() }
        };
        command.debug.push(Series { name: "step".into(), values });
        Ok(command)
    }
}

fn fail(fault: &str) -> Result<Command, PlannerError> {
    let mut command = Command { brake: 1.0, ..Command::default() };
    match fault {
        "none" => {}
        "error" => return Err("instructed to give up".into()),
        "panic" => panic!("instructed to panic"),
        "nan" => command.steering = f64::NAN,
        "range" => command.steering = 7.0,
        "endless" => loop {
            std::hint::black_box(());
        },
        "memory" => {
            let mut hoard: Vec<Vec<u8>> = Vec::new();
            loop {
                hoard.push(vec![1; 1 << 20]);
                std::hint::black_box(&hoard);
            }
        }
        "static" => command = turn(0.1 * f64::from(MADE.load(Ordering::Relaxed))),
        "clock" => command = turn(f64::from(nanoseconds()) / 1e9),
        "stack" => command.steering = recurse(0),
        other => return Err(PlannerError::new(format!("parameter `fault`: there is no `{other}`"))),
    }
    Ok(command)
}

fn turn(steering: f64) -> Command {
    Command { steering, throttle: 0.3, ..Command::default() }
}

/// Nanoseconds of the time of day, which is not available to WASM planners.
#[allow(clippy::disallowed_methods, reason = "planners must not do this")]
fn nanoseconds() -> u32 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.subsec_nanos())
}

/// Deeper than any stack, but a terminating recursion for the compiler.
fn recurse(depth: u64) -> f64 {
    let frame = std::hint::black_box([depth; 16]);
    if frame[15] == u64::MAX { 0.0 } else { recurse(frame[15] + 1) + 1.0 }
}
