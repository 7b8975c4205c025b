//! Where a wheel meets the ground.

use super::Contact;
use crate::V3;
use crate::spec::TyreSpec;
use vb_world::Heightfield;

const STATIONS: usize = 15;
/// Offsets of the two strips from the wheel's mid-plane, as fractions of the width.
const STRIPS: [f64; 2] = [-0.3, 0.3];
/// Deflections at which a pair of stations begins to overlap or is wholly overlapped by flat ground.
const KNOTS: usize = STATIONS + 1;

/// Enveloping contact of a tyre with a heightfield.
///
/// The disc is sampled at stations along two strips. The overlap of disc and ground gives an area, which the segment
/// of a disc on flat ground relates to a radial deflection; the ground's gradient, weighted by overlap, gives the
/// normal, and the centroid of the overlap the point of contact. So an edge, a kerb and a ridge narrower than the
/// wheel are felt. (The envelope method of Chrono's `DiscTerrainCollisionEnvelope`, after Sui and Hirshey 2001,
/// with few stations, both strips and the gradient.)
#[derive(Clone, Debug)]
pub struct Envelope {
    radius: f64,
    width: f64,
    xs: [f64; STATIONS],
    /// Half the chord at each station.
    half: [f64; STATIONS],
    /// (area, deflection) on flat ground, between which the relation is linear for this very sampling.
    knots: [(f64, f64); KNOTS],
}

impl Envelope {
    /// For a tyre's radius and width.
    #[must_use]
    pub fn new(tyre: &TyreSpec) -> Self {
        let r = tyre.radius;
        let spacing = 2.0 * r / STATIONS as f64;
        let xs: [f64; STATIONS] = std::array::from_fn(|k| -r + spacing * (k as f64 + 0.5));
        let half = xs.map(|x| (r * r - x * x).max(0.0).sqrt());
        let area =
            |depth: f64| half.iter().map(|h| (h - (r - depth)).clamp(0.0, 2.0 * h)).sum::<f64>() * spacing;
        let middle = STATIONS / 2;
        let knots = std::array::from_fn(|k| {
            // Stations come in pairs around the middle one, which is touched first.
            let depth = if k <= middle { r - half[middle - k] } else { r + half[k - middle - 1] };
            (area(depth), depth)
        });
        Self { radius: r, width: tyre.width, xs, half, knots }
    }

    /// The contact of a wheel with centre `hub` and axle direction `axis` (unit, to the left), if it touches.
    #[must_use]
    pub fn query(&self, ground: &Heightfield, hub: &V3, axis: &V3) -> Option<Contact> {
        self.query_where(ground, hub, axis, |_, _| 1.0)
    }

    /// As [`Self::query`] where only a share of the ground, between 0 and 1, carries at each (x, y).
    pub(crate) fn query_where(
        &self,
        ground: &Heightfield,
        hub: &V3,
        axis: &V3,
        share: impl Fn(f64, f64) -> f64,
    ) -> Option<Contact> {
        let below = ground.at(hub.x, hub.y);
        let slope = V3::new(-below.dzdx, -below.dzdy, 1.0).normalize();
        let along = axis.cross(&slope);
        // A wheel that lies on its side stands on the hull, not on its tread.
        let along = along.try_normalize(0.3)?;
        let up = along.cross(axis);
        if up.z < 0.1 {
            return None;
        }
        let (mut sum, mut sum_x, mut sum_s, mut sum_gx, mut sum_gy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for strip in STRIPS {
            let offset = strip * self.width;
            let origin = hub + axis * offset;
            for (&x, &half) in self.xs.iter().zip(&self.half) {
                let px = origin.x + along.x * x - up.x * half;
                let py = origin.y + along.y * x - up.y * half;
                let pz = origin.z + along.z * x - up.z * half;
                let g = ground.at(px, py);
                if g.z > pz {
                    // Along the chord to where it leaves the facet's plane; a facet nearly along it ends it.
                    let climb = (up.z - g.dzdx * up.x - g.dzdy * up.y).max(0.3);
                    let overlap = ((g.z - pz) / climb).min(2.0 * half) * share(px, py);
                    sum += overlap;
                    sum_x += overlap * x;
                    sum_s += overlap * offset;
                    sum_gx += overlap * g.dzdx;
                    sum_gy += overlap * g.dzdy;
                }
            }
        }
        if sum <= 0.0 {
            return None;
        }
        let inv = 1.0 / sum;
        let area = sum * 2.0 * self.radius / (STATIONS * STRIPS.len()) as f64;
        let k = self.knots.iter().position(|&(a, _)| area < a).unwrap_or(KNOTS - 1).max(1);
        let ((a0, d0), (a1, d1)) = (self.knots[k - 1], self.knots[k]);
        let depth = d0 + (d1 - d0) * ((area - a0) / (a1 - a0)).min(1.0);
        let normal = V3::new(-sum_gx * inv, -sum_gy * inv, 1.0).normalize();
        let forward = axis.cross(&normal).try_normalize(0.3)?;
        let radial = forward.cross(axis);
        let point = hub + along * (sum_x * inv) + axis * (sum_s * inv) - radial * (self.radius - depth);
        Some(Contact { point, normal, depth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tyre() -> TyreSpec {
        crate::VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv")
            .unwrap()
            .tyre
    }

    #[test]
    fn on_a_plane_the_envelope_finds_the_radial_deflection_and_the_normal() {
        let t = tyre();
        let e = Envelope::new(&t);
        // A 30 % grade along x, the wheel heading up it with its axle level.
        let ground = Heightfield::new(9, 9, 1.0, (0..81).map(|i| 0.3 * f64::from(i % 9)).collect());
        let n = V3::new(-0.3, 0.0, 1.0).normalize();
        for depth in [0.005, 0.02, 0.08] {
            let on_plane = V3::new(0.2, 0.1, ground.height(0.2, 0.1));
            let hub = on_plane + n * (t.radius - depth);
            let c = e.query(&ground, &hub, &V3::y()).unwrap();
            assert!((c.normal - n).norm() < 1e-12);
            assert!((c.depth - depth).abs() < 1e-9, "{} {depth}", c.depth);
            assert!((c.point - on_plane).norm() < 0.02, "{} {on_plane}", c.point);
        }
        assert!(e.query(&ground, &V3::new(0.2, 0.1, 3.0), &V3::y()).is_none());
    }

    #[test]
    fn a_step_narrower_than_the_wheel_is_felt_before_the_hub_is_over_it() {
        let t = tyre();
        let e = Envelope::new(&t);
        // A ridge 0.3 m high at x = 0 between flat ground, pitch 0.1 m.
        let (rows, cols) = (41, 81);
        let h = (0..rows * cols).map(|i| if i % cols == 40 { 0.3 } else { 0.0 }).collect();
        let ground = Heightfield::new(rows, cols, 0.1, h);
        let hub = V3::new(-0.35, 0.0, t.radius - 0.01);
        let c = e.query(&ground, &hub, &V3::y()).unwrap();
        assert!(c.normal.x < -0.1, "the ridge pushes the wheel back: {}", c.normal);
        assert!(c.depth > 0.011);
    }
}
