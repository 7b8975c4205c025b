//! The footprint of a wheel on soil.

use super::grid::Grid;
use super::ground::{SoilGround, Under};
use crate::tyre::WheelMotion;
use crate::{M3, V3};
use vb_world::Heightfield;

/// Stations along the heading: this many on each side of the one under the axle.
const REACH: usize = 10;
const STATIONS: usize = 2 * REACH + 1;
/// The outermost stations lie at this part of the radius, where the rim stands at 72 degrees.
const EXTENT: f64 = 0.95;
/// Spacing under the axle over the mean spacing: where the rim leaves the soil matters most there.
const CROWDING: f64 = 0.35;
/// A wheel keeps its footprint until it is this part of its radius above the ground.
const CLEARANCE: f64 = 0.5;
/// Time over which the width of the contact that enters Bekker's pressure follows the contact, s.
const BREADTH_LAG: f64 = 0.02;
/// Part of the grid's pitch by which a wheel slides before it looks at the ground beside it again.
const SLIDE: f64 = 0.02;

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

/// One number a station of a strip, from the rearmost on.
type Row = [f64; STATIONS];

/// The states of the soil under and around one wheel; strips from the rightmost on.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    radius: f64,
    width: f64,
    strips: usize,
    /// Distance of each station from the axle along the heading, and the length it stands for.
    xs: Row,
    lengths: Row,
    inverse_lengths: Row,
    /// Half the chord of the wheel's disc at each station; sine, cosine and secant of the rim's slope there.
    half: Row,
    rim: [(f64, f64, f64); STATIONS],
    /// As in [`super::grid::Cell`].
    plastic: Vec<Row>,
    raised: Vec<Row>,
    /// Displacement of the rim against the soil since it came into contact, along the heading and to the left, m.
    shear: [Vec<Row>; 2],
    /// Whether the states are the ground's: else they are in the grid.
    live: bool,
    /// Way to the left since the ground beside was last looked at, m; and plastic sinkage and heaps there.
    aside: f64,
    beside: [Row; 2],
    /// Width of the contact, with a lag, m.
    breadth: f64,
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

