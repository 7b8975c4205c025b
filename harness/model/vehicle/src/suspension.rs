//! Suspension and steering as data. All points are those of the left side, at design height, relative to the axle's
//! reference point, in chassis axes (x forward, y left, z up), m. The right side is their mirror image.

use crate::Point;
use crate::table::{interpolate, slope_within};
use serde::{Deserialize, Serialize};

/// The guidance and the springing of the wheels of an axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suspension {
    /// The linkage that guides the wheels.
    pub linkage: Linkage,
    /// The lowest and the highest travel for which the linkage is solved, m, around 0; unused by rigid mounts. The
    /// stops belong inside this range: beyond it a wheel keeps its direction and its struts go on at their last rate.
    #[serde(default)]
    pub range: [f64; 2],
    /// The springs and dampers, along two lines of action for each wheel at most.
    #[serde(default)]
    pub struts: Vec<Strut>,
    /// The stops at the ends of the wheel's travel.
    #[serde(default)]
    pub stops: Option<Stops>,
    /// The coupling between the two wheels.
    #[serde(default)]
    pub anti_roll: Option<AntiRoll>,
}

/// The linkage that guides the wheels of an axle, with ideal joints and massless links.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Linkage {
    /// Two A-arms with ball joints at the upright, and a tie rod, guide each wheel.
    DoubleWishbone(DoubleWishbone),
    /// One A-arm on which the upright turns about its kingpin, and which a tie rod holds, guides each wheel.
    SingleWishbone(SingleWishbone),
    /// Five rods to the upright, one of which is the tie rod, guide each wheel.
    Multilink(Multilink),
    /// One arm that turns about an axis fixed to the chassis carries the wheel: trailing, semi-trailing and swing arms,
    /// with a torsion bar or a strut.
    TorsionArm(TorsionArm),
    /// A rigid beam between two wheels hangs on rods: three-link (triangle and two rods), four-link, rods and Panhard
    /// rod.
    SolidAxle(SolidAxle),
    /// A rigid beam between two wheels hangs on leaf springs.
    LeafAxle(LeafAxle),
    /// A rigid beam between two wheels turns about a longitudinal pin at the chassis and can't rise: an axle that gives
    /// way to the ground but doesn't spring.
    PivotAxle(PivotAxle),
    /// The wheels are fixed to the chassis.
    Rigid(RigidMount),
}

/// The joints of a double wishbone.
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

/// The joints of a single wishbone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct SingleWishbone {
    pub spindle: Point,
    pub arm_front: Point,
    pub arm_rear: Point,
    /// The lower of two points of the line about which the upright turns on the arm.
    pub kingpin_lower: Point,
    pub kingpin_upper: Point,
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// A rod with a ball joint at each end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// The end on the chassis.
    pub chassis: Point,
    /// The end on the upright or the beam.
    pub carrier: Point,
}

/// The joints of a five-link suspension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the names are the documentation: joints of the linkage")]
pub struct Multilink {
    pub spindle: Point,
    /// The four rods in addition to the tie rod.
    pub links: [Rod; 4],
    pub tie_rod_inner: Point,
    pub tie_rod_outer: Point,
}

/// An arm that carries the wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorsionArm {
    /// The wheel's centre.
    pub spindle: Point,
    /// A point of the axis about which the arm turns.
    pub pivot: Point,
    /// The direction of that axis; [0, 1, 0] is that of a trailing or leading arm.
    pub axis: Point,
    /// The torsion bar in the axis, if there is one.
    #[serde(default)]
    pub torsion: Option<Torsion>,
}

/// A torsion bar at an arm. Its torque is preload + stiffness · angle + damping · rate and pushes the wheel down; the
/// angle is that of the arm from the design position, positive in compression.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torsion {
    /// The stiffness, N m/rad.
    pub stiffness: f64,
    /// The damping, N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// The torque at design height, N m.
    #[serde(default)]
    pub preload: f64,
}

