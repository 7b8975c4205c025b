//! Mechanisms of rigid parts and their solution.
//!
//! Parts form a tree: each hangs at its parent by a joint that leaves it six, three or one coordinates. Closures take
//! coordinates away: rods of fixed length between any two parts, coordinates that a point keeps, directions that a part
//! keeps; some of them are driven. With as many closures as coordinates, Newton's method finds the position next to a
//! known one (García de Jalón and Bayo, Kinematic and Dynamic Simulation of Multibody Systems, 1994, ch. 3).

use crate::V3;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3};

/// From the design position in the chassis frame to the present one.
pub(super) type Pose = Isometry3<f64>;

/// How a part hangs at its parent; places and directions are those of the design position.
#[derive(Clone, Copy)]
pub(super) enum Joint {
    /// Nothing but closures holds it; its rotation is counted about `centre`.
    Free {
        centre: V3,
    },
    Ball {
        at: V3,
    },
    Hinge {
        at: V3,
        axis: UnitVector3<f64>,
    },
}

impl Joint {
    fn freedom(self) -> usize {
        match self {
            Self::Free { .. } => 6,
            Self::Ball { .. } => 3,
            Self::Hinge { .. } => 1,
        }
    }
}

#[derive(Clone, Copy)]
struct Part {
    parent: Option<usize>,
    joint: Joint,
    /// Its first coordinate.
    offset: usize,
}

/// A point, by its place in the design position.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    /// Fixed.
    Chassis(V3),
    /// Moved from outside: number of the input, design place.
    Input(usize, V3),
    /// On a part.
    Part(usize, V3),
}

#[derive(Clone, Copy)]
enum Closure {
    Rod {
        a: Anchor,
        b: Anchor,
        length: f64,
    },
    /// The coordinate `axis` of a point is `design` plus the drive of that number.
    Coordinate {
        point: Anchor,
        axis: usize,
        design: f64,
        drive: Option<usize>,
    },
    /// A direction of the part keeps its component along a chassis direction.
    Direction {
        part: usize,
        direction: V3,
        along: V3,
    },
    /// The part has turned about its hinge by the drive of that number.
    Angle {
        part: usize,
        drive: usize,
    },
}

/// Where a point is in the design position.
fn design(anchor: Anchor) -> V3 {
    match anchor {
        Anchor::Chassis(p) | Anchor::Input(_, p) | Anchor::Part(_, p) => p,
    }
}

/// Parts and closures.
#[derive(Clone, Default)]
pub(super) struct Mechanism {
    parts: Vec<Part>,
    closures: Vec<Closure>,
    freedom: usize,
}

/// Rotation of a part about the axis of its hinge, rad, in (−π, π].
pub(super) fn turned(pose: &Pose, axis: &V3) -> f64 {
    2.0 * vb_math::atan2(pose.rotation.imag().dot(axis), pose.rotation.w)
}

impl Mechanism {
    /// Adds a part; parents come first.
    pub(super) fn part(&mut self, parent: Option<usize>, joint: Joint) -> usize {
        self.parts.push(Part { parent, joint, offset: self.freedom });
        self.freedom += joint.freedom();
        self.parts.len() - 1
    }

    /// A rod between two points, as long as it is in the design position.
    pub(super) fn rod(&mut self, a: Anchor, b: Anchor) {
        let length = (design(a) - design(b)).norm();
        self.closures.push(Closure::Rod { a, b, length });
    }

    /// Lets the coordinate `axis` (0 x, 1 y, 2 z) of a point follow a drive, or keep its value.
    pub(super) fn coordinate(&mut self, point: Anchor, axis: usize, drive: Option<usize>) {
        let design = design(point)[axis];
        self.closures.push(Closure::Coordinate { point, axis, design, drive });
    }

    /// Lets a direction of a part keep its component along a direction of the chassis.
    pub(super) fn direction(&mut self, part: usize, direction: V3, along: V3) {
        self.closures.push(Closure::Direction { part, direction, along });
    }

    /// Lets the angle of a part's hinge at the chassis follow a drive.
    pub(super) fn angle(&mut self, part: usize, drive: usize) {
        self.closures.push(Closure::Angle { part, drive });
    }

    /// The design position.
    pub(super) fn start(&self) -> Vec<Pose> {
        vec![Pose::identity(); self.parts.len()]
    }

    fn place(anchor: Anchor, inputs: &[V3], poses: &[Pose]) -> V3 {
        match anchor {
            Anchor::Chassis(p) => p,
            Anchor::Input(i, _) => inputs[i],
            Anchor::Part(b, p) => transform(&poses[b], &p),
        }
    }

    /// Adds n · ∂(point)/∂coordinates to a row of the Jacobian.
    fn gradient(&self, anchor: Anchor, place: &V3, n: &V3, poses: &[Pose], row: &mut [f64]) {
        let Anchor::Part(b, _) = anchor else { return };
        self.chain(b, poses, |offset, kind| match kind {
            Motion::Shift(e) => row[offset] += n.dot(&e),
            Motion::Turn(axis, at) => row[offset] += n.dot(&axis.cross(&(place - at))),
        });
    }

