//! Suspension and steering as data. All points are of the left side, at design height, relative to the axle's
//! reference point, chassis axes, m; the right side is their mirror image.

use crate::Point;
use serde::{Deserialize, Serialize};

/// How the wheels of an axle are guided and sprung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suspension {
    /// What guides the wheels.
    pub linkage: Linkage,
    /// Lowest and highest travel for which the linkage is solved, m, around 0; not for rigid mounts. The stops belong
    /// inside: beyond it a wheel keeps its direction and its struts go on at their last rate.
    #[serde(default)]
    pub range: [f64; 2],
    /// Springs and dampers, at most two lines of action a wheel.
    #[serde(default)]
    pub struts: Vec<Strut>,
    /// At the ends of the wheel's travel.
    #[serde(default)]
    pub stops: Option<Stops>,
    /// Between the two wheels.
    #[serde(default)]
    pub anti_roll: Option<AntiRoll>,
}

/// What guides the wheels of an axle: ideal joints, massless links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Linkage {
    /// Two A-arms with ball joints at the upright, and a tie rod.
    DoubleWishbone(DoubleWishbone),
    /// One A-arm on which the upright turns about its kingpin, held by a tie rod.
    SingleWishbone(SingleWishbone),
    /// Five rods to the upright, one of which is the tie rod.
    Multilink(Multilink),
    /// One arm that turns about an axis fixed to the chassis and carries the wheel: trailing, semi-trailing and swing
    /// arms, with a torsion bar or a strut.
    TorsionArm(TorsionArm),
    /// A rigid beam between two wheels on rods: three-link (triangle and two rods), four-link, rods and Panhard rod.
    SolidAxle(SolidAxle),
    /// A rigid beam between two wheels on leaf springs.
    LeafAxle(LeafAxle),
    /// A rigid beam between two wheels that turns about a longitudinal pin at the chassis and can't rise: an axle that
    /// gives way to the ground but doesn't spring.
    PivotAxle(PivotAxle),
    /// The wheels are fixed to the chassis.
    Rigid(RigidMount),
}

/// Joints of a double wishbone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct DoubleWishbone {
    pub spindle: Point,
    pub upper_arm_front: Point,
    pub upper_arm_rear: Point,
    pub upper_ball_joint: Point,
    pub lower_arm_front: Point,
    pub lower_arm_rear: Point,
    pub lower_ball_joint: Point,
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// Joints of a single wishbone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct SingleWishbone {
    pub spindle: Point,
    pub arm_front: Point,
    pub arm_rear: Point,
    /// Two points of the line about which the upright turns on the arm.
    pub kingpin_lower: Point,
    pub kingpin_upper: Point,
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// A rod with a ball joint at each end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// End on the chassis.
    pub chassis: Point,
    /// End on the upright or the beam.
    pub carrier: Point,
}

/// Joints of a five-link suspension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct Multilink {
    pub spindle: Point,
    /// Four rods beside the tie rod.
    pub links: [Rod; 4],
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// An arm that carries the wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorsionArm {
    /// Wheel centre.
    pub spindle: Point,
    /// A point of the axis about which the arm turns.
    pub pivot: Point,
    /// Direction of that axis; [0, 1, 0] is a trailing or leading arm.
    pub axis: Point,
    /// Torsion bar in the axis.
    #[serde(default)]
    pub torsion: Option<Torsion>,
}

/// A torsion bar at an arm: torque = preload + stiffness · angle + damping · rate, pushing the wheel down, with the
/// angle of the arm from the design position, positive in compression.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torsion {
    /// N m/rad.
    pub stiffness: f64,
    /// N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// N m at design height.
    #[serde(default)]
    pub preload: f64,
}

/// Joints of a rigid beam on rods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidAxle {
    /// Wheel centre.
    pub spindle: Point,
    /// The beam's mass.
    pub beam: Beam,
    /// Rods that exist at both sides. An A-arm or triangle with its tip on the beam is a pair of rods that meet on the
    /// centre line. Twice their number and the unpaired rods must make four.
    pub links: Vec<Rod>,
    /// Rods that exist once, such as a Panhard rod.
    #[serde(default)]
    pub single_links: Vec<Rod>,
    /// For a steered axle.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// A rigid beam on leaf springs that locate it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeafAxle {
    /// Wheel centre.
    pub spindle: Point,
    /// The beam's mass.
    pub beam: Beam,
    /// Where the leaf spring is clamped to the beam.
    pub seat: Point,
    /// The spring's fixed eye at the chassis.
    pub eye: Point,
    /// For a steered axle.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// A rigid beam on a pin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PivotAxle {
    /// Wheel centre.
    pub spindle: Point,
    /// The beam's mass.
    pub beam: Beam,
    /// Height of the pin, m.
    pub pin_height: f64,
    /// For a steered axle.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// What a beam weighs, beside the unsprung masses of its two wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// kg.
    pub mass: f64,
    /// Moment of inertia about its middle, for roll and yaw, kg m².
    pub inertia: f64,
}

