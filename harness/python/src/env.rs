//! The single environment.

use std::sync::{Mutex, MutexGuard};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use vb_env::{EnvError, Reset, Size, Terms, View};
use vb_files::lock;
use vb_score::TaskRecord;
use vb_sdk::policy::{Dtype, Row};
use vb_world::TaskId;

use crate::arena::Arena;
use crate::arrays::copied;
use crate::errors;

/// Returns a record as JSON.
pub(crate) fn record_json(record: &TaskRecord) -> String {
    serde_json::to_string(record).expect("a record has text keys and can be written as JSON")
}

/// A single environment with at most one episode at a time.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct Env {
    inner: Mutex<vb_env::Env>,
}

/// Saved state of an environment.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct Snapshot {
    pub(crate) inner: vb_env::Snapshot,
}

#[pymethods]
impl Snapshot {
    /// Returns the snapshot for another process: task, seed and all actions.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = errors::guarded(py, || self.inner.to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }
}

impl Env {
    /// Locks the environment. Release it before creating Python objects: that may switch to another Python thread, which would
    /// wait for this lock and never release Python's.
    fn lock(&self) -> MutexGuard<'_, vb_env::Env> {
        lock(&self.inner)
    }
}

#[pymethods]
impl Env {
    #[new]
    fn new(arena: &Arena, seed: u64) -> Self {
        Self { inner: Mutex::new(vb_env::Env::new(arena.inner.clone(), seed)) }
    }

    /// Begins an episode. `seed` determines tasks and sensor noise from now on (None: continues); `task` and `run_seed` (the seed
    /// of the sensor noise) are sampled if None. Raises `UnknownError` for an unknown task.
    #[pyo3(signature = (seed=None, task=None, run_seed=None))]
    fn reset(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        task: Option<String>,
        run_seed: Option<u64>,
    ) -> PyResult<()> {
        errors::guarded(py, || {
            let task = task.map(TaskId::try_from).transpose()?;
            self.lock().reset(&Reset { seed, task, run_seed })
        })
    }

    /// Simulates one action; returns the reward, the values of its terms, and whether the episode has terminated or was truncated.
    /// Raises `ActionError` for a wrong length or a number that is not finite, `EpisodeError` without a running episode.
    fn step(&self, py: Python<'_>, action: Vec<f64>) -> PyResult<(f64, Terms, bool, bool)> {
        let step = errors::guarded(py, || self.lock().step(&action))?;
        Ok((step.reward, step.terms, step.terminated, step.truncated))
    }

    /// Returns the parts of the observation as new arrays, in order.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let arena = self.lock().arena().clone();
        let part = |(k, part): (usize, &vb_sdk::policy::Part)| match part.dtype {
            Dtype::F32 => {
                let mut to = vec![0f32; part.width()];
                self.lock().observe(k, Row::F32(&mut to));
                copied(py, &to, &part.shape)
            }
            Dtype::U8 => {
                let mut to = vec![0u8; part.width()];
                self.lock().observe(k, Row::U8(&mut to));
                copied(py, &to, &part.shape)
            }
        };
        arena.layout().parts().iter().enumerate().map(part).collect()
    }

    /// Returns the flat observation as a new array.
    fn observe_flat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let to = {
            let env = self.lock();
            let mut to = vec![0f32; env.arena().layout().flat_width()];
            env.observe_flat(&mut to);
            to
        };
        copied(py, &to, &[to.len()])
    }

    /// Returns the task name and the seed of the sensor noise; None without an episode.
    fn episode(&self) -> Option<(String, u64)> {
        let env = self.lock();
        Some((env.task()?.to_string(), env.run_seed()?))
    }

    /// Returns the record of an ended episode as JSON; otherwise None.
    fn record(&self) -> Option<String> {
        self.lock().record().map(record_json)
    }

    /// Saves the state of the environment.
    fn snapshot(&self, py: Python<'_>) -> Snapshot {
        Snapshot { inner: py.detach(|| self.lock().snapshot()) }
    }

    /// Restores a state. Raises `OptionError` if it is from an environment with other options.
    fn restore(&self, py: Python<'_>, snapshot: &Snapshot) -> PyResult<()> {
        errors::guarded(py, || self.lock().restore(&snapshot.inner))
    }

    /// Restores the bytes of a snapshot by repeating its actions. Raises `OptionError` if they are invalid or from other options.
    fn restore_from(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        errors::guarded(py, || self.lock().restore_from(bytes))
    }

    /// Returns the true state of the vehicle as a dictionary; None without an episode.
    fn vehicle<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(state) = self.lock().vehicle() else { return Ok(None) };
        let all = PyDict::new(py);
        let (roll, pitch, yaw) = state.roll_pitch_yaw();
        let three = |v: [f64; 3]| copied(py, &v, &[3]);
        all.set_item("time", state.time)?;
        all.set_item("position", three(state.position.into())?)?;
        all.set_item("attitude", three([roll, pitch, yaw])?)?;
        all.set_item("velocity", three(state.velocity_body.into())?)?;
        all.set_item("angular_velocity", three(state.angular_velocity_body.into())?)?;
        all.set_item("steering", state.steering)?;
        all.set_item("engine_speed", state.engine_speed)?;
        let wheels: Vec<f64> =
            state.wheels.iter().flat_map(|w| [w.speed, w.deflection, w.load, w.sinkage]).collect();
        all.set_item("wheels", copied(py, &wheels, &[state.wheels.len(), 4])?)?;
        Ok(Some(all))
    }

    /// Returns name, start (x, y, heading), goal (x, y), goal radius, time limit and path points (n, 2) of the task, in m, rad
    /// and s; None without an episode.
    fn task<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(brief) = self.lock().brief().cloned() else { return Ok(None) };
        let all = PyDict::new(py);
        all.set_item("name", &brief.id)?;
        all.set_item("start", (brief.start.x, brief.start.y, brief.start.yaw))?;
        all.set_item("goal", (brief.goal.x, brief.goal.y))?;
        all.set_item("goal_radius", brief.goal_radius)?;
        all.set_item("time_limit", brief.time_limit)?;
        let points: Vec<f64> = brief.path.iter().flat_map(|p| [p.x, p.y]).collect();
        all.set_item("path", copied(py, &points, &[brief.path.len(), 2])?)?;
        Ok(Some(all))
    }

    /// Renders the episode from the camera `chase` or `top`: an image of shape (height, width, 3), uint8.
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: &str,
        width: u32,
        height: u32,
    ) -> PyResult<Bound<'py, PyAny>> {
        let view = if camera == "top" { View::Top { window: None } } else { View::Chase };
        let picture = errors::guarded(py, || self.lock().picture(view, Size { width, height }))?;
        copied(py, &picture, &[height as usize, width as usize, 3])
    }

    /// Raises `EpisodeError` if there is no episode.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        let is_there = self.lock().task().is_some();
        if is_there { Ok(()) } else { Err(errors::exception(py, &EnvError::NoEpisode)) }
    }
}
