//! The little of Parquet that the store needs: one row group of required, non-nested columns.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, get_typed_column_reader};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use vb_files::decoding;

use crate::StoreError;
use crate::bounded::{ParquetBounds, read_parquet};

pub(crate) enum Column {
    F64(Vec<f64>),
    F32(Vec<f32>),
    I32(Vec<i32>),
    Text(Vec<ByteArray>),
}

impl Column {
    fn physical(&self) -> Physical {
        match self {
            Self::F64(_) => Physical::DOUBLE,
            Self::F32(_) => Physical::FLOAT,
            Self::I32(_) => Physical::INT32,
            Self::Text(_) => Physical::BYTE_ARRAY,
        }
    }
}

/// A file in memory, with one metadata entry.
///
/// Floats are split into byte streams, which lets snappy find the slowly changing exponents; text is
/// dictionary-coded.
pub(crate) fn encode(
    key: &str,
    meta: String,
    columns: Vec<(String, Column)>,
) -> Result<Vec<u8>, ParquetError> {
    let mut fields = Vec::with_capacity(columns.len());
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_key_value_metadata(Some(vec![KeyValue::new(key.to_owned(), meta)]));
    for (name, column) in &columns {
        let mut field =
            Type::primitive_type_builder(name, column.physical()).with_repetition(Repetition::REQUIRED);
        let path = ColumnPath::new(vec![name.clone()]);
        match column {
            Column::F64(_) | Column::F32(_) => {
                properties = properties.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
            }
            Column::I32(_) => {}
            Column::Text(_) => {
                field = field.with_logical_type(Some(LogicalType::String));
                properties = properties.set_column_dictionary_enabled(path, true);
            }
        }
        fields.push(Arc::new(field.build()?));
    }
    let schema = Type::group_type_builder("vertibench").with_fields(fields).build()?;
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties.build()))?;
    let mut rows = writer.next_row_group()?;
    for (_, column) in columns {
        let Some(mut out) = rows.next_column()? else { break };
        match column {
            Column::F64(v) => out.typed::<DoubleType>().write_batch(&v, None, None)?,
            Column::F32(v) => out.typed::<FloatType>().write_batch(&v, None, None)?,
            Column::I32(v) => out.typed::<Int32Type>().write_batch(&v, None, None)?,
            Column::Text(v) => out.typed::<ByteArrayType>().write_batch(&v, None, None)?,
        };
        out.close()?;
    }
    rows.close()?;
    writer.into_inner()
}

/// A file opened for reading.
pub(crate) struct Table {
    reader: SerializedFileReader<Bytes>,
}

/// Rows that are decoded at a time.
const PART: usize = 1 << 14;

const HINT: &str = "the file is truncated or not a trace of this harness: re-run the task";

/// An error about the content of the file.
pub(crate) fn damaged(path: &Path, detail: impl ToString) -> StoreError {
    damaged_as(path, detail, HINT)
}

/// An error about the content of the file, with what to do about it.
pub(crate) fn damaged_as(path: &Path, detail: impl ToString, hint: &'static str) -> StoreError {
    // Parquet's own messages may span lines; ours never do.
    let detail = vb_files::one_line(&detail.to_string());
    StoreError::Damaged { path: path.to_owned(), detail, hint }
}

impl Table {
    /// Opens a file that is within bounds.
    pub(crate) fn open(path: &Path, bounds: &ParquetBounds) -> Result<Self, StoreError> {
        let content = read_parquet(path, bounds).map_err(|e| match e.kind() {
            ErrorKind::InvalidData => damaged(path, e),
            _ => StoreError::io("read", path)(e),
        })?;
        Self::of(path, content)
    }

    /// Opens the content of the file at `path`, which is within bounds.
    pub(crate) fn of(path: &Path, content: Bytes) -> Result<Self, StoreError> {
        let reader = decoding(|| SerializedFileReader::new(content)).map_err(|e| damaged(path, e))?;
        let reader = reader.map_err(|e| damaged(path, e))?;
        Ok(Self { reader })
    }

    pub(crate) fn meta(&self, path: &Path, key: &str) -> Result<&str, StoreError> {
        let entries = self.reader.metadata().file_metadata().key_value_metadata();
        entries
            .and_then(|all| all.iter().find(|e| e.key == key))
            .and_then(|e| e.value.as_deref())
            .ok_or_else(|| damaged(path, format!("no metadata entry {key:?}")))
    }