/// Steering knuckles of a beam, which turn about kingpins, and what turns them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Knuckles {
    /// Two points of the kingpin's line.
    pub kingpin_lower: Point,
    /// The upper one.
    pub kingpin_upper: Point,
    /// End of the tie rod on the knuckle.
    pub tie_rod: Point,
    /// The drag link's end at the steering gear, as it stands: not mirrored.
    pub drag_link_inner: Point,
    /// How the drag link moves the knuckles.
    pub by: KnuckleDrive,
}

/// How a drag link moves the knuckles of a beam. Points as they stand: not mirrored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum KnuckleDrive {
    /// The drag link turns the left knuckle; a bar between the knuckles' arms takes the right one along.
    Toebar {
        /// End of the drag link on the left knuckle.
        drag_link_outer: Point,
    },
    /// The drag link turns a bellcrank on the beam, from which a tie rod goes to each knuckle.
    Bellcrank {
        /// Where it turns.
        pivot: Point,
        /// Direction of its axis.
        axis: Point,
        /// End of the drag link on it.
        drag_link_outer: Point,
        /// End of the left knuckle's tie rod on it.
        tie_rod_left: Point,
        /// End of the right knuckle's tie rod on it.
        tie_rod_right: Point,
    },
}

/// Wheels without suspension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidMount {
    /// Wheel centre.
    pub spindle: Point,
}

/// A line between chassis and linkage along which a spring, a damper and stops act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strut {
    /// End on the chassis.
    pub chassis: Point,
    /// End on `part`.
    pub end: Point,
    /// The part that moves this end.
    pub part: Part,
    /// Spring along it.
    #[serde(default)]
    pub spring: Option<Spring>,
    /// Damper along it.
    #[serde(default)]
    pub damper: Option<Damper>,
    /// Stops along it.
    #[serde(default)]
    pub stops: Option<StrutStops>,
}

/// A moving part of a linkage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// What carries the wheel.
    Upright,
    /// The lower wishbone, the single wishbone or the torsion arm.
    Arm,
    /// The beam of a solid axle.
    Beam,
}

/// Force of a spring over its compression e = free length − length; in tension too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Spring {
    /// preload + stiffness · e.
    Linear {
        /// N/m.
        stiffness: f64,
        /// m.
        free_length: f64,
        /// N at the free length.
        #[serde(default)]
        preload: f64,
    },
    /// stiffness · e + progression · e·|e| (the springs of Chrono's MAN trucks, chrono_models/vehicle/man).
    Progressive {
        /// N/m.
        stiffness: f64,
        /// N/m².
        progression: f64,
        /// m.
        free_length: f64,
    },
    /// Straight lines between points, and on beyond the last ones.
    Table {
        /// m.
        free_length: f64,
        /// Compression, m, and force, N; compressions increase.
        points: Vec<[f64; 2]>,
    },
}

/// Force of a damper over the rate v at which it is compressed (v > 0) or extended (v < 0), against the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Damper {
    /// coefficient · v.
    Linear {
        /// N s/m.
        coefficient: f64,
    },
    /// One coefficient for each direction.
    Bilinear {
        /// N s/m.
        compression: f64,
        /// N s/m.
        rebound: f64,
    },
    /// c·v / (1 + n·|v|) with c and n for each direction (the dampers of Chrono's MAN trucks, chrono_models/vehicle/man).
    Degressive {
        /// c, N s/m.
        compression: f64,
        /// n, s/m.
        compression_degression: f64,
        /// c, N s/m.
        rebound: f64,
        /// n, s/m.
        rebound_degression: f64,
    },
    /// Straight lines between points, and on beyond the last ones.
    Table {
        /// Rate of compression, m/s, and force, N, of the same sign; rates increase; [0, 0] is one of them.
        points: Vec<[f64; 2]>,
    },
}

/// Stops along a strut: stiffness and table add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrutStops {
    /// Length below which it is pushed apart, m.
    pub shortest: f64,
    /// Length above which it is pulled together, m.
    pub longest: f64,
    /// N/m.
    #[serde(default)]
    pub stiffness: f64,
    /// Depth into the stop, m, and force, N; straight lines between, and on beyond the last point.
    #[serde(default)]
    pub table: Vec<[f64; 2]>,
}

