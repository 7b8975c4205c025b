//! The footprint of a wheel, or of a track, on soil.
//!
//! States of the stations lie in rows, one a strip, that are worked through four stations at a time: four whatever the
//! processor has, so that the order of sums is the same everywhere. The length of its rows tells a wheel's footprint
//! from a track's.

mod aside;
mod heap;
mod press;
mod shape;
mod transport;

use super::grid::Grid;
use super::ground::{SoilGround, Under};
use super::slip;
use crate::tyre::WheelMotion;
use crate::{M3, V3, normal_of};
use fearless_simd::{Level, Simd, dispatch};
use press::Sum;
use shape::Shape;
use vb_world::Heightfield;

/// Stations that are computed at once.
const LANES: usize = 4;
/// Place of the rearmost station in a row. The place on either side of the stations is for what flows in.
const FIRST: usize = 1;
/// Places of a wheel's row and of a track's: stations, inflow on both sides, and one that fills up the last lanes.
pub(crate) const WHEEL: usize = 24;
pub(crate) const TRACK: usize = 48;
/// Time over which the width of the contact that enters Bekker's pressure follows the contact, s.
const BREADTH_LAG: f64 = 0.02;

#[derive(Clone, Copy, Debug)]
pub(crate) struct SoilForce {
    pub(crate) force: V3,
    /// Backward component of the pressure on the rim, without shear: the resistance to compaction, N.
    pub(crate) compaction: f64,
    /// About the hub.
    pub(crate) moment: V3,
    /// Component of the force away from the ground, N.
    pub(crate) load: f64,
    /// How deep the lowest point of a wheel's middle plane lies below the undisturbed surface, m; 0 for a belt.
    pub(crate) sinkage: f64,
    /// What the implicit treatment of damping and unloading adds to the wheel's mass.
    pub(crate) inertia: M3,
}

/// One number a station of a strip, from the rearmost on.
pub(crate) type Row<const N: usize> = [f64; N];

/// The states of the soil under and around one wheel or track; strips from the rightmost on.
#[derive(Clone, Debug)]
pub(crate) struct Footprint<const N: usize> {
    shape: Shape<N>,
    /// Speed of a belt along the outline towards its rear, m/s; 0 for a wheel, whose rotation has its spin.
    belt: f64,
    /// Height of a belt above the ground up to which the soil between its pads is sheared on, m; 0 for a wheel.
    grip: f64,
    /// What acts at each station, where that is asked for.
    stations: Option<Box<Stations<N>>>,
    /// What SIMD the processor has.
    level: Level,
    /// As in [`super::grid::Cell`].
    plastic: Vec<Row<N>>,
    raised: Vec<Row<N>>,
    /// Displacement of the rim against the soil that mobilises its shear stress, along the heading and to the left, m.
    shear: [Vec<Row<N>>; 2],
    /// Plastic sinkage that undisturbed soil would have if it were pressed by the rim as it stands, m.
    pressed: Vec<Row<N>>,
    /// Whether the states are the ground's: else they are in the grid.
    live: bool,
    /// Whether it has ever been live.
    used: bool,
    /// Way to the left since the ground beside was last looked at, m; and plastic sinkage and heaps there.
    aside: f64,
    beside: [Row<N>; 2],
    /// Slip, from 0 to 1, that deepens the sinkage, with a lag; 0 on soils that have no slip sinkage.
    slip: f64,
    /// Width of the contact, with a lag, m.
    breadth: f64,
    /// Volume that waits to be heaped up beside the wheel, m³, and the steps that it has waited.
    waiting: (f64, u32),
}

/// What acts at each station, summed over the strips; components in the wheel's frame.
#[derive(Clone, Debug)]
pub(crate) struct Stations<const N: usize> {
    /// Along the heading, to the left and up, N.
    pub(crate) force: [Row<N>; 3],
    /// Part of it along the outline, towards the front, N.
    pub(crate) thrust: Row<N>,
    /// About the heading and about what is up, as the force acts beside the middle, N m.
    pub(crate) moment: [Row<N>; 2],
    /// Mass that the implicit treatment of damping and unloading adds along the normal, kg.
    pub(crate) inertia: Row<N>,
    /// Sinkage, m.
    pub(crate) sinkage: Row<N>,
}

