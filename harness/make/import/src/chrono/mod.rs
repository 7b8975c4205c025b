//! Project Chrono's JSON sets (chrono_vehicle; the format of `data/vehicle` of 2023 and later).

mod beam;
mod chassis;
mod choice;
mod driveline;
mod finish;
mod json;
mod powertrain;
mod set;
mod steering;
mod strut;
mod suspension;
mod tir;
mod tracked;
mod tyre;
mod wheeled;

pub(crate) use finish::{Draft, build, deviations, to_the_left, travels};

use crate::{ImportError, Imported, MOST, Notes, Options};
use json::Doc;
use set::Set;
use std::path::Path;

/// Converts the file of a vehicle with all that it refers to.
///
/// # Errors
/// Returns an error if a file is missing, malformed or of another type than expected, or a template has no counterpart.
pub fn import(file: &Path, options: &Options) -> Result<Imported, ImportError> {
    let text = vb_files::read_text(file, MOST).map_err(|e| ImportError::reading(file, &e))?;
    let name = file.display().to_string();
    let doc = Doc::parse(name.clone(), &text)?;
    let root = doc.root();
    match set::kind(&doc)?.as_str() {
        "Vehicle" => {}
        "TrackVehicle" | "TrackSystem" | "Powertrain" => {
            let problem =
                "a format of Chrono before 2020; give a file with \"Type\": \"Vehicle\" and a \"Template\"";
            return Err(ImportError::new(name, "Type", problem));
        }
        other => {
            let problem = format!(
                "{other:?} is a part of a vehicle; give the file with \"Type\": \"Vehicle\" that refers to it"
            );
            return Err(ImportError::new(name, "Type", problem));
        }
    }
    let reference = root.get("Chassis").and_then(|c| c.get("Input File")).map(|n| n.text()).transpose()?;
    let set = Set::around(file, reference, options.data.as_deref())?;
    let full = std::fs::canonicalize(file).map_err(|e| ImportError::reading(file, &e))?;
    let vehicle = set.load(&full, &["Vehicle"])?;
    let mut notes = Notes::default();
    let spec = match set::template(&vehicle)?.as_str() {
        "WheeledVehicle" => wheeled::convert(&set, &vehicle, options, &mut notes)?,
        "TrackedVehicle" => tracked::convert(&set, &vehicle, options, &mut notes)?,
        other => {
            let problem = format!("{other:?} has no counterpart; WheeledVehicle and TrackedVehicle have");
            return Err(ImportError::new(&vehicle.file, "Template", problem));
        }
    };
    set.list_unread(&mut notes);
    let source = format!("{} of Project Chrono", set.short(&full));
    let mut imported = Imported { spec, notes, source };
    finish::deviations(&mut imported);
    Ok(imported)
}
