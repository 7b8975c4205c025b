//! The conformance kit: what an author of a planner runs before anybody else does.
//!
//! [`check`] loads a plugin, drives it over up to three tasks of a suite and shows it extreme observations. Each
//! [`Check`] tells one promise that planners make, and whether this one keeps it. What the checks are is described for
//! authors in `docs/writing-a-planner.md`.

mod budget;
mod course;
mod determinism;
mod hygiene;
mod imports;
mod loading;
mod probes;
mod report;
mod stamp;
mod start_up;
mod tasks;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use vb_host::{Blame, Limits, LoadError, ParamError, Plugin};
use vb_score::Rules;
use vb_sim::Soils;
use vb_vehicle::Vehicle;
use vb_world::{Suite, TaskId};

pub use report::{Check, Report, Verdict};

use crate::RunError;
use course::Course;

/// The things that are checked, and the tasks on which they are.
pub struct Kit<'a> {
    /// Loads the plugin anew; a native one, in a fresh process.
    pub load: &'a (dyn Fn() -> Result<Plugin, LoadError> + Sync),
    /// The plugin's file; `None` for a command.
    pub file: Option<&'a Path>,
    /// The planner's parameters as the user gave them.
    pub params: &'a [(String, String)],
    /// The limits that the plugin is loaded with.
    pub limits: &'a Limits,
    /// The suite of the tasks.
    pub suite: &'a Suite,
    /// The tasks of the suite, at least one; the first three are driven.
    pub tasks: &'a [TaskId],
    pub vehicle: &'a Vehicle,
    /// The soils of deformable ground.
    pub soils: &'a Soils,
    pub rules: &'a Rules,
}

/// The reason why the checks couldn't be made. What the planner does wrong is none of this.
#[derive(Debug, thiserror::Error)]
pub enum KitError {
    /// The plugin doesn't exist, or the machine refuses what loading it needs.
    #[error("{} ({})", .0, .0.code())]
    Load(LoadError),
    /// The planner doesn't have a parameter.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The tasks can't be driven.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The harness or the machine failed: nothing is known about the planner.
    #[error("the harness or the machine failed, so the planner was not checked: {0}")]
    Host(String),
    /// The checks were cancelled.
    #[error("stopped before the last check")]
    Cancelled,
}

/// Makes all checks, and hands each to `on_check` when it is made. Setting `cancel` ends the checks soon.
///
/// # Errors
/// Returns an error if the checks can't be made; see [`KitError`]. A check that fails is not an error.
pub fn check(
    kit: &Kit<'_>,
    on_check: &mut (dyn FnMut(&Check) + Send),
    cancel: &AtomicBool,
) -> Result<Report, KitError> {
    // The WASM code runs on the thread's own stack.
    let stack = kit.limits.thread_stack_bytes();
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(stack);
        let work = thread
            .spawn_scoped(scope, || check_here(kit, on_check, cancel))
            .map_err(|e| KitError::Run(RunError::Thread(e)))?;
        work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn check_here(
    kit: &Kit<'_>,
    on_check: &mut dyn FnMut(&Check),
    cancel: &AtomicBool,
) -> Result<Report, KitError> {
    let course = Course::new(kit)?;
    let mut report = Report::default();
    let (first, first_load) = start_up::timed(|| (kit.load)());
    let checks = match first {
        Ok(first) => {
            report.planner = Some(first.metadata().clone());
            let mut checks = Told { on_check, checks: Vec::new() };
            check_loaded(kit, &course, &first, first_load, &mut checks, cancel)?;
            checks
        }
        Err(error) => {
            let mut checks = Told { on_check, checks: Vec::new() };
            loading::refused(error)?.into_iter().for_each(|check| checks.tell(check));
            checks
        }
    };
    report.checks = checks.checks;
    Ok(report)
}

/// The checks that have been made and told.
struct Told<'a> {
    on_check: &'a mut dyn FnMut(&Check),
    checks: Vec<Check>,
}

impl Told<'_> {
    fn tell(&mut self, check: Check) {
        (self.on_check)(&check);
        self.checks.push(check);
    }
}

fn check_loaded(
    kit: &Kit<'_>,
    course: &Course,
    first: &Plugin,
    first_load: f64,
    checks: &mut Told<'_>,
    cancel: &AtomicBool,
) -> Result<(), KitError> {
    let params = first.params(kit.params)?;
    checks.tell(loading::loaded(first));
    checks.tell(stamp::check(first));
    checks.tell(imports::check(kit, first));
    course.fits(first)?;

    // With `first` and `third` a task is driven by a plugin that has driven nothing before; with `second` the second
    // task comes after the first.
    let (second, second_load) = start_up::timed(|| (kit.load)());
    let (second, third) = match (second, (kit.load)()) {
        (Ok(second), Ok(third)) => (second, third),
        (Err(error), _) | (_, Err(error)) => {
            loading::not_again(error)?.into_iter().for_each(|check| checks.tell(check));
            return Ok(());
        }
    };
    let drive = |task: usize, plugin: &Plugin| course.drive(task, plugin, &params, cancel);
    let mut driven = vec![drive(0, first)?, drive(1, &third)?];
    if course.len() > 2 {
        driven.push(drive(2, &third)?);
    }
    let each = &driven[..course.len().min(driven.len())];
    checks.tell(tasks::check(each));
    let a_again = drive(0, &second)?;
    let deterministic = determinism::check(&driven[0], &a_again);
    let verdict = deterministic.verdict;
    checks.tell(deterministic);
    let b_after_a = drive(1, &second)?;
    checks.tell(hygiene::check(&driven[1], &b_after_a, &a_again, verdict));
    checks.tell(budget::check(each, kit.limits));
    checks.tell(probes::check(course, first, &params)?);
    checks.tell(start_up::check(course, first, &params, [first_load, second_load]));
    Ok(())
}

/// A fault that isn't the planner's ends the checks.
fn planners_own(fault: vb_host::PlannerFault) -> Result<vb_host::PlannerFault, KitError> {
    match fault.code().blame() {
        Blame::Planner => Ok(fault),
        Blame::Host | Blame::Simulation => Err(KitError::Host(fault.to_string())),
    }
}
