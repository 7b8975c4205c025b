//! Trajectories in Parquet files.

use std::path::Path;

use serde::{Deserialize, Serialize};
use vb_world::TaskId;

use crate::bounded::ParquetBounds;
use crate::parquet_io::{Column, Table, damaged, encode};
use crate::settings::PLACES;
use crate::{Sample, StoreError, WheelSample};

/// The version of the layout of a trace file.
pub const TRACE_SCHEMA: u32 = 1;

const META_KEY: &str = "vertibench:trace";

/// The file at most: three hours of all samples of a vehicle of four wheels, or an hour of one of forty.
const BOUNDS: ParquetBounds =
    ParquetBounds { file: 512 << 20, values: 1 << 25, bytes: 512 << 20, dictionary: 1 << 20 };

/// The samples of a trajectory that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TraceMode {
    /// No samples are kept. Such a run can't be re-scored.
    #[serde(rename = "none")]
    None,
    /// Every tenth sample and the last one are kept: enough for inspection and approximate re-scoring.
    #[default]
    #[serde(rename = "10hz")]
    TenHz,
    /// Every sample used by the rules is kept: re-scoring reproduces the outcomes exactly.
    #[serde(rename = "full")]
    Full,
}

impl TraceMode {
    /// The number of samples for which one kept sample stands; `None` if none is kept.
    #[must_use]
    pub fn stride(self) -> Option<u64> {
        match self {
            Self::None => None,
            Self::TenHz => Some(10),
            Self::Full => Some(1),
        }
    }

    /// The name as written in run.json and on the command line: `none`, `10hz` or `full`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::TenHz => "10hz",
            Self::Full => "full",
        }
    }
}

/// The data of a trace file about its task, beside the samples. Lengths are in metres of the world as simulated, that
/// is after scaling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceMeta {
    /// The version of the layout, [`TRACE_SCHEMA`].
    pub schema: u32,
    /// The name of the task, e.g. `w001/t03`.
    pub task: TaskId,
    /// The start pose: x (m), y (m), yaw (rad, counter-clockwise from east).
    pub start: [f64; 3],
    /// The goal (x, y), m.
    pub goal: [f64; 2],
    /// The height of the ground at the goal, m.
    pub goal_z: f64,
    /// Half the extents of the world along x and y, m.
    pub half_extent: [f64; 2],
    /// The factor by which the world's lengths were multiplied.
    pub scale: f64,
    /// The vehicle's maximum speed, m/s.
    pub max_speed: f64,
    /// The time step of the simulation, s.
    pub time_step: f64,
    /// The time between the samples that the rules saw, s.
    pub sample_period: f64,
    /// The samples that are in the file.
    pub mode: TraceMode,
}

impl TraceMeta {
    /// The time between the samples in the file, s.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.sample_period * self.mode.stride().unwrap_or(1) as f64
    }
}

/// A recorded trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The data about the task of the trajectory.
    pub meta: TraceMeta,
    /// The samples in the order of time.
    pub samples: Vec<Sample>,
    /// The number of wheels.
    pub wheels: usize,
    /// The states of the wheels, `samples.len() * wheels` entries: the wheels of the first sample, those of the second,
    /// and so on.
    pub wheel_samples: Vec<WheelSample>,
}

/// A recorder that collects the samples of one task as a [`TraceMode`] wants them.
#[derive(Clone, Debug)]
pub struct TraceRecorder {
    mode: TraceMode,
    wheels: usize,
    seen: u64,
    samples: Vec<Sample>,
    wheel_samples: Vec<WheelSample>,
    /// The latest sample while it isn't kept: the last one always is.
    pending: Option<(Sample, Vec<WheelSample>)>,
}

impl TraceRecorder {
    /// A recorder for a vehicle with this many wheels.
    #[must_use]
    pub fn new(mode: TraceMode, wheels: usize) -> Self {
        Self { mode, wheels, seen: 0, samples: Vec::new(), wheel_samples: Vec::new(), pending: None }
    }

    /// Takes a sample with the state of each wheel.
    ///
    /// # Panics
    /// Panics if `wheels` has another length than [`TraceRecorder::new`] was told.
    pub fn push(&mut self, sample: &Sample, wheels: &[WheelSample]) {
        assert_eq!(wheels.len(), self.wheels, "wheels of a sample");
        let Some(stride) = self.mode.stride() else { return };
        if self.seen.is_multiple_of(stride) {
            self.pending = None;
            self.samples.push(*sample);
            self.wheel_samples.extend_from_slice(wheels);
        } else if let Some((last, last_wheels)) = &mut self.pending {
            *last = *sample;
            last_wheels.copy_from_slice(wheels);
        } else {
            self.pending = Some((*sample, wheels.to_vec()));
        }
        self.seen += 1;
    }

    /// The trace; `None` if the mode wants none.
    #[must_use]
    pub fn finish(mut self, meta: TraceMeta) -> Option<Trace> {
        self.mode.stride()?;
        if let Some((sample, wheels)) = self.pending.take() {
            self.samples.push(sample);
            self.wheel_samples.extend_from_slice(&wheels);
        }
        Some(Trace { meta, samples: self.samples, wheels: self.wheels, wheel_samples: self.wheel_samples })
    }
}