/// Stops that act on the wheel beyond these travels; stiffness and table add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stops {
    /// Compression at which the upper stop is met, m, > 0.
    pub jounce: f64,
    /// Travel at which the lower stop is met, m, < 0.
    pub rebound: f64,
    /// N/m at the wheel.
    #[serde(default)]
    pub stiffness: f64,
    /// Depth into the stop, m, and force, N; straight lines between, and on beyond the last point.
    #[serde(default)]
    pub table: Vec<[f64; 2]>,
}

/// What couples the two wheels of an axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum AntiRoll {
    /// A force at each wheel, in proportion to the difference of their travels.
    Travel {
        /// N/m: force on each wheel over left travel less right travel.
        stiffness: f64,
    },
    /// A torsion bar with an arm at each end and a drop link from each arm to the linkage.
    Bar {
        /// N m/rad.
        stiffness: f64,
        /// N m s/rad.
        #[serde(default)]
        damping: f64,
        /// A point of the bar's axis, which points to the left.
        pivot: Point,
        /// Upper end of the drop link, on the bar's arm.
        arm_end: Point,
        /// Lower end of the drop link, on `part`.
        link_end: Point,
        /// The part that moves it.
        part: Part,
    },
}

/// The driver's steering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steering {
    /// Greatest rate of the command, 1/s.
    pub rate: f64,
    /// What the command moves.
    #[serde(default)]
    pub by: SteeredBy,
}

/// What a steering command moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SteeredBy {
    /// The steering gears of the axles that have one.
    #[default]
    Wheels,
    /// The driveline, which drives the two sides at different speeds (tracked vehicles); no axle has a steering gear.
    Differential,
}

/// The steering gear of an axle, which moves the inner joints of its tie rods or of its drag link. Points as they
/// stand: not mirrored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum SteeringGear {
    /// A rack moves the joints sideways.
    RackAndPinion {
        /// Travel to the right at command +1, m.
        travel: f64,
    },
    /// An arm and an idler arm carry the link with the joints: a four-bar linkage.
    PitmanArm {
        /// Where the arm turns.
        pivot: Point,
        /// Joint of arm and link.
        arm_end: Point,
        /// Where the idler arm turns.
        idler_pivot: Point,
        /// Joint of idler arm and link.
        idler_end: Point,
        /// Direction of all four joints.
        #[serde(default = "up")]
        axis: Point,
        /// Angle at command +1, clockwise seen against the axis (from above if it points up), rad.
        angle: f64,
    },
    /// The joints sit on an arm.
    RotaryArm {
        /// Where the arm turns.
        pivot: Point,
        /// Direction of its axis.
        #[serde(default = "up")]
        axis: Point,
        /// Angle at command +1, clockwise seen against the axis (from above if it points up), rad.
        angle: f64,
    },
}

fn up() -> Point {
    [0.0, 0.0, 1.0]
}

impl Linkage {
    /// Centre of the left wheel at design height, m.
    #[must_use]
    pub fn spindle(&self) -> Point {
        match self {
            Self::DoubleWishbone(l) => l.spindle,
            Self::SingleWishbone(l) => l.spindle,
            Self::Multilink(l) => l.spindle,
            Self::TorsionArm(l) => l.spindle,
            Self::SolidAxle(l) => l.spindle,
            Self::LeafAxle(l) => l.spindle,
            Self::PivotAxle(l) => l.spindle,
            Self::Rigid(l) => l.spindle,
        }
    }

    /// The beam, if the wheels share one.
    #[must_use]
    pub fn beam(&self) -> Option<Beam> {
        match self {
            Self::SolidAxle(l) => Some(l.beam),
            Self::LeafAxle(l) => Some(l.beam),
            Self::PivotAxle(l) => Some(l.beam),
            _ => None,
        }
    }

    /// The steering knuckles, if the wheels share a beam and are steered.
    #[must_use]
    pub fn knuckles(&self) -> Option<&Knuckles> {
        match self {
            Self::SolidAxle(l) => l.knuckles.as_ref(),
            Self::LeafAxle(l) => l.knuckles.as_ref(),
            Self::PivotAxle(l) => l.knuckles.as_ref(),
            _ => None,
        }
    }

    /// Inner joint of the left tie rod, where each wheel has its own.
    #[must_use]
    pub fn tie_rod_inner(&self) -> Option<Point> {
        match self {
            Self::DoubleWishbone(l) => Some(l.tie_rod_inner),
            Self::SingleWishbone(l) => Some(l.tie_rod_inner),
            Self::Multilink(l) => Some(l.tie_rod_inner),
            _ => None,
        }
    }

    /// The torsion bar of an arm.
    #[must_use]
    pub fn torsion(&self) -> Option<Torsion> {
        match self {
            Self::TorsionArm(l) => l.torsion,
            _ => None,
        }
    }
}
