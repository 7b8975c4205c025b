//! The footprint of a wheel on soil.

use super::grid::Grid;
use super::ground::{SoilGround, Under};
use super::law::Soil;
use crate::{M3, V3};
use vb_world::{Heightfield, SurfacePoint};

/// Stations along the heading: this many on each side of the one under the axle.
const REACH: usize = 12;
const STATIONS: usize = 2 * REACH + 1;
/// The outermost stations lie at this part of the radius, where the rim stands at 72 degrees.
const EXTENT: f64 = 0.95;
/// Spacing under the axle over the mean spacing: where the rim leaves the soil matters most there.
const CROWDING: f64 = 0.35;
/// A wheel keeps its footprint until it is this part of its radius above the ground.
const CLEARANCE: f64 = 0.5;
/// Time over which the width of the contact that enters Bekker's pressure follows the contact, s.
const BREADTH_LAG: f64 = 0.02;
/// Largest shear displacement that is remembered, in shear moduli: exp(−5) is as good as sheared.
const SHEARED: f64 = 5.0;

/// How a wheel moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelMotion {
    /// Its centre, world, m.
    pub(crate) hub: V3,
    /// Velocity of the centre, m/s.
    pub(crate) velocity: V3,
    /// Angular velocity with its spin, rad/s.
    pub(crate) rotation: V3,
    /// Direction of the axle, to the left.
    pub(crate) axis: V3,
}

/// What the soil does to a wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoilForce {
    pub(crate) force: V3,
    /// The part of the force that is pressure, without shear.
    pub(crate) pressure: V3,
    /// About the hub.
    pub(crate) moment: V3,
    /// Component of the force away from the ground, N.
    pub(crate) load: f64,
    /// Greatest sinkage below the undisturbed surface, m.
    pub(crate) sinkage: f64,
    /// What the implicit treatment of damping and unloading adds to the wheel's mass.
    pub(crate) inertia: M3,
}

/// State of the soil at a station.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Station {
    /// As in [`super::grid::Cell`].
    plastic: f64,
    raised: f64,
    /// Displacement of the rim against the soil since it came into contact, along the heading and to the left, m.
    shear: [f64; 2],
}

impl Station {
    /// The mean of this state and one of weight `c` (≥ 0) that comes from upstream.
    #[inline]
    fn mix(&mut self, from: &Self, c: f64) {
        let inv = 1.0 / (1.0 + c);
        let mean = |a: f64, b: f64| (a + c * b) * inv;
        self.plastic = mean(self.plastic, from.plastic);
        self.raised = mean(self.raised, from.raised);
        self.shear = [mean(self.shear[0], from.shear[0]), mean(self.shear[1], from.shear[1])];
    }

    fn fresh(grid: &Grid, at: V3) -> Self {
        let cell = grid.at(at.x, at.y);
        Self { plastic: cell.plastic, raised: cell.raised, shear: [0.0; 2] }
    }

    fn leave(&self, grid: &mut Grid, at: V3) {
        if self.plastic == 0.0 && self.raised == 0.0 {
            return;
        }
        if let Some(cell) = grid.at_mut(at.x, at.y) {
            cell.plastic = cell.plastic.max(self.plastic);
            cell.raised = cell.raised.max(self.raised);
        }
    }
}

/// The states of the soil under and around one wheel.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    radius: f64,
    width: f64,
    strips: usize,
    /// Distance of each station from the axle along the heading, and the length it stands for.
    xs: [f64; STATIONS],
    lengths: [f64; STATIONS],
    /// Half the chord of the wheel's disc at each station.
    half: [f64; STATIONS],
    stations: Vec<Station>,
    live: bool,
    /// Width of the contact, with a lag, m.
    breadth: f64,
}

/// Directions of a wheel on the ground.
struct Frame {
    along: V3,
    up: V3,
}

/// What one step collects.
struct Sum {
    force: V3,
    pressure: V3,
    moment: V3,
    load: f64,
    sinkage: f64,
    inertia: M3,
    /// Strips in contact.
    strips: usize,
    displaced: f64,
    /// First and last station in contact.
    span: Option<(usize, usize)>,
}

