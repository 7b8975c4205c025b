//! The vector environment.

use std::sync::{Mutex, TryLockError};

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vb_env::curriculum::{Curriculum, Spec};
use vb_env::{Arrival, Autoreset, EnvError, Pointer, Reset};
use vb_world::TaskId;

use crate::arena::Arena;
use crate::arrays::over;
use crate::env::{Snapshot, record_json};
use crate::errors;

/// Task name and seed of the sensor noise of a new episode.
type Began = Option<(String, u64)>;

/// Many environments, stepped on several threads.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct VectorEnv {
    inner: Mutex<vb_env::VectorEnv>,
    /// Process of the threads.
    process: u32,
    flat: bool,
}

impl VectorEnv {
    /// Calls a function on the environments, without Python's lock.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut vb_env::VectorEnv) -> Result<T, EnvError> + Send,
    ) -> PyResult<T> {
        if std::process::id() != self.process {
            let what = "the vector environment was made in another process, whose threads a fork doesn't have: make it in the \
                        process that uses it, or start processes by spawn";
            return Err(errors::named(py, "EpisodeError", what));
        }
        let done = errors::guarded(py, || match self.inner.try_lock() {
            Ok(mut env) => work(&mut env).map(Some),
            Err(TryLockError::Poisoned(env)) => work(&mut env.into_inner()).map(Some),
            Err(TryLockError::WouldBlock) => Ok(None),
        })?;
        done.ok_or_else(|| {
            let what = "another thread is using the vector environment: use it from one thread at a time";
            errors::named(py, "EpisodeError", what)
        })
    }
}

#[pymethods]
impl VectorEnv {
    #[new]
    fn new(
        py: Python<'_>,
        arena: &Arena,
        count: usize,
        threads: usize,
        autoreset: &str,
        flat: bool,
    ) -> PyResult<Self> {
        let autoreset = match autoreset {
            "next_step" => Autoreset::NextStep,
            "same_step" => Autoreset::SameStep,
            _ => Autoreset::Disabled,
        };
        let inner = vb_env::VectorEnv::new(arena.inner.clone(), count, threads, autoreset, flat);
        let inner = Mutex::new(inner.map_err(|e| errors::exception(py, &e))?);
        Ok(Self { inner, process: std::process::id(), flat })
    }

    /// Returns arrays over the memory that the threads write: `observations` (a list in the order of the parts, or with the flat
    /// array only), `finals` (in the same form, or empty), `rewards`, `terms`, `terminated` and `truncated`. A row is valid from
    /// the reception of its environment until its next step or reset.
    fn arrays<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (py, own) = (slf.py(), slf.get());
        let env = vb_files::lock(&own.inner);
        let (count, output, owner) = (env.count(), env.output(), slf.as_any());
        // SAFETY: the memory belongs to the environment, which the arrays keep alive, has a row of the right width for each
        // environment, and never moves. The package hands out rows of environments that aren't at work.
        let array =
            |pointer: Pointer, shape: &[usize]| unsafe { over(pointer, &[&[count], shape].concat(), owner) };
        let observations = |pointers: Vec<Pointer>| -> Vec<Bound<'py, PyAny>> {
            let layout = env.arena().layout();
            if own.flat {
                return pointers.into_iter().map(|p| array(p, &[layout.flat_width()])).collect();
            }
            pointers.into_iter().zip(layout.parts()).map(|(p, part)| array(p, &part.shape)).collect()
        };
        let all = PyDict::new(py);
        all.set_item("observations", observations(output.observations()))?;
        all.set_item("finals", observations(output.finals()))?;
        all.set_item("rewards", array(output.rewards(), &[]))?;
        all.set_item("terms", array(output.terms(), &[vb_env::TERMS.len()]))?;
        all.set_item("terminated", array(output.terminated(), &[]))?;
        all.set_item("truncated", array(output.truncated(), &[]))?;
        Ok(all)
    }

    /// Lets a curriculum, given by name or file, choose the tasks.
    fn follow(&self, py: Python<'_>, curriculum: &str, seed: u64) -> PyResult<()> {
        self.with(py, |env| env.follow(&Spec::resolve(curriculum)?, seed))
    }

    /// Returns the state of the curriculum as text; None without a curriculum.
    fn curriculum_state(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.with(py, |env| Ok(env.curriculum().map(Curriculum::state)))
    }

    /// Restores a state of the curriculum.
    fn restore_curriculum(&self, py: Python<'_>, state: &str) -> PyResult<()> {
        self.with(py, |env| env.restore_curriculum(state))
    }

    /// Returns each task's probability to be chosen next, and each environment's stage; None without a curriculum.
    fn curriculum(&self, py: Python<'_>) -> PyResult<Option<(Vec<f64>, Vec<usize>)>> {
        self.with(py, |env| Ok(env.curriculum().map(|c| (c.chances(), c.stages()))))
    }

    /// Reports the learner's score of a task to the curriculum.
    fn score(&self, py: Python<'_>, task: &str, score: f64) -> PyResult<()> {
        self.with(py, |env| env.score(&task.parse()?, score))
    }

    /// Begins episodes; each entry is (index, seed or None, task or None, seed of the sensor noise or None).
    #[allow(clippy::type_complexity, reason = "a tuple of Python")]
    fn reset(
        &self,
        py: Python<'_>,
        resets: Vec<(usize, Option<u64>, Option<String>, Option<u64>)>,
    ) -> PyResult<()> {
        self.with(py, |env| {
            let reset = |(k, seed, task, run_seed): (_, _, Option<String>, _)| {
                Ok((k, Reset { seed, task: task.map(TaskId::try_from).transpose()?, run_seed }))
            };
            env.reset(resets.into_iter().map(reset).collect::<Result<_, EnvError>>()?)
        })
    }

    /// Begins a step of the environments with these indices, with one row of `actions` each.
    fn send(
        &self,
        py: Python<'_>,
        indices: PyReadonlyArray1<'_, i64>,
        actions: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let indices: Vec<i64> = indices.as_array().iter().copied().collect();
        let actions: Vec<f64> = actions.as_array().iter().copied().collect();
        self.with(py, |env| {
            let count = env.count();
            let index = |k: i64| usize::try_from(k).map_err(|_| EnvError::NoEnv { index: usize::MAX, count });
            let indices = indices.into_iter().map(index).collect::<Result<Vec<_>, _>>()?;
            env.send(&indices, &actions)
        })
    }

    /// Waits for the results of `count` environments. Each, in order of arrival, is (index, task and seed of the sensor noise if an
    /// episode has begun, record as JSON if one has ended).
    fn receive(&self, py: Python<'_>, count: usize) -> PyResult<Vec<(usize, Began, Option<String>)>> {
        let arrivals = loop {
            // Waits in short intervals, so that signals are handled in between.
            match self.with(py, |env| env.receive(count, &mut || false))? {
                Some(arrivals) => break arrivals,
                None => py.check_signals()?,
            }
        };
        let arrival = |a: Arrival| {
            let record = a.ended.map(|r| record_json(&r));
            (a.index, a.began.map(|(task, seed)| (task.to_string(), seed)), record)
        };
        Ok(arrivals.into_iter().map(arrival).collect())
    }

    /// Returns the number of busy environments.
    fn pending(&self, py: Python<'_>) -> PyResult<usize> {
        self.with(py, |env| Ok(env.pending()))
    }

    /// Saves the state of one environment.
    fn snapshot(&self, py: Python<'_>, index: usize) -> PyResult<Snapshot> {
        let inner = self.with(py, |env| env.with(index, |env| env.snapshot()))?;
        Ok(Snapshot { inner })
    }
}
