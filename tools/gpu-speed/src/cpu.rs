//! The same drives on the CPU.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use vb_sim::{SAMPLE_PERIOD, Simulation, StateHash, Surroundings};

use crate::{Drive, timed};

/// What became of the first vehicles on the CPU.
pub(crate) struct Driven {
    pub(crate) threads: usize,
    /// Time that starts took, s.
    pub(crate) starts: f64,
    /// Time that drives took, s.
    pub(crate) drives: f64,
    /// The hash of the states of each vehicle; none if it couldn't start, or has diverged.
    pub(crate) hashes: Vec<Option<u64>>,
}

/// Drives the first `count` vehicles on all cores.
pub(crate) fn drive(drive: &Drive, count: usize) -> Driven {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let worlds: Vec<_> =
        drive.course.worlds.iter().map(|world| Surroundings::from(Arc::new(world.clone()))).collect();
    let starting = |task: usize| {
        let ((world, task), s) = (&drive.course.tasks[task], &drive.course.setting);
        Simulation::new(worlds[*world].clone(), &s.model, &s.soils, task.start, s.options).ok()
    };
    let (pool, starts) = timed(|| side_by_side(threads, drive.course.tasks.len().min(count), starting));
    let sample_every = (SAMPLE_PERIOD / drive.course.setting.options.step).round() as u64;
    let driving = |vehicle: usize| {
        let mut sim = pool.get(drive.task(vehicle))?.clone()?;
        let mut hash = StateHash::default();
        sim.visit_state(|x| hash.push(x));
        // From sample to sample, as trials do.
        for _ in 0..drive.periods * drive.steps() / sample_every {
            sim.advance(Drive::controls(vehicle), sample_every).ok()?;
            sim.visit_state(|x| hash.push(x));
        }
        Some(hash.value())
    };
    let (hashes, drives) = timed(|| side_by_side(threads, count, driving));
    Driven { threads, starts, drives, hashes }
}

/// What a function makes of the numbers below `count`, in their order.
fn side_by_side<T: Send>(threads: usize, count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mine = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < count));
        mine.map(|k| (k, of(k))).collect::<Vec<_>>()
    };
    let mut all = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_default()).collect::<Vec<_>>()
    });
    all.sort_by_key(|(k, _)| *k);
    all.into_iter().map(|(_, made)| made).collect()
}