impl Footprint {
    /// For a tyre, on soil that is remembered at a pitch (m): as many strips as cells go into the width.
    pub(crate) fn new(radius: f64, width: f64, pitch: f64) -> Self {
        let strips = ((width / pitch) as usize).clamp(2, 16);
        let extent = EXTENT * radius;
        let xs: [f64; STATIONS] = std::array::from_fn(|k| {
            let u = (k as f64 - REACH as f64) / REACH as f64;
            extent * u * (CROWDING + (1.0 - CROWDING) * u * u)
        });
        let lengths = std::array::from_fn(|k| {
            let low = if k == 0 { xs[0] } else { xs[k - 1] };
            let high = if k + 1 == STATIONS { xs[k] } else { xs[k + 1] };
            0.5 * (high - low)
        });
        Self {
            radius,
            width,
            strips,
            xs,
            lengths,
            half: xs.map(|x| (radius * radius - x * x).sqrt()),
            stations: vec![Station::default(); strips * STATIONS],
            live: false,
            breadth: width,
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
        let below = surface.at(motion.hub.x, motion.hub.y);
        let normal = normal_of(&below);
        let height = (motion.hub.z - below.z) * normal.z;
        let frame = motion
            .axis
            .cross(&normal)
            .try_normalize(0.3)
            .map(|along| Frame { up: along.cross(&motion.axis), along });
        let Some(frame) = frame
            .filter(|f| height < (1.0 + CLEARANCE) * self.radius && under != Under::Rigid && f.up.z > 0.1)
        else {
            self.retire(&mut ground.grid, motion);
            return None;
        };
        if self.live {
            self.transport(&mut ground.grid, motion, &frame, dt);
        } else {
            self.enter(&ground.grid, motion, &frame);
        }
        let mut sum = Sum {
            force: V3::zeros(),
            pressure: V3::zeros(),
            moment: V3::zeros(),
            load: 0.0,
            sinkage: 0.0,
            inertia: M3::zeros(),
            strips: 0,
            displaced: 0.0,
            span: None,
        };
        self.press(ground, surface, under, motion, &frame, dt, &mut sum);
        if sum.strips > 0 {
            let breadth = self.width * sum.strips as f64 / self.strips as f64;
            self.breadth += (breadth - self.breadth) * (dt / BREADTH_LAG).min(1.0);
        }
        if sum.displaced > 0.0
            && let Some(soil) = ground.soil_at(motion.hub.x, motion.hub.y)
            && let Some((slope, flow)) = soil.heap
            && let Some(span) = sum.span
        {
            self.heap(&mut ground.grid, motion, &frame, span, flow * sum.displaced, slope);
        }
        sum.span.is_some().then_some(SoilForce {
            force: sum.force,
            pressure: sum.pressure,
            moment: sum.moment,
            load: sum.load,
            sinkage: sum.sinkage,
            inertia: sum.inertia,
        })
    }

    /// Numbers that change when the soil under the wheel does.
    pub(crate) fn digest(&self) -> [f64; 4] {
        let mut sums = [self.breadth, 0.0, 0.0, 0.0];
        for s in &self.stations {
            sums[1] += s.plastic;
            sums[2] += s.raised;
            sums[3] += s.shear[0] + s.shear[1];
        }
        sums
    }

    fn offset(&self, strip: usize) -> f64 {
        self.width * ((strip as f64 + 0.5) / self.strips as f64 - 0.5)
    }

    /// Takes over the ground under the wheel from the grid.
    fn enter(&mut self, grid: &Grid, m: &WheelMotion, f: &Frame) {
        for strip in 0..self.strips {
            let origin = m.hub + m.axis * self.offset(strip);
            for k in 0..STATIONS {
                self.stations[strip * STATIONS + k] = Station::fresh(grid, origin + f.along * self.xs[k]);
            }
        }
        self.live = true;
    }

    /// Hands the ground under the wheel back to the grid.
    fn retire(&mut self, grid: &mut Grid, m: &WheelMotion) {
        if !self.live {
            return;
        }
        self.live = false;
        self.breadth = self.width;
        let along = m.axis.cross(&V3::z()).try_normalize(0.1).unwrap_or_else(V3::zeros);
        for strip in 0..self.strips {
            let origin = m.hub + m.axis * self.offset(strip);
            for k in 0..STATIONS {
                self.stations[strip * STATIONS + k].leave(grid, origin + along * self.xs[k]);
            }
        }
    }

    /// Moves the states through the footprint as the wheel moves over the ground: upwind and implicit, so that it is
    /// stable at any speed.
    fn transport(&mut self, grid: &mut Grid, m: &WheelMotion, f: &Frame, dt: f64) {
        const STILL: f64 = 1e-6;
        let edge = self.xs[STATIONS - 1];
        for strip in 0..self.strips {
            let arm = m.axis * self.offset(strip);
            let speed = (m.velocity + m.rotation.cross(&arm)).dot(&f.along);
            if speed.abs() < STILL {
                continue;
            }
            let origin = m.hub + arm;
            let ahead = edge * speed.signum();
            let mut upstream = Station::fresh(grid, origin + f.along * ahead);
            let row = &mut self.stations[strip * STATIONS..(strip + 1) * STATIONS];
            let travel = speed.abs() * dt;
            if speed > 0.0 {
                for k in (0..STATIONS).rev() {
                    row[k].mix(&upstream, travel / self.lengths[k]);
                    upstream = row[k];
                }
            } else {
                for (k, station) in row.iter_mut().enumerate() {
                    station.mix(&upstream, travel / self.lengths[k]);
                    upstream = *station;
                }
            }
            // Fast wheels leave more than a cell a step.
            let cells = (travel / grid.pitch()) as usize + 1;
            for i in 0..cells {
                let behind = ahead + speed.signum() * travel * i as f64 / cells as f64;
                upstream.leave(grid, origin - f.along * behind);
            }
        }
        let sideways = m.velocity.dot(&m.axis);
        if sideways.abs() > STILL {
            self.slide(grid, m, f, sideways * dt);
        }
    }

    /// Moves the states across the footprint of a wheel that slides to the left by `distance`.
    fn slide(&mut self, grid: &mut Grid, m: &WheelMotion, f: &Frame, distance: f64) {
        let spacing = self.width / self.strips as f64;
        let c = distance.abs() / spacing;
        let side = distance.signum() * 0.5 * (self.width + grid.pitch());
        for k in 0..STATIONS {
            let middle = m.hub + f.along * self.xs[k];
            let mut upstream = Station::fresh(grid, middle + m.axis * side);
            for i in 0..self.strips {
                let strip = if distance > 0.0 { self.strips - 1 - i } else { i };
                let station = &mut self.stations[strip * STATIONS + k];
                station.mix(&upstream, c);
                upstream = *station;
            }
            upstream.leave(grid, middle - m.axis * side);
        }
    }

    /// Presses the wheel into the soil.
    #[allow(clippy::too_many_arguments, reason = "wheel, ground and what comes of them")]
    fn press(
        &mut self,
        ground: &SoilGround,
        surface: &Heightfield,
        under: Under,
        m: &WheelMotion,
        f: &Frame,
        dt: f64,
        sum: &mut Sum,
    ) {
        let strip_width = self.width / self.strips as f64;
        let inverse_radius = 1.0 / self.radius;
        for strip in 0..self.strips {
            let origin = m.hub + m.axis * self.offset(strip);
            let mut touches = false;
            for k in 0..STATIONS {
                let (x, half) = (self.xs[k], self.half[k]);
                let point = origin + f.along * x - f.up * half;
                let g = surface.at(point.x, point.y);
                let station = &mut self.stations[strip * STATIONS + k];
                let gap = g.z + station.raised - point.z;
                if gap <= 0.0 {
                    station.shear = [0.0; 2];
                    continue;
                }
                let ground_normal = normal_of(&g);
                let sinkage = gap * ground_normal.z;
                let (soil, share) = match under {
                    Under::Soil(ref soil) => (soil, 1.0),
                    _ => match ground.soil_at(point.x, point.y) {
                        Some(soil) => (soil, ground.share(point.x, point.y, BLEND)),
                        None => continue,
                    },
                };
                let before = station.plastic;
                let (stress, yields) = soil.load(soil.modulus(self.breadth), sinkage, &mut station.plastic);
                if stress <= 0.0 {
                    station.shear = [0.0; 2];
                    continue;
                }
                // Area of the ground that the station stands for; that of the rim over it is larger where it is steep.
                let area = self.lengths[k] * strip_width * share;
                let (n, t, rim) = if soil.radial {
                    let (cos, sin) = (half * inverse_radius, x * inverse_radius);
                    (f.up * cos - f.along * sin, f.along * cos + f.up * sin, area / cos)
                } else {
                    (ground_normal, f.along, area)
                };
                let arm = point - m.hub;
                let velocity = m.velocity + m.rotation.cross(&arm);
                let leaving = velocity.dot(&n);
                let pressure = stress - soil.damping * leaving;
                touches = true;
                sum.sinkage = sum.sinkage.max(sinkage);
                sum.displaced += (station.plastic - before) * area;
                sum.span = Some(sum.span.map_or((k, k), |(a, b)| (a.min(k), b.max(k))));
                if pressure <= 0.0 {
                    station.shear = [0.0; 2];
                    continue;
                }
                let slip = [(velocity - n * leaving).dot(&t), velocity.dot(&m.axis)];
                let tangential = shear_stress(soil, &mut station.shear, slip, pressure, dt);
                let force = (n * pressure + t * tangential[0] + m.axis * tangential[1]) * rim;
                sum.force += force;
                sum.pressure += n * (pressure * rim);
                sum.moment += arm.cross(&force);
                sum.load += force.dot(&f.up);
                let stiffness = if yields { 0.0 } else { soil.elastic };
                let implicit = rim * dt * (soil.damping + dt * stiffness);
                sum.inertia += n * n.transpose() * implicit;
            }
            sum.strips += usize::from(touches);
        }
    }

    /// Heaps displaced soil up around the contact: before and behind it within the footprint, beside it on the grid.
    /// Each side gets what its share of the perimeter is.
    fn heap(
        &mut self,
        grid: &mut Grid,
        m: &WheelMotion,
        f: &Frame,
        (first, last): (usize, usize),
        volume: f64,
        slope: f64,
    ) {
        let pitch = grid.pitch();
        let length = self.xs[last] - self.xs[first] + self.lengths[first];
        let around = 2.0 * (length + self.width);
        let end = volume * self.width / around;
        for (from, step) in [(last, 1isize), (first, -1)] {
            let outside = |k: usize| k.checked_add_signed(step).filter(|k| *k < STATIONS);
            let Some(nearest) = outside(from) else { continue };
            for strip in 0..self.strips {
                let row = &mut self.stations[strip * STATIONS..(strip + 1) * STATIONS];
                row[nearest].raised += end / (self.width * self.lengths[nearest]);
                let mut k = nearest;
                while let Some(next) = outside(k) {
                    let spacing = (self.xs[next] - self.xs[k]).abs();
                    let excess = row[k].raised - row[next].raised - slope * spacing;
                    if excess <= 0.0 {
                        break;
                    }
                    let (a, b) = (self.lengths[k], self.lengths[next]);
                    let moved = excess * a * b / (a + b);
                    row[k].raised -= moved / a;
                    row[next].raised += moved / b;
                    k = next;
                }
            }
        }
        let side = volume * length / around;
        let count = (length / pitch) as usize + 1;
        let each = side / (count as f64 * pitch * pitch);
        for direction in [-1.0, 1.0] {
            for i in 0..count {
                let x = self.xs[first] + length * (i as f64 + 0.5) / count as f64;
                let beside = |ring: usize| {
                    let y = direction * (0.5 * self.width + pitch * (ring as f64 + 0.5));
                    m.hub + f.along * x + m.axis * y
                };
                let at = beside(0);
                let Some(cell) = grid.at_mut(at.x, at.y) else { continue };
                cell.raised += each;
                let mut inner = (at, cell.raised);
                for ring in 1..RINGS {
                    let at = beside(ring);
                    let Some(outer) = grid.at_mut(at.x, at.y) else { break };
                    let moved = 0.5 * (inner.1 - outer.raised - slope * pitch);
                    if moved <= 0.0 {
                        break;
                    }
                    outer.raised += moved;
                    let next = (at, outer.raised);
                    if let Some(cell) = grid.at_mut(inner.0.x, inner.0.y) {
                        cell.raised -= moved;
                    }
                    inner = next;
                }
            }
        }
    }
}

/// Cells beside the wheel over which a heap may slide, as the original lets it (facts §4.3: 10 propagations).
const RINGS: usize = 10;

/// Half the width over which a load is handed over between soil and rigid ground, m.
pub(crate) const BLEND: f64 = 0.05;

#[inline]
fn normal_of(g: &SurfacePoint) -> V3 {
    let inv = 1.0 / (1.0 + g.dzdx * g.dzdx + g.dzdy * g.dzdy).sqrt();
    V3::new(-g.dzdx * inv, -g.dzdy * inv, inv)
}

/// Advances the shear displacement by a slip velocity; returns the stress on the rim (Pa) along the heading and to
/// the left.
#[inline]
fn shear_stress(soil: &Soil, shear: &mut [f64; 2], slip: [f64; 2], pressure: f64, dt: f64) -> [f64; 2] {
    let mut j = [shear[0] + dt * slip[0], shear[1] + dt * slip[1]];
    let mut size = (j[0] * j[0] + j[1] * j[1]).sqrt();
    let most = SHEARED / soil.inverse_shear_modulus;
    if size > most {
        j = [j[0] * most / size, j[1] * most / size];
        size = most;
    }
    *shear = j;
    if size < 1e-12 {
        return [0.0; 2];
    }
    let strength = soil.cohesion + pressure * soil.tan_phi;
    let stress = soil.shear(pressure, size);
    // The damper fades as the soil shears.
    let damper = soil.shear_damping * (strength - stress);
    let s = [-stress * j[0] / size - damper * slip[0], -stress * j[1] / size - damper * slip[1]];
    let total = (s[0] * s[0] + s[1] * s[1]).sqrt();
    if total > strength { [s[0] * strength / total, s[1] * strength / total] } else { s }
}
