//! Where a wheel meets the ground.

use super::Contact;
use crate::V3;
use vb_world::{Heightfield, Nearby};

/// Square of the sine of the angle between a wheel's plane and the ground below which the wheel counts as one that lies
/// down, 55° from upright. The ground hardly meets its radius any more, so its deflection is taken along the ground's
/// normal from there on, with the stiffness that it has got by then.
const LEANING: f64 = 1.0 / 3.0;
/// The same where the slope from strip to strip, which are over the same ground by then, says nothing any more, 63° from
/// upright.
const LYING: f64 = 0.2;
/// Vertical part of the direction up in a wheel's plane below which heights don't tell how deep a wheel is in a wall; they
/// are believed again at twice that.
const WALL: f64 = 0.05;
/// Sine of the angle between a wheel's plane and the ground below which it has no lowest point.
const FLAT: f64 = 1e-6;
/// Stations on each side of the lowest one.
const SIDE: usize = 7;
const STATIONS: usize = 2 * SIDE + 1;
/// Spacing of the innermost stations over that of evenly spaced ones: a hard tyre's footprint is as short as 10 cm.
const DENSITY: f64 = 0.3;
/// Farthest station over the radius.
const REACH: f64 = 0.97;

/// The enveloping contact of a tyre with a heightfield.
///
/// The disc is sampled at stations along two strips, dense at the bottom. The overlap of disc and ground gives an area,
/// which the segment of a disc on flat ground relates to a radial deflection. The tyre presses back from the overlap's
/// centroid towards the hub, on a plane along its normal; the ground's slope from strip to strip inclines that sideways.
/// So an edge, a kerb and a ridge narrower than the wheel are felt, and since only heights enter, which are continuous,
/// force and normal change continuously over the edges of facets. (The envelope method of Chrono's
/// `DiscTerrainCollisionEnvelope`, after Sui and Hirshey 2001, with few stations, both strips and the centroid.)
///
/// The strips are a radius of gyration of the tyre's width from its middle, and a tilt against the ground moves the
/// point of contact by width²/12 · tilt/deflection, so that a linear spring has the overturning moment of a tyre whose
/// width presses evenly (Rill, Road Vehicle Dynamics, 2012, ch. 3: −w²/12 · stiffness · inclination).
///
/// A wheel that leans by more than 55° is on its way to lie on its flank. It is held by its rim all the way, with a force
/// that depends on how deep it is along the ground's normal and not on the way it came: a wheel that was let into the ground
/// without force as it lay would throw the vehicle up as it rolls back.
#[derive(Clone, Debug)]
pub struct Envelope {
    radius: f64,
    /// Distance of a strip from the mid-plane.
    strip: f64,
    xs: [f64; STATIONS],
    /// Half the chord at each station.
    half: [f64; STATIONS],
    /// Length of the radius that a station stands for.
    fraction: [f64; STATIONS],
    /// (area, deflection) on flat ground, between which the relation is linear for this very sampling.
    knots: [(f64, f64); 2 * SIDE + 2],
}

/// How far a wheel's stations have yet to move before they can touch, from step to step: most of them are well above the
/// ground, and heights of the ground are what an [`Envelope`] costs.
///
/// A height over ground changes by no more than the sum over the axes of how far a point has moved along each, times the
/// steepest slope nearby (1 for the height itself). As long as that is less than it was, nothing touches.
#[derive(Clone, Debug)]
pub(crate) struct Clearance {
    /// Hub and directions (along, up, axle) when it was last asked for.
    pose: [V3; 4],
    /// Where slopes were looked at, and the slopes; none where nothing is known.
    around: Option<([f64; 2], V3)>,
    /// Bound of what heights over ground have lost so far, m.
    spent: f64,
    /// What is spent when a station may touch, m.
    due: [f64; STATIONS],
}

/// Some of the stations, a bit each.
#[derive(Clone, Copy, Default)]
struct Stations(u32);

impl Stations {
    /// Their numbers, ascending.
    #[inline]
    fn iter(self) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(self.0), |left| Some(left & left.wrapping_sub(1)))
            .take_while(|left| *left != 0)
            .map(|left| left.trailing_zeros() as usize)
    }
}

/// Sums over the stations of both strips where they overlap the ground.
#[derive(Default)]
struct Overlap {
    /// Of both strips, m².
    area: f64,
    /// Its first moments ahead of the hub and below it, m³.
    ahead: f64,
    below: f64,
    /// Its moment of how much higher the ground is over the rim of the left strip than over that of the right, m³.
    across: f64,
}