    /// Calls `f` for every coordinate that moves a part.
    fn chain(&self, part: usize, poses: &[Pose], mut f: impl FnMut(usize, Motion)) {
        let mut next = Some(part);
        while let Some(b) = next {
            let p = &self.parts[b];
            let carried = |at: &V3| p.parent.map_or(*at, |q| transform(&poses[q], at));
            let unit = [V3::x(), V3::y(), V3::z()];
            match p.joint {
                Joint::Free { centre } => {
                    let at = transform(&poses[b], &centre);
                    for (k, e) in unit.into_iter().enumerate() {
                        f(p.offset + k, Motion::Shift(e));
                        f(p.offset + 3 + k, Motion::Turn(e, at));
                    }
                }
                Joint::Ball { at } => {
                    for (k, e) in unit.into_iter().enumerate() {
                        f(p.offset + k, Motion::Turn(e, carried(&at)));
                    }
                }
                Joint::Hinge { at, axis } => {
                    let axis = p.parent.map_or(*axis, |q| poses[q].rotation * *axis);
                    f(p.offset, Motion::Turn(axis, carried(&at)));
                }
            }
            next = p.parent;
        }
    }

    /// The position in which the drives have these values and the moved points are at `inputs`, near `from`; none if
    /// there is no such position or it isn't near.
    pub(super) fn solve(&self, drives: &[f64], inputs: &[V3], from: &[Pose]) -> Option<Vec<Pose>> {
        let n = self.freedom;
        debug_assert_eq!(self.closures.len(), n, "as many closures as coordinates");
        let mut poses = from.to_vec();
        let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n]);
        for _ in 0..40 {
            a.fill(0.0);
            let mut size: f64 = 1.0;
            for (k, closure) in self.closures.iter().enumerate() {
                let row = &mut a[k * n..(k + 1) * n];
                b[k] = match *closure {
                    Closure::Rod { a: p, b: q, length } => {
                        let (pp, pq) = (Self::place(p, inputs, &poses), Self::place(q, inputs, &poses));
                        let d = pp - pq;
                        let now = d.norm();
                        let direction = d / now;
                        self.gradient(p, &pp, &direction, &poses, row);
                        self.gradient(q, &pq, &-direction, &poses, row);
                        size = size.max(length);
                        now - length
                    }
                    Closure::Coordinate { point, axis, design, drive } => {
                        let place = Self::place(point, inputs, &poses);
                        let mut e = V3::zeros();
                        e[axis] = 1.0;
                        self.gradient(point, &place, &e, &poses, row);
                        place[axis] - design - drive.map_or(0.0, |i| drives[i])
                    }
                    Closure::Direction { part, direction, along } => {
                        let now = poses[part].rotation * direction;
                        self.chain(part, &poses, |offset, motion| {
                            if let Motion::Turn(axis, _) = motion {
                                row[offset] += along.dot(&axis.cross(&now));
                            }
                        });
                        along.dot(&now) - along.dot(&direction)
                    }
                    Closure::Angle { part, drive } => {
                        let Joint::Hinge { axis, .. } = self.parts[part].joint else { return None };
                        row[self.parts[part].offset] = 1.0;
                        turned(&poses[part], &axis) - drives[drive]
                    }
                };
            }
            if b.iter().all(|r| r.abs() < 1e-13 * size) {
                return Some(poses);
            }
            eliminate(&mut a, &mut b)?;
            // The next position lies near: a larger step leads to a branch beyond a dead centre.
            if b.iter().any(|x| !x.is_finite() || x.abs() > 0.5) {
                return None;
            }
            self.advance(&mut poses, &b);
        }
        None
    }

    /// Moves the parts by −`step`; children are carried along.
    fn advance(&self, poses: &mut [Pose], step: &[f64]) {
        let before = poses.to_vec();
        for (b, part) in self.parts.iter().enumerate() {
            let carried = part.parent.map_or(before[b], |p| poses[p] * (before[p].inverse() * before[b]));
            let of_parent = |at: &V3| part.parent.map_or(*at, |p| transform(&poses[p], at));
            let v = |k: usize| {
                -V3::new(step[part.offset + k], step[part.offset + k + 1], step[part.offset + k + 2])
            };
            let about = |at: V3, turn: V3| {
                let q = UnitQuaternion::from_scaled_axis(turn);
                Pose::from_parts(Translation3::from(at - q * at), q)
            };
            poses[b] = match part.joint {
                Joint::Free { centre } => {
                    let at = transform(&carried, &centre);
                    Translation3::from(v(0)) * about(at, v(3)) * carried
                }
                Joint::Ball { at } => about(of_parent(&at), v(0)) * carried,
                Joint::Hinge { at, axis } => {
                    let axis = part.parent.map_or(*axis, |p| poses[p].rotation * *axis);
                    about(of_parent(&at), axis * -step[part.offset]) * carried
                }
            };
            poses[b].rotation.renormalize();
        }
    }
}

enum Motion {
    Shift(V3),
    Turn(V3, V3),
}

/// Where a pose takes a point of the design position.
pub(super) fn transform(pose: &Pose, p: &V3) -> V3 {
    pose.rotation * p + pose.translation.vector
}

/// Solves a x = b in place by Gaussian elimination with row exchange; `a` by rows.
fn eliminate(a: &mut [f64], b: &mut [f64]) -> Option<()> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs()))?;
        if a[pivot * n + k].abs() < 1e-12 {
            return None;
        }
        if pivot != k {
            for c in 0..n {
                a.swap(k * n + c, pivot * n + c);
            }
            b.swap(k, pivot);
        }
        for i in k + 1..n {
            let f = a[i * n + k] / a[k * n + k];
            if f != 0.0 {
                for c in k..n {
                    a[i * n + c] -= f * a[k * n + c];
                }
                b[i] -= f * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|c| a[k * n + c] * b[c]).sum();
        b[k] = (b[k] - known) / a[k * n + k];
    }
    Some(())
}