impl<const N: usize> Stations<N> {
    const NONE: Self = Self {
        force: [[0.0; N]; 3],
        thrust: [0.0; N],
        moment: [[0.0; N]; 2],
        inertia: [0.0; N],
        sinkage: [0.0; N],
    };
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

/// A step of a footprint that is near the ground.
struct Step<'a> {
    surface: &'a Heightfield,
    /// What lies within reach of the hub.
    under: Under,
    motion: &'a WheelMotion,
    frame: Frame,
    /// Unit normal of the ground under the hub, out of it, in world axes.
    normal: V3,
    /// s.
    dt: f64,
}

impl Footprint<WHEEL> {
    /// For a tyre, on soil that is remembered at a resolution (m): as many strips as cells go into the width.
    pub(crate) fn wheel(radius: f64, width: f64, resolution: f64) -> Self {
        Self::of(Shape::wheel(radius, width, resolution))
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
        let below = surface.at(motion.hub.x, motion.hub.y);
        let normal = normal_of([below.dzdx, below.dzdy]);
        let height = (motion.hub.z - below.z) * normal.z;
        let near = height < self.shape.near && under.has_soil();
        let frame = motion
            .axis
            .cross(&normal)
            .try_normalize(0.3)
            .map(|along| Frame { along, axis: motion.axis, up: along.cross(&motion.axis) })
            .filter(|f| near && f.up.z > 0.1);
        let tilt = motion.axis.dot(&normal);
        let reach = self.shape.radius * (1.0 - tilt * tilt).max(0.0).sqrt();
        let step = frame.map(|frame| Step { surface, under, motion, frame, normal, dt });
        let force = self.advance(ground, motion, step)?;
        Some(SoilForce { sinkage: (reach - height).max(0.0), ..force })
    }
}

impl Footprint<TRACK> {
    /// For a belt whose lowest part reaches from `rear` to `front` (m, along the heading, from the point that stands for
    /// the hub) and that stays near the ground up to a height of `near` (m) of that point.
    /// Soil stays between its pads while it is less than `grip` (m) above the ground.
    pub(crate) fn track([rear, front]: [f64; 2], near: f64, grip: f64, width: f64, resolution: f64) -> Self {
        Self {
            grip,
            stations: Some(Box::new(Stations::NONE)),
            ..Self::of(Shape::track(rear, front, near, width, resolution))
        }
    }

    /// Places of the stations, and how far in front of the point that stands for the hub each is, m.
    pub(crate) fn places(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let xs = self.shape.xs;
        (FIRST..=Self::LAST).map(move |k| (k, xs[k]))
    }

    /// Sets the outline at a station: how far below the point that stands for the hub it is, m, its slope, rise over way
    /// forward, and how fast it rises against the hull, m/s.
    pub(crate) fn set(&mut self, k: usize, below: f64, slope: f64, rate: f64) {
        self.shape.set(k, below, slope, rate);
    }

    /// How far below the point that stands for the hub the outline is at a station, m, and its unit normal towards the
    /// belt: forward, up.
    pub(crate) fn outline(&self, k: usize) -> (f64, [f64; 2]) {
        let n = &self.shape.radial.normal;
        (self.shape.half[k], [n[0][k], n[2][k]])
    }

    /// What acted at each station in the last step in which the track touched the soil.
    pub(crate) fn stations(&self) -> Option<&Stations<TRACK>> {
        self.stations.as_deref()
    }

    /// As [`Footprint::step`], for a belt that moves by `belt` (m/s) along its outline towards the rear, on a hull with
    /// the axes forward and up (world). The motion is the hull's, without spin.
    #[allow(clippy::too_many_arguments, reason = "ground, hull and belt")]
    pub(crate) fn step_belt(
        &mut self,
        ground: &mut SoilGround,
        surface: &Heightfield,
        under: Under,
        motion: &WheelMotion,
        [along, up]: [V3; 2],
        belt: f64,
        dt: f64,
    ) -> Option<SoilForce> {
        self.belt = belt;
        let below = surface.at(motion.hub.x, motion.hub.y);
        let normal = normal_of([below.dzdx, below.dzdy]);
        let near = motion.hub.z - below.z < self.shape.near && under.has_soil();
        let frame = Some(Frame { along, axis: motion.axis, up }).filter(|f| near && f.up.z > 0.1);
        let step = frame.map(|frame| Step { surface, under, motion, frame, normal, dt });
        self.advance(ground, motion, step)
    }
}

impl<const N: usize> Footprint<N> {
    /// Place of the foremost station.
    const LAST: usize = N - 3;