/// What is taken off every clearance for rounding, m: far more than heights and coordinates have of it.
const ROUNDING: f64 = 1e-9;

impl Default for Clearance {
    fn default() -> Self {
        Self { pose: [V3::zeros(); 4], around: None, spent: 0.0, due: [0.0; STATIONS] }
    }
}

impl Clearance {
    /// Takes note of where the wheel has come to.
    #[inline]
    fn move_to(&mut self, ground: &Heightfield, wheel: &Envelope, pose: [V3; 4]) {
        let before = std::mem::replace(&mut self.pose, pose);
        let hub = &pose[0];
        let room = wheel.radius;
        let near = |c: &[f64; 2], p: &V3| (p.x - c[0]).abs() <= room && (p.y - c[1]).abs() <= room;
        match self.around {
            Some((centre, _)) if near(&centre, hub) => {}
            _ => {
                let centre = [hub.x, hub.y];
                let reach = room + wheel.radius + wheel.strip + ROUNDING;
                let slopes = ground.steepest(hub.x, hub.y, reach).map(|[x, y]| V3::new(x, y, 1.0));
                // The way here must lie where the slopes are known.
                if self.around.is_none() || !near(&centre, &before[0]) {
                    self.due = [f64::NEG_INFINITY; STATIONS];
                }
                self.around = slopes.map(|slopes| (centre, slopes));
            }
        }
        let Some((_, slopes)) = &self.around else {
            self.due = [f64::NEG_INFINITY; STATIONS];
            return;
        };
        let [hub, along, up, axis] = std::array::from_fn(|k| (pose[k] - before[k]).abs());
        let moved = hub + axis * wheel.strip + (along + up) * wheel.radius;
        self.spent += moved.dot(slopes) + ROUNDING;
    }

    #[inline]
    fn may_touch(&self) -> Stations {
        let bit = |k: usize| u32::from(!self.is_clear(k)) << k;
        Stations((0..STATIONS).map(bit).sum())
    }

    #[inline]
    fn is_clear(&self, station: usize) -> bool {
        self.spent < self.due[station]
    }

    /// A station is `height` (m) above the ground.
    #[inline]
    fn note(&mut self, station: usize, height: f64) {
        self.due[station] = self.spent + height - ROUNDING;
    }
}

impl Envelope {
    /// The contact of a tyre of this radius and width, m.
    #[must_use]
    pub fn new(radius: f64, width: f64) -> Self {
        let r = radius;
        let at = |k: f64| {
            let t = k / SIDE as f64;
            r * REACH * t * (DENSITY + (1.0 - DENSITY) * t.abs())
        };
        let xs: [f64; STATIONS] = std::array::from_fn(|k| at(k as f64 - SIDE as f64));
        let half = xs.map(|x| (r * r - x * x).max(0.0).sqrt());
        let edge = |k: usize| match k {
            0 => -r,
            STATIONS => r,
            _ => 0.5 * (xs[k - 1] + xs[k]),
        };
        let fraction: [f64; STATIONS] = std::array::from_fn(|k| edge(k + 1) - edge(k));
        let area = |depth: f64| -> f64 {
            half.iter().zip(&fraction).map(|(h, w)| vb_math::clamp(h - (r - depth), 0.0, 2.0 * h) * w).sum()
        };
        let knots = std::array::from_fn(|k| {
            // Stations come in pairs around the middle one, which is touched first and wholly overlapped last.
            let depth = if k <= SIDE { r - half[SIDE - k] } else { r + half[k - SIDE - 1] };
            (area(depth), depth)
        });
        Self { radius, strip: width / 12.0_f64.sqrt(), xs, half, fraction, knots }
    }

    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// Half of the tyre's width, m.
    pub(crate) fn half_width(&self) -> f64 {
        self.strip * 3.0_f64.sqrt()
    }

    /// The contact of a wheel with its centre at `hub` (m, world frame) and the axle direction `axis` (a unit vector to
    /// the left); `None` if it doesn't touch.
    #[must_use]
    pub fn query(&self, ground: &Heightfield, hub: &V3, axis: &V3) -> Option<Contact> {
        self.query_where(ground, hub, axis, &mut Clearance::default(), |_, _| 1.0)
    }

