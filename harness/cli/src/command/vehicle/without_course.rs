//! Courses for `vehicle test`, of a program that is built without readers of elevation files.

use std::path::Path;

use vb_validate::NamedCourse;

use crate::error::CliError;

/// Refuses to read one.
pub(super) fn read(_: &Path) -> Result<NamedCourse, CliError> {
    Err(CliError::usage(crate::missing("OpenCRG files", "terrain")))
}