    fn of(shape: Shape<N>) -> Self {
        let states = vec![[0.0; N]; shape.strips];
        Self {
            belt: 0.0,
            grip: 0.0,
            stations: None,
            level: Level::new(),
            plastic: states.clone(),
            raised: states.clone(),
            shear: [states.clone(), states.clone()],
            pressed: states,
            live: false,
            used: false,
            aside: 0.0,
            beside: [[0.0; N]; 2],
            slip: 0.0,
            breadth: shape.width,
            waiting: (0.0, 0),
            shape,
        }
    }

    /// A step, if there is a frame for it: else the states go back to the grid.
    fn advance(
        &mut self,
        ground: &mut SoilGround,
        motion: &WheelMotion,
        step: Option<Step<'_>>,
    ) -> Option<SoilForce> {
        let Some(step) = step else {
            self.retire(&mut ground.grid, motion);
            return None;
        };
        dispatch!(self.level, simd => self.step_with(simd, ground, &step))
    }

    /// [`Footprint::advance`] for one instruction set: what it calls must be compiled into it to be compiled for that
    /// set. Closures that arrays' `map` calls are not, so there are none here.
    #[inline(always)]
    fn step_with<S: Simd>(&mut self, simd: S, ground: &mut SoilGround, step: &Step<'_>) -> Option<SoilForce> {
        let Step { motion, frame, dt, .. } = step;
        // A wheel that has been in soil comes back to it.
        let returns = self.used && !self.live;
        if self.live {
            self.transport(simd, &mut ground.grid, step);
        } else {
            self.enter(&ground.grid, motion, frame);
        }
        if let Some(stations) = &mut self.stations {
            **stations = Stations::NONE;
        }
        if ground.digs() {
            let drive = self.belt + motion.spin * self.shape.radius;
            let travel = motion.velocity.dot(&frame.along);
            self.slip = slip::follow(self.slip, drive, travel, self.shape.renewal, *dt);
        }
        let mut sum = Sum::default();
        self.press(simd, ground, step, returns, &mut sum);
        let span = sum.span?;
        let soil = ground.soil_at(motion.hub.x, motion.hub.y);
        if let Some(soil) = soil {
            self.resist_aside(simd, soil, step, &mut sum);
        }
        let breadth = self.shape.strip_width() * sum.strips as f64;
        self.breadth += (breadth - self.breadth) * (dt / BREADTH_LAG).min(1.0);
        if sum.displaced > 0.0
            && let Some((slope, flow)) = soil.and_then(|soil| soil.heap)
        {
            self.heap(&mut ground.grid, step, span, flow * sum.displaced, slope);
        }
        let [xx, xy, xz, yy, yz, zz] = sum.inertia;
        let axes = M3::from_columns(&[frame.along, frame.axis, frame.up]);
        Some(SoilForce {
            force: frame.world(&sum.force),
            compaction: -sum.pressure,
            moment: frame.world(&sum.moment),
            load: sum.force.dot(&frame.local(&step.normal)),
            sinkage: 0.0,
            inertia: axes * M3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * axes.transpose(),
        })
    }