    /// As [`Self::query`] for a wheel that is asked for again and again over the same ground, and where only a share of
    /// the ground, between 0 and 1, carries at each (x, y). What `clearance` remembers saves work and changes nothing.
    #[inline]
    pub(crate) fn query_where(
        &self,
        ground: &Heightfield,
        hub: &V3,
        axis: &V3,
        clearance: &mut Clearance,
        carries: impl Fn(f64, f64) -> f64,
    ) -> Option<Contact> {
        let heading = V3::new(axis.y, -axis.x, 0.0).try_normalize(FLAT).unwrap_or_else(V3::x);
        let left = V3::new(-heading.y, heading.x, 0.0);
        // One for each side, so that a wheel astride an edge of cells doesn't change to and fro.
        let mut nearby = [Nearby::new(ground), Nearby::new(ground)];
        let mut rise = |to: &V3, reach: f64| {
            (nearby[1].height(hub.x + reach * to.x, hub.y + reach * to.y)
                - nearby[0].height(hub.x - reach * to.x, hub.y - reach * to.y))
                / (2.0 * reach)
        };
        let slope = V3::z() - heading * rise(&heading, 0.5 * self.radius) - left * rise(&left, self.strip);
        let across = axis.cross(&slope);
        // Flat on the ground it has no lowest point; any will do.
        let along = across.try_normalize(FLAT).unwrap_or_else(|| axis.cross(&V3::x()).normalize());
        let up = along.cross(axis);
        let level = across.norm_squared() / slope.norm_squared();
        let stands = ((level - LYING) / (LEANING - LYING)).min(up.z / WALL - 1.0).clamp(0.0, 1.0);
        clearance.move_to(ground, self, [*hub, along, up, *axis]);
        // How far the ground is above the rim; left at nothing where both strips are surely clear of it.
        let mut above = [[0.0; STATIONS]; 2];
        let mut fractions = [[0.0; STATIONS]; 2];
        let origins = [-self.strip, self.strip].map(|offset| hub + axis * offset);
        let mut touching = Stations::default();
        for k in clearance.may_touch().iter() {
            let (x, half) = (self.xs[k], self.half[k]);
            let mut highest = f64::NEG_INFINITY;
            for (s, origin) in origins.iter().enumerate() {
                let px = origin.x + along.x * x - up.x * half;
                let py = origin.y + along.y * x - up.y * half;
                let dz = nearby[s].height(px, py) - (origin.z + along.z * x - up.z * half);
                above[s][k] = dz;
                fractions[s][k] = if dz > 0.0 { carries(px, py) } else { 0.0 };
                highest = highest.max(dz);
            }
            clearance.note(k, -highest);
            touching.0 |= u32::from(highest > 0.0) << k;
        }
        let overlap = |gain: f64, short: f64| self.overlap(touching, &above, &fractions, gain, short);
        let strips = (stands > 0.0).then(|| overlap(up.z, 0.0)).filter(|o| o.area > 0.0).map(|o| {
            // The ground's slope from strip to strip in the wheel's frame.
            let across = o.across / o.area;
            let sideways = across * up.z / (2.0 * self.strip + across * axis.z).max(0.4 * self.strip);
            // Overlaps were measured from the rim upwards to where the ground is above it, not to the inclined ground.
            let incline = (1.0 - sideways * axis.z / up.z).clamp(0.3, 3.0);
            (o, sideways, incline)
        });
        let from_hub = |below: f64, ahead: f64| (up * below - along * ahead).try_normalize(1e-12);
        let reach = self.strip;
        if stands >= 1.0 {
            let (o, sideways, incline) = strips?;
            let depth = self.deflection(0.5 * o.area * incline);
            let radial = from_hub(o.below, o.ahead)?;
            let normal = (radial - axis * sideways).normalize();
            let offset = vb_math::clamp(reach * reach * sideways / depth.max(1e-6), -reach, reach);
            let point = hub - radial * (self.radius - depth) + axis * offset;
            return Some(Contact { point, normal, depth });
        }
        // Over a wheel that lies, the ground's own slope is the one that counts; in between, something of both.
        let (slope, level) = (slope.normalize(), level.sqrt());
        let stiffer = (1.0 / level).min(1.0 / LEANING.sqrt());
        let lies = overlap(stiffer * slope.z, (1.0 - stiffer * level).max(0.0));
        let (mut area, mut below, mut ahead, mut normal) = (lies.area, lies.below, lies.ahead, slope);
        if let Some((o, sideways, incline)) = strips {
            let mix = |lying: f64, standing: f64| lying + stands * (standing - lying);
            area = mix(area, o.area * incline);
            (below, ahead) = (mix(below, o.below * incline), mix(ahead, o.ahead * incline));
            let standing = (from_hub(o.below, o.ahead)? - axis * sideways).normalize();
            normal = slope.lerp(&standing, stands).normalize();
        }
        if area <= 0.0 {
            return None;
        }
        let depth = self.deflection(0.5 * area);
        let radial = from_hub(below, ahead)?;
        let sideways = -normal.dot(axis) / normal.dot(&radial).max(FLAT);
        let offset = vb_math::clamp(reach * reach * sideways / depth.max(1e-6), -reach, reach);
        let point = hub - radial * (self.radius - depth * (level * stiffer)) + axis * offset;
        Some(Contact { point, normal, depth })
    }

