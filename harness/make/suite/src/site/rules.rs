//! The rules for the conversion of a survey to worlds, as data: `tasks/generator/site.yaml` and files like it.

use std::collections::BTreeMap;

use serde::Deserialize;
use vb_files::{Document, Flaw, Schema};
use vb_world::{SoilLevels, TerrainClass};

use crate::rules::{self, MOST_NODES, Square, flaw};

/// The rules for the conversion of a survey to worlds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SiteParams {
    pub schema: Schema<1>,
    pub name: String,
    /// The node spacing of a world, m.
    pub resolution: f64,
    /// The side of a patch of one terrain class, m.
    pub patch: f64,
    /// The side of a world, m.
    pub side: f64,
    pub ground: SiteGround,
}

/// The rules for the terrain classes of a site.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SiteGround {
    /// The rules by slope and height; the first one that applies determines the class.
    pub rules: Vec<GroundRule>,
    /// The class of each value of a label raster.
    pub legend: BTreeMap<u16, TerrainClass>,
    /// The level of each deformable class.
    pub soil: SoilLevels,
}

/// A terrain class for a range of slopes and heights.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundRule {
    pub class: TerrainClass,
    /// The minimum and the maximum slope, degrees.
    #[serde(default = "always")]
    pub slope: [f64; 2],
    /// The minimum and the maximum height above the lowest point of the world, m.
    #[serde(default = "always")]
    pub height: [f64; 2],
}

fn always() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
}

impl GroundRule {
    /// A rule without conditions, for any slope and height.
    pub(crate) const ALWAYS: Self = Self {
        class: TerrainClass::Dirt,
        slope: [f64::NEG_INFINITY, f64::INFINITY],
        height: [f64::NEG_INFINITY, f64::INFINITY],
    };

    pub(crate) fn holds(&self, slope: f64, height: f64) -> bool {
        let within = |[low, high]: [f64; 2], v: f64| (low..=high).contains(&v);
        within(self.slope, slope) && within(self.height, height)
    }
}

impl Default for SiteParams {
    /// `tasks/generator/site.yaml`, which is part of the build.
    fn default() -> Self {
        rules::built_in(Self::DEFAULT_YAML)
    }
}

impl SiteParams {
    pub const DEFAULT_YAML: &'static str = include_str!("../../../../../tasks/generator/site.yaml");

    fn square(&self) -> Square {
        Square { resolution: self.resolution, patch: self.patch, side: self.side }
    }

    /// Nodes along a side of a world.
    pub(crate) fn nodes(&self) -> usize {
        self.square().nodes()
    }

    /// Patches along a side of a world.
    pub(crate) fn patches(&self) -> usize {
        self.square().patches()
    }
}

impl Document for SiteParams {
    type File = Self;
    const KIND: &'static str = "rules";
    const FIELDS: &'static str = "docs/making-suites.md";

    fn from_file(rules: Self) -> Result<Self, Flaw> {
        rules.check()?;
        Ok(rules)
    }
}

vb_files::document!(SiteParams);

impl SiteParams {
    fn check(&self) -> Result<(), Flaw> {
        self.square().check("")?;
        if self.nodes() > MOST_NODES {
            let most = (MOST_NODES - 1) as f64 * self.resolution;
            return Err(flaw("side", format!("{} must not exceed {most} at this resolution", self.side)));
        }
        let rules = &self.ground.rules;
        for (k, rule) in rules.iter().enumerate() {
            for (name, [low, high]) in [("slope", rule.slope), ("height", rule.height)] {
                if low.is_nan() || high.is_nan() || low > high {
                    let field = format!("ground.rules[{k}].{name}");
                    return Err(flaw(field, format!("[{low}, {high}] must be two numbers, lower first")));
                }
            }
        }
        if rules.last().is_none_or(|last| last.slope != always() || last.height != always()) {
            let problem = "the last rule must apply everywhere: give it neither slope nor height";
            return Err(flaw("ground.rules", problem));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flaws_of_a_site_file_are_named() {
        let cases = [
            ("schema: 1", "schema: 3", "version 3 is not supported"),
            ("resolution: 1.0", "resolution: 0", "resolution: 0 must lie in"),
            ("patch: 8.0", "patch: 7.5", "patch: 7.5 must be a multiple of resolution, 1"),
            ("side: 128.0", "side: 100.0", "side: 100 must be a multiple of patch, 8"),
            ("side: 128.0", "side: 8000.0", "side: 8000 must not exceed 4096"),
            ("class: rock", "class: lava", "ground.rules[0].class"),
            (
                "[20.0, 35.0]",
                "[40.0, 35.0]",
                "ground.rules[1].slope: [40, 35] must be two numbers, lower first",
            ),
            (
                "- {class: grass}",
                "- {class: grass, height: [0.0, 3.0]}",
                "the last rule must apply everywhere",
            ),
            ("legend: {}", "legend: {1: swamp}", "ground.legend"),
            ("side: 128.0", "sides: 128.0", "sides"),
        ];
        for (from, to, expected) in cases {
            assert!(SiteParams::DEFAULT_YAML.contains(from), "{from}");
            let text = SiteParams::DEFAULT_YAML.replacen(from, to, 1);
            let message = SiteParams::parse(&text, "mine.yaml").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\nlacks {expected}");
        }
        assert_eq!((SiteParams::default().nodes(), SiteParams::default().patches()), (129, 16));
    }
}
