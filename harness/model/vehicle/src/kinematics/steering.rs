//! Steering gears, solved into the places of the joints that they move, and the knuckles of a beam.

use super::LinkageError;
use super::corner::command_at;
use super::mechanism::{Anchor, Joint, Mechanism, Pose, transform};
use super::table::BEAM_TRAVELS;
use super::{mirror, unit};
use crate::V3;
use crate::suspension::{KnuckleDrive, Knuckles, SteeringGear};
use vb_math::sin_cos;

/// Nodes of the steering command.
pub(super) const COMMANDS: usize = 17;

/// Places of the given points of the gear's moving part at every node of the command.
pub(super) fn joints(gear: &SteeringGear, points: &[V3]) -> Result<Vec<Vec<V3>>, LinkageError> {
    let pitman = Pitman::new(gear);
    let mut places = vec![Vec::new(); COMMANDS];
    let middle = COMMANDS / 2;
    let outward: [Vec<usize>; 2] = [(0..=middle).rev().collect(), (middle + 1..COMMANDS).collect()];
    for nodes in outward {
        let mut poses = pitman.as_ref().map(|p| p.mechanism.start()).unwrap_or_default();
        for k in nodes {
            let command = command_at(k, COMMANDS);
            let pose = match gear {
                SteeringGear::RackAndPinion { travel } => Pose::translation(0.0, -travel * command, 0.0),
                SteeringGear::RotaryArm { pivot, axis, angle, .. } => {
                    about(&(*pivot).into(), &(*axis).into(), -angle * gear.position(command))
                }
                SteeringGear::PitmanArm { angle, .. } => {
                    let locked = || LinkageError::SteeringLocked { command };
                    let p = pitman.as_ref().ok_or_else(locked)?;
                    // From the node before in short steps.
                    let before = if k <= middle {
                        command_at((k + 1).min(middle), COMMANDS)
                    } else {
                        command_at(k - 1, COMMANDS)
                    };
                    for part in 1..=4 {
                        let c = before + (command - before) * f64::from(part) / 4.0;
                        poses = p.mechanism.solve(&[-angle * c], &[], &poses).ok_or_else(locked)?;
                    }
                    poses[p.link]
                }
            };
            places[k] = points.iter().map(|p| transform(&pose, p)).collect();
        }
    }
    Ok(places)
}

fn about(at: &V3, axis: &V3, angle: f64) -> Pose {
    let q = nalgebra::UnitQuaternion::from_axis_angle(&unit(*axis), angle);
    Pose::from_parts((at - q * at).into(), q)
}

struct Pitman {
    mechanism: Mechanism,
    link: usize,
}

impl Pitman {
    fn new(gear: &SteeringGear) -> Option<Self> {
        let SteeringGear::PitmanArm { pivot, arm_end, idler_pivot, idler_end, axis, .. } = gear else {
            return None;
        };
        let axis = unit((*axis).into());
        let mut mechanism = Mechanism::default();
        let arm = mechanism.part(None, Joint::Hinge { at: (*pivot).into(), axis });
        let link = mechanism.part(Some(arm), Joint::Hinge { at: (*arm_end).into(), axis });
        mechanism.angle(arm, 0);
        mechanism.rod(Anchor::Part(link, (*idler_end).into()), Anchor::Chassis((*idler_pivot).into()));
        Some(Self { mechanism, link })
    }
}

/// Knuckle angles are tabulated at every `STRIDE`-th node of the beam's table.
const STRIDE: usize = 2;
const NODES: usize = (BEAM_TRAVELS - 1) / STRIDE + 1;

/// The two knuckles of a beam over command and both travels; straight lines between nodes.
#[derive(Clone, Debug)]
pub(super) struct KnuckleTable {
    low: f64,
    per_step: f64,
    /// A point and the direction of each kingpin, in the beam's design position.
    pub(super) kingpins: [(V3, V3); 2],
    /// Angles left and right, `[command][left][right]`.
    angles: Vec<[[[f64; 2]; NODES]; NODES]>,
}

/// The angle of a knuckle about its kingpin, with its derivatives.
#[derive(Clone, Copy, Default)]
pub(super) struct KnuckleAngle {
    pub(super) angle: f64,
    /// Over the left and the right travel, rad/m.
    pub(super) rates: [f64; 2],
    /// Over the command.
    pub(super) steer_rate: f64,
}