    /// The overlap of ground that is `above` the rim (m) at each of the `touching` stations of each strip, and of which a
    /// share carries; elsewhere it is below both. A height above the rim is `gain` times as long along the radius, less
    /// `short` times how much higher the rim is there than at its lowest point.
    #[inline]
    fn overlap(
        &self,
        touching: Stations,
        above: &[[f64; STATIONS]; 2],
        fractions: &[[f64; STATIONS]; 2],
        gain: f64,
        short: f64,
    ) -> Overlap {
        let mut sum = Overlap::default();
        for (row, fraction) in above.iter().zip(fractions) {
            for k in touching.iter() {
                let overlap = (row[k] * gain - short * (self.radius - self.half[k])).min(2.0 * self.half[k]);
                if overlap > 0.0 {
                    let part = overlap * self.fraction[k] * fraction[k];
                    sum.area += part;
                    sum.ahead += part * self.xs[k];
                    sum.below += part * (self.half[k] - 0.5 * overlap);
                    sum.across += part * (above[1][k] - above[0][k]);
                }
            }
        }
        sum
    }

    /// Radial deflection (m) on flat ground of a disc that overlaps it by an area, m².
    #[inline]
    fn deflection(&self, area: f64) -> f64 {
        let k = self.knots.iter().position(|&(a, _)| area < a).unwrap_or(self.knots.len() - 1).max(1);
        let ((a0, d0), (a1, d1)) = (self.knots[k - 1], self.knots[k]);
        d0 + (d1 - d0) * ((area - a0) / (a1 - a0)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.467;

    fn envelope() -> Envelope {
        Envelope::new(RADIUS, 0.254)
    }

    #[test]
    fn on_a_plane_the_envelope_finds_the_radial_deflection_and_the_normal() {
        let e = envelope();
        // A 30 % grade along x, the wheel heading up it with its axle level.
        let ground = Heightfield::new(9, 9, 1.0, (0..81).map(|i| 0.3 * f64::from(i % 9)).collect());
        let n = V3::new(-0.3, 0.0, 1.0).normalize();
        for depth in [0.002, 0.005, 0.02, 0.08, 0.2] {
            let on_plane = V3::new(0.2, 0.1, ground.height(0.2, 0.1));
            let hub = on_plane + n * (RADIUS - depth);
            let c = e.query(&ground, &hub, &V3::y()).unwrap();
            assert!((c.normal - n).norm() < 1e-12);
            assert!((c.depth - depth).abs() < 1e-9, "{} {depth}", c.depth);
            assert!((c.point - on_plane).norm() < 1e-9, "{} {on_plane}", c.point);
        }
        assert!(e.query(&ground, &V3::new(0.2, 0.1, 3.0), &V3::y()).is_none());
    }

    #[test]
    fn on_a_side_slope_a_tilted_wheel_finds_the_plane_and_stands_on_its_lower_side() {
        let e = envelope();
        let slope = |x: f64, y: f64| 0.2 * x - 0.15 * y;
        let ground =
            Heightfield::new(9, 9, 1.0, (0..81).map(|i| slope(f64::from(i % 9), f64::from(i / 9))).collect());
        let n = V3::new(-0.2, 0.15, 1.0).normalize();
        let along = V3::y().cross(&n).normalize();
        let left = n.cross(&along);
        let foot = V3::new(0.3, -0.2, ground.height(0.3, -0.2));
        for tilt in [-0.02, 0.02_f64] {
            let (s, c) = vb_math::sin_cos(tilt);
            let (axis, up) = (left * c + n * s, n * c - left * s);
            let hub = foot + up * (RADIUS - 0.02);
            let contact = e.query(&ground, &hub, &axis).unwrap();
            assert!((contact.normal - n).norm() < 1e-9, "{}", contact.normal);
            assert!((contact.depth - 0.02).abs() < 3e-4, "{}", contact.depth);
            // w²/12 tilt/deflection, towards the side that dips (Rill).
            let offset = (contact.point - hub).dot(&axis);
            let expected = -0.254 * 0.254 / 12.0 * tilt / 0.02;
            assert!((offset - expected).abs() < 0.03 * expected.abs(), "{offset} {expected}");
        }
    }

    /// On ground with a slope along both axes: contacts of a wheel that leans in the plane across its heading, from upright
    /// over flat on its flank to upside down, with its hub `height` (m) above the ground along its normal.
    fn leaning(height: f64, steps: u32) -> (V3, Vec<(f64, V3, Option<Contact>)>) {
        let e = envelope();
        let slope = |x: f64, y: f64| 0.2 * x - 0.3 * y;
        let ground =
            Heightfield::new(9, 9, 1.0, (0..81).map(|i| slope(f64::from(i % 9), f64::from(i / 9))).collect());
        let n = V3::new(-0.2, 0.3, 1.0).normalize();
        let along = V3::y().cross(&n).normalize();
        let left = n.cross(&along);
        let hub = V3::new(0.3, -0.2, ground.height(0.3, -0.2)) + n * height;
        let contacts = (0..=steps).map(|k| {
            let lean = std::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(steps + 1);
            let (s, c) = vb_math::sin_cos(lean);
            let axis = left * c - n * s;
            (lean, hub, e.query(&ground, &hub, &axis))
        });
        (n, contacts.collect())
    }

    #[test]
    fn a_wheel_that_lies_down_is_held_all_the_way_along_the_ground_s_normal() {
        let strip = 0.254 / 12.0_f64.sqrt();
        for height in [0.05, 0.2, 0.35] {
            let (n, contacts) = leaning(height, 4000);
            for (lean, hub, contact) in &contacts {
                // How deep the lower strip's rim is, by geometry.
                let (s, c) = vb_math::sin_cos(*lean);
                let deep = RADIUS * c.abs() + strip * s - height;
                if deep < 1e-3 {
                    continue;
                }
                let contact =
                    contact.unwrap_or_else(|| panic!("nothing holds it at {lean} rad, {deep} m deep"));
                if c * c < LYING {
                    assert!((contact.normal - n).norm() < 1e-9, "{lean}: {}", contact.normal);
                    // Both strips' mean, of which the lower one is at least half, at √3 times the stiffness.
                    let most = 3.0_f64.sqrt() * deep;
                    assert!(
                        (0.45 * most..=1.05 * most).contains(&contact.depth),
                        "{lean}: {} {most}",
                        contact.depth
                    );
                    // On the side that is lower, within the tyre.
                    let arm = contact.point - hub;
                    assert!(arm.dot(&n) < 0.0 && arm.norm() < RADIUS + strip, "{lean}: {arm}");
                }
            }
        }
    }

    #[test]
    fn as_a_wheel_lies_down_its_contact_does_not_jump() {
        let (_, contacts) = leaning(0.2, 4000);
        for pair in contacts.windows(2) {
            let [(lean, _, before), (_, _, after)] = pair else { unreachable!() };
            let (Some(before), Some(after)) = (before, after) else { continue };
            // Flat on its flank its lowest point changes sides.
            if (lean - std::f64::consts::FRAC_PI_2).abs() < 2e-3 {
                continue;
            }
            // 0.8 mrad on, over which the rim moves by 0.4 mm.
            assert!((after.depth - before.depth).abs() < 2e-3, "{lean}: {} {}", before.depth, after.depth);
            assert!((after.normal - before.normal).norm() < 5e-3, "{lean}: {}", after.normal);
            assert!((after.point - before.point).norm() < 5e-3, "{lean}: {}", after.point - before.point);
        }
    }

    #[test]
    fn a_step_narrower_than_the_wheel_is_felt_before_the_hub_is_over_it() {
        let e = envelope();
        // A ridge 0.3 m high at x = 0 between flat ground, resolution 0.1 m.
        let (rows, cols) = (41, 81);
        let h = (0..rows * cols).map(|i| if i % cols == 40 { 0.3 } else { 0.0 }).collect();
        let ground = Heightfield::new(rows, cols, 0.1, h);
        let hub = V3::new(-0.35, 0.0, RADIUS - 0.01);
        let c = e.query(&ground, &hub, &V3::y()).unwrap();
        assert!(c.normal.x < -0.1, "the ridge pushes the wheel back: {}", c.normal);
        assert!(c.depth > 0.011);
    }

    #[test]
    fn what_a_wheel_remembers_of_its_clearance_changes_no_contact() {
        let e = envelope();
        let n = 41;
        let mut stream = vb_math::rng::Stream::new(5, &["clearance"]);
        let heights = (0..n * n).map(|_| stream.normal(0.0, 0.15)).collect();
        let ground = Heightfield::new(n, n, 0.5, heights);
        let mut clearance = Clearance::default();
        let (mut touched, mut saved) = (0, 0);
        // It hops over rough ground, beyond the edge and back, turns, tilts, and is set down elsewhere at times.
        for k in 0..40_000 {
            let t = 1e-3 * f64::from(k % 16_000);
            let place = if k < 16_000 { 0.0 } else { 1.7 };
            let (x, y) = (11.0 * vb_math::sin(0.4 * t), 8.0 * vb_math::sin(0.31 * t + place));
            let (yaw, tilt) = (0.8 * t, 0.3 * vb_math::sin(3.0 * t));
            let (s, c) = vb_math::sin_cos(tilt);
            let axis = V3::new(-vb_math::sin(yaw) * c, vb_math::cos(yaw) * c, s);
            let hub = V3::new(x, y, ground.height(x, y) + RADIUS + 0.12 * vb_math::sin(9.0 * t));
            let found = e.query_where(&ground, &hub, &axis, &mut clearance, |_, _| 1.0);
            assert_eq!(found, e.query(&ground, &hub, &axis), "step {k}");
            touched += u32::from(found.is_some());
            saved += (0..STATIONS).filter(|s| clearance.is_clear(*s)).count();
        }
        assert!((10_000..35_000).contains(&touched), "{touched}");
        assert!(saved > 200_000, "a third of all stations was not looked at: {saved}");
    }

    /// The contact over `x` for a hub so high that the wheel is `depth` deep.
    fn at_depth(e: &Envelope, ground: &Heightfield, x: f64, depth: f64) -> Contact {
        let (mut low, mut high) = (-1.0, 2.0);
        for _ in 0..50 {
            let z = 0.5 * (low + high);
            let c = e.query(ground, &V3::new(x, 0.0, z), &V3::y());
            if c.is_some_and(|c| c.depth > depth) { low = z } else { high = z }
        }
        e.query(ground, &V3::new(x, 0.0, low), &V3::y()).unwrap()
    }

    #[test]
    fn over_the_edge_of_a_facet_the_normal_turns_smoothly() {
        let e = envelope();
        let turn = 2.0 * vb_math::atan(0.15);
        // A crest and a valley between 1 m facets of ±15 %, at the static deflections of a hard and of a soft tyre.
        for (crest, depth) in [(1.0, 0.0024), (1.0, 0.015), (-1.0, 0.0024), (-1.0, 0.015)] {
            let height = |i: i32| -crest * 0.15 * f64::from((i % 9 - 4).abs());
            let ground = Heightfield::new(9, 9, 1.0, (0..81).map(height).collect());
            // A footprint is 2 √(2 r d) long, 95 and 240 mm; in the valley both facets bear only within ±d/tan of half
            // the turn, 32 and 200 mm. The share of the turn that falls to a millimetre is at most 2.5 times the mean.
            let mut length = 2.0 * (2.0 * RADIUS * depth).sqrt();
            if crest < 0.0 {
                length = length.min(2.0 * depth / 0.15);
            }
            let even = turn / (length * 1e3);
            let mut before = at_depth(&e, &ground, -0.3, depth);
            let first = before.normal;
            for k in -299..=300 {
                let c = at_depth(&e, &ground, 1e-3 * f64::from(k), depth);
                let turned = (c.normal - before.normal).norm();
                assert!(turned < 2.5 * even, "{crest} {depth}: {turned} at {k} mm, {even} on average");
                assert!((c.point - before.point).norm() < 0.02, "{crest} {depth}: a jump at {k} mm");
                before = c;
            }
            assert!((vb_math::acos(first.dot(&before.normal)) - turn).abs() < 1e-6, "it turns all the way");
        }
    }
}
