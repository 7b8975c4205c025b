//! Beds for trials of one task, like the paper's physical testbed: a rough square, covered with patches of a few
//! materials, on which a car drives the same way several times.

mod rules;

pub use rules::{
    BedElevation, BedLevel, BedParams, Material, Materials, StartNoise, TestbedParams, TrialParams,
};

use vb_math::angle::{radians, wrap};
use vb_math::rng::Stream;
use vb_terrain::{Model, Request};
use vb_world::{Density, Heightfield, Provenance, Semantics, SoilLevels, SuiteMeta, Terrain, World};

use crate::generate::{self, GenerateError, TaskParams};
use crate::surface::counted_from_lowest;

/// Surfaces drawn before giving up on start and goal.
const SURFACES: usize = 100;
/// Standard deviations at which the noise of starts is clipped.
const NOISE_LIMIT: f64 = 2.0;
/// Version of this builder, which changes whenever the same inputs would give other worlds.
const VERSION: u32 = 1;

/// What a suite of beds follows from.
#[derive(Clone, Copy, Debug)]
pub struct Testbed<'a> {
    /// The rules.
    pub rules: &'a TestbedParams,
    /// The terrain model that [`BedElevation::model`] names.
    pub model: &'a Model,
    /// The seed.
    pub seed: u64,
}

impl Testbed<'_> {
    /// What the suite says about itself.
    #[must_use]
    pub fn meta(&self, name: &str, version: &str) -> SuiteMeta {
        let (rules, seed) = (self.rules, self.seed);
        let (beds, trials) = (rules.elevation.beds.len(), rules.trials.count);
        let materials: Vec<&str> = rules.materials.all.iter().map(|m| m.name.as_str()).collect();
        SuiteMeta {
            name: name.into(),
            version: version.into(),
            description: format!("{beds} beds of {}, with {trials} trials each.", materials.join(", ")),
            provenance: Provenance::Generated {
                generator: format!(
                    "testbed {VERSION}, rules {}, model {}",
                    rules.name, rules.elevation.model
                ),
                seed,
            },
        }
    }

    /// Makes the beds, one for each level of the rules, in their order: `w001` and so on.
    ///
    /// # Errors
    /// If the terrain model can't draw such a surface, or none has ground for start and goal.
    pub fn worlds(&self) -> Result<Vec<World>, GenerateError> {
        (0..self.rules.elevation.beds.len()).map(|index| self.world(index)).collect()
    }

    fn world(&self, index: usize) -> Result<World, GenerateError> {
        let rules = self.rules;
        let bed = rules.elevation.beds[index];
        let id = format!("w{:03}", index + 1);
        let stream = |part: &str| Stream::new(self.seed, &["testbed", &id, part]);
        let semantics = self.cover(&mut stream("materials"));
        let (heightfield, [start, goal]) =
            self.ground_with_ends(&id, bed.std, &semantics, &mut stream("elevation"))?;
        let mut world = World {
            elevation: bed.level,
            terrain: Terrain::Rigid,
            density: Density::Sparse,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles: Vec::new(),
            tasks: Vec::new(),
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
        let [low, high] = materials.clip;
        let friction = kinds.iter().map(|&k| {
            let mu = rng.normal(materials.all[k].mean, materials.all[k].std).clamp(low, high);
            // Three decimals are plenty, and people read them. Rounding must not leave the clip.
            ((mu * 1000.0).round() / 1000.0).clamp(low, high)
        });
        let friction = friction.collect();
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

    /// Draws surfaces until one has a start and a goal across the middle.
    fn ground_with_ends(
        &self,
        id: &str,
        std: f64,
        semantics: &Semantics,
        rng: &mut Stream,
    ) -> Result<(Heightfield, [[f64; 2]; 2]), GenerateError> {
        let (rules, nodes) = (self.rules, self.rules.nodes());
        let radius = 0.5 * rules.trials.distance;
        let tasks = TaskParams { count: 1, radius, stand: rules.stand };
        for _ in 0..SURFACES {
            let request = Request {
                seed: rng.next_u64(),
                rows: nodes,
                cols: nodes,
                pitch: rules.bed.pitch,
                share: std / self.model.header().relief,
            };
            let ground = counted_from_lowest(nodes, rules.bed.pitch, self.model.surface(&request)?.heights());
            let ends = generate::ends(&ground, semantics, &[], rules.path.clearance, radius, &tasks);
            if let Some(pair) = ends.and_then(|e| e.pairs.first().copied()) {
                return Ok((ground, pair));
            }
        }
        Err(GenerateError::NoStart { world: id.into(), distance: rules.trials.distance })
    }
}

/// Rounded to whole millimetres, which people can read.
fn millimetres(v: f64) -> f64 {
    (v * 1000.0).round() / 1000.0 + 0.0
}
