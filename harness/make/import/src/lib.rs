//! Vehicles of other programs as vehicle files: Project Chrono's JSON sets ([`chrono`]) and URDF or xacro ([`urdf`]).
//!
//! A conversion never drops a value silently. Each value of the source is read, or stands in [`Imported::notes`], as does each
//! value of the result that the source does not give. Sources are untrusted: sizes, depths and counts are bounded, and a file
//! that makes no sense is an [`ImportError`] with file, place and next step.

#![deny(missing_docs)]

pub mod chrono;
mod emit;
mod error;
mod hull;
mod note;
mod place;
pub mod urdf;

pub use error::ImportError;
pub use note::{Kind, Note, Notes};

use std::path::{Path, PathBuf};
use vb_vehicle::VehicleSpec;

/// The most that is read of a source file of numbers, bytes.
pub(crate) const MOST: u64 = 4 << 20;

/// Choices that the source leaves open.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The name of the vehicle; the source's if absent.
    pub name: Option<String>,
    /// The scale of the worlds that the vehicle is made for; chosen from its length if absent.
    pub scale: Option<f64>,
    /// The folder to which the paths within a source are relative; searched above the source if absent.
    pub data: Option<PathBuf>,
    /// Chrono: the engine's file; chosen from the set if absent.
    pub engine: Option<PathBuf>,
    /// Chrono: the transmission's file; chosen from the set if absent.
    pub transmission: Option<PathBuf>,
    /// Chrono: the tyres' files, one for all axles or one per axle in the order of the vehicle's file; chosen from the set if empty.
    pub tyres: Vec<PathBuf>,
    /// xacro: values of arguments, by name.
    pub arguments: Vec<(String, String)>,
}

/// A converted vehicle.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The vehicle, valid as a vehicle file.
    pub spec: VehicleSpec,
    /// Choices, approximations, assumptions, and values of the source without a counterpart.
    pub notes: Notes,
    /// The source, for the head of the file.
    pub source: String,
}

impl Imported {
    /// The vehicle file: the notes as comments, then the vehicle.
    #[must_use]
    pub fn file(&self) -> String {
        emit::file(self)
    }
}

/// Converts a file, whose format follows from its content.
///
/// # Errors
/// Returns an error if the file or a file that it refers to cannot be read, is of another format, or describes no vehicle that the
/// simulator has.
pub fn import(file: &Path, options: &Options) -> Result<Imported, ImportError> {
    let text = vb_files::read_text(file, MOST).map_err(|e| ImportError::reading(file, &e))?;
    let start = text.trim_start_matches('\u{feff}').trim_start();
    let imported = if start.starts_with('<') {
        urdf::import(file, &text, options)?
    } else if start.starts_with(['{', '/']) {
        chrono::import(file, &text, options)?
    } else {
        let problem = "neither JSON of Project Chrono nor URDF or xacro; give one of these, or write the vehicle file as \
                       docs/custom-vehicle.md describes";
        return Err(ImportError::new(file.display(), "", problem));
    };
    // What is written can be read: the checks of vehicle files are those of the result.
    let name = format!("{} (converted)", file.display());
    <VehicleSpec as vb_files::Document>::parse(&imported.file(), &name).map_err(ImportError::invalid)?;
    Ok(imported)
}
