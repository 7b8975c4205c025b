//! Two wheels on a rigid beam, whose two coordinates are the travels of its ends.
//!
//! The beam's pose over both travels is tabulated; hubs and struts follow from it in closed form, so that their rates
//! are exactly those of the interpolated pose.

use super::LinkageError;
use super::mechanism::{Anchor, Joint, Mechanism, Pose, transform};
use super::steering::{KnuckleAngle, KnuckleTable};
use super::table::{BEAM_COLUMNS, BEAM_TRAVELS, BeamRow, BeamTable};
use super::{Side, mirror};
use crate::V3;
use crate::suspension::{Linkage, Rod, Suspension};
use nalgebra::{Quaternion, UnitQuaternion};

/// Effective length of a leaf spring as a link over that of its fixed half (SAE HS-788, Manual on Design and
/// Application of Leaf Springs: the seat of a symmetric flat spring moves on a circle of ¾ of that length).
const LEAF_LINK: f64 = 0.75;

/// A solved beam.
#[derive(Clone, Debug)]
pub struct BeamAxle {
    table: BeamTable,
    /// The beam's middle and the left wheel centre in the design position.
    middle: V3,
    spindle: V3,
    /// Left struts: end on the chassis, end on the beam.
    struts: Vec<(V3, V3)>,
    knuckles: Option<KnuckleTable>,
}

/// A wheel of a beam, in the chassis frame relative to the axle's reference point. Its rates are over the travels of
/// the left and the right wheel, in this order.
#[derive(Clone, Copy, Debug)]
pub struct BeamWheel {
    /// The wheel's centre, m.
    pub hub: V3,
    /// ∂hub/∂travel, m/m.
    pub hub_rates: [V3; 2],
    /// ∂hub/∂command of the steering, m.
    pub hub_steer_rate: V3,
    /// The rotation of the knuckle over the command of the steering, its component across the axle, rad.
    pub steer_tilt_rate: V3,
    /// The acceleration Σᵢⱼ ∂²hub/∂qᵢ∂qⱼ q̇ᵢ q̇ⱼ of the centre over the travels q, m/s².
    pub bend: V3,
    /// The direction of the wheel's axle, a unit vector to the left.
    pub axis: V3,
    /// The rotation of the wheel's axle over each travel, its component across the axle, rad/m.
    pub tilt_rates: [V3; 2],
    /// The lengths of the struts, m.
    pub struts: [f64; 2],
    /// ∂strut/∂travel as `[strut][travel]`, m/m.
    pub strut_rates: [[f64; 2]; 2],
}

/// The pose of a beam, with its wheels.
#[derive(Clone, Copy, Debug)]
pub struct BeamPose {
    /// The left and the right wheel.
    pub wheels: [BeamWheel; 2],
    /// The middle of the beam in the chassis frame, relative to the axle's reference point, m.
    pub middle: V3,
    /// ∂middle/∂travel, over the left and the right travel, m/m.
    pub middle_rates: [V3; 2],
    /// The acceleration Σᵢⱼ ∂²middle/∂qᵢ∂qⱼ q̇ᵢ q̇ⱼ of the middle over the travels q, m/s².
    pub middle_bend: V3,
}

fn mechanism(suspension: &Suspension, spindle: V3, middle: V3) -> Mechanism {
    let mut m = Mechanism::default();
    let beam = m.part(None, Joint::Free { centre: middle });
    let rod = |m: &mut Mechanism, rod: &Rod, side: f64| {
        let (chassis, end) = (mirror(rod.chassis.into(), side), mirror(rod.carrier.into(), side));
        m.rod(Anchor::Part(beam, end), Anchor::Chassis(chassis));
    };
    match &suspension.linkage {
        Linkage::SolidAxle(l) => {
            for link in &l.links {
                rod(&mut m, link, 1.0);
                rod(&mut m, link, -1.0);
            }
            l.single_links.iter().for_each(|link| rod(&mut m, link, 1.0));
        }
        Linkage::LeafAxle(l) => {
            let (seat, eye) = (V3::from(l.seat), V3::from(l.eye));
            let link = Rod { chassis: (seat + (eye - seat) * LEAF_LINK).into(), carrier: l.seat };
            rod(&mut m, &link, 1.0);
            rod(&mut m, &link, -1.0);
            // Leaves are stiff sideways and, clamped to the beam, against its turning about itself.
            m.coordinate(Anchor::Part(beam, V3::new(seat.x, 0.0, seat.z)), 1, None);
            m.direction(beam, V3::z(), V3::x());
        }
        Linkage::PivotAxle(l) => {
            let pin = Anchor::Part(beam, V3::new(spindle.x, 0.0, l.pin_height));
            m.coordinate(pin, 0, None);
            m.coordinate(pin, 1, None);
            m.direction(beam, V3::z(), V3::x());
            m.direction(beam, V3::y(), V3::x());
        }
        _ => {}
    }
    for (drive, side) in [(0, 1.0), (1, -1.0)] {
        m.coordinate(Anchor::Part(beam, mirror(spindle, side)), 2, Some(drive));
    }
    m
}

