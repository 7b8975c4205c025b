//! Beds for trials of one task, like the paper's physical testbed: a rough square, covered with patches of a few
//! materials, on which a car drives the same way several times.

mod rules;

pub use rules::{
    BedElevation, BedLevel, BedParams, Material, Materials, StartNoise, TestbedParams, TrialParams,
};

use vb_math::angle::{radians, wrap};
use vb_math::rng::Stream;
use vb_terrain::Model;
use vb_world::{Density, Semantics, SoilLevels, SuiteMeta, Terrain, World};

use crate::generate::{self, Fields, GenerateError, Surfaces, TaskParams, millimetres};

/// Standard deviations at which the noise of starts is clipped.
const NOISE_LIMIT: f64 = 2.0;
/// Version of this builder, which changes whenever the same inputs would give other worlds.
const VERSION: u32 = 1;
/// What the rules of beds call what surfaces follow from.
const FIELDS: Fields = Fields { grid: "bed", stand: "stand", distance: "trials.distance", elsewhere: "" };

/// The things that a suite of beds follows from.
#[derive(Clone, Copy, Debug)]
pub struct Testbed<'a> {
    pub rules: &'a TestbedParams,
    /// The terrain model that [`BedElevation::model`] names.
    pub model: &'a Model,
    pub seed: u64,
}

impl Testbed<'_> {
    #[must_use]
    pub fn meta(&self, name: &str, version: &str) -> SuiteMeta {
        let (rules, seed) = (self.rules, self.seed);
        let (beds, trials) = (rules.elevation.beds.len(), rules.trials.count);
        let materials: Vec<&str> = rules.materials.all.iter().map(|m| m.name.as_str()).collect();
        SuiteMeta {
            name: name.into(),
            version: version.into(),
            description: format!("{beds} beds of {}, with {trials} trials each.", materials.join(", ")),
            provenance: generate::provenance(
                format_args!("testbed {VERSION}"),
                &rules.name,
                &rules.elevation.model,
                seed,
            ),
        }
    }

    /// Makes the beds, one for each level of the rules, in their order: `w001` and so on.
    ///
    /// # Errors
    /// Returns an error if the terrain model can't draw such a surface, or if none that it draws has ground for start
    /// and goal.
    pub fn worlds(&self) -> Result<Vec<World>, GenerateError> {
        (0..self.rules.elevation.beds.len()).map(|index| self.world(index)).collect()
    }

    fn world(&self, index: usize) -> Result<World, GenerateError> {
        let rules = self.rules;
        let bed = rules.elevation.beds[index];
        let id = format!("w{:03}", index + 1);
        let stream = |part: &str| Stream::new(self.seed, &["testbed", &id, part]);
        let semantics = self.cover(&mut stream("materials"));
        let radius = 0.5 * rules.trials.distance;
        let surfaces = Surfaces {
            model: self.model,
            shaping: None,
            step: None,
            shift: [0, 0],
            nodes: rules.nodes(),
            resolution: rules.bed.resolution,
            std: bed.std,
            semantics: &semantics,
            // The trials are repetitions of one task.
            tasks: &TaskParams { count: 1, radius, stand: rules.stand },
            fields: FIELDS,
        };
        let (heightfield, planned) = surfaces.with_ends(&id, &mut stream("elevation"))?;
        let [start, goal] = planned[0];
        let mut world = World {
            elevation: bed.level,
            terrain: Terrain::Rigid,
            density: Density::Sparse,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles: Vec::new(),
            tasks: Vec::new(),
            beds: Vec::new(),
            id: id.clone(),
        };
        let noise = rules.trials.noise;
        let mut rng = stream("trials");
        let mut draw = |std: f64, step: f64| {
            let value = std * rng.normal(0.0, 1.0).clamp(-NOISE_LIMIT, NOISE_LIMIT);
            (value / step).round() * step
        };
        let mut turns = Vec::with_capacity(rules.trials.count);
        let mut ends = Vec::with_capacity(rules.trials.count);
        for _ in 0..rules.trials.count {
            let moved = start.map(|v| millimetres(v + draw(noise.position, 1e-3)));
            ends.push([moved, goal]);
            turns.push(radians(draw(noise.heading, 0.1)));
        }
        generate::plan_tasks(&mut world, &rules.path, &ends)?;
        // All trials mean to head as the undisturbed start does, along the line from start to goal.
        let heading = vb_math::atan2(goal[1] - start[1], goal[0] - start[0]);
        for (task, turn) in world.tasks.iter_mut().zip(turns) {
            task.start.yaw = wrap(heading + turn);
        }
        Ok(world)
    }

    /// Patches of the materials in drawn places, equally many of each or one more of the first ones.
    fn cover(&self, rng: &mut Stream) -> Semantics {
        let (materials, n) = (&self.rules.materials, self.rules.patches());
        let mut kinds: Vec<usize> = (0..n * n).map(|k| k % materials.all.len()).collect();
        rng.shuffle(&mut kinds);
        let of_kind = |&k: &usize| generate::drawn_friction(materials.all[k].friction(), materials.clip, rng);
        let friction = kinds.iter().map(of_kind).collect();
        let classes = kinds.iter().map(|&k| materials.all[k].class).collect();
        Semantics {
            rows: n,
            cols: n,
            patch: self.rules.bed.patch,
            classes,
            friction,
            soil: SoilLevels::default(),
        }
    }
}
