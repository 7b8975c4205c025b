//! Contact of a wheel with the terrain.
//!
//! Stations along the circumference of the wheel's disc measure its overlap area with the terrain. The area gives the
//! tyre deflection, as the same area would on flat terrain; its centroid gives the direction, and the terrain's slope
//! along the axle inclines the force. The tyre thus envelops edges, kerbs and ridges narrower than the wheel (Sui and
//! Hirshey, "A new analytical tire model for vehicle dynamic analysis", 2001).

use wide::f32x8;

use super::Twin;
use super::vector::{V3, all};

/// Stations on each side of the lowest station, and their offsets, in radii.
const SIDE: usize = 3;
const AHEAD: [f32; SIDE] = [0.15, 0.4, 0.8];
const STATIONS: usize = 2 * SIDE + 1;
/// Bounds of the factor by which terrain inclination changes an overlap that is measured vertically.
const INCLINE: [f32; 2] = [0.3, 3.0];
/// Minimum vertical component of a force that is inclined along the axle.
const STEEPEST: f32 = 0.2;

/// A station on the circumference, in radii.
#[derive(Clone, Copy, Debug)]
struct Station {
    /// Offset ahead of the centre and below it.
    ahead: f32,
    below: f32,
    /// Width of the strip of the disc that it represents, in radii.
    part: f32,
}

/// A linear segment of deflection over area: the deflection at an area, and its `slope`.
#[derive(Clone, Copy, Debug)]
struct Piece {
    area: f32,
    deflection: f32,
    slope: f32,
}

/// The circumference of a wheel with radius 1.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    stations: [Station; STATIONS],
    /// Deflection over area on flat terrain. It is concave: the minimum of all segments applies.
    pieces: [Piece; SIDE + 1],
}

impl Outline {
    pub(super) fn new() -> Self {
        let ahead = |k: usize| match k.cmp(&SIDE) {
            std::cmp::Ordering::Less => -AHEAD[SIDE - 1 - k],
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Greater => AHEAD[k - SIDE - 1],
        };
        let edge = |k: usize| match k {
            0 => -1.0,
            STATIONS => 1.0,
            _ => 0.5 * (ahead(k - 1) + ahead(k)),
        };
        let stations: [Station; STATIONS] = std::array::from_fn(|k| Station {
            ahead: ahead(k),
            below: (1.0 - ahead(k) * ahead(k)).sqrt(),
            part: edge(k + 1) - edge(k),
        });
        let area = |deflection: f32| -> f32 {
            stations.iter().map(|s| (s.below - 1.0 + deflection).max(0.0) * s.part).sum()
        };
        // Stations come in pairs around the lowest station, which makes contact first.
        let touched = |pair: usize| if pair > SIDE { 1.0 } else { 1.0 - stations[SIDE - pair].below };
        let pieces = std::array::from_fn(|pair| {
            let [from, to] = [touched(pair), touched(pair + 1)];
            Piece { area: area(from), deflection: from, slope: (to - from) / (area(to) - area(from)) }
        });
        Self { stations, pieces }
    }

    /// The deflection on flat terrain at an overlap area.
    fn deflection(&self, area: f32x8) -> f32x8 {
        let on = |p: &Piece| all(p.deflection) + (area - all(p.area)) * all(p.slope);
        self.pieces.iter().map(on).fold(all(f32::INFINITY), f32x8::min)
    }
}

/// Contact state of a wheel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Tyre deflection, m; negative without contact.
    pub(super) depth: f32x8,
    /// Sine of the angle by which the contact is ahead of the lowest point.
    pub(super) ahead: f32x8,
    /// Slope of the terrain along the axle, positive rising to the left, in the wheel's axes.
    pub(super) aside: f32x8,
}

/// Unit vectors at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// From the contact to the hub.
    pub(super) radial: V3,
    /// Out of the ground.
    pub(super) normal: V3,
    /// The rolling direction of the tread, and the direction to its left on the terrain.
    pub(super) along: V3,
    pub(super) across: V3,
    /// The cosine of the angle between the wheel's up and the radial direction.
    pub(super) cosine: f32x8,
}

impl Frame {
    /// The directions at a contact of a wheel with these forward, up and left axes.
    pub(super) fn new(contact: &Contact, [ahead, up, axle]: [V3; 3]) -> Self {
        let Contact { ahead: sine, aside, .. } = *contact;
        let one = all(1.0);
        let cosine = (one - sine * sine).max(all(0.0)).sqrt();
        let radial = up * cosine + ahead * -sine;
        let unit = one / (one + aside * aside).sqrt();
        Self {
            radial,
            normal: (radial + axle * -aside) * unit,
            along: ahead * cosine + up * sine,
            across: (axle + radial * aside) * unit,
            cosine,
        }
    }
}

