//! The Rust bindings of the component, which the SDK carries ready-made: a planner's project would have to build the generator first,
//! which takes longer than all the rest of it.

use std::path::Path;

use wit_bindgen_core::wit_parser::Resolve;
use wit_bindgen_core::{Files, WorldGenerator as _};
use wit_bindgen_rust::Opts;

/// The world that planners export.
const WORLD: &str = "planner-plugin";

/// The module with the bindings of the package in a folder.
pub(crate) fn write(folder: &Path) -> Result<String, String> {
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e:#}", folder.display());
    let mut resolve = Resolve::default();
    let (package, _) = resolve.push_dir(folder).map_err(|e| failed(&e))?;
    let world = resolve.select_world(&[package], Some(WORLD)).map_err(|e| failed(&e))?;
    let options = Opts {
        format: true,
        pub_export_macro: true,
        export_macro_name: Some("export".into()),
        ..Opts::default()
    };
    let mut files = Files::default();
    options.build().generate(&mut resolve, world, &mut files).map_err(|e| failed(&e))?;
    let (_, bytes) = files.iter().next().ok_or_else(|| failed(&"no bindings were made"))?;
    let code = std::str::from_utf8(bytes).map_err(|e| failed(&e))?;
    Ok(format!("//! The bindings of `wit/v1_0/planner.wit`.\n//!\n//! {}\n\n{code}", crate::HEADER))
}
