//! Wheels that are guided independently: their mechanisms, solved into tables over travel and steering command.

use super::mechanism::{Anchor, Joint, Mechanism, Pose, transform, turned};
use super::table::{COLUMNS, CornerTable, NODES, Row, TRAVELS};
use super::{LinkageError, mirror, unit};
use crate::V3;
use crate::suspension::{AntiRoll, Linkage, Part, Suspension};

/// A coordinate of the linkage along which a spring or damper acts; it decreases when the wheel rises.
enum Measure {
    /// Distance between a point of the chassis and one of a part.
    Length { chassis: V3, end: V3, part: usize },
    /// Angle of an arm about this axis, taken negative.
    Angle { axis: V3, part: usize },
}

/// The mechanism of a left wheel.
struct Corner {
    mechanism: Mechanism,
    upright: usize,
    spindle: V3,
    measures: Vec<Measure>,
    /// Arm of an anti-roll bar.
    bar: Option<(usize, V3)>,
}

const HEIGHT: usize = 0;

impl Corner {
    fn new(suspension: &Suspension) -> Self {
        let mut m = Mechanism::default();
        let linkage = &suspension.linkage;
        let spindle = V3::from(linkage.spindle());
        let hinge = |a: V3, b: V3| Joint::Hinge { at: a, axis: unit(b - a) };
        let tie = |m: &mut Mechanism, upright: usize, inner: [f64; 3], outer: [f64; 3]| {
            m.rod(Anchor::Part(upright, outer.into()), Anchor::Input(0, inner.into()));
        };
        let mut measures = Vec::new();
        let (upright, arm) = match linkage {
            Linkage::DoubleWishbone(l) => {
                let (front, rear) = (l.lower_arm_front.into(), l.lower_arm_rear.into());
                let arm = m.part(None, hinge(front, rear));
                let upright = m.part(Some(arm), Joint::Ball { at: l.lower_ball_joint.into() });
                for chassis in [l.upper_arm_front, l.upper_arm_rear] {
                    m.rod(Anchor::Part(upright, l.upper_ball_joint.into()), Anchor::Chassis(chassis.into()));
                }
                tie(&mut m, upright, l.tie_rod_inner, l.tie_rod_outer);
                (upright, arm)
            }
            Linkage::SingleWishbone(l) => {
                let arm = m.part(None, hinge(l.arm_front.into(), l.arm_rear.into()));
                let kingpin = hinge(l.kingpin_lower.into(), l.kingpin_upper.into());
                let upright = m.part(Some(arm), kingpin);
                tie(&mut m, upright, l.tie_rod_inner, l.tie_rod_outer);
                (upright, arm)
            }
            Linkage::Multilink(l) => {
                let upright = m.part(None, Joint::Free { centre: spindle });
                for rod in &l.links {
                    m.rod(Anchor::Part(upright, rod.carrier.into()), Anchor::Chassis(rod.chassis.into()));
                }
                tie(&mut m, upright, l.tie_rod_inner, l.tie_rod_outer);
                (upright, upright)
            }
            Linkage::TorsionArm(l) => {
                let at = V3::from(l.pivot);
                // Turning about it lifts the wheel.
                let axis = unit(l.axis.into());
                let lifts = axis.cross(&(spindle - at)).z;
                let axis = if lifts < 0.0 { -axis } else { axis };
                let arm = m.part(None, Joint::Hinge { at, axis });
                if l.torsion.is_some() {
                    measures.push(Measure::Angle { axis: *axis, part: arm });
                }
                (arm, arm)
            }
            // Not of this kind: no coordinates, which leaves the wheel where it is.
            Linkage::Rigid(_) | Linkage::SolidAxle(_) | Linkage::LeafAxle(_) | Linkage::PivotAxle(_) => {
                return Self { mechanism: m, upright: 0, spindle, measures, bar: None };
            }
        };
        m.coordinate(Anchor::Part(upright, spindle), 2, Some(HEIGHT));
        let part = |on: Part| if on == Part::Arm { arm } else { upright };
        measures.extend(suspension.struts.iter().map(|s| Measure::Length {
            chassis: s.chassis.into(),
            end: s.end.into(),
            part: part(s.part),
        }));
        let bar = match &suspension.anti_roll {
            Some(AntiRoll::Bar { pivot, arm_end, link_end, part: on, .. }) => {
                let arm = m.part(None, Joint::Hinge { at: (*pivot).into(), axis: V3::y_axis() });
                m.rod(Anchor::Part(arm, (*arm_end).into()), Anchor::Part(part(*on), (*link_end).into()));
                Some((arm, V3::y()))
            }
            _ => None,
        };
        Self { mechanism: m, upright, spindle, measures, bar }
    }

