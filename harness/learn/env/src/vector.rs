//! Many environments at a time, stepped by several threads.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::curriculum::{Curriculum, Ending, Spec};
use vb_files::lock;
use vb_score::{Outcome, TaskRecord};
use vb_world::TaskId;

use crate::error::guarded;
use crate::{Arena, Env, EnvError, Output, Reset, Step};

/// The stack of a worker, bytes. Simulations keep little there.
const STACK: usize = 8 << 20;
/// How often it is looked whether the caller wants no more.
const LOOK: Duration = Duration::from_millis(50);

/// When the next episode begins after one has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Autoreset {
    /// With the step after it, whose action is not used and which is worth nothing.
    #[default]
    NextStep,
    /// At once: the step returns the first observation of the next episode, and the last one of the old apart from it.
    SameStep,
    /// When it is asked for.
    Disabled,
}

/// What an environment has done, beside the numbers of [`Output`].
#[derive(Clone, Debug)]
pub struct Arrival {
    /// The index of the environment, from 0.
    pub index: usize,
    /// The task and the seed of the sensors' noise, if an episode has begun.
    pub began: Option<(TaskId, u64)>,
    /// The record of the episode that has ended; `None` if the episode goes on.
    pub ended: Option<Box<TaskRecord>>,
}

enum Job {
    Reset(Reset),
    Step(Vec<f64>),
}

/// One environment among many.
struct Place {
    env: Env,
    is_over: bool,
    /// The name of the task that the curriculum has chosen for the next episode.
    next: Option<TaskId>,
}

impl Place {
    /// How long its next job will take compared with others. To begin an episode takes as long as several steps, and one in which the
    /// hull touches something is mostly followed by another.
    fn effort(&self) -> u64 {
        if self.is_over { u64::MAX } else { self.env.contact_steps() }
    }
}

struct Shared {
    places: Vec<Mutex<Place>>,
    output: Output,
    autoreset: Autoreset,
    /// How many jobs are done at a time.
    threads: usize,
    jobs: Mutex<Jobs>,
    there_are_jobs: Condvar,
    done: Mutex<VecDeque<(usize, Result<Arrival, EnvError>)>>,
    something_is_done: Condvar,
}

#[derive(Default)]
struct Jobs {
    waiting: VecDeque<(usize, Job)>,
    running: usize,
    stop: bool,
}

impl Jobs {
    /// The next job, if one waits and fewer than `most` are being done.
    fn take(&mut self, most: usize) -> Option<(usize, Job)> {
        let next = if self.running < most { self.waiting.pop_front() } else { None };
        self.running += usize::from(next.is_some());
        next
    }
}

/// Many environments of an arena, stepped by several threads.
///
/// [`Self::reset`] and [`Self::send`] hand out work to workers, [`Self::receive`] waits for what is done and may help them. What an
/// environment does depends on its own seed and actions alone; only the order in which environments are done depends on the threads.
pub struct VectorEnv {
    arena: Arc<Arena>,
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
    /// The process that the workers are in.
    process: u32,
    /// The environments that are at work.
    at_work: Vec<bool>,
    /// How far each is, as far as it was received.
    phases: Vec<Phase>,
    curriculum: Option<Curriculum>,
}

/// How far an environment is.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Phase {
    /// It was never reset.
    Fresh,
    /// It is in an episode.
    Driving,
    /// Its episode has ended, for this reason.
    Over(String),
}

#[allow(clippy::disallowed_methods, reason = "it tells when the caller is asked, which changes no result")]
fn now() -> Instant {
    Instant::now()
}