impl Twin {
    /// The contact of a wheel at this sinkage (m), from its centre and its forward, up and left axes.
    pub(super) fn meet(&self, hub: V3, [ahead, up, axle]: [V3; 3], sunk: f32x8) -> Contact {
        let (radius, outline) = (all(self.shape.radius), &self.shape.outline);
        let none = all(0.0);
        let upright = up.z.max(none);
        let (mut area, mut before, mut below, mut rise) = (none, none, none, none);
        let mut nearest = all(f32::NEG_INFINITY);
        for s in &outline.stations {
            let rim = hub + ahead * (all(s.ahead) * radius) + up * (all(-s.below) * radius);
            let [z, east, north] = self.ground.surface(rim.x, rim.y);
            let over = z - sunk - rim.z;
            nearest = nearest.max(over);
            let overlap = (over.max(none) * upright / radius).min(all(2.0 * s.below));
            let part = overlap * all(s.part);
            area += part;
            before += part * all(s.ahead);
            below += part * (all(s.below) - overlap * all(0.5));
            rise += part * (east * axle.x + north * axle.y - axle.z);
        }
        let rise = rise / area.max(all(1e-9));
        let aside = rise * up.z / (all(1.0) + rise * axle.z).max(all(STEEPEST));
        // Overlaps are measured vertically, and not normal to inclined terrain.
        let incline = all(1.0) - aside * axle.z / up.z.max(all(0.05));
        let deflection = outline.deflection(area * incline.max(all(INCLINE[0])).min(all(INCLINE[1])));
        let length = (before * before + below * below).sqrt().max(all(1e-9));
        let touches = area.simd_gt(none);
        Contact {
            depth: touches.select(deflection.max(none) * radius, nearest * upright),
            ahead: before / length,
            aside,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::tests::{GRAVEL, twin};

    /// On a plane the terrain presses along its normal; the deflection is the depth of the lowest point, measured along
    /// its radius.
    #[test]
    fn a_plane_presses_along_its_normal() {
        for [east, north] in [[0.0_f64, 0.0], [0.3, 0.0], [-0.2, 0.0], [0.0, 0.25], [0.0, -0.4], [0.2, 0.3]] {
            let twin = twin(GRAVEL, |x, y| east * x + north * y);
            let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]].map(V3::all);
            let unit = 1.0 / (1.0 + east * east + north * north).sqrt();
            // The disc would be 3 cm deep in a plane that rises only ahead.
            let ahead = (1.0 + east * east).sqrt();
            let hub = V3::all([0.0, 0.0, ((0.467 - 0.03) * ahead) as f32]);
            let contact = twin.meet(hub, axes, all(0.0));
            let normal = Frame::new(&contact, axes).normal;
            let along = V3::all([-east * unit, -north * unit, unit].map(|c| c as f32)).dot(normal);
            // Within 6 degrees.
            assert!(along.to_array()[0] > 0.9945, "{east} {north}: {normal:?}");
            if north == 0.0 {
                let depth = contact.depth.to_array()[0];
                assert!((depth - 0.03).abs() < 0.006, "{east}: {depth}");
            }
        }
    }

    #[test]
    fn a_wheel_above_the_ground_tells_how_far() {
        let twin = twin(GRAVEL, |_, _| 0.0);
        let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]].map(V3::all);
        let contact = twin.meet(V3::all([0.0, 0.0, 0.567]), axes, all(0.0));
        assert!((contact.depth.to_array()[0] + 0.1).abs() < 1e-4, "{contact:?}");
    }

    /// A disc of radius 1 that is cut off by a chord of this depth: arccos(1 − d) − (1 − d) √(2 d − d²).
    #[test]
    fn a_deflection_follows_from_the_area_that_flat_ground_cuts_off() {
        let outline = Outline::new();
        for depth in [0.02_f64, 0.05, 0.1, 0.3, 0.6] {
            let chord = 1.0 - depth;
            let segment = vb_sdk::math::acos(chord) - chord * (2.0 * depth - depth * depth).sqrt();
            let told = f64::from(outline.deflection(all(segment as f32)).to_array()[0]);
            // Seven stations measure an area coarsely.
            assert!((told / depth - 1.0).abs() < 0.25, "{told} for {depth}");
        }
    }

    /// For any stations, flat terrain deflects the tyre by its height above the lowest point.
    #[test]
    fn flat_ground_deflects_by_its_depth() {
        let outline = Outline::new();
        for depth in [0.001_f32, 0.01, 0.03, 0.1, 0.3] {
            let area: f32 = outline.stations.iter().map(|s| (s.below - 1.0 + depth).max(0.0) * s.part).sum();
            let told = outline.deflection(all(area)).to_array()[0];
            assert!((told - depth).abs() < 1e-5, "{told} for {depth}");
        }
    }
}
