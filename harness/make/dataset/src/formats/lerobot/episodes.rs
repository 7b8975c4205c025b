//! The files that tell of the episodes, one beside each data file.

use std::path::Path;
use std::sync::Arc;

use arrow_array::builder::{Float64Builder, Int64Builder, ListBuilder, StringBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use serde_json::{Map, Value};
use vb_record::ParquetBounds;

use crate::episode::EpisodeInfo;
use crate::error::DatasetError;
use crate::format::{Place, Row};
use crate::stats::Stats;

/// Limits of a metadata file. Files written here have at most 256 episodes and about a hundred columns.
const BOUNDS: ParquetBounds =
    ParquetBounds { file: 128 << 20, values: 1 << 25, bytes: 256 << 20, dictionary: 2 << 20 };
/// Episodes that are decoded at a time: each can have every text of the file.
const ROWS: usize = 16;
/// The longest text of an episode, bytes.
const TEXT: usize = 4096;

/// Our own fields of an episode, as a flat table: text, numbers, or lists of numbers.
fn own(info: &EpisodeInfo) -> Map<String, Value> {
    match serde_json::to_value(info).expect("an episode has text keys and can be written as JSON") {
        Value::Object(map) => map,
        other => unreachable!("an episode is an object as JSON, not {other}"),
    }
}

fn text(values: impl Iterator<Item = String>) -> ArrayRef {
    Arc::new(StringArray::from_iter_values(values))
}

fn whole(values: impl Iterator<Item = usize>) -> ArrayRef {
    Arc::new(Int64Array::from_iter_values(values.map(|v| i64::try_from(v).unwrap_or(i64::MAX))))
}

fn lists<'a>(values: impl Iterator<Item = &'a [f64]>) -> ArrayRef {
    let mut builder = ListBuilder::new(Float64Builder::new());
    for list in values {
        builder.values().append_slice(list);
        builder.append(true);
    }
    Arc::new(builder.finish())
}

/// The content of a file for these episodes, which all lie in the same data file.
pub(crate) fn write_episodes(rows: &[Row]) -> Result<Vec<u8>, DatasetError> {
    let fail = |e: &dyn std::fmt::Display| DatasetError::Encode { detail: e.to_string() };
    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let mut add = |name: &str, array: ArrayRef| columns.push((name.to_owned(), array));
    add("episode_index", whole(rows.iter().map(|r| r.index)));
    let mut tasks = ListBuilder::new(StringBuilder::new());
    for row in rows {
        tasks.values().append_value(&row.info.instruction);
        tasks.append(true);
    }
    add("tasks", Arc::new(tasks.finish()));
    add("length", whole(rows.iter().map(|r| r.place.to - r.place.from)));
    for part in ["data", "meta/episodes"] {
        add(&format!("{part}/chunk_index"), whole(rows.iter().map(|r| super::place(r.place.file).0)));
        add(&format!("{part}/file_index"), whole(rows.iter().map(|r| super::place(r.place.file).1)));
    }
    add("dataset_from_index", whole(rows.iter().map(|r| r.place.from)));
    add("dataset_to_index", whole(rows.iter().map(|r| r.place.to)));
    let infos: Vec<Map<String, Value>> = rows.iter().map(|r| own(&r.info)).collect();
    for (name, sample) in own(&EpisodeInfo::default()) {
        let of = |k: usize| &infos[k][&name];
        let each = 0..infos.len();
        let array: ArrayRef = match sample {
            Value::String(_) => text(each.map(|k| of(k).as_str().unwrap_or_default().to_owned())),
            Value::Array(_) => {
                let values: Vec<Vec<f64>> = each
                    .map(|k| of(k).as_array().into_iter().flatten().filter_map(Value::as_f64).collect())
                    .collect();
                lists(values.iter().map(Vec::as_slice))
            }
            Value::Number(n) if n.is_u64() => {
                let numbers = each.map(|k| of(k).as_i64().unwrap_or(0));
                Arc::new(Int64Array::from_iter_values(numbers))
            }
            _ => Arc::new(Float64Array::from_iter_values(each.map(|k| of(k).as_f64().unwrap_or(0.0)))),
        };
        add(&name, array);
    }
    for (k, (feature, _)) in rows.first().map(|r| r.stats.as_slice()).unwrap_or_default().iter().enumerate() {
        let part = |f: fn(&Stats) -> &[f64]| lists(rows.iter().map(|r| f(&r.stats[k].1)));
        add(&format!("stats/{feature}/min"), part(|s| &s.min));
        add(&format!("stats/{feature}/max"), part(|s| &s.max));
        add(&format!("stats/{feature}/mean"), part(|s| &s.mean));
        add(&format!("stats/{feature}/std"), part(|s| &s.std));
        let mut counts = ListBuilder::new(Int64Builder::new());
        for row in rows {
            counts.values().append_value(i64::try_from(row.stats[k].1.count[0]).unwrap_or(i64::MAX));
            counts.append(true);
        }
        add(&format!("stats/{feature}/count"), Arc::new(counts.finish()));
    }
    let fields: Vec<Field> =
        columns.iter().map(|(name, array)| Field::new(name, array.data_type().clone(), true)).collect();
    let schema = Arc::new(Schema::new(fields));
    let arrays = columns.into_iter().map(|(_, array)| array).collect();
    let table = RecordBatch::try_new(schema.clone(), arrays).map_err(|e| fail(&e))?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, schema, Some(properties)).map_err(|e| fail(&e))?;
    writer.write(&table).map_err(|e| fail(&e))?;
    writer.close().map_err(|e| fail(&e))?;
    Ok(bytes)
}

