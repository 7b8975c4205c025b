//! A world: all that a task happens in.

use crate::{
    GranularBed, Heightfield, Obstacle, Pose2, Raster, Semantics, SoilLevels, Task, TerrainClass, geometry,
};

/// The elevation level of a world, as in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Elevation {
    /// The relief is 30 % of the full one.
    Low,
    /// The relief is 60 % of the full one.
    Medium,
    /// The relief is the full one.
    High,
}

impl Elevation {
    /// All levels, in order.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// The name of the level, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// The terrain of a world: rigid, deformable, or mixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Terrain {
    /// The world has rigid classes only.
    Rigid,
    /// The world has deformable classes only.
    Deformable,
    /// The world has rigid and deformable classes.
    Mixed,
}

impl Terrain {
    /// All kinds, in order.
    pub const ALL: [Self; 3] = [Self::Rigid, Self::Deformable, Self::Mixed];

    /// The name of the kind, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Deformable => "deformable",
            Self::Mixed => "mixed",
        }
    }
}

/// The obstacle density of a world, as in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Density {
    /// The world has 10 boulders.
    Sparse,
    /// The world has 20 boulders.
    Medium,
    /// The world has 40 boulders.
    Dense,
}

impl Density {
    /// All densities, in order.
    pub const ALL: [Self; 3] = [Self::Sparse, Self::Medium, Self::Dense];

    /// The name of the density, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sparse => "sparse",
            Self::Medium => "medium",
            Self::Dense => "dense",
        }
    }
}

/// A world at its own scale (see [`World::scaled`]).
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The name of the world within the suite, e.g. `w001`.
    pub id: String,
    /// The elevation level.
    pub elevation: Elevation,
    /// The kind of ground.
    pub terrain: Terrain,
    /// The obstacle density.
    pub density: Density,
    /// The factor by which all lengths were multiplied: 1 for a world as stored.
    pub scale: f64,
    /// The ground surface.
    pub heightfield: Heightfield,
    /// The classes and the friction of the ground.
    pub semantics: Semantics,
    /// The obstacles.
    pub obstacles: Vec<Obstacle>,
    /// The tasks, in order.
    pub tasks: Vec<Task>,
    /// The granular beds.
    pub beds: Vec<GranularBed>,
}

impl World {
    /// A world whose ground is of one class and, where that is rigid, has one friction coefficient, over the given
    /// heights; it has no obstacles and no tasks.
    #[must_use]
    pub fn uniform(id: &str, heightfield: Heightfield, class: TerrainClass, friction: f64) -> Self {
        let soft = class.is_deformable();
        Self {
            id: id.to_owned(),
            elevation: Elevation::Low,
            terrain: if soft { Terrain::Deformable } else { Terrain::Rigid },
            density: Density::Sparse,
            scale: 1.0,
            semantics: Semantics {
                rows: 1,
                cols: 1,
                patch: 2.0 * heightfield.half_x().max(heightfield.half_y()),
                classes: vec![class],
                friction: vec![if soft { 0.0 } else { friction }],
                soil: SoilLevels::default(),
            },
            heightfield,
            obstacles: Vec::new(),
            tasks: Vec::new(),
            beds: Vec::new(),
        }
    }

    /// The same world with every length multiplied by `s` (> 0): heights, grid and patch sizes, obstacles with their
    /// burial, beds with their grains, starts, goals and paths. Angles and friction stay; [`World::scale`] is multiplied.
    ///
    /// The paper scales vehicle and world together (1, 1/6, 1/10); the original code scaled some lengths twice and
    /// others not at all, which is not repeated here.
    #[must_use]
    pub fn scaled(&self, s: f64) -> Self {
        let point = |p: [f64; 2]| [p[0] * s, p[1] * s];
        let task = |t: &Task| Task {
            id: t.id.clone(),
            start: Pose2 { x: t.start.x * s, y: t.start.y * s, yaw: t.start.yaw },
            goal: point(t.goal),
            path: t.path.iter().map(|&p| point(p)).collect(),
        };
        Self {
            id: self.id.clone(),
            scale: self.scale * s,
            heightfield: self.heightfield.scaled(s),
            semantics: Semantics { patch: self.semantics.patch * s, ..self.semantics.clone() },
            obstacles: self.obstacles.iter().map(|o| o.scaled(s)).collect(),
            tasks: self.tasks.iter().map(task).collect(),
            beds: self.beds.iter().map(|bed| bed.scaled(s)).collect(),
            ..*self
        }
    }

    /// This world for a vehicle of so many times the full size: as [`World::scaled`], and unchanged, without a copy, at full size.
    #[must_use]
    pub fn at_scale(self, s: f64) -> Self {
        if s == 1.0 { self } else { self.scaled(s) }
    }

    /// The number of the granular bed at (x, y); `None` outside of all.
    #[must_use]
    pub fn bed_at(&self, x: f64, y: f64) -> Option<usize> {
        self.beds.iter().position(|bed| bed.contains(x, y))
    }

    /// Tells whether no patch yields under a wheel.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        !self.semantics.classes.iter().any(|c| c.is_deformable())
    }

    /// The class of the ground under (x, y).
    #[must_use]
    pub fn class_at(&self, x: f64, y: f64) -> TerrainClass {
        self.semantics.class_at(x, y)
    }

    /// The Coulomb friction coefficient of the ground under (x, y).
    #[must_use]
    pub fn friction_at(&self, x: f64, y: f64) -> f64 {
        self.semantics.friction_at(x, y)
    }

    /// The task with this id; `None` if there is none.
    #[must_use]
    pub fn task(&self, id: &str) -> Option<&Task> {
        self.tasks.iter().find(|t| t.id == id)
    }

    /// The occupancy on squares of side `resolution` (m): 1 where an obstacle's footprint covers any part of the
    /// square, else 0. The squares tile the world from its south-west corner; the last row and column may reach beyond
    /// its edge.
    ///
    /// # Panics
    /// Panics if `resolution` is not positive.
    #[must_use]
    pub fn occupancy(&self, resolution: f64) -> Raster<u8> {
        assert!(resolution > 0.0, "resolution {resolution} m is not positive");
        // A hair less than the quotient, so that 128 m / 0.1 m gives 1280 squares and not 1281 by rounding.
        let count = |half: f64| ((2.0 * half / resolution * (1.0 - 1e-12)).ceil() as usize).max(1);
        let (half_x, half_y) = (self.heightfield.half_x(), self.heightfield.half_y());
        let (rows, cols) = (count(half_y), count(half_x));
        let half = 0.5 * resolution;
        let origin = [half - half_x, half - half_y];
        let mut raster = Raster { rows, cols, resolution, origin, data: vec![0; rows * cols] };
        for obstacle in &self.obstacles {
            let outline = obstacle.footprint();
            let span = |axis: usize, n: usize| {
                let (low, high) = outline
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
                let index = |v: f64| (v - origin[axis]) / resolution + 0.5;
                (index(low).max(0.0) as usize)..((index(high).max(0.0) as usize + 1).min(n))
            };
            for row in span(1, rows) {
                for col in span(0, cols) {
                    if geometry::overlaps_square(&outline, raster.centre(row, col), half) {
                        raster.data[row * cols + col] = 1;
                    }
                }
            }
        }
        raster
    }
}
