//! `vb-twin-check`: how far the twin, the simulation in Ibex's mind, agrees with the harness's simulator.

mod drive;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use ibex::twin::Twin;
use vb_catalog::Catalog;
use vb_env::{Arena, EnvError, Options};
use vb_sdk::mppi::{LANES, Model as _};
use vb_sdk::policy::ActionKind;
use vb_sdk::{Observation, PlannerError, math};
use vb_world::TaskId;

use crate::drive::{Drive, FASTEST};

/// Drive at random, and let Ibex's twin foretell each second what comes of the next three
///
/// The twin is told what a planner is: the maps and the state. It doesn't know of obstacles, so that drives that end at one are left out.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The suite: its name or folder
    #[arg(long, value_name = "SUITE")]
    suite: PathBuf,
    /// The tasks from whose starts it is driven, as for `vb-harness run`; without it, all
    #[arg(long, value_name = "SELECTOR")]
    tasks: Option<String>,
    /// The vehicle
    #[arg(long, value_name = "NAME|FILE", default_value = "hmmwv")]
    vehicle: String,
    /// By how much lower than it is the hull is simulated, m at full scale
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    clearance: f64,
}

#[derive(Debug, thiserror::Error)]
enum CheckError {
    #[error(transparent)]
    Catalog(#[from] vb_catalog::CatalogError),
    #[error(transparent)]
    Env(#[from] EnvError),
    #[error(transparent)]
    Planner(#[from] PlannerError),
    #[error("{0}: there is no map of heights")]
    NoMap(TaskId),
    #[error("no drive is long enough for the twin to foretell anything: choose other tasks")]
    Nothing,
}

/// What is foretold, s.
const AHEAD: [usize; 3] = [1, 2, 3];
/// A vehicle is stuck that comes this far in the last of these seconds at most, m at full scale.
const STUCK: f64 = 0.4;
/// A vehicle drives that is faster than this, m/s at full scale.
const DRIVES: f64 = 1.5;
/// What a vehicle's motion consists of, and whether it is turning.
const MOTION: [(&str, bool); 6] = [
    ("velocity forward, m/s", false),
    ("to the left, m/s", false),
    ("up, m/s", false),
    ("angular velocity of roll, rad/s", true),
    ("of pitch, rad/s", true),
    ("of yaw, rad/s", true),
];

/// What the twin foretold once.
struct Foretold {
    /// Of a vehicle that drives: by how much each part of its [`MOTION`] was foretold wrong over a control period, and has changed.
    moved: Option<[[f64; 2]; MOTION.len()]>,
    /// How far off it was after each of [`AHEAD`], m.
    off: [f64; AHEAD.len()],
    /// Whether the vehicle drove at first, whether it was stuck in the end, and whether the twin was.
    drove: bool,
    stuck: bool,
    foreseen: bool,
}

fn main() -> ExitCode {
    match run(&Args::parse(), &Catalog::find()) {
        Ok(foretold) => {
            let _ = write!(std::io::stdout(), "{}", table(&foretold));
            ExitCode::SUCCESS
        }
        Err(e) => {
            let _ = writeln!(std::io::stderr(), "error: {e}");
            ExitCode::from(3)
        }
    }
}

fn run(args: &Args, catalog: &Catalog) -> Result<Vec<Foretold>, CheckError> {
    let options = Options {
        suite: Some(args.suite.clone()),
        tasks: args.tasks.clone(),
        vehicle: args.vehicle.clone(),
        action: ActionKind::Speed { slowest: 0.0, fastest: FASTEST },
        observation: vec!["state".into()],
        ..Options::default()
    };
    let arena = Arc::new(Arena::new(catalog, options, &mut || ())?);
    let mut foretold = Vec::new();
    for task in arena.tasks() {
        let drive = Drive::new(&arena, task)?;
        if !drive.met_obstacle {
            foretell(&drive, task, args.clearance, &mut foretold)?;
        }
    }
    if foretold.is_empty() {
        return Err(CheckError::Nothing);
    }
    Ok(foretold)
}

/// Lets the twin foretell a drive, second by second.
fn foretell(drive: &Drive, name: &TaskId, clearance: f64, all: &mut Vec<Foretold>) -> Result<(), CheckError> {
    let task = &drive.task;
    let heights = task.elevation.as_ref().ok_or_else(|| CheckError::NoMap(name.clone()))?;
    let mut twin = Twin::new(heights, task.semantics.as_ref(), &task.vehicle, clearance);
    let (scale, second) = (task.vehicle.scale, drive.second);
    let longest = AHEAD[AHEAD.len() - 1] * second;
    for (k, seen) in drive.seen.iter().enumerate() {
        let start = twin.state(seen, drive.integrals[k])?;
        twin.learn(&start, seen.time);
        if !k.is_multiple_of(second) || k + longest >= drive.seen.len() {
            continue;
        }
        let drove = seen.pose.is_some_and(|p| p.linear_velocity.x > DRIVES * scale.sqrt());
        let place = |k: usize| drive.seen[k].pose.map_or([0.0; 2], |p| [p.position.x, p.position.y]);
        let between = |a: [f64; 2], b: [f64; 2]| math::hypot(a[0] - b[0], a[1] - b[1]);
        let moved = drove.then(|| {
            let mut next = start.clone();
            twin.step(&mut next, &drive.commands[k].map(|c| [c as f32; LANES]), drive.period as f32);
            let [before, after] = [k, k + 1].map(|k| motion(&drive.seen[k]));
            let told = twin.motion(&next);
            std::array::from_fn(|i| {
                let unit = if MOTION[i].1 { 1.0 / scale.sqrt() } else { scale.sqrt() };
                [told[i] - after[i], after[i] - before[i]].map(|d| d.abs() / unit)
            })
        });
        let ends = twin_ends(&twin, start, &drive.commands[k..k + longest], drive.period, second);
        let last = |places: [[f64; 2]; 2]| between(places[0], places[1]) < STUCK * scale;
        all.push(Foretold {
            moved,
            off: std::array::from_fn(|i| between(ends[i], place(k + AHEAD[i] * second)) / scale),
            drove,
            stuck: last([place(k + longest - second), place(k + longest)]),
            foreseen: last([ends[AHEAD.len() - 2], ends[AHEAD.len() - 1]]),
        });
    }
    Ok(())
}

/// How a vehicle is seen to move, as [`MOTION`] has it.
fn motion(seen: &Observation) -> [f64; MOTION.len()] {
    seen.pose.map_or([0.0; MOTION.len()], |p| {
        let (v, w) = (p.linear_velocity, p.angular_velocity);
        [v.x, v.y, v.z, w.x, w.y, w.z]
    })
}

/// Where the twin is after each second.
fn twin_ends(
    twin: &Twin,
    mut state: ibex::twin::State,
    commands: &[[f64; 2]],
    period: f64,
    second: usize,
) -> Vec<[f64; 2]> {
    let mut ends = Vec::new();
    for (k, command) in commands.iter().enumerate() {
        twin.step(&mut state, &command.map(|c| [c as f32; LANES]), period as f32);
        if (k + 1).is_multiple_of(second) {
            ends.push([f64::from(state.x[0]), f64::from(state.y[0])]);
        }
    }
    ends
}

fn table(all: &[Foretold]) -> String {
    let mut text = format!(
        "{} times foretold\n\n| off by, m at full scale | median | 3 of 4 | 9 of 10 |\n|---|---|---|---|\n",
        all.len()
    );
    for (i, seconds) in AHEAD.iter().enumerate() {
        let mut off: Vec<f64> = all.iter().map(|f| f.off[i]).collect();
        off.sort_by(f64::total_cmp);
        let part = |part: f64| off[((part * off.len() as f64) as usize).min(off.len() - 1)];
        let _ =
            writeln!(text, "| after {seconds} s | {:.2} | {:.2} | {:.2} |", part(0.5), part(0.75), part(0.9));
    }
    text.push_str("\n| driving, within a control period | off by (median) | changes by |\n|---|---|---|\n");
    for (i, (name, _)) in MOTION.iter().enumerate() {
        let median = |k: usize| {
            let mut of: Vec<f64> = all.iter().filter_map(|f| f.moved).map(|m| m[i][k]).collect();
            of.sort_by(f64::total_cmp);
            of.get(of.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let _ = writeln!(text, "| {name} | {:.3} | {:.3} |", median(0), median(1));
    }
    text.push_str("\n| | times | foretold |\n|---|---|---|\n");
    let mut row = |name: &str, of: &dyn Fn(&Foretold) -> bool, told: &dyn Fn(&Foretold) -> bool| {
        let count = all.iter().filter(|f| of(f)).count();
        let right = all.iter().filter(|f| of(f) && told(f)).count();
        let _ = writeln!(text, "| {name} | {count} | {right} |");
    };
    row("gets on", &|f| !f.stuck, &|f| !f.foreseen);
    row("is stuck in the end", &|f| f.stuck, &|f| f.foreseen);
    row("drives at first, and is stuck in the end", &|f| f.stuck && f.drove, &|f| f.foreseen);
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn foretold(tasks: &str, clearance: f64) -> Result<Vec<Foretold>, CheckError> {
        let catalog = Catalog::at(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tasks"));
        let args =
            Args { suite: "smoke".into(), tasks: Some(tasks.into()), vehicle: "hmmwv".into(), clearance };
        run(&args, &catalog)
    }

    /// On low ground the twin is mostly within half a metre after a second, by which a planner tells that a vehicle gets on, and takes none for
    /// stuck that isn't. It is still that of a vehicle with open differentials and stiffer springs. A hull that is half a metre lower than the vehicle's lies on the ground, which nobody may overlook.
    #[test]
    fn on_low_ground_the_twin_foretells_what_the_simulator_does() {
        let good = |all: &[Foretold]| {
            let near = all.iter().filter(|f| f.off[0] < 0.5).count();
            near as f64 / all.len() as f64
        };
        let (own, low) = (foretold("w001/t00-t01", 0.05).unwrap(), foretold("w001/t00-t01", 0.5).unwrap());
        assert!(own.len() > 20 && good(&own) > 0.5, "{} of {}", good(&own), own.len());
        assert!(own.iter().all(|f| f.stuck || !f.foreseen));
        assert!(good(&low) < 0.25, "{}", good(&low));
        assert_eq!(table(&own), table(&foretold("w001/t00-t01", 0.05).unwrap()));
    }

    #[test]
    fn tasks_that_are_not_there_are_an_error() {
        assert!(foretold("w999", 0.05).is_err());
    }
}
