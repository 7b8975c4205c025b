//! The wheel is pressed into the soil.

use super::super::ground::{SoilGround, Under};
use super::super::law::Soil;
use super::super::shear::{ShearLaw, with_law};
use super::{FIRST, Footprint, Frame, LANES, Row, Stations, Step};
use crate::{V3, normal_of};
use fearless_simd::{Simd, f64x4, mask64x4, prelude::*};
use vb_world::Heightfield;

/// What one step collects, in the wheel's frame.
#[derive(Default)]
pub(super) struct Sum {
    pub(super) force: V3,
    /// Component of the pressure along the heading.
    pub(super) pressure: f64,
    pub(super) moment: V3,
    /// xx, xy, xz, yy, yz, zz.
    pub(super) inertia: [f64; 6],
    /// Strips in contact.
    pub(super) strips: usize,
    pub(super) displaced: f64,
    /// First and last station in contact.
    pub(super) span: Option<(usize, usize)>,
}

/// A strip's place on the ground.
struct Field<const N: usize> {
    /// Depth of the rim below the raised surface, m; at most the plastic sinkage where the rim is surely above it.
    sinkage: Row<N>,
    /// Normals of the ground in the wheel's frame, where pressure acts along them.
    normal: [Row<N>; 3],
    /// Part of each station's load that the soil carries; negative where there is another soil or none.
    fraction: Row<N>,
}

/// The wheel's motion in its own frame.
struct Body {
    velocity: V3,
    rotation: V3,
    offset: f64,
    belt: f64,
    dt: f64,
    /// Of the area of the footprint, the part that is seen from above.
    seen: f64,
}

impl Body {
    /// The velocity of the rim at four stations `x` ahead of the hub and `half` below it, m/s.
    #[inline(always)]
    fn rim_velocity<S: Simd>(&self, simd: S, x: f64x4<S>, half: f64x4<S>) -> [f64x4<S>; 3] {
        let all = |x: f64| f64x4::splat(simd, x);
        let (velocity, rotation) = (self.velocity, self.rotation);
        [
            all(velocity.x - rotation.z * self.offset) - half * all(rotation.y),
            all(velocity.y) + x * all(rotation.z) + half * all(rotation.x),
            all(velocity.z + rotation.x * self.offset) - x * all(rotation.y),
        ]
    }
}

const NOT_HERE: f64 = -1.0;

impl<const N: usize> Footprint<N> {
    /// Presses all strips into the soil. `returns`: the wheel comes back to soil in which it has been.
    #[inline(always)]
    pub(super) fn press<S: Simd>(
        &mut self,
        simd: S,
        ground: &SoilGround,
        step: &Step<'_>,
        returns: bool,
        sum: &mut Sum,
    ) {
        let Step { surface, under, motion: m, frame: f, dt, .. } = step;
        let mut body = Body {
            velocity: f.local(&m.velocity),
            rotation: f.local(&m.rotation),
            offset: 0.0,
            belt: self.belt,
            dt: *dt,
            seen: f.up.z,
        };
        let only = if let Under::Soil(number) = under { ground.soil(*number) } else { None };
        let mut facet = Facet::of(surface.facet(m.hub.x, m.hub.y), f);
        let top = surface.ceiling(m.hub.x, m.hub.y, self.shape.reach).unwrap_or(f64::INFINITY);
        let mut field = Field { sinkage: [0.0; N], normal: self.shape.level.normal, fraction: [1.0; N] };
        for strip in 0..self.shape.strips {
            body.offset = self.shape.offset(strip);
            let origin = m.hub + m.axis * body.offset;
            if !self.locate(simd, strip, step, &origin, top, &mut facet, &mut field) {
                self.lift_off(strip, &field);
                continue;
            }
            if returns {
                self.displace(strip, &field);
            }
            let before = sum.strips;
            match only {
                Some(soil) => self.press_strip(simd, strip, soil, &field, &body, sum),
                None => {
                    for soil in ground.soils() {
                        let mut here = false;
                        for k in FIRST..=Self::LAST {
                            let at = origin + f.along * self.shape.xs[k] - f.up * self.shape.half[k];
                            let mine = ground.soil_at(at.x, at.y).is_some_and(|s| std::ptr::eq(s, soil));
                            field.fraction[k] =
                                if mine { ground.fraction(at.x, at.y, ground.blend) } else { NOT_HERE };
                            here |= mine;
                        }
                        if here {
                            self.press_strip(simd, strip, soil, &field, &body, sum);
                        }
                    }
                }
            }
            sum.strips = sum.strips.min(before + 1);
        }
    }