impl VectorEnv {
    /// So many environments, on so many threads. Observations are flat, or by parts.
    ///
    /// # Errors
    /// Returns an error if a number is 0 or too great, or a thread can't be started.
    pub fn new(
        arena: Arc<Arena>,
        count: usize,
        threads: usize,
        autoreset: Autoreset,
        flat: bool,
    ) -> Result<Self, EnvError> {
        let within = |option, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            let problem = format!("must lie in 1 to {most}");
            Err(EnvError::Option { option, value: value.to_string(), problem })
        };
        within("num_envs", count, 65_536)?;
        within("threads", threads, 1024)?;
        // Memory that isn't there would end the process later, and the interpreter with it.
        let bytes = Output::bytes(&arena, count, flat, autoreset);
        if Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
            let problem =
                format!("is too many: their observations need {bytes} bytes, more than the available memory");
            return Err(EnvError::Option { option: "num_envs", value: count.to_string(), problem });
        }
        let place = |k: usize| {
            Mutex::new(Place { env: Env::new(arena.clone(), k as u64), is_over: true, next: None })
        };
        let shared = Arc::new(Shared {
            places: (0..count).map(place).collect(),
            output: Output::new(&arena, count, flat, autoreset),
            autoreset,
            threads: threads.min(count),
            jobs: Mutex::default(),
            there_are_jobs: Condvar::new(),
            done: Mutex::default(),
            something_is_done: Condvar::new(),
        });
        let phases = vec![Phase::Fresh; count];
        let at_work = vec![false; count];
        let (workers, process) = (Vec::new(), std::process::id());
        let mut own = Self { arena, shared, workers, process, at_work, phases, curriculum: None };
        for _ in 0..own.shared.threads {
            let shared = Arc::clone(&own.shared);
            let thread = std::thread::Builder::new().name("vertibench".into()).stack_size(STACK);
            own.workers.push(thread.spawn(move || shared.work()).map_err(EnvError::Thread)?);
        }
        Ok(own)
    }

    /// What the environments share.
    #[must_use]
    pub fn arena(&self) -> &Arc<Arena> {
        &self.arena
    }

    /// The number of environments.
    #[must_use]
    pub fn count(&self) -> usize {
        self.at_work.len()
    }

    /// When the next episode begins after one has ended.
    #[must_use]
    pub fn autoreset(&self) -> Autoreset {
        self.shared.autoreset
    }

    /// The arrays of all environments.
    #[must_use]
    pub fn output(&self) -> &Output {
        &self.shared.output
    }

    /// Lets a curriculum choose the tasks of episodes from now on, where [`Reset`] names none. It is told how episodes end when
    /// they are received, in the order of the environments' indices, and chooses an environment's next task when its episode has
    /// begun: so what it chooses doesn't depend on the threads as long as all environments are received together.
    ///
    /// # Errors
    /// Returns an error if the curriculum doesn't fit the tasks, and if an environment is at work.
    pub fn follow(&mut self, spec: &Spec, seed: u64) -> Result<(), EnvError> {
        if self.pending() > 0 {
            return Err(EnvError::Pending(self.pending()));
        }
        let (suite, tasks) = (self.arena.suite(), self.arena.tasks());
        self.curriculum = Some(Curriculum::new(spec, suite, tasks, self.count(), seed)?);
        self.choose(true);
        Ok(())
    }

    /// The curriculum that chooses the tasks.
    #[must_use]
    pub fn curriculum(&self) -> Option<&Curriculum> {
        self.curriculum.as_ref()
    }

    /// Tells the curriculum what a learner thinks of a task ([`Curriculum::score`]).
    ///
    /// # Errors
    /// Returns an error if there is no such task. Without a curriculum nothing happens.
    pub fn score(&mut self, task: &TaskId, score: f64) -> Result<(), EnvError> {
        let task = self.arena.find(task)?;
        if let Some(curriculum) = &mut self.curriculum {
            curriculum.score(task, score);
        }
        Ok(())
    }

    /// Lets the curriculum go on from what another one remembered, and choose the next tasks anew. What they would have been is
    /// forgotten, so whoever wants to go on exactly does this in the training that isn't interrupted, too.
    ///
    /// # Errors
    /// Returns an error, and changes nothing, if it doesn't fit, or an environment is at work.
    pub fn restore_curriculum(&mut self, state: &str) -> Result<(), EnvError> {
        if self.pending() > 0 {
            return Err(EnvError::Pending(self.pending()));
        }
        if let Some(curriculum) = &mut self.curriculum {
            curriculum.restore(state)?;
        }
        self.choose(true);
        Ok(())
    }

    /// Chooses the next task of environments that have none, or of all.
    fn choose(&mut self, anew: bool) {
        let Some(curriculum) = &mut self.curriculum else { return };
        for (index, place) in self.shared.places.iter().enumerate().filter(|(k, _)| !self.at_work[*k]) {
            let next = &mut lock(place).next;
            if anew || next.is_none() {
                *next = Some(self.arena.tasks()[curriculum.draw(index)].clone());
            }
        }
    }

    /// Tells the curriculum how episodes have ended, and lets it choose the next tasks.
    fn learn(&mut self, arrivals: &[Arrival]) -> Result<(), EnvError> {
        let Some(curriculum) = &mut self.curriculum else { return Ok(()) };
        let mut by_index: Vec<&Arrival> = arrivals.iter().collect();
        by_index.sort_by_key(|a| a.index);
        for (environment, record) in by_index.iter().filter_map(|a| Some((a.index, a.ended.as_ref()?))) {
            let task = self.arena.find(&record.task)?;
            curriculum.report(&Ending { environment, task, is_success: record.outcome == Outcome::Success });
        }
        self.choose(false);
        Ok(())
    }

    /// Begins episodes in these environments.
    ///
    /// # Errors
    /// Returns an error, and begins nothing, if there is no such environment or task, or one is at work or named twice.
    pub fn reset(&mut self, resets: Vec<(usize, Reset)>) -> Result<(), EnvError> {
        self.are_free(resets.iter().map(|(index, _)| *index))?;
        for (_, reset) in &resets {
            if let Some(task) = &reset.task {
                self.arena.find(task)?;
            }
        }
        self.hand_out(resets.into_iter().map(|(index, reset)| (index, Job::Reset(reset))));
        Ok(())
    }

    /// Steps these environments, with the numbers of their actions one after the other.
    ///
    /// # Errors
    /// Returns an error, and steps none, if there is no such environment, one is at work or named twice, was never reset, or has
    /// ended its episode without [`Autoreset`], or if an action isn't made of as many finite numbers as an action has.
    pub fn send(&mut self, indices: &[usize], actions: &[f64]) -> Result<(), EnvError> {
        let dimensions = self.arena.action().dimensions();
        if actions.len() != indices.len() * dimensions.len() {
            let names = dimensions.iter().map(|d| d.name).collect::<Vec<_>>().join(", ");
            let given = actions.len() / indices.len().max(1);
            return Err(EnvError::ActionLength { wanted: dimensions.len(), names, given });
        }
        if let Some(at) = actions.iter().position(|a| !a.is_finite()) {
            let index = at % dimensions.len();
            return Err(EnvError::Action { index, name: dimensions[index].name, value: actions[at] });
        }
        self.are_free(indices.iter().copied())?;
        for index in indices {
            match &self.phases[*index] {
                Phase::Fresh => return Err(EnvError::NoEpisode),
                Phase::Over(reason) if self.autoreset() == Autoreset::Disabled => {
                    return Err(EnvError::Ended(reason.clone()));
                }
                Phase::Driving | Phase::Over(_) => {}
            }
        }
        let jobs = indices.iter().zip(actions.chunks(dimensions.len()));
        self.hand_out(jobs.map(|(index, action)| (*index, Job::Step(action.to_vec()))));
        Ok(())
    }

    fn are_free(&self, indices: impl Iterator<Item = usize>) -> Result<(), EnvError> {
        let mut named = vec![false; self.count()];
        for index in indices {
            self.is_free(index)?;
            if std::mem::replace(&mut named[index], true) {
                return Err(EnvError::Twice(index));
            }
        }
        Ok(())
    }

    fn is_free(&self, index: usize) -> Result<(), EnvError> {
        match self.at_work.get(index) {
            None => Err(EnvError::NoEnv { index, count: self.count() }),
            Some(true) => Err(EnvError::Pending(self.pending())),
            Some(false) => Ok(()),
        }
    }

    /// The number of environments that are at work.
    #[must_use]
    pub fn pending(&self) -> usize {
        self.at_work.iter().filter(|w| **w).count()
    }

    fn hand_out(&mut self, jobs: impl Iterator<Item = (usize, Job)>) {
        let mut jobs: Vec<_> = jobs.collect();
        // What takes longest comes first, so that no thread is still at it when the others have nothing left to do.
        jobs.sort_by_cached_key(|(index, _)| std::cmp::Reverse(lock(&self.shared.places[*index]).effort()));
        let mut queue = lock(&self.shared.jobs);
        for (index, job) in jobs {
            self.at_work[index] = true;
            queue.waiting.push_back((index, job));
        }
        let workers = queue.waiting.len().min(self.shared.threads - 1).max(1);
        drop(queue);
        // One fewer than there are, since this thread may do the work of one. If it doesn't, they wake the last.
        for _ in 0..workers {
            self.shared.there_are_jobs.notify_one();
        }
    }

    /// Waits until `count` environments are done, and returns them in the order in which they came. `wants_more` is asked every
    /// 50 ms, or once the environment is done that this thread is at; if it says no, `None` is returned, and what is done can be
    /// received later.
    ///
    /// A thread that waits for all that is at work takes the place of a worker meanwhile: it has a processor already, on which a
    /// worker would have to be woken.
    ///
    /// # Errors
    /// Returns an error if so many aren't at work, and the first error of an environment. The curriculum has been told of the others
    /// then.
    pub fn receive(
        &mut self,
        count: usize,
        wants_more: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Vec<Arrival>>, EnvError> {
        let pending = self.pending();
        if count == 0 || pending < count {
            return Err(if pending == 0 { EnvError::Nothing } else { EnvError::Pending(pending) });
        }
        let mut asked = now();
        let taken = loop {
            let mut done = lock(&self.shared.done);
            if done.len() >= count {
                break done.drain(..count).collect::<Vec<_>>();
            }
            drop(done);
            if asked.elapsed() >= LOOK {
                if !wants_more() {
                    // A worker may have left its place to this thread.
                    self.shared.there_are_jobs.notify_all();
                    return Ok(None);
                }
                asked = now();
            }
            let waits_for_all = count == pending;
            if !(waits_for_all && self.shared.help()) {
                self.shared.wait_for(count);
            }
        };
        for (index, arrival) in &taken {
            self.at_work[*index] = false;
            match arrival {
                Ok(Arrival { began: Some(_), .. }) => self.phases[*index] = Phase::Driving,
                Ok(Arrival { ended: Some(record), .. }) => {
                    self.phases[*index] = Phase::Over(record.reason.clone());
                }
                Ok(_) | Err(_) => {}
            }
        }
        let (mut arrivals, mut failed) = (Vec::with_capacity(count), None);
        for (_, arrival) in taken {
            match arrival {
                Ok(arrival) => arrivals.push(arrival),
                Err(e) => failed = failed.or(Some(e)),
            }
        }
        self.learn(&arrivals)?;
        failed.map_or(Ok(Some(arrivals)), Err)
    }

    /// Looks at an environment.
    ///
    /// # Errors
    /// Returns an error if there is no such environment, or it is at work.
    pub fn with<T>(&self, index: usize, look: impl FnOnce(&mut Env) -> T) -> Result<T, EnvError> {
        self.is_free(index)?;
        Ok(look(&mut lock(&self.shared.places[index]).env))
    }
}