impl Trace {
    /// The content of a trace file: a column for each of [`Sample::FIELDS`], then `speed_0`, `deflection_0`, … for
    /// each wheel, all DOUBLE; [`TraceMeta`] as JSON under the key `vertibench:trace`.
    pub(crate) fn encode(&self) -> Result<Vec<u8>, StoreError> {
        let fail = |detail: String| StoreError::Encode { what: "a trace", detail };
        if self.wheel_samples.len() != self.samples.len() * self.wheels {
            return Err(fail("the numbers of samples and wheels differ".into()));
        }
        let meta = serde_json::to_string(&self.meta).map_err(|e| fail(e.to_string()))?;
        let mut fields = vec![Vec::with_capacity(self.samples.len()); Sample::FIELDS.len()];
        for sample in &self.samples {
            for (column, value) in fields.iter_mut().zip(sample.to_array()) {
                column.push(value);
            }
        }
        let mut columns: Vec<(String, Column)> =
            Sample::FIELDS.iter().zip(fields).map(|(name, v)| ((*name).to_owned(), Column::F64(v))).collect();
        for w in 0..self.wheels {
            let of = |f: fn(&WheelSample) -> f64| {
                self.wheel_samples[w..].iter().step_by(self.wheels).map(f).collect()
            };
            if self.samples.is_empty() {
                columns.push((format!("speed_{w}"), Column::F64(Vec::new())));
                columns.push((format!("deflection_{w}"), Column::F64(Vec::new())));
            } else {
                columns.push((format!("speed_{w}"), Column::F64(of(|s| s.speed))));
                columns.push((format!("deflection_{w}"), Column::F64(of(|s| s.deflection))));
            }
        }
        encode(META_KEY, meta, columns).map_err(|e| fail(e.to_string()))
    }

    /// Reads a trace file.
    ///
    /// # Errors
    /// Returns an error if the file can't be read, is truncated, or is not a trace file of a supported version.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        let table = Table::open(path, &BOUNDS)?;
        let text = table.meta(path, META_KEY)?;
        let fields: serde_json::Value =
            serde_json::from_str(text).map_err(|e| damaged(path, format!("metadata: {e}")))?;
        let schema = fields.get("schema").and_then(serde_json::Value::as_u64).unwrap_or(0);
        if schema != u64::from(TRACE_SCHEMA) {
            return Err(StoreError::Schema { path: path.to_owned(), found: schema, supported: TRACE_SCHEMA });
        }
        let meta: TraceMeta =
            serde_json::from_value(fields).map_err(|e| damaged(path, format!("metadata: {e}")))?;
        if let Some(flaw) = meta.flaw() {
            return Err(damaged(path, format!("metadata: {flaw}")));
        }
        let columns =
            Sample::FIELDS.iter().map(|name| table.f64(path, name)).collect::<Result<Vec<_>, _>>()?;
        let rows = columns[0].len();
        for (name, values) in Sample::FIELDS.iter().zip(&columns) {
            if let Some(k) = values.iter().position(|v| !PLACES.contains(v)) {
                let detail = format!("sample {k}: {name}: {:e} is out of range", values[k]);
                return Err(damaged(path, detail));
            }
        }
        let wheels = table.columns().iter().filter(|name| name.starts_with("speed_")).count();
        let mut wheel_columns = Vec::with_capacity(wheels);
        for w in 0..wheels {
            let speed = table.f64(path, &format!("speed_{w}"))?;
            let deflection = table.f64(path, &format!("deflection_{w}"))?;
            wheel_columns.push((speed, deflection));
        }
        if columns.iter().any(|c| c.len() != rows)
            || wheel_columns.iter().any(|(s, d)| s.len() != rows || d.len() != rows)
        {
            return Err(damaged(path, "columns differ in length"));
        }
        let samples = (0..rows).map(|r| Sample::from_array(std::array::from_fn(|c| columns[c][r]))).collect();
        let wheel_samples = (0..rows)
            .flat_map(|r| {
                wheel_columns.iter().map(move |(s, d)| WheelSample { speed: s[r], deflection: d[r] })
            })
            .collect();
        Ok(Self { meta, samples, wheels, wheel_samples })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn meta(mode: TraceMode) -> TraceMeta {
        TraceMeta {
            schema: TRACE_SCHEMA,
            task: "w001/t03".parse().unwrap(),
            start: [-60.0, 0.1, 0.3],
            goal: [60.0, -0.1],
            goal_z: 1.0 / 3.0,
            half_extent: [64.0, 64.0],
            scale: 1.0 / 6.0,
            max_speed: 30.0,
            time_step: 0.001,
            sample_period: 0.01,
            mode,
        }
    }

    /// Values whose every bit matters: subnormals, signed zero, the greatest that are read and the neighbours of 1.
    fn awkward(i: usize) -> f64 {
        let bits =
            [0x3ff0_0000_0000_0001, 0x8000_0000_0000_0000, 1, 0xc1cd_cd65_0000_0000, 0x3fd5_5555_5555_5555];
        f64::from_bits(bits[i % bits.len()]) + if i.is_multiple_of(7) { i as f64 * 0.1 } else { 0.0 }
    }