    /// Finds out how deep each station of a strip lies below the ground; returns whether one may be in contact.
    #[allow(clippy::too_many_arguments, reason = "strip, ground and what comes of them")]
    #[inline(always)]
    fn locate<S: Simd>(
        &self,
        simd: S,
        strip: usize,
        step: &Step<'_>,
        origin: &V3,
        top: f64,
        facet: &mut Facet,
        field: &mut Field<N>,
    ) -> bool {
        let Step { surface, frame: f, .. } = step;
        let all = |x: f64| f64x4::splat(simd, x);
        let load = |row: &Row<N>, g: usize| f64x4::from_slice(simd, &row[g..g + LANES]);
        let (plastic, shape, zero) = (&self.plastic[strip], &self.shape, all(0.0));
        let mut touches = false;
        for g in (0..N).step_by(LANES) {
            let is_station = load(&shape.lengths, g).simd_gt(zero);
            let (x, half, depth) = (load(&shape.xs, g), load(&shape.half, g), load(plastic, g));
            let raised = load(&self.raised[strip], g);
            let rim = all(origin.z) + all(f.along.z) * x - all(f.up.z) * half;
            // Above what is left of the highest ground nearby.
            let most = all(top) + raised - rim;
            let near = is_station & !most.simd_le(depth);
            let mut sinkage = is_station.select(most, zero);
            if near.any_true() {
                let at = [
                    all(origin.x) + all(f.along.x) * x - all(f.up.x) * half,
                    all(origin.y) + all(f.along.y) * x - all(f.up.y) * half,
                ];
                if let Some(height) = facet.heights(simd, at, near) {
                    let deep = (height + raised - rim) * all(facet.slope);
                    sinkage = near.select(deep, sinkage);
                    for (row, n) in field.normal.iter_mut().zip(facet.normal.iter()) {
                        let normal = near.select(all(*n), load(row, g));
                        store(row, g, normal);
                    }
                } else {
                    // From facet to facet, in the order of the stations.
                    let ([xs, ys], near) = (at, near.to_bitmask());
                    let mut found = *sinkage;
                    for lane in (0..LANES).filter(|lane| near >> lane & 1 == 1) {
                        let height = facet.follow(surface, f, [xs[lane], ys[lane]]);
                        found[lane] = (height + raised[lane] - rim[lane]) * facet.slope;
                        for (row, n) in field.normal.iter_mut().zip(facet.normal.iter()) {
                            row[g + lane] = *n;
                        }
                    }
                    sinkage = found.simd_into(simd);
                }
                touches |= (near & sinkage.simd_gt(depth)).any_true();
            }
            store(&mut field.sinkage, g, sinkage);
        }
        touches
    }

    /// Takes the soil above a strip for displaced already: a wheel that lay flat and comes up on its rim is in the soil as
    /// deep as it lay, without a force so far.
    fn displace(&mut self, strip: usize, field: &Field<N>) {
        for (plastic, sinkage) in self.plastic[strip].iter_mut().zip(&field.sinkage) {
            *plastic = plastic.max(*sinkage);
        }
    }

    /// Nothing of a strip touches the ground.
    fn lift_off(&mut self, strip: usize, field: &Field<N>) {
        self.shear[0][strip] = [0.0; N];
        self.shear[1][strip] = [0.0; N];
        self.pressed[strip] = field.sinkage.map(|s| s.max(0.0));
    }

    /// Presses the stations of a strip that lie on one soil into it.
    #[inline(always)]
    fn press_strip<S: Simd>(
        &mut self,
        simd: S,
        strip: usize,
        soil: &Soil,
        field: &Field<N>,
        body: &Body,
        sum: &mut Sum,
    ) {
        with_law!(&soil.shear, law => self.press_with(simd, strip, soil, law, field, body, sum));
    }

