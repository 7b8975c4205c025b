//! What the ground is made of: one class and one friction value a patch.

/// The ten semantic classes of the paper, in the original's label order (0…9).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[repr(u8)]
pub enum TerrainClass {
    /// Label 0, rigid.
    Clay = 0,
    /// Label 1, rigid.
    Concrete,
    /// Label 2, rigid.
    Dirt,
    /// Label 3, rigid.
    Grass,
    /// Label 4, rigid.
    Gravel,
    /// Label 5, rigid.
    Rock,
    /// Label 6, rigid.
    Wood,
    /// Label 7, deformable.
    Mud,
    /// Label 8, deformable.
    Sand,
    /// Label 9, deformable.
    Snow,
}

impl TerrainClass {
    /// All classes in label order.
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

    /// The class with this label (0…9).
    #[must_use]
    pub fn from_label(label: u8) -> Option<Self> {
        Self::ALL.get(usize::from(label)).copied()
    }

    /// The label, 0…9.
    #[must_use]
    pub fn label(self) -> u8 {
        self as u8
    }

    /// The name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["clay", "concrete", "dirt", "grass", "gravel", "rock", "wood", "mud", "sand", "snow"][self as usize]
    }

    /// Whether the ground yields under a wheel (mud, sand, snow).
    #[must_use]
    pub fn is_deformable(self) -> bool {
        self >= Self::Mud
    }
}

/// How firm the ground of a deformable class is: the paper has three levels a class.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum SoilLevel {
    /// The softest.
    Soft,
    /// Between.
    #[default]
    Medium,
    /// The firmest.
    Hard,
}

impl SoilLevel {
    /// All, in order.
    pub const ALL: [Self; 3] = [Self::Soft, Self::Medium, Self::Hard];

    /// The name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Medium => "medium",
            Self::Hard => "hard",
        }
    }
}

/// The level of each deformable class in a world; what it stands for is the matter of a soil file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs, reason = "the classes of the paper")]
pub struct SoilLevels {
    pub mud: SoilLevel,
    pub sand: SoilLevel,
    pub snow: SoilLevel,
}

impl SoilLevels {
    /// The level of a deformable class; of a rigid class, `None`.
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
#[derive(Clone, Debug, PartialEq)]
pub struct Semantics {
    /// Number of patch rows (south to north).
    pub rows: usize,
    /// Number of patch columns (west to east).
    pub cols: usize,
    /// Side of a patch, m.
    pub patch: f64,
    /// Row-major class of each patch.
    pub classes: Vec<TerrainClass>,
    /// Row-major Coulomb friction coefficient of each patch's own surface. Deformable patches carry 0: their
    /// resistance comes from the soil model.
    pub friction: Vec<f64>,
    /// Level of each deformable class.
    pub soil: SoilLevels,
}

impl Semantics {
    /// Index of the patch under (x, y), positions measured from the world's centre; the nearest patch outside.
    /// A point on a shared edge belongs to the patch in the east or north.
    #[inline]
    #[must_use]
    pub fn patch_index(&self, x: f64, y: f64) -> usize {
        let fx = x / self.patch + 0.5 * self.cols as f64;
        let fy = y / self.patch + 0.5 * self.rows as f64;
        let col = (fx.max(0.0) as usize).min(self.cols - 1);
        let row = (fy.max(0.0) as usize).min(self.rows - 1);
        row * self.cols + col
    }

    /// Class under (x, y).
    #[must_use]
    pub fn class_at(&self, x: f64, y: f64) -> TerrainClass {
        self.classes[self.patch_index(x, y)]
    }

    /// Friction coefficient under (x, y).
    #[inline]
    #[must_use]
    pub fn friction_at(&self, x: f64, y: f64) -> f64 {
        self.friction[self.patch_index(x, y)]
    }

    /// Mean friction coefficient of the rigid patches that reach into the square of half side `reach` about (x, y);
    /// 0 where there are none.
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
