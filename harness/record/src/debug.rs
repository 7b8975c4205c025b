//! A planner's own series, recorded beside the trajectory.

use std::collections::BTreeMap;
use std::path::Path;

use parquet::data_type::ByteArray;

use crate::StoreError;
use crate::parquet_io::{Column, Table, damaged, encode};

const META_KEY: &str = "vertibench:debug";

/// The debug series of one task, e.g. sampled trajectories and their costs.
///
/// What a planner sends is bounded: values beyond [`DebugSeries::MAX_VALUES`], and those of names beyond
/// [`DebugSeries::MAX_NAMES`], are dropped, and counted.
#[derive(Clone, Debug, Default)]
pub struct DebugSeries {
    names: BTreeMap<String, usize>,
    entries: Vec<(f64, usize, usize)>,
    values: Vec<f32>,
    dropped: u64,
}

/// The values that a planner sent under one name in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugEntry {
    /// The time of the step, s.
    pub time: f64,
    /// The name of the series.
    pub name: String,
    /// The values of the series.
    pub values: Vec<f32>,
}

impl DebugSeries {
    /// The number of values that are kept of one task: 4 MiB of memory, and a file of 16 MiB at most.
    pub const MAX_VALUES: usize = 1 << 20;

    /// The number of different names that are kept of one task.
    pub const MAX_NAMES: usize = 256;

    /// Takes the values that the planner sent under `name` in the step at `time` (s).
    pub fn push(&mut self, time: f64, name: &str, values: &[f32]) {
        if values.is_empty() {
            return;
        }
        let next = self.names.len();
        let known = self.names.get(name).copied();
        if self.values.len() + values.len() > Self::MAX_VALUES || (known.is_none() && next >= Self::MAX_NAMES)
        {
            self.dropped += values.len() as u64;
            return;
        }
        let index = known.unwrap_or_else(|| {
            self.names.insert(name.to_owned(), next);
            next
        });
        self.entries.push((time, index, values.len()));
        self.values.extend_from_slice(values);
    }

    /// Tells whether nothing was sent.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The number of values that were dropped.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The content of a debug file, one row a value: `time`, `name`, `index` in the series, `value`.
    pub(crate) fn encode(&self) -> Result<Vec<u8>, StoreError> {
        let fail = |detail: String| StoreError::Encode { what: "debug series", detail };
        let mut names = vec![ByteArray::new(); self.names.len()];
        for (name, &i) in &self.names {
            names[i] = ByteArray::from(name.as_str());
        }
        let n = self.values.len();
        let (mut time, mut name, mut index) =
            (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n));
        for &(t, which, len) in &self.entries {
            for i in 0..len {
                time.push(t);
                name.push(names[which].clone());
                index.push(i32::try_from(i).map_err(|e| fail(e.to_string()))?);
            }
        }
        let columns = vec![
            ("time".to_owned(), Column::F64(time)),
            ("name".to_owned(), Column::Text(name)),
            ("index".to_owned(), Column::I32(index)),
            ("value".to_owned(), Column::F32(self.values.clone())),
        ];
        let meta = format!("{{\"schema\":1,\"dropped\":{}}}", self.dropped);
        encode(META_KEY, meta, columns).map_err(|e| fail(e.to_string()))
    }

    /// Reads a debug file. Series without values are not in it.
    ///
    /// # Errors
    /// Returns an error if the file can't be read or is damaged.
    pub fn read(path: &Path) -> Result<Vec<DebugEntry>, StoreError> {
        let table = Table::open(path)?;
        table.meta(path, META_KEY)?;
        let (time, name) = (table.f64(path, "time")?, table.text(path, "name")?);
        let (index, value) = (table.i32(path, "index")?, table.f32(path, "value")?);
        if name.len() != time.len() || index.len() != time.len() || value.len() != time.len() {
            return Err(damaged(path, "columns differ in length"));
        }
        let mut entries: Vec<DebugEntry> = Vec::new();
        for (((time, name), index), value) in time.into_iter().zip(name).zip(index).zip(value) {
            match entries.last_mut() {
                Some(last) if index > 0 => last.values.push(value),
                _ => entries.push(DebugEntry { time, name, values: vec![value] }),
            }
        }
        Ok(entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_read_back_as_sent() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.debug.parquet");
        let mut d = DebugSeries::default();
        d.push(0.0, "cost", &[1.5, -0.0]);
        d.push(0.0, "rollout", &[f32::NAN, 2.0, 3.0]);
        d.push(0.1, "cost", &[0.1]);
        std::fs::write(&path, d.encode().unwrap()).unwrap();
        let back = DebugSeries::read(&path).unwrap();
        assert_eq!(back.len(), 3);
        assert_eq!(back[0], DebugEntry { time: 0.0, name: "cost".into(), values: vec![1.5, -0.0] });
        assert!(back[1].values[0].is_nan() && back[1].name == "rollout" && back[1].values.len() == 3);
        assert_eq!(back[2], DebugEntry { time: 0.1, name: "cost".into(), values: vec![0.1] });
    }

    #[test]
    fn what_a_planner_sends_beyond_the_cap_is_dropped_and_counted() {
        let mut d = DebugSeries::default();
        d.push(0.0, "big", &vec![0.0; DebugSeries::MAX_VALUES]);
        d.push(0.1, "more", &[1.0, 2.0]);
        assert_eq!(d.dropped(), 2);
        let mut d = DebugSeries::default();
        for k in 0..=DebugSeries::MAX_NAMES {
            d.push(0.0, &k.to_string(), &[1.0]);
        }
        assert_eq!(d.dropped(), 1);
    }
}