    fn row(&self, poses: &[Pose], travel: f64) -> Row {
        let hub = transform(&poses[self.upright], &self.spindle);
        let axis = poses[self.upright].rotation * V3::y();
        let mut row = [hub.x, hub.y, axis.x, axis.z, 0.0, 0.0, 0.0];
        for (k, measure) in self.measures.iter().enumerate() {
            row[4 + k] = match measure {
                Measure::Length { chassis, end, part } => (transform(&poses[*part], end) - chassis).norm(),
                Measure::Angle { axis, part } => -turned(&poses[*part], axis),
            };
        }
        row[6] = self.bar.map_or(travel, |(part, axis)| turned(&poses[part], &axis));
        row
    }
}

/// Solves the linkage of one wheel for all travels and all given positions of the inner tie-rod joint, one a node of
/// the steering command (one only if the axle isn't steered); `side` is 1 for the left wheel, −1 for the right.
pub(super) fn solve(
    suspension: &Suspension,
    joints: &[Option<V3>],
    side: f64,
) -> Result<CornerTable, LinkageError> {
    let spindle = V3::from(suspension.linkage.spindle());
    let [low, high] = suspension.range;
    if let Linkage::Rigid(_) = suspension.linkage {
        return Ok(CornerTable::fixed(spindle, side));
    }
    let corner = Corner::new(suspension);
    // The node nearest to the design position, from which the solution goes outwards.
    let step = (high - low) / (TRAVELS - 1) as f64;
    let at = |i: usize| low + step * i as f64;
    let middle = ((-low / step).round() as usize).min(TRAVELS - 1);
    let design = suspension.linkage.tie_rod_inner().map_or_else(V3::zeros, V3::from);
    let mut columns = Vec::with_capacity(joints.len());
    for (k, joint) in joints.iter().enumerate() {
        let command = command_at(k, joints.len());
        let joint = joint.map_or(design, |j| mirror(j, side));
        let locked = |travel: f64| LinkageError::Locked { travel, command };
        let mut centre = corner.mechanism.start();
        // The joint's way from the design position in short steps.
        let parts = if joint == design { 1 } else { 16 };
        for part in 1..=parts {
            let f = f64::from(part) / f64::from(parts);
            let at_joint = design + (joint - design) * f;
            let travel = at(middle) * f;
            centre = corner.mechanism.solve(&[travel], &[at_joint], &centre).ok_or_else(|| locked(travel))?;
        }
        let mut column = [[0.0; COLUMNS]; TRAVELS];
        column[middle] = corner.row(&centre, at(middle));
        let outward: [Vec<usize>; 2] = [(0..middle).rev().collect(), (middle + 1..TRAVELS).collect()];
        for indices in outward {
            let mut poses = centre.clone();
            for i in indices {
                poses = corner.mechanism.solve(&[at(i)], &[joint], &poses).ok_or_else(|| locked(at(i)))?;
                column[i] = corner.row(&poses, at(i));
            }
        }
        let first = corner.measures.len() - suspension.struts.len();
        for k in (0..suspension.struts.len()).filter(|&k| suspension.struts[k].spring.is_some()) {
            let column_of = 4 + first + k;
            if let Some(i) = column.windows(2).position(|w| w[1][column_of] >= w[0][column_of]) {
                return Err(LinkageError::Lengthens { strut: k, travel: at(i) });
            }
        }
        columns.push(column);
    }
    debug_assert!(columns.iter().all(|c| c.len() + 2 * super::table::PAD == NODES));
    Ok(CornerTable::new(low, step, spindle.z, side, &columns))
}

/// Steering command of a node.
pub(super) fn command_at(k: usize, count: usize) -> f64 {
    if count > 1 { 2.0 * k as f64 / (count - 1) as f64 - 1.0 } else { 0.0 }
}