impl BeamAxle {
    /// Solves the beam for all pairs of travels, and the knuckles for all places of the drag link's inner joint.
    pub(super) fn solve(suspension: &Suspension, joints: Option<&[V3]>) -> Result<Self, LinkageError> {
        let spindle = V3::from(suspension.linkage.spindle());
        let middle = V3::new(spindle.x, 0.0, spindle.z);
        let m = mechanism(suspension, spindle, middle);
        let [low, high] = suspension.range;
        let step = (high - low) / (BEAM_TRAVELS - 1) as f64;
        let node = |i: usize| low + step * i as f64;
        let rest = ((-low / step).round() as usize).min(BEAM_TRAVELS - 1);
        let sweep: [Vec<usize>; 2] = [(0..rest).rev().collect(), (rest + 1..BEAM_TRAVELS).collect()];
        let solve = |l: usize, r: usize, from: &[Pose]| {
            m.solve(&[node(l), node(r)], &[], from)
                .ok_or(LinkageError::BeamLocked { travels: [node(l), node(r)] })
        };
        let mut poses = vec![vec![Pose::identity(); BEAM_TRAVELS]; BEAM_TRAVELS];
        let mut row = |l: usize, from: &[Pose]| -> Result<(), LinkageError> {
            poses[l][rest] = from[0];
            for way in &sweep {
                let mut at = from.to_vec();
                for &r in way {
                    at = solve(l, r, &at)?;
                    poses[l][r] = at[0];
                }
            }
            Ok(())
        };
        let start = solve(rest, rest, &m.start())?;
        row(rest, &start)?;
        for way in &sweep {
            let mut at = start.clone();
            for &l in way {
                at = solve(l, rest, &at)?;
                row(l, &at)?;
            }
        }
        let mut nodes = [[[0.0; BEAM_COLUMNS]; BEAM_TRAVELS]; BEAM_TRAVELS];
        for (l, line) in poses.iter().enumerate() {
            for (r, pose) in line.iter().enumerate() {
                let shift = transform(pose, &middle) - middle;
                let v = pose.rotation.imag() * pose.rotation.w.signum();
                nodes[l][r] = [shift.x, shift.y, shift.z, v.x, v.y, v.z];
            }
        }
        let struts: Vec<(V3, V3)> =
            suspension.struts.iter().map(|s| (V3::from(s.chassis), V3::from(s.end))).collect();
        for (k, &(chassis, end)) in struts.iter().enumerate() {
            if suspension.struts[k].spring.is_none() {
                continue;
            }
            let length = |i: usize| (transform(&poses[i][i], &end) - chassis).norm();
            if let Some(i) = (1..BEAM_TRAVELS).find(|&i| length(i) >= length(i - 1)) {
                return Err(LinkageError::Lengthens { strut: k, travel: node(i - 1) });
            }
        }
        let knuckles = match (suspension.linkage.knuckles(), joints) {
            (Some(k), Some(joints)) => Some(KnuckleTable::solve(k, joints, &poses, low, step)?),
            _ => None,
        };
        Ok(Self { table: BeamTable::new(low, step, &nodes), middle, spindle, struts, knuckles })
    }

