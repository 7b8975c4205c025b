//! A bed of grains that moves.

use crate::contact::{Law, Memory, Pair};
use crate::neighbours::{Neighbours, Other, Period};
use crate::packing::{Bin, Grain, Packing};
use crate::tool::{Motion, Reaction, Tool};
use crate::walls::Walls;
use crate::{GRAVITY, V3};
use vb_world::GranularMaterial;

/// Time step and contact parameters of a bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The time over which tools move with constant velocities, s.
    pub step: f64,
    /// Stiffness of a contact, N/m.
    pub stiffness: f64,
    /// Distance from the tools beyond which grains at rest stay as they are, m. Infinite: all grains move.
    pub reach: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { step: 1e-3, stiffness: 3e5, reach: f64::INFINITY }
    }
}

/// Restitution coefficient of grains: sand and gravel hardly bounce.
const RESTITUTION: f64 = 0.3;
/// Sub-steps in the period of contact of the lightest grains.
const SUBSTEPS: f64 = 15.0;
/// Grains further than this beyond a contact are no neighbours, in radii of the smallest.
const SKIN: f64 = 0.3;

/// State of the grains.
#[derive(Clone, Debug)]
pub(crate) struct Grains {
    pub(crate) position: Vec<V3>,
    pub(crate) velocity: Vec<V3>,
    pub(crate) spin: Vec<V3>,
    pub(crate) radius: Vec<f64>,
    pub(crate) mass: Vec<f64>,
}

/// Grains in a bin, with tools among them. A clone goes on exactly as the original does.
#[derive(Clone, Debug)]
pub struct Bed {
    grains: Grains,
    force: Vec<V3>,
    moment: Vec<V3>,
    tools: Vec<Tool>,
    reactions: Vec<Reaction>,
    neighbours: Neighbours,
    walls: Walls,
    law: Law,
    gravity: V3,
    substeps: u32,
    dt: f64,
    floor_load: f64,
}

impl Bed {
    /// A bed of grains at rest, with tools.
    #[must_use]
    pub fn new(packing: &Packing, material: &GranularMaterial, tools: Vec<Tool>, settings: Settings) -> Self {
        let n = packing.grains.len();
        let grains = Grains {
            position: packing.grains.iter().map(|g| g.position).collect(),
            velocity: vec![V3::zeros(); n],
            spin: vec![V3::zeros(); n],
            radius: packing.grains.iter().map(|g| g.radius).collect(),
            mass: packing.grains.iter().map(|g| material.mass(g.radius)).collect(),
        };
        let log = vb_math::ln(RESTITUTION);
        let law = Law {
            stiffness: settings.stiffness,
            damping: -log / (std::f64::consts::PI * std::f64::consts::PI + log * log).sqrt(),
            friction: material.friction,
            rolling_resistance: material.rolling_resistance,
            cohesion: material.cohesion,
        };
        let period =
            std::f64::consts::PI * (0.5 * material.mass(material.radius[0]) / settings.stiffness).sqrt();
        let substeps = (settings.step * SUBSTEPS / period).ceil().max(1.0);
        Self {
            grains,
            force: vec![V3::zeros(); n],
            moment: vec![V3::zeros(); n],
            reactions: vec![Reaction::default(); tools.len()],
            tools,
            neighbours: Neighbours::new(SKIN * material.radius[0], 2.0 * material.radius[1], settings.reach),
            walls: Walls::new(packing.bin),
            law,
            gravity: V3::new(0.0, 0.0, -GRAVITY),
            substeps: substeps as u32,
            dt: settings.step / substeps,
            floor_load: 0.0,
        }
    }

    /// The same grains in a bin whose opposite walls are one: what leaves it comes back in from the other side.
    pub(crate) fn periodic(mut self, bin: Bin) -> Self {
        self.walls.count = 1;
        self.neighbours.period = Period::of(bin);
        self
    }

    /// Advances the grains by a step, in which each tool moves with constant velocities, and returns what they do to the tools.
    pub fn step(&mut self, motions: &[Motion]) -> &[Reaction] {
        self.reactions.fill(Reaction::default());
        self.floor_load = 0.0;
        let mut motions = motions.to_vec();
        for _ in 0..self.substeps {
            self.neighbours.update(&mut self.grains, &self.tools, &motions, &self.walls);
            self.press_grains();
            self.press_others(&motions);
            self.integrate();
            for motion in &mut motions {
                motion.position += motion.velocity * self.dt;
                motion.rotation = crate::Quat::from_scaled_axis(motion.spin * self.dt) * motion.rotation;
            }
        }
        self.floor_load /= f64::from(self.substeps);
        &self.reactions
    }

    /// Gravity, and the forces of contacts between grains.
    fn press_grains(&mut self) {
        let Self { grains, force, moment, neighbours, law, dt, .. } = self;
        for &i in &neighbours.moving {
            force[i as usize] = self.gravity * grains.mass[i as usize];
            moment[i as usize] = V3::zeros();
        }
        for near in &mut neighbours.grains {
            let (i, j) = (near.grain as usize, near.other as usize);
            let way = neighbours.period.nearest(grains.position[i] - grains.position[j]);
            let (ri, rj) = (grains.radius[i], grains.radius[j]);
            let square = way.norm_squared();
            if square >= (ri + rj) * (ri + rj) {
                near.memory = Memory::default();
                continue;
            }
            let distance = square.sqrt().max(f64::MIN_POSITIVE);
            let normal = way / distance;
            let depth = ri + rj - distance;
            // The contact is in the middle of the overlap.
            let (ai, aj) = (ri - 0.5 * depth, rj - 0.5 * depth);
            let (mi, mj) = (grains.mass[i], grains.mass[j]);
            let (wi, wj) = (grains.spin[i], grains.spin[j]);
            let pair = Pair {
                normal,
                depth,
                velocity: grains.velocity[i] - grains.velocity[j] - (wi * ai + wj * aj).cross(&normal),
                spin: wi - wj,
                mass: mi * mj / (mi + mj),
                radius: ri * rj / (ri + rj),
                smaller: ri.min(rj),
            };
            let (f, rolling) = law.act(&pair, &mut near.memory, *dt);
            let turning = f.cross(&normal);
            force[i] += f;
            force[j] -= f;
            moment[i] += turning * ai + rolling;
            moment[j] += turning * aj - rolling;
        }
    }

