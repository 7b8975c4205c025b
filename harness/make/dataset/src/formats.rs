//! The list of formats.

use crate::format::Files;
use crate::header::Format;
use crate::lerobot::LeRobot;

/// The files of a format.
pub(crate) fn files(format: Format) -> &'static dyn Files {
    match format {
        Format::LeRobot => &LeRobot,
    }
}