/// The joints of a rigid beam on rods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidAxle {
    /// The left wheel's centre.
    pub spindle: Point,
    /// The mass of the beam.
    pub beam: Beam,
    /// The rods that exist at both sides. An A-arm or triangle with its tip on the beam is a pair of rods that meet on
    /// the centre line. Twice the number of these rods and the number of unpaired ones must add up to four.
    pub links: Vec<Rod>,
    /// The rods that exist once, such as a Panhard rod.
    #[serde(default)]
    pub single_links: Vec<Rod>,
    /// The steering knuckles, if the axle is steered.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// A rigid beam on leaf springs that locate it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeafAxle {
    /// The left wheel's centre.
    pub spindle: Point,
    /// The mass of the beam.
    pub beam: Beam,
    /// The point at which the leaf spring is clamped to the beam.
    pub seat: Point,
    /// The spring's fixed eye at the chassis.
    pub eye: Point,
    /// The steering knuckles, if the axle is steered.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// A rigid beam that turns about a pin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PivotAxle {
    /// The left wheel's centre.
    pub spindle: Point,
    /// The mass of the beam.
    pub beam: Beam,
    /// The height of the pin, m.
    pub pin_height: f64,
    /// The steering knuckles, if the axle is steered.
    #[serde(default)]
    pub knuckles: Option<Knuckles>,
}

/// The mass and the inertia of a beam, without the unsprung masses of its two wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// The mass, kg.
    pub mass: f64,
    /// The moment of inertia about the beam's middle, for roll and yaw, kg m².
    pub inertia: f64,
}

/// The steering knuckles of a beam, which turn about kingpins, and what turns them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Knuckles {
    /// The lower of two points of the kingpin's line.
    pub kingpin_lower: Point,
    /// The upper of these two points.
    pub kingpin_upper: Point,
    /// The end of the tie rod on the knuckle.
    pub tie_rod: Point,
    /// The drag link's end at the steering gear, at its true place: it is not mirrored.
    pub drag_link_inner: Point,
    /// The way in which the drag link moves the knuckles.
    pub by: KnuckleDrive,
}

/// The way in which a drag link moves the knuckles of a beam. The points are at their true places: they are not
/// mirrored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum KnuckleDrive {
    /// The drag link turns the left knuckle; a bar between the knuckles' arms takes the right one along.
    Toebar {
        /// The end of the drag link on the left knuckle.
        drag_link_outer: Point,
    },
    /// The drag link turns a bellcrank on the beam, from which a tie rod goes to each knuckle.
    Bellcrank {
        /// The point at which the bellcrank turns.
        pivot: Point,
        /// The direction of its axis.
        axis: Point,
        /// The end of the drag link on the bellcrank.
        drag_link_outer: Point,
        /// The end of the left knuckle's tie rod on the bellcrank.
        tie_rod_left: Point,
        /// The end of the right knuckle's tie rod on the bellcrank.
        tie_rod_right: Point,
    },
}

/// The mount of wheels without suspension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidMount {
    /// The left wheel's centre.
    pub spindle: Point,
}

/// A line between chassis and linkage along which a spring, a damper and stops act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strut {
    /// The end on the chassis.
    pub chassis: Point,
    /// The end on `part`.
    pub end: Point,
    /// The part that moves this end.
    pub part: Part,
    /// The spring along the strut, if there is one.
    #[serde(default)]
    pub spring: Option<Spring>,
    /// The damper along the strut, if there is one.
    #[serde(default)]
    pub damper: Option<Damper>,
    /// The stops along the strut, if there are any.
    #[serde(default)]
    pub stops: Option<StrutStops>,
}

/// A moving part of a linkage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The upright, which carries the wheel.
    Upright,
    /// The lower wishbone, the single wishbone or the torsion arm.
    Arm,
    /// The beam of a solid axle.
    Beam,
}

/// A spring: its force over its compression e = free length − length, which holds in tension (e < 0) too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Spring {
    /// The force is preload + stiffness · e.
    Linear {
        /// The stiffness, N/m.
        stiffness: f64,
        /// The length at which e is 0, m.
        free_length: f64,
        /// The force at the free length, N.
        #[serde(default)]
        preload: f64,
    },
    /// The force is stiffness · e + progression · e·|e| (the springs of Chrono's MAN trucks,
    /// chrono_models/vehicle/man).
    Progressive {
        /// The stiffness at the free length, N/m.
        stiffness: f64,
        /// The growth of the stiffness, N/m².
        progression: f64,
        /// The length at which e is 0, m.
        free_length: f64,
    },
    /// The force follows straight lines between points, and goes on beyond the last ones.
    Table {
        /// The length at which e is 0, m.
        free_length: f64,
        /// The points \[compression m, force N\], by increasing compression.
        points: Vec<[f64; 2]>,
    },
}

