//! Every task of every run as a table for programs: CSV and Parquet.

use std::borrow::Cow;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use vb_record::RunReader;
use vb_score::{Flag, FuelUse, Measured, Metrics, Reader, Ride, TaskRecord};

use crate::ReportError;
use crate::runs::Runs;

/// Rows that are gathered before they are written: what is in memory at a time.
const GROUP: usize = 20_000;

/// The names and values of a row.
type Row<'a> = Vec<(Cow<'static, str>, Cell<'a>)>;

enum Cell<'a> {
    Text(Cow<'a, str>),
    Number(Option<f64>),
    Count(Option<u64>),
}

/// The columns of one task, with their names. Names and units are those of tasks.jsonl, with `fuel_` before those of fuel.
fn cells<'a>(run: &'a str, r: &'a TaskRecord) -> Row<'a> {
    let text = |t: &'a str| Cell::Text(Cow::Borrowed(t));
    let class = match r.three_way {
        vb_score::ThreeWay::Success => "success",
        vb_score::ThreeWay::Rollover => "rollover",
        vb_score::ThreeWay::Stuck => "stuck",
    };
    let cells = vec![
        ("run", text(run)),
        ("task", text(r.task.as_str())),
        ("world", text(&r.world)),
        ("elevation", text(r.elevation.name())),
        ("terrain", text(r.terrain.name())),
        ("density", text(r.density.name())),
        ("outcome", text(r.outcome.name())),
        ("three_way", text(class)),
        ("reason", text(&r.reason)),
        ("cause", text(r.cause.map_or("", vb_score::Cause::name))),
        ("evidence", text(&r.evidence)),
        ("fault", text(r.fault.map_or("", |code| code.name()))),
        ("time_s", Cell::Number(Some(r.time_s))),
        ("state_hash", text(&r.state_hash)),
        ("sim_steps", Cell::Count(Some(r.sim_steps))),
        ("planner_steps", Cell::Count(Some(r.planner_steps))),
        ("clamped", Cell::Count(Some(r.clamped))),
    ];
    // 0 or 1, so that a sum counts.
    let flags = Flag::ALL.map(|flag| {
        let is = r.flags.get(&flag).map(|is| u64::from(*is));
        (flag.name(), Cell::Count(is))
    });
    let own = |(name, cell)| (Cow::Borrowed(name), cell);
    let of_fuel = |(name, cell): (&'static str, _)| {
        let name = if name == "memory_bytes" { name.into() } else { format!("fuel_{name}").into() };
        (name, cell)
    };
    let metrics = columns(Metrics::MEASURES, r.metrics.as_ref()).map(own);
    let ride = columns(Ride::MEASURES, r.ride.as_ref()).map(own);
    let fuel = columns(FuelUse::MEASURES, r.fuel.as_ref()).map(of_fuel);
    cells.into_iter().chain(flags).map(own).chain(metrics).chain(ride).chain(fuel).collect()
}

/// A column a measure, empty where the task has none of them.
fn columns<'a, T>(
    measures: &'static [Measured<T>],
    of: Option<&'a T>,
) -> impl Iterator<Item = (&'static str, Cell<'a>)> {
    measures.iter().map(move |m| {
        let cell = match m.value {
            Reader::Count(read) => Cell::Count(of.map(read)),
            Reader::Number(read) => Cell::Number(of.map(read)),
            Reader::Optional(read) => Cell::Number(of.and_then(read)),
            Reader::Flag(read) => Cell::Count(of.map(|of| u64::from(read(of)))),
        };
        (m.name, cell)
    })
}