impl Drop for VectorEnv {
    fn drop(&mut self) {
        if std::process::id() != self.process {
            // A fork has none of the threads, and its locks are as they were left.
            self.workers.drain(..).for_each(std::mem::forget);
            return;
        }
        let mut jobs = lock(&self.shared.jobs);
        jobs.stop = true;
        jobs.waiting.clear();
        drop(jobs);
        self.shared.there_are_jobs.notify_all();
        for worker in self.workers.drain(..) {
            // A worker catches the panics of its jobs, and its own would have been told as an error.
            let _ = worker.join();
        }
    }
}

impl Shared {
    /// Does jobs until there is an end.
    fn work(&self) {
        let mut jobs = lock(&self.jobs);
        while !jobs.stop {
            if let Some((index, job)) = jobs.take(self.threads) {
                let is_room = jobs.running < self.threads && !jobs.waiting.is_empty();
                drop(jobs);
                if is_room {
                    self.there_are_jobs.notify_one();
                }
                self.finish(index, &job);
                jobs = lock(&self.jobs);
                jobs.running -= 1;
            } else {
                jobs = self.there_are_jobs.wait(jobs).unwrap_or_else(PoisonError::into_inner);
            }
        }
    }

    /// Does one job in place of a worker, if one waits and fewer than all threads are at work; tells whether it did.
    fn help(&self) -> bool {
        let next = lock(&self.jobs).take(self.threads);
        let Some((index, job)) = next else { return false };
        self.finish(index, &job);
        lock(&self.jobs).running -= 1;
        true
    }