impl KnuckleTable {
    /// Solves the knuckles for the beam's poses at its nodes `[left][right]`, of travels from `low` on by `step`, and
    /// for the drag link's inner joint at the nodes of the command.
    pub(super) fn solve(
        knuckles: &Knuckles,
        joints: &[V3],
        beam: &[Vec<Pose>],
        low: f64,
        step: f64,
    ) -> Result<Self, LinkageError> {
        let mut m = Mechanism::default();
        let (lower, upper) = (V3::from(knuckles.kingpin_lower), V3::from(knuckles.kingpin_upper));
        let side = [1.0, -1.0];
        let kingpins = side.map(|s| (mirror(lower, s), *unit(mirror(upper - lower, s))));
        let parts = kingpins.map(|(at, axis)| m.part(None, Joint::Hinge { at, axis: unit(axis) }));
        let ties = side.map(|s| mirror(knuckles.tie_rod.into(), s));
        let inner = Anchor::Input(0, knuckles.drag_link_inner.into());
        match &knuckles.by {
            KnuckleDrive::Toebar { drag_link_outer } => {
                m.rod(Anchor::Part(parts[0], ties[0]), Anchor::Part(parts[1], ties[1]));
                m.rod(Anchor::Part(parts[0], (*drag_link_outer).into()), inner);
            }
            KnuckleDrive::Bellcrank { pivot, axis, drag_link_outer, tie_rod_left, tie_rod_right } => {
                let crank = m.part(None, Joint::Hinge { at: (*pivot).into(), axis: unit((*axis).into()) });
                for (end, i) in [(tie_rod_left, 0), (tie_rod_right, 1)] {
                    m.rod(Anchor::Part(crank, (*end).into()), Anchor::Part(parts[i], ties[i]));
                }
                m.rod(Anchor::Part(crank, (*drag_link_outer).into()), inner);
            }
        }
        let axes = kingpins.map(|(_, axis)| axis);
        let node = |i: usize| low + step * i as f64;
        // The beam's node next to its design position.
        let rest = ((-low / step / STRIDE as f64).round() as usize).min(NODES - 1);
        let mut angles = vec![[[[0.0; 2]; NODES]; NODES]; joints.len()];
        let middle = joints.len() / 2;
        let sweep = |from: usize, count: usize| -> [Vec<usize>; 2] {
            [(0..from).rev().collect(), (from + 1..count).collect()]
        };
        // Every step goes from a solved position to one nearby: commands at rest, left travels, right travels.
        let design = V3::from(knuckles.drag_link_inner);
        let go = |from: &(Vec<Pose>, V3), k: usize, l: usize, r: usize| {
            let to = transform(&beam[l * STRIDE][r * STRIDE].inverse(), &joints[k]);
            let mut poses = from.0.clone();
            for part in 1..=4 {
                let at = from.1 + (to - from.1) * (f64::from(part) / 4.0);
                poses = m.solve(&[], &[at], &poses).ok_or(LinkageError::KnucklesLocked {
                    travels: [node(l * STRIDE), node(r * STRIDE)],
                    command: command_at(k, joints.len()),
                })?;
            }
            Ok((poses, to))
        };
        let mut fill = |k: usize, from: &(Vec<Pose>, V3)| {
            let mut put = |l: usize, r: usize, at: &(Vec<Pose>, V3)| {
                angles[k][l][r] = [0, 1].map(|i| super::mechanism::turned(&at.0[i], &axes[i]));
            };
            let mut row = |l: usize, from: &(Vec<Pose>, V3)| -> Result<(), LinkageError> {
                put(l, rest, from);
                for way in sweep(rest, NODES) {
                    let mut at = from.clone();
                    for r in way {
                        at = go(&at, k, l, r)?;
                        put(l, r, &at);
                    }
                }
                Ok(())
            };
            row(rest, from)?;
            for way in sweep(rest, NODES) {
                let mut at = from.clone();
                for l in way {
                    at = go(&at, k, l, rest)?;
                    row(l, &at)?;
                }
            }
            Ok(())
        };
        let start = go(&(m.start(), design), middle, rest, rest)?;
        fill(middle, &start)?;
        for way in sweep(middle, joints.len()) {
            let mut at = start.clone();
            for k in way {
                at = go(&at, k, rest, rest)?;
                fill(k, &at)?;
            }
        }
        Ok(Self { low, per_step: 1.0 / (step * STRIDE as f64), kingpins, angles })
    }

    /// The angles of both knuckles; beyond the tabulated travels those of the ends.
    pub(super) fn at(&self, travels: [f64; 2], command: f64) -> [KnuckleAngle; 2] {
        let place = |x: f64, count: usize| {
            let last = (count - 1) as f64;
            let inside = x.clamp(0.0, last);
            let k = (inside as usize).min(count.saturating_sub(2));
            (k, inside - k as f64, if x == inside { 1.0 } else { 0.0 })
        };
        let count = self.angles.len();
        let per_command = 0.5 * (count - 1) as f64;
        let (k, fk, _) = place((command + 1.0) * per_command, count);
        let (l, fl, dl) = place((travels[0] - self.low) * self.per_step, NODES);
        let (r, fr, dr) = place((travels[1] - self.low) * self.per_step, NODES);
        [0, 1].map(|i| {
            let mut a = KnuckleAngle::default();
            for (c, wc, vc) in [(0, 1.0 - fk, -1.0), (1, fk, 1.0)] {
                let square = &self.angles[(k + c).min(count - 1)];
                for (x, wx, vx) in [(0, 1.0 - fl, -1.0), (1, fl, 1.0)] {
                    for (y, wy, vy) in [(0, 1.0 - fr, -1.0), (1, fr, 1.0)] {
                        let node = square[l + x][r + y][i];
                        a.angle += wc * wx * wy * node;
                        a.rates[0] += wc * vx * wy * node * self.per_step * dl;
                        a.rates[1] += wc * wx * vy * node * self.per_step * dr;
                        a.steer_rate += vc * wx * wy * node * per_command;
                    }
                }
            }
            a
        })
    }

    /// A vector turned about a kingpin (Rodrigues' rotation).
    pub(super) fn turn(axis: &V3, angle: f64, v: &V3) -> V3 {
        let (s, c) = sin_cos(angle);
        v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c))
    }
}
