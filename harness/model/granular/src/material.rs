//! Granular materials as data: `tasks/soils/granular/*.yaml`.

use serde::{Deserialize, Serialize};
use vb_files::{Document, Flaw, Schema};
use vb_world::GranularMaterial;

/// A file of a granular material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    pub schema: Schema<1>,
    pub name: String,
    /// A description in one line, for people.
    pub description: String,
    pub grains: GranularMaterial,
}

impl Document for MaterialFile {
    type File = Self;
    const KIND: &'static str = "granular material";
    const FIELDS: &'static str = "docs/granular.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("gravel", include_str!("../../../../tasks/soils/granular/gravel.yaml")),
        ("sand", include_str!("../../../../tasks/soils/granular/sand.yaml")),
    ];

    fn from_file(material: Self) -> Result<Self, Flaw> {
        material.grains.check().map_err(|flaw| flaw.within("grains"))?;
        Ok(material)
    }
}

vb_files::document!(MaterialFile);
