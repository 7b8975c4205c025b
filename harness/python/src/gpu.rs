//! Fleets on a GPU, and their GPU arrays, which other libraries access through DLPack.

use std::ffi::c_void;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use dlpark::ffi::{DLDataType, DLDevice, DLManagedTensor, DLManagedTensorVersioned};
use dlpark::metadata::Fixed;
use dlpark::python::{DlpackExporter, ExportRequest, export_dlpack};
use dlpark::{DlpackElement as _, DlpackFlags, Managed, ManagedTensorBase};
use pyo3::exceptions::PyBufferError;
use pyo3::prelude::*;
use vb_catalog::Catalog;
use vb_gpu::{Course, CourseError, GpuError, Options, STATE};

use crate::arrays::copied;
use crate::errors;

/// Reason why a fleet can't be created or can't continue.
#[derive(Debug)]
enum FleetError {
    Course(CourseError),
    Gpu(GpuError),
}

impl FleetError {
    fn exception(&self, py: Python<'_>) -> PyErr {
        match self {
            Self::Course(e) => errors::named(py, "OptionError", &e.to_string()),
            Self::Gpu(e @ (GpuError::Empty | GpuError::Length { .. } | GpuError::Task { .. })) => {
                errors::named(py, "OptionError", &e.to_string())
            }
            Self::Gpu(e) => errors::named(py, "GpuError", &e.to_string()),
        }
    }
}

/// Calls a function without Python's lock.
fn work<T: Send>(py: Python<'_>, of: impl FnOnce() -> Result<T, FleetError> + Send) -> PyResult<T> {
    errors::guarded(py, || Ok(of()))?.map_err(|e| e.exception(py))
}

/// Vehicles on a GPU that one call steps together.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct Fleet {
    inner: Arc<Mutex<vb_gpu::Fleet>>,
    course: Course,
    vehicles: usize,
    device: usize,
}

impl Fleet {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        of: impl FnOnce(&mut vb_gpu::Fleet) -> Result<T, GpuError> + Send,
    ) -> PyResult<T> {
        let fleet = || vb_files::lock(&self.inner);
        work(py, || of(&mut fleet()).map_err(FleetError::Gpu))
    }

    fn array(&self, at: u64, columns: Option<usize>, kind: DLDataType) -> Array {
        Array { fleet: self.inner.clone(), at, rows: self.vehicles, columns, kind, device: self.device }
    }
}

#[pymethods]
impl Fleet {
    #[new]
    #[pyo3(signature = (*, tasks_dir, kernel, suite, tasks, vehicle, time_step, vehicles, device, spare_memory))]
    #[allow(clippy::too_many_arguments, reason = "each is an option of its own, given by its name")]
    fn new(
        py: Python<'_>,
        tasks_dir: PathBuf,
        kernel: PathBuf,
        suite: PathBuf,
        tasks: Option<String>,
        vehicle: String,
        time_step: f64,
        vehicles: usize,
        device: usize,
        spare_memory: Option<u64>,
    ) -> PyResult<Self> {
        let (course, fleet) = work(py, || {
            let catalog = Catalog::at(tasks_dir);
            let course = Course::new(&catalog, &suite, tasks.as_deref(), &vehicle, time_step);
            let course = course.map_err(FleetError::Course)?;
            let options = Options { device, spare_memory, ..Options::default() };
            let fleet = vb_gpu::Fleet::new(&kernel, &course.sent(), &course.starts(), vehicles, options);
            Ok((course, fleet.map_err(FleetError::Gpu)?))
        })?;
        Ok(Self { inner: Arc::new(Mutex::new(fleet)), course, vehicles, device })
    }

    /// Returns the names of the tasks.
    fn tasks(&self) -> Vec<String> {
        self.course.names()
    }

