//! The little of Parquet that the store needs: one row group of required, non-nested columns.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, get_typed_column_reader};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use crate::StoreError;

/// A column's values.
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
    reader: SerializedFileReader<File>,
}

const HINT: &str = "the file is truncated or not a trace of this harness: run the task again";

/// An error about the content of the file.
pub(crate) fn damaged(path: &Path, detail: impl ToString) -> StoreError {
    // Parquet's own messages may span lines; ours never do.
    let detail = detail.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    StoreError::Damaged { path: path.to_owned(), detail, hint: HINT }
}

impl Table {
    pub(crate) fn open(path: &Path) -> Result<Self, StoreError> {
        let file = vb_files::open(path).map_err(StoreError::io("read", path))?;
        let reader = SerializedFileReader::new(file).map_err(|e| damaged(path, e))?;
        Ok(Self { reader })
    }

    /// The value of a metadata entry.
    pub(crate) fn meta(&self, path: &Path, key: &str) -> Result<&str, StoreError> {
        let entries = self.reader.metadata().file_metadata().key_value_metadata();
        entries
            .and_then(|all| all.iter().find(|e| e.key == key))
            .and_then(|e| e.value.as_deref())
            .ok_or_else(|| damaged(path, format!("no metadata entry {key:?}")))
    }

    /// Names of the columns.
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

    pub(crate) fn text(&self, path: &Path, name: &str) -> Result<Vec<String>, StoreError> {
        let bytes = self.read::<ByteArrayType>(path, name, Physical::BYTE_ARRAY)?;
        bytes
            .iter()
            .map(|b| {
                b.as_utf8().map(str::to_owned).map_err(|e| damaged(path, format!("column {name:?}: {e}")))
            })
            .collect()
    }

    fn read<T: DataType>(&self, path: &Path, name: &str, want: Physical) -> Result<Vec<T::T>, StoreError> {
        let metadata = self.reader.metadata();
        let schema = metadata.file_metadata().schema_descr();
        let index = (0..schema.num_columns())
            .find(|&i| schema.column(i).name() == name)
            .ok_or_else(|| damaged(path, format!("no column {name:?}")))?;
        let column = schema.column(index);
        if column.physical_type() != want || column.max_def_level() != 0 || column.max_rep_level() != 0 {
            return Err(damaged(path, format!("column {name:?} is not of required {want}s")));
        }
        let fail = |e: ParquetError| damaged(path, format!("column {name:?}: {e}"));
        let mut values = Vec::new();
        for group in 0..metadata.num_row_groups() {
            let rows = self.reader.get_row_group(group).map_err(fail)?;
            let count = usize::try_from(rows.metadata().num_rows()).unwrap_or(0);
            let column: ColumnReader = rows.get_column_reader(index).map_err(fail)?;
            let mut reader = get_typed_column_reader::<T>(column);
            let before = values.len();
            while values.len() - before < count {
                let missing = count - (values.len() - before);
                let (records, _, _) = reader.read_records(missing, None, None, &mut values).map_err(fail)?;
                if records == 0 {
                    return Err(damaged(path, format!("column {name:?} has fewer than its {count} rows")));
                }
            }
        }
        Ok(values)
    }
}