/// Hands over each task of each run, in the order in which they ended.
fn each(runs: &Runs, mut take: impl FnMut(Row<'_>) -> Result<(), ReportError>) -> Result<(), ReportError> {
    for run in &runs.runs {
        let mut result = Ok(());
        RunReader::open(&run.dir)?.each_record(|record: TaskRecord| {
            if result.is_ok() {
                result = take(cells(&run.label, &record));
            }
        })?;
        result?;
    }
    Ok(())
}

/// Text that a spreadsheet would take for a formula, marked as text.
pub(crate) fn no_formula(text: &str) -> Cow<'_, str> {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Writes every task of every run as CSV (RFC 4180) with a header. What is missing is empty; texts that begin like a
/// formula get an apostrophe in front. `path` is what the file is called in errors.
pub fn write_csv(runs: &Runs, file: impl Write, path: &Path) -> Result<(), ReportError> {
    let fail = ReportError::write::<csv::Error>(path);
    let mut writer = csv::Writer::from_writer(file);
    let mut begun = false;
    each(runs, |cells| {
        if !begun {
            begun = true;
            writer.write_record(cells.iter().map(|(name, _)| name.as_ref())).map_err(&fail)?;
        }
        let texts = cells.iter().map(|(_, cell)| match cell {
            Cell::Text(t) => no_formula(t).into_owned(),
            Cell::Number(v) => v.map_or_else(String::new, |v| v.to_string()),
            Cell::Count(v) => v.map_or_else(String::new, |v| v.to_string()),
        });
        writer.write_record(texts).map_err(&fail)
    })?;
    writer.flush().map_err(ReportError::write(path))
}

/// A column of a row group.
enum Column {
    Text(Vec<ByteArray>),
    Number(Vec<f64>, Vec<i16>),
    Count(Vec<i64>, Vec<i16>),
}

/// Writes every task of every run as a Parquet file (snappy): texts as strings, measures as DOUBLE and counts as INT64,
/// null where they are missing. `path` is what the file is called in errors.
pub fn write_parquet(runs: &Runs, file: impl Write + Send, path: &Path) -> Result<(), ReportError> {
    let fail = ReportError::write::<ParquetError>(path);
    let mut file = Some(BufWriter::new(file));
    let mut writer = None;
    let mut columns: Vec<Column> = Vec::new();
    let mut rows = 0;
    each(runs, |cells| {
        if let Some(out) = file.take() {
            writer = Some(open(out, &cells).map_err(&fail)?);
        }
        if columns.is_empty() {
            columns = cells.iter().map(|(_, cell)| empty(cell)).collect();
        }
        for (column, (_, cell)) in columns.iter_mut().zip(cells) {
            push(column, cell);
        }
        rows += 1;
        if rows == GROUP
            && let Some(writer) = &mut writer
        {
            rows = 0;
            write_group(writer, std::mem::take(&mut columns)).map_err(&fail)?;
        }
        Ok(())
    })?;
    if let Some(mut writer) = writer {
        if rows > 0 {
            write_group(&mut writer, columns).map_err(&fail)?;
        }
        writer.close().map_err(&fail)?;
    }
    Ok(())
}

fn open<W: Write + Send>(
    out: W,
    cells: &[(Cow<'static, str>, Cell<'_>)],
) -> Result<SerializedFileWriter<W>, ParquetError> {
    let mut fields = Vec::with_capacity(cells.len());
    for (name, cell) in cells {
        let (kind, repetition) = match cell {
            Cell::Text(_) => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
            Cell::Number(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
            Cell::Count(_) => (Physical::INT64, Repetition::OPTIONAL),
        };
        let mut field = Type::primitive_type_builder(name, kind).with_repetition(repetition);
        if kind == Physical::BYTE_ARRAY {
            field = field.with_logical_type(Some(LogicalType::String));
        }
        fields.push(Arc::new(field.build()?));
    }
    let schema = Type::group_type_builder("vertibench_tasks").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))
}

fn empty(cell: &Cell<'_>) -> Column {
    match cell {
        Cell::Text(_) => Column::Text(Vec::new()),
        Cell::Number(_) => Column::Number(Vec::new(), Vec::new()),
        Cell::Count(_) => Column::Count(Vec::new(), Vec::new()),
    }
}

fn push(column: &mut Column, cell: Cell<'_>) {
    match (column, cell) {
        (Column::Text(values), Cell::Text(t)) => values.push(ByteArray::from(t.as_ref())),
        (Column::Number(values, there), Cell::Number(v)) => {
            values.extend(v);
            there.push(i16::from(v.is_some()));
        }
        (Column::Count(values, there), Cell::Count(v)) => {
            // Counts beyond i64 don't happen: a saturated one is as good as any.
            values.extend(v.map(|v| i64::try_from(v).unwrap_or(i64::MAX)));
            there.push(i16::from(v.is_some()));
        }
        // All rows have the same columns.
        _ => {}
    }
}

fn write_group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    columns: Vec<Column>,
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut out) = group.next_column()? else { break };
        match column {
            Column::Text(v) => out.typed::<ByteArrayType>().write_batch(&v, None, None)?,
            Column::Number(v, there) => out.typed::<DoubleType>().write_batch(&v, Some(&there), None)?,
            Column::Count(v, there) => out.typed::<Int64Type>().write_batch(&v, Some(&there), None)?,
        };
        out.close()?;
    }
    group.close().map(drop)
}
