//! The data behind the header of an OpenCRG file: a row of numbers per lateral cut.

use super::super::Flaw;
use super::super::geotiff::number;
use super::header::{Header, Numbers, flaw};

/// The length of a record, bytes.
const RECORD: usize = 80;

/// The rows of the data behind the header, one after the other; NaN where there is no number. `rows` is their number, if the header
/// says so.
pub(super) fn read(header: &Header, bytes: &[u8], rows: Option<usize>) -> Result<Vec<f64>, Flaw> {
    match header.numbers {
        Numbers::Binary(size) => binary(bytes, size, header.channels.len(), rows),
        Numbers::Text(width) => text(header, bytes, width, rows),
    }
}

fn binary(bytes: &[u8], size: usize, columns: usize, rows: Option<usize>) -> Result<Vec<f64>, Flaw> {
    let whole = bytes.chunks_exact(size);
    let value = |b: &[u8]| match *b {
        [a, b, c, d] => f64::from(f32::from_be_bytes([a, b, c, d])),
        [a, b, c, d, e, f, g, h] => f64::from_be_bytes([a, b, c, d, e, f, g, h]),
        _ => f64::NAN,
    };
    let mut values: Vec<f64> = whole.map(value).collect();
    let there = values.len() / columns;
    let Some(wanted) = rows else {
        // The last record is filled with NaN, which may look like rows.
        values.truncate(there * columns);
        while values.len() >= columns && values[values.len() - columns..].iter().all(|v| v.is_nan()) {
            values.truncate(values.len() - columns);
        }
        return Ok(values);
    };
    if there < wanted {
        return Err(Flaw::Truncated(format!("{there} rows of data, but its header declares {wanted}")));
    }
    let left = values.len() - wanted * columns;
    if left >= RECORD / size {
        return Err(Flaw::Damaged(format!(
            "{left} numbers follow the {wanted} rows of {columns} that its header declares"
        )));
    }
    values.truncate(wanted * columns);
    Ok(values)
}

fn text(header: &Header, bytes: &[u8], width: usize, rows: Option<usize>) -> Result<Vec<f64>, Flaw> {
    let columns = header.channels.len();
    let mut values = Vec::new();
    let mut line = header.lines;
    let mut lines = bytes.split(|b| *b == b'\n').peekable();
    while let Some(bytes) = lines.next() {
        line += 1;
        let bytes = bytes.strip_suffix(b"\r").unwrap_or(bytes);
        if lines.peek().is_none() && bytes.iter().all(u8::is_ascii_whitespace) {
            break;
        }
        // Each row begins a record, and a record holds as many numbers as there is room for.
        let column = values.len() % columns;
        let here = (columns - column).min(RECORD / width);
        if bytes.len() > RECORD && bytes[RECORD..].iter().any(|b| !b.is_ascii_whitespace()) {
            return Err(flaw(line, format!("has more than the {RECORD} characters of a record")));
        }
        for k in 0..here {
            let field = bytes.get(k * width..).unwrap_or_default();
            let field = String::from_utf8_lossy(&field[..field.len().min(width)]);
            let field = field.trim();
            if field.is_empty() {
                let problem =
                    format!("ends before number {} of {here}: each takes {width} characters", k + 1);
                return Err(flaw(line, problem));
            }
            values.push(if field.starts_with('*') {
                f64::NAN
            } else {
                number(&field.replace(['D', 'd'], "E")).ok_or_else(|| {
                    flaw(line, format!("{field:?} is not a number: each takes {width} characters"))
                })?
            });
        }
        let rest = bytes.get(here * width..).unwrap_or_default();
        if rest.iter().any(|b| !b.is_ascii_whitespace()) {
            return Err(flaw(line, format!("has more than {here} numbers")));
        }
    }
    let there = values.len() / columns;
    if !values.len().is_multiple_of(columns) {
        return Err(Flaw::Truncated(format!(
            "its last row of data has {} of {columns} numbers",
            values.len() % columns
        )));
    }
    match rows {
        Some(wanted) if there < wanted => {
            Err(Flaw::Truncated(format!("{there} rows of data, but its header declares {wanted}")))
        }
        Some(wanted) if there > wanted => {
            Err(Flaw::Damaged(format!("{there} rows of data, but its header declares {wanted}")))
        }
        _ => Ok(values),
    }
}
