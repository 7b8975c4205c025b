//! Project Chrono's JSON sets (chrono_vehicle; the format of `data/vehicle` of 2023 and later, and older names of keys and types).

mod beam;
mod chassis;
mod choice;
mod driveline;
mod finish;
mod json;
mod parts;
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

use crate::{ImportError, Imported, Notes, Options};
use json::Doc;
use set::Set;
use std::path::Path;

/// Converts the file of a vehicle, whose text is given, with all that it refers to.
///
/// # Errors
/// Returns an error if a file is missing, malformed or of another type than expected, or a template has no counterpart.
pub fn import(file: &Path, text: &str, options: &Options) -> Result<Imported, ImportError> {
    let name = file.display().to_string();
    let doc = Doc::parse(name.clone(), text)?;
    let root = doc.root();
    let problem = match set::kind(&doc)?.as_str() {
        "Vehicle" => String::new(),
        "TrackVehicle" | "TrackSystem" => {
            "a format of Chrono before 2020; give a file with \"Type\": \"Vehicle\" and a \"Template\""
                .to_owned()
        }
        other => format!(
            "{other:?} is a part of a vehicle; give the file with \"Type\": \"Vehicle\" that refers to it"
        ),
    };
    if !problem.is_empty() {
        return Err(ImportError::new(name, "Type", problem));
    }
    // A vehicle of SynChrono names the vehicle's file with powertrain and tyres.
    let whole = root.get("Vehicle").and_then(|v| v.get("Input File"));
    let reference = match &whole {
        Some(n) => Some(n.text()?),
        None => root.get("Chassis").and_then(|c| c.get("Input File")).map(|n| n.text()).transpose()?,
    };
    let set = Set::around(file, reference, options.data.as_deref())?;
    let full = std::fs::canonicalize(file).map_err(|e| ImportError::reading(file, &e))?;
    let whole = whole.is_some();
    let mut notes = Notes::default();
    let mut vehicle = set.add(&full, doc);
    let mut options = choice::named(&set, &vehicle.root(), options, &mut notes)?;
    if whole {
        for key in ["Vehicle", "Powertrain", "Tire"] {
            vehicle.root().get(key).inspect(json::Node::used);
        }
        vehicle = set.follow(&vehicle.root().need("Vehicle")?.need("Input File")?, &["Vehicle"])?;
        options = choice::named(&set, &vehicle.root(), &options, &mut notes)?;
    }
    let spec = match set::template(&vehicle)?.as_str() {
        "WheeledVehicle" => wheeled::convert(&set, &vehicle, &options, &mut notes)?,
        "TrackedVehicle" => tracked::convert(&set, &vehicle, &options, &mut notes)?,
        other => {
            let problem = format!("{other:?} has no counterpart; use WheeledVehicle or TrackedVehicle");
            return Err(ImportError::new(&vehicle.file, "Template", problem));
        }
    };
    set.list_unread(&mut notes);
    let source = format!("{} of Project Chrono", set.short(&full));
    let mut imported = Imported { spec, notes, source };
    finish::deviations(&mut imported);
    Ok(imported)
}