    /// Numbers that change when the soil under the wheel does.
    pub(crate) fn digest(&self) -> [f64; 6] {
        if !self.used {
            return [self.breadth, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        let row = |r: &Row<N>| r[FIRST..=Self::LAST].iter().sum::<f64>();
        let sum = |states: &[Row<N>]| states.iter().map(row).sum::<f64>();
        let [a, b] = &self.shear;
        [
            self.breadth + self.slip,
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
            for k in FIRST..=Self::LAST {
                let at = origin + f.along * self.shape.xs[k];
                let cell = grid.at(at.x, at.y);
                self.plastic[strip][k] = cell.plastic;
                self.raised[strip][k] = cell.raised;
            }
            self.shear[0][strip] = [0.0; N];
            self.shear[1][strip] = [0.0; N];
            self.pressed[strip] = [0.0; N];
        }
        self.aside = f64::INFINITY;
        self.slip = 0.0;
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
            for k in FIRST..=Self::LAST {
                self.leave(strip, k, grid, origin + along * self.shape.xs[k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::law::{Bulldozing, PressureDirection, SoilLaw};
    use super::super::shear::Shear;
    use super::super::sinkage::{Bekker, Sinkage};
    use super::super::slip::SlipSinkage;
    use super::*;

    /// A soil whose pressure is proportional to the sinkage.
    pub(super) fn linear() -> SoilLaw {
        SoilLaw {
            sinkage: Sinkage::Bekker(Bekker { k_phi: 2e6, k_c: 0.0, exponent: 1.0 }),
            slip_sinkage: SlipSinkage::None,
            cohesion: 0.0,
            friction_angle_deg: 30.0,
            shear: Shear::Janosi,
            shear_modulus: 0.01,
            elastic_stiffness: 2e8,
            damping: 0.0,
            pressure: PressureDirection::Radial,
            steel_friction: None,
            bulldozing: None,
        }
    }

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
            sinkage: Sinkage::Bekker(Bekker { k_phi: 2e6, k_c: 13e3, exponent: 1.1 }),
            slip_sinkage: SlipSinkage::Lyasko { strength: 1.0 },
            cohesion: 1e3,
            friction_angle_deg: 30.0,
            shear: Shear::Janosi,
            shear_modulus: 0.01,
            elastic_stiffness: 2e8,
            damping: 3e4,
            pressure,
            steel_friction: None,
            bulldozing: Some(Bulldozing { erosion_angle_deg: 30.0, flow: 0.5 }),
        };
        let mut stream = vb_math::rng::Stream::new(3, &["footprint"]);
        let heights = (0..21 * 21).map(|_| stream.normal(0.0, 0.05)).collect();
        let surface = Heightfield::new(21, 21, 1.0, heights);
        let mut ground = SoilGround::of_one(law.prepare(), [10.0, 10.0], 0.1);
        let mut wheel = Footprint::wheel(0.47, 0.25, 0.1);
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

    #[test]
    fn the_sinkage_of_a_wheel_is_that_of_its_middle_plane_whatever_its_tilt_and_the_grid() {
        let law = linear();
        // A plane that rises by 0.2 to the left.
        let surface = Heightfield::new(9, 9, 1.0, (0..81).map(|i| 0.2 * f64::from(i / 9)).collect());
        let normal = normal_of([0.0, 0.2]);
        let below = V3::new(0.3, 0.1, surface.height(0.3, 0.1));
        for tilt in [0.0, 0.1, -0.3_f64] {
            for resolution in [0.1, 0.05, 0.02] {
                let mut ground = SoilGround::of_one(law.prepare(), [4.0, 4.0], resolution);
                let mut wheel = Footprint::wheel(0.47, 0.25, resolution);
                let left = normal.cross(&V3::x());
                let axis = left * vb_math::cos(tilt) + normal * vb_math::sin(tilt);
                // The lowest point of the circle is 3 cm deep.
                let hub = below + normal * (0.47 * vb_math::cos(tilt) - 0.03);
                let still = V3::zeros();
                let motion = WheelMotion { hub, velocity: still, rotation: still, axis, spin: 0.0 };
                let under = ground.under(hub.x, hub.y, 0.47);
                let force = wheel.step(&mut ground, &surface, under, &motion, 1e-3).unwrap();
                assert!((force.sinkage - 0.03).abs() < 1e-9, "{tilt}, {resolution} m: {}", force.sinkage);
            }
        }
    }

    #[test]
    fn a_wheel_that_lay_flat_in_soil_comes_up_on_its_rim_without_a_blow() {
        let surface = Heightfield::new(9, 9, 1.0, vec![0.0; 81]);
        let mut ground = SoilGround::of_one(linear().prepare(), [4.0, 4.0], 0.1);
        let mut wheel = Footprint::wheel(0.47, 0.25, 0.1);
        // It stands above the ground, is laid down with its hub in the surface, and comes up again where it lies.
        let mut at = |degrees: f64, height: f64| {
            let roll = degrees.to_radians();
            let axis = V3::new(0.0, vb_math::cos(roll), vb_math::sin(roll));
            let still = V3::zeros();
            let hub = V3::new(0.0, 0.0, height);
            let motion = WheelMotion { hub, velocity: still, rotation: still, axis, spin: 0.0 };
            let under = ground.under(hub.x, hub.y, 0.47);
            let force = wheel.step(&mut ground, &surface, under, &motion, 1e-3);
            (wheel.live, force.map_or(0.0, |f| f.load))
        };
        assert!(at(0.0, 0.6).0 && !at(80.0, 0.0).0);
        let (live, load) = at(60.0, 0.0);
        assert!(live && load == 0.0, "{load} N");
        // What goes deeper meets the resistance of the depth.
        assert!(at(60.0, -0.01).1 > 1e4);
    }
}
