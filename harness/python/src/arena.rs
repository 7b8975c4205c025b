//! Settings that environments share.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vb_catalog::Catalog;
use vb_env::{Column, EnvError, Frame, Options, Reward};
use vb_sdk::policy::{ActionKind, Dtype, Sight};

use crate::arrays::copied;
use crate::errors;

/// Settings that environments share: tasks, vehicle, observation, action and reward.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct Arena {
    pub(crate) inner: Arc<vb_env::Arena>,
}

/// A reward argument: name or file, or weights by term.
#[derive(FromPyObject)]
enum Wanted {
    Named(String),
    Weights(BTreeMap<String, f64>),
}

#[pymethods]
impl Arena {
    #[new]
    #[pyo3(signature = (*, tasks_dir, suite, tasks, worlds, world_seed, apart_from, vehicle, soils, perception, rules, scale,
        control_hz, time_step, observation, sight, action, speed_range, reward))]
    #[allow(clippy::too_many_arguments, reason = "each is an option of its own, given by its name")]
    fn new(
        py: Python<'_>,
        tasks_dir: PathBuf,
        suite: Option<PathBuf>,
        tasks: Option<String>,
        worlds: u32,
        world_seed: u64,
        apart_from: Vec<PathBuf>,
        vehicle: String,
        soils: String,
        perception: String,
        rules: String,
        scale: Option<f64>,
        control_hz: f64,
        time_step: f64,
        observation: Vec<String>,
        sight: BTreeMap<String, f64>,
        action: &str,
        speed_range: (f64, f64),
        reward: Wanted,
    ) -> PyResult<Self> {
        let raise = |e: EnvError| errors::exception(py, &e);
        let wrong =
            |option, value: String, problem: String| raise(EnvError::Option { option, value, problem });
        let action = match action {
            "speed" => ActionKind::Speed { slowest: speed_range.0, fastest: speed_range.1 },
            "rate" => ActionKind::Rate { slowest: speed_range.0, fastest: speed_range.1 },
            "pedals" => ActionKind::Pedals,
            other => return Err(wrong("action", other.to_owned(), "must be speed, rate or pedals".into())),
        };
        let mut seen = Sight::default();
        for (name, value) in sight {
            match name.as_str() {
                // A value that is no whole number becomes a count out of range.
                "cells" => seen.cells = value as usize,
                "points" => seen.points = value as usize,
                "resolution" => seen.resolution = value,
                "ahead" => seen.ahead = value,
                "spacing" => seen.spacing = value,
                _ => {
                    let known = "there are cells, resolution, ahead, points and spacing";
                    return Err(wrong("sight", name, known.into()));
                }
            }
        }
        let reward = match reward {
            Wanted::Named(name) => Reward::resolve(&name),
            Wanted::Weights(weights) => Reward::new("given", weights).map_err(|e| e.of("reward", "reward")),
        };
        let options = Options {
            suite,
            tasks,
            worlds,
            world_seed,
            apart_from,
            vehicle,
            soils,
            perception,
            rules,
            scale,
            control_hz,
            time_step,
            observation,
            sight: seen,
            action,
            reward: reward.map_err(|e| raise(e.into()))?,
        };
        // Generating worlds takes a while: on a thread, so that Ctrl-C ends the waiting.
        let (sender, mut receiver) = mpsc::channel();
        let made = std::thread::Builder::new().stack_size(16 << 20).spawn(move || {
            let arena = vb_env::Arena::new(&Catalog::at(tasks_dir), options, &mut || {});
            // There is no receiver if the waiting was ended.
            let _ = sender.send(arena);
        });
        made.map_err(|e| raise(EnvError::Thread(e)))?;
        loop {
            let waiting = &mut receiver;
            match py.detach(move || waiting.recv_timeout(Duration::from_millis(50))) {
                Ok(arena) => return arena.map(|a| Self { inner: Arc::new(a) }).map_err(raise),
                Err(mpsc::RecvTimeoutError::Timeout) => py.check_signals()?,
                Err(mpsc::RecvTimeoutError::Disconnected) => {
                    return Err(raise(EnvError::Panic("while the arena was made".into())));
                }
            }
        }
    }

    /// Returns the parts of an observation: dictionaries with `name`, `about` (description), `is_crop`, `dtype`, `shape`, and along
    /// the innermost axis `names`, `units`, `low`, `high` and `usual` (normalisation scales).
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let part = |p: &vb_sdk::policy::Part| {
            let all = PyDict::new(py);
            all.set_item("name", p.name)?;
            all.set_item("about", p.about)?;
            all.set_item("is_crop", p.is_crop())?;
            all.set_item("dtype", if p.dtype == Dtype::F32 { "float32" } else { "uint8" })?;
            all.set_item("shape", p.shape.clone())?;
            let of = |f: fn(&vb_sdk::policy::Entry) -> f64| p.entries.iter().map(f).collect::<Vec<_>>();
            all.set_item("names", p.entries.iter().map(|e| e.name).collect::<Vec<_>>())?;
            all.set_item("units", p.entries.iter().map(|e| e.unit).collect::<Vec<_>>())?;
            all.set_item("low", of(|e| e.low))?;
            all.set_item("high", of(|e| e.high))?;
            all.set_item("usual", of(|e| e.usual))?;
            Ok(all)
        };
        self.inner.layout().parts().iter().map(part).collect()
    }

    /// Number of entries of a flat observation.
    #[getter]
    fn flat_width(&self) -> usize {
        self.inner.layout().flat_width()
    }

    /// Maximum absolute value of an entry of a flat observation.
    #[getter]
    fn flat_bound(&self) -> f32 {
        vb_sdk::policy::Layout::FLAT_BOUND
    }

    /// Returns the entries of an action, as (name, minimum, maximum, description).
    fn action(&self) -> Vec<(&'static str, f64, f64, &'static str)> {
        let dimensions = self.inner.action().dimensions();
        dimensions.iter().map(|d| (d.name, d.low, d.high, d.about)).collect()
    }

    /// Returns the weights of the reward, by term.
    fn weights(&self) -> BTreeMap<&'static str, f64> {
        vb_env::TERMS.iter().map(|t| t.name).zip(self.inner.reward().weights).collect()
    }

    /// Returns the observations of a policy in a recorded drive of a task: an array per part, with a row per frame. `states` has
    /// the 15 entries of a dataset's `observation.state`, shape (frames, 15). `commands` has steering, throttle and brake that were
    /// applied until the frame, shape (frames, 3). Raises `OptionError` for other shapes, `UnknownError` for an unknown task.
    fn recall<'py>(
        &self,
        py: Python<'py>,
        task: &str,
        states: PyReadonlyArray2<'_, f64>,
        commands: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let (states, commands) = (states.as_array(), commands.as_array());
        let count = states.nrows();
        if states.ncols() != 15 || commands.shape() != [count, 3] {
            let what = "a drive has 15 entries of the state and 3 of the command in each frame";
            return Err(errors::named(py, "OptionError", what));
        }
        let frame = |k: usize| Frame {
            state: std::array::from_fn(|i| states[[k, i]]),
            command: std::array::from_fn(|i| commands[[k, i]]),
        };
        let frames: Vec<Frame> = (0..count).map(frame).collect();
        let columns = errors::guarded(py, || self.inner.recall(&task.parse()?, &frames))?;
        let array = |(column, part): (&Column, &vb_sdk::policy::Part)| {
            let shape = [&[count], &part.shape[..]].concat();
            match column {
                Column::F32(numbers) => copied(py, numbers, &shape),
                Column::U8(labels) => copied(py, labels, &shape),
            }
        };
        columns.iter().zip(self.inner.layout().parts()).map(array).collect()
    }

    /// Folder of the tasks' suite.
    #[getter]
    fn suite(&self) -> PathBuf {
        self.inner.suite().dir().to_owned()
    }

    /// Returns the names of the tasks, in the order of the suite.
    fn tasks(&self) -> Vec<String> {
        self.inner.tasks().iter().map(ToString::to_string).collect()
    }

    /// Simulated time between two actions, s.
    #[getter]
    fn control_period(&self) -> f64 {
        self.inner.control_period()
    }
}
