//! Tyres: where a wheel meets the ground, and the forces in the contact plane.

use crate::V3;
use crate::spec::TyreSpec;
use vb_world::Heightfield;

/// A wheel's contact with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Where the force acts, world, m.
    pub point: V3,
    /// Out of the ground.
    pub normal: V3,
    /// Radial deflection, m, > 0.
    pub depth: f64,
}

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
                    let overlap = ((g.z - pz) / climb).min(2.0 * half);
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

/// Forces of a tyre in its contact plane: a brush with relaxation.
///
/// The tread deflects by `u` (m) against the ground: u̇ = v_s − |v_r| u/σ with the sliding velocity v_s of the contact
/// patch, the rolling speed v_r and the relaxation length σ of each direction (Pacejka, Tire and Vehicle Dynamics,
/// 2012, eq. 7.8 ff.). The force follows the brush model with a parabolic pressure distribution (ibid. eq. 3.11,
/// 3.40): with e = (C/σ) u the force of full adhesion and x = |e|/(μF_z), F = μF_z(x − x²/3 + x³/27) up to x = 3 and
/// μF_z beyond. At rest the deflection is a spring, so a braked vehicle stays where it is on a slope up to atan μ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brush {
    /// Longitudinal and lateral deflection, m.
    pub deflection: [f64; 2],
}

/// What the brush needs of a tyre, per unit load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrushLaw {
    stiffness: [f64; 2],
    damping: [f64; 2],
    relaxation: [f64; 2],
}

impl BrushLaw {
    pub(crate) fn new(tyre: &TyreSpec) -> Self {
        let stiffness = std::array::from_fn(|k| tyre.slip_stiffness[k] / tyre.relaxation_length[k]);
        // 2 ζ √(k m) per unit load, with k = stiffness · load and m = load / g.
        let damping = stiffness.map(|k: f64| 2.0 * tyre.damping_ratio * (k / crate::GRAVITY).sqrt());
        Self { stiffness, damping, relaxation: tyre.relaxation_length }
    }
}

impl Brush {
    /// Advances the deflection by `dt` and returns the force on the wheel (longitudinal, lateral), N.
    ///
    /// `sliding`: velocity of the contact patch over the ground, m/s; `rolling`: |spin · effective radius|, m/s.
    #[inline]
    pub(crate) fn advance(
        &mut self,
        law: &BrushLaw,
        sliding: [f64; 2],
        rolling: f64,
        load: f64,
        friction: f64,
        dt: f64,
    ) -> [f64; 2] {
        if load <= 0.0 || friction <= 0.0 {
            self.deflection = [0.0; 2];
            return [0.0; 2];
        }
        let limit = friction * load;
        let mut rate = [0.0; 2];
        for k in 0..2 {
            let old = self.deflection[k];
            let new = (old + dt * sliding[k]) / (1.0 + dt * rolling / law.relaxation[k]);
            rate[k] = (new - old) / dt;
            self.deflection[k] = new;
        }
        let e = [law.stiffness[0] * load * self.deflection[0], law.stiffness[1] * load * self.deflection[1]];
        let adhesion = (e[0] * e[0] + e[1] * e[1]).sqrt();
        let x = adhesion / limit;
        if x >= 3.0 {
            // Sliding: the tread deflects no further.
            let keep = 3.0 / x;
            self.deflection[0] *= keep;
            self.deflection[1] *= keep;
            let scale = -limit / adhesion;
            return [e[0] * scale, e[1] * scale];
        }
        let secant = 1.0 - x / 3.0 + x * x / 27.0;
        let tangent = (1.0 - x / 3.0) * (1.0 - x / 3.0);
        let f = [
            -e[0] * secant - law.damping[0] * load * rate[0] * tangent,
            -e[1] * secant - law.damping[1] * load * rate[1] * tangent,
        ];
        let norm = (f[0] * f[0] + f[1] * f[1]).sqrt();
        let clip = if norm > limit { limit / norm } else { 1.0 };
        [f[0] * clip, f[1] * clip]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tyre() -> TyreSpec {
        crate::VehicleSpec::parse(include_str!("../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap().tyre
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

    #[test]
    fn steady_slip_gives_the_brush_curve_and_the_friction_limit() {
        let t = tyre();
        let law = BrushLaw::new(&t);
        let (load, mu) = (6000.0, 0.8);
        for slip in [0.005, 0.02, 0.05, 0.3] {
            let mut b = Brush::default();
            let rolling = 10.0;
            let mut f = [0.0; 2];
            for _ in 0..4000 {
                f = b.advance(&law, [-slip * rolling, 0.0], rolling, load, mu, 1e-3);
            }
            // Pacejka 2012, eq. 3.11 with stiffness C = slip_stiffness · load.
            let x = t.slip_stiffness[0] * slip / mu;
            let expected = mu * load * if x < 3.0 { x - x * x / 3.0 + x * x * x / 27.0 } else { 1.0 };
            assert!((f[0] - expected).abs() < 2e-3 * expected, "{slip}: {} {expected}", f[0]);
            assert_eq!(f[1], 0.0);
        }
    }

    #[test]
    fn combined_slip_never_exceeds_friction() {
        let law = BrushLaw::new(&tyre());
        let mut b = Brush::default();
        for k in 0..5000 {
            let a = 0.013 * f64::from(k);
            let s = [3.0 * vb_math::sin(a), 2.0 * vb_math::cos(0.7 * a)];
            let f = b.advance(&law, s, 2.0, 5000.0, 0.6, 1e-3);
            assert!(vb_math::hypot(f[0], f[1]) <= 3000.0 * (1.0 + 1e-12));
        }
    }
}
