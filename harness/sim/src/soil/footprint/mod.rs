//! The footprint of a wheel on soil.
//!
//! States of the stations lie in rows, one a strip, that are worked through four stations at a time: four whatever the
//! processor has, so that the order of sums is the same everywhere.

mod heap;
mod press;
mod transport;

use super::grid::Grid;
use super::ground::{SoilGround, Under};
use crate::tyre::WheelMotion;
use crate::{M3, V3};
use fearless_simd::{Level, Simd, dispatch};
use press::Sum;
use vb_world::Heightfield;

/// Stations along the heading: this many on each side of the one under the axle.
const REACH: usize = 10;
const STATIONS: usize = 2 * REACH + 1;
/// Stations that are computed at once.
const LANES: usize = 4;
/// Places of the rearmost and of the foremost station in a row. The place on either side is for what flows in.
const FIRST: usize = 1;
const LAST: usize = STATIONS;
/// Place of the station under the axle.
const MIDDLE: usize = FIRST + REACH;
/// Places of a row: stations, inflow on both sides, and what fills up the last lanes.
const PLACES: usize = (STATIONS + 2).next_multiple_of(LANES);
/// The outermost stations lie at this part of the radius, where the rim stands at 72 degrees.
const EXTENT: f64 = 0.95;
/// Spacing under the axle over the mean spacing: where the rim leaves the soil matters most there.
const CROWDING: f64 = 0.35;
/// A wheel keeps its footprint until it is this part of its radius above the ground.
const CLEARANCE: f64 = 0.5;
/// Time over which the width of the contact that enters Bekker's pressure follows the contact, s.
const BREADTH_LAG: f64 = 0.02;

/// What the soil does to a wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoilForce {
    pub(crate) force: V3,
    /// Backward component of the pressure on the rim, without shear: the resistance to compaction, N.
    pub(crate) compaction: f64,
    /// About the hub.
    pub(crate) moment: V3,
    /// Component of the force away from the ground, N.
    pub(crate) load: f64,
    /// Greatest sinkage below the undisturbed surface, m.
    pub(crate) sinkage: f64,
    /// What the implicit treatment of damping and unloading adds to the wheel's mass.
    pub(crate) inertia: M3,
}

/// One number a station of a strip, from the rearmost on.
type Row = [f64; PLACES];
const NO_ROW: Row = [0.0; PLACES];

/// The states of the soil under and around one wheel; strips from the rightmost on.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    shape: Shape,
    /// What SIMD the processor has.
    level: Level,
    /// As in [`super::grid::Cell`].
    plastic: Vec<Row>,
    raised: Vec<Row>,
    /// Displacement of the rim against the soil that mobilises its shear stress, along the heading and to the left, m.
    shear: [Vec<Row>; 2],
    /// Plastic sinkage that undisturbed soil would have if it were pressed by the rim as it stands, m.
    pressed: Vec<Row>,
    /// Whether the states are the ground's: else they are in the grid.
    live: bool,
    /// Whether it has ever been live.
    used: bool,
    /// Way to the left since the ground beside was last looked at, m; and plastic sinkage and heaps there.
    aside: f64,
    beside: [Row; 2],
    /// Width of the contact, with a lag, m.
    breadth: f64,
    /// Volume that waits to be heaped up beside the wheel, m³, and the steps that it has waited.
    waiting: (f64, u32),
}

/// What doesn't change: the wheel and where its stations are.
#[derive(Clone, Debug)]
struct Shape {
    radius: f64,
    width: f64,
    strips: usize,
    /// Distance of each station from the axle along the heading, and the length it stands for.
    xs: Row,
    lengths: Row,
    inverse_lengths: Row,
    /// Half the chord of the wheel's disc at each station.
    half: Row,
    /// Pressure towards the axle and pressure normal to the ground.
    radial: Directions,
    level: Directions,
}

