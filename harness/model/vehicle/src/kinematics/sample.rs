//! The tables of linkages as numbers, for plots and checks.

use super::WheelPose;
use super::{AxleKinematics, Side, elements};
use crate::V3;
use crate::suspension::{AntiRoll, Linkage, Suspension};
use vb_math::{asin, atan2};

/// The way in which the two wheels of an axle move while it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Both wheels move alike: heave.
    Parallel,
    /// One wheel moves up and the other as far down: roll.
    Opposite,
}

/// A wheel at one travel and one steering command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelSample {
    /// The side of the vehicle on which the wheel is.
    pub side: Side,
    /// The travel, m, compression positive.
    pub travel: f64,
    /// The steering command, in [-1, 1], positive to the left.
    pub command: f64,
    /// The wheel's centre in the chassis frame, relative to the axle's reference point, m.
    pub hub: V3,
    /// The angle of the wheel's plane from straight ahead, positive to the left, rad.
    pub toe: f64,
    /// The tilt of the wheel's plane, positive with the top away from the vehicle, rad.
    pub camber: f64,
    /// The lengths of the struts, m; for a torsion bar the arm's angle, rad, taken negative. The length of a missing
    /// strut is 0.
    pub struts: [f64; 2],
    /// The shortening of each strut per rise of the wheel in this motion, m/m (rad/m for a torsion bar).
    pub motion_ratios: [f64; 2],
    /// The force with which springs, stops and the anti-roll bar push the wheel down, N: the force that carries the
    /// vehicle. In opposite motion it is half the difference between the two wheels, which resists the roll.
    pub force: f64,
    /// The change of that force over the travel in this motion, N/m.
    pub wheel_rate: f64,
}

/// The steering axis of a left wheel in the design position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringAxis {
    /// The tilt of the axis to the rear at its top, rad.
    pub caster: f64,
    /// The tilt of the axis towards the vehicle's middle at its top, rad.
    pub inclination: f64,
}

impl Suspension {
    /// The axis about which the left wheel is steered; `None` where no part of the linkage has such an axis.
    #[must_use]
    pub fn steering_axis(&self) -> Option<SteeringAxis> {
        let (lower, upper) = match &self.linkage {
            Linkage::DoubleWishbone(l) => (l.lower_ball_joint, l.upper_ball_joint),
            Linkage::SingleWishbone(l) => (l.kingpin_lower, l.kingpin_upper),
            linkage => linkage.knuckles().map(|k| (k.kingpin_lower, k.kingpin_upper))?,
        };
        let up = V3::from(upper) - V3::from(lower);
        let up = up * up.z.signum();
        Some(SteeringAxis { caster: atan2(-up.x, up.z), inclination: atan2(-up.y, up.z) })
    }
}

impl AxleKinematics {
    /// Samples both wheels at `travels` values over the suspension's range and at `commands` values over [-1, 1]; one
    /// value alone means travel 0 or straight ahead. The samples of the left wheel come before those of the right one;
    /// within a side they are ordered by command, then by travel. `suspension` must be the one that was solved.
    #[must_use]
    pub fn sample(
        &self,
        suspension: &Suspension,
        motion: Motion,
        travels: usize,
        commands: usize,
    ) -> Vec<WheelSample> {
        let [low, high] = suspension.range;
        let at = |k: usize, count: usize, a: f64, b: f64| {
            if count > 1 { a + (b - a) * k as f64 / (count - 1) as f64 } else { 0.0 }
        };
        let mut samples = Vec::with_capacity(2 * travels * commands);
        for side in [Side::Left, Side::Right] {
            for c in 0..commands {
                let command = at(c, commands, -1.0, 1.0);
                samples.extend(
                    (0..travels).map(|t| {
                        self.sample_at(suspension, motion, side, at(t, travels, low, high), command)
                    }),
                );
            }
        }
        samples
    }

    fn sample_at(
        &self,
        suspension: &Suspension,
        motion: Motion,
        side: Side,
        travel: f64,
        command: f64,
    ) -> WheelSample {
        let both = |travel: f64| {
            let other = if motion == Motion::Parallel { travel } else { -travel };
            if side == Side::Left { [travel, other] } else { [other, travel] }
        };
        let elements = elements(suspension);
        // Virtual work of both wheels in this motion, half of it a wheel's: a beam's struts feel both travels.
        let force = |travel: f64| {
            let h = 1e-6;
            let work = |s: Side| {
                let pose = |travel: f64| self.wheel(s, both(travel), command);
                let (a, b, now) = (pose(travel - h), pose(travel + h), pose(travel));
                let shortens =
                    |a: &WheelPose, b: &WheelPose, k: usize| (a.struts[k] - b.struts[k]) / (2.0 * h);
                let struts: f64 = elements
                    .iter()
                    .enumerate()
                    .map(|(k, e)| e.force(now.struts[k]) * shortens(&a, &b, k))
                    .sum();
                let own = both(travel)[s.index()];
                let sense = if motion == Motion::Opposite && s != side { -1.0 } else { 1.0 };
                struts + suspension.stops.as_ref().map_or(0.0, |x| x.force(own) * sense)
            };
            let twist = |travel: f64| {
                self.wheel(Side::Left, both(travel), command).bar
                    - self.wheel(Side::Right, both(travel), command).bar
            };
            let stiffness = match suspension.anti_roll {
                Some(AntiRoll::Travel { stiffness } | AntiRoll::Bar { stiffness, .. }) => stiffness,
                None => 0.0,
            };
            let bar = stiffness * twist(travel) * (twist(travel + h) - twist(travel - h)) / (2.0 * h);
            // In parallel motion the two wheels are alike but for steering; in roll they push against each other, so
            // each wheel's own springs are told, and the difference is the bar's.
            match motion {
                Motion::Parallel => work(side) + 0.5 * bar,
                Motion::Opposite => {
                    let other = if side == Side::Left { Side::Right } else { Side::Left };
                    0.5 * (work(side) + work(other) + bar)
                }
            }
        };
        let h = 1e-5;
        let pose = self.wheel(side, both(travel), command);
        let (a, b) =
            (self.wheel(side, both(travel - h), command), self.wheel(side, both(travel + h), command));
        WheelSample {
            side,
            travel,
            command,
            hub: pose.hub,
            toe: atan2(-pose.axis.x, pose.axis.y),
            camber: -side.sign() * asin(pose.axis.z),
            struts: pose.struts,
            motion_ratios: [0, 1].map(|k| (a.struts[k] - b.struts[k]) / (2.0 * h)),
            force: force(travel),
            wheel_rate: (force(travel + h) - force(travel - h)) / (2.0 * h),
        }
    }
}
