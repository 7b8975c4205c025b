//! Granular beds of a world under a vehicle, whose wheels, belts and hull are bodies among the grains.
//!
//! The crate `vb_granular` has model and coupling. Here beds are placed in the world and get the motions of all bodies in every step;
//! what they do to the bodies acts on the equations of motion of the same step. A bed rests, as it is, while no body is near it.

use crate::V3;
use crate::error::SimError;
use std::sync::Arc;
use vb_granular::{Bed, Bin, Motion, Packing, PackingError, Reaction, Settings, Tool};
use vb_world::{GranularBed, World};

/// Stiffness of a contact at full scale, N/m: at the least radius of `gravel` seven steps of the grains go into one of the vehicle.
const STIFFNESS: f64 = 3e5;
/// Distance from wheels, belts and hull beyond which grains at rest don't move, at full scale, m: three times the depth to which a wheel
/// of a car shears gravel.
const REACH: f64 = 0.3;

/// The beds of a world as they were filled, at rest, or the reason why one can't be: worlds that were checked have no such bed.
pub(crate) type Packings = Arc<[Result<Packing, PackingError>]>;

/// Checks that no grain of a world's beds is larger than a vehicle's smallest wheel, of `radius` (m) at the world's scale.
///
/// # Errors
/// Returns [`SimError::Grains`] for the first bed with larger grains.
pub fn check_grains(world: &World, radius: f64) -> Result<(), SimError> {
    let largest = |bed: &GranularBed| bed.material.radius[1];
    match world.beds.iter().map(largest).find(|grain| *grain > radius) {
        Some(grain) => Err(SimError::Grains { world: world.id.clone(), grain, wheel: radius }),
        None => Ok(()),
    }
}

/// Fills the beds of a world.
pub(crate) fn fill(world: &World) -> Packings {
    let fill = |bed: &GranularBed| {
        let settings = settings(world.scale, FILLING);
        let bin = Bin { length: bed.length, width: bed.width, depth: bed.depth };
        Packing::tiled(&bed.material, bin, bed.seed, settings)
    };
    world.beds.iter().map(fill).collect()
}

/// The step in which beds are filled at full scale, s.
const FILLING: f64 = 1e-3;

/// In a world of another scale a contact yields in proportion to the grain: stiffness × length is proportional to the weight.
fn settings(scale: f64, step: f64) -> Settings {
    Settings { step, stiffness: STIFFNESS * scale * scale, reach: REACH * scale }
}

/// The beds of a world and the bodies of a vehicle among their grains.
#[derive(Clone)]
pub(crate) struct Beds {
    beds: Vec<Placed>,
    /// On each body, in the last step.
    reactions: Vec<Reaction>,
    /// Distances from the centres of the bodies within which they lie, m.
    bounds: Vec<f64>,
    reach: f64,
}

#[derive(Clone)]
struct Placed {
    bed: Bed,
    described: GranularBed,
    /// The middle of its floor in the world, m.
    floor_world: V3,
}

impl Beds {
    /// `tools` makes the bodies of the vehicle for grains of a mean radius (m).
    ///
    /// # Errors
    /// Returns [`SimError::Grains`] for grains that are larger than the smallest wheel, of `radius` (m), and [`SimError::Bed`] for a bed
    /// that can't be filled.
    pub(crate) fn new(
        world: &World,
        packings: &Packings,
        tools: impl Fn(f64) -> Vec<Tool>,
        radius: f64,
        step: f64,
    ) -> Result<Self, SimError> {
        let mut bounds = Vec::new();
        check_grains(world, radius)?;
        let place = |(described, packing): (&GranularBed, &Result<Packing, PackingError>)| {
            let unfilled =
                |source: &PackingError| SimError::Bed { world: world.id.clone(), source: source.clone() };
            let packing = packing.as_ref().map_err(unfilled)?;
            let settings = settings(world.scale, step);
            let top = world.heightfield.height(described.x, described.y);
            let tools = tools(described.material.mean_radius());
            bounds = tools.iter().map(|tool| tool.shape.bound()).collect();
            Ok(Placed {
                bed: Bed::new(packing, &described.material, tools, settings),
                described: described.clone(),
                floor_world: V3::new(described.x, described.y, top - described.depth),
            })
        };
        let beds = world.beds.iter().zip(packings.iter()).map(place).collect::<Result<_, SimError>>()?;
        let reactions = vec![Reaction::default(); bounds.len()];
        Ok(Self { beds, reactions, bounds, reach: REACH * world.scale })
    }

    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self { beds: Vec::new(), reactions: Vec::new(), bounds: Vec::new(), reach: 0.0 }
    }

    /// The number of bodies of which [`Self::step`] wants the motion.
    pub(crate) fn bodies(&self) -> usize {
        self.bounds.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.beds.is_empty()
    }

    /// Height of a bed's surface before anything moved in it, m; none where there is no bed.
    pub(crate) fn surface(&self, x: f64, y: f64) -> Option<f64> {
        let bed = self.beds.iter().find(|bed| bed.described.contains(x, y))?;
        Some(bed.floor_world.z + bed.described.depth)
    }

    /// The grains of all beds: centre in the world, m, and radius, m.
    pub(crate) fn grains(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        self.beds.iter().flat_map(|bed| {
            bed.bed.grains().map(|grain| ((bed.floor_world + grain.position).into(), grain.radius))
        })
    }

    /// Advances the beds near the bodies by a step and returns what they do to each body.
    pub(crate) fn step(&mut self, motions_world: &[Motion]) -> &[Reaction] {
        self.reactions.fill(Reaction::default());
        for placed in &mut self.beds {
            let near = |(motion, bound): (&Motion, &f64)| {
                let way = motion.position - placed.floor_world;
                let within = bound + self.reach;
                way.x.abs() < 0.5 * placed.described.length + within
                    && way.y.abs() < 0.5 * placed.described.width + within
                    && way.z < placed.described.depth + within
            };
            if !motions_world.iter().zip(&self.bounds).any(near) {
                continue;
            }
            let moved = |m: &Motion| Motion { position: m.position - placed.floor_world, ..*m };
            let motions: Vec<Motion> = motions_world.iter().map(moved).collect();
            for (sum, reaction) in self.reactions.iter_mut().zip(placed.bed.step(&motions)) {
                sum.impulse += reaction.impulse;
                sum.moment += reaction.moment;
            }
        }
        &self.reactions
    }
}
