//! A planner's own series, recorded beside the trajectory.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use parquet::data_type::ByteArray;

use crate::StoreError;
use crate::bounded::ParquetBounds;
use crate::parquet_io::{Column, Table, damaged, encode};

const META_KEY: &str = "vertibench:debug";

/// The debug series of one task, e.g. sampled trajectories and their costs.
///
/// What a planner sends is bounded: values beyond [`DebugSeries::MAX_VALUES`], those of names beyond [`DebugSeries::MAX_NAMES`], and
/// those of names longer than [`DebugSeries::MAX_NAME`], are dropped, and counted.
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
    pub name: Arc<str>,
    /// The values, in the order in which the planner sent them; at least one.
    pub values: Vec<f32>,
}

impl DebugSeries {
    /// The number of values that are kept of one task: 4 MiB of memory, and a file of less than 24 MiB at most.
    pub const MAX_VALUES: usize = 1 << 20;

    /// The number of different names that are kept of one task.
    pub const MAX_NAMES: usize = 256;

    /// The length of a name that is kept, bytes. A name stands beside each value in the file.
    pub const MAX_NAME: usize = 100;

    /// The file at most: as many values with names that are not in a dictionary, and what comes between them.
    const BOUNDS: ParquetBounds = ParquetBounds {
        file: 64 << 20,
        values: 4 * Self::MAX_VALUES as u64,
        bytes: (Self::MAX_VALUES * (24 + Self::MAX_NAME)) as u64,
        dictionary: 1 << 20,
    };

    /// Takes the values that the planner sent under `name` in the step at `time` (s).
    pub fn push(&mut self, time: f64, name: &str, values: &[f32]) {
        if values.is_empty() {
            return;
        }
        let next = self.names.len();
        let known = self.names.get(name).copied();
        if self.values.len() + values.len() > Self::MAX_VALUES
            || (known.is_none() && (next >= Self::MAX_NAMES || name.len() > Self::MAX_NAME))
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

    /// Tells whether no values are kept.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The number of values that were dropped because they exceed the bounds.
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
        let table = Table::open(path, &Self::BOUNDS)?;
        table.meta(path, META_KEY)?;
        let time = table.f64(path, "time")?;
        let (names, name) = table.names(path, "name", Self::MAX_NAMES, Self::MAX_NAME)?;
        let (index, value) = (table.i32(path, "index")?, table.f32(path, "value")?);
        if name.len() != time.len() || index.len() != time.len() || value.len() != time.len() {
            return Err(damaged(path, "columns differ in length"));
        }
        let mut entries: Vec<DebugEntry> = Vec::new();
        for (((time, name), index), value) in time.into_iter().zip(name).zip(index).zip(value) {
            match entries.last_mut() {
                Some(last) if index > 0 => last.values.push(value),
                _ => entries.push(DebugEntry { time, name: names[name].clone(), values: vec![value] }),
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
        assert!(back[1].values[0].is_nan() && &*back[1].name == "rollout" && back[1].values.len() == 3);
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

    /// A planner sends a name of kilobytes once; beside each of a million values it would be gigabytes.
    #[test]
    fn names_are_as_long_as_their_bound_and_the_file_is_within_its_own() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.debug.parquet");
        let mut d = DebugSeries::default();
        d.push(0.0, &"a".repeat(DebugSeries::MAX_NAME + 1), &[1.0, 2.0]);
        assert!(d.is_empty() && d.dropped() == 2);
        // All names of full length, all values different, a step for each few of them.
        let each = DebugSeries::MAX_VALUES / DebugSeries::MAX_NAMES;
        for step in 0..each / 16 {
            for k in 0..DebugSeries::MAX_NAMES {
                let name = format!("{k:03}{}", "n".repeat(DebugSeries::MAX_NAME - 3));
                let bits = |i: usize| {
                    (((step * 16 + i) * DebugSeries::MAX_NAMES + k) as u32).wrapping_mul(2_654_435_761)
                };
                let values: Vec<f32> = (0..16).map(|i| f32::from_bits(bits(i))).collect();
                d.push(step as f64 * 0.1, &name, &values);
            }
        }
        assert_eq!((d.values.len(), d.dropped()), (DebugSeries::MAX_VALUES, 2));
        let bytes = d.encode().unwrap();
        assert!(bytes.len() < 24 << 20, "{}", bytes.len());
        std::fs::write(&path, bytes).unwrap();
        let back = DebugSeries::read(&path).unwrap();
        assert_eq!(back.len(), each / 16 * DebugSeries::MAX_NAMES);
        assert_eq!(back.iter().map(|e| e.values.len()).sum::<usize>(), DebugSeries::MAX_VALUES);
        assert!(back[5].name.starts_with("005n"));
    }

    fn file(rows: usize, name: impl Fn(usize) -> String) -> Vec<u8> {
        let text = (0..rows).map(|k| ByteArray::from(name(k).as_str())).collect();
        let columns = vec![
            ("time".to_owned(), Column::F64(vec![0.0; rows])),
            ("name".to_owned(), Column::Text(text)),
            ("index".to_owned(), Column::I32(vec![0; rows])),
            ("value".to_owned(), Column::F32(vec![0.0; rows])),
        ];
        encode(META_KEY, "{}".to_owned(), columns).unwrap()
    }

    #[test]
    fn files_that_no_planner_can_have_sent_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.debug.parquet");
        let refused = |bytes: Vec<u8>| {
            std::fs::write(&path, bytes).unwrap();
            DebugSeries::read(&path).unwrap_err().to_string()
        };
        let most = DebugSeries::MAX_VALUES;
        let e = refused(file(most + 1, |_| "a".into()));
        assert!(e.contains("t.debug.parquet") && e.contains("values, the limit for such a file"), "{e}");
        let e = refused(file(3, |_| "a".repeat(DebugSeries::MAX_NAME + 1)));
        assert!(e.contains("a text of 101 bytes; at most 100 are allowed"), "{e}");
        let e = refused(file(300, |k| k.to_string()));
        assert!(e.contains("more than 256 different texts"), "{e}");
        let e = refused(file(1, |_| "a".repeat(2 << 20)));
        assert!(e.contains("dictionary"), "{e}");
        std::fs::write(&path, file(3, |_| "a".repeat(DebugSeries::MAX_NAME))).unwrap();
        assert_eq!(DebugSeries::read(&path).unwrap().len(), 3);
    }
}
