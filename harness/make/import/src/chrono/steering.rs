//! Steering gears.

use super::json::Node;
use super::set::template;
use crate::place::{add, mirrored, quaternion, sub, turn};
use crate::{ImportError, Notes};
use vb_math::angle::radians;
use vb_vehicle::Point;
use vb_vehicle::suspension::SteeringGear;

/// A steering subsystem at its place.
#[derive(Clone, Debug)]
pub(crate) struct Gear {
    gear: SteeringGear,
    /// Its masses in the chassis frame, which move with the chassis.
    pub(crate) masses: Vec<(f64, Point)>,
}

impl Gear {
    /// The gear for an axle at this place; the mirror image for an axle whose drag link is mirrored.
    pub(crate) fn at(&self, axle: Point, mirror: bool) -> SteeringGear {
        let mut gear = self.gear.clone();
        let place = |p: &mut Point| {
            *p = sub(*p, axle);
            if mirror {
                *p = mirrored(*p);
            }
        };
        match &mut gear {
            SteeringGear::RackAndPinion { .. } => {}
            SteeringGear::PitmanArm { pivot, arm_end, idler_pivot, idler_end, .. } => {
                [pivot, arm_end, idler_pivot, idler_end].into_iter().for_each(place);
            }
            SteeringGear::RotaryArm { pivot, .. } => place(pivot),
        }
        gear
    }
}

/// Reads a steering subsystem; `entry` is its place in the vehicle's file.
pub(crate) fn read(root: &Node, entry: &Node, notes: &mut Notes) -> Result<Gear, ImportError> {
    let location = entry.pt("Location")?;
    let orientation = entry.get("Orientation").map_or(Ok([1.0, 0.0, 0.0, 0.0]), |n| n.quaternion())?;
    let frame = quaternion(orientation);
    let at = |p: Point| add(location, turn(&frame, p));
    root.get("Vehicle-Frame Inertia").inspect(Node::used);
    let mut masses = Vec::new();
    let mut weigh = |key: &str, arm: Option<Point>| -> Result<(), ImportError> {
        let Some(node) = root.get(key) else { return Ok(()) };
        let com = match node.get("COM") {
            Some(n) => n.point().or_else(|_| n.number().map(|x| [0.0, x, 0.0])).ok(),
            None => None,
        };
        masses.push((node.num_or("Mass", 0.0)?, at(com.or(arm).unwrap_or([0.0; 3]))));
        Ok(())
    };
    let gear = match template(root.doc())?.as_str() {
        "RackPinion" => {
            weigh("Steering Link", None)?;
            let pinion = root.need("Pinion")?;
            let travel = pinion.num("Radius")? * most(&pinion)?;
            SteeringGear::RackAndPinion { travel }
        }
        "PitmanArm" => {
            weigh("Steering Link", None)?;
            weigh("Pitman Arm", None)?;
            let (arm, universal, idler) = (
                root.need("Revolute Joint")?,
                root.need("Universal Joint")?,
                root.need("Revolute-Spherical Joint")?,
            );
            for (node, key) in
                [(&universal, "Direction Arm"), (&universal, "Direction Link"), (&idler, "Direction")]
            {
                node.get(key).inspect(Node::used);
            }
            // Where the tie rods join the link stands in the suspension's file; Chrono draws these.
            if let Some(n) = root.get("Tierod Locations") {
                n.used();
                notes.chosen(format!(
                    "{}: the ends of the tie rods are those of the suspension's file, as in Chrono",
                    n.at()
                ));
            }
            SteeringGear::PitmanArm {
                pivot: at(arm.pt("Location")?),
                arm_end: at(universal.pt("Location")?),
                idler_pivot: at(idler.pt("Location Chassis")?),
                idler_end: at(idler.pt("Location Link")?),
                axis: turn(&frame, arm.pt("Direction")?),
                angle: most(&arm)?,
            }
        }
        "RotaryArm" => {
            let arm = root.need("Pitman Arm")?;
            let pivot = arm.pt("Point of Rotation")?;
            weigh("Pitman Arm", Some(pivot))?;
            // The drag link's end stands in the suspension's file, too.
            arm.get("Point to Draglink").inspect(Node::used);
            SteeringGear::RotaryArm {
                pivot: at(pivot),
                axis: turn(&frame, arm.pt("Axis of Rotation")?),
                angle: most(&arm)?,
                response: Vec::new(),
            }
        }
        other => {
            return root.fail(format!(
                "no counterpart of the template {other:?}; use RackPinion, PitmanArm or RotaryArm"
            ));
        }
    };
    Ok(Gear { gear, masses })
}

/// The greatest angle, in degrees under its name of today and those of Chrono 6 and before.
fn most(node: &Node) -> Result<f64, ImportError> {
    let old = node.any(&["Maximum Angle", "Maximum Angle Degrees"]);
    old.map_or_else(|| node.num("Maximum Angle (deg)"), |n| n.number()).map(radians)
}

/// Changes the travel of a gear by a factor; -1 turns it the other way round.
pub(crate) fn scale(gear: &mut SteeringGear, by: f64) {
    match gear {
        SteeringGear::RackAndPinion { travel: x }
        | SteeringGear::PitmanArm { angle: x, .. }
        | SteeringGear::RotaryArm { angle: x, .. } => *x *= by,
    }
}
