//! Granular materials as data: `tasks/soils/granular/*.yaml`.

use serde::{Deserialize, Serialize};
use vb_files::document::within;
use vb_files::{Document, Flaw, Schema};

/// A granular material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub schema: Schema<1>,
    pub name: String,
    /// A description in one line, for people.
    pub description: String,
    /// The minimum and maximum radius of the grains, m. Radii are distributed uniformly between them.
    pub radius: [f64; 2],
    /// The density of a grain, kg/m³.
    pub density: f64,
    /// The friction coefficient between grains.
    pub friction: f64,
    /// The moment that resists rolling and twisting in a contact, over normal force and reduced radius of the contact: spheres stand for
    /// angular grains by it.
    pub rolling_resistance: f64,
    /// The attraction of two grains that touch, over the cross-section of the smaller one, Pa.
    #[serde(default)]
    pub cohesion: f64,
    /// Reduction of friction and rolling resistance while the grains are poured, from 0 (loose) to 1 (as dense as without
    /// friction).
    #[serde(default)]
    pub compaction: f64,
}

impl Document for Material {
    type File = Self;
    const KIND: &'static str = "granular material";
    const FIELDS: &'static str = "docs/granular.md";
    const BUILTIN: &'static [(&'static str, &'static str)] = &[
        ("gravel", include_str!("../../../../tasks/soils/granular/gravel.yaml")),
        ("sand", include_str!("../../../../tasks/soils/granular/sand.yaml")),
    ];

    fn from_file(material: Self) -> Result<Self, Flaw> {
        let [least, most] = material.radius;
        // Smaller grains need smaller steps and far more of them than memory holds.
        within("radius[0]", least, 0.005, 0.5)?;
        within("radius[1]", most, least, 3.0 * least)?;
        within("density", material.density, 100.0, 20_000.0)?;
        within("friction", material.friction, 0.0, 2.0)?;
        within("rolling_resistance", material.rolling_resistance, 0.0, 2.0)?;
        within("cohesion", material.cohesion, 0.0, 1e5)?;
        within("compaction", material.compaction, 0.0, 1.0)?;
        Ok(material)
    }
}

vb_files::document!(Material);

impl Material {
    /// Mass of a grain of a radius (m), kg.
    #[must_use]
    pub fn mass(&self, radius: f64) -> f64 {
        self.density * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
    }

    /// The same grains while they are poured.
    pub(crate) fn poured(&self) -> Self {
        let left = 1.0 - self.compaction;
        Self {
            friction: self.friction * left,
            rolling_resistance: self.rolling_resistance * left,
            ..self.clone()
        }
    }

    /// Mean volume of a grain, m³: radii are uniform between the minimum a and the maximum b, so the mean cube is
    /// (a + b)(a² + b²)/4.
    #[must_use]
    pub fn mean_volume(&self) -> f64 {
        let [a, b] = self.radius;
        4.0 / 3.0 * std::f64::consts::PI * (a + b) * (a * a + b * b) / 4.0
    }

    /// Mean radius, m.
    #[must_use]
    pub fn mean_radius(&self) -> f64 {
        0.5 * (self.radius[0] + self.radius[1])
    }
}