    pub(crate) fn columns(&self) -> Vec<String> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        schema.columns().iter().map(|c| c.name().to_owned()).collect()
    }

    pub(crate) fn f64(&self, path: &Path, name: &str) -> Result<Vec<f64>, StoreError> {
        self.read::<DoubleType>(path, name, Physical::DOUBLE)
    }

    pub(crate) fn f32(&self, path: &Path, name: &str) -> Result<Vec<f32>, StoreError> {
        self.read::<FloatType>(path, name, Physical::FLOAT)
    }

    pub(crate) fn i32(&self, path: &Path, name: &str) -> Result<Vec<i32>, StoreError> {
        self.read::<Int32Type>(path, name, Physical::INT32)
    }

    /// A column of text, of which each different one is kept once and known by its place in the list. There may be `most` of them, of
    /// `longest` bytes.
    pub(crate) fn names(
        &self,
        path: &Path,
        name: &str,
        most: usize,
        longest: usize,
    ) -> Result<(Vec<Arc<str>>, Vec<usize>), StoreError> {
        let mut known: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
        let (mut texts, mut rows): (Vec<Arc<str>>, _) = (Vec::new(), Vec::new());
        self.each::<ByteArrayType>(path, name, Physical::BYTE_ARRAY, |values| {
            for value in values.drain(..) {
                let fail = |detail: String| damaged(path, format!("column {name:?}: {detail}"));
                if let Some(k) = known.get(value.data()) {
                    rows.push(*k);
                    continue;
                }
                if value.len() > longest {
                    return Err(fail(format!(
                        "a text of {} bytes; at most {longest} are allowed",
                        value.len()
                    )));
                }
                if texts.len() == most {
                    return Err(fail(format!("more than {most} different texts")));
                }
                let text = value.as_utf8().map_err(|e| fail(e.to_string()))?;
                rows.push(texts.len());
                known.insert(value.data().to_vec(), texts.len());
                texts.push(text.into());
            }
            Ok(())
        })?;
        Ok((texts, rows))
    }

    fn read<T: DataType>(&self, path: &Path, name: &str, want: Physical) -> Result<Vec<T::T>, StoreError> {
        let mut all = Vec::new();
        self.each::<T>(path, name, want, |values| {
            all.append(values);
            Ok(())
        })?;
        Ok(all)
    }

    /// Hands over the values of a column in their order, some thousand at a time, to be taken out of their list.
    fn each<T: DataType>(
        &self,
        path: &Path,
        name: &str,
        want: Physical,
        take: impl FnMut(&mut Vec<T::T>) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        decoding(|| self.decode::<T>(path, name, want, take))
            .unwrap_or_else(|problem| Err(damaged(path, format!("column {name:?}: {problem}"))))
    }

    fn decode<T: DataType>(
        &self,
        path: &Path,
        name: &str,
        want: Physical,
        mut take: impl FnMut(&mut Vec<T::T>) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let metadata = self.reader.metadata();
        let schema = metadata.file_metadata().schema_descr();
        let index = (0..schema.num_columns())
            .find(|&i| schema.column(i).name() == name)
            .ok_or_else(|| damaged(path, format!("no column {name:?}")))?;
        let column = schema.column(index);
        if column.physical_type() != want || column.max_def_level() != 0 || column.max_rep_level() != 0 {
            return Err(damaged(path, format!("column {name:?} is not of type required {want}")));
        }
        let fail = |e: ParquetError| damaged(path, format!("column {name:?}: {e}"));
        let mut values = Vec::new();
        for group in 0..metadata.num_row_groups() {
            let rows = self.reader.get_row_group(group).map_err(fail)?;
            let count = usize::try_from(rows.metadata().num_rows()).unwrap_or(0);
            let column: ColumnReader = rows.get_column_reader(index).map_err(fail)?;
            let mut reader = get_typed_column_reader::<T>(column);
            let mut missing = count;
            while missing > 0 {
                let (records, ..) =
                    reader.read_records(missing.min(PART), None, None, &mut values).map_err(fail)?;
                if records == 0 {
                    return Err(damaged(path, format!("column {name:?} has fewer than its {count} rows")));
                }
                take(&mut values)?;
                values.clear();
                missing = missing.saturating_sub(records);
            }
        }
        Ok(())
    }
}
