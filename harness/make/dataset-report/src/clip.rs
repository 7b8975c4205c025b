//! An episode as a replay.

use std::sync::Arc;

use vb_dataset::{Dataset, Ending, Episode, EpisodeInfo};
use vb_record::{Sample, TRACE_SCHEMA, Trace, TraceMeta, TraceMode, WheelSample};
use vb_replay::{Motion, PlannerSeries, Replay, ReplayRun, Sensed};
use vb_score::{Outcome, TaskRecord};
use vb_vehicle::VehicleModel;
use vb_world::{Pose2, Task, World};

/// The replay of an episode, from its frames: as many poses a second as there are frames, and no ruts. `world` is the
/// episode's at the dataset's scale, and `vehicle` the dataset's.
#[must_use]
pub fn clip(
    dataset: &Dataset,
    index: usize,
    episode: &Episode,
    world: &Arc<World>,
    vehicle: &VehicleModel,
) -> Replay {
    let info = &episode.info;
    let own = || {
        let [x, y, yaw] = info.start;
        let path = vec![[x, y], info.goal];
        Task { id: format!("episode_{index}"), start: Pose2 { x, y, yaw }, goal: info.goal, path }
    };
    let task = info.task.as_ref().and_then(|id| world.task(id.task())).cloned().unwrap_or_else(own);
    let trace = trace(dataset, episode, world, &task);
    let run = ReplayRun {
        label: format!("{}, episode {index}", info.driver),
        record: record(info, world, &task),
        rules: None,
        vehicle: Arc::new(vehicle.spec().clone()),
        motion: Motion::sampled(&trace, Some(vehicle)),
        series: PlannerSeries::new(Vec::new()),
        sensed: Sensed::default(),
    };
    let suite = dataset.header().name.clone();
    // Whoever drives a task has a goal; an exploration has no task.
    let has_goal = info.task.is_some() || info.goal != [info.start[0], info.start[1]];
    Replay { world: world.clone(), task, suite, has_goal, goal_radius: None, runs: vec![run] }
}

/// The frames as samples.
fn trace(dataset: &Dataset, episode: &Episode, world: &World, task: &Task) -> Trace {
    let header = dataset.header();
    let (view, period) = (episode.view(dataset.features()), 1.0 / f64::from(header.hz));
    let mut trace = Trace {
        meta: TraceMeta {
            schema: TRACE_SCHEMA,
            task: world.task_id(task),
            start: episode.info.start,
            goal: task.goal,
            goal_z: world.heightfield.height(task.goal[0], task.goal[1]),
            half_extent: [world.heightfield.half_x(), world.heightfield.half_y()],
            scale: header.scale,
            max_speed: 30.0,
            time_step: header.time_step,
            sample_period: period,
            mode: TraceMode::Full,
        },
        samples: Vec::with_capacity(episode.frames),
        wheels: header.layout.wheels,
        wheel_samples: Vec::new(),
    };
    for k in 0..episode.frames {
        let (s, applied) = (view.state(k), view.row("action.applied", k));
        trace.samples.push(Sample {
            time: k as f64 * period,
            x: s[0],
            y: s[1],
            z: s[2],
            roll: s[3],
            pitch: s[4],
            yaw: s[5],
            vx: s[6],
            vy: s[7],
            vz: s[8],
            wx: s[9],
            wy: s[10],
            wz: s[11],
            steering: s[12],
            throttle: applied[1],
            brake: applied[2],
            gear: match s[14] {
                gear if gear < 0.0 => Sample::REVERSE,
                gear if gear > 0.0 => 0.0,
                _ => Sample::NEUTRAL,
            },
        });
        let wheels = view.row("observation.wheels", k);
        let wheel = |w: &[f64]| WheelSample { speed: w[0], deflection: w[1] };
        trace.wheel_samples.extend(wheels.chunks_exact(2).map(wheel));
    }
    trace
}

/// What a run would have written of the episode.
fn record(info: &EpisodeInfo, world: &World, task: &Task) -> TaskRecord {
    let outcome = match info.outcome {
        Ending::Decided(outcome) => outcome,
        // It has no outcome of the rules; its reason says so.
        Ending::ByDriver => Outcome::Timeout,
    };
    TaskRecord {
        task: world.task_id(task),
        world: world.id.clone(),
        elevation: world.elevation,
        terrain: world.terrain,
        density: world.density,
        outcome,
        three_way: outcome.three_way(false),
        flags: std::collections::BTreeMap::new(),
        departures: Vec::new(),
        reason: info.reason.clone(),
        cause: info.cause,
        evidence: String::new(),
        fault: None,
        time_s: info.time_s,
        state_hash: info.state_hash.clone(),
        sim_steps: 0,
        planner_steps: 0,
        clamped: 0,
        fuel: None,
        metrics: None,
        ride: None,
        log: Vec::new(),
        backtrace: Vec::new(),
    }
}
