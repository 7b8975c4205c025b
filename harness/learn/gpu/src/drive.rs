//! Drives that a GPU and a CPU make alike, to see whether they come to the same states.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use vb_sim::{Controls, SAMPLE_PERIOD, Simulation, StateHash, Surroundings};

use crate::{Course, Fleet, GpuError};

/// The time from one command to the next, s: that of the benchmark's environments.
pub const CONTROL_PERIOD: f64 = 0.1;

/// A drive: each vehicle begins one of the tasks of a course and keeps its steering and throttle, which differ from vehicle to
/// vehicle, for the whole time.
pub struct Drive<'a> {
    course: &'a Course,
    /// Commands.
    periods: u64,
}

impl<'a> Drive<'a> {
    /// A drive of this time (s), of one control period at least.
    #[must_use]
    pub fn new(course: &'a Course, seconds: f64) -> Self {
        Self { course, periods: (seconds / CONTROL_PERIOD).round().max(1.0) as u64 }
    }

    /// How many commands a vehicle is given.
    #[must_use]
    pub fn periods(&self) -> u64 {
        self.periods
    }

    /// The numbers of the tasks that so many vehicles begin.
    #[must_use]
    pub fn tasks(&self, vehicles: usize) -> Vec<Option<usize>> {
        (0..vehicles).map(|vehicle| Some(self.task(vehicle))).collect()
    }

    fn task(&self, vehicle: usize) -> usize {
        vehicle % self.course.tasks.len().max(1)
    }

    fn controls(vehicle: usize) -> Controls {
        let part = |primes: usize| (vehicle * primes % 101) as f64 / 100.0;
        Controls { steering: part(37) - 0.5, throttle: 0.2 + 0.6 * part(53), ..Controls::default() }
    }

    /// Steps from one command to the next.
    fn steps(&self) -> u64 {
        (CONTROL_PERIOD / self.course.setting.options.step).round() as u64
    }

    /// Drives a fleet whose vehicles stand at the starts of [`Self::tasks`].
    pub fn on_gpu(&self, fleet: &mut Fleet) -> Result<(), GpuError> {
        let told = (0..fleet.vehicles()).map(Self::controls).map(|c| [c.steering, c.throttle, c.brake, 1.0]);
        let told: Vec<[f64; 4]> = told.collect();
        (0..self.periods).try_for_each(|_| {
            fleet.control(&told)?;
            fleet.advance(self.steps())
        })
    }

    /// The first `vehicles` vehicles at their starts on the CPU, one for each task that one of them begins; none for a task that
    /// can't be started.
    #[must_use]
    pub fn starts_on_cpu(&self, vehicles: usize) -> Vec<Option<Simulation>> {
        let worlds = self.course.worlds.iter().map(|world| Surroundings::from(Arc::new(world.clone())));
        let worlds: Vec<_> = worlds.collect();
        side_by_side(self.course.tasks.len().min(vehicles), |task| {
            let ((world, task), s) = (&self.course.tasks[task], &self.course.setting);
            Simulation::new(worlds[*world].clone(), &s.model, &s.soils, task.start, s.options).ok()
        })
    }

    /// Drives the first `vehicles` vehicles on all cores, from these starts. Returns the hash of the states of each; none if it
    /// couldn't start, or has diverged.
    #[must_use]
    pub fn on_cpu(&self, starts: &[Option<Simulation>], vehicles: usize) -> Vec<Option<u64>> {
        let sample_every = (SAMPLE_PERIOD / self.course.setting.options.step).round() as u64;
        side_by_side(vehicles, |vehicle| {
            let mut sim = starts.get(self.task(vehicle))?.clone()?;
            let mut hash = StateHash::default();
            sim.visit_state(|x| hash.push(x));
            // From sample to sample, as trials do.
            for _ in 0..self.periods * self.steps() / sample_every {
                sim.advance(Self::controls(vehicle), sample_every).ok()?;
                sim.visit_state(|x| hash.push(x));
            }
            Some(hash.value())
        })
    }
}

/// How many of the CPU's hashes a fleet has, too, and how many there are: a vehicle that has diverged on the CPU has none.
#[must_use]
pub fn same(cpu: &[Option<u64>], gpu: &[u64]) -> (usize, usize) {
    let compared = cpu.iter().zip(gpu).filter_map(|(cpu, gpu)| cpu.map(|cpu| cpu == *gpu));
    compared.fold((0, 0), |(same, of), is| (same + usize::from(is), of + 1))
}

/// What a function makes of the numbers below `count`, in their order, on all cores.
fn side_by_side<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mine = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < count));
        mine.map(|k| (k, of(k))).collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut all = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let made = workers.into_iter().map(|w| w.join().unwrap_or_else(|panic| resume_unwind(panic)));
        made.flatten().collect::<Vec<_>>()
    });
    all.sort_by_key(|(k, _)| *k);
    all.into_iter().map(|(_, made)| made).collect()
}