    fn recorded(mode: TraceMode, n: usize) -> Trace {
        let mut recorder = TraceRecorder::new(mode, 4);
        for k in 0..n {
            let mut fields: [f64; 17] = std::array::from_fn(|i| awkward(k * 17 + i));
            fields[0] = k as f64 * 0.01;
            let wheels: [WheelSample; 4] =
                std::array::from_fn(|w| WheelSample { speed: awkward(k + w), deflection: -awkward(k * w) });
            recorder.push(&Sample::from_array(fields), &wheels);
        }
        recorder.finish(meta(mode)).unwrap()
    }

    fn bits(t: &Trace) -> Vec<u64> {
        let samples = t.samples.iter().flat_map(|s| s.to_array().map(f64::to_bits));
        let wheels = t.wheel_samples.iter().flat_map(|w| [w.speed.to_bits(), w.deflection.to_bits()]);
        samples.chain(wheels).collect()
    }

    #[test]
    fn a_trace_reads_back_to_the_same_bits() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.parquet");
        for n in [0, 1, 6001] {
            let trace = recorded(TraceMode::Full, n);
            std::fs::write(&path, trace.encode().unwrap()).unwrap();
            let back = Trace::read(&path).unwrap();
            assert_eq!(back.meta, trace.meta);
            assert_eq!(back.samples.len(), n);
            assert_eq!(back.wheels, 4);
            assert_eq!(bits(&back), bits(&trace));
        }
    }

    #[test]
    fn ten_hertz_keeps_every_tenth_sample_and_the_last() {
        let times = |n| recorded(TraceMode::TenHz, n).samples.iter().map(|s| s.time).collect::<Vec<_>>();
        assert_eq!(times(24), [0.0, 0.1, 0.2, 0.23]);
        assert_eq!(times(21), [0.0, 0.1, 0.2]);
        assert!((meta(TraceMode::TenHz).resolution() - 0.1).abs() < 1e-15);
    }

    #[test]
    fn mode_none_keeps_nothing() {
        let mut recorder = TraceRecorder::new(TraceMode::None, 0);
        recorder.push(&Sample::default(), &[]);
        assert!(recorder.finish(meta(TraceMode::None)).is_none());
    }

    #[test]
    fn a_truncated_or_foreign_file_is_an_error_that_names_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.parquet");
        let whole = recorded(TraceMode::Full, 500).encode().unwrap();
        for bytes in
            [&whole[..whole.len() / 2], &whole[..whole.len() - 1], &whole[..3], b"hello world, no parquet"]
        {
            std::fs::write(&path, bytes).unwrap();
            let e = Trace::read(&path).unwrap_err();
            let text = e.to_string();
            assert!(matches!(e, StoreError::Damaged { .. }), "{text}");
            assert!(text.contains("t.parquet") && text.contains("re-run the task") && !text.contains('\n'));
        }
        let missing = dir.path().join("none.parquet");
        assert!(matches!(Trace::read(&missing).unwrap_err(), StoreError::Io { .. }));
    }

    #[test]
    fn a_trace_of_another_version_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.parquet");
        let mut trace = recorded(TraceMode::Full, 3);
        trace.meta.schema = 2;
        std::fs::write(&path, trace.encode().unwrap()).unwrap();
        let e = Trace::read(&path).unwrap_err();
        assert!(matches!(e, StoreError::Schema { found: 2, .. }), "{e}");
    }

    #[test]
    fn a_trace_with_a_number_that_no_vehicle_has_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.parquet");
        for value in [1e300, -1e300, f64::INFINITY, f64::NAN] {
            let mut trace = recorded(TraceMode::Full, 3);
            trace.samples[1].y = value;
            std::fs::write(&path, trace.encode().unwrap()).unwrap();
            let e = Trace::read(&path).unwrap_err().to_string();
            assert!(e.contains(&format!("sample 1: y: {value:e} is out of range")), "{e}");
        }
    }

    #[test]
    fn a_trace_whose_task_no_simulation_can_have_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.parquet");
        let refused = |change: fn(&mut TraceMeta)| {
            let mut trace = recorded(TraceMode::Full, 3);
            change(&mut trace.meta);
            std::fs::write(&path, trace.encode().unwrap()).unwrap();
            Trace::read(&path).unwrap_err().to_string()
        };
        for (change, field) in [
            ((|m| m.scale = 0.0) as fn(&mut TraceMeta), "scale: 0 must"),
            (|m| m.sample_period = -1.0, "sample_period: -1 must"),
            (|m| m.sample_period = 1e300, "sample_period: 1e300 must"),
            (|m| m.half_extent[1] = 1e300, "half_extent: 1e300 must"),
            (|m| m.goal[0] = -1e300, "goal: -1e300 must"),
            (|m| m.goal_z = 1e12, "goal_z: 1e12 must"),
            (|m| m.start[2] = 1e12, "start: 1e12 must"),
        ] {
            let e = refused(change);
            assert!(e.contains(field) && e.contains("t.parquet"), "{e}");
        }
    }
}
