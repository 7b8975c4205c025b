//! The nearest hit of a ray with the ground, with obstacles and with the ruts on soft soil.
//!
//! The ground is the triangulated surface of [`vb_world::Heightfield`], and an obstacle is the convex hull of
//! [`vb_world::Obstacle::hull`]; both are hit exactly, but for rounding. Nothing is hit beyond the edge of the world,
//! where no heights are known. Ruts are explained at [`Ruts`].

mod ground;
mod ruts;
mod solid;

pub use ruts::Ruts;

pub(crate) use solid::Solid;

use crate::V3;
use ground::{Ground, Origin};
use std::sync::{Arc, OnceLock};
use vb_world::World;

/// What a ray hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    Ground,
    /// The obstacle with this index in [`World::obstacles`].
    Obstacle(usize),
}

/// The nearest place at which a ray hits something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance from the ray's origin, m.
    pub distance: f64,
    pub surface: Surface,
}

/// A world as rays meet it. A scene is made once for a world and shared by all who look at it; what rays need beyond the
/// world itself is made at the first ray, so a scene that nobody looks at costs nothing.
#[derive(Debug)]
pub struct Scene {
    world: Arc<World>,
    shapes: OnceLock<Shapes>,
}

/// What rays need of a world.
#[derive(Debug)]
struct Shapes {
    ground: Ground,
    solids: Vec<Solid>,
}

/// Rays from one origin that lie in one plane, such as those of a column of a lidar's scan or of a camera's image: the
/// obstacles that the plane misses are left out for all of them at once.
#[derive(Clone, Debug)]
pub struct Fan<'a> {
    scene: &'a Scene,
    shapes: &'a Shapes,
    origin: V3,
    over: Origin,
    reach: f64,
    /// Indices of the obstacles that the plane meets.
    solids: Vec<usize>,
    sweep: Option<Sweep>,
}

/// What one ray of a fan from above the ground tells the next. Where the ground is nowhere so steep that it leans over in the
/// fan's plane, what lies above a point over the ground lies over the ground as well. So the ground is in the way of no ray before
/// it is in that of a lower one, and rays that come in order of rise go over all the ground between them only once.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    /// Unit vectors in the plane: ahead, and up from there.
    ahead: V3,
    up: V3,
    /// The rise of the last ray, and how far ahead it is known to be over the ground, m.
    rise: f64,
    free: f64,
}

impl Sweep {
    /// None for a plane in which the ground may lean over.
    fn new(normal: &V3, forward: &V3, steepest: f64) -> Option<Self> {
        let ahead = (forward - normal * forward.dot(normal)).try_normalize(1e-9)?;
        let across = normal.cross(&ahead);
        let up = if across.z < 0.0 { -across } else { across };
        let level = (up.x * up.x + up.y * up.y).sqrt();
        // A little less than it might be, for rounding.
        let stands = steepest * level < 0.99 * up.z;
        stands.then_some(Self { ahead, up, rise: f64::INFINITY, free: 0.0 })
    }
}

impl Scene {
    #[must_use]
    pub fn new(world: Arc<World>) -> Self {
        Self { world, shapes: OnceLock::new() }
    }

    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    fn shapes(&self) -> &Shapes {
        self.shapes.get_or_init(|| Shapes {
            ground: Ground::new(&self.world.heightfield),
            solids: self.world.obstacles.iter().map(|o| Solid::of(o, &self.world.heightfield)).collect(),
        })
    }

    /// The nearest hit of a ray within `reach` (m) of its origin; `None` if there is none. `origin` is in the world
    /// frame, m, and `direction` is a unit vector in world axes. An origin inside an obstacle hits it where the ray
    /// leaves it; an origin below the ground hits the ground from below.
    #[must_use]
    pub fn cast(&self, origin: &V3, direction: &V3, reach: f64, ruts: Option<&dyn Ruts>) -> Option<Hit> {
        let shapes = self.shapes();
        let all = (0..shapes.solids.len()).collect();
        self.fan_of(origin, reach, all, None).cast(direction, ruts)
    }

    /// The rays from `origin` that lie in the plane with the unit normal `normal` and on the side of `forward`, both in
    /// world axes, and that end at the distance `reach`, m.
    #[must_use]
    pub fn fan(&self, origin: &V3, normal: &V3, forward: &V3, reach: f64) -> Fan<'_> {
        let shapes = self.shapes();
        let meets = |s: &Solid| {
            let (to, r) = (s.centre - origin, s.radius);
            to.dot(normal).abs() <= r
                && to.dot(forward) >= -r
                && to.norm_squared() <= (reach + r) * (reach + r)
        };
        let solids = shapes.solids.iter().enumerate().filter(|(_, s)| meets(s)).map(|(k, _)| k).collect();
        self.fan_of(origin, reach, solids, Sweep::new(normal, forward, shapes.ground.steepest()))
    }

    fn fan_of(&self, origin: &V3, reach: f64, solids: Vec<usize>, sweep: Option<Sweep>) -> Fan<'_> {
        let over = Origin::new(&self.world.heightfield, origin);
        let sweep = sweep.filter(|_| over.is_above());
        Fan { scene: self, shapes: self.shapes(), origin: *origin, over, reach, solids, sweep }
    }
}

impl Fan<'_> {
    /// The nearest hit of the ray along `direction`, a unit vector in world axes that lies in the fan's plane; `None` if
    /// there is none within the fan's reach. Rays may come in any order; it is fastest from the lowest to the highest.
    #[must_use]
    pub fn cast(&mut self, direction: &V3, ruts: Option<&dyn Ruts>) -> Option<Hit> {
        let field = &self.scene.world.heightfield;
        let plain = self.plain(direction);
        let distance = match (plain, ruts) {
            (Some(plain), Some(ruts)) => ruts::cast(field, ruts, &self.origin, direction, plain, self.reach),
            _ => plain,
        };
        let mut nearest = distance.map(|distance| Hit { distance, surface: Surface::Ground });
        for &k in &self.solids {
            let reach = nearest.map_or(self.reach, |h| h.distance);
            if let Some(distance) = self.shapes.solids[k].cast(&self.origin, direction, reach) {
                nearest = Some(Hit { distance, surface: Surface::Obstacle(k) });
            }
        }
        nearest
    }

    /// The distance at which the ray meets the unchanged ground, m.
    #[inline]
    fn plain(&mut self, direction: &V3) -> Option<f64> {
        let (ground, field) = (&self.shapes.ground, &self.scene.world.heightfield);
        let Some(sweep) = &mut self.sweep else {
            return ground.cast(field, &self.over, direction, 0.0, self.reach).ok();
        };
        let ahead = direction.dot(&sweep.ahead);
        if ahead <= 1e-6 {
            return ground.cast(field, &self.over, direction, 0.0, self.reach).ok();
        }
        let rise = direction.dot(&sweep.up) / ahead;
        if rise < sweep.rise {
            sweep.free = 0.0;
        }
        let free = sweep.free / ahead * (1.0 - 1e-9);
        let met = ground.cast(field, &self.over, direction, free, self.reach);
        let (Ok(distance) | Err(distance)) = met;
        sweep.free = sweep.free.max(distance * ahead);
        sweep.rise = rise;
        met.ok()
    }
}
