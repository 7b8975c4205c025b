//! The material of the ground: one class and one friction value for each patch.

/// The ten semantic classes of the paper, in the original's label order (0…9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[repr(u8)]
pub enum TerrainClass {
    /// Clay: label 0, rigid.
    Clay = 0,
    /// Concrete: label 1, rigid.
    Concrete,
    /// Dirt: label 2, rigid.
    Dirt,
    /// Grass: label 3, rigid.
    Grass,
    /// Gravel: label 4, rigid.
    Gravel,
    /// Rock: label 5, rigid.
    Rock,
    /// Wood: label 6, rigid.
    Wood,
    /// Mud: label 7, deformable.
    Mud,
    /// Sand: label 8, deformable.
    Sand,
    /// Snow: label 9, deformable.
    Snow,
}

impl TerrainClass {
    /// All classes in the order of their labels.
    pub const ALL: [Self; 10] = [
        Self::Clay,
        Self::Concrete,
        Self::Dirt,
        Self::Grass,
        Self::Gravel,
        Self::Rock,
        Self::Wood,
        Self::Mud,
        Self::Sand,
        Self::Snow,
    ];

    /// The class with this label (0…9); `None` for any other number.
    #[must_use]
    pub fn from_label(label: u8) -> Option<Self> {
        Self::ALL.get(usize::from(label)).copied()
    }

    /// The label of the class, 0…9.
    #[must_use]
    pub fn label(self) -> u8 {
        self as u8
    }

    /// The name of the class, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["clay", "concrete", "dirt", "grass", "gravel", "rock", "wood", "mud", "sand", "snow"][self as usize]
    }

    /// The colour of the class on maps and in pictures, as red, green and blue in sRGB, 0…255 each.
    #[must_use]
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::Clay => [207, 114, 76],      // terracotta
            Self::Concrete => [190, 196, 204], // light grey
            Self::Dirt => [150, 111, 74],      // brown
            Self::Grass => [124, 179, 66],     // green
            Self::Gravel => [196, 176, 160],   // warm grey
            Self::Rock => [116, 128, 150],     // slate
            Self::Wood => [217, 160, 88],      // amber
            Self::Mud => [104, 79, 66],        // dark brown
            Self::Sand => [243, 213, 110],     // yellow
            Self::Snow => [236, 245, 255],     // bluish white
        }
    }

    /// Tells whether the ground yields under a wheel (mud, sand, snow).
    #[must_use]
    pub fn is_deformable(self) -> bool {
        self >= Self::Mud
    }
}

/// The strength level of a deformable terrain class; the paper has three per class.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum SoilLevel {
    /// The softest level.
    Soft,
    /// The level between the others.
    #[default]
    Medium,
    /// The firmest level.
    Hard,
}

impl SoilLevel {
    /// All levels, from the softest to the firmest.
    pub const ALL: [Self; 3] = [Self::Soft, Self::Medium, Self::Hard];

    /// The name of the level, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Medium => "medium",
            Self::Hard => "hard",
        }
    }
}

/// The level of each deformable class in a world; the soil set defines the soil of each level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs, reason = "the classes of the paper")]
pub struct SoilLevels {
    pub mud: SoilLevel,
    pub sand: SoilLevel,
    pub snow: SoilLevel,
}

impl SoilLevels {
    /// The level of a deformable class; `None` for a rigid class.
    #[must_use]
    pub fn of(&self, class: TerrainClass) -> Option<SoilLevel> {
        match class {
            TerrainClass::Mud => Some(self.mud),
            TerrainClass::Sand => Some(self.sand),
            TerrainClass::Snow => Some(self.snow),
            _ => None,
        }
    }
}

/// A raster of square patches that tile the world from its south-west corner, row 0 in the south.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Semantics {
    /// The number of patch rows, from south to north.
    pub rows: usize,
    /// The number of patch columns, from west to east.
    pub cols: usize,
    /// The side of a patch, m.
    pub patch: f64,
    /// The class of each patch, row-major.
    pub classes: Vec<TerrainClass>,
    /// The Coulomb friction coefficient of each patch's own surface, row-major. Deformable patches carry 0: their
    /// resistance comes from the soil model.
    pub friction: Vec<f64>,
    /// The level of each deformable class.
    pub soil: SoilLevels,
}

impl Semantics {
    /// The index of the patch under (x, y), which are measured in m from the world's centre; outside the world, that of
    /// the nearest patch. A point on a shared edge belongs to the patch in the east or north.
    #[inline]
    #[must_use]
    pub fn patch_index(&self, x: f64, y: f64) -> usize {
        let fx = x / self.patch + 0.5 * self.cols as f64;
        let fy = y / self.patch + 0.5 * self.rows as f64;
        let col = (fx.max(0.0) as usize).min(self.cols - 1);
        let row = (fy.max(0.0) as usize).min(self.rows - 1);
        row * self.cols + col
    }

    /// The class of the ground under (x, y).
    #[must_use]
    pub fn class_at(&self, x: f64, y: f64) -> TerrainClass {
        self.classes[self.patch_index(x, y)]
    }

    /// The friction coefficient of the ground under (x, y).
    #[inline]
    #[must_use]
    pub fn friction_at(&self, x: f64, y: f64) -> f64 {
        self.friction[self.patch_index(x, y)]
    }

    /// The mean friction coefficient of the rigid patches that reach into the square of half side `reach` (m) about (x,
    /// y); 0 where there are none.
    #[must_use]
    pub fn rigid_friction_around(&self, x: f64, y: f64, reach: f64) -> f64 {
        let (low, high) = (self.patch_index(x - reach, y - reach), self.patch_index(x + reach, y + reach));
        let (mut sum, mut count) = (0.0, 0.0);
        for row in low / self.cols..=high / self.cols {
            for col in low % self.cols..=high % self.cols {
                let i = row * self.cols + col;
                if !self.classes[i].is_deformable() {
                    sum += self.friction[i];
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_edge_belongs_to_the_patch_in_the_east_or_north() {
        let classes = vec![TerrainClass::Clay, TerrainClass::Rock, TerrainClass::Wood, TerrainClass::Mud];
        let s = Semantics {
            rows: 2,
            cols: 2,
            patch: 4.0,
            classes,
            friction: vec![0.1, 0.2, 0.3, 0.0],
            soil: SoilLevels::default(),
        };
        let cases = [
            ([-0.1, -0.1], TerrainClass::Clay),
            ([0.0, -0.1], TerrainClass::Rock),
            ([-0.1, 0.0], TerrainClass::Wood),
            ([0.0, 0.0], TerrainClass::Mud),
            ([-9.0, -9.0], TerrainClass::Clay),
            ([9.0, 4.0], TerrainClass::Mud),
        ];
        for ([x, y], class) in cases {
            assert_eq!(s.class_at(x, y), class, "{x}, {y}");
        }
        assert_eq!(s.friction_at(1.0, -1.0), 0.2);
    }

    #[test]
    fn labels_and_classes_correspond() {
        for (k, class) in TerrainClass::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(class.label()), k);
            assert_eq!(TerrainClass::from_label(class.label()), Some(class));
            assert_eq!(class.is_deformable(), ["mud", "sand", "snow"].contains(&class.name()));
        }
        assert_eq!(TerrainClass::from_label(10), None);
    }
}