    /// [`Self::press_strip`] for the soil's law of shear.
    #[allow(clippy::too_many_arguments, reason = "strip, soil and what comes of them")]
    #[inline(always)]
    fn press_with<S: Simd>(
        &mut self,
        simd: S,
        strip: usize,
        soil: &Soil,
        shear: &impl ShearLaw,
        field: &Field<N>,
        body: &Body,
        sum: &mut Sum,
    ) {
        let all = |x: f64| f64x4::splat(simd, x);
        let load = |row: &Row<N>, g: usize| f64x4::from_slice(simd, &row[g..g + LANES]);
        let zero = all(0.0);
        let shape = &self.shape;
        // With pressure normal to the ground a station stands for its area as seen from above, as a node of Chrono's grid
        // does (`SCMTerrain.cpp`: force = normal · cell area · pressure), however steep the ground is.
        let (directions, normal, seen) = if soil.radial {
            (&shape.radial, &shape.radial.normal, 1.0)
        } else {
            (&shape.level, &field.normal, body.seen)
        };
        let plastic_row = &mut self.plastic[strip];
        let pressed_row = &mut self.pressed[strip];
        let [a, b] = &mut self.shear;
        let mut shear_rows = [&mut a[strip], &mut b[strip]];
        let modulus = all(soil.modulus(self.breadth));
        let shallower = all(soil.shallower(self.slip));
        let (elastic_stiffness, compliance) = (all(soil.elastic), all(soil.compliance));
        let (damping, dt) = (all(soil.damping), all(body.dt));
        let (width, seen) = (all(shape.strip_width()), all(seen));
        let belt = all(body.belt);
        let mut lanes = Lanes::new(simd);
        let mut bits: u64 = 0;
        for g in (0..N).step_by(LANES) {
            let fraction = load(&field.fraction, g);
            let mine = fraction.simd_ge(zero);
            let sinkage = load(&field.sinkage, g);
            let plastic = load(plastic_row, g);
            let elastic = (sinkage - plastic) * elastic_stiffness;
            let touching = elastic.simd_gt(zero) & mine;
            // The soil between the pads of a belt stays there while the belt is less than its grip above the ground.
            let held =
                if self.grip > 0.0 { (sinkage + all(self.grip)).simd_gt(plastic) & mine } else { touching };
            if !held.any_true() {
                for row in &mut shear_rows {
                    store(row, g, mine.select(zero, load(row, g)));
                }
                let free = sinkage.simd_gt(zero).select(sinkage, zero);
                store(pressed_row, g, mine.select(free, load(pressed_row, g)));
                continue;
            }
            // The pressure is the smaller of the elastic line's and that of fresh soil: where they meet, the soil yields.
            let yielding = soil.curve.at(simd, sinkage * shallower) * modulus;
            let yields = elastic.simd_gt(yielding);
            let stress = yields.select(yielding, elastic);
            let deepest = sinkage - yielding * compliance;
            let deeper = (touching & yields).select(deepest, plastic);
            store(plastic_row, g, deeper);
            let free = sinkage.simd_gt(zero).select(sinkage, zero);
            let pressed = mine.select(touching.select(deepest, free), load(pressed_row, g));
            store(pressed_row, g, pressed);
            let (x, half) = (load(&shape.xs, g), load(&shape.half, g));
            let [vx, vy, mut vz] = body.rim_velocity(simd, x, half);
            if self.grip > 0.0 {
                vz += load(&shape.rates, g);
            }
            let n = [load(&normal[0], g), load(&normal[1], g), load(&normal[2], g)];
            let t = [load(&directions.tangent[0], g), load(&directions.tangent[1], g)];
            let leaving = vx * n[0] + vy * n[1] + vz * n[2];
            let damped = stress - damping * leaving;
            let contact = touching & damped.simd_gt(zero);
            let pressure = contact.select(damped, zero);
            let slip =
                [(vx - n[0] * leaving) * t[0] + (vz - n[2] * leaving) * t[1] - belt, vy - n[1] * leaving];
            let before = [load(shear_rows[0], g), load(shear_rows[1], g)];
            let (after, tangential) = soil.sheared(simd, shear, before, slip, pressure, body.dt);
            for k in 0..2 {
                let state = if self.grip > 0.0 {
                    held.select(after[k], zero)
                } else {
                    contact.select(after[k], zero)
                };
                store(shear_rows[k], g, mine.select(state, before[k]));
            }
            // Ground that a station stands for, and the rim over it, which is larger where it is steep.
            let strip_share = width * contact.select(fraction, zero);
            let area = load(&shape.lengths, g) * strip_share;
            let rim = load(&directions.rim, g) * strip_share * seen;
            let push = pressure * rim;
            let along = tangential[0] * rim;
            let force =
                [push * n[0] + along * t[0], push * n[1] + tangential[1] * rim, push * n[2] + along * t[1]];
            let stiffness = yields.select(zero, elastic_stiffness);
            let implicit = rim * dt * (damping + dt * stiffness);
            lanes.pressure += push * n[0];
            lanes.displaced += (deeper - plastic) * area;
            lanes.add(&force, [x, half], implicit, &n);
            bits |= contact.to_bitmask() << g;
            if let Some(stations) = &mut self.stations {
                let depth = contact.select(sinkage, zero);
                stations.add(simd, g, &force, along, body.offset, implicit, depth);
            }
        }
        if bits != 0 {
            lanes.gather(bits, body.offset, sum);
        }
    }
}