    /// Forces of contacts with walls and tools, after those between grains.
    fn press_others(&mut self, motions: &[Motion]) {
        let Self { grains, force, moment, tools, reactions, neighbours, walls, law, dt, .. } = self;
        for near in &mut neighbours.others {
            let i = near.grain as usize;
            let (x, r) = (grains.position[i], grains.radius[i]);
            let surface = match near.other {
                Other::Wall(wall) => walls.surface(wall, &x, law),
                Other::Tool(k) => tools[k as usize].surface(&motions[k as usize], &x, law),
            };
            let depth = r - surface.distance;
            if depth <= 0.0 {
                near.memory = Memory::default();
                continue;
            }
            let (normal, arm) = (surface.normal, r - 0.5 * depth);
            let pair = Pair {
                normal,
                depth,
                velocity: grains.velocity[i] - grains.spin[i].cross(&normal) * arm - surface.velocity,
                spin: grains.spin[i] - surface.spin,
                mass: grains.mass[i],
                radius: r,
                smaller: r,
            };
            let (f, rolling) = surface.law.act(&pair, &mut near.memory, *dt);
            force[i] += f;
            moment[i] += f.cross(&normal) * arm + rolling;
            match near.other {
                Other::Wall(Walls::FLOOR) => self.floor_load += f.z,
                Other::Wall(_) => {}
                Other::Tool(k) => {
                    let (reaction, motion) = (&mut reactions[k as usize], &motions[k as usize]);
                    let at = x - normal * arm - motion.position;
                    reaction.impulse -= f * *dt;
                    reaction.moment -= (at.cross(&f) + rolling) * *dt;
                }
            }
        }
    }

    fn integrate(&mut self) {
        let g = &mut self.grains;
        for &i in &self.neighbours.moving {
            let i = i as usize;
            let (mass, radius) = (g.mass[i], g.radius[i]);
            g.velocity[i] += self.force[i] * (self.dt / mass);
            g.position[i] += g.velocity[i] * self.dt;
            g.spin[i] += self.moment[i] * (self.dt / (0.4 * mass * radius * radius));
        }
    }

    /// The grains as they lie now.
    pub fn grains(&self) -> impl Iterator<Item = Grain> + '_ {
        self.grains
            .position
            .iter()
            .zip(&self.grains.radius)
            .map(|(&position, &radius)| Grain { position, radius })
    }

    /// Momentum of the grains, N s, and their angular momentum about the origin, N m s.
    #[must_use]
    pub fn momentum(&self) -> [V3; 2] {
        let g = &self.grains;
        let each = |i: usize| {
            let p = g.velocity[i] * g.mass[i];
            [p, g.position[i].cross(&p) + g.spin[i] * (0.4 * g.mass[i] * g.radius[i] * g.radius[i])]
        };
        (0..g.mass.len()).map(each).fold([V3::zeros(); 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
    }

    /// Mass of the grains, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.grains.mass.iter().sum()
    }

    /// Kinetic energy of the grains, J.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let g = &self.grains;
        let each = |i: usize| {
            let turning = 0.4 * g.radius[i] * g.radius[i] * g.spin[i].norm_squared();
            0.5 * g.mass[i] * (g.velocity[i].norm_squared() + turning)
        };
        (0..g.mass.len()).map(each).sum()
    }

    /// Energy of height of the grains above the floor, J.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        self.grains.position.iter().zip(&self.grains.mass).map(|(x, m)| m * GRAVITY * x.z).sum()
    }

    /// Energy of the springs of contacts, J.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let g = &self.grains;
        let pairs = self.neighbours.grains.iter().map(|near| {
            let (i, j) = (near.grain as usize, near.other as usize);
            let (ri, rj) = (g.radius[i], g.radius[j]);
            let depth = ri + rj - (g.position[i] - g.position[j]).norm();
            self.law.energy(depth, ri * rj / (ri + rj), &near.memory)
        });
        let walls = self.neighbours.others.iter().filter_map(|near| {
            let i = near.grain as usize;
            let Other::Wall(wall) = near.other else { return None };
            let depth = g.radius[i] - self.walls.distance(wall, &g.position[i]).0;
            Some(self.law.energy(depth, g.radius[i], &near.memory))
        });
        pairs.sum::<f64>() + walls.sum::<f64>()
    }

    /// Number of grains that move.
    #[must_use]
    pub fn moving(&self) -> usize {
        self.neighbours.moving.len()
    }

    /// Mean force of the grains on the floor in the last step, N, positive downwards.
    #[must_use]
    pub fn floor_load(&self) -> f64 {
        self.floor_load
    }

    /// Moves the wall at the end of the bin towards +x outwards by a distance, m.
    pub fn open(&mut self, distance: f64) {
        self.walls.opening += distance;
    }

    /// Takes away floor and walls, for tests of the balance of momentum.
    pub fn without_bin(&mut self) {
        self.walls.count = 0;
    }

    /// Switches gravity off, for tests of the balance of momentum.
    pub fn without_gravity(&mut self) {
        self.gravity = V3::zeros();
    }
}
