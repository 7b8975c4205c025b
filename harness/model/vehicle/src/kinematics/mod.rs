//! Suspension and steering linkages, solved once into tables over wheel travel and steering command.
//!
//! A linkage is a mechanism of rigid parts with ideal joints and massless rods (`mechanism`). A wheel that is guided
//! independently has one degree of freedom beside steering, its travel: the rise of its centre (`corner`). A beam
//! between two wheels has two, the rise of either end (`beam`). Newton's method solves the mechanism going outwards from
//! the design position. What the equations of motion need comes from the tables by splines over travel and straight
//! lines over the command, with derivatives of the very interpolant (`table`). The steering gear is solved first,
//! into places of the joints that it moves (`steering`).

mod beam;
mod corner;
mod force;
mod mechanism;
mod sample;
mod steering;
mod table;
#[cfg(test)]
mod tests;

use crate::V3;
use crate::{Axle, suspension::Linkage};
pub use beam::{BeamAxle, BeamPose, BeamWheel};
pub use force::{Element, elements};
use nalgebra::UnitVector3;
pub use sample::{Motion, SteeringAxis, WheelSample};
use std::sync::Arc;
pub use table::CornerTable;
pub use table::WheelPose;

/// A side of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The left side, where y > 0.
    Left,
    /// The right side, where y < 0.
    Right,
}

impl Side {
    /// The index of the side: 0 for the left, 1 for the right.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self == Self::Right)
    }

    /// The sign of y on this side: 1 for the left, −1 for the right.
    #[must_use]
    pub fn sign(self) -> f64 {
        if self == Self::Left { 1.0 } else { -1.0 }
    }
}

/// The reason why a linkage can't be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkageError {
    /// The linkage of a wheel locks before the end of its range.
    #[error(
        "the linkage does not close at travel {travel:.3} m, steering command {command:.2}; \
         correct its points or narrow the range"
    )]
    Locked {
        /// The travel at which it locks, m, compression positive.
        travel: f64,
        /// The steering command at which it locks, in [-1, 1].
        command: f64,
    },
    /// The rods of a beam lock before the end of its range.
    #[error(
        "the beam's rods do not close at travels {:.3} m left, {:.3} m right; correct their points or narrow the range",
        travels[0], travels[1]
    )]
    BeamLocked {
        /// The travels of the left and the right wheel at which they lock, m, compression positive.
        travels: [f64; 2],
    },
    /// The steering gear locks before the end of its range.
    #[error(
        "the steering gear does not close at command {command:.2}; correct its points or reduce its angle"
    )]
    SteeringLocked {
        /// The steering command at which it locks, in [-1, 1].
        command: f64,
    },
    /// The drag link, the tie rods and the knuckles of a beam lock before the end of their range.
    #[error(
        "the steering of the beam does not close at command {command:.2}, travels {:.3} m left, {:.3} m right; \
         correct its points, reduce the gear's travel or narrow the range",
        travels[0], travels[1]
    )]
    KnucklesLocked {
        /// The travels of the left and the right wheel at which they lock, m, compression positive.
        travels: [f64; 2],
        /// The steering command at which they lock, in [-1, 1].
        command: f64,
    },
    /// A strut does not shorten as the wheel rises, so that its spring would push the wheel up.
    #[error(
        "struts[{strut}] does not shorten in compression at travel {travel:.3} m; correct its ends or narrow the range"
    )]
    Lengthens {
        /// The number of the strut.
        strut: usize,
        /// The travel at which it does so, m, compression positive.
        travel: f64,
    },
}

/// The solved linkage of an axle.
#[derive(Clone, Debug)]
pub struct AxleKinematics {
    guide: Guide,
}

#[derive(Clone, Debug)]
enum Guide {
    /// Left and right.
    Independent([Arc<CornerTable>; 2]),
    Beam(Arc<BeamAxle>),
}

/// A point's mirror image for the right side (−1); for the left (1) the point.
fn mirror(p: V3, side: f64) -> V3 {
    V3::new(p.x, side * p.y, p.z)
}

fn unit(v: V3) -> UnitVector3<f64> {
    UnitVector3::new_normalize(v)
}