/// Sums over every fourth station.
struct Lanes<S: Simd> {
    force: [f64x4<S>; 3],
    pressure: f64x4<S>,
    moment: [f64x4<S>; 3],
    inertia: [f64x4<S>; 6],
    displaced: f64x4<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = f64x4::splat(simd, 0.0);
        Self { force: [zero; 3], pressure: zero, moment: [zero; 3], inertia: [zero; 6], displaced: zero }
    }

    /// Adds a force on four stations `x` ahead of the hub and `half` below it, and the mass that its implicit treatment
    /// adds along the normal.
    #[inline(always)]
    fn add(
        &mut self,
        force: &[f64x4<S>; 3],
        [x, half]: [f64x4<S>; 2],
        implicit: f64x4<S>,
        n: &[f64x4<S>; 3],
    ) {
        self.moment[0] += half * force[1];
        self.moment[1] -= half * force[0] + x * force[2];
        self.moment[2] += x * force[1];
        for (total, part) in self.force.iter_mut().zip(force) {
            *total += *part;
        }
        let w = [implicit * n[0], implicit * n[1], implicit * n[2]];
        let outer = [w[0] * n[0], w[0] * n[1], w[0] * n[2], w[1] * n[1], w[1] * n[2], w[2] * n[2]];
        for (total, part) in self.inertia.iter_mut().zip(&outer) {
            *total += *part;
        }
    }

    /// Adds the sums of a strip that is `offset` to the left of the middle and has contact at the stations of `bits`.
    #[inline(always)]
    fn gather(&self, bits: u64, offset: f64, sum: &mut Sum) {
        let force = V3::new(total(self.force[0]), total(self.force[1]), total(self.force[2]));
        let [mx, my, mz] = [total(self.moment[0]), total(self.moment[1]), total(self.moment[2])];
        sum.force += force;
        sum.pressure += total(self.pressure);
        sum.moment += V3::new(mx + offset * force.z, my, mz - offset * force.x);
        for (all, part) in sum.inertia.iter_mut().zip(&self.inertia) {
            *all += total(*part);
        }
        sum.displaced += total(self.displaced);
        sum.strips += 1;
        let (first, last) = (bits.trailing_zeros() as usize, bits.ilog2() as usize);
        sum.span = Some(sum.span.map_or((first, last), |(a, b)| (a.min(first), b.max(last))));
    }
}

/// The sum of the lanes, in an order that does not depend on the machine.
#[inline(always)]
pub(super) fn total<S: Simd>(lanes: f64x4<S>) -> f64 {
    let [a, b, c, d] = *lanes;
    (a + b) + (c + d)
}