/// Directions of stresses on the rim in the wheel's frame, and the rim's length over each station, m.
#[derive(Clone, Debug)]
struct Directions {
    normal: [Row; 3],
    /// Along the heading and up.
    tangent: [Row; 2],
    rim: Row,
}

/// Directions of a wheel on the ground: a right-handed frame of heading, axle and what is across both.
struct Frame {
    along: V3,
    axis: V3,
    up: V3,
}

impl Frame {
    /// Components of a vector along heading, axle and up.
    #[inline]
    fn local(&self, v: &V3) -> V3 {
        V3::new(self.along.dot(v), self.axis.dot(v), self.up.dot(v))
    }

    #[inline]
    fn world(&self, v: &V3) -> V3 {
        self.along * v.x + self.axis * v.y + self.up * v.z
    }
}

impl Shape {
    fn new(radius: f64, width: f64, pitch: f64) -> Self {
        let extent = EXTENT * radius;
        let at = |place: usize| {
            let u = (place.clamp(FIRST, LAST) as f64 - MIDDLE as f64) / REACH as f64;
            extent * u * (CROWDING + (1.0 - CROWDING) * u * u)
        };
        let xs: Row = std::array::from_fn(at);
        let lengths: Row = std::array::from_fn(|k| {
            let inside = (FIRST..=LAST).contains(&k);
            if inside { 0.5 * (at(k + 1) - at(k - 1)) } else { 0.0 }
        });
        let half = xs.map(|x| (radius * radius - x * x).sqrt());
        let (sin, cos) = (xs.map(|x| x / radius), half.map(|h| h / radius));
        let rim = std::array::from_fn(|k| lengths[k] * radius / half[k]);
        Self {
            radius,
            width,
            strips: ((width / pitch) as usize).clamp(2, 16),
            xs,
            lengths,
            inverse_lengths: lengths.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 }),
            half,
            radial: Directions { normal: [sin.map(|s| -s), NO_ROW, cos], tangent: [cos, sin], rim },
            level: Directions {
                normal: [NO_ROW, NO_ROW, [1.0; PLACES]],
                tangent: [[1.0; PLACES], NO_ROW],
                rim: lengths,
            },
        }
    }

    fn strip_width(&self) -> f64 {
        self.width / self.strips as f64
    }

    /// Distance of a strip's middle to the left of the wheel's.
    fn offset(&self, strip: usize) -> f64 {
        self.width * ((strip as f64 + 0.5) / self.strips as f64 - 0.5)
    }
}

impl Footprint {
    /// For a tyre, on soil that is remembered at a pitch (m): as many strips as cells go into the width.
    pub(crate) fn new(radius: f64, width: f64, pitch: f64) -> Self {
        let shape = Shape::new(radius, width, pitch);
        let states = vec![NO_ROW; shape.strips];
        Self {
            shape,
            level: Level::new(),
            plastic: states.clone(),
            raised: states.clone(),
            shear: [states.clone(), states.clone()],
            pressed: states,
            live: false,
            used: false,
            aside: 0.0,
            beside: [NO_ROW; 2],
            breadth: width,
            waiting: (0.0, 0),
        }
    }

    /// The force of the soil on a wheel that moves as `motion` says, if it touches any, and what that does to the
    /// soil. `under` is what lies within a radius of the hub. Call it every step, in contact or not.
    pub(crate) fn step(
        &mut self,
        ground: &mut SoilGround,
        surface: &Heightfield,
        under: Under,
        motion: &WheelMotion,
        dt: f64,
    ) -> Option<SoilForce> {
        dispatch!(self.level, simd => self.step_with(simd, ground, surface, under, motion, dt))
    }

