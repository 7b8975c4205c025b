//! Sets of soils as data: `tasks/soils/*.yaml`.

use super::law::SoilLaw;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vb_files::document::within;
use vb_files::{Document, Flaw, Schema};
use vb_world::{SoilLevel, TerrainClass};

/// A set of soils and the hash of its file, by which runs are told apart.
#[derive(Clone, Debug)]
pub struct Soils {
    pub set: SoilSet,
    /// SHA-256 of the soils' file (hex).
    pub hash: String,
    /// Side of the cells in which soil remembers ruts, at scale 1, m.
    pub resolution: f64,
}

/// Named soils, and which of them each deformable class is made of at each level. The default has no soils: rigid
/// worlds need none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoilSet {
    pub schema: Schema<1>,
    pub name: String,
    /// A description in one line, for people.
    pub description: String,
    /// The soils by name.
    pub soils: BTreeMap<String, SoilLaw>,
    /// The names of the soils of mud, sand and snow.
    pub classes: Classes,
}

/// The names of the soils of the deformable classes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Classes {
    /// The soils of mud.
    pub mud: Levels,
    /// The soils of sand.
    pub sand: Levels,
    /// The soils of snow.
    pub snow: Levels,
}

/// The names of a class's soils.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Levels {
    /// The name of the soil at the level soft.
    pub soft: String,
    /// The name of the soil at the level medium.
    pub medium: String,
    /// The name of the soil at the level hard.
    pub hard: String,
}

impl Levels {
    fn of(&self, level: SoilLevel) -> &str {
        match level {
            SoilLevel::Soft => &self.soft,
            SoilLevel::Medium => &self.medium,
            SoilLevel::Hard => &self.hard,
        }
    }
}

impl SoilSet {
    /// The soil of a deformable class at a level; `None` for a rigid class.
    #[must_use]
    pub fn law(&self, class: TerrainClass, level: SoilLevel) -> Option<&SoilLaw> {
        self.soils.get(self.levels(class)?.of(level))
    }

    fn levels(&self, class: TerrainClass) -> Option<&Levels> {
        match class {
            TerrainClass::Mud => Some(&self.classes.mud),
            TerrainClass::Sand => Some(&self.classes.sand),
            TerrainClass::Snow => Some(&self.classes.snow),
            _ => None,
        }
    }

    fn check(&self) -> Result<(), Flaw> {
        for (name, law) in &self.soils {
            law.check().map_err(|flaw| flaw.within(&format!("soils.{name}")))?;
        }
        for class in TerrainClass::ALL {
            let Some(levels) = self.levels(class) else { continue };
            for level in SoilLevel::ALL {
                let wanted = levels.of(level);
                if !self.soils.contains_key(wanted) {
                    let names: Vec<_> = self.soils.keys().map(String::as_str).collect();
                    let field = format!("classes.{}.{}", class.name(), level.name());
                    let problem = format!("{wanted:?} is none of the soils: {}", names.join(", "));
                    return Err(Flaw::new(field, problem));
                }
            }
        }
        Ok(())
    }
}

impl Document for SoilSet {
    type File = Self;
    const KIND: &'static str = "soil set";
    const FIELDS: &'static str = "docs/soils.md";

    fn from_file(set: Self) -> Result<Self, Flaw> {
        set.check()?;
        Ok(set)
    }
}

vb_files::document!(SoilSet);