    /// Does a job that was taken.
    fn finish(&self, index: usize, job: &Job) {
        let arrival = guarded(|| self.job(index, job));
        lock(&self.done).push_back((index, arrival));
        self.something_is_done.notify_one();
    }

    /// Waits until another job is done, unless `count` are, but not for long.
    fn wait_for(&self, count: usize) {
        let done = lock(&self.done);
        if done.len() < count {
            let waited = self.something_is_done.wait_timeout(done, LOOK);
            drop(waited.unwrap_or_else(PoisonError::into_inner));
        }
    }

    fn job(&self, index: usize, job: &Job) -> Result<Arrival, EnvError> {
        let mut place = lock(&self.places[index]);
        let Place { env, is_over, next } = &mut *place;
        let mut step = Step::default();
        let mut ended = None;
        let reset = match job {
            Job::Reset(reset) => Some(reset.clone()),
            Job::Step(_) if *is_over && self.autoreset == Autoreset::NextStep => Some(Reset::default()),
            Job::Step(action) => {
                step = env.step(action)?;
                let is_last = step.terminated || step.truncated;
                *is_over = is_last;
                ended = env.record().filter(|_| is_last).cloned().map(Box::new);
                (is_last && self.autoreset == Autoreset::SameStep).then(Reset::default)
            }
        };
        let mut began = None;
        if let Some(mut reset) = reset {
            if reset.task.is_none() {
                reset.task = next.take();
            }
            if ended.is_some() {
                // SAFETY: this thread has the job of this index.
                unsafe { self.output.observe_last(index, env) };
            }
            env.reset(&reset)?;
            *is_over = env.record().is_some();
            began = env.task().cloned().zip(env.run_seed());
        }
        // SAFETY: this thread has the job of this index.
        unsafe {
            self.output.observe(index, env);
            self.output.write(index, &step);
        }
        Ok(Arrival { index, began, ended })
    }
}