    /// [`Footprint::step`] for one instruction set: what it calls must be compiled into it to be compiled for that set.
    /// Closures that arrays' `map` calls are not, so there are none here.
    #[inline(always)]
    fn step_with<S: Simd>(
        &mut self,
        simd: S,
        ground: &mut SoilGround,
        surface: &Heightfield,
        under: Under,
        motion: &WheelMotion,
        dt: f64,
    ) -> Option<SoilForce> {
        let below = surface.at(motion.hub.x, motion.hub.y);
        let normal = normal_of([below.dzdx, below.dzdy]);
        let height = (motion.hub.z - below.z) * normal.z;
        let near = height < (1.0 + CLEARANCE) * self.shape.radius && under != Under::Rigid;
        let frame = motion
            .axis
            .cross(&normal)
            .try_normalize(0.3)
            .map(|along| Frame { along, axis: motion.axis, up: along.cross(&motion.axis) })
            .filter(|f| near && f.up.z > 0.1);
        let Some(frame) = frame else {
            self.retire(&mut ground.grid, motion);
            return None;
        };
        if self.live {
            self.transport(&mut ground.grid, motion, &frame, dt);
        } else {
            self.enter(&ground.grid, motion, &frame);
        }
        let mut sum = Sum::default();
        self.press(simd, ground, surface, under, motion, &frame, dt, &mut sum);
        let span = sum.span?;
        let breadth = self.shape.strip_width() * sum.strips as f64;
        self.breadth += (breadth - self.breadth) * (dt / BREADTH_LAG).min(1.0);
        if sum.displaced > 0.0
            && let Some(soil) = ground.soil_at(motion.hub.x, motion.hub.y)
            && let Some((slope, flow)) = soil.heap
        {
            self.heap(&mut ground.grid, motion, &frame, span, flow * sum.displaced, slope);
        }
        let [xx, xy, xz, yy, yz, zz] = sum.inertia;
        let axes = M3::from_columns(&[frame.along, frame.axis, frame.up]);
        Some(SoilForce {
            force: frame.world(&sum.force),
            compaction: -sum.pressure,
            moment: frame.world(&sum.moment),
            load: sum.force.dot(&frame.local(&normal)),
            sinkage: sum.sinkage,
            inertia: axes * M3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * axes.transpose(),
        })
    }