impl SoilLaw {
    fn check(&self) -> Result<(), Flaw> {
        self.sinkage.check().map_err(|flaw| flaw.within("sinkage"))?;
        self.slip_sinkage.check()?;
        within("cohesion", self.cohesion, 0.0, 1e6)?;
        within("friction_angle_deg", self.friction_angle_deg, 0.0, 60.0)?;
        within("shear_modulus", self.shear_modulus, 1e-4, 1.0)?;
        within("damping", self.damping, 0.0, 1e6)?;
        // Unloading softer than loading would give energy back; harder than this would need a smaller step.
        within("elastic_stiffness", self.elastic_stiffness, self.sinkage.softest_unloading(), 1e9)?;
        if let Some(steel) = self.steel_friction {
            within("steel_friction", steel, 0.0, 1.0)?;
        }
        if let Some(b) = self.bulldozing {
            within("bulldozing.erosion_angle_deg", b.erosion_angle_deg, 1.0, 80.0)?;
            within("bulldozing.flow", b.flow, 0.0, 2.0)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEFAULT: &str = include_str!("../../../../../tasks/soils/default.yaml");
    const ORIGINAL: &str = include_str!("../../../../../tasks/soils/original.yaml");
    const WONG: &str = include_str!("../../../../../tasks/soils/wong.yaml");

    #[test]
    fn the_shipped_sets_are_valid_and_name_a_soil_for_every_class_and_level() {
        for (name, text) in [("default", DEFAULT), ("original", ORIGINAL), ("wong", WONG)] {
            let set = SoilSet::parse(text, name).unwrap();
            assert_eq!(set.name, name);
            for class in TerrainClass::ALL {
                for level in SoilLevel::ALL {
                    assert_eq!(set.law(class, level).is_some(), class.is_deformable());
                }
            }
        }
    }

    #[test]
    fn within_a_class_a_softer_level_carries_less_at_every_sinkage_of_the_default_set() {
        let set = SoilSet::parse(DEFAULT, "default").unwrap();
        for class in [TerrainClass::Mud, TerrainClass::Sand, TerrainClass::Snow] {
            let p = |level, z| set.law(class, level).unwrap().pressure(z, 0.25);
            for z in [0.01, 0.03, 0.1] {
                assert!(p(SoilLevel::Soft, z) < p(SoilLevel::Medium, z), "{class:?} {z}");
                assert!(p(SoilLevel::Medium, z) < p(SoilLevel::Hard, z), "{class:?} {z}");
            }
        }
    }

    #[test]
    fn the_closed_form_of_each_shipped_soil_gives_the_sinkage_of_a_pressure() {
        for (name, text) in [("default", DEFAULT), ("original", ORIGINAL), ("wong", WONG)] {
            let set = SoilSet::parse(text, name).unwrap();
            for (soil, law) in &set.soils {
                for (pressure, breadth) in [(20e3, 0.1), (200e3, 0.3)] {
                    let depth = law.sinkage.plate_sinkage(pressure, breadth);
                    let found = law.sinkage.pressure(depth, breadth);
                    assert!((found / pressure - 1.0).abs() < 1e-9, "{name}, {soil}: {found} at {depth} m");
                }
            }
        }
    }

    #[test]
    fn the_levels_of_a_class_of_the_default_set_differ_and_mud_is_cohesive() {
        let set = SoilSet::parse(DEFAULT, "default").unwrap();
        for class in [TerrainClass::Mud, TerrainClass::Sand, TerrainClass::Snow] {
            let laws = SoilLevel::ALL.map(|level| *set.law(class, level).unwrap());
            assert!(laws[0] != laws[1] && laws[1] != laws[2], "{class:?}");
            for law in laws.iter().filter(|_| class == TerrainClass::Mud) {
                // Saturated fine-grained soil (Wong 2008, table 2.3).
                assert!(law.cohesion >= 4e3 && law.friction_angle_deg <= 13.0, "{law:?}");
            }
        }
        let all = |class| SoilLevel::ALL.map(|level| *set.law(class, level).unwrap());
        let (mud, snow) = (all(TerrainClass::Mud), all(TerrainClass::Snow));
        assert!(mud.iter().all(|m| snow.iter().all(|s| m != s)), "no mud is a snow");
    }

    #[test]
    fn the_originals_soils_have_no_slip_sinkage() {
        let set = SoilSet::parse(ORIGINAL, "original").unwrap();
        assert!(set.soils.values().all(|law| law.slip_sinkage == crate::soil::SlipSinkage::None));
    }

    #[test]
    fn messages_name_file_field_value_and_reason() {
        let broken = |from: &str, to: &str| {
            assert!(ORIGINAL.contains(from), "{from}");
            SoilSet::parse(&ORIGINAL.replacen(from, to, 1), "s.yaml").unwrap_err().to_string()
        };
        let e = broken("friction_angle_deg: 30.0", "friction_angle_deg: 95.0");
        assert!(e.starts_with("s.yaml: soils.") && e.contains("friction_angle_deg: 95 must lie in"), "{e}");
        let e = broken("soft: snow", "soft: slush");
        assert!(e.contains("classes.") && e.contains("\"slush\" is none of the soils: "), "{e}");
        let e = broken("elastic_stiffness: 4.0e7", "elastic_stiffness: 10.0");
        assert!(e.contains("elastic_stiffness: 10 must lie in"), "{e}");
        let e = broken("k_phi: 0.2e6", "k_phi: 0.2");
        assert!(e.contains("soils.snow.sinkage.k_phi: 0.2 must lie in"), "{e}");
        let e =
            broken("    cohesion: 0.0", "    slip_sinkage: {type: lyasko, strength: 2.0}\n    cohesion: 0.0");
        assert!(e.contains("soils.snow.slip_sinkage.strength: 2 must lie in"), "{e}");
        let e = broken(
            "type: bekker, k_phi: 0.2e6, k_c: 0.0, exponent: 1.1",
            "type: snow, depth: 0.2, density: 5.0",
        );
        assert!(e.contains("soils.snow.sinkage.density: 5 must lie in"), "{e}");
        let e = broken("cohesion: 0.0", "stickiness: 0.0");
        assert!(e.contains("stickiness"), "{e}");
    }
}
