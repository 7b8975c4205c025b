//! The names of a vehicle's parts, and how they lie: for tables and drawings.

use crate::Point;
use crate::powertrain::Differential;
use crate::suspension::{Linkage, SteeringGear};

impl Linkage {
    /// The name that people give to the linkage.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::DoubleWishbone(_) => "double wishbone",
            Self::SingleWishbone(_) => "single wishbone",
            Self::Multilink(_) => "five rods",
            Self::TorsionArm(_) => "torsion arm",
            Self::SolidAxle(_) => "solid axle on rods",
            Self::LeafAxle(_) => "solid axle on leaf springs",
            Self::PivotAxle(_) => "pivoting axle",
            Self::Rigid(_) => "rigid",
        }
    }

    /// The rods of the linkage, each from the chassis to what carries the wheel: those of the left side, at design
    /// height, relative to the axle's reference point, m.
    #[must_use]
    pub fn rods(&self) -> Vec<[Point; 2]> {
        match self {
            Self::DoubleWishbone(l) => vec![
                [l.upper_arm_front, l.upper_ball_joint],
                [l.upper_arm_rear, l.upper_ball_joint],
                [l.lower_arm_front, l.lower_ball_joint],
                [l.lower_arm_rear, l.lower_ball_joint],
                [l.tie_rod_inner, l.tie_rod_outer],
            ],
            Self::SingleWishbone(l) => vec![
                [l.arm_front, l.kingpin_lower],
                [l.arm_rear, l.kingpin_lower],
                [l.tie_rod_inner, l.tie_rod_outer],
            ],
            Self::Multilink(l) => {
                let rods = l.links.iter().map(|r| [r.chassis, r.carrier]);
                rods.chain([[l.tie_rod_inner, l.tie_rod_outer]]).collect()
            }
            Self::TorsionArm(l) => vec![[l.pivot, l.spindle]],
            Self::SolidAxle(l) => {
                let rods = l.links.iter().chain(&l.single_links).map(|r| [r.chassis, r.carrier]);
                rods.chain([beam(l.spindle)]).collect()
            }
            Self::LeafAxle(l) => vec![[l.eye, l.seat], beam(l.spindle)],
            Self::PivotAxle(l) => vec![beam(l.spindle)],
            Self::Rigid(l) => vec![beam(l.spindle)],
        }
    }
}

/// From the middle of an axle to its left wheel.
fn beam(spindle: Point) -> [Point; 2] {
    [[spindle[0], 0.0, spindle[2]], spindle]
}

impl SteeringGear {
    /// The name that people give to the steering gear.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::RackAndPinion { .. } => "rack and pinion",
            Self::PitmanArm { .. } => "pitman arm",
            Self::RotaryArm { .. } => "rotary arm and drag link",
        }
    }
}

impl Differential {
    /// The name that people give to the differential.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Open {} => "open",
            Self::Clutch { .. } => "clutch",
            Self::LimitedSlip { .. } => "limited slip",
            Self::Locked {} => "locked",
        }
    }
}