    /// The pose of the beam at the travels of its ends (left, right, m; compression positive), which change with
    /// `rates` (m/s), and at a steering command in [-1, 1].
    #[must_use]
    #[inline]
    pub fn at(&self, travels: [f64; 2], rates: [f64; 2], command: f64) -> BeamPose {
        let p = self.table.at(travels, rates);
        let place = |r: &BeamRow| V3::new(r[0], r[1], r[2]);
        let vector = |r: &BeamRow| V3::new(r[3], r[4], r[5]);
        let v = vector(&p.value);
        // Within any range that closes the beam turns by far less than a right angle.
        let w = (1.0 - v.norm_squared()).max(0.25).sqrt();
        let turn = UnitQuaternion::new_unchecked(Quaternion::from_parts(w, v)).to_rotation_matrix();
        // ω = 2 (w v̇ − ẇ v + v × v̇), from ω = 2 q̇ q*; differentiated once more for ω̇.
        let scalar_rate = |d: &V3| -v.dot(d) / w;
        let spins = [0, 1].map(|j| {
            let d = vector(&p.rates[j]);
            (d * w - v * scalar_rate(&d) + v.cross(&d)) * 2.0
        });
        let (d, dd) = (vector(&p.rates[0]) * rates[0] + vector(&p.rates[1]) * rates[1], vector(&p.bend));
        let w_rate = scalar_rate(&d);
        let w_bend = -(d.norm_squared() + v.dot(&dd) + w_rate * w_rate) / w;
        let spin_bend = (dd * w - v * w_bend + v.cross(&dd)) * 2.0;
        let spin = spins[0] * rates[0] + spins[1] * rates[1];
        let shift_rates = [place(&p.rates[0]), place(&p.rates[1])];
        let middle = self.middle + place(&p.value);
        let middle_bend = place(&p.bend);
        let angles = self.knuckles.as_ref().map_or([KnuckleAngle::default(); 2], |k| k.at(travels, command));
        let wheels = [Side::Left, Side::Right].map(|side| {
            let (i, sign) = (side.index(), side.sign());
            let spindle = mirror(self.spindle, sign);
            let angle = angles[i];
            let (lever, axis, kingpin) = match &self.knuckles {
                Some(k) => {
                    let (at, kingpin) = k.kingpins[i];
                    let lever = KnuckleTable::turn(&kingpin, angle.angle, &(spindle - at));
                    let axis = KnuckleTable::turn(&kingpin, angle.angle, &V3::y());
                    (lever, turn * axis, turn * kingpin)
                }
                None => (V3::zeros(), turn * V3::y(), V3::zeros()),
            };
            let arm = turn
                * match &self.knuckles {
                    Some(k) => k.kingpins[i].0 + lever - self.middle,
                    None => spindle - self.middle,
                };
            let steered = kingpin.cross(&(turn * lever));
            let hub_rates = [0, 1].map(|j| shift_rates[j] + spins[j].cross(&arm) + steered * angle.rates[j]);
            let tilt_rates = [0, 1].map(|j| {
                let r = spins[j] + kingpin * angle.rates[j];
                r - axis * axis.dot(&r)
            });
            let mut struts = [0.0; 2];
            let mut strut_rates = [[0.0; 2]; 2];
            for (s, &(chassis, end)) in self.struts.iter().enumerate().take(2) {
                let (chassis, end) = (mirror(chassis, sign), mirror(end, sign));
                let r = turn * (end - self.middle);
                let along = middle + r - chassis;
                struts[s] = along.norm();
                let n = along / struts[s];
                strut_rates[s] = [0, 1].map(|j| n.dot(&(shift_rates[j] + spins[j].cross(&r))));
            }
            BeamWheel {
                hub: middle + arm,
                hub_rates,
                hub_steer_rate: steered * angle.steer_rate,
                steer_tilt_rate: (kingpin - axis * axis.dot(&kingpin)) * angle.steer_rate,
                bend: middle_bend + spin_bend.cross(&arm) + spin.cross(&spin.cross(&arm)),
                axis,
                tilt_rates,
                struts,
                strut_rates,
            }
        });
        BeamPose { wheels, middle, middle_rates: shift_rates, middle_bend }
    }
}