#[inline(always)]
pub(super) fn store<S: Simd, const N: usize>(row: &mut Row<N>, g: usize, value: f64x4<S>) {
    value.store_slice(&mut row[g..g + LANES]);
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
    #[inline(always)]
    fn of(plane: vb_world::Facet, f: &Frame) -> Self {
        let normal = normal_of(plane.gradient);
        Self { plane, slope: normal.z, normal: f.local(&normal) }
    }

    /// Heights of the ground at four points, if those that are `asked` for all lie on the current facet.
    #[inline(always)]
    fn heights<S: Simd>(&self, simd: S, [x, y]: [f64x4<S>; 2], asked: mask64x4<S>) -> Option<f64x4<S>> {
        let all = |x: f64| f64x4::splat(simd, x);
        let plane = &self.plane;
        let (u, v) = (x - all(plane.corner[0]), y - all(plane.corner[1]));
        let (zero, side) = (all(0.0), all(plane.resolution));
        let half = if plane.upper { v.simd_ge(u) } else { !v.simd_ge(u) };
        let on = u.simd_ge(zero) & v.simd_ge(zero) & u.simd_lt(side) & v.simd_lt(side) & half;
        let all_on = !(asked & !on).any_true();
        all_on.then(|| all(plane.z) + all(plane.gradient[0]) * u + all(plane.gradient[1]) * v)
    }

    /// Height of the ground at a point, whose facet becomes the current one.
    #[inline(always)]
    fn follow(&mut self, surface: &Heightfield, f: &Frame, at: [f64; 2]) -> f64 {
        if let Some(z) = self.plane.height(at[0], at[1]) {
            return z;
        }
        let (plane, height) = surface.facet_and_height(at[0], at[1]);
        *self = Self::of(plane, f);
        height
    }
}

impl<const N: usize> Stations<N> {
    /// Adds what one strip, `offset` to the left of the middle, contributes to the stations from `g` on.
    #[allow(clippy::too_many_arguments, reason = "one of each of the rows")]
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        g: usize,
        force: &[f64x4<S>; 3],
        thrust: f64x4<S>,
        offset: f64,
        inertia: f64x4<S>,
        sinkage: f64x4<S>,
    ) {
        let load = |row: &Row<N>| f64x4::from_slice(simd, &row[g..g + LANES]);
        let aside = f64x4::splat(simd, offset);
        for (row, part) in self.force.iter_mut().zip(force) {
            let sum = load(row) + *part;
            store(row, g, sum);
        }
        let [about_heading, about_up] = &mut self.moment;
        for (row, part) in [
            (&mut self.thrust, thrust),
            (about_heading, aside * force[2]),
            (about_up, f64x4::splat(simd, 0.0) - aside * force[0]),
            (&mut self.inertia, inertia),
        ] {
            let sum = load(row) + part;
            store(row, g, sum);
        }
        let deepest = load(&self.sinkage);
        store(&mut self.sinkage, g, sinkage.simd_gt(deepest).select(sinkage, deepest));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn four_points_have_the_heights_of_each_if_all_that_are_asked_for_lie_on_the_facet() {
        let mut stream = vb_math::rng::Stream::new(4, &["facet"]);
        let heights = (0..81).map(|_| stream.normal(0.0, 0.2)).collect();
        let surface = Heightfield::new(9, 9, 1.0, heights);
        let frame = Frame { along: V3::x(), axis: V3::y(), up: V3::z() };
        let mut found = [0, 0];
        for k in 0..4000 {
            // The north-western and the south-eastern half of a cell.
            let middle = if k % 2 == 0 { [0.3, 0.7] } else { [0.7, 0.3] };
            let facet = Facet::of(surface.facet(middle[0], middle[1]), &frame);
            let mut around = |c: f64| [0; 4].map(|_| c + stream.normal(0.0, 0.3));
            let (x, y) = (around(middle[0]), around(middle[1]));
            let asked = [0; 4].map(|_| stream.normal(0.0, 1.0));
            let together = dispatch!(Level::new(), simd => {
                let lanes = |v: [f64; 4]| v.simd_into(simd);
                let asked = f64x4::simd_from(simd, asked).simd_gt(f64x4::splat(simd, 0.0));
                facet.heights(simd, [lanes(x), lanes(y)], asked).map(|z| *z)
            });
            let asked = (0..LANES).filter(|i| asked[*i] > 0.0);
            let alone: Vec<_> = asked.map(|i| (i, facet.plane.height(x[i], y[i]))).collect();
            let all_on = alone.iter().all(|(_, z)| z.is_some());
            assert_eq!(together.is_some(), all_on, "{alone:?}");
            for (i, z) in alone.iter().filter(|_| all_on) {
                assert_eq!(z.map(f64::to_bits), together.map(|all| all[*i].to_bits()));
            }
            found[usize::from(all_on)] += usize::from(!alone.is_empty());
        }
        assert!(found.iter().all(|n| *n > 500), "{found:?}");
    }
}
