//! The tables as numbers for plots and checks.

use super::WheelPose;
use super::{AxleKinematics, Side, elements};
use crate::V3;
use crate::suspension::{AntiRoll, Linkage, Suspension};
use vb_math::{asin, atan2};

/// How the two wheels of an axle move while it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Both alike: heave.
    Parallel,
    /// One up, the other as far down: roll.
    Opposite,
}

/// A wheel at one travel and steering command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelSample {
    /// Its side.
    pub side: Side,
    /// m, compression positive.
    pub travel: f64,
    /// In [-1, 1].
    pub command: f64,
    /// Wheel centre in the chassis frame, relative to the axle's reference point, m.
    pub hub: V3,
    /// Angle of the wheel's plane from straight ahead, positive to the left, rad.
    pub toe: f64,
    /// Tilt of the wheel's plane, positive with the top away from the vehicle, rad.
    pub camber: f64,
    /// Lengths of the struts, m; for a torsion bar the arm's angle, rad, taken negative. 0 for a missing one.
    pub struts: [f64; 2],
    /// How much a strut shortens as the wheel rises in this motion, m/m (rad/m for a torsion bar).
    pub motion_ratios: [f64; 2],
    /// Force with which springs, stops and the anti-roll bar push the wheel down, N: what carries the vehicle. In
    /// opposite motion half the difference between the two wheels, which is what resists roll.
    pub force: f64,
    /// Change of that force over travel in this motion, N/m.
    pub wheel_rate: f64,
}

/// Steering axis of a wheel in the design position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringAxis {
    /// Tilt to the rear at the top, rad.
    pub caster: f64,
    /// Tilt to the vehicle's middle at the top, rad.
    pub inclination: f64,
}

impl Suspension {
    /// The axis about which the left wheel is steered, where the linkage has one in a part of its own.
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
    /// Both wheels over `travels` values of the range and `commands` values in [-1, 1] (one: straight ahead); left
    /// before right, then by command, then by travel. `suspension` is the one that was solved.
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
