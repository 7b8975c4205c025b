//! Courses for the events of `vehicle test` that drive over one.

use std::path::Path;

use vb_validate::NamedCourse;

use crate::error::CliError;
use crate::output;

/// Reads the course of an OpenCRG file, and prints its summary and what was made of the file.
pub(super) fn read(path: &Path) -> Result<NamedCourse, CliError> {
    let file = vb_terrain::read::course(path).map_err(CliError::input)?;
    output::note(&file.course.summary());
    for note in &file.notes {
        output::say(&format!("note: {note}"));
    }
    let name = path.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    Ok(NamedCourse { name, course: file.course })
}
