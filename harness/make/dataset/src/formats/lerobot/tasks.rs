//! The list of tasks, as pandas writes a table whose index is the task in words.

use std::sync::Arc;

use arrow_array::{ArrayRef, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use serde_json::json;

use crate::error::DatasetError;

/// The content of `meta/tasks.parquet`.
pub(crate) fn write_tasks(tasks: &[String]) -> Result<Vec<u8>, DatasetError> {
    let fail = |e: &dyn std::fmt::Display| DatasetError::Encode { detail: e.to_string() };
    let column = |name: &str, pandas: &str, numpy: &str| json!({"name": name, "field_name": name, "pandas_type": pandas, "numpy_type": numpy, "metadata": null});
    // What pandas reads to know which column is the index.
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "creator": {"library": "vb-dataset", "version": env!("CARGO_PKG_VERSION")},
        "pandas_version": "2.0.0"
    });
    let fields =
        vec![Field::new("task_index", DataType::Int64, false), Field::new("task", DataType::Utf8, false)];
    let metadata = std::collections::BTreeMap::from([("pandas".to_owned(), pandas.to_string())]);
    let schema = Arc::new(Schema::new(fields).with_metadata(metadata));
    let columns: Vec<ArrayRef> = vec![
        Arc::new(Int64Array::from_iter_values(0..tasks.len() as i64)),
        Arc::new(StringArray::from_iter_values(tasks)),
    ];
    let rows = RecordBatch::try_new(schema.clone(), columns).map_err(|e| fail(&e))?;
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, schema, None).map_err(|e| fail(&e))?;
    writer.write(&rows).map_err(|e| fail(&e))?;
    writer.close().map_err(|e| fail(&e))?;
    Ok(bytes)
}