    /// Numbers that change when the soil under the wheel does.
    pub(crate) fn digest(&self) -> [f64; 6] {
        if !self.used {
            return [self.breadth, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        let row = |r: &Row| r[FIRST..=LAST].iter().sum::<f64>();
        let sum = |states: &[Row]| states.iter().map(row).sum::<f64>();
        let [a, b] = &self.shear;
        [
            self.breadth,
            row(&self.beside[0]) + row(&self.beside[1]),
            sum(&self.plastic),
            sum(&self.raised),
            sum(a) + sum(b),
            self.waiting.0,
        ]
    }

    /// Takes over the ground under the wheel from the grid, unsheared.
    fn enter(&mut self, grid: &Grid, m: &WheelMotion, f: &Frame) {
        for strip in 0..self.shape.strips {
            let origin = m.hub + m.axis * self.shape.offset(strip);
            for k in FIRST..=LAST {
                let at = origin + f.along * self.shape.xs[k];
                let cell = grid.at(at.x, at.y);
                self.plastic[strip][k] = cell.plastic;
                self.raised[strip][k] = cell.raised;
            }
            self.shear[0][strip] = NO_ROW;
            self.shear[1][strip] = NO_ROW;
            self.pressed[strip] = NO_ROW;
        }
        self.aside = f64::INFINITY;
        self.breadth = self.shape.width;
        self.live = true;
        self.used = true;
    }

    /// Leaves the state of a station to the grid.
    fn leave(&self, strip: usize, k: usize, grid: &mut Grid, at: V3) {
        let (plastic, raised) = (self.plastic[strip][k], self.raised[strip][k]);
        if (plastic != 0.0 || raised != 0.0)
            && let Some(cell) = grid.at_mut(at.x, at.y)
        {
            cell.plastic = cell.plastic.max(plastic);
            cell.raised = cell.raised.max(raised);
        }
    }

    /// Hands the ground under the wheel back to the grid.
    fn retire(&mut self, grid: &mut Grid, m: &WheelMotion) {
        if !self.live {
            return;
        }
        self.live = false;
        let along = m.axis.cross(&V3::z()).try_normalize(0.1).unwrap_or_else(V3::zeros);
        for strip in 0..self.shape.strips {
            let origin = m.hub + m.axis * self.shape.offset(strip);
            for k in FIRST..=LAST {
                self.leave(strip, k, grid, origin + along * self.shape.xs[k]);
            }
        }
    }
}

#[inline]
fn normal_of([dzdx, dzdy]: [f64; 2]) -> V3 {
    let inv = 1.0 / (1.0 + dzdx * dzdx + dzdy * dzdy).sqrt();
    V3::new(-dzdx * inv, -dzdy * inv, inv)
}

#[cfg(test)]
mod tests {
    use super::super::law::{Bulldozing, PressureDirection, SoilLaw};
    use super::*;

    /// All that the processor has.
    fn levels() -> Vec<Level> {
        let mut levels = vec![Level::baseline(), Level::new()];
        #[cfg(target_arch = "x86_64")]
        {
            let best = Level::new();
            levels.extend(best.as_sse4_2().map(Level::Sse4_2));
            levels.extend(best.as_avx2().map(Level::Avx2));
        }
        levels
    }

    /// The bits of all forces on a wheel that rolls, slips, slides to the left, bounces and turns over rough soil.
    fn forces(level: Level, pressure: PressureDirection) -> Vec<u64> {
        let law = SoilLaw {
            k_phi: 2e6,
            k_c: 13e3,
            n: 1.1,
            cohesion: 1e3,
            friction_angle_deg: 30.0,
            shear_modulus: 0.01,
            elastic_stiffness: 2e8,
            damping: 3e4,
            pressure,
            bulldozing: Some(Bulldozing { erosion_angle_deg: 30.0, flow: 0.5 }),
        };
        let mut stream = vb_math::rng::Stream::new(3, &["footprint"]);
        let heights = (0..21 * 21).map(|_| stream.normal(0.0, 0.05)).collect();
        let surface = Heightfield::new(21, 21, 1.0, heights);
        let mut ground = SoilGround::of_one(law.prepare(), [10.0, 10.0], 0.1);
        let mut wheel = Footprint::new(0.47, 0.25, 0.1);
        wheel.level = level;
        let mut bits = Vec::new();
        for i in 0..3000 {
            let t = 1e-3 * f64::from(i);
            let yaw = 0.3 * t;
            let axis = V3::new(-vb_math::sin(yaw), vb_math::cos(yaw), 0.05);
            let axis = axis / axis.norm();
            let velocity = V3::new(2.0, 0.3, 0.8 * vb_math::cos(8.0 * t));
            let hub = V3::new(-5.0 + 2.0 * t, 0.3 * t, 0.42 + 0.1 * vb_math::sin(8.0 * t));
            let spin = 2.0 + 4.0 * t;
            let motion = WheelMotion { hub, velocity, rotation: axis * spin, axis, spin };
            let under = ground.under(hub.x, hub.y, 0.47);
            if let Some(f) = wheel.step(&mut ground, &surface, under, &motion, 1e-3) {
                bits.extend(f.force.iter().chain(f.moment.iter()).map(|x| x.to_bits()));
                bits.extend(wheel.digest().map(f64::to_bits));
            }
        }
        bits
    }

    #[test]
    fn every_instruction_set_of_the_processor_gives_the_same_bits() {
        for pressure in [PressureDirection::Radial, PressureDirection::Ground] {
            let first = forces(Level::baseline(), pressure);
            assert!(first.len() > 10_000, "the wheel touches the ground");
            for level in levels() {
                assert!(forces(level, pressure) == first, "{level:?}");
            }
        }
    }
}