/// Reads a file that tells of episodes, with their statistics.
pub(crate) fn read_episodes(path: &Path) -> Result<Vec<Row>, DatasetError> {
    let damaged = |detail: String| DatasetError::damaged(path, &detail);
    let content = super::open(path, &BOUNDS)?;
    let reader =
        ParquetRecordBatchReaderBuilder::try_new(content).and_then(|b| b.with_batch_size(ROWS).build());
    let reader = reader.map_err(|e| damaged(e.to_string()))?;
    let mut all = Vec::new();
    for table in reader {
        let table = table.map_err(|e| damaged(e.to_string()))?;
        let column = |name: &str| {
            table.column_by_name(name).cloned().ok_or_else(|| damaged(format!("no column {name}")))
        };
        let wrong = |name: &str| damaged(format!("column {name} has another type"));
        let number = |name: &str, row: usize| -> Result<usize, DatasetError> {
            let array = column(name)?;
            let values = array.as_primitive_opt::<Int64Type>().ok_or_else(|| wrong(name))?;
            let value = values.value(row);
            usize::try_from(value)
                .map_err(|_| damaged(format!("{name}: {value} in row {row} is not a count")))
        };
        let list = |name: &str, row: usize| -> Result<Vec<f64>, DatasetError> {
            let array = column(name)?;
            let cell = array.as_list_opt::<i32>().ok_or_else(|| wrong(name))?.value(row);
            let values = cell.as_primitive_opt::<Float64Type>().ok_or_else(|| wrong(name))?;
            Ok(values.values().to_vec())
        };
        let schema = table.schema();
        let features: Vec<&str> = schema
            .fields()
            .iter()
            .filter_map(|f| f.name().strip_prefix("stats/")?.strip_suffix("/mean"))
            .collect();
        for row in 0..table.num_rows() {
            let mut fields = Map::new();
            for (name, sample) in own(&EpisodeInfo::default()) {
                let array = column(&name)?;
                let value = match sample {
                    Value::String(_) => {
                        let texts = array.as_string_opt::<i32>().ok_or_else(|| wrong(&name))?;
                        let text = texts.value(row);
                        if text.len() > TEXT {
                            let length = text.len();
                            return Err(damaged(format!(
                                "column {name} has a text of {length} bytes; at most {TEXT} are allowed"
                            )));
                        }
                        Value::from(text)
                    }
                    Value::Array(_) => Value::from(list(&name, row)?),
                    Value::Number(n) if n.is_u64() => Value::from(number(&name, row)?),
                    _ => {
                        let numbers = array.as_primitive_opt::<Float64Type>();
                        Value::from(numbers.ok_or_else(|| wrong(&name))?.value(row))
                    }
                };
                fields.insert(name, value);
            }
            let info = serde_path_to_error::deserialize(Value::Object(fields)).map_err(|e| {
                let (field, problem) = (e.path().to_string(), e.into_inner());
                damaged(format!("row {row}: {field}: {problem}"))
            })?;
            let (chunk, file) = (number("data/chunk_index", row)?, number("data/file_index", row)?);
            let file = chunk.checked_mul(super::CHUNK).and_then(|first| first.checked_add(file));
            let place = Place {
                file: file.ok_or_else(|| damaged(format!("data/chunk_index: {chunk} is too large")))?,
                from: number("dataset_from_index", row)?,
                to: number("dataset_to_index", row)?,
            };
            let length = number("length", row)?;
            if place.to.checked_sub(place.from) != Some(length) {
                let index = number("episode_index", row)?;
                return Err(damaged(format!(
                    "episode {index}: length: {length} does not match frames {} to {}",
                    place.from, place.to
                )));
            }
            let stats = features.iter().map(|feature| {
                let part = |what: &str| list(&format!("stats/{feature}/{what}"), row);
                let (min, max, mean, std) = (part("min")?, part("max")?, part("mean")?, part("std")?);
                if [&max, &mean, &std].iter().any(|other| other.len() != min.len()) {
                    return Err(damaged(format!("stats/{feature}: its lists differ in length")));
                }
                let count = [length as u64];
                Ok(((*feature).to_owned(), Stats { min, max, mean, std, count }))
            });
            let stats = stats.collect::<Result<_, DatasetError>>()?;
            all.push(Row { index: number("episode_index", row)?, place, info, stats });
        }
    }
    Ok(all)
}
