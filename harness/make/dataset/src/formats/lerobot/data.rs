//! The files with the frames.

use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Int64Type, UInt8Type};
use arrow_array::{
    Array, ArrayRef, BooleanArray, FixedSizeListArray, Float32Array, Int64Array, RecordBatch, UInt8Array,
};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, Encoding};
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;
use vb_record::ParquetBounds;

use super::{OWN, open};
use crate::error::DatasetError;
use crate::feature::{Dtype, Feature, Values};
use crate::format::Batch;

/// A data file at most. Ours have 48 MiB before compression, or one episode.
const BOUNDS: ParquetBounds =
    ParquetBounds { file: 512 << 20, values: 1 << 28, bytes: 1 << 30, dictionary: 16 << 20 };

fn item(dtype: Dtype) -> DataType {
    match dtype {
        Dtype::F32 => DataType::Float32,
        Dtype::I64 => DataType::Int64,
        Dtype::U8 => DataType::UInt8,
        Dtype::Bool => DataType::Boolean,
    }
}

/// The type of a value of this shape: a number, a list of fixed length, or a list of such lists.
fn nested(item: DataType, shape: &[usize]) -> DataType {
    match shape {
        [] | [1] => item,
        _ => shape.iter().rev().fold(item, |inner, n| {
            let field = Arc::new(Field::new("element", inner, false));
            DataType::FixedSizeList(field, i32::try_from(*n).unwrap_or(i32::MAX))
        }),
    }
}

fn array(feature: &Feature, values: &Values) -> Result<ArrayRef, ArrowError> {
    let flat: ArrayRef = match values {
        Values::F32(v) => Arc::new(Float32Array::from(v.clone())),
        Values::I64(v) => Arc::new(Int64Array::from(v.clone())),
        Values::U8(v) => Arc::new(UInt8Array::from(v.clone())),
        Values::Bool(v) => Arc::new(BooleanArray::from(v.clone())),
    };
    if feature.shape == [1] {
        return Ok(flat);
    }
    feature.shape.iter().rev().try_fold(flat, |inner, n| {
        let field = Arc::new(Field::new("element", inner.data_type().clone(), false));
        let list = FixedSizeListArray::try_new(field, i32::try_from(*n).unwrap_or(i32::MAX), inner, None)?;
        Ok(Arc::new(list) as ArrayRef)
    })
}

/// The content of a data file.
pub(crate) fn write_data(features: &[Feature], batch: &Batch) -> Result<Vec<u8>, DatasetError> {
    let fail = |e: &dyn std::fmt::Display| DatasetError::Encode { detail: e.to_string() };
    let mut fields: Vec<Field> =
        features.iter().map(|f| Field::new(f.name, nested(item(f.dtype), &f.shape), false)).collect();
    fields.extend(OWN.map(|(name, dtype)| Field::new(name, item(dtype), false)));
    let mut arrays = Vec::with_capacity(fields.len());
    for (feature, values) in features.iter().zip(&batch.columns) {
        arrays.push(array(feature, values).map_err(|e| fail(&e))?);
    }
    arrays.push(Arc::new(Float32Array::from(batch.timestamp.clone())));
    for whole in [&batch.frame_index, &batch.episode_index, &batch.index, &batch.task_index] {
        arrays.push(Arc::new(Int64Array::from(whole.clone())));
    }
    let schema = Arc::new(Schema::new(fields));
    let rows = RecordBatch::try_new(schema.clone(), arrays).map_err(|e| fail(&e))?;
    // Floats are split into streams of bytes, in which snappy finds the slowly changing exponents.
    let mut properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    for feature in features.iter().filter(|f| f.dtype == Dtype::F32) {
        let lists = if feature.shape == [1] { 0 } else { feature.shape.len() };
        let mut path = vec![feature.name.to_owned()];
        path.extend((0..lists).flat_map(|_| ["list".to_owned(), "element".to_owned()]));
        let path = ColumnPath::new(path);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
    }
    let mut bytes = Vec::new();
    let mut writer =
        ArrowWriter::try_new(&mut bytes, schema, Some(properties.build())).map_err(|e| fail(&e))?;
    writer.write(&rows).map_err(|e| fail(&e))?;
    writer.close().map_err(|e| fail(&e))?;
    Ok(bytes)
}

/// The values of an array, down to its numbers.
fn flat(mut array: ArrayRef, dtype: Dtype) -> Option<Values> {
    while let Some(list) = array.as_fixed_size_list_opt() {
        array = list.values().clone();
    }
    if array.null_count() > 0 {
        return None;
    }
    match dtype {
        Dtype::F32 => array.as_primitive_opt::<Float32Type>().map(|a| Values::F32(a.values().to_vec())),
        Dtype::I64 => array.as_primitive_opt::<Int64Type>().map(|a| Values::I64(a.values().to_vec())),
        Dtype::U8 => array.as_primitive_opt::<UInt8Type>().map(|a| Values::U8(a.values().to_vec())),
        Dtype::Bool => array.as_boolean_opt().map(|a| Values::Bool(a.iter().flatten().collect())),
    }
}

/// Reads a data file with these features.
pub(crate) fn read_data(path: &Path, features: &[Feature]) -> Result<Batch, DatasetError> {
    let damaged = |detail: String| DatasetError::damaged(path, &detail);
    let content = open(path, &BOUNDS)?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(content).map_err(|e| damaged(e.to_string()))?;
    let reader = builder.with_batch_size(8192).build().map_err(|e| damaged(e.to_string()))?;
    let mut batch = Batch::new(features);
    for rows in reader {
        let rows = rows.map_err(|e| damaged(e.to_string()))?;
        let column = |name: &str, dtype: Dtype, width: usize| {
            let array = rows.column_by_name(name).ok_or_else(|| damaged(format!("no column {name}")))?;
            let values = flat(array.clone(), dtype);
            values.filter(|v| v.len() == rows.num_rows() * width).ok_or_else(|| {
                damaged(format!("column {name} is not {} with {width} values per frame", dtype.name()))
            })
        };
        for (feature, to) in features.iter().zip(&mut batch.columns) {
            let values = column(feature.name, feature.dtype, feature.width())?;
            to.append(&values, 0..values.len());
        }
        let Batch { timestamp, frame_index, episode_index, index, task_index, .. } = &mut batch;
        let mut whole = [frame_index, episode_index, index, task_index].into_iter();
        for (name, dtype) in OWN {
            match column(name, dtype, 1)? {
                Values::F32(v) => timestamp.extend(v),
                Values::I64(v) => whole.next().into_iter().for_each(|to| to.extend(&v)),
                _ => return Err(damaged(format!("column {name} has another type"))),
            }
        }
    }
    Ok(batch)
}