/// A damper: its force, against the motion, over the rate v at which it is compressed (v > 0) or extended (v < 0).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Damper {
    /// The force is coefficient · v.
    Linear {
        /// The coefficient, N s/m.
        coefficient: f64,
    },
    /// The force is linear, with one coefficient for each direction.
    Bilinear {
        /// The coefficient in compression, N s/m.
        compression: f64,
        /// The coefficient in extension, N s/m.
        rebound: f64,
    },
    /// The force is c·v / (1 + n·|v|) with c and n for each direction (the dampers of Chrono's MAN trucks,
    /// chrono_models/vehicle/man).
    Degressive {
        /// The coefficient c in compression, N s/m.
        compression: f64,
        /// The coefficient n in compression, s/m.
        compression_degression: f64,
        /// The coefficient c in extension, N s/m.
        rebound: f64,
        /// The coefficient n in extension, s/m.
        rebound_degression: f64,
    },
    /// The force follows straight lines between points, and goes on beyond the last ones.
    Table {
        /// The points \[rate of compression m/s, force N\], by increasing rate. Rate and force have the same sign, and
        /// [0, 0] is one of the points.
        points: Vec<[f64; 2]>,
    },
}

/// The stops along a strut. The forces of stiffness and table add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrutStops {
    /// The length below which the strut is pushed apart, m.
    pub shortest: f64,
    /// The length above which the strut is pulled together, m.
    pub longest: f64,
    /// The stiffness of the stops, N/m.
    #[serde(default)]
    pub stiffness: f64,
    /// The points \[depth into the stop m, force N\], with straight lines between them and on beyond the last one.
    #[serde(default)]
    pub table: Vec<[f64; 2]>,
}

/// The stops that act on the wheel beyond these travels. The forces of stiffness and table add up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stops {
    /// The compression at which the upper stop is met, m, > 0.
    pub jounce: f64,
    /// The travel at which the lower stop is met, m, < 0.
    pub rebound: f64,
    /// The stiffness of the stops at the wheel, N/m.
    #[serde(default)]
    pub stiffness: f64,
    /// The points \[depth into the stop m, force N\], with straight lines between them and on beyond the last one.
    #[serde(default)]
    pub table: Vec<[f64; 2]>,
}

/// The coupling of the two wheels of an axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum AntiRoll {
    /// A force acts at each wheel, in proportion to the difference of their travels.
    Travel {
        /// The stiffness, N/m: the force on each wheel over the left travel less the right travel.
        stiffness: f64,
    },
    /// A torsion bar has an arm at each end and a drop link from each arm to the linkage.
    Bar {
        /// The stiffness of the bar, N m/rad.
        stiffness: f64,
        /// The damping of the bar, N m s/rad.
        #[serde(default)]
        damping: f64,
        /// A point of the bar's axis, which points to the left.
        pivot: Point,
        /// The upper end of the drop link, on the bar's arm.
        arm_end: Point,
        /// The lower end of the drop link, on `part`.
        link_end: Point,
        /// The part that moves the drop link's lower end.
        part: Part,
    },
}

/// The driver's steering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steering {
    /// The maximum rate of the command, 1/s.
    pub rate: f64,
    /// The maximum force of each rack, N. Under a greater load the rack stalls or is driven back. The force is unlimited
    /// if the field is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<f64>,
    /// The maximum torque of each pitman arm or rotary arm about its pivot, N m. Under a greater load the arm stalls or is
    /// driven back. The torque is unlimited if the field is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
    /// The parts that the command moves.
    #[serde(default)]
    pub by: SteeredBy,
}