/// What one step collects, in the wheel's frame.
#[derive(Default)]
struct Sum {
    force: V3,
    pressure: V3,
    moment: V3,
    sinkage: f64,
    /// xx, xy, xz, yy, yz, zz.
    inertia: [f64; 6],
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
        let xs: Row = std::array::from_fn(|k| {
            let u = (k as f64 - REACH as f64) / REACH as f64;
            extent * u * (CROWDING + (1.0 - CROWDING) * u * u)
        });
        let lengths: Row = std::array::from_fn(|k| {
            let low = if k == 0 { xs[0] } else { xs[k - 1] };
            let high = if k + 1 == STATIONS { xs[k] } else { xs[k + 1] };
            0.5 * (high - low)
        });
        let half = xs.map(|x| (radius * radius - x * x).sqrt());
        let states = vec![[0.0; STATIONS]; strips];
        Self {
            radius,
            width,
            strips,
            xs,
            lengths,
            inverse_lengths: lengths.map(|l| 1.0 / l),
            half,
            rim: std::array::from_fn(|k| (xs[k] / radius, half[k] / radius, radius / half[k])),
            plastic: states.clone(),
            raised: states.clone(),
            shear: [states.clone(), states],
            live: false,
            aside: 0.0,
            beside: [[0.0; STATIONS]; 2],
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
        let normal = normal_of([below.dzdx, below.dzdy]);
        let height = (motion.hub.z - below.z) * normal.z;
        let near = height < (1.0 + CLEARANCE) * self.radius && under != Under::Rigid;
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
        self.press(ground, surface, under, motion, &frame, dt, &mut sum);
        let span = sum.span?;
        let breadth = self.width * sum.strips as f64 / self.strips as f64;
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
            pressure: frame.world(&sum.pressure),
            moment: frame.world(&sum.moment),
            load: sum.force.dot(&frame.local(&normal)),
            sinkage: sum.sinkage,
            inertia: axes * M3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * axes.transpose(),
        })
    }

    /// Numbers that change when the soil under the wheel does.
    pub(crate) fn digest(&self) -> [f64; 5] {
        let sum = |states: &[Row]| states.iter().flatten().sum::<f64>();
        let [a, b] = &self.shear;
        [
            self.breadth,
            self.beside[0].iter().sum::<f64>() + self.beside[1].iter().sum::<f64>(),
            sum(&self.plastic),
            sum(&self.raised),
            sum(a) + sum(b),
        ]
    }

    fn offset(&self, strip: usize) -> f64 {
        self.width * ((strip as f64 + 0.5) / self.strips as f64 - 0.5)
    }

    /// Takes the state of a station from the grid, unsheared.
    fn take(&mut self, strip: usize, k: usize, grid: &Grid, at: V3) {
        let cell = grid.at(at.x, at.y);
        self.plastic[strip][k] = cell.plastic;
        self.raised[strip][k] = cell.raised;
        self.shear[0][strip][k] = 0.0;
        self.shear[1][strip][k] = 0.0;
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

    /// Takes over the ground under the wheel from the grid.
    fn enter(&mut self, grid: &Grid, m: &WheelMotion, f: &Frame) {
        for strip in 0..self.strips {
            let origin = m.hub + m.axis * self.offset(strip);
            for k in 0..STATIONS {
                self.take(strip, k, grid, origin + f.along * self.xs[k]);
            }
        }
        self.aside = f64::INFINITY;
        self.breadth = self.width;
        self.live = true;
    }

    /// Hands the ground under the wheel back to the grid.
    fn retire(&mut self, grid: &mut Grid, m: &WheelMotion) {
        if !self.live {
            return;
        }
        self.live = false;
        let along = m.axis.cross(&V3::z()).try_normalize(0.1).unwrap_or_else(V3::zeros);
        for strip in 0..self.strips {
            let origin = m.hub + m.axis * self.offset(strip);
            for k in 0..STATIONS {
                self.leave(strip, k, grid, origin + along * self.xs[k]);
            }
        }
    }

    /// Moves the states through the footprint as the wheel moves over the ground, by upwind differences.
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
            let direction = speed.signum();
            let travel = speed.abs() * dt;
            let entering = origin + f.along * (edge * direction);
            let cell = grid.at(entering.x, entering.y);
            // Upwind differences are stable up to one station a step.
            let parts = (travel * self.inverse_lengths[REACH]) as usize + 1;
            let part = travel / parts as f64;
            let [a, b] = &mut self.shear;
            let rows = [
                (&mut self.plastic[strip], cell.plastic),
                (&mut self.raised[strip], cell.raised),
                (&mut a[strip], 0.0),
                (&mut b[strip], 0.0),
            ];
            for (row, inflow) in rows {
                for _ in 0..parts {
                    advect(row, inflow, direction > 0.0, part, &self.inverse_lengths);
                }
            }
            // Fast wheels leave more than a cell a step.
            let last = if direction > 0.0 { 0 } else { STATIONS - 1 };
            let cells = (travel / grid.pitch()) as usize + 1;
            for i in 0..cells {
                let back = edge * direction + direction * travel * i as f64 / cells as f64;
                self.leave(strip, last, grid, origin - f.along * back);
            }
        }
        let distance = m.velocity.dot(&m.axis) * dt;
        if distance.abs() > STILL * dt {
            self.slide(grid, m, f, distance);
        }
    }

    /// Moves the states across the footprint of a wheel that slides to the left by `distance`. What lies beside the
    /// wheel is taken from and left to the grid every couple of millimetres.
    fn slide(&mut self, grid: &mut Grid, m: &WheelMotion, f: &Frame, distance: f64) {
        let strip = |i: usize| if distance > 0.0 { i } else { self.strips - 1 - i };
        let turned = self.aside * distance < 0.0;
        self.aside += distance;
        // At the start it is infinite.
        if turned || self.aside.abs() >= SLIDE * grid.pitch() {
            self.aside = 0.0;
            let side = m.axis * (distance.signum() * 0.5 * (self.width + grid.pitch()));
            for k in 0..STATIONS {
                let middle = m.hub + f.along * self.xs[k];
                self.leave(strip(0), k, grid, middle - side);
                let entering = middle + side;
                let cell = grid.at(entering.x, entering.y);
                self.beside[0][k] = cell.plastic;
                self.beside[1][k] = cell.raised;
            }
        }
        let c = (distance.abs() * self.strips as f64 / self.width).min(1.0);
        // From where states leave towards where they enter, so that each still finds its neighbour's old state.
        for i in 0..self.strips {
            let (to, from) = (strip(i), (i + 1 < self.strips).then(|| strip(i + 1)));
            let mix = |states: &mut [Row], inflow: &Row| {
                let upstream = from.map_or(*inflow, |from| states[from]);
                for (state, up) in states[to].iter_mut().zip(&upstream) {
                    *state += c * (up - *state);
                }
            };
            mix(&mut self.plastic, &self.beside[0]);
            mix(&mut self.raised, &self.beside[1]);
            mix(&mut self.shear[0], &[0.0; STATIONS]);
            mix(&mut self.shear[1], &[0.0; STATIONS]);
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
        let velocity = f.local(&m.velocity);
        let rotation = f.local(&m.rotation);
        let only = if let Under::Soil(number) = under { ground.soil(number) } else { None };
        let mut facet = Facet::at(surface, f, &m.hub);
        let reach = vb_math::hypot(self.radius, self.width);
        let top = surface.ceiling(m.hub.x, m.hub.y, reach).unwrap_or(f64::INFINITY);
        for strip in 0..self.strips {
            let offset = self.offset(strip);
            let origin = m.hub + m.axis * offset;
            let mut touches = false;
            let (raised, plastic) = (&self.raised[strip], &mut self.plastic[strip]);
            let [a, b] = &mut self.shear;
            let (shear_along, shear_across) = (&mut a[strip], &mut b[strip]);
            for k in 0..STATIONS {
                let (x, half) = (self.xs[k], self.half[k]);
                let point = origin + f.along * x - f.up * half;
                // Above what is left of the highest ground nearby.
                if point.z >= top + raised[k] - plastic[k] {
                    shear_along[k] = 0.0;
                    shear_across[k] = 0.0;
                    continue;
                }
                let gap = facet.follow(surface, f, &point) + raised[k] - point.z;
                if gap <= 0.0 {
                    shear_along[k] = 0.0;
                    shear_across[k] = 0.0;
                    continue;
                }
                let sinkage = gap * facet.slope;
                let (soil, share) = match only {
                    Some(soil) => (soil, 1.0),
                    None => match ground.soil_at(point.x, point.y) {
                        Some(soil) => (soil, ground.share(point.x, point.y, BLEND)),
                        None => continue,
                    },
                };
                let before = plastic[k];
                let (stress, yields) = soil.load(soil.modulus(self.breadth), sinkage, &mut plastic[k]);
                if stress <= 0.0 {
                    shear_along[k] = 0.0;
                    shear_across[k] = 0.0;
                    continue;
                }
                // Velocity of the rim, in the wheel's frame.
                let v = velocity
                    + V3::new(
                        -rotation.y * half - rotation.z * offset,
                        rotation.z * x + rotation.x * half,
                        rotation.x * offset - rotation.y * x,
                    );
                // Area of the ground that the station stands for; that of the rim over it is larger where it is steep.
                let area = self.lengths[k] * strip_width * share;
                let (n, t, rim) = if soil.radial {
                    let (sin, cos, sec) = self.rim[k];
                    (V3::new(-sin, 0.0, cos), V3::new(cos, 0.0, sin), area * sec)
                } else {
                    (facet.normal, V3::x(), area)
                };
                let leaving = v.dot(&n);
                let pressure = stress - soil.damping * leaving;
                if pressure <= 0.0 {
                    shear_along[k] = 0.0;
                    shear_across[k] = 0.0;
                    continue;
                }
                touches = true;
                sum.sinkage = sum.sinkage.max(sinkage);
                sum.displaced += (plastic[k] - before) * area;
                sum.span = Some(sum.span.map_or((k, k), |(a, b)| (a.min(k), b.max(k))));
                let slip = [(v - n * leaving).dot(&t), v.y - n.y * leaving];
                let mut shear = [shear_along[k], shear_across[k]];
                let tangential = soil.shear_stress(&mut shear, slip, pressure, dt);
                shear_along[k] = shear[0];
                shear_across[k] = shear[1];
                let push = n * (pressure * rim);
                let mut force = push + t * (tangential[0] * rim);
                force.y += tangential[1] * rim;
                sum.force += force;
                sum.pressure += push;
                sum.moment += V3::new(x, offset, -half).cross(&force);
                let stiffness = if yields { 0.0 } else { soil.elastic };
                let implicit = n * (rim * dt * (soil.damping + dt * stiffness));
                let outer = [
                    implicit.x * n.x,
                    implicit.x * n.y,
                    implicit.x * n.z,
                    implicit.y * n.y,
                    implicit.y * n.z,
                    implicit.z * n.z,
                ];
                for (total, part) in sum.inertia.iter_mut().zip(outer) {
                    *total += part;
                }
            }
            sum.strips += usize::from(touches);
        }
    }

    /// Heaps displaced soil up around the contact: before and behind it within the footprint, beside it on the grid.
    /// Each side gets what its share of the perimeter is, but nothing is heaped on the ground of a rut: the law knows
    /// one surface, so loose soil there would be as hard as the rut's ground.
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
        let strip_width = self.width / self.strips as f64;
        let around = 2.0 * (length + self.width);
        let end = volume * self.width / (around * self.strips as f64);
        let mut side = volume * length / around;
        for (from, step) in [(last, 1isize), (first, -1)] {
            let outside = |k: usize| k.checked_add_signed(step).filter(|k| *k < STATIONS);
            for strip in 0..self.strips {
                let Some(nearest) = outside(from).filter(|k| self.plastic[strip][*k] < LOOSE) else {
                    side += 0.5 * end;
                    continue;
                };
                let row = &mut self.raised[strip];
                row[nearest] += end / (strip_width * self.lengths[nearest]);
                let mut k = nearest;
                while let Some(next) = outside(k) {
                    let spacing = (self.xs[next] - self.xs[k]).abs();
                    let excess = row[k] - row[next] - slope * spacing;
                    if excess <= 0.0 {
                        break;
                    }
                    let (a, b) = (self.lengths[k], self.lengths[next]);
                    let moved = excess * a * b / (a + b);
                    row[k] -= moved / a;
                    row[next] += moved / b;
                    k = next;
                }
            }
        }
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

/// Plastic sinkage beyond which the ground counts as a rut, m.
const LOOSE: f64 = 1e-3;

/// Cells beside the wheel over which a heap may slide, as the original lets it (facts §4.3: 10 propagations).
const RINGS: usize = 10;

/// Width of the strip within soil over which a load is handed over from rigid ground, m.
pub(crate) const BLEND: f64 = 0.1;

#[inline]
fn normal_of([dzdx, dzdy]: [f64; 2]) -> V3 {
    let inv = 1.0 / (1.0 + dzdx * dzdx + dzdy * dzdy).sqrt();
    V3::new(-dzdx * inv, -dzdy * inv, inv)
}

/// The last facet of the ground that a station stood on, since the next mostly stands on it too.
struct Facet {
    plane: vb_world::Facet,
    /// Vertical component of the normal.
    slope: f64,
    /// In the wheel's frame.
    normal: V3,
}

impl Facet {
    fn at(surface: &Heightfield, f: &Frame, point: &V3) -> Self {
        let plane = surface.facet(point.x, point.y);
        let normal = normal_of(plane.gradient());
        Self { plane, slope: normal.z, normal: f.local(&normal) }
    }

    /// Height of the ground at a point, whose facet becomes the current one.
    #[inline]
    fn follow(&mut self, surface: &Heightfield, f: &Frame, point: &V3) -> f64 {
        if let Some(z) = self.plane.height(point.x, point.y) {
            return z;
        }
        *self = Self::at(surface, f, point);
        surface.height(point.x, point.y)
    }
}

/// Moves a row of states backward (`forward`: the wheel moves forward) by a distance of at most one station.
#[inline]
fn advect(row: &mut Row, inflow: f64, forward: bool, distance: f64, inverse_lengths: &Row) {
    if forward {
        for k in 0..STATIONS - 1 {
            row[k] += (row[k + 1] - row[k]) * (distance * inverse_lengths[k]);
        }
        row[STATIONS - 1] +=
            (inflow - row[STATIONS - 1]) * (distance * inverse_lengths[STATIONS - 1]).min(1.0);
    } else {
        for k in (1..STATIONS).rev() {
            row[k] += (row[k - 1] - row[k]) * (distance * inverse_lengths[k]);
        }
        row[0] += (inflow - row[0]) * (distance * inverse_lengths[0]).min(1.0);
    }
}
