//! The rules of a bed as data: `tasks/generator/testbed.yaml` and files like it.

use serde::Deserialize;
use vb_files::document::within;
use vb_files::{Document, Flaw, Schema};
use vb_world::{Elevation, TerrainClass};

use crate::generate::{
    Normal, StandParams, check_clip, check_friction, check_model, check_path, check_stand,
};
use crate::path::PathParams;
use crate::rules::{self, MOST_NODES, Square, flaw};

/// The rules of a bed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestbedParams {
    #[serde(rename = "schema")]
    _schema: Schema<1>,
    pub name: String,
    pub bed: BedParams,
    /// The heights of the beds.
    pub elevation: BedElevation,
    /// The materials of the patches.
    pub materials: Materials,
    pub trials: TrialParams,
    pub stand: StandParams,
    pub path: PathParams,
}

/// The size of the square bed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BedParams {
    /// The side of the bed, m.
    pub side: f64,
    /// The node spacing, m.
    pub resolution: f64,
    /// The side of a patch of one material, m.
    pub patch: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BedElevation {
    /// The terrain model: the name of one in `tasks/terrain`, or a file.
    pub model: String,
    /// The beds, in the order of the suite's worlds.
    pub beds: Vec<BedLevel>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BedLevel {
    /// The elevation level of the bed.
    pub level: Elevation,
    /// The standard deviation of the height over many beds of the level, m.
    pub std: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Materials {
    /// The minimum and the maximum friction of a patch.
    pub clip: [f64; 2],
    /// The materials; each covers the same number of patches, or one more.
    pub all: Vec<Material>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub name: String,
    /// The rigid terrain class that planners receive.
    pub class: TerrainClass,
    /// The mean of a patch's Coulomb friction.
    pub mean: f64,
    /// The standard deviation of a patch's Coulomb friction.
    pub std: f64,
}

impl Material {
    pub(super) fn friction(&self) -> Normal {
        Normal { mean: self.mean, std: self.std }
    }
}

/// The repeated trials of one task.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialParams {
    /// The number of trials on a bed.
    pub count: usize,
    /// The distance from start to goal, m.
    pub distance: f64,
    pub noise: StartNoise,
}

/// The standard deviations of the start pose; deviations are clipped at two standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartNoise {
    /// The standard deviation along x and along y, m.
    pub position: f64,
    /// The standard deviation of the heading, degrees.
    pub heading: f64,
}

impl Default for TestbedParams {
    /// `tasks/generator/testbed.yaml`, which is part of the build.
    fn default() -> Self {
        rules::built_in(Self::DEFAULT_YAML)
    }
}

impl TestbedParams {
    pub const DEFAULT_YAML: &'static str = include_str!("../../../../../tasks/generator/testbed.yaml");

    fn check_materials(&self) -> Result<(), Flaw> {
        let Materials { clip, all } = &self.materials;
        check_clip("materials.clip", *clip)?;
        if all.is_empty() {
            return Err(flaw("materials.all", "is empty: at least one material is needed"));
        }
        for (k, material) in all.iter().enumerate() {
            let field = format!("materials.all[{k}]");
            if material.class.is_deformable() {
                let problem = format!("{} is deformable: use a rigid class", material.class.name());
                return Err(flaw(format!("{field}.class"), problem));
            }
            check_friction(&field, material.friction())?;
        }
        Ok(())
    }

    fn square(&self) -> Square {
        let BedParams { side, resolution, patch } = self.bed;
        Square { resolution, patch, side }
    }

    /// Nodes along a side.
    pub(super) fn nodes(&self) -> usize {
        self.square().nodes()
    }

    /// Patches along a side.
    pub(super) fn patches(&self) -> usize {
        self.square().patches()
    }
}

impl Document for TestbedParams {
    type File = Self;
    const KIND: &'static str = "rules";
    const FIELDS: &'static str = "docs/testbed.md";

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.check()?;
        Ok(rules)
    }
}

vb_files::document!(TestbedParams);

impl TestbedParams {
    fn check(&self) -> Result<(), Flaw> {
        self.square().check("bed.")?;
        let side = self.bed.side;
        if !(3..=MOST_NODES).contains(&self.nodes()) {
            let problem = format!("{side} must be 2 to {} times bed.resolution", MOST_NODES - 1);
            return Err(flaw("bed.side", problem));
        }
        check_model("elevation.model", &self.elevation.model)?;
        if !(1..=999).contains(&self.elevation.beds.len()) {
            return Err(flaw("elevation.beds", "must have 1 to 999 entries"));
        }
        for (k, bed) in self.elevation.beds.iter().enumerate() {
            within(&format!("elevation.beds[{k}].std"), bed.std, 1e-3, 100.0)?;
        }
        self.check_materials()?;
        let TrialParams { count, distance, noise } = self.trials;
        within("trials.count", count, 1, 100)?;
        within("trials.noise.position", noise.position, 0.0, 0.05 * side)?;
        within("trials.noise.heading", noise.heading, 0.0, 90.0)?;
        // Both ends lie on the bed with their stands, whatever the direction and the noise.
        let room = 0.5 * side - self.stand.reach.max(2.0 * noise.position);
        within("trials.distance", distance, f64::MIN_POSITIVE, 2.0 * room)?;
        check_stand("stand", &self.stand, 0.5 * side)?;
        check_path("path", &self.path, 0.5 * side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flaws_of_a_file_are_named() {
        let cases = [
            ("schema: 1", "schema: 2", "version 2 is not supported"),
            ("resolution: 0.5", "resolution: 0.0", "bed.resolution: 0 must lie in"),
            ("patch: 10.0", "patch: 10.2", "bed.patch: 10.2 must be a multiple of bed.resolution, 0.5"),
            ("side: 80.0", "side: 85.0", "bed.side: 85 must be a multiple of bed.patch, 10"),
            ("resolution: 0.5", "resolution: 0.001", "bed.side: 80 must be 2 to 4096 times bed.resolution"),
            ("level: high", "level: steep", "elevation.beds[1].level"),
            ("std: 0.55", "std: -0.55", "elevation.beds[1].std: -0.55 must lie in"),
            ("model: rocks", "model: ''", "elevation.model: is empty"),
            ("class: wood", "class: sand", "materials.all[3].class: sand is deformable"),
            ("mean: 0.36", "mean: 3.6", "materials.all[2].mean: 3.6 must lie in 0 to 2"),
            ("clip: [0.1, 1.0]", "clip: [0.1, 0.0]", "materials.clip[1]: 0 must lie in 0.1"),
            ("count: 5", "count: 0", "trials.count: 0 must lie in 1 to 100"),
            // A circle of 40 m less the stand's 3 m has a diameter of 74 m.
            ("distance: 72.0", "distance: 75.0", "trials.distance: 75 must lie in"),
            ("heading: 5.0", "heading: -5.0", "trials.noise.heading: -5 must lie in 0 to 90"),
            ("tilt: 15.0", "tilt: 95.0", "stand.tilt: 95 must lie in 0 to 90"),
            ("grid: 0.5,", "grid: 0.0,", "path.grid: 0 must lie in"),
            ("name: testbed", "names: testbed", "names"),
        ];
        for (from, to, expected) in cases {
            assert!(TestbedParams::DEFAULT_YAML.contains(from), "{from}");
            let text = TestbedParams::DEFAULT_YAML.replacen(from, to, 1);
            let message = TestbedParams::parse(&text, "mine.yaml").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\nlacks {expected}");
        }
        let params = TestbedParams::default();
        assert_eq!((params.nodes(), params.patches()), (161, 8));
    }
}
