//! The commands of a run: a file by which its tasks can be driven again without the planner.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

use parquet::data_type::ByteArray;
use serde::{Deserialize, Serialize};
use vb_world::TaskId;

use crate::bounded::{ParquetBounds, read_parquet};
use crate::parquet_io::{Column, Table, damaged_as, encode};
use crate::{RunHeader, RunReader, Sample, StoreError, Trace};

/// The version of the layout of a recording.
pub const RECORDING_SCHEMA: u32 = 1;

const META_KEY: &str = "vertibench:commands";
const HINT: &str = "the file is damaged or not a recording of this harness: create it again from its run";
/// The first bytes of a Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";

/// The file at most: four million commands, which are 1000 tasks of 400 s at 10 Hz.
const BOUNDS: ParquetBounds =
    ParquetBounds { file: 256 << 20, values: 1 << 25, bytes: 256 << 20, dictionary: 1 << 22 };
/// Tasks at most, and the length of their names, bytes.
const TASKS: (usize, usize) = (100_000, 256);

/// A command as it was applied, after clamping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AppliedCommand {
    /// The steering command in \[−1, 1\], positive to the left.
    pub steering: f64,
    /// The throttle command in \[0, 1\].
    pub throttle: f64,
    /// The brake command in \[0, 1\].
    pub brake: f64,
    /// The gear command, as in [`Sample::gear`].
    pub gear: f64,
}

impl AppliedCommand {
    fn of(sample: &Sample) -> Self {
        let Sample { steering, throttle, brake, gear, .. } = *sample;
        Self { steering, throttle, brake, gear }
    }
}

/// The commands of a run, with the settings under which they were given.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The description of the run, without paths.
    pub header: RunHeader,
    /// The departures with which the run's records are marked.
    pub departures: Vec<String>,
    /// The commands of each task, one for each control period from the start.
    pub tasks: BTreeMap<TaskId, Vec<AppliedCommand>>,
}

/// The metadata of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    schema: u32,
    departures: Vec<String>,
    run: RunHeader,
}

impl Recording {
    /// The commands of the run in a directory, from its traces. `departures` are those of its records.
    ///
    /// # Errors
    /// Returns an error if the run is a shard, a task has no trace, or the traces have fewer samples than commands.
    pub fn of_run(reader: &RunReader, tasks: &[TaskId], departures: Vec<String>) -> Result<Self, StoreError> {
        let header = reader.header();
        let fail = |detail: String, hint| StoreError::Damaged { path: reader.dir().to_owned(), detail, hint };
        if let Some(shard) = header.shard {
            let detail = format!("contains only shard {} of {}", shard.index, shard.of);
            return Err(fail(detail, "join the shards first, with vb-harness merge"));
        }
        let mut all = BTreeMap::new();
        for task in tasks {
            if !reader.has_trace(task)? {
                let detail = format!("{task} has no trace, which contains the commands");
                return Err(fail(detail, "run with --trace 10hz or full"));
            }
            let commands = commands(&reader.trace(task)?, header.plugin.control_period);
            let Some(commands) = commands else {
                let detail = format!(
                    "{task}: the command period of {} s is shorter than the sample period of the trace",
                    header.plugin.control_period
                );
                return Err(fail(detail, "run with --trace full"));
            };
            all.insert(task.clone(), commands);
        }
        let mut header = header.clone();
        header.suite.path.clear();
        header.plugin.path.clear();
        Ok(Self { header, departures, tasks: all })
    }

    /// Writes the file, as a whole or not at all.
    ///
    /// # Errors
    /// Returns an error if the file can't be written.
    pub fn write(&self, path: &Path) -> Result<(), StoreError> {
        let fail = |detail: String| StoreError::Encode { what: "a recording", detail };
        let meta =
            Meta { schema: RECORDING_SCHEMA, departures: self.departures.clone(), run: self.header.clone() };
        let meta = serde_json::to_string(&meta).map_err(|e| fail(e.to_string()))?;
        let mut tasks = Vec::new();
        let mut columns = [const { Vec::new() }; 4];
        for (task, commands) in &self.tasks {
            tasks.extend(std::iter::repeat_n(ByteArray::from(task.as_str()), commands.len()));
            for AppliedCommand { steering, throttle, brake, gear } in commands {
                for (column, value) in columns.iter_mut().zip([steering, throttle, brake, gear]) {
                    column.push(*value);
                }
            }
        }
        let numbers = NUMBERS.iter().zip(columns).map(|(name, v)| ((*name).to_owned(), Column::F64(v)));
        let all = std::iter::once(("task".to_owned(), Column::Text(tasks))).chain(numbers).collect();
        let bytes = encode(META_KEY, meta, all).map_err(|e| fail(e.to_string()))?;
        vb_files::write(path, &bytes).map_err(StoreError::io("write", path))
    }