    /// Returns the starts of the tasks: x (m), y (m), heading (rad); shape (tasks, 3).
    fn starts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = |start: vb_world::Pose2| [start.x, start.y, start.yaw];
        let rows: Vec<_> = self.course.tasks.iter().map(|(_, task)| of(task.start)).collect();
        copied(py, rows.as_flattened(), &[rows.len(), 3])
    }

    /// Returns the goals of the tasks: x (m), y (m); shape (tasks, 2).
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows: Vec<_> = self.course.tasks.iter().map(|(_, task)| task.goal).collect();
        copied(py, rows.as_flattened(), &[rows.len(), 2])
    }

    /// Returns the number of each task's world.
    fn worlds(&self) -> Vec<usize> {
        self.course.tasks.iter().map(|(world, _)| *world).collect()
    }

    /// Returns the heights of a world's nodes and the distance between nodes, m; None if there is no such world.
    fn ground<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Option<(Bound<'py, PyAny>, f64)>> {
        let Some(world) = self.course.worlds.get(world) else { return Ok(None) };
        let ground = &world.heightfield;
        let heights = copied(py, ground.heights(), &[ground.rows(), ground.cols()])?;
        Ok(Some((heights, ground.resolution())))
    }

    /// Returns the simulation time step, s.
    fn time_step(&self) -> f64 {
        self.course.setting.options.step
    }

    /// Lets each vehicle begin the task with this number; vehicles with negative numbers continue. None: uses the array `resets`.
    #[pyo3(signature = (tasks=None))]
    fn reset(&self, py: Python<'_>, tasks: Option<Vec<i64>>) -> PyResult<()> {
        let tasks = tasks.map(|tasks| tasks.into_iter().map(|task| usize::try_from(task).ok()).collect());
        self.with(py, |fleet| match tasks {
            Some::<Vec<_>>(tasks) => fleet.reset(&tasks),
            None => fleet.reset_as_told(),
        })
    }

    /// Simulates all vehicles for a number of time steps.
    fn advance(&self, py: Python<'_>, steps: u64) -> PyResult<()> {
        self.with(py, |fleet| fleet.advance(steps))
    }

    /// Compares the first vehicles with the CPU over a simulated time, s; returns the number of compared vehicles.
    fn verify(&self, py: Python<'_>, vehicles: usize, seconds: f64) -> PyResult<usize> {
        self.with(py, |fleet| fleet.verify(&self.course, vehicles, seconds))
    }

    /// Returns the hash of each vehicle's states since its start.
    fn hashes(&self, py: Python<'_>) -> PyResult<Vec<u64>> {
        self.with(py, |fleet| fleet.hashes())
    }

    /// Returns the arrays on the GPU: states, controls, resets and faults.
    fn arrays(&self, py: Python<'_>) -> PyResult<[Array; 4]> {
        let at = self.with(py, |fleet| Ok(fleet.arrays()))?;
        Ok([
            self.array(at.states, Some(STATE.len()), f64::DTYPE),
            self.array(at.controls, Some(4), f64::DTYPE),
            self.array(at.resets, None, i32::DTYPE),
            // Few libraries support unsigned numbers; fault numbers are small.
            self.array(at.faults, None, i32::DTYPE),
        ])
    }
}

/// Array in the fleet's own GPU memory, for `from_dlpack` of other libraries. It keeps the memory alive.
#[pyclass(frozen, module = "vertibench._native")]
pub(crate) struct Array {
    fleet: Arc<Mutex<vb_gpu::Fleet>>,
    at: u64,
    rows: usize,
    columns: Option<usize>,
    kind: DLDataType,
    device: usize,
}

impl Array {
    fn tensor<M: ManagedTensorBase>(&self) -> PyResult<Managed<M>> {
        let rows = self.rows as i64;
        match self.columns.map(|columns| columns as i64) {
            Some(columns) => self.shaped([rows, columns], [columns, 1]),
            None => self.shaped([rows], [1]),
        }
    }

    fn shaped<M: ManagedTensorBase, const N: usize>(
        &self,
        shape: [i64; N],
        strides: [i64; N],
    ) -> PyResult<Managed<M>> {
        let keeper = Box::new(self.fleet.clone());
        let made = Fixed::new(shape, strides).initialize_as::<M>(keeper);
        let mut made = made.map_err(|e| PyBufferError::new_err(e.to_string()))?;
        let tensor = made.tensor_mut();
        tensor.data = self.at as *mut c_void;
        tensor.device = self.device();
        tensor.dtype = self.kind;
        // SAFETY: the memory has as many numbers as the shape says, never moves, and lives as long as the fleet, which the
        // tensor keeps.
        Ok(unsafe { made.finish() })
    }
}

impl DlpackExporter for Array {
    fn device(&self) -> DLDevice {
        DLDevice::cuda(i32::try_from(self.device).unwrap_or(i32::MAX))
    }

    fn flags(&self) -> DlpackFlags {
        DlpackFlags::empty()
    }

    /// Does nothing: when a method of the fleet has returned, the GPU has finished its work.
    fn prepare_export(&self, _: Python<'_>, _: &ExportRequest<'_>) -> PyResult<()> {
        Ok(())
    }

    fn export_legacy(&self, _: Python<'_>) -> PyResult<Managed<DLManagedTensor>> {
        self.tensor()
    }

    fn export_versioned(&self, _: Python<'_>) -> PyResult<Managed<DLManagedTensorVersioned>> {
        self.tensor()
    }
}

#[pymethods]
impl Array {
    /// Lengths of the axes.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        [self.rows].into_iter().chain(self.columns).collect()
    }

    fn __dlpack_device__(&self) -> (u32, i32) {
        let device = DlpackExporter::device(self);
        (device.device_type.0, device.device_id)
    }

    #[pyo3(signature = (*, stream=None, max_version=None, dl_device=None, copy=None))]
    fn __dlpack__(
        &self,
        py: Python<'_>,
        stream: Option<Bound<'_, PyAny>>,
        max_version: Option<(u32, u32)>,
        dl_device: Option<(u32, i32)>,
        copy: Option<bool>,
    ) -> PyResult<Py<PyAny>> {
        export_dlpack(self, py, ExportRequest::parse(stream.as_ref(), max_version, dl_device, copy)?)
    }
}
