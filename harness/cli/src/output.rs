//! Writing to stdout, stderr and files. A reader that went away is no error: results are on disk. Any other failure of stdout is one –
//! whoever sends results to a file must not believe that they are there – and the program ends with it.

use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::sync::OnceLock;

use serde::Serialize;
use vb_score::Outcome;

use crate::error::CliError;

/// Why stdout could not be written, the first time that it couldn't.
static FAILURE: OnceLock<String> = OnceLock::new();

/// Text to stdout.
pub(crate) fn text(text: &str) {
    let mut out = std::io::stdout().lock();
    check(out.write_all(text.as_bytes()).and_then(|()| out.flush()));
}

/// Remembers a failure of stdout.
pub(crate) fn check(written: std::io::Result<()>) {
    if let Err(e) = written
        && e.kind() != ErrorKind::BrokenPipe
    {
        let _ = FAILURE.set(e.to_string());
    }
}

/// The error that stdout could not be written, if so.
pub(crate) fn failure() -> Option<CliError> {
    let why = FAILURE.get()?;
    Some(CliError::output(format!(
        "cannot write to the standard output: {why} (free some space, or send it elsewhere)"
    )))
}

/// The number of columns of the terminal that stdout goes to; none for files and pipes, which have no end of a line.
pub(crate) fn width() -> Option<usize> {
    let out = console::Term::stdout();
    // Less than this is no width to write for.
    out.is_term().then(|| out.size_checked()).flatten().map(|(_, columns)| usize::from(columns).max(40))
}

/// An outcome in its colour, if stderr is a terminal that has colours and nobody asked for none (`NO_COLOR`).
pub(crate) fn coloured(outcome: Outcome) -> console::StyledObject<&'static str> {
    let style = console::Style::new().for_stderr();
    let style = match outcome {
        Outcome::Success => style.green(),
        Outcome::Rollover => style.red(),
        Outcome::Stuck => style.yellow(),
        Outcome::Timeout | Outcome::OutOfBounds => style.cyan(),
        Outcome::PlannerError | Outcome::SimError | Outcome::HostError => style.magenta().bold(),
    };
    style.apply_to(outcome.name())
}

/// One JSON object on a line of stdout.
pub(crate) fn json<T: Serialize>(value: &T) {
    match serde_json::to_string(value) {
        Ok(line) => text(&(line + "\n")),
        Err(e) => note(&format!("cannot encode a message: {e}")),
    }
}

/// Writes a file.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), CliError> {
    std::fs::write(path, content).map_err(|e| unwritten(path, &e))
}

/// Looks whether a file can be written, before the work for it is done.
///
/// # Errors
/// Returns the error that writing it would end in.
pub(crate) fn must_be_writable(path: &Path) -> Result<(), CliError> {
    let was_there = path.exists();
    let opened = std::fs::OpenOptions::new().append(true).create(true).open(path);
    opened.map_err(|e| unwritten(path, &e))?;
    if !was_there {
        std::fs::remove_file(path).map_err(|e| unwritten(path, &e))?;
    }
    Ok(())
}

/// Makes a folder, and those that it is in.
pub(crate) fn create_dir(path: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(path).map_err(|e| unwritten(path, &e))
}

/// Why a file or a folder isn't there.
fn unwritten(path: &Path, e: &std::io::Error) -> CliError {
    CliError::output(format!("cannot write {}: {e}", path.display()))
}

/// A line to stderr.
pub(crate) fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// The one line that tells why a command failed.
pub(crate) fn error(e: &CliError) {
    note(&format!("error: {e}"));
}

/// Rows of cells as text with aligned columns: to the left, two spaces between.
pub(crate) fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            line += cell;
            line += &" ".repeat(width + 2 - cell.chars().count());
        }
        out += line.trim_end();
        out.push('\n');
    }
    out
}