    /// Whether a file can be a recording, by its first bytes.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        let mut magic = [0; MAGIC.len()];
        vb_files::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC
    }

    /// Reads a recording; returns also the SHA-256 of its file (hex).
    ///
    /// # Errors
    /// Returns an error if the file can't be read, or is not a recording of a supported version.
    pub fn read(path: &Path) -> Result<(Self, String), StoreError> {
        Self::read_table(path).map_err(|e| match e {
            StoreError::Damaged { path, detail, .. } => damaged_as(&path, detail, HINT),
            e => e,
        })
    }

    fn read_table(path: &Path) -> Result<(Self, String), StoreError> {
        let fail = |detail: String| damaged_as(path, detail, HINT);
        let content = read_parquet(path, &BOUNDS).map_err(|e| match e.kind() {
            ErrorKind::InvalidData => fail(e.to_string()),
            _ => StoreError::io("read", path)(e),
        })?;
        let sha256 = vb_files::sha256(&content);
        let table = Table::of(path, content)?;
        let fields: serde_json::Value =
            serde_json::from_str(table.meta(path, META_KEY)?).map_err(|e| fail(format!("metadata: {e}")))?;
        let schema = fields.get("schema").and_then(serde_json::Value::as_u64).unwrap_or(0);
        if schema != u64::from(RECORDING_SCHEMA) {
            return Err(StoreError::Schema {
                path: path.to_owned(),
                found: schema,
                supported: RECORDING_SCHEMA,
            });
        }
        let meta: Meta = serde_json::from_value(fields).map_err(|e| fail(format!("metadata: {e}")))?;
        let (most, longest) = TASKS;
        let (names, rows) = table.names(path, "task", most, longest)?;
        let columns = NUMBERS.map(|name| table.f64(path, name));
        let [steering, throttle, brake, gear] = columns;
        let (steering, throttle, brake, gear) = (steering?, throttle?, brake?, gear?);
        if [&steering, &throttle, &brake, &gear].iter().any(|c| c.len() != rows.len()) {
            return Err(fail("columns differ in length".into()));
        }
        let ids =
            names.iter().map(|name| name.parse::<TaskId>().map_err(|e| fail(format!("task {name:?}: {e}"))));
        let ids = ids.collect::<Result<Vec<_>, _>>()?;
        let mut tasks: Vec<Vec<AppliedCommand>> = vec![Vec::new(); ids.len()];
        for (row, task) in rows.into_iter().enumerate() {
            let command = AppliedCommand {
                steering: steering[row],
                throttle: throttle[row],
                brake: brake[row],
                gear: gear[row],
            };
            let values = [command.steering, command.throttle, command.brake, command.gear];
            if let Some((name, value)) = NUMBERS.iter().zip(values).find(|(_, v)| !v.is_finite()) {
                return Err(fail(format!("row {row}: {name} is {value}")));
            }
            tasks[task].push(command);
        }
        let (header, departures) = (meta.run, meta.departures);
        Ok((Self { header, departures, tasks: ids.into_iter().zip(tasks).collect() }, sha256))
    }
}

/// The columns of numbers.
const NUMBERS: [&str; 4] = ["steering", "throttle", "brake", "gear"];

/// The commands of a trajectory that were given every `period` (s): a sample has the command that was applied up to it.
/// `None` if there are fewer samples than commands.
fn commands(trace: &Trace, period: f64) -> Option<Vec<AppliedCommand>> {
    let ratio = period / trace.meta.resolution();
    let stride = ratio.round();
    if stride < 1.0 || (ratio - stride).abs() > 1e-6 {
        return None;
    }
    // The first sample is before any command, and the last may be anywhere in its period.
    let after = trace.samples.get(1..).unwrap_or_default();
    Some(after.iter().step_by(stride as usize).map(AppliedCommand::of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::tests::meta;
    use crate::{TraceMode, TraceRecorder};

    /// A trajectory of `end` samples under commands that change every `every` samples.
    fn trace(mode: TraceMode, every: u64, end: u64) -> Trace {
        let mut recorder = TraceRecorder::new(mode, 0);
        for k in 0..=end {
            // The command of a step holds until the sample at which the next one is given, included.
            let command = if k == 0 { 0.0 } else { ((k - 1) / every) as f64 / 64.0 };
            let sample = Sample {
                time: 0.01 * k as f64,
                steering: command,
                gear: Sample::REVERSE,
                ..Sample::default()
            };
            recorder.push(&sample, &[]);
        }
        recorder.finish(meta(mode)).unwrap()
    }

    #[test]
    fn each_command_is_found_wherever_the_drive_ends() {
        for (mode, every) in [
            (TraceMode::TenHz, 10),
            (TraceMode::TenHz, 20),
            (TraceMode::Full, 1),
            (TraceMode::Full, 2),
            (TraceMode::Full, 10),
        ] {
            for end in 0..=45 {
                let found = commands(&trace(mode, every, end), 0.01 * every as f64).unwrap();
                let expected: Vec<f64> = (0..end.div_ceil(every)).map(|k| k as f64 / 64.0).collect();
                let steering: Vec<f64> = found.iter().map(|c| c.steering).collect();
                assert_eq!(steering, expected, "{mode:?}, every {every}, {end} samples");
                assert!(found.iter().all(|c| c.gear == Sample::REVERSE));
            }
        }
    }

    #[test]
    fn commands_between_two_samples_are_not_guessed() {
        for (mode, every) in [(TraceMode::TenHz, 5), (TraceMode::TenHz, 15)] {
            assert_eq!(commands(&trace(mode, every, 30), 0.01 * every as f64), None, "{mode:?}, {every}");
        }
    }
}