/// The parts that a steering command moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SteeredBy {
    /// The command moves the steering gears of the axles that have one.
    #[default]
    Wheels,
    /// The command goes to the driveline, which drives the two sides at different speeds (tracked vehicles and skid
    /// steering). No axle has a steering gear.
    Differential,
}

/// The steering gear of an axle, which moves the inner joints of its tie rods or of its drag link. The points are at
/// their true places: they are not mirrored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum SteeringGear {
    /// A rack moves the joints sideways.
    RackAndPinion {
        /// The travel to the right at command +1, m.
        travel: f64,
    },
    /// An arm and an idler arm carry the link with the joints: a four-bar linkage.
    PitmanArm {
        /// The point about which the arm turns.
        pivot: Point,
        /// The joint of arm and link.
        arm_end: Point,
        /// The point about which the idler arm turns.
        idler_pivot: Point,
        /// The joint of idler arm and link.
        idler_end: Point,
        /// The direction of the axes of all four joints.
        #[serde(default = "up")]
        axis: Point,
        /// The angle at command +1, rad, clockwise seen against the axis (from above if it points up).
        angle: f64,
    },
    /// The joints sit on an arm.
    RotaryArm {
        /// The point about which the arm turns.
        pivot: Point,
        /// The direction of its axis.
        #[serde(default = "up")]
        axis: Point,
        /// The largest angle, rad, clockwise seen against the axis (from above if it points up) at positive commands.
        angle: f64,
        /// The fraction of that angle over the command, from command −1 to +1 and rising: the characteristic of a servo,
        /// which may reach less far to one side. In proportion if absent.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        response: Vec<[f64; 2]>,
    },
}

impl SteeringGear {
    /// The position of a gear at a command in \[−1, 1\], as a fraction of its travel or angle.
    #[must_use]
    pub fn position(&self, command: f64) -> f64 {
        match self {
            Self::RotaryArm { response, .. } if !response.is_empty() => interpolate(response, command).0,
            _ => command,
        }
    }

    /// The largest travel (m) or angle (rad) of the gear: at position 1 or −1.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let (Self::RackAndPinion { travel: reach }
        | Self::PitmanArm { angle: reach, .. }
        | Self::RotaryArm { angle: reach, .. }) = self;
        reach.abs()
    }

    /// The derivative of `position` with respect to the command; at a corner of a response that of the segment to its
    /// right, and at command 1 that of the last segment.
    #[must_use]
    pub fn slope(&self, command: f64) -> f64 {
        match self {
            Self::RotaryArm { response, .. } if !response.is_empty() => slope_within(response, command),
            _ => 1.0,
        }
    }
}

fn up() -> Point {
    [0.0, 0.0, 1.0]
}

impl Linkage {
    /// The centre of the left wheel at design height, m.
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

    /// The beam; `None` if the wheels don't share one.
    #[must_use]
    pub fn beam(&self) -> Option<Beam> {
        match self {
            Self::SolidAxle(l) => Some(l.beam),
            Self::LeafAxle(l) => Some(l.beam),
            Self::PivotAxle(l) => Some(l.beam),
            _ => None,
        }
    }

    /// The steering knuckles; `None` if the wheels share no beam or aren't steered.
    #[must_use]
    pub fn knuckles(&self) -> Option<&Knuckles> {
        match self {
            Self::SolidAxle(l) => l.knuckles.as_ref(),
            Self::LeafAxle(l) => l.knuckles.as_ref(),
            Self::PivotAxle(l) => l.knuckles.as_ref(),
            _ => None,
        }
    }

    /// The inner joint of the left tie rod, m; `None` for linkages in which the wheels have no tie rods of their own.
    #[must_use]
    pub fn tie_rod_inner(&self) -> Option<Point> {
        match self {
            Self::DoubleWishbone(l) => Some(l.tie_rod_inner),
            Self::SingleWishbone(l) => Some(l.tie_rod_inner),
            Self::Multilink(l) => Some(l.tie_rod_inner),
            _ => None,
        }
    }

    /// The torsion bar of an arm; `None` for arms without one and for other linkages.
    #[must_use]
    pub fn torsion(&self) -> Option<Torsion> {
        match self {
            Self::TorsionArm(l) => l.torsion,
            _ => None,
        }
    }
}