impl AxleKinematics {
    /// Solves the linkage of an axle for all travels and, if the axle is steered, for all commands.
    ///
    /// # Errors
    /// Returns an error where the linkage or its steering doesn't close, or where a strut would work the wrong way.
    pub fn solve(axle: &Axle) -> Result<Self, LinkageError> {
        let suspension = &axle.suspension;
        let linkage = &suspension.linkage;
        if linkage.beam().is_some() {
            let inner = linkage.knuckles().map(|k| V3::from(k.drag_link_inner));
            let joints = match (&axle.steering, inner) {
                (Some(gear), Some(p)) => {
                    Some(steering::joints(gear, &[p])?.iter().map(|p| p[0]).collect::<Vec<_>>())
                }
                (None, Some(p)) => Some(vec![p]),
                _ => None,
            };
            let beam = BeamAxle::solve(suspension, joints.as_deref())?;
            return Ok(Self { guide: Guide::Beam(Arc::new(beam)) });
        }
        let (left, right) = match (&axle.steering, linkage.tie_rod_inner()) {
            (Some(gear), Some(p)) => {
                let p = V3::from(p);
                let places = steering::joints(gear, &[p, mirror(p, -1.0)])?;
                let joints = |i: usize| places.iter().map(|p| Some(p[i])).collect::<Vec<_>>();
                let left = corner::solve(suspension, &joints(0), 1.0)?;
                // A gear that is its own mirror image spares half the work.
                let symmetric =
                    places.iter().zip(places.iter().rev()).all(|(p, q)| p[0] == mirror(q[1], -1.0));
                let right =
                    if symmetric { left.mirrored() } else { corner::solve(suspension, &joints(1), -1.0)? };
                (left, right)
            }
            _ => {
                let left = corner::solve(suspension, &[None], 1.0)?;
                let right = left.mirrored();
                (left, right)
            }
        };
        Ok(Self { guide: Guide::Independent([Arc::new(left), Arc::new(right)]) })
    }

    /// The pose of a wheel at the travels of the axle's left and right wheel (m, compression positive) and at a
    /// steering command in [-1, 1]. Its rates are over the wheel's own travel. The pose of a wheel that is guided
    /// independently doesn't depend on the other's travel. Beyond the tabulated travels an independent wheel keeps its
    /// direction, and a beam's pose goes on in a straight line.
    #[must_use]
    pub fn wheel(&self, side: Side, travels: [f64; 2], command: f64) -> WheelPose {
        let i = side.index();
        match &self.guide {
            Guide::Independent(tables) => tables[i].at(travels[i], command),
            Guide::Beam(beam) => {
                let mut own = [0.0; 2];
                own[i] = 1.0;
                let w = &beam.at(travels, own, command).wheels[i];
                WheelPose {
                    hub: w.hub,
                    hub_rate: w.hub_rates[i],
                    hub_curvature: w.bend,
                    hub_steer_rate: w.hub_steer_rate,
                    steer_tilt_rate: w.steer_tilt_rate,
                    axis: w.axis,
                    tilt_rate: w.tilt_rates[i],
                    struts: w.struts,
                    strut_rates: [w.strut_rates[0][i], w.strut_rates[1][i]],
                    bar: travels[i],
                    bar_rate: 1.0,
                }
            }
        }
    }

    /// The table of a wheel that is guided independently; `None` for a wheel on a beam.
    #[must_use]
    pub fn corner(&self, side: Side) -> Option<Arc<CornerTable>> {
        match &self.guide {
            Guide::Independent(tables) => Some(tables[side.index()].clone()),
            Guide::Beam(_) => None,
        }
    }

    /// The beam of a solid axle; `None` for other axles.
    #[must_use]
    pub fn beam(&self) -> Option<Arc<BeamAxle>> {
        match &self.guide {
            Guide::Beam(beam) => Some(beam.clone()),
            Guide::Independent(_) => None,
        }
    }
}

/// Tells whether the wheels of a linkage can move.
#[must_use]
pub fn moves(linkage: &Linkage) -> bool {
    !matches!(linkage, Linkage::Rigid(_))
}
